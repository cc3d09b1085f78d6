"""The command `freebody convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from freebody.cli import options, terminal

EXAMPLE = "Example: freebody convert ur5e ur5e.urdf"


@options.collected(
    wrench="a robot's file holds no wrenches.",
    speed="a robot's file holds no motion.",
)
def convert(
    robot: options.GivenRobot,
    out: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="The file to write: .toml, .urdf, .sdf, .xml or .mjcf (MJCF), .csv (DH table), or "
            ".fmu, its motion as a unit of co-simulation (FMI 2.0).",
        ),
    ],
    lossy: Annotated[
        bool,
        typer.Option("--lossy", help="Write it although the format does not hold all of it."),
    ] = False,
) -> None:
    """Write a robot in another format. What that format cannot hold is listed, and only written
    without it where --lossy says so."""
    from freebody.formats.saving import losses, save

    model = robot.load()
    if out.suffix.lower() == ".fmu":
        from freebody.ways_out.fmus import export_fmu

        with terminal.warnings_as_lines():
            export_fmu(model, out)
        terminal.out().print(f"written: {out}", soft_wrap=True, markup=False, highlight=False)
        return
    save(model, out, lossy=lossy)
    for loss in losses(model, out.suffix[1:].lower()) if lossy else ():
        terminal.out().print(f"lost: {loss}", soft_wrap=True, markup=False, highlight=False)
    terminal.out().print(f"written: {out}", soft_wrap=True, markup=False, highlight=False)
