"""Control of a frame's motion in operational space (Khatib 1987)."""

from __future__ import annotations

from freebody.algorithms.controllers.pose_error import pose_error
from freebody.algorithms.crba import bias, crba, factor, substitute
from freebody.algorithms.kinematics import frame_motion, jacobian, outward
from freebody.algorithms.operational_space import inverse_of_symmetric
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, dot, symmetric, times, transposed


def operational_space_control(
    tree: Tree,
    frame: str,
    rows: tuple[int, ...],
    q: Vector,
    qd: Vector,
    pose_ref: Matrix,
    V_ref: Vector,
    A_ref: Vector,
    kp_task: Vector,
    kd_task: Vector,
    tau_null: Vector,
) -> Vector:
    """tau = Jᵀ Λ (A_ref + kd (V_ref - V) + kp e - J̇ q̇) + (1 - Jᵀ Λ J M⁻¹) tau_null + bias.

    The chosen rows of the frame's motion then have ë + kd ė + kp e = 0; tau_null moves only what
    does not accelerate them. e: `pose_error`. bias: c + g + friction + springs, taken whole, so
    that a redundant arm does not fall in its null space.
    """
    J = tuple(jacobian(tree, q, frame)[r] for r in rows)
    factors = factor(tree, crba(tree, q))
    solved = [substitute(tree, factors, row) for row in J]
    inertia = inverse_of_symmetric(symmetric(len(rows), lambda i, j: dot(J[i], solved[j])))
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    (w, v), (wd, vd) = frame_motion(tree, motion, frame)
    twist, drift, apart = v + w, vd + wd, pose_error(tree, q, frame, pose_ref)
    wanted = tuple(
        a + d * (u - twist[r]) + p * apart[r] - drift[r] - dot(solved[i], tau_null)
        for i, (r, a, d, u, p) in enumerate(zip(rows, A_ref, kd_task, V_ref, kp_task, strict=True))
    )
    wrench = times(inertia, wanted)
    return add(times(transposed(J, tree.nv), wrench), tau_null, bias(tree, q, qd))
