"""The interpreter's own way into a kernel: plain single samples take it, everything else comes out
the same.

Which way a call took cannot be seen in its result, so the general way is replaced by what tells.
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import ShapeError
from freebody.kernels.parameter_inputs import InputKernel
from freebody.math import sin
from freebody.program import Argument, trace
from freebody.targets import Kernel, KernelError, compile_program, settings
from freebody.targets.call_errors import BatchError
from freebody.targets.llvm import fastcall


@pytest.fixture(scope="module", params=["on", "off"])
def kernel(request):
    """A kernel with the fast call, and one without: whatever is asked of it, they answer the
    same."""
    program = trace(
        "both",
        lambda q, A: ([q[0] * A[0][1], sin(q[1])], [[x * q[0] for x in row] for row in A]),
        [Argument("q", (2,)), Argument("A", (2, 3))],
        [Argument("y", (2,)), Argument("B", (2, 3))],
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settings, "FASTCALL", request.param == "on")
        if request.param == "on" and not fastcall.available():
            pytest.skip("this interpreter's objects are not laid out as the fast call expects")
        return compile_program(program, target="cpu")


def test_the_environment_switches_it_off(monkeypatch):
    program = trace(
        "switched", lambda q: ([q[0] + 1.0],), [Argument("q", (1,))], [Argument("y", (1,))]
    )
    monkeypatch.setattr(settings, "FASTCALL", False)
    without = compile_program(program, target="cpu")
    assert without.__call__.__func__ is Kernel.__call__
    assert without(np.array([1.0]))[0] == 2.0
    monkeypatch.undo()
    if fastcall.available():
        within = compile_program(program, target="cpu")
        assert isinstance(within.__call__, types.BuiltinMethodType)
        assert within(np.array([1.0]))[0] == 2.0


OF_ALL_WAYS = [
    "compiler/test_pickling.py",
    "compiler/test_forks_and_interrupts.py",
    "compiler/test_kernels.py",
    "laws/test_numerics_errors.py",
]


@pytest.mark.long
@pytest.mark.parametrize("file", OF_ALL_WAYS)
def test_the_suite_passes_without_it(file):
    """Files that call kernels in every way."""
    here = Path(__file__).parents[1]
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-x",
            "-n0",
            "-p",
            "no:cacheprovider",
            str(here / file),
        ],
        env={**os.environ, "FREEBODY_FASTCALL": "off"},
        cwd=here.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-3000:]


Q = np.array([0.5, -1.25])
A = np.arange(6.0).reshape(2, 3)


def test_the_fast_way_gives_the_bits_of_the_ufunc(kernel):
    for fast, slow in zip(kernel(Q, A), kernel.ufunc(Q, A), strict=True):
        assert type(fast) is np.ndarray
        assert fast.flags.owndata
        assert fast.flags.writeable
        assert fast.shape == slow.shape
        assert fast.tobytes() == slow.tobytes()


@pytest.mark.parametrize(
    ("q", "a"),
    [
        (list(Q), A),
        (tuple(Q), A.tolist()),
        (Q.astype(np.float32), A),
        (np.array([1, 2]), A),
        (Q.astype(">f8"), A),
        (np.stack([Q, Q])[:, ::1][0][::-1][::-1], A),
        (np.repeat(Q, 2)[::2], A),
        (Q, np.asfortranarray(A)),
        (np.frombuffer(b"\0" + Q.tobytes(), dtype=np.uint8)[1:].view(np.float64), A),
        (Q.view(np.recarray), A),
        (np.stack([Q, 2 * Q]), A),
        (Q, np.stack([A, A, A])),
    ],
)
def test_anything_else_goes_the_general_way(kernel, q, a):
    for given, expected in zip(
        kernel(q, a), kernel.ufunc(np.array(q, float), np.array(a, float)), strict=True
    ):
        np.testing.assert_array_equal(given, expected)


def test_out_is_written_and_returned(kernel):
    out = (np.empty(2), np.empty((2, 3)))
    returned = kernel(Q, A, out=out)
    assert returned[0] is out[0]
    assert returned[1] is out[1]
    for written, expected in zip(out, kernel(Q, A), strict=True):
        assert written.tobytes() == expected.tobytes()
    np.testing.assert_array_equal(kernel(Q, A, threads=1)[0], out[0])
    before = sys.getrefcount(out), sys.getrefcount(Q)
    for _ in range(100):
        kernel(Q, A, out=out)
    after = sys.getrefcount(out), sys.getrefcount(Q)
    assert after == before


def test_out_of_plain_arrays_never_leaves_the_interpreters_own_way(monkeypatch):
    """A loop that runs a thousand times a second writes to its own arrays; the general way takes
    four times as long."""
    program = trace(
        "squared", lambda q: ([q[0] * q[0]],), [Argument("q", (1,))], [Argument("y", (1,))]
    )
    if not fastcall.available():
        pytest.skip("this interpreter's objects are not laid out as the fast call expects")
    general = []
    monkeypatch.setattr(Kernel, "__call__", lambda *given, **named: general.append(named))
    square, out = compile_program(program, target="cpu"), np.empty(1)
    assert square(np.array([3.0]), out=out) is out
    assert out[0] == 9.0
    assert general == []
    square(np.array([3.0]), out=np.empty((1, 1)))
    square(np.array([3.0]), out=out, threads=1)
    square(out, out=out)
    assert len(general) == 3


def test_numbers_of_python_go_the_quick_way(monkeypatch):
    """A gain or a step's length: NumPy takes 4 microseconds to make two arrays of them."""
    program = trace(
        "scaled",
        lambda q, a, b: ([a * q[0] + b, sin(b)],),
        [Argument("q", (1,)), Argument("a", ()), Argument("b", ())],
        [Argument("y", (2,))],
    )
    if not fastcall.available():
        pytest.skip("this interpreter's objects are not laid out as the fast call expects")
    general = []
    whole = Kernel.__call__

    def counted(self, *given, **named):
        general.append(given)
        return whole(self, *given, **named)

    monkeypatch.setattr(Kernel, "__call__", counted)
    scaled, q, out = compile_program(program, target="cpu"), np.array([3.0]), np.empty(2)
    expected = scaled.ufunc(q, 2.5, -0.1)
    a, b = 2.5, float("-0.1")
    before = sys.getrefcount(b)
    for given in ((a, b), (np.array(a), b), (a, np.array(b))):
        assert scaled(q, *given).tobytes() == expected.tobytes()
        assert scaled(q, *given, out=out).tobytes() == expected.tobytes()
    assert sys.getrefcount(b) <= before + 1  # of the tuples above
    assert np.isnan(scaled(q, float("nan"), b)).all()
    assert general == []
    for other in (2, True, np.float64(2.0), np.float32(2.0), np.array([[2.0]])):
        np.testing.assert_array_equal(scaled(q, other, b), scaled.ufunc(q, np.float64(other), b))
    assert len(general) == 5
    single = compile_program(program, target="cpu", dtype="float32")
    np.testing.assert_allclose(single(q.astype(np.float32), 2.5, -0.1), expected, rtol=1e-6)


BUFFER = np.zeros(16)


@pytest.mark.parametrize(
    "out",
    [
        (np.empty(2), np.empty((3, 2)).T),
        (np.empty(4)[::2], np.empty((2, 3))),
        (BUFFER[1:3], BUFFER[5:11].reshape(2, 3)),
        (BUFFER[4:6], BUFFER[5:11].reshape(2, 3)),  # overlap each other, and both the input
        (np.empty((1, 2)), np.empty((1, 2, 3))),
    ],
)
def test_out_of_any_other_kind_comes_out_as_the_ufunc_writes_it(kernel, out):
    q, expected = BUFFER[4:6], tuple(x.copy() for x in out)
    BUFFER[:] = np.linspace(0.1, 1.0, 16)
    if not np.may_share_memory(*out):
        expected = kernel.ufunc(q.copy(), A)
    else:
        kernel.ufunc(q, A, out=out)
        expected = tuple(x.copy() for x in out)
        BUFFER[:] = np.linspace(0.1, 1.0, 16)
    kernel(q, A, out=out)
    for written, value in zip(out, expected, strict=True):
        np.testing.assert_array_equal(written, np.broadcast_to(value, written.shape))


@pytest.mark.parametrize(
    "out",
    [
        np.empty(2),
        (np.empty(2),),
        [np.empty(2), np.empty((2, 3))],
        (np.empty(2), None, None),
        (np.empty(3), np.empty((2, 3))),
        (np.empty(2, dtype=int), np.empty((2, 3))),
        (np.frombuffer(bytes(16)), np.empty((2, 3))),  # not to be written
    ],
)
def test_out_that_does_not_fit_is_refused(kernel, out):
    with pytest.raises((TypeError, ValueError)):
        kernel(Q, A, out=out)


def test_a_sample_that_is_not_finite_is_nan_throughout(kernel):
    for bad in (np.nan, np.inf, -np.inf):
        y, B = kernel(np.array([0.5, bad]), A)
        assert np.isnan(y).all()
        assert np.isnan(B).all()


def test_errors_are_those_of_the_kernel(kernel):
    with pytest.raises(ShapeError, match=r"both: q has shape \(3,\), expected \(..., 2\)"):
        kernel(np.zeros(3), A)
    with pytest.raises(ShapeError, match=r"both: A has shape \(3, 2\), expected \(..., 2, 3\)"):
        kernel(Q, A.T.copy())
    with pytest.raises(
        KernelError, match=r"both: 1 arguments given, expected 2: q\(2\), A\(2, 3\)"
    ):
        kernel(Q)
    with pytest.raises(KernelError, match="holds complex numbers, expected real"):
        kernel(Q.astype(complex), A)
    with pytest.raises(KernelError, match="3 arguments given, expected 2"):
        kernel(Q, A, np.empty(2))  # NumPy would write to it
    with pytest.raises(BatchError):
        kernel(np.ones((3, 2)), np.ones((4, 2, 3)))


def test_nothing_leaks(kernel):
    q, a = Q.copy(), A.copy()
    before = sys.getrefcount(q), sys.getrefcount(a), sys.getrefcount(q.dtype)
    for _ in range(1000):
        y, B = kernel(q, a)
    assert (sys.getrefcount(q), sys.getrefcount(a)) == before[:2]
    assert abs(sys.getrefcount(q.dtype) - before[2]) < 50
    assert sys.getrefcount(y) == 2  # the variable and the argument
    del y, B
    gc.collect()
    import tracemalloc

    tracemalloc.start()
    kernel(q, a)
    start = tracemalloc.get_traced_memory()[0]
    for _ in range(1000):
        kernel(q, a)
    assert tracemalloc.get_traced_memory()[0] - start < 10_000
    tracemalloc.stop()


def of(function, inputs, outputs, dtype="float64"):
    """A kernel with the quick way."""
    if not fastcall.available():
        pytest.skip("this interpreter's objects are not laid out as the fast call expects")
    arguments = [
        [Argument(name, shape) for name, shape in some.items()] for some in (inputs, outputs)
    ]
    return compile_program(trace("quick", function, *arguments), target="cpu", dtype=dtype)


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_one_number_comes_out_as_numpys_own(monkeypatch, dtype):
    """An energy: without a function of its own it took ten times as long as Pinocchio's."""
    kernel = of(
        lambda q: (q[0] * q[1], [q[0]], sin(q[0])),
        {"q": (2,)},
        {"T": (), "y": (1,), "V": ()},
        dtype,
    )
    q = np.array([0.5, 3.0], dtype=dtype)
    expected = kernel.ufunc(q)
    monkeypatch.setattr(Kernel, "__call__", lambda *given, **named: pytest.fail("the general way"))
    for given, ufuncs in zip(kernel(q), expected, strict=True):
        assert type(given) is type(ufuncs)
        assert given.tobytes() == ufuncs.tobytes()
    outs = np.empty((), dtype), np.empty(1, dtype), np.empty((), dtype)
    assert kernel(q, out=outs) is outs
    assert [x.tobytes() for x in outs] == [x.tobytes() for x in expected]
    before = sys.getrefcount(q.dtype)
    for _ in range(1000):
        kernel(q)
    assert abs(sys.getrefcount(q.dtype) - before) < 50


def test_a_function_holds_the_last_argument():
    kernel = of(lambda q, p: ([q[0] * p[0], p[1]],), {"q": (1,), "p": (2,)}, {"y": (2,)})
    q, p, general = np.array([3.0]), np.array([2.0, 5.0]), []
    held = kernel.quick(lambda *given, **named: general.append((given, named)), p)
    for given in ((q,), (q, p)):
        assert held(*given).tolist() == [6.0, 5.0]
        out = np.empty(2)
        assert held(*given, out=out) is out
        assert out.tolist() == [6.0, 5.0]
    assert held(q, 2 * p).tolist() == [12.0, 10.0]
    assert general == []
    held(q, p=p)
    held([3.0])
    held()
    kernel.quick(lambda *given, **named: general.append((given, named)))(q)
    kernel.quick(lambda *given, **named: general.append((given, named)), p[:1])(q)
    assert [len(given) for given, _ in general] == [1, 1, 0, 1, 1]
    before = sys.getrefcount(p)
    for _ in range(100):
        held(q)
    assert sys.getrefcount(p) == before
    del held
    assert sys.getrefcount(p) == before - 1


@pytest.mark.sample(6)
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("size", [1, 7, 8, 9, 16, 21])
def test_a_checked_call_sees_every_entry_that_is_not_finite(size, dtype):
    kernel = of(lambda q: ([x * x for x in q],), {"q": (size,)}, {"y": (size,)}, dtype)
    checked = kernel.quick_checked(lambda q: None)
    q = np.ones(size, dtype)
    assert checked(q).tolist() == q.tolist()
    for k in range(size):
        large = q.copy()
        large[k] = np.sqrt(np.finfo(dtype).max) * 2
        assert checked(large) is None


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_a_checked_call_sees_what_is_not_of_unit_length(dtype):
    kernel = of(lambda q, r: ([q[0] + r[0]],), {"q": (5,), "r": (9,)}, {"y": (1,)}, dtype)
    checked = kernel.quick_checked(lambda q, r: None, units=[(0, 1), (1, 0), (1, 5)])
    q, r = np.zeros(5, dtype), np.zeros(9, dtype)
    q[2] = r[3] = 1.0
    r[5:] = 0.5, -0.5, 0.5, 0.5
    assert checked(q, r).tolist() == [0.0]
    for array, k in ((q, 2), (r, 3), (r, 8)):
        for off in (2.0, 1.0 + 1e-5, 1.0 - 1e-5, np.nan):
            kept, array[k] = array[k], array[k] * off
            assert checked(q, r) is None
            array[k] = kept
        array[k] = array[k] * (1.0 + 2e-7)
        assert checked(q, r) is not None
    q[0] = r[4] = 100.0
    assert checked(q, r) is not None


# ---------------------------------------------------------------- short batches
def _several(count: int, dtype: str) -> Kernel:
    """One of its own, of no other test that counts."""
    return of(
        lambda q, a, A: (
            [q[0] * A[0][1] + a, sin(q[1])],
            q[0] * q[1] * a,
            [[x * q[0] for x in row] for row in A],
            sin(q[0]) + float(count),
        ),
        {"q": (2,), "a": (), "A": (2, 3)},
        {"y": (2,), "E": (), "B": (2, 3), "s": ()},
        dtype,
    )


@pytest.mark.sample(3)
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("count", [1, 2, 7, 16, 33])
def test_a_short_batch_goes_the_quick_way_whatever_is_common_to_it(monkeypatch, count, dtype):
    """(1, n), the shape of every control loop, took eight times as long as (n,)."""
    general = []
    monkeypatch.setattr(Kernel, "__call__", lambda *given, **named: general.append(given))
    kernel, rng = _several(count, dtype), np.random.default_rng(count)
    shapes = (2,), (), (2, 3)
    for mask in range(1, 8):
        batched = [bool(mask & 1 << k) for k in range(3)]
        given = [
            np.asarray(rng.normal(size=(count, *shape) if rows else shape)).astype(dtype)
            for rows, shape in zip(batched, shapes, strict=True)
        ]
        before = [sys.getrefcount(x) for x in given]
        found, expected = kernel(*given), kernel.ufunc(*given)
        for one, other in zip(found, expected, strict=True):
            assert type(one) is np.ndarray
            assert one.flags.owndata
            assert one.shape == other.shape
            assert one.tobytes() == other.tobytes()
            assert sys.getrefcount(one) == sys.getrefcount(other)
        out = tuple(np.empty_like(x) for x in expected)
        assert kernel(*given, out=out) is out
        assert [x.tobytes() for x in out] == [x.tobytes() for x in expected]
        assert [sys.getrefcount(x) for x in given] == before
    assert general == []
    q, a, A = (np.ones((count, *shape), dtype) for shape in shapes)
    other = np.ones((count + 1, 2), dtype)
    for given in (
        (other, a, A), (q[None], a, A), (q[:0], a[:0], A[:0]),
        (q, a, np.ones((count, 3, 2), dtype)),
        (np.asfortranarray(q) if count > 1 else q[None], a, A),
    ):  # fmt: skip
        kernel(*given)
    kernel(q, a, A, out=tuple(x[:1] for x in out) if count > 1 else tuple(x[0] for x in out))
    kernel(q[0], a[0], A[0], out=out)
    assert len(general) == 7


def test_what_lies_where_a_result_is_written_goes_the_general_way(monkeypatch):
    general = []
    monkeypatch.setattr(Kernel, "__call__", lambda *given, **named: general.append(given))
    kernel = of(lambda q: ([3.0 * q[0]],), {"q": (1,)}, {"y": (1,)})
    room = np.arange(8.0).reshape(8, 1)
    assert kernel(room[:4], out=room[4:])[3, 0] == 9.0
    assert general == []
    kernel(room[:4], out=room[3:7])
    assert len(general) == 1


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_a_checked_batch_is_seen_to_its_last_entry(dtype):
    kernel = of(
        lambda q: ([q[0] * q[0], q[1]], q[2] * q[2]), {"q": (7,)}, {"y": (2,), "E": ()}, dtype
    )
    checked = kernel.quick_checked(lambda q: None, units=[(0, 3)])
    q = np.zeros((5, 7), dtype)
    q[:, 4] = 1.0
    assert checked(q)[0].shape == (5, 2)
    for row in range(5):
        for entry, value in ((0, np.sqrt(np.finfo(dtype).max) * 2), (2, np.inf), (4, 1.01)):
            wrong = q.copy()
            wrong[row, entry] = value
            assert checked(wrong) is None, (row, entry)


@pytest.mark.sample(3)
@pytest.mark.parametrize("batch", [(), (1,), (7,), (300,), (40_000,), (2, 3)])
def test_other_numbers_answer_as_their_copies_in_float64(batch: tuple[int, ...]):
    """Lists, whole numbers, float32 and arrays with gaps: bit for bit, in float64, whatever was
    called before."""
    model = fb.load("ur5e")
    state = [x.reshape(*batch, 6) for x in fb.random_state(model, 3, int(np.prod(batch)))]
    narrow = [np.round(64.0 * x).astype(np.float32) / 64 for x in state]
    whole = [np.round(3.0 * x).astype(np.int64) for x in state]
    gaps = [np.repeat(x, 2, axis=-1)[..., ::2] for x in state]
    others = [narrow, whole, gaps] + ([[x.tolist() for x in state]] if len(batch) < 2 else [])
    for given in others:
        copies = [np.array(x, dtype=float) for x in given]
        for function in (fb.inverse_dynamics, fb.forward_dynamics, fb.inverse_dynamics_derivatives):
            expected = _outputs(function(model, *copies))
            mixed = function(model, given[0], *copies[1:])
            for found in (_outputs(function(model, *given)), _outputs(mixed)):
                for x, y in zip(found, expected, strict=True):
                    assert x.dtype == np.float64
                    np.testing.assert_array_equal(x, y)


def _outputs(found: np.ndarray | tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    return found if isinstance(found, tuple) else (found,)


def test_a_long_batch_is_shared_among_threads_as_before(monkeypatch):
    general = []
    monkeypatch.setattr(Kernel, "__call__", lambda *given, **named: general.append(given))
    kernel = of(lambda q: ([q[0] + q[0]],), {"q": (1,)}, {"y": (1,)})
    kernel(np.ones((kernel.few, 1)))
    assert general == []
    kernel(np.ones((kernel.few + 1, 1)))
    assert len(general) == 1


def test_a_kernel_is_still_a_kernel(kernel):
    from freebody.targets import Kernel

    assert isinstance(kernel, Kernel)
    assert "both" in repr(kernel)


@pytest.mark.skipif(
    not sys.platform.startswith("linux"),
    reason="freed memory is overwritten by glibc's MALLOC_PERTURB_",
)
def test_a_process_with_kernels_ends_in_peace():
    """What kernels point to must outlive them to the very end of the interpreter."""
    text = "import freebody as fb; k = fb.kernel(fb.load('2R'), 'mass_matrix'); k([0.1, 0.2])"
    env = {**os.environ, "PYTHONMALLOC": "malloc", "MALLOC_PERTURB_": "165"}
    done = subprocess.run(
        [sys.executable, "-c", text], env=env, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_plain_arrays_with_numbers_go_to_the_compiled_function_itself():
    kernel = fb.kernel(fb.load("2R"), "inverse_dynamics", inputs=["m1"])
    if kernel.kernel.target != "cpu" or not fastcall.available():
        pytest.skip("no C function here")
    assert type(kernel.__call__) is type(kernel.kernel.__call__) is types.BuiltinFunctionType


def test_without_p_the_compiled_function_takes_the_models_own_numbers(monkeypatch):
    kernel, q = (
        fb.kernel(fb.load("2R"), "gravity_torque", inputs=["m1", "m2"]),
        np.array([0.3, -0.4]),
    )
    if kernel.kernel.target != "cpu" or not fastcall.available():
        pytest.skip("no C function here")
    expected = kernel(q, kernel.values)
    monkeypatch.setattr(InputKernel, "numbers", lambda *_: pytest.fail("the general way"))
    assert kernel(q).tobytes() == expected.tobytes()
    out = np.empty(2)
    assert kernel(q, out=out) is out
    assert out.tobytes() == expected.tobytes()
