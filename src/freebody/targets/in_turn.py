"""Many calls of a kernel one after the other in compiled code: an output of one may be an input of
the next; the samples of each call are computed side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.targets.kernel import Kernel
from freebody.targets.threads import cpus, run_split


@dataclass(frozen=True, eq=False)
class Placed:
    """An argument with another place at each step: at step k it is row `row[k]` of
    `arrays[which[k]]`, (R, N, *core) each."""

    arrays: tuple[Array, ...]
    which: NDArray[np.intp]
    row: NDArray[np.intp]


def in_turn(kernel: Kernel, arguments: Sequence[Array | Placed], steps: int, samples: int) -> None:
    """Call a kernel step after step; an output of one step may be an input of the next, and may
    overwrite an input of its own step.

    arguments: the kernel's inputs, then its outputs, of its own numbers: (*core), (N, *core) or
    (T, N, *core), where N and T may be 1 for what is the same everywhere; or `Placed`.
    """
    if kernel.loop is None:
        _one_by_one(kernel, arguments, steps)
        return
    from freebody.targets.llvm.scan import repeated

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
    """Strides of an argument from step to step, from sample to sample, and along the core; 0 where
    it stays the same."""
    batch, shape, own = x.ndim - core, x.shape, x.strides
    rows, lanes = shape[0] if batch == 2 else 1, shape[batch - 1] if batch else 1
    assert rows in (1, steps), (rows, steps)
    assert lanes in (1, samples), (lanes, samples)
    return own[0] if rows > 1 else 0, own[batch - 1] if lanes > 1 else 0, own[batch:]


def _one_by_one(kernel: Kernel, arguments: Sequence[Array | Placed], steps: int) -> None:
    """Make the calls one after the other in Python."""
    cores = [len(x.shape) for x in kernel.program.inputs + kernel.program.outputs]
    count = len(kernel.program.inputs)
    for k in range(steps):
        now = [_at(x, core, k) for x, core in zip(arguments, cores, strict=True)]
        kernel.ufunc(*now[:count], out=tuple(now[count:]))


def _at(x: Array | Placed, core: int, k: int) -> Array:
    """The value of an argument at step k."""
    if isinstance(x, Placed):
        return x.arrays[x.which[k]][x.row[k]]
    return x[k if len(x) > 1 else 0] if x.ndim == core + 2 else x


_FEW = 3
"""Samples that are as soon done one by one, by code for a single one."""
_FEWEST = 16
"""Samples that a further thread is woken for, at least: whole vectors."""


def recurrence(kernel: Kernel, first: Array, *sequences: Array) -> Array:
    """The states (T + 1, N, s) of a kernel applied repeatedly, from the first state (N, s) and the
    inputs (T, N, …) of T steps.

    Arrays of float64 with any strides; a sequence whose axis runs backwards takes the steps from
    its end. Nothing is broadcast.
    """
    count, batch = sequences[0].shape[0], first.shape[0]
    states = np.empty((count + 1, *first.shape))
    states[0] = first
    if not (count and batch):
        return states
    if kernel.loop is not None and batch <= _FEW:
        _alone(kernel, [states, *sequences])
        return states
    worth = 2 * kernel.samples_of_a_thread / count
    threads = max(1, min(cpus(), int(batch / max(_FEWEST, worth))))

    def steps(own: Array, *given: Array) -> None:
        in_turn(kernel, (own[:-1], *given, own[1:]), count, own.shape[1])

    if threads == 1:
        steps(states, *sequences)
        return states
    by_sample = [np.moveaxis(x, 1, 0) for x in (states, *sequences)]

    def part(*arrays: np.ndarray, out: tuple[np.ndarray, ...]) -> None:
        steps(*(np.moveaxis(x, 0, 1) for x in (*out, *arrays)))

    cores = [x.ndim - 1 for x in by_sample]
    run_split(part, by_sample[1:], by_sample[:1], [*cores[1:], cores[0]], (batch,), threads)
    return states


def _alone(kernel: Kernel, arrays: Sequence[Array]) -> None:
    """Run a recurrence sample by sample; arrays: states, then input sequences, which are copied
    where an entry is not contiguous."""
    from freebody.targets.llvm.scan import scan

    scanned = scan(kernel)
    whole = [x if x[0, 0].flags.c_contiguous else np.ascontiguousarray(x) for x in arrays]
    for k in range(arrays[0].shape[1]):
        scanned(*(x[:, k] for x in whole))
