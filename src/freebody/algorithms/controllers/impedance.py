"""Impedance of a frame: a spring and a damper between it and its reference (Hogan 1985)."""

from __future__ import annotations

from freebody.algorithms.controllers.pd_gravity import at_rest
from freebody.algorithms.controllers.pose_error import pose_error
from freebody.algorithms.kinematics import jacobian
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, sub, times, transposed


def impedance(
    tree: Tree,
    frame: str,
    rows: tuple[int, ...],
    q: Vector,
    qd: Vector,
    pose_ref: Matrix,
    V_ref: Vector,
    stiffness: Vector,
    damping: Vector,
) -> Vector:
    """tau = g + springs + Jᵀ (stiffness e + damping (V_ref - V)) of the chosen rows, the inertia
    left as it is.

    e: `pose_error`. At rest under a wrench w on the frame, stiffness e = -w.
    """
    J = tuple(jacobian(tree, q, frame)[r] for r in rows)
    apart, slower = pose_error(tree, q, frame, pose_ref), sub(V_ref, times(J, qd))
    wrench = tuple(
        k * apart[r] + d * v for r, k, d, v in zip(rows, stiffness, damping, slower, strict=True)
    )
    return add(at_rest(tree, q), times(transposed(J, tree.nv), wrench))
