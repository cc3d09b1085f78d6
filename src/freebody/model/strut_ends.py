"""Struts whose ends are at one point wherever the joints are, such as two on one axis."""

from __future__ import annotations

import math
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from freebody.model.families import of_member
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import parents_first
from freebody.spatial import Matrix, Vector, compose, identity, of_dimension, sub

if TYPE_CHECKING:
    from freebody.model.model import Model

_ONE_POINT = 1e-9
"""m between points that are one."""


def strut_fault(model: Model) -> str | None:
    """Why a strut of the model does nothing wherever its joints are, or None: its ends are at one
    point, in a family in one member's. Whether they are is asked of positions that no mechanism
    singles out, and of a model with numbers without value not at all."""
    if not model.struts or model.missing:
        return None
    space, poses = of_dimension(model.dim), _poses(model)
    at = {
        frame.name: compose(poses[frame.body], frame.placement.lower(space, VALUES))[1]
        for frame in model.frames
    }
    for strut in model.struts:
        first, second = strut.frames
        apart = [np.abs(x) for x in sub(at[first], at[second])]
        none = np.argwhere(reduce(np.maximum, apart) <= _ONE_POINT)
        if len(none):
            member = of_member(tuple(map(int, none[0])))
            return (
                f"strut {strut.name!r}: frames {first!r} and {second!r} are always at one point"
                f"{member}, where a strut has no direction; name frames that move apart"
            )
    return None


def _poses(model: Model) -> dict[int, tuple[Matrix, Vector]]:
    """The pose of each body where all coordinates are some irrational numbers."""
    space = of_dimension(model.dim)
    found: dict[int, tuple[Matrix, Vector]] = {-1: (identity(model.dim), space.zero)}
    for i in parents_first(model.bodies):
        joint, kind = model.bodies[i].joint, model.bodies[i].kind
        pose = compose(found[model.bodies[i].parent], joint.placement.lower(space, VALUES))
        numbers = tuple(map(VALUES.quantity, joint.numbers))
        for k, (primitive, axis) in enumerate(kind.primitives(space, joint.axis, numbers)):
            q = tuple(math.sqrt(2.0 + 3.0 * i + k + 0.1 * n) for n in range(primitive.nq))
            pose = compose(pose, primitive.pose(space, axis, q))
        found[i] = pose
    return found
