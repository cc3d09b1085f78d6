"""One step of a simulation as straight-line arithmetic, of any tree and any joints.

Positions move on their manifold: q ⊕ x is where the constant rates x lead in unit time
(`kinematics.moved`), and of q = q₀ ⊕ x the rates of x are those of the joint behind the
exponential's differential, ẋ = dexp⁻¹(x) v. Motor torques and external wrenches are held over the
step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from freebody.algorithms.crba import bias, crba, factor, substitute, without
from freebody.algorithms.kinematics import between, coordinate_rates, moved
from freebody.algorithms.loop_constraints import constrained_motion, onto_loops
from freebody.algorithms.rnea import External
from freebody.elementary import Scalar, sqrt
from freebody.model.tree import Tree
from freebody.spatial import Vector, add, scale, sub

State = tuple[Vector, Vector]
"""(q, q̇)."""

Acceleration = Callable[[Vector, Vector], Vector]
"""q̈ of q and q̇."""

Loads = Callable[[Vector], Sequence[External]]
"""External wrenches on the bodies, of q."""

FRICTION_WIDTH = 1e-3
"""rad/s or m/s: where `implicit` takes c q̇ / sqrt(q̇² + width²) for Coulomb friction c
sign(q̇)."""


def semi_implicit(
    tree: Tree, q: Vector, qd: Vector, h: Scalar, acceleration: Acceleration
) -> State:
    """Semi-implicit (symplectic) Euler: q̇₁ = q̇ + h q̈, then q₁ = q ⊕ h q̇₁. Of order 1."""
    qd1 = add(qd, scale(h, acceleration(q, qd)))
    return moved(tree, q, scale(h, qd1)), qd1


def runge_kutta(tree: Tree, q: Vector, qd: Vector, h: Scalar, acceleration: Acceleration) -> State:
    """The classical method of order 4; positions by Munthe-Kaas (1998): stages in the coordinates x
    of q ⊕ x."""
    half, sixth = 0.5 * h, h * (1.0 / 6.0)
    v1, a1 = qd, acceleration(q, qd)

    def stage(length: Scalar, rates: Vector, change: Vector) -> State:
        """(ẋ, q̈) where x = length · rates and q̇ has changed by length · change."""
        x, v = scale(length, rates), add(qd, scale(length, change))
        return coordinate_rates(tree, x, v), acceleration(moved(tree, q, x), v)

    v2, a2 = stage(half, v1, a1)
    v3, a3 = stage(half, v2, a2)
    v4, a4 = stage(h, v3, a3)

    def mean(first: Vector, second: Vector, third: Vector, fourth: Vector) -> Vector:
        return scale(sixth, add(add(first, fourth), scale(2.0, add(second, third))))

    return moved(tree, q, mean(v1, v2, v3, v4)), add(qd, mean(a1, a2, a3, a4))


@dataclass(frozen=True)
class Feedback:
    """Torques -kp (q ⊖ q_ref) - kd (q̇ - qd_ref) besides tau; q_ref is that at the step's start and
    moves with qd_ref.

    kp, kd: one gain a rate. q ⊖ q_ref is the way from q_ref to q (`kinematics.between`).
    """

    q_ref: Vector
    qd_ref: Vector
    kp: Vector
    kd: Vector

    def later(self, tree: Tree, time: Scalar) -> Feedback:
        """With the reference where it is after a time."""
        return replace(self, q_ref=moved(tree, self.q_ref, scale(time, self.qd_ref)))


def implicit(
    tree: Tree,
    q: Vector,
    qd: Vector,
    tau: Vector,
    h: Scalar,
    loads: Loads,
    feedback: Feedback | None = None,
    rows: Sequence[int] | None = None,
) -> State:
    """Linearly implicit Euler, extrapolated once (Deuflhard 1985): of order 2, stable however stiff
    the drives are.

    Two steps of h/2 less one of h, so that the error's first term cancels. Implicit is what the
    drives do: friction, springs, feedback. They add h D + h² K to M, on its diagonal, so that its
    factors stay without fill-in; the order does not depend on what is implicit. The step of h
    shares M and the forces with the first of h/2.
    """
    half = 0.5 * h

    def euler(start: State, length: Scalar, law: Feedback | None) -> State:
        return _implicit_euler(tree, *start, tau, length, loads, law, rows)

    rough = euler((q, qd), h, feedback)
    middle = euler((q, qd), half, feedback)
    fine = euler(middle, half, None if feedback is None else feedback.later(tree, half))
    on = moved(tree, fine[0], between(tree, rough[0], fine[0]))
    return on, sub(scale(2.0, fine[1]), rough[1])


def _implicit_euler(
    tree: Tree,
    q: Vector,
    qd: Vector,
    tau: Vector,
    h: Scalar,
    loads: Loads,
    feedback: Feedback | None,
    rows: Sequence[int] | None,
) -> State:
    """(M + h D + h² K) q̈ = forces - h (stiffness q̇ + kp (q̇ - qd_ref)), then as `semi_implicit`.

    The forces are those at q and q̇; D and K on the left are the slopes of what the drives take of
    them.
    """
    damping, stiffness, drag = _slopes(tree, qd)
    forces = sub(sub(tau, bias(without(tree, "coulomb"), q, qd, loads(q))), _each(drag, qd))
    ahead = _each(stiffness, qd)
    if feedback is not None:
        apart, faster = between(tree, feedback.q_ref, q), sub(qd, feedback.qd_ref)
        forces = sub(forces, add(_each(feedback.kp, apart), _each(feedback.kd, faster)))
        ahead = add(ahead, _each(feedback.kp, faster))
        damping, stiffness = add(damping, feedback.kd), add(stiffness, feedback.kp)
    added = scale(h, add(damping, drag, scale(h, stiffness)))
    M = tuple(
        tuple(x + added[i] if i == j else x for j, x in enumerate(row))
        for i, row in enumerate(crba(tree, q))
    )
    factors, forces = factor(tree, M), sub(forces, scale(h, ahead))
    if tree.loops:
        qdd = constrained_motion(tree, q, qd, factors, forces, rows).qdd
    else:
        qdd = substitute(tree, factors, forces)
    return semi_implicit(tree, q, qd, h, lambda q, qd: qdd)


def _slopes(tree: Tree, qd: Vector) -> tuple[Vector, Vector, Vector]:
    """Of each rate: viscous friction, stiffness of springs, and smooth Coulomb friction over the
    rate."""
    viscous, stiffness, drag = ([0.0] * tree.nv for _ in range(3))
    for body in tree.bodies:
        if body.drive is not None:
            (rate,), k, square = body.rates(qd), body.coordinates.v[0], body.coordinates.ratio**2
            size = sqrt(rate * rate + FRICTION_WIDTH**2)
            viscous[k] = viscous[k] + square * body.drive.viscous
            stiffness[k] = stiffness[k] + square * body.drive.stiffness
            drag[k] = drag[k] + square * (body.drive.coulomb / size)
    return tuple(viscous), tuple(stiffness), tuple(drag)


def _each(factors: Vector, values: Vector) -> Vector:
    return tuple(a * x for a, x in zip(factors, values, strict=True))


def on_loops(tree: Tree, q: Vector, reached: State, rows: Sequence[int] | None) -> State:
    """The state reached from q, brought back onto the loops; that of a tree as it is."""
    if not tree.loops:
        return reached
    return onto_loops(tree, *reached, factor(tree, crba(tree, q)), rows)
