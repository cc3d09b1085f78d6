"""Traced scalars: folding, interning, and what they refuse."""

import math
from operator import neg

import numpy as np
import pytest

from freebody.math import cos, sign, sin, sqrt
from freebody.scalars.expr import Expr, Graph
from freebody.scalars.nodes import GraphError


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
