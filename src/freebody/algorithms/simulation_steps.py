"""One step of a simulation as straight-line arithmetic, of any tree and any joints; forward
dynamics where dry friction or a stop holds some coordinates.

Positions move on their manifold: q ⊕ x is where the constant rates x lead in unit time
(`kinematics.moved`), and of q = q₀ ⊕ x the rates of x are those of the joint behind the
exponential's differential, ẋ = dexp⁻¹(x) v. Torques and external wrenches
depend on the time, torques on the state too, as their law says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from freebody.algorithms.crba import bias, crba, factor, substitute, with_drives
from freebody.algorithms.forward_dynamics import under_losses
from freebody.algorithms.kinematics import between, coordinate_rates, moved
from freebody.algorithms.loop_constraints import Counting, constrained_motion, onto_loops
from freebody.algorithms.rnea import External
from freebody.elementary import Scalar, absolute, less, maximum, sqrt, where
from freebody.model.drives.acting import DriveScalars
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, dot, scale, sub

MotionState = tuple[Vector, Vector]
"""Positions and rates (q, q̇)."""

Acceleration = Callable[[float, Vector, Vector], Vector]
"""Function (part of the step that has passed (0 to 1), q, q̇) -> q̈."""

StageWrenches = Callable[[float, Vector], Sequence[External]]
"""(part of the step that has passed, q) -> external wrenches on the bodies."""

FRICTION_WIDTH = 1e-3
"""rad/s or m/s: where `implicit` takes q̇ / sqrt(q̇² + width²) for the sign of a rate."""


def semi_implicit(
    tree: Tree, q: Vector, qd: Vector, h: Scalar, acceleration: Acceleration
) -> MotionState:
    """Semi-implicit (symplectic) Euler: q̇₁ = q̇ + h q̈, then q₁ = q ⊕ h q̇₁. Of order 1."""
    qd1 = add(qd, scale(h, acceleration(0.0, q, qd)))
    return moved(tree, q, scale(h, qd1)), qd1


def runge_kutta(
    tree: Tree, q: Vector, qd: Vector, h: Scalar, acceleration: Acceleration
) -> MotionState:
    """The classical method of order 4; positions by Munthe-Kaas (1998): stages in the coordinates x
    of q ⊕ x."""
    half, sixth = 0.5 * h, h * (1.0 / 6.0)
    v1, a1 = qd, acceleration(0.0, q, qd)

    def stage(part: float, length: Scalar, rates: Vector, change: Vector) -> MotionState:
        """(ẋ, q̈) where x = length · rates and q̇ has changed by length · change."""
        x, v = scale(length, rates), add(qd, scale(length, change))
        return coordinate_rates(tree, x, v), acceleration(part, moved(tree, q, x), v)

    v2, a2 = stage(0.5, half, v1, a1)
    v3, a3 = stage(0.5, half, v2, a2)
    v4, a4 = stage(1.0, h, v3, a3)

    def mean(first: Vector, second: Vector, third: Vector, fourth: Vector) -> Vector:
        return scale(sixth, add(add(first, fourth), scale(2.0, add(second, third))))

    return moved(tree, q, mean(v1, v2, v3, v4)), add(qd, mean(a1, a2, a3, a4))


@dataclass(frozen=True)
class Linearised:
    """Torques at the joints besides the robot's own drives, linear in the state: tau at a state,
    its decrease per second while the state moves on at its rates, and its decrease per unit of each
    joint's q and q̇ (diagonals, at least 0)."""

    tau: Vector
    ahead: Vector
    stiffness: Vector
    damping: Vector


Law = Callable[[float, float, Vector, Vector], Linearised]
"""(parts of the step at which a stage of it begins and ends, q and q̇ at its beginning) -> the
torques of the stage."""


def held(tau: Vector) -> Law:
    """A control law with the constant torque tau."""
    nothing = (0.0,) * len(tau)
    return lambda start, end, q, qd: Linearised(tau, nothing, nothing, nothing)


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

    def law(self, tree: Tree, tau: Vector, h: Scalar) -> Law:
        """The law of feedback around tau, over a step of h."""

        def at(start: float, end: float, q: Vector, qd: Vector) -> Linearised:
            aim = self.q_ref
            if start:
                aim = moved(tree, aim, scale(start * h, self.qd_ref))
            apart, faster = between(tree, aim, q), sub(qd, self.qd_ref)
            given = sub(tau, add(_each(self.kp, apart), _each(self.kd, faster)))
            return Linearised(given, _each(self.kp, faster), self.kp, self.kd)

        return at


def implicit(
    tree: Tree,
    q: Vector,
    qd: Vector,
    h: Scalar,
    loads: StageWrenches,
    law: Law,
    counting: Counting | None = None,
    width: Scalar = FRICTION_WIDTH,
) -> MotionState:
    """Linearly implicit Euler, extrapolated once (Deuflhard 1985): of order 2, stable however stiff
    the drives are.

    Two steps of h/2 less one of h, so that the error's first term cancels. Implicit is what the
    drives do: friction, springs, feedback. They add h D + h² K to M, on its diagonal, so that its
    factors stay without fill-in; the order does not depend on what is implicit. The step of h
    shares M and the forces with the first of h/2. width: of q̇ / sqrt(q̇² + width²), which
    stands for the sign of a rate.
    """
    half = 0.5 * h

    def euler(state: MotionState, start: float, end: float, length: Scalar) -> MotionState:
        given = law(start, end, *state)
        return _implicit_euler(tree, *state, length, loads(end, state[0]), given, counting, width)

    rough = euler((q, qd), 0.0, 1.0, h)
    middle = euler((q, qd), 0.0, 0.5, half)
    fine = euler(middle, 0.5, 1.0, half)
    on = moved(tree, fine[0], between(tree, rough[0], fine[0]))
    return on, sub(scale(2.0, fine[1]), rough[1])


def _implicit_euler(
    tree: Tree,
    q: Vector,
    qd: Vector,
    h: Scalar,
    loads: Sequence[External],
    given: Linearised,
    counting: Counting | None,
    width: Scalar,
) -> MotionState:
    """One linearly implicit Euler step: (M + h D + h² K) q̈ = forces - h (stiffness q̇ + ahead),
    then the update of `semi_implicit`.

    The forces are those at q and q̇; D and K on the left are the slopes of what the drives take of
    them, K where it is above 0: what pushes away would leave M + h D + h² K without an inverse.
    """
    M = crba(tree, q)
    lost = _losses(tree, q, qd, M, given.tau, loads, width) if tree.lossy else None
    tree = with_signs(tree, lambda rate: 0.0)  # what depends on them comes as drag
    damping, stiffness, drag = _slopes(tree, q, qd, width)
    drag = drag if lost is None else add(drag, lost)
    forces = sub(sub(given.tau, bias(tree, q, qd, loads)), _each(drag, qd))
    ahead = add(_each(stiffness, qd), given.ahead)
    damping, stiffness = add(damping, given.damping), add(stiffness, given.stiffness)
    added = scale(h, add(damping, drag, scale(h, stiffness)))
    M = tuple(
        tuple(x + added[i] if i == j else x for j, x in enumerate(row)) for i, row in enumerate(M)
    )
    factors, forces = factor(tree, M), sub(forces, scale(h, ahead))
    if tree.loops:
        qdd = constrained_motion(tree, q, qd, factors, forces, counting).qdd
    else:
        qdd = substitute(tree, factors, forces)
    return semi_implicit(tree, q, qd, h, lambda part, q, qd: qdd)


def with_signs(tree: Tree, of: Callable[[Scalar], Scalar]) -> Tree:
    """The tree whose friction laws use a given function of the joints' rates in place of their
    signs."""
    return with_drives(tree, lambda drive: replace(drive, sign=lambda law, rate: of(rate)))


def with_senses(tree: Tree, senses: Vector, of: Callable[[Scalar], Scalar]) -> Tree:
    """The tree whose friction laws use given senses (one a coordinate) in place of the signs of
    rates where they hold what is at rest, and a given function of the rates in the others."""

    def given(drive: DriveScalars) -> DriveScalars:
        sense = senses[drive.at.v[0]] if drive.at.ratio > 0.0 else -senses[drive.at.v[0]]
        return replace(drive, sign=lambda law, rate: sense if law.grips else of(rate))

    return with_drives(tree, given)


def drags(tree: Tree, q: Vector, qd: Vector) -> Vector:
    """The torque at each coordinate per unit of the sign of its rate, from the laws (such as dry
    friction) that can hold a joint at rest."""
    found: list[Scalar] = [0.0] * tree.nv
    for body in tree.bodies:
        if body.drive is not None:
            k, ratio = body.coordinates.v[0], abs(body.coordinates.ratio)
            gripping = body.drive.only(lambda law: law.grips)
            found[k] = found[k] + ratio * gripping.drag(q, qd)
    return tuple(found)


def _slopes(tree: Tree, q: Vector, qd: Vector, width: Scalar) -> tuple[Vector, Vector, Vector]:
    """Damping (slopes of the torque by each rate), stiffness (by each position), and the part that
    depends on the rate's sign divided by the rate; stiffness is never below 0."""
    damping, stiffness, drag = ([0.0] * tree.nv for _ in range(3))
    for body in tree.bodies:
        if body.drive is not None:
            (rate,), k, square = body.rates(qd), body.coordinates.v[0], body.coordinates.ratio**2
            by_position, by_rate = body.drive.slopes(q, qd)
            size = sqrt(rate * rate + width * width)
            damping[k] = damping[k] + square * by_rate
            stiffness[k] = stiffness[k] + square * maximum(by_position, 0.0)
            drag[k] = drag[k] + square * (body.drive.drag(q, qd) / size)
    return tuple(damping), tuple(stiffness), tuple(drag)


def _losses(
    tree: Tree,
    q: Vector,
    qd: Vector,
    M: Matrix,
    tau: Vector,
    loads: Sequence[External],
    width: Scalar,
) -> Vector:
    """The torque that lossy joints lose, divided by the rate; what they transmit is that under the
    torques tau at the state."""

    def size(rate: Scalar) -> Scalar:
        return sqrt(rate * rate + width * width)

    rubbing = with_signs(tree, lambda rate: rate / size(rate))
    forces = sub(tau, bias(rubbing, q, qd, loads))
    sent = under_losses(rubbing, q, qd, tau, M, forces).transmitted
    found: list[Scalar] = [0.0] * tree.nv
    for body in tree.bodies:
        if body.drive is not None and body.drive.lossy:
            k = body.coordinates.v[0]
            driving, driven = body.drive.losses
            part = where(less(0.0, qd[k] * sent[k]), driving, driven)
            found[k] = part * absolute(sent[k]) / size(qd[k])
    return tuple(found)


def _each(factors: Vector, values: Vector) -> Vector:
    return tuple(a * x for a, x in zip(factors, values, strict=True))


def on_loops(tree: Tree, q: Vector, reached: MotionState, counting: Counting | None) -> MotionState:
    """The state reached from q, brought back onto the loops of a closed chain; unchanged for a
    tree."""
    if not tree.loops:
        return reached
    return onto_loops(tree, *reached, factor(tree, crba(tree, q)), counting)


class HeldMotion(NamedTuple):
    """The motion of a tree some of whose coordinates are held, by dry friction or by a stop: q̈
    (nv,), 0 of those; the torques that hold them (nv,), 0 of the others; M (nv, nv)."""

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
