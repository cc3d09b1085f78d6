"""Piecewise polynomials and what plans are made of: splines and jets of quintics, profiles of one
axis, samples of curves, the replay between jumps.

A motion shows of these only its samples.
"""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

import freebody as fb
from freebody.cli.plan import PlannerName
from freebody.motion.optimal.geometric_path import sampled
from freebody.motion.piecewise import PiecewisePolynomial, hermite, interpolated, side_by_side
from freebody.motion.planners import PLANNERS as PLANNERS_BY_NAME
from freebody.motion.planning.point_to_point import PROFILES
from freebody.report.replay import replayed
from freebody.report.studied_motion import with_peaks
from freebody.targets import in_turn
from freebody.targets import in_turn as recurrences

RNG = np.random.default_rng(7)
T = np.cumsum(RNG.uniform(0.1, 1.0, 9))
X = RNG.normal(size=(9, 3))
GRID = np.linspace(T[0], T[-1], 20001)

WAY = [[0.0, 0.0], [1.0, -0.5], [0.4, 1.0], [-0.8, 0.3]]


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


# ---------------------------------------------------------------- one axis
def test_the_trapezoid_and_its_triangle_are_the_closed_forms():
    move = PROFILES["trapezoid"].quickest
    assert move(3.0, 1.0, 2.0, np.inf).breaks == pytest.approx([0.0, 0.5, 3.0, 3.5])
    assert move(2.0, 9.0, 2.0, np.inf).breaks == pytest.approx([0.0, 1.0, 2.0])
    assert move(2.0, np.inf, 2.0, np.inf)(1.0) == pytest.approx(1.0)


def test_the_s_curve_has_the_phases_of_the_book():
    """Biagiotti and Melchiorri 2008, examples 3.9 and 3.11: way 10, limits 5, 10, 30 and so on."""
    move = PROFILES["s-curve"].quickest
    full = move(10.0, 5.0, 10.0, 30.0)
    assert np.diff(full.breaks) == pytest.approx(np.array([2, 1, 2, 7, 2, 1, 2]) / 6.0)
    short = move(10.0, 10.0, 10.0, 1e6)  # nearly a triangle of speed
    assert short.breaks[-1] == pytest.approx(2.0, rel=1e-4)
    assert move(2.0, np.inf, np.inf, 1.0).breaks[-1] == pytest.approx(4.0)


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_reach_a_limit_and_break_none(name: str):
    rng = np.random.default_rng(3)
    for _ in range(40):
        way, *limits = (10.0 ** rng.uniform(-2, 2, 4)).tolist()
        curve = PROFILES[name].quickest(way, *limits)
        assert curve(curve.breaks[[0, -1]]) == pytest.approx(np.array([[0.0], [way]]), rel=1e-9)
        assert curve.derivative()(curve.breaks[-1]) == pytest.approx(0.0, abs=1e-8 * way)
        counted = limits[:2] if name == "trapezoid" else limits
        used = [curve.derivative(k + 1).extremes.size[0] / most for k, most in enumerate(counted)]
        assert max(used) == pytest.approx(1.0, rel=1e-9)


def test_with_dry_friction_the_replay_goes_from_jump_to_jump_too():
    arm = fb.load("2R").with_drive("joint1", coulomb=2.0).with_drive("joint2", coulomb=2.0)
    motion = fb.time_optimal(arm, [[0, 0], [1, -0.5], [0.4, 1]], torque=[150, 40], points=21)
    replay = replayed(arm, motion)
    assert replay.method == "Radau"  # begins again at once
    assert np.nanmax(replay.misses) < 1e-8
    assert replay.drift_time[-1] == motion.t[-1]
    assert replay.drift.max() < 1e-6


def test_polynomials_that_meet_without_a_jump_are_replayed_each_in_its_place():
    arm = fb.load("2R")
    way = [[0, 0], [0.4, 0.5], [1, 0.7], [0.8, -0.3]]
    motion = fb.spline(arm, way, degree=3, acceleration=3).then(
        fb.trapezoid(arm, way[::-1], acceleration=3)
    )
    assert len(motion.jumps) < len(motion.knots) - 2
    replay = replayed(arm, motion)
    assert np.nanmax(replay.misses) < 1e-7


@pytest.mark.parametrize("off", [-1e-13, 1e-13])
def test_a_break_beside_a_sample_is_that_sample(off: float):
    t, still = np.array([0.0, 0.25, 0.5, 1.0]), np.zeros((4, 2))
    pieces = PiecewisePolynomial(np.array([0.0, 0.5 + off, 0.8, 1.0]), np.zeros((2, 3, 2)))
    layout = fb.default_motion(fb.load("2R")).layout
    motion = fb.Motion(t, still, still, still, "", layout, pieces=pieces)
    assert motion.knots.tolist() == [0.0, 0.25, 0.5, 0.8, 1.0]


def test_the_command_knows_all_planners():
    assert set(get_args(PlannerName)) == set(PLANNERS_BY_NAME)
    assert next(iter(PLANNERS_BY_NAME)) == "spline"


def test_noise_between_samples_is_no_peak():
    arm, t = fb.load("2R"), np.linspace(0.0, 1.0, 21)
    q = np.stack([np.sin(t), 0.5 * t**2], axis=-1)
    rates, seconds = np.stack([np.cos(t), t], axis=-1), np.stack([-np.sin(t), 1.0 + 0 * t], axis=-1)
    noisy = q + 1e-3 * np.random.default_rng(1).normal(size=q.shape)
    motion = fb.Motion.of(arm, t, noisy, rates, seconds)
    assert np.abs(motion.at(t[:-1] + 0.01)[2]).max() > 3.0  # between the samples
    found = with_peaks(arm, motion)
    peaks, own = (
        np.abs(fb.inverse_dynamics(arm, x.q, x.qd, x.qdd)).max(axis=0) for x in (found, motion)
    )
    np.testing.assert_allclose(peaks, own, rtol=0.01)


def test_curves_of_any_degree_are_sampled_as_scipy_does():
    """With a derivative for each power, at breaks those of the piece that begins there."""
    rng = np.random.default_rng(3)
    curves = [
        PiecewisePolynomial(np.array([0.0, 0.3, 1.0]), rng.normal(size=(degree + 1, 2, 2)))
        for degree in (1, 4, 2)
    ]
    s = np.stack([np.linspace(0.0, 1.0, 11), *rng.uniform(0.0, 1.0, (2, 11))], axis=1)
    found = sampled(curves, s).orders
    assert len(found) == 5
    for k, curve in enumerate(curves):
        of_scipy = PPoly(np.array(curve.coefficients), np.array(curve.breaks))
        for order, x in enumerate(found):
            expected = of_scipy.derivative(order)
            np.testing.assert_allclose(x[:, k], expected(s[:, k]), rtol=1e-13, atol=1e-13)
            own = curve.derivative(order) if order else curve
            np.testing.assert_allclose(own(s[:, k]), expected(s[:, k]), rtol=1e-15, atol=1e-15)
        np.testing.assert_allclose(curve.at_breaks, of_scipy(curve.breaks), rtol=1e-13)
    alone = sampled(curves[2:], s[:, 2:])
    assert len(alone.orders) == 3
    for x, y in zip(alone.orders, found, strict=False):
        np.testing.assert_allclose(x[:, 0], y[:, 2], rtol=1e-15, atol=1e-15)


def test_without_compiled_code_the_same_comes_out(monkeypatch: pytest.MonkeyPatch):
    names = [f"joint{k}.limits.{name}" for name in ("velocity", "effort") for k in (1, 2)]
    arm = fb.load("2R").bind(dict(zip(names, (2.0, 2.0, 150.0, 40.0), strict=True)))
    quick = fb.time_optimal(arm, WAY, points=41)

    def one_by_one(kernel, arguments, steps, samples):
        in_turn._one_by_one(kernel, arguments, steps)

    monkeypatch.setattr(recurrences, "_FEW", 0)
    monkeypatch.setattr(recurrences, "in_turn", one_by_one)
    assert fb.time_optimal(arm, WAY, points=41) == quick
