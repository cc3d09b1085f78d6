"""Motions and duty cycles on the command line: one option for all commands that take them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from freebody.errors import FreebodyError
from freebody.formats.read_file import number

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

GivenSmooth = Annotated[
    str | None,
    typer.Option(
        metavar="HZ|auto",
        help="Smooth a measured motion, without delay: a cutoff in Hz, "
        "or auto to choose the cutoff from the noise.",
    ),
]


def cutoff(smooth: str | None) -> bool | float:
    """The cutoff frequency (Hz) that --smooth asks for; True for an automatic one, False for
    none."""
    if smooth is None or smooth == "auto":
        return smooth is not None
    given = number(smooth)
    if given is None or not given > 0.0:
        raise FreebodyError(
            f"--smooth is {smooth!r}, expected a cutoff in Hz above 0, such as 8, or auto."
        )
    return given


def read(
    model: Model, file: Path, speed: float = 1.0, smooth: bool | float = False
) -> Motion | DutyCycle:
    """The motion or the duty cycle of a model that a file holds, smoothed as `cutoff` tells, run
    `speed` times as fast."""
    from freebody.design.duty_cycle import DutyCycle
    from freebody.motion.files.csv_files import read_motion
    from freebody.motion.files.measured_motions import smoothed

    if file.suffix.lower() != ".toml":
        motion = read_motion(model, file)
        if smooth is not False:
            motion = smoothed(model, motion, None if smooth is True else smooth)
        return motion if speed == 1.0 else motion.faster(speed)
    if smooth is not False:
        raise FreebodyError(
            f"--smooth is for one motion, and {file} is a duty cycle: its segments would no longer "
            f"meet. Smooth the whole in Python (fb.smoothed), then divide it."
        )
    cycle = DutyCycle.read(model, file)
    if speed == 1.0:
        return cycle
    return replace(
        cycle, segments=[replace(x, motion=x.motion.faster(speed)) for x in cycle.segments]
    )


def read_cycle(model: Model, file: Path | None, smooth: bool | float = False) -> DutyCycle:
    """A duty cycle from a file, a motion being one of a single segment, smoothed as `cutoff` tells;
    without a file that of the default motion."""
    from freebody.design.duty_cycle import DutyCycle, Segment
    from freebody.motion.default_motion import default_motion

    found = default_motion(model) if file is None else read(model, file, smooth=smooth)
    if isinstance(found, DutyCycle):
        return found
    return DutyCycle([Segment(found)], source=found.source if file is None else file.name)
