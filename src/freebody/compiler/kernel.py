"""A compiled program that is called as a NumPy generalized ufunc."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.compiler import emit_llvm, emit_numpy, target
from freebody.compiler.gufunc import make_gufunc, signature
from freebody.compiler.passes import optimise
from freebody.compiler.program import Argument, Program
from freebody.errors import FreebodyError, ShapeError

BACKENDS = ("llvm", "numpy")


class KernelError(FreebodyError, TypeError):
    """A kernel asked for or called in a way it does not know."""


class Kernel:
    """A program ready to run on arrays.

    Each argument has its core shape last; leading batch shapes broadcast; any strides. Integers and float32 are
    converted, complex numbers and objects refused. A sample with an input that is not finite has NaN in all outputs;
    no other sample is touched. The GIL is released.

    Attributes:
        program: what was traced.
        backend: "llvm" or "numpy".
        width: samples in a vector; 1 with NumPy.
        ufunc: what runs, without the checks: a np.ufunc, or a function called like one with NumPy.
        signature: core sizes as NumPy writes them.
    """

    def __init__(self, program: Program, backend: str, width: int, ufunc: Callable[..., Any]):
        self.program = program
        self.backend = backend
        self.width = width
        self.ufunc = ufunc
        self.signature = signature(program.inputs, program.outputs)

    def __call__(self, *arrays: ArrayLike, out: Any = None, threads: int | None = None) -> Any:
        """The output, or the tuple of outputs.

        Args:
            arrays: one for each input, shape (..., *core).
            out: array or tuple of arrays to write to.
            threads: how many share the batch; by default as many as the work is worth.

        Raises:
            ShapeError: wrong core shape, or batch shapes that do not broadcast.
            KernelError: wrong number or type of arguments.
        """
        try:
            return self.ufunc(*arrays, out=out)
        except (TypeError, ValueError) as problem:
            raise self._explained(arrays, problem) from None

    def __repr__(self) -> str:
        return f"Kernel({self.program}; {self.backend}, width {self.width})"

    @cached_property
    def source(self) -> str:
        """The text that was compiled: LLVM or Python."""
        program = optimise(self.program)
        if self.backend == "numpy":
            return emit_numpy.emit(program)
        return emit_llvm.emit(program, target.host().target(self.width))

    @property
    def ir(self) -> str:
        """The LLVM text."""
        return emit_llvm.emit(optimise(self.program), target.host().target(self.width))

    def assembly(self) -> str:
        """The machine's assembly of the LLVM text."""
        return target.assembly(self.ir)

    def _explained(self, arrays: tuple[ArrayLike, ...], problem: Exception) -> Exception:
        """The error that says which argument is to blame; the original one if none is."""
        name, inputs = self.program.name, self.program.inputs
        if len(arrays) != len(inputs):
            wanted = ", ".join(map(str, inputs))
            return KernelError(f"{name}: {len(arrays)} arguments given, expected {len(inputs)}: {wanted}.")
        for array, argument in zip(arrays, inputs, strict=True):
            given = np.asarray(array)
            if not np.can_cast(given.dtype, np.float64, "safe"):
                return KernelError(f"{name}: {argument.name} holds {given.dtype} values, expected real numbers.")
            core = len(argument.shape)
            if given.ndim < core or given.shape[given.ndim - core :] != argument.shape:
                expected = f"({', '.join(['...', *map(str, argument.shape)])})"
                return ShapeError(name, argument.name, given.shape, expected)
        return problem


def compile_program(program: Program, *, backend: str | None = None, width: int | None = None) -> Kernel:
    """The kernel of a program.

    Args:
        program: from `trace`.
        backend: "llvm" or "numpy"; by default the environment's FREEBODY_BACKEND, else LLVM where it is installed.
        width: samples in a vector (2, 4, 8); by default FREEBODY_WIDTH, else what suits the CPU.

    Raises:
        KernelError: an unknown backend or width.
    """
    backend = backend or os.environ.get("FREEBODY_BACKEND") or _default_backend()
    if backend not in BACKENDS:
        raise KernelError(f"no backend {backend!r}. Backends: {', '.join(BACKENDS)} (argument or FREEBODY_BACKEND).")
    chosen = _width(width)
    if backend == "numpy" or not _has_scalars(program):
        return Kernel(program, "numpy", 1, emit_numpy.BlockedFunction(program, emit_numpy.emit(optimise(program))))
    machine = target.host().target(chosen)
    code = target.object_code(emit_llvm.emit(optimise(program), machine))
    address, keep = target.link(code)
    ufunc = make_gufunc(address, program.name, program.inputs, program.outputs, keep)
    return Kernel(program, "llvm", machine.width, ufunc)


def _default_backend() -> str:
    return "llvm" if importlib.util.find_spec("llvmlite") else "numpy"


def _width(width: int | None) -> int | None:
    given = os.environ.get("FREEBODY_WIDTH") if width is None else str(width)
    if not given:
        return None
    if given not in map(str, target.WIDTHS):
        known = ", ".join(map(str, target.WIDTHS))
        raise KernelError(f"no width {given}. Widths: {known} (argument or FREEBODY_WIDTH).")
    return int(given)


def _has_scalars(program: Program) -> bool:
    """Whether NumPy can make a gufunc of it: no argument is empty, and there is an input."""
    arguments: tuple[Argument, ...] = program.inputs + program.outputs
    return bool(program.inputs) and all(argument.size for argument in arguments)
