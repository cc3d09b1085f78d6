"""Kernels of every target against plain floats, and what NumPy promises of a generalized ufunc;
what a target is: a record that a table names.

A made-up target is put into the table and asked as the others are. How the text for LLVM is laid
out changes no bit of a result; no option chooses it, so the emitter is patched.
"""

from __future__ import annotations

import ctypes
import importlib.util
import mmap
import os
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest

import freebody as fb
from freebody import ShapeError
from freebody.math import cos, sin, sqrt
from freebody.program.segments import LONGEST, segment
from freebody.targets import TARGETS, Kernel, KernelError, kernel, settings
from freebody.targets.llvm import emit
from freebody.targets.target import Target, target_named
from support.child_process import environment
from support.every_target import every_target
from support.programs import (
    OUTPUTS,
    assert_close,
    direct,
    random_kernel,
    same_bits,
    samples,
    swap_kernel,
)

pytestmark = pytest.mark.usefixtures("memory_only")


@pytest.mark.sample(4)
@every_target
@pytest.mark.parametrize("seed", range(6))
def test_kernels_agree_with_floats(target, width, seed):
    compiled = random_kernel(seed, target=target, width=width)
    assert compiled.target == target
    assert compiled.width == (width or 1)
    for batch in (0, 1, 2, 7, 8, 9, 100):
        arrays = samples(batch, seed)
        assert_close(compiled(*arrays), direct(seed, arrays))
    arrays = samples(4097, seed)
    assert_close(compiled(*arrays), direct(seed, arrays))


@every_target
def test_single_samples_and_more_axes(target, width):
    compiled = random_kernel(1, target=target, width=width)
    x, A, s = (a[0] for a in samples(1))
    y, B, t = compiled(x, A, s)
    assert (y.shape, B.shape, t.shape) == ((4,), (3, 3), ())
    assert_close(compiled(x.tolist(), A.tolist(), float(s)), (y, B, np.asarray(t)))
    x, A, s = samples((4, 3))
    arrays = x, A[:, :1], s[2]
    assert_close(compiled(*arrays), direct(1, arrays))
    assert compiled(x[:0], A[0], s[0])[1].shape == (0, 3, 3, 3)


LAYOUTS = {
    "rows": lambda a: a,
    "columns": lambda a: np.ascontiguousarray(np.moveaxis(a, 0, -1)).transpose(
        -1, *range(a.ndim - 1)
    ),
    "reversed": lambda a: a[::-1].copy()[::-1],
    "every other": lambda a: np.repeat(a, 2, axis=0)[::2],
    "padded rows": lambda a: (
        np.concatenate([a, a], axis=-1)[..., : a.shape[-1]] if a.ndim > 1 else a
    ),
    "strided core": lambda a: np.repeat(a, 3, axis=-1)[..., ::3] if a.ndim > 1 else a,
    "reversed core": lambda a: a[..., ::-1].copy()[..., ::-1] if a.ndim > 1 else a,
    "fortran core": lambda a: (
        np.swapaxes(np.swapaxes(a, -1, -2).copy(), -1, -2) if a.ndim > 2 else a
    ),
    "misaligned": lambda a: (
        np.frombuffer(b"?" + a.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(a.shape)
    ),
    "read-only": lambda a: np.frombuffer(a.tobytes()).reshape(a.shape),
    "big-endian": lambda a: a.astype(">f8"),
}


@every_target
@pytest.mark.parametrize("layout", LAYOUTS)
def test_any_strides(target, width, layout):
    compiled = random_kernel(2, target=target, width=width)
    for batch in (1, 5, 29):
        arrays = samples(batch, 5)
        expected = compiled(*arrays)
        changed = [LAYOUTS[layout](a) for a in arrays]
        assert all(np.array_equal(a, b) for a, b in zip(arrays, changed, strict=True))
        assert same_bits(compiled(*changed), expected)
        outs = (
            tuple(LAYOUTS[layout](np.zeros_like(e)) for e in expected)
            if layout not in ("read-only",)
            else None
        )
        if layout not in ("misaligned", "read-only"):
            returned = compiled(*changed, out=outs)
            assert all(r is o for r, o in zip(returned, outs, strict=True))
            assert_close([np.asarray(o, dtype=float) for o in outs], expected)


@every_target
def test_broadcast_inputs(target, width):
    compiled = random_kernel(4, target=target, width=width)
    x, A, s = samples(37, 1)
    for arrays in [
        (x[0], A, s),
        (x, A[0], s),
        (x, A, s[0]),
        (x[:, None], A[:5], s[:5]),
        (x[0], A[0], s),
    ]:
        assert_close(compiled(*arrays), direct(4, arrays))


@pytest.mark.parametrize("width", [2, 4, 8])
def test_nothing_outside_an_array_is_written(width):
    compiled = random_kernel(2, target="cpu", width=width)
    for batch in (1, 5, 8, 13):
        arrays = samples(batch)
        buffers = [np.full((batch + 2, *shape), 7.0) for shape in OUTPUTS.values()]
        compiled(*arrays, out=tuple(b[1:-1] for b in buffers))
        assert all((b[0] == 7.0).all() and (b[-1] == 7.0).all() for b in buffers)
        wide = np.full((batch, 6), 7.0)
        compiled(*arrays, out=(wide[:, 1:5], buffers[1][1:-1], buffers[2][1:-1]))
        assert (wide[:, [0, 5]] == 7.0).all()


@pytest.mark.sample(8)
@pytest.mark.skipif(sys.platform == "win32", reason="mprotect")
@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("size", [1, 3, 5, 6, 7, 8, 9, 13])
def test_nothing_outside_an_array_is_read(width, size):
    compiled = fb.compile(
        lambda q: [2.0 * x for x in q], {"q": size}, {"r": size}, target="cpu", width=width
    )
    page = mmap.PAGESIZE
    memory = mmap.mmap(-1, 3 * page)
    bytes_ = np.frombuffer(memory, dtype=np.uint8)
    start = bytes_.ctypes.data
    libc = ctypes.CDLL(None)
    for guard in (start, start + 2 * page):
        assert libc.mprotect(ctypes.c_void_p(guard), ctypes.c_size_t(page), 0) == 0
    inside = bytes_[page : 2 * page].view(np.float64)
    for batch in (1, 3, 8, 11):
        for part in (inside[: batch * size], inside[inside.size - batch * size :]):
            q = part.reshape(batch, size)
            q[...] = np.arange(batch * size).reshape(batch, size)
            np.testing.assert_array_equal(
                compiled(q), 2.0 * np.arange(batch * size).reshape(batch, size)
            )
            compiled(q, out=q)
    for guard in (start, start + 2 * page):
        libc.mprotect(ctypes.c_void_p(guard), ctypes.c_size_t(page), 3)


@every_target
def test_output_over_input(target, width):
    compiled = swap_kernel(target=target, width=width)
    for batch in (1, 3, 8, 100):
        for shift in (-4, -3, -1, 0, 1, 3, 4):
            buffer = np.random.default_rng(batch).normal(size=3 * batch + 16)
            q, r = (buffer[at : at + 3 * batch].reshape(batch, 3) for at in (8, 8 + shift))
            expected = compiled(q.copy())
            compiled(q, out=r)
            np.testing.assert_array_equal(r, expected)
            q[...] = 1.0


@every_target
def test_every_batch_split_gives_the_same_bits(target, width):
    if not target_named(target).loops:
        pytest.skip("NumPy's own loops differ between body and tail")
    compiled = random_kernel(5, target=target, width=width)
    arrays = samples(203, 9)
    arrays[0][50] = 1e7  # the slow path of sine and cosine beside the fast one
    whole = compiled(*arrays)
    for size in (1, 3, 8, 64, 100):
        parts = [compiled(*(a[i : i + size] for a in arrays)) for i in range(0, 203, size)]
        assert same_bits(tuple(np.concatenate(p) for p in zip(*parts, strict=True)), whole)
    order = np.random.default_rng(0).permutation(203)
    assert same_bits(compiled(*(a[order] for a in arrays)), tuple(w[order] for w in whole))


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(4))
def test_every_width_gives_the_same_to_rounding(seed):
    arrays = samples(19, seed)
    narrow, *wider = (random_kernel(seed, width=width)(*arrays) for width in (2, 4, 8))
    for results in wider:
        for found, expected in zip(results, narrow, strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


WAYS_IN = {
    "rows": lambda a: a,
    "columns": np.asfortranarray,
    "strided": lambda a: np.repeat(a, 2, axis=1)[:, ::2],
    "broadcast": lambda a: np.broadcast_to(a[:, None], (a.shape[0], 9, a.shape[1])),
}


@pytest.mark.sample(29)
@pytest.mark.parametrize("way", WAYS_IN)
@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("count", [1, 2, 3, 7, 11, 130])
def test_each_of_many_inputs_is_looked_at_by_itself(count, width, way):
    """Also where numbers overflow together, or cancel: each sample but the last two has one that is
    not finite."""
    compiled = fb.compile(lambda q: [q[0] + 1.0], {"q": count}, {"r": 1}, width=width)
    q = np.ones((count + 2, count))
    q[-2] = 1e200
    q[:, ::3] *= -1.0
    q[np.arange(count), np.arange(count)] = np.where(np.arange(count) % 2, np.nan, np.inf)
    found = compiled(WAYS_IN[way](q)).reshape(count + 2, -1)
    assert np.isnan(found[:-2]).all()
    assert np.array_equal(found[-2:], np.repeat([[1.0 - 1e200], [0.0]], found.shape[1], axis=1))


@every_target
def test_wrong_arguments_are_named(target, width):
    compiled = random_kernel(0, target=target, width=width)
    x, A, s = samples(4)
    cases = [
        ((x[:, :2], A, s), ShapeError, r"random0: x has shape \(4, 2\), expected \(\.\.\., 3\)\."),
        (
            (x, A[..., 0], s),
            ShapeError,
            r"random0: A has shape \(4, 2\), expected \(\.\.\., 2, 5\)\.",
        ),
        ((1.0, A, s), ShapeError, r"random0: x has shape \(\), expected \(\.\.\., 3\)\."),
        (
            (x, A),
            fb.FreebodyError,
            r"random0: 2 arguments given, expected 3: x\(3\), A\(2, 5\), s\(\)\.",
        ),
        ((), fb.FreebodyError, r"random0: 0 arguments given, expected 3"),
        (
            (x + 0j, A, s),
            fb.FreebodyError,
            r"random0: x holds complex numbers, expected real numbers; .real has",
        ),
        (
            (x.astype(object), A, s),
            fb.FreebodyError,
            r"random0: x holds objects, expected real numbers; convert",
        ),
        ((x.astype(str), A, s), fb.FreebodyError, r"x holds text, expected"),
        (
            (x, A[:3], s),
            fb.FreebodyError,
            r"batch shapes do not broadcast together: x \(4,\), A \(3,\), s \(4,\)",
        ),
    ]
    for arrays, error, message in cases:
        for threads in (None, 2):
            with pytest.raises(error, match=message):
                compiled(*arrays, threads=threads)


@every_target
def test_integers_and_float32_are_converted(target, width):
    compiled = swap_kernel(target=target, width=width)
    for kind in (np.int64, np.int8, np.uint16, np.float32, np.bool_):
        q = np.array([[0, 1, 1], [1, 0, 1]], dtype=kind)
        np.testing.assert_array_equal(compiled(q), [[1.0, 0.0, 1.0], [0.0, 2.0, 1.0]])


@every_target
def test_out_of_the_wrong_shape_is_refused(target, width):
    compiled = swap_kernel(target=target, width=width)
    for shape in ((4, 2), (3, 3), (3,)):
        with pytest.raises(ValueError):
            compiled(np.ones((4, 3)), out=np.empty(shape))
        with pytest.raises(ValueError):
            compiled(np.ones((4, 3)), out=np.empty(shape), threads=2)


def test_options_are_checked(monkeypatch):
    with pytest.raises(
        fb.FreebodyError,
        match=rf"no target 'fortran'\. Targets: {', '.join(TARGETS)} \(argument or FREEBODY_TARG",
    ):
        swap_kernel(target="fortran")
    with pytest.raises(
        fb.FreebodyError,
        match=r"no width 3 of float64\. Widths: 2, 4, 8 \(argument or FREEBODY_WIDTH\)",
    ):
        swap_kernel(width=3)
    with pytest.raises(
        fb.FreebodyError, match=r"width=4: target 'numpy' has no vectors; leave it out\."
    ):
        swap_kernel(target="numpy", width=4)
    for threads in (0, -1, 1.5):
        with pytest.raises(
            fb.FreebodyError, match=f"threads={threads}, expected a whole number from 1 up"
        ):
            swap_kernel()(np.ones(3), threads=threads)
    monkeypatch.setattr(settings, "TARGET", "numpy")
    assert swap_kernel().target == "numpy"
    monkeypatch.setattr(settings, "TARGET", "cpu")
    monkeypatch.setattr(settings, "WIDTH", "2")
    assert swap_kernel().width == 2
    monkeypatch.setattr(settings, "WIDTH", "many")
    with pytest.raises(fb.FreebodyError, match="no width many of float64"):
        swap_kernel()


def test_the_environment_counts_as_it_was_at_first(monkeypatch):
    """What answers must not depend on what was called before the environment was changed."""
    before = swap_kernel()
    monkeypatch.setenv("FREEBODY_TARGET", "fortran")
    monkeypatch.setenv("FREEBODY_WIDTH", "many")
    assert swap_kernel() is before


def test_a_kernel_is_a_gufunc_that_can_be_read():
    compiled = random_kernel(0, target="cpu", width=4)
    assert isinstance(compiled.ufunc, np.ufunc)
    assert compiled.ufunc.signature == compiled.signature == "(3),(2,5),()->(4),(3,3),()"
    assert compiled.ufunc.__name__ == "random0"
    assert "define void @kernel" in compiled.source
    assert random_kernel(0, target="numpy").source.startswith("random0: x(3), A(2, 5), s() ->")
    assert random_kernel(0, target="cpu", width=4) is compiled
    assert "random0: x(3), A(2, 5), s()" in repr(compiled)


@every_target
def test_empty_arguments(target, width):
    halves = fb.compile(
        lambda q, x: ((), x[0] * 2.0), {"q": 0, "x": 1}, {"r": 0, "y": ()}, target=target
    )
    r, y = halves(np.empty((3, 1, 0)), np.ones((4, 1)))
    assert r.shape == (3, 4, 0)
    np.testing.assert_array_equal(y, np.full((3, 4), 2.0))
    constant = fb.compile(lambda: [1.0, 2.0], {}, {"r": (2,)}, target=target)
    np.testing.assert_array_equal(constant(), [1.0, 2.0])
    assert constant.target == ("numpy" if target_named(target).host else target)
    only = fb.compile(lambda q: (), {"q": (0,)}, {"r": (0,)}, target=target)
    assert only(np.empty((5, 0))).shape == (5, 0)


@every_target
def test_outputs_that_are_inputs_and_constants(target, width):
    def function(q):
        return [q[1], 0.0, sin(q[0]), -sin(q[0]), q[1], -2.5, cos(q[0])]

    compiled = fb.compile(function, {"q": 2}, {"r": 7}, target=target, width=width)
    q = np.random.default_rng(0).normal(size=(19, 2))
    s, c, one = np.sin(q[:, 0]), np.cos(q[:, 0]), np.ones(19)
    expected = np.stack([q[:, 1], 0 * one, s, -s, q[:, 1], -2.5 * one, c], axis=1)
    np.testing.assert_allclose(compiled(q), expected, rtol=1e-14)


@every_target
def test_a_sample_that_is_not_finite_is_nan_and_no_other(target, width):
    def function(x, y):
        return [sin(x[0]), 0.0 * x[1], 3.0, x[2] - x[2]], x[0] * x[2]

    compiled = fb.compile(
        function, {"x": 3, "y": ()}, {"r": 4, "t": ()}, target=target, width=width
    )
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(50, 3)), rng.normal(size=50)
    expected = compiled(x, y)
    bad = {3: (0, np.nan), 4: (1, np.inf), 11: (2, -np.inf), 30: (1, np.nan), 49: (0, -np.inf)}
    for sample, (component, value) in bad.items():
        x[sample, component] = value
    y[20] = np.inf
    r, t = compiled(x, y)
    spoiled = np.isin(np.arange(50), [*bad, 20])
    assert np.isnan(r[spoiled]).all()
    assert np.isnan(t[spoiled]).all()
    assert same_bits((r[~spoiled], t[~spoiled]), tuple(e[~spoiled] for e in expected))


@every_target
def test_no_warnings_from_floating_point_flags(target, width):
    compiled = fb.compile(
        lambda x: (1.0 / x, sqrt(x), x * 1e300),
        {"x": ()},
        dict.fromkeys("abc", ()),
        target=target,
        width=width,
    )
    a, b, c = compiled(np.array([0.0, -1.0, 1e300, np.nan]))
    np.testing.assert_array_equal(a[:2], [np.inf, -1.0])
    assert np.isnan(b[1])
    assert c[2] == np.inf


def test_a_target_is_a_module_and_a_line(monkeypatch):
    """It is found, told its program, width and number type, asked for its text, and found again by
    a pickle."""
    asked = []

    def build(program, width, dtype):
        asked.append((width, dtype))
        return Kernel(program, "halves", width or 6, lambda q: np.asarray(q) / 2, dtype)

    record = Target(
        build=build,
        source=lambda program, width, dtype: f"{program.name} {width} {dtype}",
        widths={"float64": (6, 7), "float16": ()},
        variant=lambda program: os.environ.get("HALVES"),
        loops=False,
    )
    monkeypatch.setitem(TARGETS, "halves", lambda: record)
    first = swap_kernel(target="halves", width=7)
    assert (first.target, first.width, first.dtype, first.source) == (
        "halves",
        7,
        "float64",
        "swap 7 float64",
    )
    assert first(np.ones(3)).tolist() == [0.5, 0.5, 0.5]
    assert pickle.loads(pickle.dumps(first)) is first
    assert asked == [(7, "float64")]
    swap_kernel(target="halves", dtype="float16")
    monkeypatch.setattr(settings, "TARGET", "halves")
    monkeypatch.setattr(settings, "WIDTH", "6")
    assert fb.kernel(fb.load("2R"), "bias").target == "halves"
    monkeypatch.setenv("HALVES", "other")  # what the code depends on is part of its key
    assert swap_kernel(width=7) is not first
    assert asked[1:] == [(None, "float16"), (6, "float64"), (7, "float64")]
    for option, text in (
        ({"width": 4}, "no width 4 of float64. Widths: 6, 7 "),
        ({"dtype": "float32"}, "target 'halves' has no dtype 'float32'. It has: float64, float16."),
    ):
        with pytest.raises(KernelError, match=re.escape(text)):
            swap_kernel(**option)


def test_importing_the_compiler_does_not_import_llvm():
    code = (
        "import sys, freebody.targets; assert not any(m.startswith('llvmlite') for m in "
        "sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


def test_without_llvm_numpy_computes(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert swap_kernel().target == "numpy"


def test_cutting_into_segments_changes_nothing(monkeypatch):
    arrays = samples(20)
    whole = random_kernel(3, 300)(*arrays)
    for longest in (1, 7, 50):
        monkeypatch.setattr(emit, "segment", lambda p, n=longest: segment(p, n))
        monkeypatch.setattr(kernel, "_kernels", {})
        assert_close(random_kernel(3, 300)(*arrays), whole)


def test_one_or_two_groups_a_round_give_the_same_bits(monkeypatch):
    kernels = []
    for tiles in (1, 2):
        monkeypatch.setattr(emit, "_tiles", lambda nodes, room, n=tiles: n)
        monkeypatch.setattr(kernel, "_kernels", {})
        kernels.append(random_kernel(8, width=4))
    for batch in (1, 3, 4, 5, 8, 9, 12, 15, 16, 17, 100):
        x, A, s = samples(batch)
        for arrays in [(x, A, s), (x[0], A, s), (x, A[:, :, ::-1], s[0])]:
            assert same_bits(*(k(*arrays) for k in kernels))
            assert_close(kernels[0](*arrays), direct(8, arrays))


def test_long_programs_run_their_pieces_in_groups(monkeypatch):
    """As a whole and in functions of a few pieces: the same bits."""
    arrays = samples(37, 17)
    whole = random_kernel(17, 4000).ufunc(*arrays)
    monkeypatch.setattr(emit, "PIECES", 3)
    monkeypatch.setattr(kernel, "_kernels", {})
    cut = random_kernel(17, 4000)
    assert "@compute1(" in cut.source
    assert same_bits(cut.ufunc(*arrays), whole)


def test_the_text_grows_with_the_program_and_its_functions_do_not():
    """LLVM takes more than twice as long for a function twice as long: so time stays in proportion
    to the program."""

    def lengths(length):
        compiled = random_kernel(11, length, target="cpu", width=8)
        functions = re.findall(r"^define .*?^}", compiled.source, flags=re.M | re.S)
        return [text.count("\n") for text in functions], sum(compiled.program.operations.values())

    (short, few), (long, many) = lengths(1500), lengths(12000)
    assert many > 4 * few
    assert sum(long) / many < 1.2 * sum(short) / few
    assert max(long + short) < 2 * LONGEST
