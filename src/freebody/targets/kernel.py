"""A compiled program that is called as a NumPy generalized ufunc."""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import importlib.util
import os
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.errors import FreebodyError, ShapeError
from freebody.lazy import cached_property
from freebody.program.hoist import hoist
from freebody.program.passes import optimise
from freebody.program.program import Argument, Program, verify
from freebody.scalars.operations import OPERATIONS
from freebody.targets import memory
from freebody.targets.interpret import BlockedFunction
from freebody.targets.llvm import cache, fastcall
from freebody.targets.llvm.emit import emit
from freebody.targets.llvm.gufunc import make_gufunc, signature
from freebody.targets.llvm.lanes import DOUBLE, REALS, Real
from freebody.targets.llvm.loader import load
from freebody.targets.llvm.machine import LONGEST_VECTOR, WIDTHS, assembly, host, object_code
from freebody.targets.sound import sound
from freebody.targets.threads import cpus, run_split

BACKENDS = ("llvm", "numpy")


_WORTH = 4e6
"""Operations (per vector lane) that a thread is woken for: about 0.1 ms."""

_SLICE = 50 * _WORTH
"""Operations that one call of the compiled loop may take: milliseconds, so that an interrupt does not wait for long."""

_MOVE = 4.0
"""What an entry read or written costs where a batch does not fit into the processor's caches."""


class KernelError(FreebodyError, TypeError):
    """A kernel asked for or called in a way it does not know."""


class BatchError(FreebodyError, ValueError):
    """Leading dimensions that do not broadcast."""


class Kernel:
    """A program ready to run on arrays.

    Each argument has its core shape last; leading batch shapes broadcast; any strides. Numbers of another real type
    are converted to the kernel's, complex numbers and objects refused. Where a uniform input has leading axes,
    `per_sample` answers. A sample with an input that is not finite has NaN in all outputs; no other sample is touched.
    The GIL is released.

    Attributes:
        program: what was traced.
        backend: "llvm" or "numpy".
        width: samples in a vector; 1 with NumPy.
        dtype: NumPy's type of the numbers that it computes with and returns.
        ufunc: what runs, without the checks: a np.ufunc, or a function called like one with NumPy.
        signature: core sizes as NumPy writes them.
    """

    def __init__(
        self, program: Program, backend: str, width: int, ufunc: Callable[..., Any], real: Real = DOUBLE
    ):
        self.program = program
        self.backend = backend
        self.width = width
        self.dtype = np.dtype(real.dtype)
        self.ufunc = ufunc
        self.signature = signature(program.inputs, program.outputs)
        # NumPy's way broadcasts them as any others
        self._uniform = [
            (k, len(x.shape)) for k, x in enumerate(program.inputs) if x.uniform and backend == "llvm"
        ]
        every = hoist(program)[1] if self._uniform else program
        self._cost = sum(OPERATIONS[op].cost * count for op, count in every.operations.items()) + 1.0
        self._cores = [len(argument.shape) for argument in program.inputs + program.outputs]
        moved = _MOVE * (program.sampled_size + program.output_size)
        self._longest = max(1, int(_SLICE / (self._cost + moved)))
        # samples that are surely not worth threads, and of these those whose results need no memory from the store
        largest = max((argument.size for argument in program.outputs), default=1) or 1
        self._few = min(int(2 * _WORTH / self._cost), self._longest)
        self._small = min(self._few, memory.SMALLEST // (real.size * largest))

    def __call__(self, *arrays: ArrayLike, out: Any = None, threads: int | None = None) -> Any:
        """The output, or the tuple of outputs.

        Args:
            arrays: one for each input, shape (..., *core).
            out: array or tuple of arrays to write to, of the whole shape.
            threads: how many share the batch; by default as many as the work is worth.

        Raises:
            ShapeError: wrong core shape.
            BatchError: batch shapes that do not broadcast.
            KernelError: wrong number or type of arguments.
        """
        try:
            if self._uniform and any(
                np.ndim(arrays[k]) > core for k, core in self._uniform if k < len(arrays)
            ):
                return self.per_sample(*arrays, out=out, threads=threads)
            if threads is None or threads == 1:
                if out is None:
                    if self._at_most(self._small, arrays):
                        return self.ufunc(*arrays)
                elif self._at_most(self._longest if threads else self._few, arrays):
                    return self.ufunc(*arrays, out=out)
            return self._long(arrays, out, threads)
        except (TypeError, ValueError) as problem:
            raise self._explained(arrays, problem) from None

    @cached_property
    def per_sample(self) -> Kernel:
        """The kernel of the same program with no input uniform: what answers where one has a value for every sample."""
        inputs = tuple(replace(argument, uniform=False) for argument in self.program.inputs)
        return compile_program(
            replace(self.program, inputs=inputs),
            backend=self.backend,
            width=self.width,
            dtype=self.dtype.name,
        )

    def checked(self, *arrays: ArrayLike) -> Any:
        """As `__call__`; None where an input is no plain array or an output may not be what is meant (see `sound`)."""
        return sound(self, arrays)

    def _at_most(self, count: int, arrays: tuple[ArrayLike, ...]) -> bool:
        """Whether the batch surely has at most so many samples, by a look at the arrays: a call takes a microsecond."""
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
        """Call part by part, so that an interrupt need not wait, the parts shared among threads where it is worth it.

        At once where there is no batch, or where NumPy has something to say about the arrays.
        """
        values = [self._converted(np.asarray(array)) for array in arrays]
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise KernelError(f"{self.program.name}: threads={threads!r}, expected a whole number from 1 up.")
        shapes = {x.shape[: x.ndim - core] for x, core in zip(values, self._cores, strict=False)}
        batch = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
        count = prod(batch)
        given = () if out is None else out if isinstance(out, tuple) else (out,)
        if not batch or not count or self.backend == "numpy" or not self._fits(values, given, batch):
            return self.ufunc(*values) if out is None else self.ufunc(*values, out=out)
        if threads is None:
            threads = max(1, min(cpus(), int(count * self._cost / _WORTH)))
        outs = given or tuple(
            memory.empty(batch + argument.shape, self.dtype) for argument in self.program.outputs
        )
        if given:  # of what is written over, a copy is read, as NumPy does
            values = [x.copy() if any(np.may_share_memory(x, y) for y in given) else x for x in values]
        if threads == 1 and count <= self._longest:
            self.ufunc(*values, out=outs)
        else:
            run_split(self.ufunc, values, outs, self._cores, batch, threads, self._longest)
        return outs[0] if len(outs) == 1 else outs

    def _converted(self, array: np.ndarray) -> np.ndarray:
        """As the kernel's own numbers, where that is another real type; what cannot be is left for NumPy to refuse."""
        if array.dtype == self.dtype or not np.can_cast(array.dtype, self.dtype, "same_kind"):
            return array
        return array.astype(self.dtype)

    def _fits(self, values: list[np.ndarray], outs: tuple[Any, ...], batch: tuple[int, ...]) -> bool:
        """Whether arrays have the core shapes, and those to write to the whole shape and no memory in common."""
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
        """Another process compiles the program for itself, or finds it in the cache."""
        width = self.width if self.backend == "llvm" else None
        return _compiled_again, (self.program, self.backend, width, self.dtype.name)

    def __repr__(self) -> str:
        return f"Kernel({self.program}; {self.dtype}, {self.backend}, width {self.width})"

    @cached_property
    def source(self) -> str:
        """What runs, as text: LLVM, or the program's own listing, which NumPy runs node by node."""
        return optimise(self.program).listing() if self.backend == "numpy" else self.ir

    @property
    def ir(self) -> str:
        """The LLVM text."""
        return emit(optimise(self.program), host().target(self.width, REALS[self.dtype.name]))

    def assembly(self) -> str:
        """The machine's assembly of the LLVM text."""
        return assembly(self.ir)

    def _explained(self, arrays: tuple[ArrayLike, ...], problem: Exception) -> Exception:
        """The error that says which argument is to blame; the original one if none is."""
        name, inputs = self.program.name, self.program.inputs
        if len(arrays) != len(inputs):
            wanted = ", ".join(map(str, inputs))
            return KernelError(f"{name}: {len(arrays)} arguments given, expected {len(inputs)}: {wanted}.")
        for array, argument in zip(arrays, inputs, strict=True):
            given = np.asarray(array)
            if not np.can_cast(given.dtype, self.dtype, "same_kind"):
                return KernelError(
                    f"{name}: {argument.name} holds {given.dtype} values, expected real numbers."
                )
            core = len(argument.shape)
            if given.ndim < core or given.shape[given.ndim - core :] != argument.shape:
                expected = f"({', '.join(['...', *map(str, argument.shape)])})"
                return ShapeError(name, argument.name, given.shape, expected)
        return _batch_error(name, inputs, arrays) or problem


class _QuickKernel(Kernel):
    """A kernel whose calls go to C functions of its own: Python finds them, by the class, in the kernel's slots."""

    __slots__ = ("__call__", "checked")

    def __init__(self, kernel: Kernel, call: Callable[..., Any], checked: Callable[..., Any]):
        super().__init__(kernel.program, kernel.backend, kernel.width, kernel.ufunc, REALS[kernel.dtype.name])
        self.__call__, self.checked = call, checked  # type: ignore[method-assign]


def _batch_error(name: str, inputs: tuple[Argument, ...], arrays: tuple[ArrayLike, ...]) -> BatchError | None:
    shapes = [np.shape(x)[: np.ndim(x) - len(i.shape)] for x, i in zip(arrays, inputs, strict=True)]
    try:
        np.broadcast_shapes(*shapes)
    except ValueError:
        listed = ", ".join(f"{argument.name} {shape}" for argument, shape in zip(inputs, shapes, strict=True))
        return BatchError(f"{name}: the batch shapes do not broadcast together: {listed}.")
    return None


def compile_program(
    program: Program, *, backend: str | None = None, width: int | None = None, dtype: str = "float64"
) -> Kernel:
    """The kernel of a program.

    Args:
        program: from `trace`.
        backend: "llvm" or "numpy"; by default the environment's FREEBODY_BACKEND, else LLVM where it is installed.
        width: samples in a vector (2, 4, 8; 16 of float32); by default FREEBODY_WIDTH, else what suits the CPU.
        dtype: "float64" or "float32", of the numbers that come in, are computed with and come out.

    Raises:
        KernelError: an unknown backend, width or dtype; a constant beyond the range of the dtype.
    """
    backend = backend or os.environ.get("FREEBODY_BACKEND") or _default_backend()
    if backend not in BACKENDS:
        known = ", ".join(BACKENDS)
        raise KernelError(f"no backend {backend!r}. Backends: {known} (argument or FREEBODY_BACKEND).")
    if dtype not in REALS:
        raise KernelError(f"no dtype {dtype!r} of kernels. Known: {', '.join(REALS)}.")
    real = REALS[dtype]
    width = _width(width, real)
    if not _has_scalars(program):
        backend = "numpy"
    key = (program.digest, backend, width, dtype, fastcall.available(program))
    with _lock:
        kernel = _kernels.get(key)
        if kernel is None:
            kernel = _kernels[key] = _COMPILE[backend](_in_range(verify(program), real), width, real)
        _recent[key] = kernel
        _recent.move_to_end(key)
        if len(_recent) > RECENT:
            _recent.popitem(last=False)
    return kernel


def _compiled_again(program: Program, backend: str, width: int | None, dtype: str) -> Kernel:
    return compile_program(program, backend=backend, width=width, dtype=dtype)


def _in_range(program: Program, real: Real) -> Program:
    """The program itself, if its constants are finite as numbers of that type."""
    for value in program.constants:
        try:
            real.constant(value)
        except OverflowError:
            raise KernelError(
                f"{program.name}: the constant {value!r} is beyond the range of {real.dtype}."
            ) from None
    return program


_lock = threading.Lock()
if hasattr(os, "register_at_fork"):  # a fork waits, since its child would find the lock taken for ever
    os.register_at_fork(before=_lock.acquire, after_in_parent=_lock.release, after_in_child=_lock.release)

RECENT = 32
"""Kernels that are kept although nobody has them any more, for the next who asks for one."""

_Key = tuple[str, str, int | None, str, bool]
_kernels: weakref.WeakValueDictionary[_Key, Kernel] = weakref.WeakValueDictionary()
_recent: OrderedDict[_Key, Kernel] = OrderedDict()
"""Those that were asked for last, the last one at the end."""


def _compile_numpy(program: Program, width: int | None, real: Real) -> Kernel:
    return Kernel(program, "numpy", 1, BlockedFunction(optimise(program), real.dtype), real)


def _compile_llvm(program: Program, width: int | None, real: Real) -> Kernel:
    here = host()
    machine = here.target(width, real)
    fast = fastcall.available(program)
    key = cache.key(program.digest, here, machine, _compiler_version(), fast)
    code = cache.load(key)
    if code is None:
        text = emit(optimise(program), machine)
        code = object_code(text + fastcall.text(program, real) if fast else text)
        cache.store(key, code)
    symbols = ("kernel", *fastcall.EXPORTS) if fast else ("kernel",)
    loaded, addresses = load(code, symbols, fastcall.symbols(real) if fast else {})
    ufunc = make_gufunc(addresses["kernel"], program.name, program.inputs, program.outputs, loaded, real)
    kernel = Kernel(program, "llvm", machine.width, ufunc, real)
    if not fast:
        return kernel
    ways = (kernel.__call__, kernel.checked)  # for what is not plain
    call, checked = (
        fastcall.function(addresses[symbol], program.name, general, loaded)
        for symbol, general in zip(fastcall.EXPORTS, ways, strict=True)
    )
    return _QuickKernel(kernel, call, checked)


_COMPILE = {"llvm": _compile_llvm, "numpy": _compile_numpy}


@functools.cache
def _compiler_version() -> str:
    """Of the compiler's own text: whatever is changed in it, cached objects of the former text are not used."""
    digest = hashlib.sha256()
    house = Path(__file__).parent.parent
    for path in sorted([*house.glob("program/*.py"), *house.glob("targets/**/*.py")]):
        digest.update(path.read_bytes())
    return f"{_installed_version()} {digest.hexdigest()}"


def _installed_version() -> str:
    try:
        return importlib.metadata.version("freebody")
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _default_backend() -> str:
    return "llvm" if importlib.util.find_spec("llvmlite") else "numpy"


def _width(width: int | None, real: Real) -> int | None:
    given = os.environ.get("FREEBODY_WIDTH") if width is None else str(width)
    if not given:
        return None
    known = [n for n in WIDTHS if n * real.bits <= LONGEST_VECTOR]
    if given not in map(str, known):
        listed = ", ".join(map(str, known))
        raise KernelError(f"no width {given} of {real.dtype}. Widths: {listed} (argument or FREEBODY_WIDTH).")
    return int(given)


def _has_scalars(program: Program) -> bool:
    """Whether NumPy can make a gufunc of it: no argument is empty, and there is an input."""
    arguments: tuple[Argument, ...] = program.inputs + program.outputs
    return bool(program.inputs) and all(argument.size for argument in arguments)
