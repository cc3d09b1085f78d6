"""Programs, passes and kernels: every emitter against plain floats, and what NumPy promises of a generalized ufunc."""

import dataclasses
import importlib.util
import itertools
import math
import os
import pickle
import re
import stat
import subprocess
import sys
import threading
import time
import types
import weakref
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody.elementary import (
    absolute,
    acos,
    atan2,
    cos,
    exp,
    less,
    less_equal,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tanh,
    where,
)
from freebody.errors import ShapeError
from freebody.program import Argument, Program, ProgramError, passes, trace, verify
from freebody.program.segments import segment
from freebody.targets import TARGETS, Kernel, KernelError, compile_program, kernel
from freebody.targets.llvm import cache, cpu, emit, machine
from freebody.targets.llvm.machine import Machine
from freebody.targets.target import Target, target_named
from freebody.targets.threads import run_split

ON_POSIX = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and modes of files are POSIX")
WAYS = [(name, width) for name in TARGETS for width in target_named(name).widths["float64"] or (None,)]
every_target = pytest.mark.parametrize(("target", "width"), WAYS)


@pytest.fixture(autouse=True)
def memory_only(monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    monkeypatch.delenv("FREEBODY_TARGET", raising=False)
    monkeypatch.delenv("FREEBODY_WIDTH", raising=False)


def random_function(seed, length=60):
    """A function of x (3), A (2, 5) and s () with outputs y (4), B (3, 3), t (), bounded so that errors stay small."""

    def function(x, A, s):
        rng = np.random.default_rng(seed)
        pool = [*x, *A[0], *A[1], s, 0.0, 1.0, -2.5]
        operations = [
            lambda a, b: 0.5 * (a + b),
            lambda a, b: a - 0.7 * b,
            lambda a, b: sin(a) * b,
            lambda a, b: cos(a) * sin(a) - cos(b),
            lambda a, b: a * b / (2.0 + b * b),
            lambda a, b: b / (1.0 + a**2),
            lambda a, b: sqrt(1.0 + a * a),
            lambda a, b: -a,
            lambda a, b: sign(a - b) * 0.5,
            lambda a, b: sin(sin(a + b)),
            lambda a, b: where(less(a, b), a, 0.5 * b),
            lambda a, b: maximum(minimum(a, 0.8), -absolute(b)),
            lambda a, b: atan2(a, 1.5 + sin(b)) * exp(-b * b),
            lambda a, b: tanh(a) + log(1.0 + b * b),
            lambda a, b: acos(a / (1.0 + absolute(a))) - 1.5 * less_equal(b, a),
        ]
        for _ in range(length):
            a, b = (pool[i] for i in rng.integers(len(pool), size=2))
            pool.append(operations[rng.integers(len(operations))](a, b))
        picks = [pool[i] for i in rng.integers(len(pool), size=14)]
        return picks[:4], [picks[4:7], picks[7:10], picks[10:13]], picks[13]

    return function


INPUTS = (Argument("x", (3,)), Argument("A", (2, 5)), Argument("s", ()))
OUTPUTS = (Argument("y", (4,)), Argument("B", (3, 3)), Argument("t", ()))


def random_program(seed, length=60):
    return trace(f"random{seed}", random_function(seed, length), INPUTS, OUTPUTS)


def samples(batch, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.normal(scale=2.0, size=(*np.atleast_1d(batch).astype(int), *i.shape)) for i in INPUTS]


def direct(seed, arrays, length=60):
    """The same function on plain arrays, one column a scalar."""
    x, A, s = arrays
    batch = np.broadcast_shapes(x.shape[:-1], A.shape[:-2], s.shape)
    columns = [x[..., i] for i in range(3)], [[A[..., i, j] for j in range(5)] for i in range(2)], s
    y, B, t = random_function(seed, length)(*columns)

    def stacked(value, shape):
        flat = (
            [np.broadcast_to(v, batch) for v in np.asarray(value, dtype=object).ravel()] if shape else [value]
        )
        return np.stack(flat, axis=-1).reshape(batch + shape)

    y = np.stack([np.broadcast_to(v, batch) for v in y], axis=-1)
    B = np.stack([np.broadcast_to(v, batch) for row in B for v in row], axis=-1).reshape(*batch, 3, 3)
    return y, B, np.broadcast_to(t, batch)


def assert_close(results, expected):
    for result, reference in zip(results, expected, strict=True):
        assert result.shape == reference.shape
        np.testing.assert_allclose(result, reference, rtol=1e-11, atol=1e-11)


def same_bits(left, right):
    left, right = (x if isinstance(x, tuple) else (x,) for x in (left, right))
    return all(
        np.array_equal(np.asarray(x).view(np.int64), np.asarray(y).view(np.int64))
        for x, y in zip(left, right, strict=True)
    )


def swap_program():
    return trace("swap", lambda q: ([q[1], 2.0 * q[0], q[2]],), [Argument("q", (3,))], [Argument("r", (3,))])


# ---------------------------------------------------------------- traces and programs
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
    a, b = swap_program(), swap_program()
    assert a.digest == b.digest
    assert dataclasses.replace(a, constants=(3.0,)).digest != a.digest
    assert dataclasses.replace(a, name="other").digest != a.digest
    chosen = trace("f", lambda q: (where(q[0], q[1], q[2]),), [Argument("q", (3,))], [Argument("r", ())])
    assert dataclasses.replace(chosen, c=tuple(min(k, 1) for k in chosen.c)).digest != chosen.digest


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (lambda x: x[0], r"f: the traced function returned Expr, expected a tuple .*: r\(2\)"),
        (lambda x: (x, x), r"returned 2 values, expected a tuple with one entry for each output: r\(2\)"),
        (lambda x: (x[0],), r"output r\(2\) holds a scalar where a sequence of 2 was expected"),
        (lambda x: ((x[0],) * 3,), r"output r\(2\) holds a tuple of 3 where a sequence of 2"),
        (lambda x: ((x[0], "a"),), r"output r\(2\) holds a str of 1|holds str 'a' where a scalar"),
        (lambda x: ((x[0], x),), r"output r\(2\) holds a tuple of 2 where a scalar was expected"),
        (lambda x: ((x[0], None),), r"output r\(2\) holds NoneType None where a scalar was expected"),
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
        ({"c": (-1, -1, 0)}, r"%2 = add: it has 2 operands, what is left of \(a, b, c\) = \(0, 1, 0\) is -1"),
        ({"b": (-1, -1)}, "op, a, b and c have one entry a node"),
        ({"c": (-1, -1)}, "op, a, b and c have one entry a node"),
        ({"results": (0, 1, 3)}, "a result is a node"),
        ({"results": (0, 1)}, "3 output scalars need as many results"),
        ({"constants": (math.inf,)}, "constants are finite"),
        ({"outputs": ()}, "at least one output"),
        ({"inputs": (Argument("q", (3,)), Argument("q", ()))}, "names of inputs are used once: q, q"),
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


# ---------------------------------------------------------------- passes and segments
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
    single = trace("f", lambda x: ([x[0] / x[2], x[1] / x[0]],), [Argument("x", (3,))], [Argument("y", (2,))])
    assert passes.share_reciprocals(single) is single


def test_the_schedule_keeps_few_values_alive():
    def sums(x):  # made breadth first: all products, then all sums
        products = [a * b for a, b in itertools.combinations(x, 2)]
        while len(products) > 1:
            products = [a + b for a, b in itertools.zip_longest(products[::2], products[1::2], fillvalue=0.0)]
        return (products[0],)

    program = trace("sums", sums, [Argument("x", (20,))], [Argument("y", ())])
    assert most_alive(program) > 90
    assert most_alive(passes.schedule(program)) < 15


def most_alive(program):
    last = {i: k for k in range(len(program)) for i in program.operands(k)}
    alive, most = 0, 0
    for k, op in enumerate(program.op):
        ended = sum(
            last[i] == k and program.op[i] not in ("input", "const") for i in set(program.operands(k))
        )
        alive += (op not in ("input", "const")) - ended
        most = max(most, alive)
    return most


def test_cutting_into_segments_changes_nothing(monkeypatch):
    program, arrays = random_program(3, 300), samples(20)
    whole = compile_program(program)(*arrays)
    for longest in (1, 7, 50):
        monkeypatch.setattr(emit, "segment", lambda p, n=longest: segment(p, n))
        renamed = dataclasses.replace(program, name=f"cut{longest}")
        assert_close(compile_program(renamed)(*arrays), whole)


def test_one_or_two_groups_a_round_give_the_same_bits(monkeypatch):
    program, kernels = random_program(8), []
    for tiles in (1, 2):
        monkeypatch.setattr(emit, "_tiles", lambda nodes, room, n=tiles: n)
        kernels.append(compile_program(dataclasses.replace(program, name=f"tiles{tiles}"), width=4))
    for batch in (1, 3, 4, 5, 8, 9, 12, 15, 16, 17, 100):
        x, A, s = samples(batch)
        for arrays in [(x, A, s), (x[0], A, s), (x, A[:, :, ::-1], s[0])]:
            assert same_bits(*(k(*arrays) for k in kernels))
            assert_close(kernels[0](*arrays), direct(8, arrays))


# ---------------------------------------------------------------- kernels against floats
@every_target
@pytest.mark.parametrize("seed", range(6))
def test_kernels_agree_with_floats(target, width, seed):
    compiled = compile_program(random_program(seed), target=target, width=width)
    assert compiled.target == target
    assert compiled.width == (width or 1)
    for batch in (0, 1, 2, 7, 8, 9, 100):
        arrays = samples(batch, seed)
        assert_close(compiled(*arrays), direct(seed, arrays))
    arrays = samples(4097, seed)
    assert_close(compiled(*arrays), direct(seed, arrays))


@pytest.mark.parametrize("flags", [(True, False, False), (False, True, True), (True, True, True)])
@pytest.mark.parametrize("seed", range(2))
def test_uniform_inputs_change_nothing_but_roundings(seed, flags):
    program = random_program(seed, 80)
    inputs = tuple(
        dataclasses.replace(i, uniform=uniform) for i, uniform in zip(program.inputs, flags, strict=True)
    )
    arrays = [x[0] if uniform else x for x, uniform in zip(samples(21, seed), flags, strict=True)]
    for target, width in (("numpy", None), ("cpu", 8)):
        compiled = compile_program(dataclasses.replace(program, inputs=inputs), target=target, width=width)
        batch = arrays if False in flags else [x[None] for x in arrays]
        assert_close(compiled(*batch), direct(seed, batch, 80))
        assert_close(compiled(*arrays), direct(seed, arrays, 80))


@every_target
def test_single_samples_and_more_axes(target, width):
    compiled = compile_program(random_program(1), target=target, width=width)
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
    "columns": lambda a: np.ascontiguousarray(np.moveaxis(a, 0, -1)).transpose(-1, *range(a.ndim - 1)),
    "reversed": lambda a: a[::-1].copy()[::-1],
    "every other": lambda a: np.repeat(a, 2, axis=0)[::2],
    "padded rows": lambda a: np.concatenate([a, a], axis=-1)[..., : a.shape[-1]] if a.ndim > 1 else a,
    "strided core": lambda a: np.repeat(a, 3, axis=-1)[..., ::3] if a.ndim > 1 else a,
    "reversed core": lambda a: a[..., ::-1].copy()[..., ::-1] if a.ndim > 1 else a,
    "fortran core": lambda a: np.swapaxes(np.swapaxes(a, -1, -2).copy(), -1, -2) if a.ndim > 2 else a,
    "misaligned": lambda a: (
        np.frombuffer(b"?" + a.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(a.shape)
    ),
    "read-only": lambda a: np.frombuffer(a.tobytes()).reshape(a.shape),
    "big-endian": lambda a: a.astype(">f8"),
}


@every_target
@pytest.mark.parametrize("layout", LAYOUTS)
def test_any_strides(target, width, layout):
    compiled = compile_program(random_program(2), target=target, width=width)
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
    compiled = compile_program(random_program(4), target=target, width=width)
    x, A, s = samples(37, 1)
    for arrays in [(x[0], A, s), (x, A[0], s), (x, A, s[0]), (x[:, None], A[:5], s[:5]), (x[0], A[0], s)]:
        assert_close(compiled(*arrays), direct(4, arrays))


@pytest.mark.parametrize("width", [2, 4, 8])
def test_nothing_outside_an_array_is_written(width):
    compiled = compile_program(random_program(2), target="cpu", width=width)
    for batch in (1, 5, 8, 13):
        arrays = samples(batch)
        buffers = [np.full((batch + 2, *o.shape), 7.0) for o in OUTPUTS]
        compiled(*arrays, out=tuple(b[1:-1] for b in buffers))
        assert all((b[0] == 7.0).all() and (b[-1] == 7.0).all() for b in buffers)
        wide = np.full((batch, 6), 7.0)
        compiled(*arrays, out=(wide[:, 1:5], buffers[1][1:-1], buffers[2][1:-1]))
        assert (wide[:, [0, 5]] == 7.0).all()


@pytest.mark.skipif(sys.platform == "win32", reason="mprotect")
@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("size", [1, 3, 5, 6, 7, 8, 9, 13])
def test_nothing_outside_an_array_is_read(width, size):
    import ctypes
    import mmap

    compiled = compile_program(
        trace("edge", lambda q: ([2.0 * x for x in q],), [Argument("q", (size,))], [Argument("r", (size,))]),
        target="cpu",
        width=width,
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
            np.testing.assert_array_equal(compiled(q), 2.0 * np.arange(batch * size).reshape(batch, size))
            compiled(q, out=q)
    for guard in (start, start + 2 * page):
        libc.mprotect(ctypes.c_void_p(guard), ctypes.c_size_t(page), 3)


@every_target
def test_output_over_input(target, width):
    compiled = compile_program(swap_program(), target=target, width=width)
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
    compiled = compile_program(random_program(5), target=target, width=width)
    arrays = samples(203, 9)
    arrays[0][50] = 1e7  # the slow path of sine and cosine beside the fast one
    whole = compiled(*arrays)
    for size in (1, 3, 8, 64, 100):
        parts = [compiled(*(a[i : i + size] for a in arrays)) for i in range(0, 203, size)]
        assert same_bits(tuple(np.concatenate(p) for p in zip(*parts, strict=True)), whole)
    order = np.random.default_rng(0).permutation(203)
    assert same_bits(compiled(*(a[order] for a in arrays)), tuple(w[order] for w in whole))


@pytest.mark.parametrize("seed", range(4))
def test_every_width_gives_the_same_to_rounding(seed):
    arrays = samples(19, seed)
    narrow, *wider = (compile_program(random_program(seed), width=width)(*arrays) for width in (2, 4, 8))
    for results in wider:
        for found, expected in zip(results, narrow, strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_long_programs_run_their_pieces_in_groups(monkeypatch):
    """As a whole and in functions of a few pieces: the same bits."""
    program, arrays = random_program(17, 4000), samples(37, 17)
    whole = compile_program(program).ufunc(*arrays)
    monkeypatch.setattr(emit, "PIECES", 3)
    monkeypatch.setattr(kernel, "_kernels", {})
    cut = compile_program(program)
    assert "@compute1(" in cut.source
    assert same_bits(cut.ufunc(*arrays), whole)


WAYS_IN = {
    "rows": lambda a: a,
    "columns": np.asfortranarray,
    "strided": lambda a: np.repeat(a, 2, axis=1)[:, ::2],
    "broadcast": lambda a: np.broadcast_to(a[:, None], (a.shape[0], 9, a.shape[1])),
}


@pytest.mark.parametrize("way", WAYS_IN)
@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("count", [1, 2, 3, 7, 11, 130])
def test_each_of_many_inputs_is_looked_at_by_itself(count, width, way):
    """Also where numbers overflow together, or cancel: each sample but the last two has one that is not finite."""
    program = trace("few", lambda q: ([q[0] + 1.0],), [Argument("q", (count,))], [Argument("r", (1,))])
    compiled = compile_program(program, width=width)
    q = np.ones((count + 2, count))
    q[-2] = 1e200
    q[:, ::3] *= -1.0
    q[np.arange(count), np.arange(count)] = np.where(np.arange(count) % 2, np.nan, np.inf)
    found = compiled(WAYS_IN[way](q)).reshape(count + 2, -1)
    assert np.isnan(found[:-2]).all()
    assert np.array_equal(found[-2:], np.repeat([[1.0 - 1e200], [0.0]], found.shape[1], axis=1))


@pytest.mark.parametrize("threads", [1, 2, 3, 7, None])
def test_threads_change_nothing(threads):
    compiled = compile_program(random_program(5))
    arrays = samples(1001, 9)
    whole = compiled.ufunc(*arrays)
    assert same_bits(compiled(*arrays, threads=threads), whole)
    outs = tuple(np.zeros_like(w) for w in whole)
    returned = compiled(*arrays, out=outs, threads=threads)
    assert all(r is o for r, o in zip(returned, outs, strict=True))
    assert same_bits(outs, whole)
    x, A, s = arrays
    mixed = x[None, :7], A[:300, None], s[0]
    assert same_bits(compiled(*mixed, threads=threads), compiled.ufunc(*mixed))
    single = tuple(a[0] for a in arrays)
    assert same_bits(compiled(*single, threads=threads), compiled.ufunc(*single))


def test_large_batches_are_shared_by_default(monkeypatch):
    parts = []
    compiled = compile_program(swap_program())
    monkeypatch.setattr(kernel, "run_split", lambda *a: parts.append(a[-2]))
    monkeypatch.setattr(kernel, "cpus", lambda: 4)
    compiled(np.ones((100, 3)))
    assert parts == []
    compiled(np.zeros((20_000_000 // 3, 3)))
    assert parts == [3]


def test_threads_with_out_over_input():
    compiled = compile_program(swap_program())
    q = np.random.default_rng(0).normal(size=(1000, 3))
    expected = compiled(q)
    compiled(q, out=q, threads=4)
    np.testing.assert_array_equal(q, expected)


@pytest.mark.parametrize("count", [1, 15, 16, 17, 100, 1001, 100_000])
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_every_sample_is_in_one_part(count, threads):
    hits, parts = np.zeros((count, 1)), []

    def ufunc(x, out):
        parts.append(len(x))
        out[0][:] += x

    run_split(ufunc, [np.ones((count, 1))], [hits], [1, 1], (count,), threads)
    assert (hits == 1.0).all()
    assert sum(parts) == count
    assert len(parts) <= 3 * threads


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
@pytest.mark.parametrize("where", [0, 500, 999])
def test_what_a_part_raises_is_raised_when_all_are_done(error, where):
    finished = np.zeros(1000, dtype=bool)

    def ufunc(x, out):
        time.sleep(0.01)
        if where in x:
            raise error
        finished[x.astype(int)] = True

    x = np.arange(1000.0)
    for _ in range(2):  # the helpers are there afterwards
        with pytest.raises(error):
            run_split(ufunc, [x], [x.copy()], [0, 0], (1000,), 2)
    assert finished.sum() < 1000
    assert finished.any() or error is KeyboardInterrupt  # what nobody has begun is dropped


def test_several_callers_at_once_and_nothing_is_kept():
    compiled = compile_program(random_program(5))
    arrays = samples(3001, 9)
    whole, wrong = compiled.ufunc(*arrays), []

    def call():
        wrong.extend(not same_bits(compiled(*arrays, threads=3), whole) for _ in range(50))

    callers = [threading.Thread(target=call) for _ in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert len(wrong) == 200
    assert not any(wrong)
    q = np.ones((1000, 3))
    kept = weakref.ref(q)
    compile_program(swap_program())(q, threads=2)
    del q
    deadline = time.monotonic() + 10.0  # a helper lets go when its thread comes to it
    while kept() is not None:
        assert time.monotonic() < deadline
        time.sleep(0.001)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
def test_threads_work_in_a_forked_child():
    code = """
import os, numpy as np, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # fork beside threads is what is tested
from freebody.program import Argument, trace
from freebody.targets import compile_program
k = compile_program(trace("f", lambda q: ([2.0 * q[0]],), [Argument("q", (1,))], [Argument("r", (1,))]))
q = np.ones((5000, 1))
k(q, threads=4)
child = os.fork()
if child == 0:
    os._exit(0 if (k(q, threads=4) == 2.0).all() else 1)
assert os.waitpid(child, 0)[1] == 0
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_child_forked_during_a_compilation_can_compile():
    code = """
import os, sys, threading, warnings
import numpy as np
warnings.simplefilter("ignore", DeprecationWarning)  # fork beside threads is what is tested
from freebody.program import Argument, trace
from freebody.targets import compile_program
def program(n):
    def function(q):
        x = q[0]
        for _ in range(n):
            x = x * q[0] + 1.0
        return ([x],)
    return trace(f"f{n}", function, [Argument("q", (1,))], [Argument("r", (1,))])
ready = [program(n) for n in range(300, 330)]
work = threading.Thread(target=lambda: [compile_program(p) for p in ready])
work.start()
while work.is_alive():
    child = os.fork()
    if child == 0:
        os._exit(0 if compile_program(program(2))(np.ones((1, 1))) == 3.0 else 1)
    assert os.waitpid(child, 0)[1] == 0
work.join()
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


def test_the_gil_is_released():
    compiled = compile_program(random_program(0, 4000))
    arrays = samples(100_000)
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        while not ticks:
            time.sleep(0.001)
        before = time.perf_counter()
        compiled.ufunc(*arrays)
        after = time.perf_counter()
    finally:
        stop.set()
        thread.join()
    assert sum(before < t < after for t in ticks) > 2, (after - before, len(ticks))


# ---------------------------------------------------------------- refusals
@every_target
def test_wrong_arguments_are_named(target, width):
    compiled = compile_program(random_program(0), target=target, width=width)
    x, A, s = samples(4)
    cases = [
        ((x[:, :2], A, s), ShapeError, r"random0: x has shape \(4, 2\), expected \(\.\.\., 3\)\."),
        ((x, A[..., 0], s), ShapeError, r"random0: A has shape \(4, 2\), expected \(\.\.\., 2, 5\)\."),
        ((1.0, A, s), ShapeError, r"random0: x has shape \(\), expected \(\.\.\., 3\)\."),
        ((x, A), KernelError, r"random0: 2 arguments given, expected 3: x\(3\), A\(2, 5\), s\(\)\."),
        ((), KernelError, r"random0: 0 arguments given, expected 3"),
        ((x + 0j, A, s), KernelError, r"random0: x holds complex128 values, expected real numbers\."),
        ((x.astype(object), A, s), KernelError, r"random0: x holds object values, expected real numbers\."),
        ((x.astype(str), A, s), KernelError, r"x holds <U\d+ values"),
        (
            (x, A[:3], s),
            kernel.BatchError,
            r"batch shapes do not broadcast together: x \(4,\), A \(3,\), s \(4,\)",
        ),
    ]
    for arrays, error, message in cases:
        for threads in (None, 2):
            with pytest.raises(error, match=message):
                compiled(*arrays, threads=threads)


@every_target
def test_integers_and_float32_are_converted(target, width):
    compiled = compile_program(swap_program(), target=target, width=width)
    for kind in (np.int64, np.int8, np.uint16, np.float32, np.bool_):
        q = np.array([[0, 1, 1], [1, 0, 1]], dtype=kind)
        np.testing.assert_array_equal(compiled(q), [[1.0, 0.0, 1.0], [0.0, 2.0, 1.0]])


@every_target
def test_out_of_the_wrong_shape_is_refused(target, width):
    compiled = compile_program(swap_program(), target=target, width=width)
    for shape in ((4, 2), (3, 3), (3,)):
        with pytest.raises(ValueError):
            compiled(np.ones((4, 3)), out=np.empty(shape))
        with pytest.raises(ValueError):
            compiled(np.ones((4, 3)), out=np.empty(shape), threads=2)


def test_options_are_checked(monkeypatch):
    program = swap_program()
    with pytest.raises(
        KernelError, match=r"no target 'fortran'\. Targets: cpu, numpy \(argument or FREEBODY_TARG"
    ):
        compile_program(program, target="fortran")
    with pytest.raises(
        KernelError, match=r"no width 3 of float64\. Widths: 2, 4, 8 \(argument or FREEBODY_WIDTH\)"
    ):
        compile_program(program, width=3)
    with pytest.raises(KernelError, match=r"width=4: target 'numpy' has no vectors; leave it out\."):
        compile_program(program, target="numpy", width=4)
    for threads in (0, -1, 1.5):
        with pytest.raises(KernelError, match=f"threads={threads}, expected a whole number from 1 up"):
            compile_program(program)(np.ones(3), threads=threads)
    monkeypatch.setenv("FREEBODY_TARGET", "numpy")
    assert compile_program(program).target == "numpy"
    monkeypatch.setenv("FREEBODY_TARGET", "cpu")
    monkeypatch.setenv("FREEBODY_WIDTH", "2")
    assert compile_program(program).width == 2
    monkeypatch.setenv("FREEBODY_WIDTH", "many")
    with pytest.raises(KernelError, match="no width many of float64"):
        compile_program(program)


def test_a_kernel_is_a_gufunc_that_can_be_read():
    compiled = compile_program(random_program(0), target="cpu", width=4)
    assert isinstance(compiled.ufunc, np.ufunc)
    assert compiled.ufunc.signature == compiled.signature == "(3),(2,5),()->(4),(3,3),()"
    assert compiled.ufunc.__name__ == "random0"
    assert "define void @kernel" in compiled.source
    assert compile_program(random_program(0), target="numpy").source.startswith(
        "random0: x(3), A(2, 5), s() ->"
    )
    assert compile_program(random_program(0), target="cpu", width=4) is compiled
    assert "random0: x(3), A(2, 5), s()" in repr(compiled)


@pytest.mark.parametrize("target", ["cpu", "numpy"])
def test_empty_arguments(target):
    nothing = Argument("q", (0,))
    program = trace(
        "f",
        lambda q, x: ((), x[0] * 2.0),
        [nothing, Argument("x", (1,))],
        [Argument("r", (0,)), Argument("y", ())],
    )
    r, y = compile_program(program, target=target)(np.empty((3, 1, 0)), np.ones((4, 1)))
    assert r.shape == (3, 4, 0)
    np.testing.assert_array_equal(y, np.full((3, 4), 2.0))
    constant = compile_program(trace("c", lambda: ([1.0, 2.0],), [], [Argument("r", (2,))]), target=target)
    np.testing.assert_array_equal(constant(), [1.0, 2.0])
    only = compile_program(trace("n", lambda q: ((),), [nothing], [Argument("r", (0,))]), target=target)
    assert only(np.empty((5, 0))).shape == (5, 0)


@every_target
def test_outputs_that_are_inputs_and_constants(target, width):
    program = trace(
        "f",
        lambda q: ([q[1], 0.0, sin(q[0]), -sin(q[0]), q[1], -2.5, cos(q[0])],),
        [Argument("q", (2,))],
        [Argument("r", (7,))],
    )
    q = np.random.default_rng(0).normal(size=(19, 2))
    s, c, one = np.sin(q[:, 0]), np.cos(q[:, 0]), np.ones(19)
    expected = np.stack([q[:, 1], 0 * one, s, -s, q[:, 1], -2.5 * one, c], axis=1)
    np.testing.assert_allclose(compile_program(program, target=target, width=width)(q), expected, rtol=1e-14)


# ---------------------------------------------------------------- NaN and infinity
@every_target
def test_a_sample_that_is_not_finite_is_nan_and_no_other(target, width):
    program = trace(
        "f",
        lambda x, y: ([sin(x[0]), 0.0 * x[1], 3.0, x[2] - x[2]], x[0] * x[2]),
        [Argument("x", (3,)), Argument("y", ())],
        [Argument("r", (4,)), Argument("t", ())],
    )
    compiled = compile_program(program, target=target, width=width)
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
    program = trace(
        "f", lambda x: (1.0 / x, sqrt(x), x * 1e300), [Argument("x", ())], [Argument(n, ()) for n in "abc"]
    )
    compiled = compile_program(program, target=target, width=width)
    a, b, c = compiled(np.array([0.0, -1.0, 1e300, np.nan]))
    np.testing.assert_array_equal(a[:2], [np.inf, -1.0])
    assert np.isnan(b[1])
    assert c[2] == np.inf


# ---------------------------------------------------------------- sine and cosine
BITS = 1400  # fixed point: 1024 bits for the largest double, the rest for its smallest sine


def _arctangent_of_inverse(n):
    power = (1 << BITS) // n
    total, k = power, 3
    while power:
        power //= -n * n
        total, k = total + power // k, k + 2
    return total


HALF_PI = 8 * _arctangent_of_inverse(5) - 2 * _arctangent_of_inverse(239)


def exact_sine_and_cosine(x):
    """Sine and cosine of a double as fractions, by integer arithmetic."""
    fixed = int(Fraction(x) * 2**BITS)
    turns = (2 * fixed + HALF_PI) // (2 * HALF_PI)
    r = fixed - turns * HALF_PI
    terms, k = [1 << BITS], 1
    while terms[-1]:
        terms.append((terms[-1] * r >> BITS) // k)
        k += 1
        if terms[-1] == -1:
            break
    c = sum(t * (-1) ** (i // 2) for i, t in enumerate(terms) if i % 2 == 0)
    s = sum(t * (-1) ** (i // 2) for i, t in enumerate(terms) if i % 2 == 1)
    s, c = {0: (s, c), 1: (c, -s), 2: (-s, -c), 3: (-c, s)}[turns % 4]
    return Fraction(s, 2**BITS), Fraction(c, 2**BITS)


def ulps(value, exact):
    return abs(Fraction(float(value)) - exact) / Fraction(math.ulp(float(exact)))


def both(width):
    program = trace(
        "both", lambda x: (sin(x), cos(x)), [Argument("x", ())], [Argument("s", ()), Argument("c", ())]
    )
    return compile_program(program, target="cpu", width=width)


@pytest.mark.parametrize("width", [2, 4, 8])
def test_sine_and_cosine_within_two_ulp(width):
    rng = np.random.default_rng(1)
    halves = np.arange(1, 63662, 97) * (math.pi / 2)  # where cancellation is worst
    x = np.concatenate(
        [
            rng.uniform(-1e5, 1e5, 400),
            rng.uniform(-4, 4, 400),
            halves[:600],
            np.nextafter(halves[:200], 0.0),
            np.arange(-40, 40) * (math.pi / 4),
            10.0 ** rng.uniform(-310, 5, 100),
            [1e-300, 5e-324, 1e5, -1e5, 99999.99999999999, 0.7853981633974483, 0.785398163397448],
        ]
    )
    for value, s, c in zip(x, *both(width)(x), strict=True):
        sine, cosine = exact_sine_and_cosine(value)
        assert ulps(s, sine) <= 2, value
        assert ulps(c, cosine) <= 2, value


@pytest.mark.parametrize("width", [2, 4, 8])
def test_sine_and_cosine_of_large_arguments(width):
    rng = np.random.default_rng(2)
    x = np.concatenate(
        [
            [
                1e5 * (1 + 1e-15),
                1e15,
                -1e15,
                1e16,
                1e100,
                1e300,
                -sys.float_info.max,
                6381956970095103 * 2.0**797,
            ],
            10.0 ** rng.uniform(5, 308, 200),
        ]
    )
    x = np.stack([x, rng.uniform(-3, 3, len(x))], axis=1).ravel()  # large and small in one vector
    for value, s, c in zip(x, *both(width)(x), strict=True):
        sine, cosine = exact_sine_and_cosine(value)
        assert ulps(s, sine) <= 4, value
        assert ulps(c, cosine) <= 4, value


def test_sine_keeps_the_sign_of_zero():
    s, c = both(8)(np.array([0.0, -0.0, -5e-324]))
    assert np.signbit(s).tolist() == [False, True, True]
    assert c.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("width", [2, 4, 8])
def test_overflow_before_a_sine_is_nan(width):
    program = trace(
        "f", lambda x: (sin(x * x), cos(x * x)), [Argument("x", ())], [Argument("s", ()), Argument("c", ())]
    )
    s, c = compile_program(program, target="cpu", width=width)(np.array([1e200, 1.0]))
    assert np.isnan([s[0], c[0]]).all()
    assert np.isfinite([s[1], c[1]]).all()


def test_without_fused_multiply_add(monkeypatch):
    monkeypatch.setattr(machine.Host, "machine", lambda self, width, real: Machine(4, False, self.x86, real))
    program = trace(
        "bare", lambda x: (sin(x), cos(x)), [Argument("x", ())], [Argument("s", ()), Argument("c", ())]
    )
    compiled = compile_program(program, target="cpu", width=4)
    assert "@llvm.fma.v4f64(<4 x double> %" not in compiled.source
    rng = np.random.default_rng(3)
    halves = np.arange(1, 63662, 211) * (math.pi / 2)
    x = np.concatenate([rng.uniform(-1e5, 1e5, 300), halves, [-0.0, 1e-300, 1e15]])
    for value, s, c in zip(x, *compiled(x), strict=True):
        sine, cosine = exact_sine_and_cosine(value)
        assert ulps(s, sine) <= 2, value
        assert ulps(c, cosine) <= 2, value


# ---------------------------------------------------------------- the cache on disk
@pytest.fixture
def store(tmp_path, monkeypatch):
    """A folder for the cache, and programs that no other test has compiled."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("FREEBODY_CACHE", str(folder))
    return folder


def compile_again(monkeypatch):
    """Compile as a new process would; whether LLVM had to work."""
    worked = []
    original = machine.object_code
    for k in range(kernel.RECENT):  # others push it out of the kernels that are kept
        compile_program(dataclasses.replace(swap_program(), name=f"other{k}"), target="numpy")
    monkeypatch.setattr(cpu, "object_code", lambda text: worked.append(1) or original(text))
    result = compile_program(swap_program(), target="cpu")(np.array([1.0, 2.0, 3.0]))
    monkeypatch.setattr(cpu, "object_code", original)
    assert result.tolist() == [2.0, 2.0, 3.0]
    return bool(worked)


def test_the_second_process_finds_the_object(store, monkeypatch):
    assert compile_again(monkeypatch)
    (entry,) = store.iterdir()
    assert entry.suffix == ".o"
    if hasattr(os, "geteuid"):
        assert stat.S_IMODE(store.stat().st_mode) == 0o700
        assert stat.S_IMODE(entry.stat().st_mode) == 0o600
    assert not compile_again(monkeypatch)


def test_off_means_off(store, monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    assert compile_again(monkeypatch)
    assert compile_again(monkeypatch)
    assert not store.exists()


@pytest.mark.parametrize(
    "damage",
    [
        lambda entry: b"",
        lambda entry: entry[:-1],
        lambda entry: entry[:20],
        lambda entry: entry + b"\0",
        lambda entry: entry[:200] + bytes([entry[200] ^ 1]) + entry[201:],
        lambda entry: b"something else entirely",
    ],
)
def test_a_damaged_entry_is_compiled_anew(store, monkeypatch, damage):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.write_bytes(damage(entry.read_bytes()))
    assert compile_again(monkeypatch)
    assert not compile_again(monkeypatch)


def test_an_entry_under_another_name_is_not_believed(store, monkeypatch):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    os.replace(entry, store / f"{'0' * 64}.o")
    assert cache.load("0" * 64) is None


@ON_POSIX
@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_an_entry_that_others_may_write_is_not_believed(store, monkeypatch, mode):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.chmod(mode)
    assert compile_again(monkeypatch)
    assert not compile_again(monkeypatch)


@ON_POSIX
@pytest.mark.parametrize("mode", [0o720, 0o777])
def test_a_folder_that_others_may_write_is_not_used(store, monkeypatch, mode):
    compile_again(monkeypatch)
    store.chmod(mode)
    assert compile_again(monkeypatch)
    assert compile_again(monkeypatch)


@ON_POSIX
def test_an_owner_other_than_this_user_is_not_believed(store, monkeypatch):
    compile_again(monkeypatch)
    monkeypatch.setattr(cache.os, "geteuid", lambda: os.getuid() + 1)
    assert compile_again(monkeypatch)


@ON_POSIX
def test_links_are_not_followed(store, monkeypatch, tmp_path):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    os.replace(entry, tmp_path / "elsewhere.o")
    entry.symlink_to(tmp_path / "elsewhere.o")
    assert compile_again(monkeypatch)
    assert not entry.is_symlink()  # replaced by a file of our own
    link = tmp_path / "link"
    link.symlink_to(store)
    monkeypatch.setenv("FREEBODY_CACHE", str(link))
    assert compile_again(monkeypatch)


@ON_POSIX
def test_a_pipe_or_folder_in_the_place_of_an_entry(store, monkeypatch):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.unlink()
    os.mkfifo(entry)
    assert compile_again(monkeypatch)
    assert not compile_again(monkeypatch)
    entry.unlink()
    entry.mkdir()
    assert compile_again(monkeypatch)


def test_a_folder_that_cannot_be_made(store, monkeypatch):
    store.write_text("a file in the way")
    assert compile_again(monkeypatch)
    monkeypatch.setenv("FREEBODY_CACHE", str(store / "below"))
    assert compile_again(monkeypatch)
    monkeypatch.setenv("FREEBODY_CACHE", "")
    for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(cache.Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    assert cache.folder() is None
    assert compile_again(monkeypatch)


@ON_POSIX
def test_a_read_only_folder(store, monkeypatch):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.unlink()
    real = os.open

    def denied(path, flags, *rest, **kw):  # root may write anywhere: modes alone would not tell
        if flags & os.O_CREAT:
            raise PermissionError(13, "denied")
        return real(path, flags, *rest, **kw)

    monkeypatch.setattr(cache.os, "open", denied)
    assert compile_again(monkeypatch)
    assert list(store.iterdir()) == []


def test_the_oldest_entries_make_room(store, monkeypatch):
    monkeypatch.setattr(cache, "LIMIT", 3500)
    for k in range(5):
        cache.store(f"{k}" * 64, bytes(1000))
        os.utime(store / f"{f'{k}' * 64}.o", (k, k))
        if k == 2:
            assert cache.load("0" * 64) == bytes(1000)  # of use: now the youngest
    assert sorted(p.name[0] for p in store.iterdir()) == ["0", "3", "4"]


def test_what_a_killed_process_left_is_removed(store):
    cache.store("a" * 64, b"code")
    old, new = store / f".{'b' * 64}.1.00", store / f".{'c' * 64}.2.00"
    for path in (old, new):
        path.write_bytes(b"half")
    os.utime(old, (0, 0))
    cache.store("d" * 64, b"code")
    assert not old.exists()
    assert new.exists()


def test_the_default_folder(monkeypatch):
    monkeypatch.delenv("FREEBODY_CACHE")
    monkeypatch.setattr(cache.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert cache.folder() == cache.Path("/somewhere/freebody")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative is ignored")
    monkeypatch.setattr(cache.Path, "home", lambda: cache.Path("/home/me"))
    assert cache.folder() == cache.Path("/home/me/.cache/freebody")
    monkeypatch.setattr(cache.sys, "platform", "darwin")
    assert cache.folder() == cache.Path("/home/me/Library/Caches/freebody")


def environment():
    return {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}


CHILD = """
import sys, numpy as np
from freebody.program import Argument, trace
from freebody.targets import compile_program
from freebody.targets.llvm import cpu
from freebody.elementary import sin
if len(sys.argv) > 1:
    def refuse(text): raise AssertionError("compiled again")
    cpu.object_code = refuse
k = compile_program(trace("child", lambda q: ([sin(q[0]) * q[1], q[0]],), [Argument("q", (2,))], [Argument("r", (2,))]))
print(k(np.random.default_rng(0).normal(size=(11, 2)) * [1e7, 1.0]).tobytes().hex())
"""


def test_processes_share_objects(store):
    def start(*arguments):
        return subprocess.Popen(
            [sys.executable, "-c", CHILD, *arguments], stdout=subprocess.PIPE, env=environment(), text=True
        )

    both_at_once = [start(), start()]
    printed = {process.communicate(timeout=60)[0] for process in both_at_once}
    assert [process.returncode for process in both_at_once] == [0, 0]
    later = start("must load")
    printed.add(later.communicate(timeout=60)[0])
    assert later.returncode == 0
    assert len(printed) == 1
    assert len(list(store.iterdir())) == 1


def test_a_target_is_a_module_and_a_line(monkeypatch):
    """It is found, told its program, width and number type, asked for its text, and found again by a pickle."""
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
    monkeypatch.setitem(sys.modules, "halves", types.SimpleNamespace(TARGET=record))
    monkeypatch.setitem(TARGETS, "halves", "halves")
    first = compile_program(swap_program(), target="halves", width=7)
    assert (first.target, first.width, first.dtype, first.source) == (
        "halves",
        7,
        "float64",
        "swap 7 float64",
    )
    assert first(np.ones(3)).tolist() == [0.5, 0.5, 0.5]
    assert pickle.loads(pickle.dumps(first)) is first
    assert asked == [(7, "float64")]
    compile_program(swap_program(), target="halves", dtype="float16")
    monkeypatch.setenv("FREEBODY_TARGET", "halves")
    monkeypatch.setenv("FREEBODY_WIDTH", "6")
    assert fb.kernel(fb.load("2R"), "bias").target == "halves"
    monkeypatch.setenv("HALVES", "other")  # what the code depends on is part of its key
    assert compile_program(swap_program(), width=7) is not first
    assert asked[1:] == [(None, "float16"), (6, "float64"), (7, "float64")]
    for option, text in (
        ({"width": 4}, "no width 4 of float64. Widths: 6, 7 "),
        ({"dtype": "float32"}, "Known: float64, float16"),
    ):
        with pytest.raises(KernelError, match=re.escape(text)):
            compile_program(swap_program(), **option)


def test_importing_the_compiler_does_not_import_llvm():
    code = "import sys, freebody.targets; assert not any(m.startswith('llvmlite') for m in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


def test_without_llvm_numpy_computes(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert compile_program(swap_program()).target == "numpy"


def test_compile_time_is_near_linear():
    def seconds(length):
        program = dataclasses.replace(random_program(11, length), name=f"long{length}")
        start = time.perf_counter()
        compile_program(program, target="cpu")
        return time.perf_counter() - start, sum(program.operations.values())

    seconds(100)
    (short, few), (long, many) = seconds(1500), seconds(12000)
    assert long / short < 3 * many / few
