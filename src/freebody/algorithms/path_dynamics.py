"""Torques of a robot along a path q(s): with q̇ = q' ṡ and q̈ = q' s̈ + q'' ṡ² they are linear in
s̈ and ṡ² (Bobrow, Dubowsky and Gibson 1985)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from freebody.algorithms.crba import mass_product, only_inertia
from freebody.algorithms.rnea import External, rnea
from freebody.model.tree import Tree
from freebody.spatial import Vector


def torques_along(
    tree: Tree, q: Vector, first: Vector, second: Vector, external: Sequence[External]
) -> tuple[Vector, Vector, Vector]:
    """(M q', M q'' + C q', what holds the robot still), without friction: the torque is the first
    times s̈, plus the second times ṡ², plus the third. first, second: q' and q''."""
    weightless = replace(only_inertia(tree), gravity=tree.space.zero)
    still = (0.0,) * tree.nv
    return (
        mass_product(tree, q, first),
        rnea(weightless, q, first, second).tau,
        rnea(tree, q, still, still, external).tau,
    )
