"""Programs, the half-way product of the compiler: what is traced, checked, printed, and changed by
its passes; the steps of recurrences; uniform inputs, which have one value for the whole batch, read
and worked up once a call.

No public function makes a program that is wrong, or shows one between two passes, or has a
recurrence or mixture of uniform inputs that can be chosen freely; so these are traced here.
"""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from freebody import ShapeError
from freebody.math import cos, minimum, sign, sin, sqrt, where
from freebody.program import Argument, Program, ProgramError, passes, trace, verify
from freebody.program.passes import hoist
from freebody.targets import compile_program
from freebody.targets.in_turn import Placed, in_turn, recurrence
from freebody.targets.interpreter import Interpreter
from freebody.targets.llvm import scan
from support.programs import assert_close, direct, random_program, samples, swap_kernel


def test_a_program_prints_and_counts():
    program = trace(
        "f",
        lambda q, m: ([sin(q[0]) * m, -3.0],),
        [Argument("q", (2,)), Argument("m", ())],
        [Argument("r", (2,))],
    )
    assert program.listing().splitlines() == [
        "f: q(2), m() -> r(2)",
        "  %0 = q[0]",
        "  %1 = m",
        "  %2 = sin %0",
        "  %3 = mul %1 %2",
        "  %4 = -3.0",
        "  r[0] = %3",
        "  r[1] = %4",
    ]
    assert str(program) == "f: q(2), m() -> r(2); 1 mul, 1 sin"
    assert program.operations == {"sin": 1, "mul": 1}


def test_the_digest_is_of_the_content():
    a, b = (swap_kernel(target="numpy").program for _ in range(2))
    assert a.digest == b.digest
    assert dataclasses.replace(a, constants=(3.0,)).digest != a.digest
    assert dataclasses.replace(a, name="other").digest != a.digest
    chosen = trace(
        "f", lambda q: (where(q[0], q[1], q[2]),), [Argument("q", (3,))], [Argument("r", ())]
    )
    assert dataclasses.replace(chosen, c=tuple(min(k, 1) for k in chosen.c)).digest != chosen.digest


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (lambda x: x[0], r"f: the traced function returned Expr, expected a tuple .*: r\(2\)"),
        (
            lambda x: (x, x),
            r"returned 2 values, expected a tuple with one entry for each output: r\(2\)",
        ),
        (lambda x: (x[0],), r"output r\(2\) holds a scalar where a sequence of 2 was expected"),
        (lambda x: ((x[0],) * 3,), r"output r\(2\) holds a tuple of 3 where a sequence of 2"),
        (lambda x: ((x[0], "a"),), r"output r\(2\) holds a str of 1|holds str 'a' where a scalar"),
        (lambda x: ((x[0], x),), r"output r\(2\) holds a tuple of 2 where a scalar was expected"),
        (
            lambda x: ((x[0], None),),
            r"output r\(2\) holds NoneType None where a scalar was expected",
        ),
    ],
)
def test_what_a_traced_function_returns_is_checked(returned, message):
    with pytest.raises(ProgramError, match=message):
        trace("f", returned, [Argument("x", (2,))], [Argument("r", (2,))])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"op": ("input", "input", "magic")}, "unknown operation 'magic'; known: input, const"),
        ({"a": (0, 7, 0)}, "input 7 of 3"),
        ({"a": (0, 1, 2)}, "an operand precedes its use"),
        ({"b": (-1, -1, 2)}, "an operand precedes its use"),
        ({"b": (-1, -1, -1)}, "an operand precedes its use"),
        ({"b": (-1, 0, 1)}, "input 1 of 3"),
        (
            {"c": (-1, -1, 0)},
            r"%2 = add: it has 2 operands, what is left of \(a, b, c\) = \(0, 1, 0\) is -1",
        ),
        ({"b": (-1, -1)}, "op, a, b and c have one entry a node"),
        ({"c": (-1, -1)}, "op, a, b and c have one entry a node"),
        ({"results": (0, 1, 3)}, "a result is a node"),
        ({"results": (0, 1)}, "3 output scalars need as many results"),
        ({"constants": (math.inf,)}, "constants are finite"),
        ({"outputs": ()}, "at least one output"),
        (
            {"inputs": (Argument("q", (3,)), Argument("q", ()))},
            "names of inputs are used once: q, q",
        ),
        ({"inputs": (Argument("q", (-1,)),)}, "negative size"),
    ],
)
def test_the_specification_of_a_program(change, message):
    valid = Program(
        "p",
        (Argument("q", (3,)),),
        (Argument("r", (3,)),),
        ("input", "input", "add"),
        (0, 1, 0),
        (-1, -1, 1),
        (),
        (0, 1, 2),
    )
    assert verify(valid) is valid
    with pytest.raises(ProgramError, match=message):
        verify(dataclasses.replace(valid, **change))


@pytest.mark.parametrize("name", passes.PASSES)
def test_a_pass_keeps_the_meaning(name):
    for seed in range(5):
        program = random_program(seed)
        changed = verify(passes.PASSES[name](program))
        arrays = samples(50)
        assert_close(compile_program(changed, target="numpy")(*arrays), direct(seed, arrays))


def test_quotients_by_one_denominator_share_its_reciprocal():
    program = trace(
        "f", lambda x: ([x[0] / x[2], x[1] / x[2]],), [Argument("x", (3,))], [Argument("y", (2,))]
    )
    assert passes.share_reciprocals(program).operations == {"div": 1, "mul": 2}
    single = trace(
        "f", lambda x: ([x[0] / x[2], x[1] / x[0]],), [Argument("x", (3,))], [Argument("y", (2,))]
    )
    assert passes.share_reciprocals(single) is single


def test_the_schedule_keeps_few_values_alive():
    def sums(x):  # made breadth first: all products, then all sums
        products = [a * b for a, b in itertools.combinations(x, 2)]
        while len(products) > 1:
            products = [
                a + b
                for a, b in itertools.zip_longest(products[::2], products[1::2], fillvalue=0.0)
            ]
        return (products[0],)

    program = trace("sums", sums, [Argument("x", (20,))], [Argument("y", ())])
    assert most_alive(program) > 90
    assert most_alive(passes.schedule(program)) < 15


def most_alive(program):
    last = {i: k for k in range(len(program)) for i in program.operands(k)}
    alive, most = 0, 0
    for k, op in enumerate(program.op):
        ended = sum(
            last[i] == k and program.op[i] not in ("input", "const")
            for i in set(program.operands(k))
        )
        alive += (op not in ("input", "const")) - ended
        most = max(most, alive)
    return most


STEPS = 7


def step(state, row, low):
    a, b = state
    total = sum(row[1:], row[0])
    return ((minimum(a + 0.1 * sin(total * b), low), b - a * row[4]),)


STEP_INPUTS = [Argument("state", (2,)), Argument("row", (13,)), Argument("low", ())]


STEPPING = trace("steps", step, STEP_INPUTS, [Argument("next", (2,))])


def given(samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First states, rows that run backwards in an array of gaps, and numbers."""
    rng = np.random.default_rng(samples)
    rows = rng.normal(size=(STEPS, samples, 13, 2))[::-1, :, :, 0]
    return rng.normal(size=(samples, 2)), rows, rng.normal(size=(STEPS, samples))


@pytest.mark.parametrize("samples", [1, 3, 4, 21])
def test_steps_are_those_of_the_kernel(samples: int):
    kernel = compile_program(STEPPING)
    state, rows, low = given(samples)
    found = recurrence(kernel, state, rows, low)
    assert found.shape == (STEPS + 1, samples, 2)
    for k in range(STEPS):
        state = kernel(state, rows[k], low[k])
        assert np.array_equal(found[k + 1], state)
    without = recurrence(compile_program(STEPPING, target="numpy"), *given(samples))
    assert found == pytest.approx(without, rel=1e-12)


@pytest.mark.parametrize("samples", [1, 5])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("entry", [0, 7, 8, 12])
def test_what_is_not_finite_ends_a_sample_alone(samples: int, wrong: float, entry: int):
    state, rows, low = given(samples)
    rows[3, 0, entry] = wrong
    found = recurrence(compile_program(STEPPING), state, rows, low)
    assert np.isfinite(found[:4]).all()
    assert np.isnan(found[4:, 0]).all()
    assert np.isfinite(found[:, 1:]).all()
    low[0, 0], rows[3, 0, entry] = wrong, 0.0
    assert np.isnan(recurrence(compile_program(STEPPING), state, rows, low)[1:, 0]).all()


def test_no_steps_are_none():
    state, rows, low = given(2)
    found = recurrence(compile_program(STEPPING), state, rows[:0], low[:0])
    assert np.array_equal(found, state[None])


@pytest.mark.parametrize("target", ["cpu", "numpy"])
@pytest.mark.parametrize("samples", [1, 21])
def test_states_may_stay_where_they_are_or_go_elsewhere(target: str, samples: int, monkeypatch):
    """Of five steps the results of two are kept; a row for all steps, numbers for all samples."""
    # as where two threads compile it at once: each must keep its own
    monkeypatch.setattr(scan, "_repeat", scan._repeat.__wrapped__)
    kernel = compile_program(STEPPING, target=target)
    state, rows, low = given(samples)
    kept = np.full((samples, 4, 3, 2), np.nan)[:, :, 1].swapaxes(0, 1)
    now, expected = state.copy(), [state]
    where = [-1, 2, -1, 0, -1, -1]
    places = [
        Placed((now[None], kept), np.array([k >= 0 for k in some]) * 1, np.maximum(some, 0))
        for some in (where[:-1], where[1:])
    ]
    in_turn(kernel, (places[0], rows[0], low[:5, :1], places[1]), 5, samples)
    for k in range(5):
        expected.append(kernel(expected[-1], rows[0], low[k, 0]))
    np.testing.assert_array_equal(kept[2], expected[1])
    np.testing.assert_array_equal(kept[0], expected[3])
    np.testing.assert_array_equal(now, expected[5])
    assert np.isnan(kept[[1, 3]]).all()


LLVM = [2, 4, 8]


every_width = pytest.mark.parametrize("width", LLVM)


pytestmark = pytest.mark.usefixtures("memory_only")


def mixed(p, x, A, s, y):
    """Of each kind: uniform throughout, of a sample throughout, and where they meet; sines of
    both."""
    turn, scale = sin(p[2]), cos(p[2]) / (1.0 + p[1] * p[1])
    a = p[0] * p[1] + turn
    row = sin(x[1] + sin(a)) * scale
    return (
        [a * x[0] + row, x[0] / p[3], a, p[4], 2.0, sin(x[0]), y[0][1]],
        [
            [x[1] * A[0][0], A[1][1] * a - scale],
            [sqrt(s * s + 1.0) / y[0][0], sign(s) - y[1][0] / A[0][1]],
        ],
        s * sin(s),
    )


INPUTS = (
    Argument("p", (19,), uniform=True),
    Argument("x", (2,)),
    Argument("A", (2, 2), uniform=True),
    Argument("s", (), uniform=True),
    Argument("y", (2, 3)),
)


OUTPUTS = (Argument("u", (7,)), Argument("B", (2, 2)), Argument("t", ()))


PROGRAM = trace("mixed", mixed, INPUTS, OUTPUTS)


def compiled(width):
    return compile_program(PROGRAM, target="cpu", width=width)


PLAIN = compile_program(PROGRAM, target="numpy")


def arrays(batch, moving=(), seed=0):
    """Values of the inputs: those of a sample and the `moving` uniform ones have the batch's
    axes."""
    rng = np.random.default_rng(seed)
    return [
        rng.uniform(
            0.5, 2.0, size=(() if x.uniform and x.name not in moving else tuple(batch)) + x.shape
        )
        for x in INPUTS
    ]


def same_bits(left, right):
    return all(np.array_equal(a, b) for a, b in zip(left, right, strict=True))


@every_width
@pytest.mark.parametrize("batch", [(), (1,), (3,), (8,), (17,), (100,), (3, 5), (0,), (4, 0)])
def test_one_value_for_the_batch(width, batch):
    given = arrays(batch)
    assert_close(compiled(width)(*given), PLAIN(*given), 1e-13)


@every_width
def test_any_strides(width):
    given = arrays((21,))
    apart = [np.repeat(x, 2, axis=-1)[..., ::2] if x.ndim else x for x in given]
    turned = [np.asfortranarray(x) if x.ndim else x for x in given]
    backwards = [x[::-1].copy()[::-1] if x.ndim else x for x in given]
    for some in (apart, turned, backwards):
        assert same_bits(compiled(width)(*some), compiled(width)(*given))


@every_width
@pytest.mark.parametrize("moving", [("p",), ("A", "s"), ("p", "A", "s")])
def test_a_value_for_every_sample(width, moving):
    """By a kernel in which nothing is uniform; the loop itself is right too, one sample after the
    other."""
    kernel, given = compiled(width), arrays((11,), moving)
    expected = PLAIN(*given)
    assert_close(kernel(*given), expected, 1e-13)
    assert_close(kernel.ufunc(*given), expected, 1e-13)
    assert same_bits(kernel(*given), kernel.per_sample(*given))
    one = [x[4] if x.ndim > len(i.shape) else x for x, i in zip(given, INPUTS, strict=True)]
    assert same_bits(kernel(*one), [x[4] for x in kernel.ufunc(*given)])


def test_values_that_broadcast_with_the_batch():
    p, x, A, s, y = arrays((6,))
    many = np.stack([p, 2.0 * p, p + 1.0])[:, None]
    kernel = compiled(8)
    assert_close(kernel(many, x, A, s, y), PLAIN(many, x, A, s, y), 1e-13)
    assert_close(kernel.ufunc(many, x, A, s, y), PLAIN(many, x, A, s, y), 1e-13)
    out = tuple(np.empty((3, 6, *argument.shape)) for argument in OUTPUTS)
    assert kernel(many, x, A, s, y, out=out)[0] is out[0]
    assert_close(out, PLAIN(many, x, A, s, y), 1e-13)


def test_the_number_of_axes_alone_decides():
    kernel, given = compiled(4), arrays((5,))
    p, rest = given[0], given[1:]
    assert same_bits(kernel(p[None], *rest), kernel.per_sample(p[None], *rest))
    batch = kernel(*given)
    single = kernel(
        p, *(x[2] if not i.uniform else x for x, i in zip(rest, INPUTS[1:], strict=True))
    )
    assert same_bits(single, [x[2] for x in batch])


@every_width
@pytest.mark.parametrize("name", ["p", "A", "s"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_not_finite_is_in_all_results(width, name, bad):
    kernel = compiled(width)
    for place in (0, -1):
        given = arrays((9,))
        which = [x.name for x in INPUTS].index(name)
        given[which] = np.array(given[which])
        given[which].reshape(-1)[place] = bad
        assert all(np.isnan(x).all() for x in kernel(*given))
    moving = arrays((9,), ("p",))
    moving[0][4, 7] = bad
    for results in (kernel(*moving), kernel.ufunc(*moving)):
        for x in results:
            lost = np.isnan(x.reshape(9, -1))
            assert lost[4].all()
            assert not np.delete(lost, 4, axis=0).any()


def test_a_sample_that_is_not_finite_is_nan_and_no_other():
    given = arrays((9,))
    given[1][3, 0] = np.nan
    for x in compiled(8)(*given):
        lost = np.isnan(x.reshape(9, -1))
        assert lost[3].all()
        assert lost.sum() == lost[3].size


@every_width
def test_all_results_uniform(width):
    program = trace(
        "all",
        lambda p, x: ([p[0] * sin(p[1]), p[1], 3.0],),
        [Argument("p", (2,), True), Argument("x", (1,))],
        [Argument("r", (3,))],
    )
    kernel = compile_program(program, target="cpu", width=width)
    p = np.array([2.0, 0.5])
    expected = [2.0 * np.sin(0.5), 0.5, 3.0]
    assert np.allclose(kernel(p, np.ones((13, 1))), np.tile(expected, (13, 1)), rtol=1e-15)
    assert np.isnan(kernel(p, np.array([np.nan]))).all()
    alone = trace(
        "alone", lambda p: ([p[0] * sin(p[1]), p[1], 3.0],), program.inputs[:1], program.outputs
    )
    kernel = compile_program(alone, target="cpu", width=width)
    assert np.allclose(kernel(p), expected, rtol=1e-15)
    assert np.allclose(kernel(np.tile(p, (5, 1))), np.tile(expected, (5, 1)), rtol=1e-15)


def test_no_numbers_at_all():
    program = trace(
        "none",
        lambda x, p: ([2.0 * x[0]],),
        [Argument("x", (1,)), Argument("p", (0,), True)],
        [Argument("r", (1,))],
    )
    kernel = compile_program(program)
    assert kernel(np.ones((4, 1)), np.ones(0)).tolist() == [[2.0]] * 4


def test_threads_change_nothing():
    given = arrays((3000,))
    alone = compiled(8)(*given, threads=1)
    assert same_bits(compiled(8)(*given, threads=3), alone)
    assert_close(alone, PLAIN(*given), 1e-13)


@pytest.mark.sample(1)
@every_width
def test_many_numbers_and_large_angles(width):
    count = 1003
    program = trace(
        "many",
        lambda x, p: ([sum((sin(p[k]) * x[0] for k in range(40)), 0.0), sum(p[1:], p[0]) * x[0]],),
        [Argument("x", (1,)), Argument("p", (count,), uniform=True)],
        [Argument("r", (2,))],
    )
    kernel = compile_program(program, target="cpu", width=width)
    rng = np.random.default_rng(1)
    x, p = rng.normal(size=(19, 1)), rng.normal(size=count)
    p[:40] = 10.0 ** rng.uniform(-3, 15, 40)
    expected = np.stack([np.sin(p[:40]).sum() * x[:, 0], p.sum() * x[:, 0]], axis=-1)
    np.testing.assert_allclose(kernel(x, p), expected, rtol=1e-11)
    for k in (0, 40, count - 1):
        p[k], kept = np.inf, p[k]
        assert np.isnan(kernel(x, p)).all()
        p[k] = kept


def test_shapes_are_checked_as_of_any_input():
    with pytest.raises(ShapeError, match=r"mixed: p has shape \(18,\), expected \(..., 19\)"):
        compiled(8)(np.ones(18), *arrays((3,))[1:])
    with pytest.raises(ShapeError, match=r"mixed: p has shape \(2, 18\), expected \(..., 19\)"):
        compiled(8)(np.ones((2, 18)), *arrays((3,))[1:])


def test_what_is_uniform_is_computed_once():
    once, every = hoist(PROGRAM)
    assert once.operations.get("sin") == 3  # of p[2], of a, of s
    assert every.operations["sin"] == 2
    assert [x.name for x in every.inputs] == ["x", "y", "uniform"]
    given = arrays(())
    known = np.concatenate([x.ravel() for x, i in zip(given, INPUTS, strict=True) if i.uniform])
    own = np.concatenate([x.ravel() for x, i in zip(given, INPUTS, strict=True) if not i.uniform])
    found = Interpreter.of(every)([*own, *known, *Interpreter.of(once)(known)])
    expected = np.concatenate([np.ravel(x) for x in PLAIN(*given)])
    np.testing.assert_allclose(found, expected, rtol=1e-15)


def test_a_uniform_denominator_is_divided_by_once():
    every = hoist(passes.optimise(PROGRAM))[1]
    assert every.operations.get("div") == 1  # by y, which is a sample's


def test_uniform_factors_are_multiplied_once():
    """Also where the inner product has another reader, and through several factors and a
    quotient."""

    def function(u, x):
        inner = u[0] * x[0]
        return [
            inner,
            u[1] * inner,
            u[2] * (u[1] * inner) / u[3],
            0.1 * (u[2] * (x[0] * x[1])),
            u[0] * u[1],
        ]

    program = trace(
        "factors",
        lambda u, x: (function(u, x),),
        [Argument("u", (4,), uniform=True), Argument("x", (2,))],
        [Argument("r", (5,))],
    )
    every = hoist(passes.optimise(program))[1]
    assert every.operations == {"mul": 5}
    rng = np.random.default_rng(3)
    u, x = rng.uniform(0.5, 2.0, 4), rng.normal(size=(7, 2))
    expected = np.stack(np.broadcast_arrays(*function(u, x.T)), axis=-1)
    np.testing.assert_allclose(compile_program(program)(u, x), expected, rtol=1e-15)
    plain = dataclasses.replace(
        program, inputs=tuple(Argument(i.name, i.shape) for i in program.inputs)
    )
    assert passes.gather_factors(plain) is plain


@pytest.mark.sample(2)
@pytest.mark.parametrize("flags", [(True, False, False), (False, True, True), (True, True, True)])
@pytest.mark.parametrize("seed", range(2))
def test_uniform_inputs_change_nothing_but_roundings(seed, flags):
    program = random_program(seed, 80)
    inputs = tuple(
        dataclasses.replace(i, uniform=uniform)
        for i, uniform in zip(program.inputs, flags, strict=True)
    )
    arrays = [x[0] if uniform else x for x, uniform in zip(samples(21, seed), flags, strict=True)]
    for target, width in (("numpy", None), ("cpu", 8)):
        compiled = compile_program(
            dataclasses.replace(program, inputs=inputs), target=target, width=width
        )
        batch = arrays if False in flags else [x[None] for x in arrays]
        assert_close(compiled(*batch), direct(seed, batch, 80))
        assert_close(compiled(*arrays), direct(seed, arrays, 80))
