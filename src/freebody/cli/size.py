"""The command `freebody size`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from freebody.cli import motions, numbers, options, terminal
from freebody.outputs.display import TextTable

if TYPE_CHECKING:
    from freebody.design.size import Sizing

EXAMPLE = "Example: freebody size scara --catalogue invented --margin 1.2"
_MOST = 12


@options.collected(
    wrench="what pulls at the robot belongs to a segment of a duty cycle; give it there.",
    speed="a duty cycle is taken as it is; write a faster motion with fb.Motion.faster.",
)
def size(
    context: typer.Context,
    robot: options.GivenRobot,
    catalogue: Annotated[
        str,
        typer.Option(
            metavar="FILE",
            help="Motors and gears, TOML; or invented, a small catalogue for trying this out that "
            "no maker sells.",
        ),
    ],
    motion: motions.GivenMotions = None,
    smooth: motions.GivenSmooth = None,
    joint: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A joint to choose for. Default: all that are driven."),
    ] = None,
    mount: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOINT=FRAME",
            help="The frame on which a joint's drive rides, or ground. Default: the link before "
            "the joint.",
        ),
    ] = None,
    life: Annotated[
        float,
        typer.Option(metavar="HOURS", parser=numbers.number, help="How long gears have to last."),
    ] = 0.0,
    margin: Annotated[
        float,
        typer.Option(
            metavar="RATIO",
            parser=numbers.number,
            help="What is allowed over what is used, at least.",
        ),
    ] = 1.0,
    hold: Annotated[
        bool,
        typer.Option("--hold", help="Every motor must have a brake that holds its joint."),
    ] = False,
    rejected: Annotated[
        str | None,
        typer.Option(metavar="JOINT", help="List the pairs that do not suffice there, and why."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="File for the robot with the lightest choice, such as arm.toml."
        ),
    ] = None,
) -> None:
    """Choose motors and gears for what a robot has to do: all choices of which no other is lighter,
    cheaper and safer at once.

    Exit status 0: there are choices. 1: for some joint nothing in the catalogue suffices. 2:
    something cannot be read or written.
    """
    from freebody.design.catalogue import catalogue as read
    from freebody.design.choices import FITS
    from freebody.design.pairs import used
    from freebody.design.size import size as chosen

    with terminal.progress("reading") as tell:
        model = robot.load()
        parts = read(catalogue)
        found = chosen(
            model,
            [motions.read_cycle(model, file, motions.cutoff(smooth)) for file in motion or (None,)],
            parts,
            joints=joint,
            mounts=_mounts(mount),
            life=life,
            margin=margin,
            hold=hold,
            progress=tell,
        )
    if parts.note:
        terminal.out().print(parts.note, markup=False, highlight=False)
    _print(found)
    if rejected is not None:
        rows = [
            (x.motor, x.gear, x.limit, "" if x.limit == FITS else used(x.share))
            for x in found.rejected(rejected)
        ]
        allowed = f"used, at most {100.0 / margin:.3g} %"
        terminal.table(TextTable(("motor", "gear", "limit", allowed), rows))
    if out is not None and found.choices:
        from freebody.formats.saving import save

        save(found.drive_loads().model, out)
        terminal.out().print(f"written: {out}", soft_wrap=True, markup=False, highlight=False)
    terminal.out().print(f"again:  {options.again(context)}", soft_wrap=True, highlight=False)
    if not found.choices:
        raise typer.Exit(1)


def _mounts(given: list[str] | None) -> dict[str, str | None]:
    pairs = numbers.pairs("--mount", given, "joint3=base")
    return {joint: None if frame == "ground" else frame for joint, frame in pairs.items()}


def _print(found: Sizing) -> None:
    from freebody.design.drive_loads import limit_table
    from freebody.design.size import choice_table

    out = terminal.out()
    for cycle in found.cycles:
        out.print(f"{cycle!r}"[1:-1], markup=False, highlight=False)
    notices = found.notices
    if found.choices:
        loads = found.drive_loads()
        terminal.table(replace(choice_table(found, _MOST), notes=()))
        if len(found.choices) > _MOST:
            out.print(f"… and {len(found.choices) - _MOST} more, heavier.")
        out.print("The lightest:")
        terminal.table(replace(limit_table(loads), notes=()))
        if found.carries:
            out.print(f"{found.heaviest()!r}"[1:-1] + ".", markup=False, highlight=False)
        notices = (*notices, *loads.notices)
    else:
        terminal.warn(notices[0])
        notices = notices[1:]
    for notice in dict.fromkeys(notices):
        out.print(notice, markup=False, highlight=False)
