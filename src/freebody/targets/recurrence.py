"""A kernel applied again and again: what comes out of one step goes into the next.

The kernel's first input and its only output are the state; its other inputs have a value for each
step, none is uniform. Steps follow one another, the samples of a batch are computed side by side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.targets.in_turn import in_turn
from freebody.targets.kernel import Kernel
from freebody.targets.threads import cpus, run_split

_FEW = 3
"""Samples that are as soon done one by one, by code for a single one."""
_FEWEST = 16
"""Samples that a further thread is woken for, at least: whole vectors."""


def recurrence(kernel: Kernel, first: Array, *sequences: Array) -> Array:
    """States (T + 1, N, s) from the first one (N, s), and inputs (T, N, …) of T steps.

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
    """Sample by sample: states, then sequences, whose entries are to lie in one piece each."""
    from freebody.targets.llvm.scan import scan

    scanned = scan(kernel)
    whole = [x if x[0, 0].flags.c_contiguous else np.ascontiguousarray(x) for x in arrays]
    for k in range(arrays[0].shape[1]):
        scanned(*(x[:, k] for x in whole))
