"""Large square matrices column by column, by programs whose length grows with the robot and not
with its square.

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
from freebody.errors import ShapeError
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.formulas.record import Fetch
from freebody.lazy import cached_property
from freebody.program import Argument, Program
from freebody.targets.call_errors import require_count

LARGEST = 64
"""Coordinates up to which a matrix is one straight-line program."""


class _InParts:
    """A computation by several kernels that could be one program."""

    def __init__(self, inputs: tuple[Argument, ...], whole: Callable[[], Program]):
        self.inputs, self._whole = inputs, whole

    @cached_property
    def program(self) -> Program:
        """The whole computation as one program, traced on first access and run by nothing here: it
        grows with the square of the robot."""
        return self._whole()


class ColumnKernel(_InParts):
    """Called like a `Kernel` of the same formula: (..., n) inputs, (..., n, n) outputs."""

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
        """parts: kernel, names of its inputs, and which outputs of the whole its outputs are."""
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
