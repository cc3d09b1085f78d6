"""The command `freebody diff`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from freebody.cli import numbers, options, terminal

EXAMPLE = "Example: freebody diff ur5e ur5e"


@options.collected(
    wrench="two robots are compared, and nothing pulls at them.",
    speed="two robots are compared; there is no motion.",
)
def diff(
    robot: options.GivenRobot,
    other: options.GivenRobot,
    tolerance: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            parser=numbers.number,
            help="Differences that are none: relative, rad, and in lengths a share of the longest "
            "chain.",
        ),
    ] = 1e-5,
    as_json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
) -> None:
    """Tell whether two files are of the same robot, or where they differ and by how much: joints,
    geometry, masses, limits, friction.

    Where the base stands, the tool's frame, zeros and directions of joints, frames of links, names
    and split links do not count, and are told. Exit status 0: the same robot. 1: another one. 2: a
    file cannot be read.
    """
    from freebody.diagnosis.same_robot import same_robot

    found = same_robot(robot.load(), other.load(), tolerance=tolerance)
    out = terminal.out()
    if as_json:
        out.print(json.dumps(found.data, indent=2, ensure_ascii=False), soft_wrap=True)
    else:
        out.print(found.title, style="bold green" if found else "bold red")
        for line in (*map(str, found.differences), *found.regardless):
            out.print(line, soft_wrap=True)
    raise typer.Exit(0 if found else 1)
