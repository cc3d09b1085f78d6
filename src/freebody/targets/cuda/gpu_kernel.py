"""NVIDIA's GPUs as a target: programs as PTX, which the driver assembles for the GPU at hand,
called like kernels of the CPU with arrays of either."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from freebody.arrays import as_array
from freebody.errors import ShapeError
from freebody.program.program import Argument, Program
from freebody.targets.call_errors import common_batch, require_count, require_real
from freebody.targets.cuda import driver
from freebody.targets.cuda.driver import missing
from freebody.targets.cuda.gpu_arrays import (
    DeviceArray,
    DeviceView,
    device_of,
    on_gpu,
    row_strides,
    runs,
    view,
)
from freebody.targets.cuda.ptx import Plan, plan
from freebody.targets.kernel import Kernel
from freebody.targets.target import KernelError, Target


class GpuKernel(Kernel):
    """A kernel on a GPU, called with NumPy arrays, which are copied to it and back, or with arrays
    of CuPy, PyTorch, JAX or Numba.

    Given one array on a GPU, results stay there: arrays of the same library, new ones or `out`.
    Small things beside it may be NumPy's. What the driver assembled for a GPU is kept with the
    kernel.
    """

    def __init__(self, program: Program, plan: Plan, dtype: str):
        super().__init__(program, "cuda", 1, self._run, dtype)
        self._plan = plan
        self._modules: dict[int, driver.Module] = {}

    def __call__(
        self, *arrays: Any, out: Any = None, threads: int | None = None, stream: Any = None
    ) -> Any:
        """The output, or the tuple of outputs.

        Parameters
        ----------
        arrays
            One for each input, shape (..., *core); on a GPU of the kernel's own type of number.
        out
            Array or tuple of arrays to write to, of the whole shape; on the GPU if an input is.
        threads
            Of the CPU, which has nothing to share here; refused as other kernels refuse it.
        stream
            Of CUDA, which the work goes to; then the call does not wait for it. By default the
            legacy stream.

        Raises
        ------
        ShapeError, BatchError, KernelError
            As other kernels.
        GpuError
            What the driver refused.
        """
        self._require_threads(threads)
        return self._run(*arrays, out=out, stream=stream)

    def _run(self, *arrays: Any, out: Any = None, stream: Any = None) -> Any:
        inputs = self.program.inputs
        require_count(self.program.name, arrays, self.program.inputs)
        there = next((x for x in arrays if on_gpu(x)), None)
        handle = driver.DEFAULT_STREAM if stream is None else driver.handle_of(stream)
        device = self._device(arrays)
        with driver.current(device):
            given = [
                view(x, handle) if on_gpu(x) else self._hosted(a, x)
                for a, x in zip(inputs, arrays, strict=True)
            ]
        if self._varies(given):
            return cast(GpuKernel, self.per_sample)(*arrays, out=out, stream=stream)
        batch = self._batch(given)
        given_out = () if out is None else out if isinstance(out, tuple) else (out,)
        with driver.current(device):
            call = _Call(self, batch, device, handle, stream)
            results = call.outputs(given_out, there is not None)
            call.launch(given, [x.view if isinstance(x, DeviceArray) else x for x in results])
            made = call.finished(
                [x for x in results if isinstance(x, DeviceArray)], given_out, there
            )
        done = given_out or made
        return done[0] if len(done) == 1 else done

    def _varies(self, given: Sequence[np.ndarray | DeviceView]) -> bool:
        """Whether some uniform input is given with one value for each sample."""
        return any(
            argument.uniform and len(x.shape) > len(argument.shape)
            for argument, x in zip(self.program.inputs, given, strict=True)
        )

    def _hosted(self, argument: Argument, value: Any) -> np.ndarray:
        """An array of the host in the kernel's number type and C order."""
        array = as_array(self.program.name, argument.name, value)
        require_real(self.program.name, argument, array, self.dtype)
        return np.ascontiguousarray(array, self.dtype).reshape(array.shape)

    def _batch(self, given: Sequence[np.ndarray | DeviceView]) -> tuple[int, ...]:
        """The batch shape of the arrays; refuses wrong core shapes and number types."""
        name, inputs = self.program.name, self.program.inputs
        for argument, x in zip(inputs, given, strict=True):
            if x.dtype != self.dtype:
                raise KernelError(
                    f"{name}: {argument.name} holds {x.dtype} on the GPU, expected {self.dtype}; "
                    f"convert it, or ask for fb.kernel(..., dtype={x.dtype.name!r})."
                )
        return common_batch(name, inputs, given)

    def _device(self, arrays: Sequence[Any]) -> int:
        """The index of the GPU that all arrays are on; that of the first GPU for arrays of the
        host."""
        devices = {device_of(x) for x in arrays if on_gpu(x)}
        if len(devices) > 1:
            raise KernelError(
                f"{self.program.name}: arrays are on different GPUs: "
                f"{', '.join(map(str, sorted(devices)))}."
            )
        return devices.pop() if devices else 0

    def module(self, device: int) -> driver.Module:
        """The kernel's entries loaded on a GPU, which must be current."""
        if device not in self._modules:
            self._modules[device] = driver.Module(self.source, self._plan.names, device)
        return self._modules[device]

    @property
    def plan(self) -> Plan:
        """The PTX entries of the kernel, and their arguments."""
        return self._plan


class _Call:
    """One call of a kernel on the current GPU: where its arrays are, and its launches on a stream,
    in order."""

    def __init__(
        self, kernel: GpuKernel, batch: tuple[int, ...], device: int, handle: int, stream: Any
    ):
        self.kernel, self.program, self.batch = kernel, kernel.program, batch
        self.device, self.handle, self.stream = device, handle, stream
        self.kept: list[Any] = []

    def outputs(self, given: Sequence[Any], there: bool) -> list[DeviceArray | DeviceView]:
        """New arrays for the outputs, or views of the given ones where these are on the GPU."""
        name, outputs = self.program.name, self.program.outputs
        if given and len(given) != len(outputs):
            raise KernelError(f"{name}: out has {len(given)} arrays, expected {len(outputs)}.")
        for argument, x in zip(outputs, given, strict=False):
            shape = self.batch + argument.shape
            if not (on_gpu(x) if there else isinstance(x, np.ndarray)):
                wanted = (
                    "on the GPU, where the inputs are"
                    if there
                    else "an array of NumPy, as the inputs"
                )
                raise KernelError(
                    f"{name}: out for {argument.name} is a {type(x).__name__}, expected {wanted}."
                )
            if tuple(x.shape) != shape:
                raise ShapeError(name, f"out for {argument.name}", tuple(x.shape), str(shape))
        if given and there:
            return [
                self._written(a, view(x, self.handle)) for a, x in zip(outputs, given, strict=True)
            ]
        dtype = self.kernel.dtype
        shapes = [self.batch + a.shape for a in outputs]
        return [
            DeviceArray(self._memory(int(np.prod(shape)) * dtype.itemsize), shape, dtype)
            for shape in shapes
        ]

    def _written(self, argument: Argument, given: DeviceView) -> DeviceView:
        name = f"{self.program.name}: out for {argument.name}"
        if given.dtype != self.kernel.dtype or given.device != self.device or given.readonly:
            raise KernelError(
                f"{name} holds {given.dtype} on GPU "
                f"{given.device}{', read-only' if given.readonly else ''}; expected "
                f"{self.kernel.dtype} on GPU {self.device}, writable."
            )
        if given.step(len(argument.shape)) is None:
            raise KernelError(
                f"{name}: the entries of a sample are not evenly spaced in memory; give one in C "
                f"order."
            )
        return given

    def launch(self, given: Sequence[np.ndarray | DeviceView], outs: Sequence[DeviceView]) -> None:
        """Start all work of the call on the stream: copies, numbers computed once, and each part
        for all samples."""
        self._require_apart(outs)
        views = [
            self._readable(a, x, outs) for a, x in zip(self.program.inputs, given, strict=True)
        ]
        uniform = [x for a, x in zip(self.program.inputs, views, strict=True) if a.uniform]
        sampled = [x for a, x in zip(self.program.inputs, views, strict=True) if not a.uniform]
        plan, module = self.kernel.plan, self.kernel.module(self.device)
        shared = self._launch_once(uniform) if plan.once else []
        arguments = [*(a for a in self.program.inputs if not a.uniform), *self.program.outputs]
        arrays = [*sampled, *outs]
        strides = [
            _along(x, len(a.shape), self.batch) for a, x in zip(arguments, arrays, strict=True)
        ]
        size = self.kernel.dtype.itemsize
        for run in runs(self.batch, strides):
            values = [
                value
                for a, x, begin, step in zip(arguments, arrays, run.begins, run.steps, strict=True)
                for value in (x.address + begin * size, step, x.step(len(a.shape)) or 1)
            ]
            values[3 * len(sampled) : 3 * len(sampled)] = shared
            for name in plan.parts:
                module.launch(name, values, run.count, self.handle)

    def finished(
        self, made: Sequence[DeviceArray], given: Sequence[Any], there: Any
    ) -> tuple[Any, ...]:
        """The outputs as the caller expects them: arrays of the library of `there`, else in the
        host's memory, copied into given ones."""
        if there is None:
            found = tuple(x.numpy() for x in made)
            for target, result in zip(given, found, strict=False):
                np.copyto(target, result, casting="same_kind")
            return found
        if given and self.stream is None:
            # whoever owns these arrays does not know what they wait for
            driver.call("cuStreamSynchronize", self.handle)
        return tuple(x.like(there) for x in made)

    def _require_apart(self, outs: Sequence[DeviceView]) -> None:
        """Refuse output arrays that share memory."""
        for k, x in enumerate(outs):
            if any(x.overlaps(y) for y in outs[:k]):
                raise KernelError(f"{self.program.name}: two arrays of out share memory.")

    def _launch_once(self, uniform: Sequence[DeviceView]) -> list[int]:
        """The address of the numbers computed once a call, whose launch is started."""
        plan, module = self.kernel.plan, self.kernel.module(self.device)
        memory = self._memory(plan.shared * self.kernel.dtype.itemsize)
        values = [v for x in uniform for v in (x.address, 0, x.step(len(x.shape)) or 1)]
        module.launch(plan.once, [*values, memory.address, 0, 1], 1, self.handle)
        return [memory.address]

    def _readable(
        self, argument: Argument, given: np.ndarray | DeviceView, outs: Sequence[DeviceView]
    ) -> DeviceView:
        """A view of an input on the GPU that no output overlaps; a copy where necessary."""
        if isinstance(given, DeviceView):
            if given.step(len(argument.shape)) is None:
                raise KernelError(
                    f"{self.program.name}: the entries of a sample of {argument.name} are not "
                    f"evenly spaced in memory; give it in C order, or as columns."
                )
            if not any(given.overlaps(x) for x in outs):
                return given
            low, high = given.extent
            memory = self._memory(high - low)
            driver.call("cuMemcpyDtoDAsync", memory.address, low, high - low, self.handle)
            moved = memory.address + given.address - low
            return DeviceView(moved, given.shape, given.strides, given.dtype, self.device)
        memory = self._memory(given.nbytes)
        if given.nbytes:
            self.kept.append(given)
            driver.call(
                "cuMemcpyHtoDAsync", memory.address, given.ctypes.data, given.nbytes, self.handle
            )
        return DeviceView(
            memory.address, given.shape, row_strides(given.shape), given.dtype, self.device
        )

    def _memory(self, size: int) -> driver.Memory:
        """Memory that stays until the call ends, or longer where a result uses it."""
        memory = driver.Memory(size, self.device, self.handle, self.stream)
        self.kept.append(memory)
        return memory


def _along(x: DeviceView, core: int, batch: tuple[int, ...]) -> tuple[int, ...]:
    """Strides along the axes of the batch, 0 where an array is broadcast."""
    own = len(x.shape) - core
    steps = [0 if n == 1 else s for n, s in zip(x.shape[:own], x.strides[:own], strict=True)]
    return (*[0] * (len(batch) - own), *steps)


def _build(program: Program, width: int | None, dtype: str) -> GpuKernel:
    return GpuKernel(program, plan(program, dtype), dtype)


def _source(program: Program, width: int, dtype: str) -> str:
    return plan(program, dtype).text


TARGET = Target(
    build=_build,
    source=_source,
    widths={"float64": (), "float32": ()},
    variant=lambda program: None,
    loops=True,
    missing=missing,
    host=False,
)
