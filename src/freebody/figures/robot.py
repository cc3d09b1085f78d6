"""The robot as a stick drawing, in the plane as textbooks draw it, in space as an axonometric
picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from freebody.figures import plane, space
from freebody.figures.drawing import Drawing
from freebody.figures.skeleton import skeleton
from freebody.figures.svg import picture
from freebody.model.model import Model


def robot_drawing(
    model: Model, q: ArrayLike, ghosts: Sequence[ArrayLike] = (), path: ArrayLike | None = None
) -> Drawing:
    """The robot at q (nq,), with fainter poses `ghosts` and the tip's `path` (k, dim) in world
    metres."""
    pose = skeleton(model, q)
    others = [skeleton(model, ghost) for ghost in ghosts]
    track = None if path is None else np.asarray(path, dtype=float)
    draw = plane.draw if model.dim == 2 else space.draw
    return draw(model, pose, others, track)


def robot_svg(
    model: Model,
    q: ArrayLike,
    ghosts: Sequence[ArrayLike] = (),
    path: ArrayLike | None = None,
    css: bool = True,
) -> str:
    """The same as SVG text."""
    return picture(robot_drawing(model, q, ghosts, path), 640, 520).text(css)
