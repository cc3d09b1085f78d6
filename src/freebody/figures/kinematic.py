"""`kinematic_diagram`: a robot drawn in one pose with the names of its geometry, its vectors,
velocities or accelerations, or with joint numbers, fainter poses and the path of its tip."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.expressions.notations.notation import BookNotation
from freebody.figures.drawing import Drawing
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.labelling import chosen_of, labels_of
from freebody.figures.layers import bare_robot, measures, motion
from freebody.figures.layers.bare_robot import Layer, drawn
from freebody.figures.skeleton import Skeleton, extent, skeleton
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT, best_view
from freebody.model.model import Model
from freebody.trees.public_calls import JointVector

WIDE, TALL = 440.0, 420.0
"""Size of one drawing, pixels."""
_MOVING = ("velocities", "accelerations")
"""Views that show rates; the last shows accelerations, too."""
_BENT: tuple[Layer, ...] = (measures.angles, measures.slides)
_GEOMETRY: tuple[Layer, ...] = (*_BENT, measures.centres)
VIEWS: dict[int, dict[str, tuple[Layer, ...]]] = {
    2: {
        "geometry": (*_GEOMETRY, measures.all_lengths, measures.of_the_ground),
        "vectors": (*_BENT, measures.links, measures.to_tip),
        "centres": (*_GEOMETRY, measures.of_centres),
        "velocities": (*_GEOMETRY, motion.rates, motion.of_centres),
        "accelerations": (
            *_GEOMETRY, partial(motion.rates, second=True), partial(motion.of_centres, second=True)
        ),
    },
    3: {
        "frames": (measures.axes, measures.variables),
        "normals": (measures.axes, measures.normals),
        "vectors": (measures.links, measures.centres),
    },
}  # fmt: skip
"""Choices of `show`, by dimension, and the layers that each is made of."""
_DEFAULT = {2: ("geometry", "vectors"), 3: ("frames", "normals")}


def kinematic_diagram(
    model: Model,
    q: JointVector | None = None,
    show: str | Sequence[str] | None = None,
    qd: JointVector | None = None,
    qdd: JointVector | None = None,
    *,
    labels: str = "names",
    notation: str | PathLike[str] | BookNotation | None = None,
) -> Figure:
    """Drawings of a robot with symbols: geometry and vectors in the plane, joint axes and common
    normals in space.

    Parameters
    ----------
    model
        Parameters without value get typical values.
    q, qd, qdd
        (nq,) rad or m, (nv,), (nv,); default: a state in which the robot is clearly visible.
    show
        One or several of, in the plane, "geometry" (θ_i, d_i, l_i, l_ci, C_i), "vectors" (s_i, r),
        "centres" (r_ci), "velocities" (rates, v_ci), "accelerations"; in space "frames" (z_i, of
        slides u_i, joint variables), "normals" (a_i, d_i), "vectors" (s_i, C_i).
    labels
        "names", "values" or "both".
    notation
        Whose letters stand in it, as for `check`.

    Returns
    -------
    Figure
        With `.svg`, `.save("arm.svg")` and `.named("s_1")`, the elements as data.

    Raises
    ------
    ShapeError, NotFiniteError, UnknownNameError, MissingValueError

    References
    ----------
    Figures 1.2, 2.1, 3.2, 4.3, 5.3, 6.4, 6.5.
    """
    caller, known = "kinematic_diagram", VIEWS[model.dim]
    asked = _DEFAULT[model.dim] if show is None else show
    chosen = chosen_of(f"{caller} of a model in {model.dim}D", asked, known)
    if not chosen:
        raise FreebodyError(f"{caller}: show is empty; name one of {', '.join(known)}.")
    for argument, value, views in (("qd", qd, _MOVING), ("qdd", qdd, _MOVING[1:])):
        if value is not None and not set(views) & set(chosen):
            instead = "drawings in space show none; leave it out"
            instead = f"say show={views[0]!r}" if views[0] in known else instead
            shown = ", ".join(chosen)
            raise FreebodyError(f"{caller}: {argument} is not drawn in {shown}: {instead}.")
    how = labels_of(caller, model, labels)
    seen = snapshot(model, q, qd, qdd, None, caller, notation)
    drawings = tuple(drawn(seen, x, known[x], faint=x == "vectors") for x in chosen)
    for drawing in drawings:
        drawing.labels = how
    to_one_scale(drawings, WIDE, TALL)
    return Figure(f"Kinematic diagram of {model.name}", drawings, 2, WIDE, TALL, caller)


_NUMBERED = (
    measures.angles,
    measures.slides,
    measures.centres,
    measures.lengths,
)
_CROWDED = 12  # bodies; the joints of more are not numbered


def robot_drawing(
    model: Model, q: ArrayLike, ghosts: Sequence[ArrayLike] = (), path: ArrayLike | None = None
) -> Drawing:
    """The robot at q (nq,), with fainter poses `ghosts` and the tip's `path` (k, dim) in world
    metres."""
    still = np.zeros(model.nv)
    seen = snapshot(model, q, still, still)
    poses = [seen.pose, *(skeleton(model, ghost) for ghost in ghosts)]
    track = None if path is None else np.asarray(path, dtype=float)
    drawing = robot_scene(poses, track, f"{model.name}: the robot at one position", seen.size)
    if model.dim == 3:
        bare_robot.shadow(drawing, seen, poses)
    for pose in poses[1:]:
        for ends in bare_robot.sticks(pose):
            drawing.line(ends, "ghost", "ghost")
    tip_path(drawing, track)
    bare_robot.structure(drawing, seen)
    for layer in _NUMBERED if model.dim == 2 else (_numbered,):
        layer(drawing, seen)
    return drawing


def robot_scene(poses: Sequence[Skeleton], track: Array | None, title: str, size: float) -> Drawing:
    """The drawing in which a robot of a size (m) stands in some poses, still without it: the view
    that shows them best, the floor, a ruler about as long as suits them and the path of the tip,
    track (k, dim)."""
    view = FLAT
    if poses[0].dim == 3:
        view = best_view([ends for pose in poses for ends in bare_robot.sticks(pose)])
    drawing = Drawing(view, title, labels="both")
    if poses[0].dim == 3:
        bare_robot.floor(drawing, poses, size)
    about = extent(poses, track) / 5
    drawing.ruler(about, about, "m", "length")
    return drawing


def tip_path(drawing: Drawing, track: Array | None) -> None:
    """Draw the path (k, dim) of the tip, with a dot where it starts."""
    if track is not None:
        drawing.line(track, "tip path", "tippath")
        drawing.mark(track[0], "dot", "path start", "tipdot", 3.0)


def _numbered(drawing: Drawing, seen: Snapshot) -> None:
    """Draw the frame of the tip and the numbers of the joints."""
    pose = seen.pose
    if pose.tip is not None and pose.tip_rotation is not None:
        axes, size = [f"tip {name}" for name in "xyz"], 0.1 * seen.size
        bare_robot.triad(drawing, pose.tip, pose.tip_rotation, size, axes, label="")
    if len(pose.bodies) <= _CROWDED:
        for body in pose.bodies:
            drawing.write(body.origin, str(body.number), (0.0, 0.0, -1.0))
