"""Exact trigonometric polynomials: the laws of a ring, of sines and cosines, and of derivatives, on
seeded elements."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, UnknownNameError
from freebody.scalars.rational import exactly, rational_axis, rational_rotation, rational_sin_cos
from freebody.scalars.trig import Trig, TrigRing
from support.generate import random_rotation

RING = TrigRing(["x", "y", "z"], ["d", "x_d", "y_d", "z_d", "d_d", "sgn_x_d", "m", "l"])
VALUES = {name: 0.3 + 0.37 * k for k, name in enumerate(RING.names)}


def element(seed: int, terms: int = 5) -> Trig:
    """A random polynomial, sines squared on the way."""
    rng = np.random.default_rng(seed)
    total = Trig(RING, RING.constant(0), 0)
    atoms = (
        [RING.sin(x) for x in "xyz"]
        + [RING.cos(x) for x in "xyz"]
        + [RING[n] for n in ("d", "m", "l", "x")]
    )
    for _ in range(terms):
        term = RING["m"] * Fraction(int(rng.integers(-9, 10)), int(rng.integers(1, 7)))
        for k in rng.integers(len(atoms), size=int(rng.integers(0, 5))):
            term = term * atoms[k]
        total = total + term
    return total


@pytest.mark.parametrize("seed", range(20))
def test_ring_laws(seed: int) -> None:
    a, b, c = (element(3 * seed + k) for k in range(3))
    assert a + b == b + a
    assert a * b == b * a
    assert (a + b) + c == a + (b + c)
    assert (a * b) * c == a * (b * c)
    assert a * (b + c) == a * b + a * c
    assert a - b == -(b - a)
    assert (a - a).is_zero
    assert a * 1 == a
    assert a + 0 == a
    assert (a + b) ** 3 == a**3 + 3 * a**2 * b + 3 * a * b**2 + b**3
    assert hash(a * b + c) == hash(c + b * a)


@pytest.mark.parametrize("seed", range(20))
def test_normal_form_has_no_squared_sine(seed: int) -> None:
    a = element(seed) * element(seed + 1) * element(seed + 2)
    assert all(
        e < 2 for powers, _ in a.terms() for name, e in powers.items() if name.startswith("sin_")
    )
    assert RING.polynomial(a.terms()) == a


@pytest.mark.parametrize("seed", range(20))
def test_values_follow(seed: int) -> None:
    a, b = element(seed), element(seed + 100)
    x, y = a.evaluate(VALUES), b.evaluate(VALUES)
    scale = 1 + abs(x) + abs(y)
    assert (a + b).evaluate(VALUES) == pytest.approx(x + y, abs=1e-12 * scale)
    assert (a * b).evaluate(VALUES) == pytest.approx(x * y, abs=1e-11 * scale**2)
    assert a.evaluate({k: np.full((2, 3), v) for k, v in VALUES.items()}).shape in {(2, 3), ()}


@pytest.mark.parametrize("seed", range(10))
def test_derivatives(seed: int) -> None:
    a, b = element(seed), element(seed + 50)
    for name in ("x", "d", "m"):
        assert (a * b).derivative(name) == a.derivative(name) * b + a * b.derivative(name)
        assert a.derivative(name).derivative("y") == a.derivative("y").derivative(name)
        h = 1e-6
        up, down = ({**VALUES, name: VALUES[name] + s} for s in (h, -h))
        slope = (a.evaluate(up) - a.evaluate(down)) / (2 * h)
        assert a.derivative(name).evaluate(VALUES) == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_time_derivative() -> None:
    rates = {x: RING[f"{x}_d"] for x in ("x", "y")}
    moving = RING["x"] + 2 * RING["y"]
    assert moving.sin().along(rates) == moving.cos() * (RING["x_d"] + 2 * RING["y_d"])


def test_sines_of_sums() -> None:
    x, y = RING["x"], RING["y"]
    assert x.sin() * x.sin() + x.cos() * x.cos() == 1
    assert (x + y).cos() == x.cos() * y.cos() - x.sin() * y.sin()
    assert (2 * x - y).sin() ** 2 == 1 - (2 * x - y).cos() ** 2
    assert (-x).sin() == -x.sin()
    assert (x + math.pi / 2).sin() == x.cos()
    assert (3 * x).cos() == 4 * x.cos() ** 3 - 3 * x.cos()
    tilted = (x + 0.3).sin() ** 2 + (x + 0.3).cos() ** 2
    assert tilted == 1
    assert (x + 0.3).sin().evaluate(VALUES) == pytest.approx(math.sin(VALUES["x"] + 0.3), abs=1e-15)


def test_sines_that_are_no_polynomials() -> None:
    for argument in (RING["x"] * 0.5, RING["d"] * 1, RING["x"] * RING["y"]):
        with pytest.raises(FreebodyError, match="sum of angles with whole factors"):
            argument.sin()


def test_signs() -> None:
    assert RING["x_d"].sign() == RING["sgn_x_d"]
    assert (RING["x_d"] * -2).sign() == -RING["sgn_x_d"]
    with pytest.raises(FreebodyError, match="friction acts on single rates"):
        (RING["x_d"] + RING["y_d"]).sign()


@pytest.mark.parametrize("seed", range(10))
def test_division(seed: int) -> None:
    a, b = element(seed), element(seed + 20, terms=2)
    if (
        not b.is_zero
        and b.derivative("x").is_zero
        and b.derivative("y").is_zero
        and b.derivative("z").is_zero
    ):
        assert a * b / b == a
    assert (a * 6) / 3 == a * 2
    assert a / 0.5 == a * 2
    with pytest.raises(FreebodyError, match="no such closed form"):
        RING["m"] / (RING["l"] + 1)


def test_factors() -> None:
    d, l, m = (RING[n] for n in ("d", "l", "m"))
    found = (m * (d + l) ** 2 * (d - l) * 4).factors()
    assert sorted(exponent for _, exponent in found) == [1, 1, 2]
    product = Trig(RING, RING.constant(1), 0)
    for factor, exponent in found:
        product = product * factor**exponent
    assert (
        m * (d + l) ** 2 * (d - l)
    ) / product.leading_coefficient == product / product.leading_coefficient**2


def test_equality_and_hash_with_numbers() -> None:
    one = RING["m"] / RING["m"]
    assert one == 1
    assert hash(one) == hash(1)
    assert one == Fraction(1)
    assert one != RING["m"]
    assert len({RING["m"] + RING["l"], RING["l"] + RING["m"], RING["l"]}) == 2
    assert one.leading_coefficient == 1
    assert (one - 1).leading_coefficient == 0


def test_floats_are_read_by_their_shortest_decimal() -> None:
    assert exactly(0.1) == Fraction(1, 10)
    assert exactly(1e-3) == Fraction(1, 1000)
    assert exactly(Fraction(1, 3)) == Fraction(1, 3)
    assert RING["m"] * 0.1 * 10 == RING["m"]
    assert (RING["m"] * 0.3).leading_coefficient == Fraction(3, 10)


def test_names() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'x_d'"):
        RING["x_dd"]
    with pytest.raises(FreebodyError, match="two quantities"):
        TrigRing(["a"], ["a"])
    with pytest.raises(UnknownNameError, match="no value 'l'"):
        RING["l"].evaluate({})


@pytest.mark.parametrize("seed", range(20))
def test_rotations_stay_orthogonal_exactly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    R = random_rotation(rng)
    exact = rational_rotation(R)
    for i in range(3):
        for j in range(3):
            assert sum(exact[i][k] * exact[j][k] for k in range(3)) == (i == j)
    assert np.abs(np.array(exact, dtype=float) - R).max() < 1e-15
    axis = R[0]
    unit = rational_axis(axis)
    assert sum(x * x for x in unit) == 1
    assert np.abs(np.array(unit, dtype=float) - axis).max() < 1e-15
    angle = float(rng.uniform(-10, 10))
    s, c = rational_sin_cos(angle)
    assert s * s + c * c == 1
    assert float(s) == pytest.approx(math.sin(angle), abs=1e-15)
    assert float(c) == pytest.approx(math.cos(angle), abs=1e-15)


@pytest.mark.parametrize("quarter", range(-4, 5))
def test_right_angles_are_exact(quarter: int) -> None:
    s, c = rational_sin_cos(quarter * math.pi / 2)
    assert (s, c) == (
        round(math.sin(quarter * math.pi / 2)),
        round(math.cos(quarter * math.pi / 2)),
    )


def test_a_closed_form_too_large_for_memory_is_refused_and_does_not_end_the_process() -> None:
    """FLINT aborts where memory ends: fourteen letters were enough."""
    with pytest.raises(FreebodyError, match="too large to be worked out"):
        fb.derive(fb.planar("R" * 14), "newton-euler")
    many = RING.polynomial(
        [({"m": i, "l": j}, Fraction(1)) for i in range(130) for j in range(130)]
    )
    with pytest.raises(FreebodyError, match="too large to be worked out"):
        many * many
