"""By how much a loop may fail to close: what rounding of the model's numbers does to it."""

from __future__ import annotations

import numpy as np

from freebody.algorithms.kinematics import ancestors
from freebody.model.model import Model
from freebody.model.tree import Tree

_OF_LENGTH = 1e-3
"""What rounding may do to a loop, relative to its size: files print three digits at least."""
_MOST = (1e-3, 1e-3)
"""(m, rad): files print metres to four digits and angles to three, and a loop adds up a few of
them."""


def tolerance_of_loop(model: Model, tree: Tree, index: int) -> tuple[float, float]:
    """(metres, radians): the model's `loop_tolerance`, or its default for a loop of the size that
    it has in `tree`."""
    if model.loop_tolerance is not None:
        return model.loop_tolerance
    loop = tree.loops[index]
    first, second = (ancestors(tree, tree.frames[frame][0]) for frame in loop.frames)
    offsets = [tree.bodies[i].p for i in set(first) ^ set(second)]
    offsets += [tree.frames[frame][2] for frame in loop.frames] + [(loop.distance,)]
    size = max(float(np.linalg.norm(np.asarray(p, dtype=float))) for p in offsets)
    metres, radians = _MOST
    return min(metres, _OF_LENGTH * size), radians
