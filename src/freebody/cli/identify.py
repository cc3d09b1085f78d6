"""The command `freebody identify`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import numbers, options, terminal

if TYPE_CHECKING:
    from freebody.identification.logs.log import Log
    from freebody.model.model import Model

EXAMPLE = "Example: freebody identify scara simulated --validate simulated --out identified"
_SIMULATED = "simulated"


@options.reading(*options.FILE)
def identify(
    context: typer.Context,
    robot: options.GivenRobot,
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG…",
            help="Logs of the robot (.csv, .parquet), with a TOML file of their columns beside "
            "them where the names of these do not tell; or simulated, a log made from the model.",
        ),
    ],
    validate: Annotated[
        list[str] | None,
        typer.Option(metavar="LOG", help="A log to predict, which is used for nothing else."),
    ] = None,
    friction: Annotated[
        str | None,
        typer.Option(
            metavar="LAWS",
            help="Laws of friction, apart by commas. Default: "
            "viscous,coulomb,offset,cube_root,quadratic,load.",
        ),
    ] = None,
    masses: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="Masses of the links in order, kg, as a data sheet has them. Default: the robot's "
            "own, if it has some.",
        ),
    ] = None,
    loaded: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LOG",
            help="A log of currents with a load of known mass at the tip, which tells the scale of "
            "unknown gains.",
        ),
    ] = None,
    load: Annotated[
        float | None, typer.Option(metavar="KG", help="The mass of the load of --loaded, kg.")
    ] = None,
    rotors: Annotated[
        bool, typer.Option(help="Whether the drives' rotors have unknown inertias.")
    ] = True,
    payload_of: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LOG",
            help="A log of the same robot with a load at its tip, whose mass, centre and inertia "
            "are then told.",
        ),
    ] = None,
    collisions_in: Annotated[
        str | None,
        typer.Option(metavar="LOG", help="A log that is searched for collisions."),
    ] = None,
    layout: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The TOML file that tells the logs' columns."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for the page (index.html), the robot (model.toml), the report, and it as "
            "JSON.",
        ),
    ] = None,
) -> None:
    """A robot's masses, rotors and friction from its logs, with intervals, and a model that
    predicts its torques.

    Exit status 0: the model predicts the logs of --validate about as well as those that it was
    made from. 1: it does not, there are none, or the scale of its masses is not told to a tenth.
    2: bad input.
    """
    from freebody.identification.collisions import detect_collisions
    from freebody.identification.identify import identify as identified
    from freebody.identification.identify_payload import identify_payload
    from freebody.identification.result_files import write_results
    from freebody.report.identification_page import identification_page

    with terminal.progress("reading"):
        model = robot.load()
        searched = () if collisions_in is None else (collisions_in,)
        used, unseen, carrying, pushed, weighed = (
            [_log(text, model, layout, seed) for text in given or ()]
            for seed, given in enumerate((logs, validate, payload_of, searched, loaded))
        )
    laws: dict[str, Any] = (
        {} if friction is None else {"friction": [x.strip() for x in friction.split(",")]}
    )
    held: dict[str, Any] = {} if masses is None else {"prior": numbers.values("--masses", masses)}
    with terminal.progress("identify"):
        found = identified(
            model, used, validate=unseen, rotors=rotors, loaded=weighed, load=load, **laws, **held
        )
        known: dict[str, Any] = {"gains": found.gains if found.scale_known else None}
        carried = pushes = None
        if carrying:
            carried = identify_payload(found.model, carrying, used, **known, **laws)
        for log in pushed:
            pushes = detect_collisions(found.model, log, gains=found.gains)
    console = terminal.out()
    _told(found, "bold green" if found.trusted else "bold red")
    for more in (carried, pushes):
        if more is not None:
            _told(more, "bold")
    if out is not None:
        names = [*logs, *(validate or ()), *(loaded or ()), *(payload_of or ()), *searched]
        page = partial(identification_page, found, carried, pushes)
        for path in write_results(found, out, names, page, carried, pushes):
            console.print(f"written: {path}", soft_wrap=True, markup=False, highlight=False)
    console.print(f"again:   {options.again(context)}", soft_wrap=True, highlight=False)
    if not found.trusted:
        raise typer.Exit(1)


def _told(found: Any, style: str) -> None:
    """Prints a result's verdict, table and notices."""
    console = terminal.out()
    console.print(found.verdict, style=style, soft_wrap=True, markup=False)
    terminal.table(found._table())
    for notice in found.notices:
        console.print(f"note:    {notice}", soft_wrap=True, markup=False, highlight=False)


def _log(text: str, model: Model, layout: Path | None, seed: int) -> Log:
    from freebody.identification.logs.read_log import read_log
    from freebody.identification.simulated import simulated_log

    return (
        simulated_log(model, seed) if text == _SIMULATED else read_log(text, model, layout=layout)
    )
