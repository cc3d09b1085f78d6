"""`freebody plan`: motions through waypoints, or along a path of the tip (--line, --arc)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import numbers, options, terminal
from freebody.cli.tip_path import GivenTipPath
from freebody.errors import FreebodyError, MissingArgumentError, listed
from freebody.outputs.display import TextTable
from freebody.outputs.number_text import compared, percent

if TYPE_CHECKING:
    from freebody.model.model import Model
    from freebody.motion.motion import Motion


_ROUNDING = 1e-12
"""Size in rad or m of what rounding leaves of 0 in a polynomial of positions."""

EXAMPLE = 'Example: freebody plan 2R "0, 0; 1.2, 30 deg; 0.5, -0.4" --acceleration 2'


PlannerName = Literal["spline", "quintic", "trapezoid", "s-curve", "time-optimal"]


@dataclass(frozen=True)
class GivenLimits:
    """Limits of all joints alike, beside the robot's own."""

    velocity: Annotated[
        float | None, numbers.option("Limit of each joint, rad/s or m/s, beside the robot's own.")
    ] = None
    acceleration: Annotated[
        float | None, numbers.option("Limit of each joint, rad/s² or m/s².")
    ] = None
    jerk: Annotated[float | None, numbers.option("Limit of each joint, rad/s³ or m/s³.")] = None
    torque: Annotated[
        float | None, numbers.option("Limit of each drive, N m or N, beside the robot's own.")
    ] = None

    def arguments(self, wrenches: dict[str, list[float]] | None) -> dict[str, Any]:
        """The limits that are given, and the wrenches that those of torque stand under, as
        arguments of a planner."""
        given = {**vars(self), "wrenches": wrenches}
        return {name: x for name, x in given.items() if x is not None}


@options.collected(wrench=options.USED)
def plan(
    context: typer.Context,
    robot: options.GivenRobot,
    waypoints: Annotated[
        str,
        typer.Argument(
            help="A CSV file whose header names the joints (rad, m; or a unit, as in 'joint1 "
            "(deg)') and perhaps t (s); or the positions themselves, semicolons between waypoints. "
            "Of --line and --arc one: where they begin.",
        ),
    ],
    path: GivenTipPath,
    limits: GivenLimits,
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="File for the motion, for study --motion.")
    ] = Path("motion.csv"),
    by: Annotated[
        PlannerName | None,
        typer.Option(
            help="spline and time-optimal do not stop at waypoints, the others do; time-optimal "
            "holds the robot's limits of torque too. Default: spline."
        ),
    ] = None,
    step: Annotated[
        float | None,
        numbers.option(
            "Seconds between rows. Default: 400 even steps, and where polynomials meet."
        ),
    ] = None,
    speed: Annotated[float | None, typer.Option(hidden=True, parser=numbers.number)] = None,
) -> None:
    """Plan a motion through waypoints, or the tip along a path, as fast as the limits allow or at
    given times, and write it.

    Limits are held between samples too. Exit status 2: the limits cannot be kept, the tip cannot
    follow, or something cannot be read or written.
    """
    from freebody.motion.files.csv_files import write_motion
    from freebody.motion.planners import PLANNERS
    from freebody.report.load_case import in_a_line

    model = robot.load()
    if speed is not None:
        path = replace(path, tip_speed=_of_old_spelling(speed, path.tip_speed))
    planner = None if path.given else PLANNERS[by or "spline"]
    if planner is None and by is not None:
        raise FreebodyError("--by is for motions through waypoints, not for --line and --arc.")
    wrenches = robot.wrenches(model)
    within = limits.arguments(wrenches)
    if planner is None:
        _refuse_idle_limits("a path of the tip", ("velocity", "acceleration"), within)
    else:
        _refuse_idle_limits(by or "spline", planner.limits, within)
    q, times = _read(model, waypoints, path.given)
    try:
        if planner is not None:
            motion = planner.plan(model, q, times, **within, step=step)
            if path.duration is not None:
                motion = _slowed(motion, path.duration, times is not None)
        else:
            motion = path.motion(model, q[0], **within, step=step)
    except MissingArgumentError as problem:
        names = ["a column t of times" if x == "times" else f"--{x}" for x in problem.names]
        raise FreebodyError(problem.worded(names)) from None
    file = write_motion(model, motion, out, "knots" if step is None else "samples")
    told = in_a_line(model, wrenches)
    _print(model, motion, file, options.again(context), told, of_tip=path.given)


def _refuse_idle_limits(what: str, own: Sequence[str], given: Iterable[str]) -> None:
    """Refuse limits, and wrenches, that change nothing in what is planned."""
    for name in given:
        if name == "wrenches":
            if "torque" not in own:
                raise FreebodyError(
                    f"--wrench: {what} holds no limits of torque, so that a wrench changes "
                    f"nothing; --by time-optimal holds them."
                )
        elif name not in own:
            raise FreebodyError(
                f"--{name} has no meaning for {what}; it takes {listed(f'--{x}' for x in own)}."
            )


def _slowed(motion: Motion, duration: float, timed: bool) -> Motion:
    """The motion through waypoints run more slowly along its path, so that it takes a duration."""
    if timed:
        raise FreebodyError(
            "--duration and a column t both say when; leave out one of them (freebody study "
            "--speed runs a motion more slowly)."
        )
    if not duration >= motion.duration * (1.0 - _ROUNDING):
        given, needed = compared(duration, motion.duration)
        raise FreebodyError(
            f"--duration {given} s is too short: within the limits the motion takes {needed} s at "
            f"least."
        )
    return motion.faster(motion.duration / duration)


def _of_old_spelling(speed: float, tip_speed: float | None) -> float:
    """--speed read as --tip-speed, which it was; elsewhere --speed is a factor on a motion."""
    if tip_speed is not None:
        raise FreebodyError("--speed is the old spelling of --tip-speed; give that one alone.")
    terminal.warn(
        f"--speed {speed:g} is now written --tip-speed {speed:g}, m/s; it is read as that. "
        f"Elsewhere --speed says how many times as fast a motion is run."
    )
    return speed


def _read(model: Model, text: str, one: bool) -> tuple[Any, Any]:
    """Positions of waypoints, from a text or CSV file, and their times or None; one: refuse more
    than the single position where a path begins."""
    from freebody.motion.files.csv_files import read_waypoints

    of_file = text.lower().endswith(".csv") or (";" not in text and Path(text).is_file())
    found = read_waypoints(model, text) if of_file else _of_text(model, text)
    if one and len(found[0]) != 1:
        raise FreebodyError(
            f"--line and --arc begin at one position; {text!r} has {len(found[0])}."
        )
    return found


def _of_text(model: Model, text: str) -> tuple[Any, None]:
    """Positions of waypoints typed as text, rows apart by semicolons."""
    texts = [row.strip() for row in text.split(";") if row.strip()]
    rows = [numbers.values("waypoints", row) for row in texts]
    names = model.position_names
    if model.loops and rows and len(rows[0]) != model.nq:
        names = model.driven_names
    for typed, row in zip(texts, rows, strict=True):
        if len(row) != len(names):
            what = "driven joints" if names is not model.position_names else "positions"
            raise FreebodyError(
                f"waypoint {typed!r} has {len(row)} positions, {model.name!r} has {len(names)} "
                f"{what}: {listed(names, 8)}.{_of_tip(model, len(row))}"
            )
    return rows, None


def _of_tip(model: Model, count: int) -> str:
    """A sentence on a waypoint of so many numbers that may be a place of the tip, else none."""
    if count not in (model.dim, 3 * model.dim - 3):
        return ""
    return (
        " Where these are places of the tip in metres: --line leads it from one position to them, "
        "and a duty cycle has them as tip = […], for study, size and payload --motion cycle.toml."
    )


def _cleared(position: float) -> float:
    """The position, or 0 where only rounding makes it differ from that."""
    return position if abs(position) > _ROUNDING else 0.0


def _print(model: Model, motion: Motion, path: Path, again: str, case: str, of_tip: bool) -> None:
    from freebody.model.doubts import in_one_line
    from freebody.motion.planning.planning_limits import planning_limits

    out = terminal.out()
    for text in motion.notices:
        terminal.warn(text)
    if motion.doubts:
        terminal.warn(in_one_line(motion.doubts))
    out.print(f"{model.name}: {motion.source}, {motion.duration:.4g} s.")
    out.print(f"{model.tip_reason} " * of_tip + case)
    rows = []
    found, limits = motion.peaks, planning_limits("plan", model)
    names = model.driven_names if model.loops else model.velocity_names
    for name in names:
        k = model.velocity_names.index(name)
        unit = "rad" if limits.allowed.turns[k] else "m"
        share = found.velocity.size[k] / limits.velocity[k]
        ends = ["", ""]  # a rate of a joint with a quaternion has no position of its own
        if name in model.position_names:
            at = model.position_names.index(name)
            ends = [
                f"{_cleared(x[at]):.4g} {unit}" for x in (found.position.low, found.position.high)
            ]
        rows.append(
            (
                name,
                *ends,
                f"{found.velocity.size[k]:.4g} {unit}/s",
                percent(float(share)) if limits.velocity[k] < float("inf") else "",
                f"{found.acceleration.size[k]:.4g} {unit}/s²",
            )
        )
    head = ("joint", "lowest", "highest", "peak speed", "of its limit", "peak acceleration")
    terminal.table(TextTable(head, rows))
    out.print(f"written: {path}", soft_wrap=True)
    out.print(f"again:   {again}", soft_wrap=True)
