"""Kernels on a GPU: skipped where there is none, but for the run on an emulated driver that
test_cuda.py starts.

On a machine with a GPU: `pytest -n0 tests/ways_out/test_cuda_device.py
tests/core/compiler/test_kernels.py tests/core/compiler/test_operations.py`.
"""

from __future__ import annotations

import gc
import pickle
import sys
import weakref

import numpy as np
import pytest

import freebody as fb
from freebody import ShapeError
from freebody.program import Argument, trace
from freebody.targets import KernelError, compile_program, settings
from freebody.targets.call_errors import BatchError
from freebody.targets.cuda import driver
from freebody.targets.cuda.driver import GpuError, missing
from freebody.targets.cuda.gpu_arrays import DeviceArray

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())

EMULATED = "support.emulated" in sys.modules


class Owned:
    """An array on the GPU with strides of any kind, as Numba has them."""

    def __init__(self, values: np.ndarray, readonly: bool = False):
        """values: a view, whose whole memory is copied as it lies there."""
        whole = values
        while isinstance(whole.base, np.ndarray):
            whole = whole.base
        self.values, self.whole = values, whole
        with driver.current(0):
            self.memory = driver.Memory(whole.nbytes, 0, driver.DEFAULT_STREAM)
            driver.call(
                "cuMemcpyHtoDAsync", self.memory.address, whole.ctypes.data, whole.nbytes, 1
            )
            driver.call("cuStreamSynchronize", 1)
        self.shape, self.dtype = values.shape, values.dtype
        self.__cuda_array_interface__ = {
            "shape": values.shape,
            "typestr": values.dtype.str,
            "data": (self.memory.address + values.ctypes.data - whole.ctypes.data, readonly),
            "strides": values.strides,
            "version": 3,
            "stream": 1,
        }

    def numpy(self) -> np.ndarray:
        """What is there now, as `values` has it; what lies between is in `whole`."""
        with driver.current(0):
            driver.call(
                "cuMemcpyDtoHAsync",
                self.whole.ctypes.data,
                self.memory.address,
                self.whole.nbytes,
                1,
            )
            driver.call("cuStreamSynchronize", 1)
        return self.values


def state(batch: tuple[int, ...], n: int = 6, seed: int = 0) -> list[np.ndarray]:
    return list(np.random.default_rng(seed).normal(size=(3, *batch, n)))


def pair(model: fb.Model, quantity: str, **options: object) -> tuple[object, object]:
    return tuple(fb.kernel(model, quantity, target=target, **options) for target in ("cuda", "cpu"))


def close(found: object, expected: object, allowed: float = 1e-13) -> None:
    found, expected = (x if isinstance(x, tuple) else (x,) for x in (found, expected))
    for x, y in zip(found, expected, strict=True):
        x = x.numpy() if hasattr(x, "numpy") else np.asarray(x)
        assert x.shape == y.shape
        assert x.dtype == y.dtype
        np.testing.assert_allclose(x, y, rtol=0, atol=allowed * (np.abs(y).max(initial=0.0) or 1.0))


@pytest.fixture(scope="module")
def arm() -> fb.Model:
    return fb.load("ur5e")


@pytest.fixture(scope="module")
def kernels(arm):
    return pair(arm, "inverse_dynamics")


@pytest.mark.sample(5)
@pytest.mark.parametrize(
    ("robot", "quantity"),
    [
        ("ur5e", "inverse_dynamics"),
        ("ur5e", "forward_dynamics"),
        ("ur5e", "inverse_dynamics_derivatives"),
        ("panda", "forward_dynamics"),
        ("panda", "inverse_dynamics_derivatives"),
        ("stewart", "constraint_jacobian"),
    ],
)
@pytest.mark.parametrize(("dtype", "allowed"), [("float64", 1e-13), ("float32", 2e-5)])
def test_numbers_agree_with_the_cpu(robot, quantity, dtype, allowed):
    model = fb.load(robot)
    here, there = pair(model, quantity, dtype=dtype)
    rng = np.random.default_rng(0)
    arrays = [0.3 * rng.normal(size=(300, *a.shape)).astype(dtype) for a in there.program.inputs]
    expected = there(*arrays)
    close(here(*arrays), expected, allowed)
    close(here(*map(Owned, arrays)), expected, allowed)


@pytest.mark.parametrize("batch", [(), (0,), (1,), (129,), (3, 4), (2, 0, 3)])
def test_batches_of_any_shape(kernels, batch):
    here, there = kernels
    arrays = state(batch)
    close(here(*arrays), there(*arrays))
    close(here(*map(Owned, arrays)), there(*arrays))


def test_batches_broadcast(kernels):
    here, there = kernels
    q, qd, qdd = state((3, 4, 5))
    arrays = [q[:, :1, :], qd[0, :, :1], qdd[0, 0, 0]]
    close(here(*arrays), there(*arrays))
    close(here(*map(Owned, arrays)), there(*arrays))


def test_rows_columns_gaps_and_backwards(kernels):
    here, there = kernels
    whole = np.random.default_rng(1).normal(size=(3, 12, 80))
    ways = [
        np.ascontiguousarray(whole[0, :6].T),
        whole[1, :6].T,
        whole[2, ::2, ::2].T,
        whole[0, 5::-1, ::-1].T,
    ]
    for k, q in enumerate(ways):
        qd, qdd = (ways[(k + j) % 4][:40] for j in (1, 2))
        arrays = [q[:40], qd, qdd]
        close(here(*map(Owned, arrays)), there(*arrays))


def test_results_go_where_they_are_wanted_and_nowhere_else(kernels):
    here, there = kernels
    arrays = state((33,))
    room = np.full((8, 100), 7.0)
    out = Owned(room[1:7, 20:53].T)
    assert here(*map(Owned, arrays), out=out) is out
    close(out, there(*arrays))
    out.values[...] = 7.0
    assert (room == 7.0).all()
    mine = np.zeros((33, 6))
    assert here(*arrays, out=mine) is mine
    close(mine, there(*arrays))


def test_what_is_written_over_is_read_before(kernels):
    here, there = kernels
    arrays = state((20,))
    given = [Owned(x) for x in arrays]
    expected = there(*arrays)
    here(*given, out=given[2])
    close(given[2], expected)
    room = np.random.default_rng(2).normal(size=(21, 6))
    before, after = room[:20].copy(), Owned(room)
    moved = Owned(room[1:])
    moved.memory, moved.whole = after.memory, after.whole
    moved.__cuda_array_interface__["data"] = (after.memory.address + 48, False)
    first = Owned(room[:20])
    first.__cuda_array_interface__["data"] = (after.memory.address, False)
    here(first, *given[:2], out=moved)
    close(moved, there(before, *arrays[:2]))


def test_numbers_of_the_robot(arm):
    here, there = pair(arm, "forward_dynamics", inputs=["payload.mass", "*.mass", "gravity"])
    arrays = state((70,))
    close(here(*arrays), there(*arrays))
    close(here(*arrays, p={"payload.mass": 3.0}), there(*arrays, p={"payload.mass": 3.0}))
    each = there.numbers({"payload.mass": np.linspace(0.0, 5.0, 70)})
    close(here(*arrays, p=each), there(*arrays, p=each))
    on_gpu = [*map(Owned, arrays)]
    close(here(*on_gpu, p={"payload.mass": 3.0}), there(*arrays, p={"payload.mass": 3.0}))
    close(here(*on_gpu, Owned(each)), there(*arrays, each))
    close(here(*on_gpu, Owned(np.repeat(each[3], 2)[::2])), there(*arrays, each[3]))
    nan = here(*arrays, p={"payload.mass": np.nan})
    assert np.isnan(nan).all()


def test_a_sample_that_is_not_finite_is_nan_alone(kernels):
    here, there = kernels
    arrays = state((9,))
    arrays[1][4, 2] = np.inf
    found, expected = here(*arrays), there(*arrays)
    assert np.isnan(found[4]).all()
    close(np.delete(found, 4, 0), np.delete(expected, 4, 0))


def test_a_stream_takes_the_work_and_may_be_of_any_library(kernels):
    here, there = kernels
    arrays = state((50,))
    given = [*map(Owned, arrays)]
    with driver.current(0):
        made = 7 if EMULATED else int(driver.call("cuStreamCreate", 1))
    for stream in (
        made,
        type("Stream", (), {"cuda_stream": made})(),
        type("Stream", (), {"ptr": made})(),
    ):
        result = here(*given, stream=stream)
        assert result.__cuda_array_interface__["stream"] == made
        close(result, there(*arrays))
    with pytest.raises(GpuError, match=r"stream='x' is not a stream"):
        here(*given, stream="x")


def test_a_result_is_the_next_input(arm, kernels):
    arrays = state((40,))
    tau = kernels[0](*map(Owned, arrays))
    assert isinstance(tau, DeviceArray)
    forward, on_cpu = pair(arm, "forward_dynamics")
    close(forward(*map(Owned, arrays[:2]), tau), arrays[2], 1e-9)
    assert on_cpu(*arrays[:2], tau.numpy()).shape == (40, 6)


def test_memory_goes_with_the_result(kernels):
    here, _ = kernels
    result = here(*map(Owned, state((5,))))
    memory = weakref.ref(result._memory)
    del result
    gc.collect()
    assert memory() is None


def test_a_pickle_is_the_same_kernel(kernels):
    here, there = kernels
    again = pickle.loads(pickle.dumps(here))
    assert (again.target, again.dtype) == ("cuda", np.float64)
    close(again(*state((3,))), there(*state((3,))))


def test_public_functions_run_there_where_the_environment_says_so(arm, monkeypatch):
    q, qd, qdd = state((4,))
    expected = fb.inverse_dynamics(arm, q, qd, qdd)
    monkeypatch.setattr(settings, "TARGET", "cuda")
    close(fb.inverse_dynamics(fb.load("ur5e"), q, qd, qdd), expected, 1e-12)


def test_a_function_of_ones_own():
    def law(q, gain):
        return fb.math.tanh(gain * q[0]) + fb.math.atan2(q[1], fb.math.exp(q[0]))

    here, there = (
        fb.compile(law, {"q": 2, "gain": ()}, target=target) for target in ("cuda", "cpu")
    )
    arrays = np.random.default_rng(0).normal(size=(40, 2)), np.linspace(0.0, 1.0, 40)
    close(here(*arrays), there(*arrays))
    many = [Argument(f"x{k}", ()) for k in range(20)]
    made = trace("total", lambda *x: (sum(x[1:], x[0]),), many, [Argument("y", ())])
    close(compile_program(made, target="cuda")(*np.arange(20.0)), np.array(190.0))


# ---------------------------------------------------------------- what is refused
def test_what_does_not_fit_is_refused_in_words(kernels):
    here, _ = kernels
    q, qd, qdd = arrays = state((5,))
    given = [*map(Owned, arrays)]
    with pytest.raises(KernelError, match=r"2 arguments given, expected 3: q\(6\)"):
        here(q, qd)
    with pytest.raises(ShapeError, match=r"qd has shape \(5, 5\), expected \(\.\.\., 6\)"):
        here(given[0], Owned(qd[:, :5]), given[2])
    with pytest.raises(BatchError, match=r"do not broadcast together: q \(5,\), qd \(4,\)"):
        here(given[0], Owned(qd[:4]), given[2])
    with pytest.raises(KernelError, match=r"qd holds float32 on the GPU, expected float64"):
        here(given[0], Owned(qd.astype(np.float32)), given[2])
    with pytest.raises(KernelError, match=r"qd holds complex numbers"):
        here(q, qd * 1j, qdd)
    with pytest.raises(KernelError, match=r"threads=0, expected a whole number"):
        here(q, qd, qdd, threads=0)
    with pytest.raises(KernelError, match=r"out for tau is a ndarray, expected on the GPU"):
        here(*given, out=np.zeros((5, 6)))
    with pytest.raises(KernelError, match=r"out for tau is a Owned, expected an array of NumPy"):
        here(*arrays, out=Owned(np.zeros((5, 6))))
    with pytest.raises(ShapeError, match=r"out for tau has shape \(4, 6\), expected \(5, 6\)"):
        here(*given, out=Owned(np.zeros((4, 6))))
    with pytest.raises(KernelError, match=r"read-only"):
        here(*given, out=Owned(np.zeros((5, 6)), readonly=True))


def test_entries_that_are_not_evenly_apart_are_refused(arm):
    here, _ = pair(arm, "mass_matrix")
    with pytest.raises(KernelError, match="not evenly spaced in memory"):
        here(Owned(np.zeros((5, 6))), out=Owned(np.zeros((5, 6, 8))[:, :, :6]))
    both, _ = pair(arm, ["gravity_torque", "bias"])
    out = Owned(np.zeros((5, 6)))
    with pytest.raises(KernelError, match="two arrays of out share memory"):
        both(Owned(np.zeros((5, 6))), Owned(np.zeros((5, 6))), out=(out, out))


# ---------------------------------------------------------------- other libraries
def test_arrays_of_cupy(kernels):
    cupy = pytest.importorskip("cupy", reason="CuPy is not installed")
    here, there = kernels
    arrays = state((30,))
    tau = here(*map(cupy.asarray, arrays))
    assert isinstance(tau, cupy.ndarray)
    close(cupy.asnumpy(tau), there(*arrays))
    with cupy.cuda.Stream(non_blocking=True) as stream:
        tau = here(*(2.0 * cupy.asarray(x) for x in arrays), stream=stream)
        close(cupy.asnumpy(tau), there(*(2.0 * x for x in arrays)))


def test_tensors_of_pytorch(kernels):
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    if not torch.cuda.is_available():
        pytest.skip("PyTorch sees no GPU")
    here, there = kernels
    arrays = state((30,))
    tau = here(*(torch.tensor(x, device="cuda") for x in arrays))
    assert tau.is_cuda
    close(tau.cpu().numpy(), there(*arrays))
    stream = torch.cuda.Stream()
    with torch.cuda.stream(stream):
        tau = here(*(2.0 * torch.tensor(x, device="cuda") for x in arrays), stream=stream)
        close((tau + 0.0).cpu().numpy(), there(*(2.0 * x for x in arrays)))
    out = torch.empty(6, 30, dtype=torch.float64, device="cuda").T
    here(*(torch.tensor(x, device="cuda") for x in arrays), out=out)
    close(out.cpu().numpy(), there(*arrays))


def test_arrays_of_jax(kernels):
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    if not any(device.platform == "gpu" for device in jax.devices()):
        pytest.skip("JAX sees no GPU")
    here, there = kernels
    arrays = state((30,))
    with jax.enable_x64(True):
        tau = here(*map(jax.numpy.asarray, arrays))
        assert isinstance(tau, jax.Array)
        close(np.asarray(tau), there(*arrays))
