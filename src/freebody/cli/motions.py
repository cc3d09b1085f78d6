"""Motions and duty cycles on the command line: one option for all commands that take them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from freebody.design.duty_cycle import DutyCycle
    from freebody.model.model import Model
    from freebody.motion.motion import Motion

_NAMES = ("--motion", "--cycle")
_WHAT = (
    "What the robot does: a motion, a CSV file whose header names t (s) and the joints (rad, m; or "
    "a unit, as in 'joint1 (deg)'); or a duty cycle, a TOML file with what is carried in each "
    "segment."
)

GivenMotion = Annotated[
    Path | None,
    typer.Option(*_NAMES, metavar="FILE", help=f"{_WHAT} Default: a motion within the limits."),
]
GivenMotions = Annotated[
    list[Path] | None,
    typer.Option(
        *_NAMES,
        metavar="FILE",
        help=f"{_WHAT} Several, if it has to be able to do each. Default: a motion within the "
        "limits.",
    ),
]
MotionInsteadOfPostures = Annotated[
    Path | None,
    typer.Option(*_NAMES, metavar="FILE", help=f"{_WHAT} Default: postures, at rest."),
]


def read(model: Model, file: Path, speed: float = 1.0) -> Motion | DutyCycle:
    """The motion or the duty cycle of a model that a file holds, run `speed` times as fast."""
    from freebody.design.duty_cycle import DutyCycle
    from freebody.motion.files.csv_files import read_motion

    if file.suffix.lower() != ".toml":
        motion = read_motion(model, file)
        return motion if speed == 1.0 else motion.faster(speed)
    cycle = DutyCycle.read(model, file)
    if speed == 1.0:
        return cycle
    return replace(
        cycle, segments=[replace(x, motion=x.motion.faster(speed)) for x in cycle.segments]
    )


def read_cycle(model: Model, file: Path | None) -> DutyCycle:
    """A duty cycle from a file, a motion being one of a single segment; without a file that of the
    default motion."""
    from freebody.design.duty_cycle import DutyCycle, Segment
    from freebody.motion.default_motion import default_motion

    found = default_motion(model) if file is None else read(model, file)
    if isinstance(found, DutyCycle):
        return found
    return DutyCycle([Segment(found)], source=found.source if file is None else file.name)
