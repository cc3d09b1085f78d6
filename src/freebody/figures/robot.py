"""The robot as a drawing with its numbers: one pose, fainter ones behind it, the way of its tip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from freebody.figures.drawing import Drawing
from freebody.figures.layers import geometry, structure
from freebody.figures.skeleton import extent, skeleton
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT, best_view
from freebody.model.model import Model

_GEOMETRY = (geometry.angles, geometry.slides, geometry.centres, geometry.lengths)
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
    view = FLAT
    if model.dim == 3:
        view = best_view([ends for pose in poses for ends in structure.sticks(pose)])
    drawing = Drawing(view, f"{model.name}: the robot at one position", labels="both")
    if model.dim == 3:
        structure.floor(drawing, seen, poses)
    for pose in poses[1:]:
        for ends in structure.sticks(pose):
            drawing.line(ends, "ghost", "ghost")
    if track is not None:
        drawing.line(track, "tip path", "tippath")
        drawing.mark(track[0], "dot", "path start", "tipdot", 3.0)
    structure.structure(drawing, seen)
    for layer in _GEOMETRY if model.dim == 2 else (_numbered,):
        layer(drawing, seen)
    about = extent(poses, track) / 5
    drawing.ruler(about, about, "m", "length")
    return drawing


def _numbered(drawing: Drawing, seen: Snapshot) -> None:
    """The frame of the tip, and the numbers of the joints."""
    pose = seen.pose
    if pose.tip is not None and pose.tip_rotation is not None:
        axes, size = [f"tip {name}" for name in "xyz"], 0.1 * seen.size
        structure.triad(drawing, pose.tip, pose.tip_rotation, size, axes, label="")
    if len(pose.bodies) <= _CROWDED:
        for body in pose.bodies:
            drawing.write(body.origin, str(body.number), (0.0, 0.0, -1.0))
