"""Many calls of a kernel, one after the other, in compiled code: an output of one may be an input
of the next; the samples of each are computed side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.targets.kernel import Kernel


@dataclass(frozen=True, eq=False)
class Placed:
    """An argument that lies elsewhere at each step: at step k in row `row[k]` of
    `arrays[which[k]]`, (R, N, *core) each."""

    arrays: tuple[Array, ...]
    which: NDArray[np.intp]
    row: NDArray[np.intp]


def in_turn(kernel: Kernel, arguments: Sequence[Array | Placed], steps: int, samples: int) -> None:
    """Call a kernel step after step; an output of one step may be an input of the next, and lie
    where an input of its own step does.

    arguments: the kernel's inputs, then its outputs, of its own numbers: (*core), (N, *core) or
    (T, N, *core), where N and T may be 1 for what is the same everywhere; or `Placed`.
    """
    if kernel.loop is None:
        _one_by_one(kernel, arguments, steps)
        return
    from freebody.targets.llvm.repeat import repeated

    program = kernel.program
    first, moves, strides, inner, placed = [], [], [], [], []
    for x, argument in zip(arguments, program.inputs + program.outputs, strict=True):
        core = len(argument.shape)
        if isinstance(x, Placed):
            placed.append((len(first), len(inner), core, x))
            address, move, stride, entries = 0, 0, 0, (0,) * core
        else:
            address, (move, stride, entries) = x.ctypes.data, _strides(x, core, steps, samples)
        first.append(address)
        moves.append(move)
        strides.append(stride)
        inner += entries
    addresses = np.array(first) + np.arange(steps)[:, None] * moves
    table = np.array([strides + inner])
    if placed:
        table = np.repeat(table, steps, axis=0)
    for k, begin, core, x in placed:
        here = np.array([[one.ctypes.data, *one.strides] for one in x.arrays])[x.which]
        addresses[:, k] = here[:, 0] + x.row * here[:, 1]
        begin += len(first)
        table[:, k], table[:, begin : begin + core] = here[:, 2], here[:, 3:]
    repeated(kernel.loop, samples, addresses, table)


def _strides(x: Array, core: int, steps: int, samples: int) -> tuple[int, int, tuple[int, ...]]:
    """From step to step, from sample to sample, and of the core; 0 where it is the same."""
    batch, shape, own = x.ndim - core, x.shape, x.strides
    rows, lanes = shape[0] if batch == 2 else 1, shape[batch - 1] if batch else 1
    assert rows in (1, steps), (rows, steps)
    assert lanes in (1, samples), (lanes, samples)
    return own[0] if rows > 1 else 0, own[batch - 1] if lanes > 1 else 0, own[batch:]


def _one_by_one(kernel: Kernel, arguments: Sequence[Array | Placed], steps: int) -> None:
    """The same without compiled code."""
    cores = [len(x.shape) for x in kernel.program.inputs + kernel.program.outputs]
    count = len(kernel.program.inputs)
    for k in range(steps):
        now = [_at(x, core, k) for x, core in zip(arguments, cores, strict=True)]
        kernel.ufunc(*now[:count], out=tuple(now[count:]))


def _at(x: Array | Placed, core: int, k: int) -> Array:
    """What an argument is at step k."""
    if isinstance(x, Placed):
        return x.arrays[x.which[k]][x.row[k]]
    return x[k if len(x) > 1 else 0] if x.ndim == core + 2 else x
