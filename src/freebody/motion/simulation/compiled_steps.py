"""Equal steps of many motions, many in each call of compiled code."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.motion.simulation.course import Track
from freebody.motion.simulation.step_sizes import step_counts
from freebody.motion.simulation.steppers import KernelStepper
from freebody.targets.in_turn import Placed

STAYING = 1024
"""Motions whose states, numbers and torques stay in a processor's caches from step to step."""
_MOST = 4096
"""Steps of a call, whose addresses stay there too."""


@dataclass(eq=False)
class CompiledSteps:
    """Equal steps of at most `step` (s; None: one from edge to edge). See `Advance`."""

    stepper: KernelStepper
    step: float | None
    stop: threading.Event
    block: int = STAYING

    def __call__(self, track: Track, block: slice, first: int, last: int) -> Iterator[float]:
        """See `Advance`; between two rows of the result the states move on where they are, and to
        and from these rows without a copy."""
        way = track.course
        begins, ends = way.begins[first:last], way.ends[first:last]
        counts = step_counts(ends - begins, self.step)
        lengths, passed = (ends - begins) / counts, np.cumsum(counts)
        state = [x[block][None] for x in track.state]
        kept = [x[:, 0].swapaxes(0, 1) for x in track.kept(block)]
        places, row = [*zip(state, kept, strict=True)], -1
        at_once = min(_MOST, max(1, self.stepper.kernel.at_once // (block.stop - block.start)))
        for begin in range(0, passed[-1], at_once):
            if self.stop.is_set():
                return
            steps = np.arange(begin, min(begin + at_once, passed[-1]))
            span = np.searchsorted(passed, steps, side="right")
            h = lengths[span]
            start = begins[span] + (steps - (passed - counts)[span]) * h
            rows = np.where(steps + 1 == passed[span], way.rows[first + 1 + span], -1)
            before, row = np.append(row, rows[:-1]), rows[-1]
            self.stepper.in_turn(
                block,
                [Placed(x, *here) for here in map(_place, (before, rows)) for x in places],
                start,
                h,
            )
            yield float(start[-1] + h[-1])
        if row >= 0:
            for x, every in places:
                x[0] = every[row]


def _place(rows: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Of steps that end at rows of the result, or at none: -1, whether in the result, and where."""
    return (rows >= 0).astype(np.intp), np.maximum(rows, 0)
