"""The command `freebody studio`."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from freebody.cli import numbers, options, terminal
from freebody.outputs.files import stem, write

EXAMPLE = "Example: freebody studio ur5e --no-open"


@options.collected(
    wrench="the page has a load at the tip instead; --payload gives one that stays.",
    speed="the page has no motion; freebody study has.",
)
def studio(
    robot: options.GivenRobot,
    q: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help='Where it stands first: positions in rad and m, or "30 deg", in the joints\' '
            "order; loops are closed near them. Default: a pose in which it is clearly visible.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="The page. Default: ROBOT-studio.html.")
    ] = None,
    opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the page in the browser.")
    ] = True,
) -> None:
    """Write a page in which the robot is moved by hand, and open it: joints and tip dragged, the
    torques that hold it, singular poses, a simulation from where it stands."""
    model = robot.load()
    with terminal.progress("studio"):
        from freebody.studio.studio_page import studio_page

        start = None if q is None else numbers.values("--q", q)
        path = write(out or Path(f"{stem(model.name)}-studio.html"), studio_page(model, start))
    terminal.out().print(f"written: {path}", soft_wrap=True)
    if opened and not webbrowser.open(path.resolve().as_uri()):
        terminal.out().print("no browser was found; open the file in one", soft_wrap=True)
