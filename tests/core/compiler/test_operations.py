"""The operations of programs: every one in every target, by its own laws, at the edges of the
number range.

Which operations there are, and what each promises, the tables of the compiler say: so these tests
read them, and trace each operation by itself.
"""

import itertools
import math

import numpy as np
import pytest

from freebody import FreebodyError, elementary
from freebody.dual import Dual, slopes
from freebody.elementary import PARTIALS
from freebody.program import Argument, trace
from freebody.scalars.expr import Expr, Graph
from freebody.scalars.nodes import GraphError
from freebody.scalars.operations import OPERATIONS
from freebody.scalars.trig import TrigRing
from freebody.targets import compile_program
from freebody.targets.interpreter import FUNCTION
from freebody.targets.llvm.instructions import INSTRUCTION
from freebody.targets.target import target_named
from freebody.targets.text import LANGUAGES, SourceUnit
from support.every_target import every_target

NAMED = sorted(elementary.FUNCTIONS)
CHOICES = ("absolute", "less", "less_equal", "equal", "where", "minimum", "maximum", "sign")
EDGES = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.5,
    -2.5,
    5e-324,
    -5e-324,
    1e-308,
    1.7e308,
    -1.7e308,
    np.nextafter(1.0, 2.0),
)


pytestmark = pytest.mark.usefixtures("memory_only")


def compiled(function, arity, target="cpu", width=None):
    inputs = [Argument(name, ()) for name in "xyz"[:arity]]
    return compile_program(
        trace("f", lambda *x: (function(*x),), inputs, [Argument("r", ())]),
        target=target,
        width=width,
    )


def edges(arity):
    """Every combination of the edges, as columns."""
    return [
        np.array(column) for column in zip(*itertools.product(EDGES, repeat=arity), strict=True)
    ]


@pytest.mark.parametrize("name", sorted(OPERATIONS))
def test_every_target_knows_every_operation(name):
    tables = {
        "NumPy": FUNCTION,
        "LLVM": INSTRUCTION | dict.fromkeys(("sin", "cos")),
    }
    assert not [target for target, table in tables.items() if name not in table]


@pytest.mark.sample(13)
@every_target
@pytest.mark.parametrize("name", sorted(OPERATIONS))
def test_every_target_computes_what_the_operation_is(name, target, width):
    operation = OPERATIONS[name]
    rng = np.random.default_rng(5)
    signs = 1.0 if name in ("sqrt", "log") else -1.0  # whose domain begins at 0; arcs' ends at 1
    columns = rng.uniform(0.05, 0.95, (operation.arity, 64)) * rng.choice(
        [1.0, signs], (operation.arity, 64)
    )
    expected = [operation.number(*values) for values in columns.T.tolist()]

    def traced(*operands):
        graph = operands[0].graph
        return Expr(graph, operation.node(graph, *(x.index for x in operands)))

    found = compiled(traced, operation.arity, target, width)(*columns)
    np.testing.assert_allclose(found, expected, rtol=2e-15, atol=0.0)


@pytest.mark.sample(12)
@every_target
@pytest.mark.parametrize("name", CHOICES)
def test_choices_are_exact_everywhere(name, target, width):
    function, operation = elementary.FUNCTIONS[name], OPERATIONS[name]
    columns = edges(operation.arity)
    expected = [
        operation.number(*values) for values in zip(*(c.tolist() for c in columns), strict=True)
    ]
    np.testing.assert_array_equal(
        compiled(function, operation.arity, target, width)(*columns), expected
    )
    np.testing.assert_array_equal(function(*columns), expected)
    assert [
        function(*values) for values in zip(*(c.tolist() for c in columns), strict=True)
    ] == expected


@pytest.mark.parametrize("name", CHOICES)
def test_choices_are_exact_in_32_bits(name):
    function, operation = elementary.FUNCTIONS[name], OPERATIONS[name]
    edges = np.array([0.0, -0.0, 1.0, -1.0, 2.5, 1e-45, -1e-45, 3e38, -3e38], dtype=np.float32)
    columns = [
        np.array(c) for c in zip(*itertools.product(edges, repeat=operation.arity), strict=True)
    ]
    inputs = [Argument(x, ()) for x in "xyz"[: operation.arity]]
    program = trace("f", lambda *x: (function(*x),), inputs, [Argument("r", ())])
    expected = [
        operation.number(*values) for values in zip(*(c.tolist() for c in columns), strict=True)
    ]
    np.testing.assert_array_equal(compile_program(program, dtype="float32")(*columns), expected)


@pytest.mark.sample(9)
@every_target
@pytest.mark.parametrize("name", NAMED)
def test_a_sample_that_is_not_finite_has_nan_whatever_is_chosen(name, target, width):
    arity = OPERATIONS[name].arity
    kernel = compiled(elementary.FUNCTIONS[name], arity, target, width)
    for k, bad in itertools.product(range(arity), (math.nan, math.inf, -math.inf)):
        columns = [np.full(11, 0.5) for _ in range(arity)]
        columns[k][3] = bad
        assert np.isnan(kernel(*columns)).nonzero()[0].tolist() == [3]


@every_target
def test_nan_that_arises_inside_is_not_hidden_by_minimum_and_maximum(target, width):
    """As NumPy's; a comparison with NaN is false, and NaN is not 0."""
    results = compile_program(
        trace(
            "f",
            lambda x: (
                tuple(
                    function(elementary.sqrt(x), 1.0) + 0.0 * function(1.0, elementary.sqrt(x))
                    for function in (elementary.minimum, elementary.maximum)
                )
                + (
                    elementary.less(elementary.sqrt(x), 1.0),
                    elementary.where(elementary.sqrt(x), 2.0, 3.0),
                )
            ),
            [Argument("x", ())],
            [Argument(name, ()) for name in "abcd"],
        ),
        target=target,
        width=width,
    )(np.array([-1.0, 4.0]))
    np.testing.assert_array_equal(results, [[np.nan, 1.0], [np.nan, 2.0], [0.0, 0.0], [2.0, 2.0]])


@pytest.mark.sample(1)
@pytest.mark.parametrize("width", [2, 4, 8])
def test_a_choice_by_a_comparison_takes_its_truth_values(width):
    """In one instruction; as exact where the comparison is a result too, or comes from
    elsewhere."""
    e = elementary
    x, y = np.random.default_rng(0).normal(size=(2, 50))
    y[::5] = x[::5]
    for compare in (e.less, e.less_equal, e.equal):
        kernel = compiled(
            lambda a, b, compare=compare: e.where(compare(a, b), a - b, 7.0), 2, width=width
        )
        assert "fcmp une" not in kernel.source
        np.testing.assert_array_equal(kernel(x, y), np.where(compare(x, y), x - y, 7.0))
    several = trace(
        "several",
        lambda a, b: (
            e.less(a, b),
            e.where(e.less(a, b), e.where(a, b, 1.0), 3.0),
            e.where(
                e.less(a, b), e.sin(e.less(a, b) * a), 3.0
            ),  # compared before the sine, chosen behind it
        ),
        [Argument("a", ()), Argument("b", ())],
        [Argument("r", ()), Argument("s", ()), Argument("t", ())],
    )
    flags, chosen, behind = compile_program(several, width=width)(x, y)
    np.testing.assert_array_equal(flags, x < y)
    np.testing.assert_array_equal(chosen, np.where(x < y, y, 3.0))
    np.testing.assert_allclose(behind, np.where(x < y, np.sin(x), 3.0), rtol=1e-15)


@pytest.mark.parametrize("name", NAMED)
def test_constants_are_folded_as_the_float_function_says(name):
    graph, operation = Graph(), OPERATIONS[name]
    for values in itertools.product((0.25, 0.5, 1.0), repeat=operation.arity):
        made = elementary.FUNCTIONS[name](*(graph.constant(v) for v in values))
        assert graph.constant_of[made.index] == operation.number(*values)


@pytest.mark.parametrize(
    "name", [x for x in NAMED if OPERATIONS[x].symmetry or OPERATIONS[x].commutes]
)
def test_symmetries_make_one_node(name):
    graph, operation, function = Graph(), OPERATIONS[name], elementary.FUNCTIONS[name]
    x, y, z = (graph.input(k) for k in "xyz")
    rest = (y, z)[: operation.arity - 1]
    if operation.commutes:
        assert function(x, y) == function(y, x)
    if operation.symmetry:
        assert function(-x, *rest) == (
            function(x, *rest) if operation.symmetry == "even" else -function(x, *rest)
        )
    # and the float function has them
    for a, b in itertools.product(EDGES, repeat=2):
        values = (a, b)[: operation.arity]
        if operation.commutes:
            assert operation.number(a, b) == operation.number(b, a)
        if operation.symmetry and all(map(_in_domain, values)):
            mirrored = operation.number(-a, *values[1:])
            assert mirrored == operation.number(*values) * (
                1 if operation.symmetry == "even" else -1
            )


def _in_domain(x):
    return abs(x) <= 1.0


@every_target
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_epsilon_is_that_of_the_numbers_that_a_kernel_computes_with(dtype, target, width):
    inputs = [Argument("x", (2,)), Argument("y", ())]
    program = trace(
        "f",
        lambda x, y: (1.0 + elementary.epsilon(x[1] * y - 3.0), elementary.epsilon(y) / 2.0 + 1.0),
        inputs,
        [Argument("next", ()), Argument("same", ())],
    )
    known = target_named(target).widths
    if dtype not in known:
        pytest.skip(f"{target} has no {dtype}")
    width = width if width in known[dtype] else None
    kernel = compile_program(program, target=target, width=width, dtype=dtype)
    above, same = kernel(np.ones((9, 2)), np.ones(9))
    assert (above == np.nextafter(np.ones(1, dtype), 2)).all()
    assert (same == 1.0).all()
    assert elementary.epsilon(np.ones(3, dtype)) == np.finfo(dtype).eps
    assert elementary.epsilon(1) == elementary.epsilon(1.0) == 2.0**-52


def test_what_folds():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    e = elementary
    assert e.less(x, x) == 0.0 * x
    assert e.less_equal(x, x) == e.equal(x, x) == x**0
    assert e.where(0.0, x, y) == y
    assert e.where(2.0, x, y) == x
    assert e.where(x, y, y) == y
    assert e.minimum(x, x) == e.maximum(x, x) == x
    assert e.absolute(-x) == e.absolute(e.absolute(x)) == abs(x)
    assert e.absolute(e.sqrt(x)) == e.sqrt(x)
    assert hash(e.epsilon(2.0 * e.sin(x) - y)) in (hash(e.epsilon(x)), hash(e.epsilon(y)))


@pytest.mark.parametrize("name", [x for x in NAMED if x in PARTIALS])
def test_derivatives_by_differences(name):
    operation, function, step = OPERATIONS[name], elementary.FUNCTIONS[name], 1e-6
    for values in itertools.product((-0.6, -0.2, 0.3, 0.7), repeat=operation.arity):
        if np.isnan(operation_or_nan(operation, values)):
            continue
        for k in range(operation.arity):
            given = [Dual(v, {0: 1.0}) if i == k else v for i, v in enumerate(values)]
            above, below = (
                function(*(v + s if i == k else v for i, v in enumerate(values)))
                for s in (step, -step)
            )
            found = function(*given)
            assert found.value == function(*values)
            assert found.slopes.get(0, 0.0) == pytest.approx(
                (above - below) / (2 * step), rel=1e-8, abs=1e-8
            )


def operation_or_nan(operation, values):
    try:
        return operation.number(*values)
    except ValueError:
        return math.nan


def test_a_choice_has_the_derivative_of_what_is_chosen():
    e, x = elementary, Dual(3.0, {0: 1.0})
    with np.errstate(all="ignore"):
        root = e.sqrt(x - x)  # its slope is not a number
    assert math.isnan(root.slopes[0])
    assert e.where(e.less(x, 0.0), root, 2.0 * x).slopes == {0: 2.0}
    assert e.where(1.0, 5.0, x).slopes == {0: 0.0}
    assert e.where(x, 5.0, 7.0).slopes == {}
    assert e.minimum(x, 3.0).slopes == {0: 1.0}  # of equals the first
    assert e.minimum(3.0, x).slopes == {0: 0.0}
    assert e.maximum(x, 2.0 * x).slopes == {0: 2.0}
    assert abs(-2.0 * x).slopes == {0: 2.0}
    assert slopes(abs(x - 3.0), 1) == [0.0]
    assert (e.less(x, 4.0), e.less_equal(x, 3.0), e.equal(x, 4.0), e.sign(x)) == (
        1.0,
        1.0,
        0.0,
        1.0,
    )


def test_traced_and_differentiated_scalars_mix():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    found = elementary.minimum(x, Dual(y, {0: 1.0}))
    assert found.value == elementary.minimum(x, y)
    assert found.slopes == {0: elementary.where(elementary.less_equal(x, y), 0.0, 1.0)}
    assert type(elementary.minimum(2.0, x)) is Expr


def test_domains_of_constants():
    graph = Graph()
    for name, value in (
        ("sqrt", -2.0),
        ("log", 0.0),
        ("log", -1.0),
        ("asin", 1.1),
        ("acos", -1.1),
        ("exp", 710.0),
    ):
        with pytest.raises(GraphError, match=rf"{name}\({value}\) has no finite value"):
            elementary.FUNCTIONS[name](graph.constant(value))


def test_closed_forms_refuse_what_is_no_polynomial():
    ring = TrigRing(["a"], ["x"])
    with pytest.raises(
        FreebodyError, match="minimum of x: closed forms are polynomials in sines and cosines"
    ):
        elementary.minimum(ring["x"], 1.0)
    with pytest.raises(FreebodyError, match="sqrt of x: closed forms"):
        elementary.sqrt(ring["x"])


@pytest.mark.parametrize("name", NAMED)
def test_python_text(name):
    operation = OPERATIONS[name]
    inputs = [Argument(x, ()) for x in "xyz"[: operation.arity]]
    program = trace("f", lambda *x: (elementary.FUNCTIONS[name](*x),), inputs, [Argument("r", ())])
    space = {}
    exec(LANGUAGES["numpy"].emit(SourceUnit(program, program.name)), space)
    columns = np.random.default_rng(1).uniform(0.1, 0.9, (operation.arity, 20))
    np.testing.assert_array_equal(
        space["f"](*columns), compile_program(program, target="numpy")(*columns)
    )
