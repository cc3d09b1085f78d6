"""The command `freebody calibrate`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import numbers, options, terminal, verdicts

if TYPE_CHECKING:
    from freebody.identification.calibration.poses import Poses
    from freebody.model.model import Model

EXAMPLE = "Example: freebody calibrate ur5e simulated --out calibrated"


@options.collected(
    wrench="measured poses tell the geometry, in which no force has a part.",
    speed="poses are measured at rest; there is no motion.",
)
def calibrate(
    context: typer.Context,
    robot: options.GivenRobot,
    poses: Annotated[
        str,
        typer.Argument(
            metavar="POSES",
            help="Measured poses (.csv, .parquet): a row has the joints by name and x, y, z of the "
            "marker, with rotations qw, qx, qy, qz too; units in the header, as in x (mm). Or "
            "simulated, poses of a robot that is slightly off its model.",
        ),
    ],
    frame: options.FrameOption = None,
    validate: Annotated[
        str | None,
        typer.Option(metavar="POSES", help="Poses to predict, which are used for nothing else."),
    ] = None,
    shift: Annotated[
        float,
        typer.Option(help="By how much joints' frames may be shifted: standard deviation, m."),
    ] = 1e-3,
    turn: Annotated[
        float, typer.Option(help="By how much they may be turned: standard deviation, rad.")
    ] = 1e-3,
    offset: Annotated[
        float,
        typer.Option(help="By how much joints' zeros may be off: standard deviation, rad (m)."),
    ] = 1e-3,
    gears: Annotated[
        float | None,
        typer.Option(help="Standard deviation of factors of the readings. Default: exact."),
    ] = None,
    noise: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="Standard deviation of measured coordinates: m, with rotations m,rad. Default: "
            "estimated.",
        ),
    ] = None,
    marker: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Where the marker sits in the frame, m. Default: found with the rest.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder for the robot (model.toml), the report, and it as JSON."
        ),
    ] = None,
) -> None:
    """A robot's geometry from measured poses of its tip, with intervals, and what these poses do
    not tell.

    Exit status 0: poses are predicted better than before, and as well as they were measured. 1:
    they are not. 2: bad input.
    """
    from freebody.identification.calibration.calibrate import calibrate as calibrated
    from freebody.identification.result_files import write_calibration

    with terminal.progress("reading"):
        model = robot.load()
        seen = _poses(poses, model, frame, 0)
        unseen = None if validate is None else _poses(validate, model, frame, 1)
    given: dict[str, Any] = {
        "frame": frame, "shift": shift, "turn": turn, "offset": offset, "gears": gears
    }  # fmt: skip
    if marker is not None:
        given["marker"] = numbers.values("--marker", marker)
    if noise is not None:
        given["noise"] = numbers.values("--noise", noise)
    with terminal.progress("calibrate"):
        found = calibrated(model, seen, validate=unseen, **given)
    files = [x for x in (poses, validate) if x is not None]
    write = None if out is None else partial(write_calibration, found, out, files)
    verdicts.conclude(context, found, write=write)


def _poses(text: str, model: Model, frame: str | None, seed: int) -> Poses:
    from freebody.identification.calibration.read_poses import read_poses
    from freebody.identification.calibration.simulated import simulated_poses

    return verdicts.measured(
        text, lambda file: read_poses(file, model), lambda: simulated_poses(model, frame, seed)
    )
