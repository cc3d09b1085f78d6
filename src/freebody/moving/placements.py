"""Placements of a robot's bodies as a JavaScript function, from the recursion that everything else
uses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.model.model import Model
from freebody.program import Argument, Program, trace
from freebody.targets.text import LANGUAGES, SourceUnit

NAME = "placed"
"""The function's name: frames = placed(q, frames)."""
SIZE = 12
"""Numbers of a placement: its rotation, row by row, then its place, m."""


def placements(model: Model) -> str:
    """JavaScript text of a function from q (nq,) to the placements of all bodies, each with twelve
    numbers in world axes; those of the plane lie in z = 0."""
    return LANGUAGES["javascript-script"].emit(SourceUnit(placement_program(model), NAME))


def placement_program(model: Model) -> Program:
    """The program behind `placements`."""
    tree = model.tree

    def placed(q: Sequence[Any]) -> tuple[list[Any]]:
        poses = world_poses(tree, joint_poses(tree, tuple(q)))
        numbers = (x for k in tree.body_of for x in in_space(*poses[k]))
        return (list(numbers),)

    outputs = (Argument("frames", (SIZE * len(model.bodies),)),)
    return trace(NAME, placed, (Argument("q", (model.nq,)),), outputs)


def in_space(R: Sequence[Sequence[Any]], p: Sequence[Any]) -> list[Any]:
    """The twelve numbers of a placement, which may be one of the plane."""
    if len(p) == 3:
        return [*R[0], *R[1], *R[2], *p]
    (a, b), (c, d) = R
    return [a, b, 0.0, c, d, 0.0, 0.0, 0.0, 1.0, *p, 0.0]
