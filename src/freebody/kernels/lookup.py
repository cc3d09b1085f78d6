"""The way from a model and the names of formulas to their kernel, specialised to the model's
numbers; large square matrices column by column, by programs whose length grows with the robot and
not with its square.

Straight-line code for the n² entries of M, C or a derivative would take minutes to compile from
some hundred joints on. Beyond `LARGEST` coordinates each column is one evaluation of the matrix
times a unit vector, all columns in one batch.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, check_core
from freebody.errors import FreebodyError, ShapeError
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.formulas.record import Fetch
from freebody.kernels.inputs import InputKernel, input_kernel, inputs_of
from freebody.kernels.tracing import arguments, program
from freebody.lazy import cached_property
from freebody.model.losses import require_lossless
from freebody.model.model import Model
from freebody.model.named_numbers import Name
from freebody.program import Argument, Program
from freebody.targets import Kernel, compile_program
from freebody.targets.call_errors import require_count


def fetch(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: tuple[Name, ...] = (),
    by: tuple[str, ...] = (),
) -> Any:
    """The kernel of some quantities of a model, compiled on first use and kept as long as the
    model."""
    key = (names, option, target, width, dtype, inputs, by)
    found = model.compiled.get(key)
    if found is None:
        large = _large(model, names)
        if large and dtype != "float64":
            raise FreebodyError(
                f"fb.kernel: {large[0]} of {model.nv} coordinates is computed column by column, "
                f"which is available in float64 only (dtype={dtype!r} up to {LARGEST} coordinates)."
            )
        if inputs or by or model.family:
            found = _with_inputs(model, names, option, target, width, dtype, inputs, by)
        else:
            found = in_columns(
                model,
                names,
                option,
                lambda part: fetch(model, (part,), Option(), target, width),
                lambda some: fetch(model, some, option, target, width),
            ) or compile_program(
                program(model, names, option), target=target, width=width, dtype=dtype
            )
        model.compiled[key] = found
    return found


def in_columns(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    fetch_product: Callable[[str], Any],
    fetch_some: Callable[[tuple[str, ...]], Any],
) -> ColumnKernel | KernelList | None:
    """The kernel of a large robot's quantities, whose large matrices are computed column by column;
    None where all fit in one program.

    fetch_product: the kernel of a formula that columns come from; fetch_some: of some of the
    quantities.
    """
    if not _large(model, names):
        return None

    def whole() -> Program:
        return program(model, names, option)

    if len(names) == 1:
        inputs = arguments(model, names, option)
        return ColumnKernel(names[0], inputs, model.nv, fetch_product, whole)
    return _in_parts(model, names, option, fetch_some, whole)


def _large(model: Model, names: tuple[str, ...]) -> list[str]:
    """The names of the quantities that are computed column by column for a model of this many
    coordinates."""
    large = [name for name in names if FORMULAS[name].by_columns] if model.nv > LARGEST else []
    for name in large:
        if FORMULAS[name].columns_lossless:
            require_lossless(name, model, f" of more than {LARGEST} coordinates")
    return large


def _with_inputs(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    target: str | None,
    width: int | None,
    dtype: str,
    wanted: tuple[Name, ...],
    by: tuple[str, ...],
) -> Kernel | InputKernel:
    """A kernel with numbers of the model as inputs, or with derivatives as outputs."""
    large = _large(model, names)
    if large:
        raise FreebodyError(
            f"fb.kernel: {large[0]} of {model.nv} coordinates is computed column by column, which "
            f"takes no inputs=, by= or family (up to {LARGEST} coordinates they do)."
        )
    if not wanted and not model.family:
        return compile_program(
            program(model, names, option, by=by), target=target, width=width, dtype=dtype
        )
    given = inputs_of("fb.kernel", model, wanted)
    # a family's numbers never stand still along the batch
    p = Argument("p", (len(given.names),), uniform=not model.family)
    traced = program(model, names, option, p, given.tree, by)
    compiled = compile_program(traced, target=target, width=width, dtype=dtype)
    return input_kernel(compiled, given.names, given.values, model)


def _in_parts(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    fetch_some: Callable[[tuple[str, ...]], Any],
    whole: Callable[[], Program],
) -> KernelList:
    """A kernel list: each large matrix by columns in a kernel of its own, all other quantities in
    one program that shares their work."""
    large = _large(model, names)
    together = tuple(name for name in names if name not in large)
    groups = [(name,) for name in large] + ([together] if together else [])
    first, places = 0, {}
    for name in names:
        places[name] = list(range(first, first + len(FORMULAS[name].outputs)))
        first += len(FORMULAS[name].outputs)
    parts = [
        (
            fetch_some(some),
            [a.name for a in arguments(model, some, option)],
            [k for x in some for k in places[x]],
        )
        for some in groups
    ]
    return KernelList(arguments(model, names, option), parts, whole)


LARGEST = 64
"""Coordinates up to which a matrix is one straight-line program."""


class _InParts:
    """A computation by several kernels which could also be written as one program."""

    def __init__(self, inputs: tuple[Argument, ...], whole: Callable[[], Program]):
        self.inputs, self._whole = inputs, whole

    @cached_property
    def program(self) -> Program:
        """The whole computation as one program, traced on first access; it grows with the square of
        the robot's size, and is never run."""
        return self._whole()


class ColumnKernel(_InParts):
    """A kernel that computes a large matrix column by column, called like a `Kernel` of the
    formula: (..., n) inputs, (..., n, n) outputs."""

    def __init__(
        self,
        name: str,
        inputs: tuple[Argument, ...],
        n: int,
        fetch: Fetch,
        whole: Callable[[], Program],
    ):
        super().__init__(inputs, whole)
        self.name, self.n, self.fetch = name, n, fetch

    def __call__(self, *arrays: ArrayLike, out: Any = None, threads: int | None = None) -> Any:
        """The matrix, or the tuple of them; `out` receives copies. Refuses what a `Kernel`
        refuses."""
        self._check(arrays)
        given = [np.asarray(a, dtype=float)[..., None, :] for a in arrays]
        compute = FORMULAS[self.name].by_columns
        assert compute is not None
        results = compute(given, self.n, self.fetch, threads)
        results = tuple(np.swapaxes(columns, -1, -2) for columns in results)
        if out is not None:
            targets: tuple[Array, ...] = out if isinstance(out, tuple) else (out,)
            for target, result in zip(targets, results, strict=True):
                if target.shape != result.shape:
                    raise ShapeError(self.name, "out", target.shape, str(result.shape))
                np.copyto(target, result, casting="same_kind")
            results = targets
        return results[0] if len(results) == 1 else results

    def _check(self, arrays: tuple[ArrayLike, ...]) -> None:
        require_count(self.name, arrays, self.inputs)
        for argument, array in zip(self.inputs, arrays, strict=True):
            given = as_floats(self.name, argument.name, array)
            check_core(self.name, argument.name, given, argument.shape)

    def __repr__(self) -> str:
        return f"ColumnKernel({self.name}: {', '.join(map(str, self.inputs))}; n = {self.n})"


class KernelList(_InParts):
    """Several quantities of a large robot behind one call, each part a kernel of its own.

    Called like a `Kernel` of them all; only, a sample has NaN in the quantities whose own inputs
    are not finite.
    """

    def __init__(
        self,
        inputs: tuple[Argument, ...],
        parts: list[tuple[Any, list[str], list[int]]],
        whole: Callable[[], Program],
    ):
        """Take over the parts: each kernel, the names of its inputs, and the indices of its outputs
        among those of the whole."""
        super().__init__(inputs, whole)
        self.parts = parts

    def __call__(
        self, *arrays: ArrayLike, out: tuple[Array, ...] | None = None, threads: int | None = None
    ) -> Any:
        """The outputs in order; refuses what a `Kernel` refuses."""
        require_count("fb.kernel", arrays, self.inputs)
        cores = [len(argument.shape) for argument in self.inputs]
        values = [np.asarray(array) for array in arrays]
        batch = np.broadcast_shapes(
            *(x.shape[: x.ndim - n] for x, n in zip(values, cores, strict=True))
        )
        given = {
            argument.name: np.broadcast_to(x, batch + x.shape[x.ndim - len(argument.shape) :])
            for argument, x in zip(self.inputs, values, strict=True)
        }
        results: dict[int, Array] = {}
        for kernel, names, places in self.parts:
            into = None if out is None else tuple(out[k] for k in places)
            found = kernel(*(given[name] for name in names), out=into, threads=threads)
            results |= zip(places, found if isinstance(found, tuple) else (found,), strict=True)
        return tuple(results[k] for k in sorted(results))

    def __repr__(self) -> str:
        return f"KernelList({', '.join(repr(kernel) for kernel, _, _ in self.parts)})"
