"""Computed torque: feedback linearisation by inverse dynamics (Luh, Walker, Paul 1980)."""

from __future__ import annotations

from freebody.algorithms.kinematics import between
from freebody.algorithms.rnea import rnea
from freebody.model.tree import Tree
from freebody.spatial import Vector


def computed_torque(
    tree: Tree,
    q: Vector,
    qd: Vector,
    q_ref: Vector,
    qd_ref: Vector,
    qdd_ref: Vector,
    kp: Vector,
    kd: Vector,
) -> Vector:
    """tau = M (q̈_ref + kd ė + kp e) + c + g + friction + springs with e = q_ref ⊖ q, so that
    ë + kd ė + kp e = 0."""
    apart = between(tree, q, q_ref)
    wanted = tuple(
        a + d * (v - rate) + p * e
        for a, d, v, rate, p, e in zip(qdd_ref, kd, qd_ref, qd, kp, apart, strict=True)
    )
    return rnea(tree, q, qd, wanted).tau
