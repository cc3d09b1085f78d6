"""A kernel applied again and again: what comes out of one step goes into the next.

The kernel's first input and its only output are the state; its other inputs have a value for each
step. Steps follow one another, the samples of a batch are computed side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from freebody.arrays import Array
from freebody.targets.kernel import Kernel, compile_program
from freebody.targets.target import target_named
from freebody.targets.threads import cpus, run_split

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
    step = _stepper(kernel)
    worth = 2 * kernel.samples_of_a_thread / count
    threads = max(1, min(cpus(), int(batch / max(_FEWEST, worth))))
    if threads == 1:
        step(states, *sequences)
        return states
    by_sample = [np.moveaxis(x, 1, 0) for x in (states, *sequences)]

    def part(*arrays: np.ndarray, out: tuple[np.ndarray, ...]) -> None:
        step(*(np.moveaxis(x, 0, 1) for x in (*out, *arrays)))

    cores = [x.ndim - 1 for x in by_sample]
    run_split(part, by_sample[1:], by_sample[:1], [*cores[1:], cores[0]], (batch,), threads)
    return states


def narrowest(kernel: Kernel) -> Kernel:
    """The kernel of the same program with the narrowest vectors that its target has: a step of few
    samples, which waits for the one before, is sooner done."""
    widths = target_named(kernel.target).widths[kernel.dtype.name]
    return compile_program(
        kernel.program,
        target=kernel.target,
        width=min(widths, default=None),
        dtype=kernel.dtype.name,
    )


def _stepper(kernel: Kernel) -> Callable[..., None]:
    """A function of (states, *sequences) that fills in all states after the first."""
    if kernel.loop is None:
        return lambda states, *sequences: _one_by_one(kernel, states, sequences)
    from freebody.targets.llvm.repeat import repeated

    loop = kernel.loop
    return lambda states, *sequences: repeated(loop, states, sequences)


def _one_by_one(kernel: Kernel, states: Array, sequences: Sequence[Array]) -> None:
    """Without compiled code."""
    for k, values in enumerate(zip(*sequences, strict=True)):
        states[k + 1] = kernel(states[k], *values)
