"""PD control with gravity compensation (Takegaki and Arimoto 1981)."""

from __future__ import annotations

from freebody.algorithms.kinematics import between
from freebody.algorithms.rnea import rnea
from freebody.model.tree import Tree
from freebody.spatial import Vector


def at_rest(tree: Tree, q: Vector) -> Vector:
    """The torques g + springs that hold the robot still."""
    still = (0.0,) * tree.nv
    return rnea(tree, q, still, still).tau


def pd_gravity(tree: Tree, q: Vector, qd: Vector, q_ref: Vector, kp: Vector, kd: Vector) -> Vector:
    """tau = g + springs + kp (q_ref ⊖ q) - kd q̇.

    T + ½ kp (q_ref ⊖ q)² then falls with kd q̇² and friction, so that q_ref is the one position of
    rest.
    """
    held, apart = at_rest(tree, q), between(tree, q, q_ref)
    return tuple(
        g + p * e - d * rate for g, p, e, d, rate in zip(held, kp, apart, kd, qd, strict=True)
    )
