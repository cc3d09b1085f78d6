"""The command `freebody payload`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from freebody.cli import fitted_parts, motions, numbers, options, terminal
from freebody.errors import FreebodyError

EXAMPLE = 'Example: freebody payload ur5e --q "0, -90 deg, 90 deg, 0, 0, 0" --out loads.svg'


@options.collected(wrench=options.USED, speed=options.USED)
def payload(
    context: typer.Context,
    robot: options.GivenRobot,
    motion: motions.MotionInsteadOfPostures = None,
    smooth: motions.GivenSmooth = None,
    q: Annotated[
        str | None,
        typer.Option(metavar="VALUES", help='At rest at this posture, rad and m, or "30 deg".'),
    ] = None,
    postures: Annotated[
        int, typer.Option(min=1, metavar="COUNT", help="So many random postures.")
    ] = 20_000,
    seed: Annotated[int, typer.Option(min=0, help="Of the random postures.")] = 0,
    com: Annotated[
        str | None,
        typer.Option(
            metavar="x,y,z",
            help="The payload's centre of mass in the tip's axes, m. Default: the origin.",
        ),
    ] = None,
    effort: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="The largest torque or force of each joint, N m and N. Default: the joints' "
            "effort limits.",
        ),
    ] = None,
    catalogue: fitted_parts.GivenCatalogue = None,
    brake: fitted_parts.GivenBrakes = None,
    bearing: fitted_parts.GivenBearings = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.svg",
            help="Draw the load diagram: mass over offset in mm, a curve for each limit.",
        ),
    ] = None,
    along: Annotated[
        str | None,
        typer.Option(
            metavar="AXIS",
            help="The tip's axis along which the offsets lie. Default: z, in the plane x.",
        ),
    ] = None,
    farthest: Annotated[
        float,
        typer.Option(metavar="MM", parser=numbers.number, help="The farthest offset, mm."),
    ] = 500.0,
) -> None:
    """The largest payload along a motion or in each segment of a duty cycle, at a posture or over
    many, the drive, brake or bearing that limits it, and the load diagram as makers print it.

    A load given by --payload is carried already: the largest comes on top of it. Exit status 0:
    something is carried. 1: nothing is, or what is doubtful about the robot bars an answer. 2: bad
    input.
    """
    from freebody.capacity.payload import payload as largest
    from freebody.report.load_case import in_a_line

    model = robot.load()
    wrenches = robot.wrenches(model)
    at, words = _where(robot, model, motion, motions.cutoff(smooth), q, postures, seed)
    centre = None if com is None else numbers.values("--com", com)
    if out is not None and centre is not None:
        raise FreebodyError("--com: the load diagram has offsets of its own; leave one out.")
    most = None if effort is None else numbers.values("--effort", effort)
    case = {"wrenches": wrenches, "effort": most, **fitted_parts.read(catalogue, brake, bearing)}
    with terminal.progress("payload"):
        found = largest(model, at, com=centre, **case)
    console = terminal.out()
    style = "bold green" if found.carries else "bold red"
    console.print(found.card, style=style)
    speed = robot.speed if motion is not None else 1.0
    console.print(f"{model.name}: {words}. {in_a_line(model, wrenches, speed)}")
    table = found._table()
    terminal.table(table)
    for note in table.notes:
        terminal.warn(note)
    if out is not None:
        console.print(f"written: {_drawn(model, at, case, along, farthest, out)}")
    console.print(f"again:   {options.again(context)}", soft_wrap=True)
    if not found.carries:
        raise typer.Exit(1)


def _where(
    robot: options.GivenRobot,
    model: Any,
    motion: Path | None,
    smooth: bool | float,
    q: str | None,
    count: int,
    seed: int,
) -> tuple[Any, str]:
    """A motion or postures, and what they are in words."""
    from freebody.trees.positions import random_state

    if motion is not None and q is not None:
        raise FreebodyError("--motion and --q: give a motion or a posture.")
    if motion is not None:
        at = motions.read(model, motion, robot.speed, smooth)
        carried = any(x.payload is not None for x in getattr(at, "segments", ()))
        how = ", smoothed" if smooth is not False else ""
        return at, f"along {motion}{how}{', besides what its segments carry' if carried else ''}"
    if smooth is not False:
        raise FreebodyError("--smooth: there is no motion to smooth; give --motion.")
    if robot.speed != 1.0:
        raise FreebodyError("--speed: there is no motion to run faster or slower; give --motion.")
    if q is not None:
        return numbers.values("--q", q), f"at rest at q = {q}"
    if model.loops:
        raise FreebodyError(
            f"freebody payload: {model.name!r} has loops, which random postures leave open; give "
            f"--motion or --q."
        )
    return random_state(model, seed, count)[0], f"at rest at {count} random postures, seed {seed}"


def _drawn(
    model: Any, at: Any, case: dict[str, Any], along: str | None, farthest: float, out: Path
) -> Path:
    """The file with the load diagram."""
    from freebody.capacity.load_diagram import load_diagram

    if not farthest > 0.0:
        raise FreebodyError(f"--farthest is {farthest:g}, expected millimetres above 0.")
    places = [1e-3 * farthest * k / 24 for k in range(25)]
    with terminal.progress("load diagram"):
        found = load_diagram(model, at, offsets=places, along=along, **case)
        return found.save(out)
