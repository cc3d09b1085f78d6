"""Kernels of 32-bit numbers: what those of 64 bits promise, to as many digits as there are.

Most of it is one program with a uniform input, which `fb.compile` does not make; a CPU without
fused multiply-add has to be feigned.
"""

import pickle

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError
from freebody.math import acos, atan2, cos, exp, log, sign, sin, sqrt, tanh, where
from freebody.program import Argument, trace
from freebody.targets import KernelError, compile_program
from freebody.targets.llvm import fastcall, machine
from freebody.targets.llvm.machine import Machine

WIDTHS = [2, 4, 8, 16]
every_width = pytest.mark.parametrize("width", WIDTHS)
ULP = 2.0**-24


pytestmark = pytest.mark.usefixtures("memory_only")


def mixed(x, A, s, p):
    turn = sin(p[0]) * x[0] + cos(x[1])
    return (
        [turn, x[2] / (2.0 + A[0][1] ** 2), sqrt(1.0 + s * s) * p[1], sign(x[0]), 0.1],
        [[A[1][k] * sin(x[k % 3]) - A[0][k] * p[2] for k in range(5)] for _ in range(2)],
        where(s, turn, -s),
    )


INPUTS = (
    Argument("x", (3,)),
    Argument("A", (2, 5)),
    Argument("s", ()),
    Argument("p", (3,), uniform=True),
)
OUTPUTS = (Argument("y", (5,)), Argument("B", (2, 5)), Argument("t", ()))
PROGRAM = trace("mixed", mixed, INPUTS, OUTPUTS)
EXACT = compile_program(PROGRAM, target="numpy")


def compiled(width=None):
    return compile_program(PROGRAM, target="cpu", width=width, dtype="float32")


def arrays(batch, seed=0):
    rng = np.random.default_rng(seed)
    sizes = [(() if x.uniform else (batch,)) + x.shape for x in INPUTS]
    return [rng.normal(size=size).astype(np.float32) for size in sizes]


def as_tuple(x):
    return x if isinstance(x, tuple) else (x,)


def same_bits(left, right):
    return all(
        x.dtype == y.dtype == np.float32 and np.array_equal(x.view(np.int32), y.view(np.int32))
        for x, y in zip(as_tuple(left), as_tuple(right), strict=True)
    )


def assert_near(results, given):
    """Within some roundings of what comes out in 64 bits."""
    for result, exact in zip(
        results, EXACT(*(np.asarray(x, dtype=np.float64) for x in given)), strict=True
    ):
        assert result.dtype == np.float32
        assert result.shape == exact.shape
        np.testing.assert_allclose(result, exact, rtol=20 * ULP, atol=20 * ULP)


# ---------------------------------------------------------------- as a ufunc
@every_width
@pytest.mark.parametrize("batch", [1, 3, 16, 37, 100])
def test_kernels_agree_with_64_bits(width, batch):
    given = arrays(batch)
    assert_near(compiled(width)(*given), given)


@every_width
def test_strides_splits_and_broadcasting_change_nothing(width):
    kernel, given = compiled(width), arrays(50)
    whole = kernel(*given)
    x, A, s, p = given
    other = [
        np.asfortranarray(x),
        np.repeat(A, 2, axis=0)[::2],
        s[::-1].copy()[::-1],
        np.repeat(p, 3)[::3],
    ]
    assert same_bits(kernel(*other), whole)
    for cut in (1, 7, 16, 49):
        parts = [
            kernel(x[part], A[part], s[part], p) for part in (slice(None, cut), slice(cut, None))
        ]
        assert same_bits(tuple(np.concatenate(both) for both in zip(*parts, strict=True)), whole)
    alike = np.array([x[4]] * 50), A, np.array([s[0]] * 50), p
    assert same_bits(kernel(x[4], A, s[0], p), kernel(*alike))


@pytest.mark.sample(18)
@pytest.mark.parametrize("columns", [1, 2, 3, 5, 6, 7, 9, 13, 17, 24, 70])
@every_width
def test_rows_of_any_length(width, columns):
    order = [(7 * k + 3) % columns for k in range(columns)]
    kernel = fb.compile(
        lambda x: [x[k] + 1.0 for k in order],
        {"x": columns},
        {"y": columns},
        target="cpu",
        width=width,
        dtype="float32",
    )
    for batch in (1, width, 3 * width + 1):
        around = np.full((2 * batch + 2, columns), np.nan, np.float32)
        around[1:-1] = np.arange(2 * batch * columns).reshape(-1, columns)
        out = np.full((batch + 2, columns), np.nan, np.float32)
        for x in (around[1 : batch + 1], around[1:-1:2], np.asfortranarray(around[1:-1])[::2]):
            kernel(x, out=out[1:-1])
            assert np.array_equal(out[1:-1], x[:, order] + 1)
            assert np.isnan(out[[0, -1]]).all()


def test_threads_and_large_results_change_nothing():
    given = arrays(40_000)
    assert same_bits(compiled()(*given, threads=3), compiled()(*given, threads=1))


@every_width
def test_a_sample_that_is_not_finite_is_nan_and_no_other(width):
    for place, bad in ((0, np.nan), (1, np.inf), (2, -np.inf)):
        given = arrays(21)
        given[place].reshape(21, -1)[13, -1] = bad
        for result in compiled(width)(*given):
            lost = np.isnan(result.reshape(21, -1))
            assert lost[13].all()
            assert lost.sum() == lost[13].size
    given = arrays(21)
    given[3][1] = np.nan
    assert all(np.isnan(result).all() for result in compiled(width)(*given))


def test_what_is_larger_than_the_type_is_infinite_and_so_nan():
    with pytest.warns(RuntimeWarning, match="overflow encountered in cast"):
        results = compiled()(np.array([1e300, 0.0, 0.0]), *arrays(1)[1:])
    assert all(np.isnan(x).all() for x in results)


def test_other_real_types_are_converted():
    kernel, given = compiled(), arrays(9)
    expected = kernel(*given)
    assert same_bits(kernel(*(x.astype(np.float64) for x in given)), expected)
    assert same_bits(kernel(*(x.tolist() for x in given)), expected)
    ones = [np.ones_like(x) for x in given]
    assert same_bits(kernel(*(x.astype(np.int64) for x in ones)), kernel(*ones))
    one = [given[0][0], given[1][0], given[2][0], given[3]]
    assert same_bits(kernel(*(np.asarray(x, dtype=np.float64) for x in one)), kernel(*one))
    with pytest.raises(KernelError, match="mixed: x holds complex numbers, expected real numbers"):
        kernel(given[0] + 1j, *given[1:])
    with pytest.raises(KernelError, match=r"x holds 'a' at index \(0, 0\)"):
        kernel(np.full((9, 3), "a"), *given[1:])


def test_out():
    kernel, given = compiled(), arrays(33)
    expected = kernel(*given)
    for dtype in (np.float32, np.float64):
        out = tuple(np.empty(x.shape, dtype) for x in expected)
        returned = kernel(*given, out=out)
        assert all(x is y for x, y in zip(returned, out, strict=True))
        assert all(np.array_equal(x, y) for x, y in zip(out, expected, strict=True))


def test_the_interpreters_own_way_gives_the_bits_of_the_ufunc():
    def two(x):
        return [x[1] * x[0], sin(x[0])], [x[0], 1.0 / x[1]]

    kernel = fb.compile(two, {"x": 2}, {"y": 2, "z": 2}, target="cpu", dtype="float32")
    if not fastcall.available():
        pytest.skip("this interpreter's objects are not laid out as the fast call expects")
    x = np.array([0.5, -1.25], np.float32)
    assert same_bits(kernel(x), kernel.ufunc(x))
    assert same_bits(kernel.quick_checked(kernel)(x), kernel.ufunc(x))
    out = (np.empty(2, np.float32), np.empty(2, np.float32))
    assert kernel(x, out=out) is out
    assert same_bits(out, kernel.ufunc(x))
    assert (
        kernel.quick_checked(lambda x: None)(np.array([1e-30, 1e-45], np.float32)) is None
    )  # 1 / 1e-45 is beyond the range
    assert same_bits(kernel(x.astype(np.float64)), kernel.ufunc(x))


def test_a_pickle_keeps_the_type():
    kernel, given = compiled(8), arrays(5)
    again = pickle.loads(pickle.dumps(kernel))
    assert (again.dtype, again.width) == (np.float32, 8)
    assert same_bits(again(*given), kernel(*given))


def test_a_value_for_every_sample():
    x, A, s, p = arrays(11)
    many = np.stack([p] * 11) * np.linspace(1, 2, 11, dtype=np.float32)[:, None]
    assert_near(compiled()(x, A, s, many), (x, A, s, many))
    assert_near(compiled().ufunc(x, A, s, many), (x, A, s, many))


def test_numpy_computes_in_the_same_type():
    kernel, given = compile_program(PROGRAM, target="numpy", dtype="float32"), arrays(12)
    assert_near(kernel(*given), given)


def test_options_are_checked():
    with pytest.raises(
        KernelError, match=r"target 'cpu' has no dtype 'float16'. It has: float64, float32\."
    ):
        compile_program(PROGRAM, target="cpu", dtype="float16")
    with pytest.raises(KernelError, match=r"no width 16 of float64\. Widths: 2, 4, 8 "):
        compile_program(PROGRAM, target="cpu", width=16)

    def large(x):
        return [x[0] * 1e39]

    with pytest.raises(
        KernelError, match=r"large: the constant 1e\+39 is beyond the range of float32"
    ):
        fb.compile(large, {"x": 1}, {"y": 1}, dtype="float32")
    assert fb.compile(large, {"x": 1}, {"y": 1})(np.ones(1))[0] == 1e39


# ---------------------------------------------------------------- accuracy
def both(width):
    def both(x):
        return sin(x), cos(x)

    shapes = {"x": ()}, {"s": (), "c": ()}
    return (
        fb.compile(both, *shapes, target="cpu", width=width, dtype="float32"),
        fb.compile(both, *shapes, target="cpu"),
    )


def ulps(found, exact):
    """Distance in units of the last place that the exact value has as a 32-bit number."""
    return np.abs(found.astype(np.float64) - exact) / np.spacing(
        np.abs(exact).astype(np.float32)
    ).astype(np.float64)


def angles(step):
    """Every `step`-th positive number of the type, and those nearest to multiples of pi/2."""
    x = np.arange(0, 0x7F800000, step, dtype=np.int64).astype(np.int32).view(np.float32)
    halves = (np.arange(1, 63662) * (np.pi / 2)).astype(np.float32)
    x = np.concatenate(
        [x, halves, np.nextafter(halves, np.float32(0)), np.nextafter(halves, np.float32(1e9))]
    )
    return np.concatenate([x, -x])


@pytest.mark.parametrize(("width", "step"), [(4, 9973), (16, 1999)])
def test_sine_and_cosine_within_two_ulp(width, step):
    """Against those of 64 bits, which are right to 4 of their own units."""
    x = angles(step)
    kernel, exact = both(width)
    for found, value in zip(kernel(x), exact(x.astype(np.float64)), strict=True):
        assert ulps(found, value).max() <= 2


@pytest.mark.long
def test_sine_and_cosine_of_one_in_a_hundred():
    x = angles(97)
    kernel, exact = both(16)
    for found, value in zip(kernel(x), exact(x.astype(np.float64)), strict=True):
        assert ulps(found, value).max() <= 2


def test_sine_and_cosine_without_fused_multiply_add(monkeypatch):
    monkeypatch.setattr(
        machine.Host,
        "machine",
        lambda self, width, real: Machine(width or 4, False, self.x86, real),
    )
    kernel = fb.compile(
        lambda x: (sin(x), cos(x)),
        {"x": ()},
        {"sine": (), "cosine": ()},
        target="cpu",
        dtype="float32",
    )
    assert "@llvm.fma.v4f32(" not in kernel.source.replace(
        "declare <4 x float> @llvm.fma.v4f32(", ""
    )
    x = angles(99_991)
    for found, value in zip(kernel(x), both(16)[1](x.astype(np.float64)), strict=True):
        assert ulps(found, value).max() <= 2


def test_signs_of_zero_and_what_is_not_finite():
    s, c = both(16)[0](np.array([0.0, -0.0, -1e-45], np.float32))
    assert np.signbit(s).tolist() == [False, True, True]
    assert c.tolist() == [1.0, 1.0, 1.0]
    found = fb.compile(lambda x: sin(x * x), {"x": ()}, dtype="float32")(
        np.array([1e30, 1.0], np.float32)
    )
    assert np.isnan(found).tolist() == [True, False]


def test_other_functions_are_rounded_once():
    functions = {"exp": exp, "log": log, "tanh": tanh, "acos": acos}
    kernel = fb.compile(
        lambda x: {name: f(x) for name, f in functions.items()} | {"atan2": atan2(x, 0.3)},
        {"x": ()},
        target="cpu",
        dtype="float32",
    )
    x = np.linspace(1e-6, 1.0, 3001).astype(np.float32)
    found = kernel(x)
    wide = x.astype(np.float64)
    exact = [
        np.exp(wide),
        np.log(wide),
        np.tanh(wide),
        np.arccos(wide),
        np.arctan2(wide, np.float32(0.3)),
    ]
    for result, value in zip(found, exact, strict=True):
        assert ulps(result, value)[value != 0].max() <= 0.51


@pytest.mark.parametrize("name", ["inverse_dynamics", "forward_dynamics", "mass_matrix"])
def test_a_robot(name):
    """The stated accuracy: a sample's error relative to its largest entry."""
    model = fb.load("ur5e")
    rng = np.random.default_rng(0)
    exact, kernel = fb.kernel(model, name), fb.kernel(model, name, dtype="float32")
    given = [rng.normal(size=(500, 6)) for _ in exact.program.inputs]
    wide, short = exact(*given), kernel(*given)
    assert short.dtype == np.float32
    axes = tuple(range(1, wide.ndim))
    error = np.abs(short - wide).max(axis=axes) / np.abs(wide).max(axis=axes)
    assert np.median(error) < 5e-7
    assert 1e-8 < error.max() < 2e-5
    assert fb.kernel(model, name) is exact


def test_matrices_of_large_robots_have_no_short_kernel():
    model = fb.planar("R" * 70)
    with pytest.raises(
        FreebodyError, match="mass_matrix of 70 coordinates is computed column by column"
    ):
        fb.kernel(model, "mass_matrix", dtype="float32")
