"""Uniform inputs: one value for the whole batch, read and worked up once a call.

`fb.compile` has none, and in kernels with inputs= p alone is one; so programs of every mixture are
traced here.
"""

import dataclasses

import numpy as np
import pytest

from freebody import ShapeError
from freebody.math import cos, sign, sin, sqrt
from freebody.program import Argument, passes, trace
from freebody.program.passes import hoist
from freebody.targets import compile_program
from freebody.targets.interpreter import Interpreter
from support.programs import assert_close, direct, random_program, samples

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
