"""The command `freebody fbd`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from freebody.cli import numbers, options, terminal
from freebody.outputs.display import TextTable
from freebody.outputs.files import stem

if TYPE_CHECKING:
    from freebody.arrays import Array
    from freebody.figures.free_body import FreeBodyDiagram

EXAMPLE = 'Example: freebody fbd 2R --q "0.5, 60 deg" --body link2 --out link2.svg'


@options.collected(
    wrench=options.USED,
    speed="a free-body diagram is of one instant; give --qd and --qdd.",
)
def fbd(
    robot: options.GivenRobot,
    q: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help='Positions in rad and m, or "30 deg", in the joints\' order; '
            "loops are closed near them. Default: a pose in which the robot is clearly visible.",
        ),
    ] = None,
    qd: Annotated[
        str | None, typer.Option(metavar="VALUES", help="Velocities. Default: at rest.")
    ] = None,
    qdd: Annotated[
        str | None, typer.Option(metavar="VALUES", help="Accelerations. Default: 0.")
    ] = None,
    body: Annotated[
        str | None, typer.Option(metavar="NAME", help="One body or its joint. Default: all.")
    ] = None,
    show: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WHAT",
            help="Geometry beside the forces, repeatable: points, centres, vectors; in the plane "
            "lengths, angles; in space axes.",
        ),
    ] = None,
    labels: Annotated[
        options.LabelsOption | None,
        typer.Option(
            help="Labels beside the arrows. Default: both; names where parameters have no value."
        ),
    ] = None,
    notation: options.NotationOption = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.svg", help="The drawing. Default: ROBOT-fbd.svg.")
    ] = None,
) -> None:
    """Draw the free-body diagram of each body, all forces and moments to scale, and list them."""
    model = robot.load()
    with terminal.progress("free bodies"):
        from freebody.figures.free_body import free_body_diagram
        from freebody.loops.assembly import assemble

        given = {
            name: None if text is None else numbers.values(f"--{name}", text)
            for name, text in (("qd", qd), ("qdd", qdd))
        }
        positions = None if q is None else numbers.values("--q", q)
        if model.loops and positions is not None:
            positions = assemble(model, positions).tolist()
        chosen = {"labels": labels, "show": show or (), "notation": notation}
        figure = free_body_diagram(
            model, positions, body, wrenches=robot.wrenches(model), **given, **chosen
        )
        path = figure.save(out or Path(f"{stem(model.name)}-fbd.svg"))
    if q is None or model.loops:
        shown = ", ".join(f"{round(x, 9) + 0.0:.3g}" for x in figure.q)  # without rounding's rest
        terminal.out().print(f"at q = {shown}; choose another with --q", soft_wrap=True)
    terminal.table(_table(figure))
    if figure.missing:
        assumed = f"drawn for typical values; without value: {', '.join(figure.missing)}"
        terminal.out().print(assumed, soft_wrap=True)
    for text in figure.unheld:
        terminal.out().print(text, soft_wrap=True)
    terminal.out().print(f"written: {path}", soft_wrap=True)


def _table(figure: FreeBodyDiagram) -> TextTable:
    """The table of loads of a free-body diagram; only their names where the model has parameters
    without value."""
    from freebody.figures.marked_text import plain

    flat, named = len(figure.loads[0].body.origin) == 2, bool(figure.missing)
    rows = []
    for item in figure.loads:
        for k, load in enumerate(item.loads):
            turning = load.moment_name and (flat or named or any(load.moment))
            rows.append(
                (
                    item.body.name if k == 0 else "",
                    load.other,
                    plain(load.name),
                    "" if named else _components(load.force),
                    plain(load.moment_name) if turning else "",
                    _components(load.moment) if turning and not named else "",
                )
            )
    return TextTable(("body", "by", "force", "components, N", "moment", "N m"), rows)


def _components(values: Array) -> str:
    from freebody.outputs.number_text import significant

    return "  ".join(significant(float(x), 4) for x in values)
