"""A compiled program that is called as a NumPy generalized ufunc."""

from __future__ import annotations

import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from itertools import combinations
from math import isinf, prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freebody import locks
from freebody.arrays import is_count
from freebody.lazy import cached_property
from freebody.program.passes import hoist
from freebody.program.program import Argument, Program, verify
from freebody.scalars.operations import OPERATIONS
from freebody.targets import result_memory
from freebody.targets.call_errors import explained
from freebody.targets.target import KernelError, chosen_target, chosen_width, target_named
from freebody.targets.threads import cpus, run_split

_WORTH = 4e6
"""Operations (per vector lane) that a thread is woken for: about 0.1 ms."""

_SLICE = 50 * _WORTH
"""Operations that one call of the compiled loop may take: milliseconds, so that an interrupt does
not wait for long."""

_MOVE = 4.0
"""The cost of an entry read or written where a batch does not fit into the processor's caches, in
additions."""


class BatchLoop(NamedTuple):
    """The address of a C function `void loop(char **args, intptr_t *dimensions, intptr_t *steps,
    void *data)` that loops over a batch.

    address: valid as long as `code` lives. content: a digest of all that the machine code depends
    on.
    """

    address: int
    content: str
    code: Any


class Kernel:
    """A program ready to run on arrays.

    Each argument has its core shape last; leading batch shapes broadcast; any strides. Numbers of
    another real type are converted to the kernel's, complex numbers and objects refused. Where a
    uniform input has leading axes, `per_sample` answers. A sample with an input that is not finite
    has NaN in all outputs; no other sample is touched. The GIL is released.

    Attributes
    ----------
    program
        What was traced.
    target
        Where it runs, a name of `TARGETS`.
    width
        Samples in a vector; 1 with NumPy.
    dtype
        NumPy's type of the numbers that it computes with and returns.
    ufunc
        What runs, without the checks: a np.ufunc, or a function called like one with NumPy.
    signature
        Core sizes as NumPy writes them.
    few
        Samples that are answered at once, by one thread into new memory.
    loop
        The machine code of the batch, for other libraries; None where the target has none.
    """

    loop: BatchLoop | None = None

    def __init__(
        self,
        program: Program,
        target: str,
        width: int,
        ufunc: Callable[..., Any],
        dtype: str = "float64",
    ):
        self.program = program
        self.target = target
        self.width = width
        self.dtype = np.dtype(dtype)
        self.ufunc = ufunc
        self.signature = signature(program.inputs, program.outputs)
        self._loops = target_named(target).loops
        # what is no loop broadcasts them as any others
        self._uniform = [
            (k, len(x.shape)) for k, x in enumerate(program.inputs) if x.uniform and self._loops
        ]
        every = hoist(program)[1] if self._uniform else program
        self._cost = (
            sum(OPERATIONS[op].cost * count for op, count in every.operations.items()) + 1.0
        )
        self._cores = [len(argument.shape) for argument in program.inputs + program.outputs]
        moved = _MOVE * (program.sampled_size + program.output_size)
        self._longest = max(1, int(_SLICE / (self._cost + moved)))
        # samples that are surely not worth threads, and of these those whose results need no memory
        # from the store
        self._few = min(int(2 * _WORTH / self._cost), self._longest)
        made = self.dtype.itemsize * max(1, program.output_size)
        self.few = min(self._few, result_memory.SMALLEST // made)

    def __call__(self, *arrays: ArrayLike, out: Any = None, threads: int | None = None) -> Any:
        """The output, or the tuple of outputs.

        Parameters
        ----------
        arrays
            One for each input, shape (..., *core).
        out
            Array or tuple of arrays to write to, of the whole shape.
        threads
            How many share the batch; by default as many as the work is worth.

        Raises
        ------
        ShapeError
            Wrong core shape.
        BatchError
            Batch shapes that do not broadcast.
        KernelError
            Wrong number or type of arguments, or an `out` that cannot be written to.
        """
        if len(arrays) > len(self.program.inputs):  # NumPy would write to the last
            raise explained(self.program, self.dtype, arrays, out, TypeError())
        try:
            if self._uniform and any(
                np.ndim(arrays[k]) > core for k, core in self._uniform if k < len(arrays)
            ):
                return self.per_sample(*arrays, out=out, threads=threads)
            if threads is None or threads == 1:
                if out is None:
                    if self._at_most(self.few, arrays):
                        return self.ufunc(*arrays)
                elif self._at_most(self._longest if threads else self._few, arrays):
                    return self.ufunc(*arrays, out=out)
            return self._long(arrays, out, threads)
        except (TypeError, ValueError, MemoryError) as problem:
            raise explained(self.program, self.dtype, arrays, out, problem) from None

    @cached_property
    def per_sample(self) -> Kernel:
        """The kernel of the same program without uniform inputs, for calls in which one has a value
        for every sample."""
        inputs = tuple(replace(argument, uniform=False) for argument in self.program.inputs)
        return compile_program(
            replace(self.program, inputs=inputs),
            target=self.target,
            width=self.asked_width,
            dtype=self.dtype.name,
        )

    def quick(self, general: Callable[..., Any], held: Any = None) -> Callable[..., Any] | None:
        """A function called like the kernel that is quick for plain arguments and calls `general`
        for others; None where there is none.

        held: the last argument of calls that do not give it.
        """
        return None

    def quick_checked(
        self, general: Callable[..., Any], held: Any = None, units: Sequence[tuple[int, int]] = ()
    ) -> Callable[..., Any] | None:
        """A function as of `quick` that also requires sound numbers, see `finite_check.sound`; the
        four entries at each of `units` must have unit length."""
        return None

    def _at_most(self, count: int, arrays: tuple[ArrayLike, ...]) -> bool:
        """Whether the batch certainly has at most `count` samples, by a glance at the arrays: a
        call takes a microsecond."""
        for array, core in zip(arrays, self._cores, strict=False):
            if type(array) is float and not core:
                continue
            if not isinstance(array, np.ndarray) or array.dtype is not self.dtype:
                return False
            axes = array.ndim - core
            if axes > 1 or (axes == 1 and array.shape[0] > count):
                return False
        return True

    def _long(self, arrays: tuple[ArrayLike, ...], out: Any, threads: int | None) -> Any:
        """The outputs of a long call, made part by part so that an interrupt need not wait, and
        shared among threads where that is worthwhile.

        In one piece where there is no batch, and where arrays do not fit, which NumPy then says.
        """
        values = [self._converted(np.asarray(array)) for array in arrays]
        self._require_threads(threads)
        shapes = {x.shape[: x.ndim - core] for x, core in zip(values, self._cores, strict=False)}
        batch = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
        count = prod(batch)
        given = () if out is None else out if isinstance(out, tuple) else (out,)
        if not batch or not count or not self._loops or not self._fits(values, given, batch):
            return self.ufunc(*values) if out is None else self.ufunc(*values, out=out)
        if threads is None:
            threads = max(1, min(cpus(), int(count * self._cost / _WORTH)))
        if given:
            values = _apart(values, given)
        outs = given or tuple(
            result_memory.empty(batch + argument.shape, self.dtype)
            for argument in self.program.outputs
        )
        if threads == 1 and count <= self._longest:
            self.ufunc(*values, out=outs)
        else:
            run_split(self.ufunc, values, outs, self._cores, batch, threads, self._longest)
        return outs[0] if len(outs) == 1 else outs

    def _require_threads(self, threads: int | None) -> None:
        if threads is not None and not is_count(threads):
            raise KernelError(
                f"{self.program.name}: threads={threads!r}, expected a whole number from 1 up."
            )

    def _converted(self, array: np.ndarray) -> np.ndarray:
        """The array converted to the kernel's number type from another real type; others are left
        for NumPy to refuse."""
        if array.dtype == self.dtype or not np.can_cast(array.dtype, self.dtype, "same_kind"):
            return array
        return array.astype(self.dtype)

    def _fits(
        self, values: list[np.ndarray], outs: tuple[Any, ...], batch: tuple[int, ...]
    ) -> bool:
        """Whether inputs have the core shapes, and outputs the full shapes without shared
        memory."""
        inputs, outputs = self.program.inputs, self.program.outputs
        if len(values) != len(inputs) or len(outs) not in (0, len(outputs)):
            return False
        for x, argument in zip(values, inputs, strict=True):
            if x.shape[x.ndim - len(argument.shape) :] != argument.shape:
                return False
        for x, argument in zip(outs, outputs, strict=False):
            if not isinstance(x, np.ndarray) or x.shape != batch + argument.shape:
                return False
        return not any(np.may_share_memory(x, y) for x, y in combinations(outs, 2))

    def __reduce__(self) -> tuple[Any, ...]:
        """A recipe for pickling: another process compiles the program itself, or finds it in the
        cache."""
        return _compiled_again, (self.program, self.target, self.asked_width, self.dtype.name)

    @property
    def samples_of_a_thread(self) -> int:
        """The number of samples that justifies another thread."""
        return max(1, int(_WORTH / self._cost))

    @property
    def asked_width(self) -> int | None:
        """The width to request so that another program gets the same vectors; None where the target
        has no vectors."""
        return self.width if target_named(self.target).widths[self.dtype.name] else None

    def __repr__(self) -> str:
        return f"Kernel({self.program}; {self.dtype}, {self.target}, width {self.width})"

    @cached_property
    def source(self) -> str:
        """The text of the code that runs: LLVM on the CPU; with NumPy the program's listing."""
        return target_named(self.target).source(self.program, self.width, self.dtype.name)


def _apart(values: list[np.ndarray], written: tuple[Any, ...]) -> list[np.ndarray]:
    """The arrays, with copies of those that an output overwrites, as NumPy does."""
    return [x.copy() if any(np.may_share_memory(x, y) for y in written) else x for x in values]


def signature(inputs: Sequence[Argument], outputs: Sequence[Argument]) -> str:
    """Core sizes as NumPy writes them: `(6),(6),(6)->(6,6)`."""

    def side(arguments: Sequence[Argument]) -> str:
        return ",".join(f"({','.join(map(str, argument.shape))})" for argument in arguments)

    return f"{side(inputs)}->{side(outputs)}"


def compile_program(
    program: Program, *, target: str | None = None, width: int | None = None, dtype: str = "float64"
) -> Kernel:
    """The kernel of a program.

    Parameters
    ----------
    program
        From `trace`.
    target
        "cpu", "cpu:" with a level, "numpy" or "cuda"; by default the environment's FREEBODY_TARGET,
        else the CPU where LLVM is.
    width
        Samples in a vector (2, 4, 8; 16 of float32); by default FREEBODY_WIDTH, else what suits the
        CPU. Both are read once, when a process first needs a kernel.
    dtype
        "float64" or "float32", of the numbers that come in, are computed with and come out.

    Raises
    ------
    KernelError
        An unknown target, width or dtype, or one that this machine lacks something for; a constant
        beyond the range of the dtype.
    """
    target = chosen_target(target)
    with locks.KERNELS:
        width = chosen_width(target, width, dtype)
        record = target_named(target)
        if record.host and not _has_scalars(program):
            target, width, record = "numpy", None, target_named("numpy")
        key = (program.digest, target, width, dtype, record.variant(program))
        kernel = _kernels.get(key)
        if kernel is None:
            if lacking := record.missing():
                raise KernelError(f"target {target!r} does not run here: {lacking}.")
            kernel = _kernels[key] = record.build(_in_range(verify(program), dtype), width, dtype)
        _recent.pop(key, None)
        _recent[key] = kernel
        if len(_recent) > RECENT:
            _recent.popitem(last=False)
    return kernel


def _compiled_again(program: Program, target: str, width: int | None, dtype: str) -> Kernel:
    return compile_program(program, target=target, width=width, dtype=dtype)


def _in_range(program: Program, dtype: str) -> Program:
    """The program itself; raises KernelError where a constant overflows in that number type."""
    with np.errstate(over="ignore"):
        rounded = np.array(program.constants, dtype=dtype)
    for value, number in zip(program.constants, rounded, strict=True):
        if isinf(number) and not isinf(value):
            raise KernelError(
                f"{program.name}: the constant {value!r} is beyond the range of {dtype}."
            )
    return program


RECENT = 32
"""Kernels that are kept although nobody has them any more, for the next who asks for one."""

_KernelKey = tuple[str, str, int | None, str, Hashable]
_kernels: weakref.WeakValueDictionary[_KernelKey, Kernel] = weakref.WeakValueDictionary()
_recent: OrderedDict[_KernelKey, Kernel] = OrderedDict()
"""The kernels that were fetched last, the last one at the end."""


def _has_scalars(program: Program) -> bool:
    """Whether NumPy can make a generalized ufunc of the program: no argument is empty, and there is
    an input."""
    arguments: tuple[Argument, ...] = program.inputs + program.outputs
    return bool(program.inputs) and all(argument.size for argument in arguments)
