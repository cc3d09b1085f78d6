"""First derivatives of inverse and forward dynamics on the tangent space (Singh, Russell, Wensing
2022, IDSVA).

For body j and a body i on the way from j to the base, with I, B, f summed over what hangs on j, and
with Ψ̇ = v_parent × S, Ψ̈ = a_parent × S + v_parent × Ψ̇, Ṡ = v × S:

    ∂tau_i/∂q_j  = S_i · (2 B Ψ̇_j + I Ψ̈_j + S_j ×* f)               (the last term where i ≠ j)
    ∂tau_i/∂q̇_j = S_i · (2 B S_j + I (Ψ̇_j + Ṡ_j))
    ∂tau_j/∂q_i  = 2 Ψ̇_i · Bᵀ S_j + Ψ̈_i · I S_j                       (i ≠ j)
    ∂tau_j/∂q̇_i = 2 S_i · Bᵀ S_j + (Ψ̇_i + Ṡ_i) · I S_j               (i ≠ j)
    ∂tau_i/∂q̈_j = S_i · I S_j = M_ij
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from freebody.algorithms.crba import crba, factor, momentum_of, substitute
from freebody.algorithms.forward_dynamics import forward_dynamics
from freebody.algorithms.kinematics import (
    Column,
    along_every_direction,
    ancestors,
    weighted,
)
from freebody.algorithms.rnea import rnea
from freebody.algorithms.struts import struts_alone
from freebody.algorithms.world_axes import (
    Force,
    WorldTree,
    coriolis_times,
    coriolis_transposed_times,
    cross_force,
    cross_motion,
    dot_motion,
    plus_motion,
    world_tree,
)
from freebody.dual import Dual, slopes
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, dot, identity, neg, scale, sub, transposed


@dataclass
class Derivatives:
    """Derivatives of tau by q, q̇ and q̈ (the last is M), or of q̈ by q, q̇ and tau (the last is
    M⁻¹): each nv × nv."""

    by_q: Matrix
    by_qd: Matrix
    by_last: Matrix
    factors: dict[int, Scalar] = field(default_factory=dict)
    """tau for each unit transmitted, by coordinate, where a joint loses a part of the torque; by q̈
    it is then no longer M, nor symmetric."""


def inverse_dynamics_derivatives(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> Derivatives:
    """Derivatives of tau, those of the drives' laws, under which the sign of a rate is constant,
    and of struts included."""
    if tree.bends:
        return derivatives_by_dual_scalars(tree, q, qd, qdd)
    space = tree.space
    world = world_tree(tree, q, qd)
    _, psi_rate, forces = accelerations(tree, world, q, qd, qdd)
    n = tree.nv
    by_q, by_qd, by_qdd = ([[0.0] * n for _ in range(n)] for _ in range(3))

    def enter(table: list[list[Scalar]], k: int, l: int, value: Scalar) -> None:
        table[k][l] = table[k][l] + value

    for j, body in enumerate(tree.bodies):
        I, B, inner = world.inertia[j], world.coriolis[j], body.coordinates
        for b, l in enumerate(inner.v):
            s, psi = world.S[j][b], world.psi[j][b]
            carried = momentum_of(space, I, s)
            back = scale(2.0, coriolis_transposed_times(space, B, s))
            turning = plus_motion(
                _twice(coriolis_times(space, B, psi)), momentum_of(space, I, psi_rate[j][b])
            )
            by_position = plus_motion(turning, cross_force(space, s, forces[j]))
            both = plus_motion(psi, world.S_rate[j][b])
            by_rate = plus_motion(_twice(coriolis_times(space, B, s)), momentum_of(space, I, both))
            for i in ancestors(tree, j):
                outer = tree.bodies[i].coordinates
                for a, k in enumerate(outer.v):
                    r, ratio = world.S[i][a], outer.ratio * inner.ratio
                    mass = ratio * dot_motion(r, carried)
                    enter(by_q, k, l, ratio * dot_motion(r, turning if i == j else by_position))
                    enter(by_qd, k, l, ratio * dot_motion(r, by_rate))
                    enter(by_qdd, k, l, mass)
                    if i == j:
                        continue
                    enter(by_qdd, l, k, mass)
                    rates = plus_motion(world.psi[i][a], world.S_rate[i][a])
                    enter(by_qd, l, k, ratio * (dot(r[0], back) + dot_motion(rates, carried)))
                    swing = dot(world.psi[i][a][0], back) + dot_motion(psi_rate[i][a], carried)
                    enter(by_q, l, k, ratio * swing)
    pulls = _add_struts(tree, q, qd, enter, by_q, by_qd) if tree.struts else (0.0,) * n
    factors = {}
    for j, body in enumerate(tree.bodies):
        drive, k = body.drive, body.coordinates.v[0]
        if drive is not None and drive.lossy:
            needed = dot_motion(world.S[j][0], forces[j]) + pulls[k]
            transmitted = needed + drive.at_joint.torque(q, qd)
            factors[k] = 1.0 + drive.lost_part(qd, transmitted)
            for table, slope in zip((by_q, by_qd), drive.at_joint.slopes(q, qd), strict=True):
                enter(table, k, k, slope)
            for table in (by_q, by_qd, by_qdd):
                table[k] = [factors[k] * x for x in table[k]]
            drive = drive.at_motor
        if drive is not None:
            square = body.coordinates.ratio * body.coordinates.ratio
            by_position, by_rate = drive.slopes(q, qd)
            enter(by_q, k, k, square * by_position)
            enter(by_qd, k, k, square * by_rate)
            enter(by_qdd, k, k, square * drive.inertia)
    q_rows, qd_rows, qdd_rows = (tuple(map(tuple, table)) for table in (by_q, by_qd, by_qdd))
    return Derivatives(q_rows, qd_rows, qdd_rows, factors)


def derivatives_by_dual_scalars(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> Derivatives:
    """The same derivatives by forward mode, also where a joint follows another by a ratio that
    changes with the position."""
    n = tree.nv
    faster = tuple(Dual(x, {n + k: 1.0}) for k, x in enumerate(qd))
    recursion = rnea(tree, along_every_direction(tree, q), faster, qdd)
    rows = [slopes(torque, 2 * n) for torque in recursion.tau]
    by_qdd, factors = list(crba(tree, q)), {}
    for i, body in enumerate(tree.bodies):
        drive = body.drive
        if drive is not None and drive.lossy:
            k, (w, v) = body.coordinates.v[0], body.columns[0]
            needed = _value(dot(w, recursion.n[i]) + dot(v, recursion.f[i]))
            factors[k] = 1.0 + drive.lost_part(qd, needed + drive.at_joint.torque(q, qd))
            rotor = tuple(drive.inertia if l == k else 0.0 for l in range(n))
            by_qdd[k] = add(scale(factors[k], sub(by_qdd[k], rotor)), rotor)
    return Derivatives(
        tuple(tuple(row[:n]) for row in rows),
        tuple(tuple(row[n:]) for row in rows),
        tuple(by_qdd),
        factors,
    )


def _value(x: Scalar) -> Scalar:
    return x.value if isinstance(x, Dual) else x


def _add_struts(
    tree: Tree,
    q: Vector,
    qd: Vector,
    enter: Callable[[list[list[Scalar]], int, int, Scalar], None],
    by_q: list[list[Scalar]],
    by_qd: list[list[Scalar]],
) -> Vector:
    """The torques that struts need; their derivatives, by forward mode, are added to the tables of
    derivatives."""
    n = tree.nv
    faster = tuple(Dual(x, {n + k: 1.0}) for k, x in enumerate(qd))
    torques = rnea(struts_alone(tree), along_every_direction(tree, q), faster, (0.0,) * n).tau
    for k, torque in enumerate(torques):
        for l, slope in enumerate(slopes(torque, 2 * n)):
            enter(by_q if l < n else by_qd, k, l % n, slope)
    return tuple(map(_value, torques))


def forward_dynamics_derivatives(
    tree: Tree,
    q: Vector,
    qd: Vector,
    tau: Vector,
    inverse_derivatives: Callable[
        [Tree, Vector, Vector, Vector], Derivatives
    ] = inverse_dynamics_derivatives,
) -> Derivatives:
    """Derivatives of q̈: -M⁻¹ ∂tau/∂q, -M⁻¹ ∂tau/∂q̇ and M⁻¹, those of tau taken at the q̈ that tau
    causes."""
    qdd = forward_dynamics(tree, q, qd, tau)
    inverse = inverse_derivatives(tree, q, qd, qdd)

    def transmitted(table: Matrix) -> Matrix:
        """The rows divided by the share that lossy joints transmit, so that the last derivative is
        symmetric."""
        gain = inverse.factors
        return tuple(scale(1.0 / gain[k], row) if k in gain else row for k, row in enumerate(table))

    factors = factor(tree, transmitted(inverse.by_last))

    def solved(right: Matrix) -> Matrix:
        right = transmitted(right)
        return transposed(tuple(substitute(tree, factors, column) for column in transposed(right)))

    by_q, by_qd = (
        tuple(neg(row) for row in solved(right)) for right in (inverse.by_q, inverse.by_qd)
    )
    return Derivatives(by_q, by_qd, solved(identity(tree.nv)))


def _twice(force: Force) -> Force:
    return scale(2.0, force[0]), scale(2.0, force[1])


def accelerations(
    tree: Tree, world: WorldTree, q: Vector, qd: Vector, qdd: Vector
) -> tuple[list[Column], list[tuple[Column, ...]], list[Force]]:
    """The acceleration and Ψ̈ of each body, and the force on each subtree: I a + v ×* I v, gravity
    as base acceleration."""
    space = tree.space
    a: list[Column] = []
    psi_rate: list[tuple[Column, ...]] = []
    forces: list[Force] = []
    base = (space.zero_angular, neg(world.gravity))
    still = (space.zero_angular, space.zero)
    for i, body in enumerate(tree.bodies):
        a_parent = base if body.parent < 0 else a[body.parent]
        v_parent = still if body.parent < 0 else world.v[body.parent]
        psi_rate.append(
            tuple(
                plus_motion(cross_motion(space, a_parent, s), cross_motion(space, v_parent, psi))
                for s, psi in zip(world.S[i], world.psi[i], strict=True)
            )
        )
        own = plus_motion(
            weighted(world.S[i], body.coordinates.second_rates(q, qd, qdd)),
            weighted(world.psi[i], body.rates(q, qd)),
        )
        a.append(plus_motion(a_parent, own))
        momentum = momentum_of(space, world.own[i], world.v[i])
        gyroscopic = cross_force(space, world.v[i], momentum)
        forces.append(plus_motion(momentum_of(space, world.own[i], a[i]), gyroscopic))
    for i in reversed(range(len(tree.bodies))):
        parent = tree.bodies[i].parent
        if parent >= 0:
            forces[parent] = plus_motion(forces[parent], forces[i])
    return a, psi_rate, forces
