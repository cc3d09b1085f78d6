"""The path of the tip on the command line: its options, and the motion that they tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import numbers
from freebody.errors import FreebodyError
from freebody.outputs.display import counted

if TYPE_CHECKING:
    from freebody.arrays import Array
    from freebody.model.model import Model
    from freebody.motion.motion import Motion

_KEEP = "keep"


@dataclass(frozen=True)
class GivenTipPath:
    """The path of the tip, as it was typed, and how long the motion takes; None for options that
    were not given."""

    line: Annotated[
        str | None,
        typer.Option(
            metavar="POINT",
            help="The tip moves straight to x, y, z (m, world axes; in the plane x, y); several "
            "targets have semicolons between them, and corners rounded within --radius.",
        ),
    ] = None
    arc: Annotated[
        str | None,
        typer.Option(
            metavar="POINT;POINT",
            help="The tip moves on a circle through the first point to the second.",
        ),
    ] = None
    pose: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLES",
            help="Orientation at the target: roll, pitch, yaw as in URDF (rad or deg; in the plane "
            "one angle), or keep, that of the start. Default: free.",
        ),
    ] = None
    task: Annotated[
        str | None,
        typer.Option(
            metavar="ROWS",
            help="What of the target counts: position, orientation, pose, reachable (the position, "
            "and of the orientation what the joints can do), or rows such as vx,vy,vz,wz.",
        ),
    ] = None
    radius: Annotated[
        float | None, numbers.option("Metres from a corner of --line at which its rounding begins.")
    ] = None
    tip_speed: Annotated[float | None, numbers.option("Limit of the tip's speed, m/s.")] = None
    duration: Annotated[
        float | None,
        numbers.option("Seconds that the motion takes. Default: as fast as limits allow."),
    ] = None

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
