"""The segments of a duty cycle as a study and a payload take them: each with the robot as it is
loaded, and constant wrenches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from freebody.arrays import Array, refuse_not_finite
from freebody.design.duty_cycle import DutyCycle
from freebody.errors import FreebodyError
from freebody.model.model import Model
from freebody.motion.motion import Motion, require_motion
from freebody.trees.public_calls import wrenches_by_frame


@dataclass(frozen=True, eq=False)
class LoadedSegment:
    """A segment of a duty cycle: its number from 1, the robot with its payload, the motion, the
    constant wrenches on the robot by frame, and the rest behind it (s)."""

    number: int
    model: Model
    motion: Motion
    wrenches: dict[str, Array]
    dwell: float


def loaded_segments(
    function: str, model: Model, cycle: DutyCycle, wrenches: Mapping[str, Array] | None = None
) -> tuple[LoadedSegment, ...]:
    """The segments of a duty cycle of a model; wrenches: further ones, in every segment. Refuses
    wrenches that change over time."""
    found = []
    for k, segment in enumerate(cycle.segments, 1):
        require_motion(function, model, segment.motion)
        own = wrenches_by_frame(function, model, segment.wrenches)
        for frame, load in own.items():
            if load.ndim > 1:
                raise FreebodyError(
                    f"{function}: the wrench at {frame!r} of segment {k} changes over time, and "
                    f"constant ones are needed; divide the segment, or ask fb.drive_loads, which "
                    f"takes it as it is."
                )
            refuse_not_finite(function, f"segment {k}, wrenches[{frame!r}]", load, 1)
        every = dict(wrenches or {})
        for frame, load in own.items():
            every[frame] = every[frame] + load if frame in every else load
        found.append(
            LoadedSegment(k, segment.carried_by(model), segment.motion, every, segment.dwell)
        )
    return tuple(found)
