"""Piecewise polynomials: against scipy's splines, and extremes against fine grids."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline

from freebody.motion.piecewise import PiecewisePolynomial, hermite, interpolated, side_by_side

RNG = np.random.default_rng(7)
T = np.cumsum(RNG.uniform(0.1, 1.0, 9))
X = RNG.normal(size=(9, 3))
GRID = np.linspace(T[0], T[-1], 20001)


def test_splines_are_those_of_scipy():
    theirs = CubicSpline(T, X, bc_type="clamped")
    mine = interpolated(T, X, 3, "rest")
    np.testing.assert_allclose(mine(GRID), theirs(GRID), atol=1e-12)
    natural = interpolated(T, X, 3, "natural")
    np.testing.assert_allclose(
        natural(GRID), CubicSpline(T, X, bc_type="natural")(GRID), atol=1e-12
    )
    still = [(1, np.zeros(3)), (2, np.zeros(3))]
    theirs = make_interp_spline(T, X, k=5, bc_type=(still, still))
    mine = interpolated(T, X, 5, "rest")
    for order in range(5):
        expected = theirs.derivative(order)(GRID) if order else theirs(GRID)
        found = mine.derivative(order)(GRID) if order else mine(GRID)
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("degree", [3, 5])
def test_a_periodic_spline_goes_on_as_it_began(degree):
    x = np.vstack([X, X[:1]])
    curve = interpolated(np.append(T, T[-1] + 0.5), x, degree, "periodic")
    for order in range(1, degree):
        first, last = curve.derivative(order)(curve.breaks[[0, -1]])
        np.testing.assert_allclose(first, last, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("degree", [3, 5])
def test_extremes_lie_between_samples(degree):
    curve = interpolated(T, X, degree)
    for order in range(3):
        function = curve.derivative(order) if order else curve
        found, seen = function.extremes, function(GRID)
        slack = 1e-3 * np.ptp(seen, axis=0)
        for mine, at, grid in (
            (found.low, found.low_at, seen.min(axis=0)),
            (-found.high, found.high_at, -seen.max(axis=0)),
        ):
            assert (mine <= grid + 1e-12).all()
            assert (mine >= grid - slack).all()
            np.testing.assert_allclose(np.abs(np.diagonal(function(at))), np.abs(mine), atol=1e-9)
        np.testing.assert_allclose(found.size, np.abs(seen).max(axis=0), atol=float(slack.max()))


def test_a_jump_counts_on_both_sides():
    curve = PiecewisePolynomial(np.array([0.0, 1.0, 2.0]), np.array([[[3.0], [-5.0]]]))
    assert curve.extremes.low == -5.0
    assert curve.extremes.high == 3.0
    assert curve.extremes.size_at == 1.0
    assert curve(1.0) == -5.0


def test_curves_are_run_faster_one_after_the_other_and_side_by_side():
    curve, other = interpolated(T, X, 5), interpolated(T - T[0], X[::-1], 3)
    np.testing.assert_allclose(
        curve.scaled(2.0)(T[0] + (GRID - T[0]) / 2.0), curve(GRID), atol=1e-11
    )
    both = curve.then(other)
    np.testing.assert_allclose(both(GRID[:-1]), curve(GRID[:-1]), atol=1e-12)
    later = np.linspace(0.0, T[-1] - T[0], 99)
    np.testing.assert_allclose(both(T[-1] + later), other(later), atol=1e-11)
    own = np.linspace(T[0], T[-1], 5)
    pair = side_by_side([curve, interpolated(own, X[:5], 3)])
    np.testing.assert_allclose(pair(GRID)[:, :3], curve(GRID), atol=1e-10)
    np.testing.assert_allclose(pair(GRID)[:, 3:], interpolated(own, X[:5], 3)(GRID), atol=1e-10)
    assert len(pair.breaks) == len(T) + 3


def test_hermite_reproduces_quintics():
    t = np.array([0.0, 0.4, 1.5])
    p = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0, -1.0, 0.7])
    x, xd, xdd = (d(t)[:, None] for d in (p, p.deriv(), p.deriv(2)))
    s = np.linspace(0, 1.5, 50)
    np.testing.assert_allclose(hermite(t, x, xd, xdd)(s)[:, 0], p(s), atol=1e-12)
