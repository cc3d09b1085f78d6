"""Scalars of algorithms: exact trigonometric polynomials (the laws of a ring, of sines and cosines,
and of derivatives, on seeded elements), and nodes of a graph (folding, interning, refusals).
"""

from __future__ import annotations

import math
from fractions import Fraction
from operator import neg

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, UnknownNameError
from freebody.expressions.polynomials.factors import factored
from freebody.math import cos, sign, sin, sqrt
from freebody.scalars.expr import Expr, Graph
from freebody.scalars.nodes import GraphError
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


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def xyz(graph):
    return graph.input("x"), graph.input("y"), graph.input("z")


def value(e: Expr) -> float:
    return e.graph.constant_of[e.index]


def test_equal_rows_are_one_node(graph, xyz):
    x, y, _ = xyz
    assert x + y == y + x
    assert x * y == y * x
    assert sin(x) == sin(x)
    assert x * 2.0 == 2 * x
    before = len(graph)
    (x + y) * (y + x)
    assert len(graph) == before + 1


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (lambda x, y: 0 + x, lambda x, y: x),
        (lambda x, y: x - 0.0, lambda x, y: x),
        (lambda x, y: 1 * x, lambda x, y: x),
        (lambda x, y: -1 * x, lambda x, y: -x),
        (lambda x, y: x / 1, lambda x, y: x),
        (lambda x, y: x / -1, lambda x, y: -x),
        (lambda x, y: x + (-y), lambda x, y: x - y),
        (lambda x, y: (-x) + y, lambda x, y: y - x),
        (lambda x, y: x - (-y), lambda x, y: x + y),
        (lambda x, y: (-x) - y, lambda x, y: -(x + y)),
        (lambda x, y: (-x) + (-y), lambda x, y: -(x + y)),
        (lambda x, y: y - x, lambda x, y: -(x - y)),
        (lambda x, y: neg(neg(x)), lambda x, y: x),
        (lambda x, y: 0 - x, lambda x, y: -x),
        (lambda x, y: (-x) * y, lambda x, y: -(x * y)),
        (lambda x, y: (-x) * (-y), lambda x, y: x * y),
        (lambda x, y: (-x) / y, lambda x, y: -(x / y)),
        (lambda x, y: x / (-y), lambda x, y: -(x / y)),
        (lambda x, y: -3.0 * x, lambda x, y: -(3.0 * x)),
        (lambda x, y: -3.0 / x, lambda x, y: -(3.0 / x)),
        (lambda x, y: x / -3.0, lambda x, y: -(x / 3.0)),
        (lambda x, y: (y - x) * 2.0, lambda x, y: -((x - y) * 2.0)),
        (lambda x, y: 2.0 * (3.0 * x), lambda x, y: 6.0 * x),
        (lambda x, y: x / 4.0, lambda x, y: 0.25 * x),
        (lambda x, y: x - 2.0, lambda x, y: x + (-2.0)),
        (lambda x, y: sin(-x), lambda x, y: -sin(x)),
        (lambda x, y: cos(-x), lambda x, y: cos(x)),
        (lambda x, y: sign(-x), lambda x, y: -sign(x)),
        (lambda x, y: x**2, lambda x, y: x * x),
        (lambda x, y: x**5, lambda x, y: x * ((x * x) * (x * x))),
        (lambda x, y: x**-2, lambda x, y: 1.0 / (x * x)),
        (lambda x, y: +x, lambda x, y: x),
    ],
)
def test_two_ways_to_write_one_node(xyz, left, right):
    x, y, _ = xyz
    assert left(x, y) == right(x, y)


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda x: 0 * x, 0.0),
        (lambda x: x - x, 0.0),
        (lambda x: 0.0 / x, 0.0),
        (lambda x: x**0, 1.0),
        (lambda x: x + 2.0 - (x + 2.0), 0.0),
        (lambda x: sin(x.graph.constant(0.5)), math.sin(0.5)),
        (lambda x: cos(x.graph.constant(0.5)), math.cos(0.5)),
        (lambda x: sqrt(x.graph.constant(2.0)), math.sqrt(2.0)),
        (lambda x: sign(x.graph.constant(-2.0)), -1.0),
        (lambda x: x.graph.constant(3.0) / 7, 3.0 / 7.0),
        (lambda x: x.graph.constant(3.0) * 7 - 1, 20.0),
    ],
)
def test_constants_are_folded(xyz, function, expected):
    assert value(function(xyz[0])) == expected


def test_negative_zero_is_zero(graph):
    zero = graph.constant(-0.0)
    assert zero == graph.constant(0.0)
    assert math.copysign(1.0, value(-zero)) == 1.0


def test_a_quotient_by_a_constant_stays_unless_exact(graph, xyz):
    quotient = xyz[0] / 3.0
    assert graph.op[quotient.index] == "div"


def test_products_of_constants_that_overflow_stay(graph, xyz):
    product = 1e200 * (1e200 * xyz[0])
    assert graph.op[product.index] == "mul"
    assert value(Expr(graph, graph.a[product.index])) == 1e200


@pytest.mark.parametrize("number", [2, 2.0, np.float64(2.0), np.float32(2.0), np.int64(2), True])
def test_numbers_of_any_kind_on_either_side(xyz, number):
    x = xyz[0]
    results = (
        number * x,
        x * number,
        number + x,
        x + number,
        number - x,
        x - number,
        number / x,
        x / number,
    )
    assert all(type(e) is Expr for e in results)
    assert number * x == float(number) * x


def test_arrays_and_text_are_no_operands(xyz):
    for other in (np.ones(3), "1", [1.0], 1j):
        with pytest.raises(TypeError):
            xyz[0] + other
        with pytest.raises(TypeError):
            other * xyz[0]


def test_two_graphs_do_not_mix(xyz):
    with pytest.raises(GraphError, match="two traces were mixed: a graph belongs to one trace"):
        xyz[0] + Graph().input("x")


@pytest.mark.parametrize(
    "branch",
    [
        bool,
        float,
        lambda x: x > 0,
        lambda x: x <= 1.0,
        lambda x: x == 0.0,
        lambda x: 1 if x else 0,
        lambda x: max(x, -x),
    ],
)
def test_branching_on_values_is_refused(xyz, branch):
    with pytest.raises(GraphError, match=r"Branch on structure .*, never on values"):
        branch(xyz[0])


@pytest.mark.parametrize("exponent", [0.5, 65, "2", -100])
def test_exponents_are_small_whole_numbers(xyz, exponent):
    with pytest.raises(GraphError, match="whole number from -64 to 64"):
        xyz[0] ** exponent


def test_what_has_no_finite_value_is_refused(graph, xyz):
    with pytest.raises(GraphError, match="constants must be finite"):
        xyz[0] * math.inf
    with pytest.raises(GraphError, match="constants must be finite"):
        graph.constant(math.nan)
    with pytest.raises(GraphError, match="division by the constant 0"):
        xyz[0] / 0.0
    with pytest.raises(GraphError, match=r"sqrt\(-1\.0\) has no finite value"):
        sqrt(graph.constant(-1.0))


def test_it_says_what_it_is(xyz):
    x, y, _ = xyz
    assert repr(x) == "Expr(%2 = x)"
    assert repr(x * y) == "Expr(%5 = mul(%2, %3))"
    assert len({x, y, x + y, y + x}) == 3


def test_folding_keeps_values():
    rng = np.random.default_rng(7)
    for _ in range(300):
        graph = Graph()
        numbers = rng.normal(size=3)
        pool = [(graph.input(f"x{i}"), float(v)) for i, v in enumerate(numbers)]
        pool += [(float(c), float(c)) for c in (0.0, 1.0, -1.0, 2.0, -0.3)]
        for _ in range(25):
            (a, va), (b, vb) = (pool[i] for i in rng.integers(len(pool), size=2))
            op = rng.integers(7)
            if op == 0:
                pool.append((a + b, va + vb))
            elif op == 1:
                pool.append((a - b, va - vb))
            elif op == 2:
                pool.append((a * b, va * vb))
            elif op == 3 and abs(vb) > 0.1:
                pool.append((a / b, va / vb))
            elif op == 4:
                pool.append((-a, -va))
            elif op == 5:
                pool.append((sin(a), math.sin(va)))
            elif op == 6:
                pool.append((cos(a), math.cos(va)))
        for e, expected in pool:
            assert _evaluate(e, numbers) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def _evaluate(e, numbers):
    if not isinstance(e, Expr):
        return e
    g, memo = e.graph, {}
    functions = {
        "neg": lambda a, _: -a,
        "sin": lambda a, _: math.sin(a),
        "cos": lambda a, _: math.cos(a),
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "div": lambda a, b: a / b,
    }
    for i, op in enumerate(g.op):
        if op == "const":
            memo[i] = g.constant_of[i]
        elif op == "input":
            memo[i] = float(numbers[g.a[i]])
        else:
            memo[i] = functions[op](memo[g.a[i]], memo.get(g.b[i]))
    return memo[e.index]


# ---------------------------------------------------------------- factors
@pytest.fixture(scope="module")
def ring():
    return TrigRing(["a", "b", "c"], ["l", "m", "d"])


def test_factors_of_sums_of_angles(ring):
    """What the normal form hides: sin²a as 1 - cos²a, sin(a+b) as a sum of four products."""
    a, b, c, l, m, d = (ring[x] for x in "abclmd")
    one = a.cos() ** 2 + a.sin() ** 2
    for wanted in (
        [(a.sin(), 2)],
        [(a.cos(), 1), (a.sin(), 1)],
        [((a + b).sin(), 1), (b.cos(), 1)],
        [((a + b).cos(), 2), (l, 1)],
        [((a - b + c).sin(), 1), ((b + c).cos(), 1), (m, 2)],
        [(one - a.cos(), 1)],
        [(l * a.cos() + m, 1), (b.sin(), 1), (d + l, 1)],
        [(l * a.cos() + m * (a + b).cos(), 1), (c.sin(), 3)],
        [((a + b).sin() + 2 * c.cos(), 1)],
    ):
        product = one * 3
        for factor, exponent in wanted:
            product = product * factor**exponent
        number, found = factored(product)
        again = one * number
        for factor, exponent in found:
            again = again * factor**exponent
        assert again == product
        assert len(found) == len(wanted)
        assert {e: sum(1 for _, x in found if x == e) for _, e in found} == {
            e: sum(1 for _, x in wanted if x == e) for _, e in wanted
        }
        for factor, exponent in wanted:
            assert any(e == exponent and _proportional(factor, f) for f, e in found)


def test_factors_of_random_products(ring):
    """Multiplied out, put into normal form, taken apart again: the product is the same, and never
    in fewer factors."""
    rng = np.random.default_rng(0)
    names = [ring[x] for x in "abc"]
    for _ in range(30):
        pool = []
        for _ in range(int(rng.integers(1, 4))):
            turns = rng.integers(-1, 2, 2)
            angle = names[0] + sum((int(k) * x for k, x in zip(turns, names[1:], strict=True)), 0)
            wave = angle.sin() if rng.random() < 0.5 else angle.cos()
            pool.append(wave + ring["l"] if rng.random() < 0.3 else wave)
        product = pool[0]
        for factor in pool[1:]:
            product = product * factor
        number, found = factored(product)
        total = None
        for factor, exponent in found:
            for _ in range(exponent):
                total = factor if total is None else total * factor
        assert total * number == product
        assert sum(e for _, e in found) >= len(pool)


def _proportional(x, y):
    return x * y.leading_coefficient == y * x.leading_coefficient
