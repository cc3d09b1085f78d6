"""Forward dynamics of a tree some of whose coordinates are held: by dry friction, or by a stop."""

from __future__ import annotations

from typing import NamedTuple

from freebody.algorithms.crba import crba, factor, substitute
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, dot, sub


class HeldMotion(NamedTuple):
    """q̈ (nv,), 0 of what is held; what holds it (nv,), 0 of what is not; M (nv, nv)."""

    qdd: Vector
    reaction: Vector
    M: Matrix


def held_motion(tree: Tree, q: Vector, forces: Vector, held: Vector) -> HeldMotion:
    """M q̈ = forces + reaction, with q̈ = 0 and a reaction where held is 1, no reaction where it is
    0.

    The rows and columns of what is held are taken out of M and replaced by those of the identity,
    so that one program serves every choice.
    """
    M = crba(tree, q)
    free = tuple(1.0 - x for x in held)
    rows = tuple(
        tuple(_entry(x, free[i] * free[j], held[i], i == j) for j, x in enumerate(row))
        for i, row in enumerate(M)
    )
    right = tuple(a * f for a, f in zip(free, forces, strict=True))
    qdd = substitute(tree, factor(tree, rows), right)
    lacking = sub(tuple(dot(row, qdd) for row in M), forces)
    return HeldMotion(qdd, tuple(h * x for h, x in zip(held, lacking, strict=True)), M)


def _entry(x: Scalar, free: Scalar, held: Scalar, diagonal: bool) -> Scalar:
    return free * x + held if diagonal else free * x
