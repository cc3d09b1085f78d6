"""`freebody plan`: motions through waypoints, or along a path of the tip (--line, --arc)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import numbers, options, terminal
from freebody.errors import FreebodyError, MissingArgumentError, listed
from freebody.outputs.display import TextTable, counted
from freebody.outputs.number_text import compared, percent

if TYPE_CHECKING:
    from freebody.arrays import Array
    from freebody.model.model import Model
    from freebody.motion.motion import Motion


_ROUNDING = 1e-12
"""Size in rad or m of what rounding leaves of 0 in a polynomial of positions."""

EXAMPLE = 'Example: freebody plan 2R "0, 0; 1.2, 30 deg; 0.5, -0.4" --acceleration 2'


PlannerName = Literal["spline", "quintic", "trapezoid", "s-curve", "time-optimal"]


def _limit(what: str) -> Any:
    return typer.Option(metavar="VALUE", parser=numbers.number, help=what)


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
    line: Annotated[
        str | None,
        typer.Option(
            metavar="POINT",
            help="The tip moves straight to x, y, z (m, world axes; in the plane x, y); several "
            "targets have semicolons between them, and corners rounded within --radius.",
        ),
    ] = None,
    arc: Annotated[
        str | None,
        typer.Option(
            metavar="POINT;POINT",
            help="The tip moves on a circle through the first point to the second.",
        ),
    ] = None,
    pose: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLES",
            help="Orientation at the target: roll, pitch, yaw as in URDF (rad or deg; in the plane "
            "one angle), or keep, that of the start. Default: free.",
        ),
    ] = None,
    task: Annotated[
        str | None,
        typer.Option(
            metavar="ROWS",
            help="What of the target counts: position, orientation, pose, reachable (the position, "
            "and of the orientation what the joints can do), or rows such as vx,vy,vz,wz.",
        ),
    ] = None,
    radius: Annotated[
        float | None, _limit("Metres from a corner of --line at which its rounding begins.")
    ] = None,
    tip_speed: Annotated[float | None, _limit("Limit of the tip's speed, m/s.")] = None,
    duration: Annotated[
        float | None, _limit("Seconds that the motion takes. Default: as fast as limits allow.")
    ] = None,
    velocity: Annotated[
        float | None, _limit("Limit of each joint, rad/s or m/s, beside the robot's own.")
    ] = None,
    acceleration: Annotated[float | None, _limit("Limit of each joint, rad/s² or m/s².")] = None,
    jerk: Annotated[float | None, _limit("Limit of each joint, rad/s³ or m/s³.")] = None,
    torque: Annotated[
        float | None, _limit("Limit of each drive, N m or N, beside the robot's own.")
    ] = None,
    step: Annotated[
        float | None,
        _limit("Seconds between rows. Default: 400 even steps, and where polynomials meet."),
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
        tip_speed = _of_old_spelling(speed, tip_speed)
    path = TipPathOptions(line, arc, pose, task, radius, tip_speed, duration)
    given = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk, "torque": torque}
    limits: dict[str, Any] = {name: x for name, x in given.items() if x is not None}
    planner = None if path.given else PLANNERS[by or "spline"]
    if planner is None and by is not None:
        raise FreebodyError("--by is for motions through waypoints, not for --line and --arc.")
    wrenches = robot.wrenches(model)
    if wrenches is not None:
        limits["wrenches"] = wrenches
    if planner is None:
        _refuse_idle_limits("a path of the tip", ("velocity", "acceleration"), limits)
    else:
        _refuse_idle_limits(by or "spline", planner.limits, limits)
    q, times = _read(model, waypoints, path.given)
    try:
        if planner is not None:
            motion = planner.plan(model, q, times, **limits, step=step)
            motion = motion if duration is None else _slowed(motion, duration, times is not None)
        else:
            motion = path.motion(model, q[0], **limits, step=step)
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


_KEEP = "keep"


@dataclass(frozen=True)
class TipPathOptions:
    """The options of a tip's path, as they were typed; None for options that were not given."""

    line: str | None
    arc: str | None
    pose: str | None
    task: str | None
    radius: float | None
    tip_speed: float | None
    duration: float | None

    @property
    def given(self) -> bool:
        """Whether the options ask for a path of the tip; options that need one are refused
        otherwise."""
        if self.line is not None and self.arc is not None:
            raise FreebodyError("--line and --arc are two paths; plan them one after the other.")
        if self.line is not None or self.arc is not None:
            return True
        for name in ("pose", "task", "radius", "tip_speed"):
            if getattr(self, name) is not None:
                option = name.replace("_", "-")
                raise FreebodyError(f"--{option} belongs to a path of the tip: --line or --arc.")
        return False

    def motion(self, model: Model, q0: Any, **limits: float | None) -> Motion:
        """The motion of the tip along its path from the positions q0; limits: those of the joints,
        and a time step."""
        from freebody.motion.planning import tip_motions

        self._refuse_idle_pose(model)
        every: dict[str, Any] = {
            **limits,
            "task": self._task,
            "speed": self.tip_speed,
            "duration": self.duration,
        }
        if self.arc is not None:
            via, *ends = self._points(model, "--arc", self.arc, "a point to pass, ; and the target")
            if len(ends) != 1 or self.radius is not None:
                raise FreebodyError(
                    "--arc takes two points, the one to pass and the target, with ; between them, "
                    "and no --radius."
                )
            return tip_motions.arc(model, q0, via, self._targets(model, ends)[0], **every)
        points = self._points(model, "--line", self.line or "", "a target, or several with ;")
        targets = self._targets(model, points)
        if len(points) == 1 and self.radius is None:
            return tip_motions.line(model, q0, targets[0], **every)
        if self.radius is None or len(points) == 1:
            raise FreebodyError(
                f"--line has {counted(len(points), 'target')}; several need --radius, metres from "
                f"a corner at which its rounding begins, and one has no corner. With a stop at "
                f"each place: a duty cycle with tip = […], for study --motion cycle.toml."
            )
        return tip_motions.blend(model, q0, targets, self.radius, **every)

    def _refuse_idle_pose(self, model: Model) -> None:
        """Refuse --pose together with a task that counts no rotation."""
        from freebody.inverse.problem.task import rows_of
        from freebody.motion.planning.tip_motions import REACHABLE

        if self.pose is None or self._task in (None, REACHABLE):
            return
        angular = rows_of("--task", model, "orientation")
        if not {*angular} & {*rows_of("--task", model, self._task)}:
            raise FreebodyError(
                f"--pose gives an orientation, and --task {self.task} counts none: leave one of "
                f"them out, or ask for --task pose or reachable."
            )

    @property
    def _task(self) -> str | Sequence[str] | None:
        if self.task is None:
            return "pose" if self.pose == _KEEP else None
        rows = self.task.replace(",", " ").split()
        return rows if len(rows) > 1 else self.task

    def _points(self, model: Model, option: str, text: str, what: str) -> list[list[float]]:
        """Points of a path in m, from a text with semicolons between them."""
        rows = [row for row in text.split(";") if row.strip()]
        axes = "x, y, z" if model.dim == 3 else "x, y"
        found = [numbers.values(option, row) for row in rows]
        for row, point in zip(rows, found, strict=True):
            if len(point) != model.dim or "deg" in row or "°" in row:
                raise FreebodyError(
                    f"{option} {row.strip()!r}: a point of {model.name!r} is {axes} in metres, "
                    f"world axes; --pose gives the orientation."
                )
        if not found:
            raise FreebodyError(f"{option} is empty: give {what}, {axes} in metres.")
        return found

    def _targets(self, model: Model, points: list[list[float]]) -> list[Any]:
        """Targets of the path: points, or poses where --pose gives one orientation for all points
        or one for each."""
        if self.pose is None or self.pose == _KEEP:
            return points
        turns = [_rotation(model, row) for row in self.pose.split(";") if row.strip()]
        if len(turns) not in (1, len(points)):
            raise FreebodyError(
                f"--pose has {counted(len(turns), 'orientation')} for "
                f"{counted(len(points), 'target')}; give one for all, or one each."
            )
        turns = turns * len(points) if len(turns) == 1 else turns
        return [_pose(R, point) for R, point in zip(turns, points, strict=True)]


def _rotation(model: Model, text: str) -> Array:
    import numpy as np
    from scipy.spatial.transform import Rotation

    angles = numbers.values("--pose", text)
    if len(angles) != (3 if model.dim == 3 else 1):
        wanted = "roll, pitch, yaw (as in URDF)" if model.dim == 3 else "one angle"
        raise FreebodyError(
            f"--pose {text.strip()!r}: the orientation of a target is {wanted}, rad or deg; or "
            f"{_KEEP}, that of the start."
        )
    R = Rotation.from_euler("xyz", angles if model.dim == 3 else [0.0, 0.0, *angles]).as_matrix()
    return np.asarray(R[: model.dim, : model.dim])


def _pose(R: Array, point: list[float]) -> Array:
    import numpy as np

    T = np.eye(len(point) + 1)
    T[:-1, :-1], T[:-1, -1] = R, point
    return T
