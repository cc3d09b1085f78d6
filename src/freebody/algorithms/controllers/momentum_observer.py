"""Disturbance torque from the generalized momentum (De Luca and Mattone 2003)."""

from __future__ import annotations

from freebody.algorithms.coriolis import coriolis_matrix
from freebody.algorithms.crba import bias, mass_product
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import Vector, add, plus, scale, sub, times, transposed


def momentum_observer(
    tree: Tree, q: Vector, qd: Vector, tau: Vector, h: Scalar, integral: Vector, ko: Vector
) -> tuple[Vector, Vector]:
    """(r, integral): r follows the torque that acts besides tau, ṙ = ko (tau_ext - r).

    r = ko (p - integral) with p = M q̇; the integral gains h (tau + Cᵀ q̇ - g - friction - springs +
    r), of r the new value (implicit Euler, stable for every gain). tau: what acted over the last h.
    Cᵀ q̇ - g - friction - springs = (C + Cᵀ) q̇ - bias.
    """
    C = coriolis_matrix(tree, q, qd)
    forces = sub(bias(tree, q, qd), times(plus(C, transposed(C, tree.nv)), qd))
    before = add(integral, scale(h, sub(tau, forces)))
    p = mass_product(tree, q, qd)
    r = tuple(k * (a - b) / (1.0 + h * k) for k, a, b in zip(ko, p, before, strict=True))
    return r, add(before, scale(h, r))
