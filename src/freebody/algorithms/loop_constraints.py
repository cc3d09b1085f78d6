"""Closed chains: the loop equations Φ(q) = 0, their derivatives (5.21, 5.22, 5.28), the motion
under them (5.29).

Each equation is a function of how frames A and B stand to one another, and its rate is

    φ̇ = f · (v_B - v_A) + n_B · ω_B - n_A · ω_A

with f, n_A, n_B in world axes. Its multiplier λ stands for a force -λ f on B at its origin and the
opposite on A.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple

from freebody.algorithms.crba import Factors, bias, crba, factor, substitute
from freebody.algorithms.kinematics import (
    Column,
    Pose,
    frame_columns,
    frame_motion,
    frame_pose,
    joint_poses,
    moved,
    outward,
    world_poses,
)
from freebody.algorithms.loop_scales import equations_of_lengths, mechanism_length, no_finer
from freebody.algorithms.rnea import External
from freebody.elementary import Scalar, maximum, minimum, sign, sqrt
from freebody.model.tree import Tree, TreeLoop
from freebody.spatial import (
    AnySpace,
    Matrix,
    Vector,
    add,
    dot,
    identity,
    scale,
    sub,
    times,
    transposed,
)


@dataclass(frozen=True)
class LoopEquation:
    """One loop equation: its value, what its multiplier presses with, and how that changes with
    time."""

    value: Scalar
    f: Vector
    n_a: Vector
    n_b: Vector


Velocities = tuple[Column, Column]
"""Velocities (ω, v) of both sides of a loop, A and B."""


class Counting(NamedTuple):
    """The loop equations that are counted as independent; those left out follow from them."""

    rows: tuple[int, ...]
    slack: float = 0.0
    """The residual that rounding of the model's numbers may leave of the other equations, relative
    to their terms."""

    def left_out(self, tree: Tree) -> tuple[int, ...]:
        """Rows of the loop equations that do not count."""
        return tuple(k for k in range(tree.constraints) if k not in self.rows)


def loop_equations(space: AnySpace, loop: TreeLoop, a: Pose, b: Pose) -> list[LoopEquation]:
    """The equations of a loop whose frames stand at a and b."""
    (R_a, p_a), (R_b, p_b) = a, b
    r = sub(p_b, p_a)
    none = space.zero_angular
    found = []
    if loop.closure.point:
        found += [
            LoopEquation(x, e, none, none) for x, e in zip(r, identity(space.dim), strict=True)
        ]
    if loop.closure.distance:
        # (|r|² - d²) / 2d: at closure its gradient is a unit vector, so λ is the tension
        d = loop.distance
        value = (dot(r, r) - d * d) * (0.5 / d)
        found.append(LoopEquation(value, scale(1.0 / d, r), none, none))
    for n in loop.closure.slides:
        f = times(R_a, n)
        found.append(LoopEquation(dot(f, r), f, space.moment(r, f), none))
    for n, u in loop.closure.turns:
        n_world, u_world = times(R_a, n), times(R_b, u)
        moment = space.moment(u_world, n_world)
        found.append(LoopEquation(dot(n_world, u_world), space.zero, moment, moment))
    return found


def constraint(tree: Tree, q: Vector) -> Vector:
    """Φ(q): how far every loop equation is from holding (m; sines of angles)."""
    world = world_poses(tree, joint_poses(tree, q))
    return tuple(
        equation.value
        for loop in tree.loops
        for equation in loop_equations(tree.space, loop, *_ends(tree, world, loop))
    )


def constraint_jacobian(tree: Tree, q: Vector) -> Matrix:
    """Φ_q (5.22): one row an equation, one column a rate."""
    space = tree.space
    world = world_poses(tree, joint_poses(tree, q))
    rows = []
    for loop in tree.loops:
        a, b = _ends(tree, world, loop)
        equations = loop_equations(space, loop, a, b)
        row: list[list[Scalar]] = [[0.0] * tree.nv for _ in equations]
        for k, (angular, linear) in _rates(tree, world, b, loop.frames[1]):
            for entry, e in zip(row, equations, strict=True):
                entry[k] = entry[k] + (dot(e.f, linear) + dot(e.n_b, angular))
        for k, (angular, linear) in _rates(tree, world, a, loop.frames[0]):
            for entry, e in zip(row, equations, strict=True):
                entry[k] = entry[k] - (dot(e.f, linear) + dot(e.n_a, angular))
        rows += map(tuple, row)
    return tuple(rows)


def constraint_rate(tree: Tree, q: Vector, qd: Vector) -> Vector:
    """Rates of the loop equations, Φ_q q̇."""
    return times(constraint_jacobian(tree, q), qd)


def constraint_bias(tree: Tree, q: Vector, qd: Vector) -> Vector:
    """c = -Φ̇_q q̇ (5.28): what Φ_q q̈ must be."""
    space = tree.space
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    world = world_poses(tree, motion.joints)
    values: list[Scalar] = []
    for loop in tree.loops:
        a, b = _ends(tree, world, loop)
        (v_a, a_a), (v_b, a_b) = (frame_motion(tree, motion, frame) for frame in loop.frames)
        slope = _equation_rates(space, loop, a, b, (v_a, v_b))
        for e, (fd, nd_a, nd_b) in zip(loop_equations(space, loop, a, b), slope, strict=True):
            second = dot(e.f, sub(a_b[1], a_a[1])) + dot(e.n_b, a_b[0]) - dot(e.n_a, a_a[0])
            rate = dot(fd, sub(v_b[1], v_a[1])) + dot(nd_b, v_b[0]) - dot(nd_a, v_a[0])
            values.append(-(second + rate))
    return tuple(values)


def _equation_rates(
    space: AnySpace, loop: TreeLoop, a: Pose, b: Pose, velocities: Velocities
) -> Iterator[tuple[Vector, Vector, Vector]]:
    """Time derivatives of (f, n_a, n_b) of each equation."""
    (R_a, p_a), (R_b, p_b) = a, b
    (w_a, v_a), (w_b, v_b) = velocities
    r, rd = sub(p_b, p_a), sub(v_b, v_a)
    still, none = space.zero, space.zero_angular
    if loop.closure.point:
        yield from [(still, none, none)] * space.dim
    if loop.closure.distance:
        yield scale(1.0 / loop.distance, rd), none, none
    for n in loop.closure.slides:
        f = times(R_a, n)
        fd = space.cross(w_a, f)
        yield fd, add(space.moment(rd, f), space.moment(r, fd)), none
    for n, u in loop.closure.turns:
        n_world, u_world = times(R_a, n), times(R_b, u)
        moment = add(
            space.moment(space.cross(w_b, u_world), n_world),
            space.moment(u_world, space.cross(w_a, n_world)),
        )
        yield still, moment, moment


def loop_wrenches(
    tree: Tree, q: Vector, multipliers: Vector, reference: str = "world"
) -> list[Vector]:
    """Wrench (force, moment) of each loop on B by A at the origin of B, world axes or B's
    ("child"): what -Φ_qᵀ λ (5.23) stands for."""
    space = tree.space
    world = world_poses(tree, joint_poses(tree, q))
    wrenches, k = [], 0
    for loop in tree.loops:
        force, moment = space.zero, space.zero_angular
        a, b = _ends(tree, world, loop)
        for e in loop_equations(space, loop, a, b):
            force = sub(force, scale(multipliers[k], e.f))
            moment = sub(moment, scale(multipliers[k], e.n_b))
            k += 1
        if reference == "child":
            E = transposed(b[0])
            force, moment = times(E, force), space.turn(E, moment)
        wrenches.append(force + moment)
    return wrenches


def loop_loads(tree: Tree, q: Vector, multipliers: Vector) -> list[External]:
    """The wrenches of all loops as they act on their bodies, for the recursion."""
    space = tree.space
    world = world_poses(tree, joint_poses(tree, q))
    loads: list[External] = []
    k = 0
    for loop in tree.loops:
        ends = _ends(tree, world, loop)
        for e in loop_equations(space, loop, *ends):
            for frame, side, moment in (
                (loop.frames[1], -1.0, e.n_b),
                (loop.frames[0], 1.0, e.n_a),
            ):
                body, _, at = tree.frames[frame]
                if body >= 0:
                    E = transposed(world[body][0])
                    force = times(E, scale(side * multipliers[k], e.f))
                    turning = space.turn(E, scale(side * multipliers[k], moment))
                    loads.append((body, force, add(turning, space.moment(at, force))))
            k += 1
    return loads


@dataclass(frozen=True)
class Constrained:
    """Accelerations, multipliers, and the pivots of S: near 0 where equations depend on one
    another, or vanish."""

    qdd: Vector
    multipliers: Vector
    pivots: Vector


def constrained_dynamics(
    tree: Tree,
    q: Vector,
    qd: Vector,
    tau: Vector,
    external: Sequence[External] = (),
    counting: Counting | None = None,
) -> Constrained:
    """q̈ and λ from (5.29) by M⁻¹ and S = Φ_q M⁻¹ Φ_qᵀ, for equations (default all) that are
    independent."""
    factors = factor(tree, crba(tree, q))
    forces = sub(tau, bias(tree, q, qd, external))
    return constrained_motion(tree, q, qd, factors, forces, counting)


def constrained_motion(
    tree: Tree,
    q: Vector,
    qd: Vector,
    factors: Factors,
    forces: Vector,
    counting: Counting | None = None,
) -> Constrained:
    """q̈ and λ of M q̈ + Φ_qᵀ λ = forces and Φ_q q̈ = c, from the factors of M."""
    phi = kept(constraint_jacobian(tree, q), counting)
    c = kept(constraint_bias(tree, q, qd), counting)
    free = substitute(tree, factors, forces)
    missing = tuple(dot(row, free) - x for row, x in zip(phi, c, strict=True))
    return Constrained(*_nearest(tree, factors, phi, free, missing))


def onto_loops(
    tree: Tree, q: Vector, qd: Vector, factors: Factors, counting: Counting | None = None
) -> tuple[Vector, Vector]:
    """(q, q̇) brought back onto loops that are a little open: one Newton step of positions, then
    the rates projected.

    Both are the least change in the metric M. NaN where the equations that count depend on one
    another, so that others would have to count, and where a loop stays open, or one that was left
    out would open.
    """
    phi, open_by = (kept(f(tree, q), counting) for f in (constraint_jacobian, constraint))
    q = moved(tree, q, _nearest(tree, factors, phi, (0.0,) * tree.nv, open_by)[0])
    every, left, angles = constraint_jacobian(tree, q), constraint(tree, q), _as_angles(tree)
    phi = kept(every, counting)
    on, _, pivots = _nearest(tree, factors, phi, qd, times(phi, qd))
    if not phi:
        return q, qd
    gaps = tuple(s * x for s, x in zip(angles, left, strict=True))
    gap = dot(gaps, gaps)
    slack = counting.slack if counting else 0.0
    allowed = no_finer(max(_OPEN, slack), gap, _ROUNDINGS)
    margins = [independence(tree, pivots, counting), allowed * allowed - gap]
    others = counting.left_out(tree) if counting else ()
    if others:
        opening = tuple(angles[k] * dot(every[k], on) for k in others)
        speed = allowed * allowed * (1.0 + dot(on, on))
        margins.append(speed - dot(opening, opening))
    valid = one_if_positive(*margins)
    return scale(valid, q), scale(valid, on)


def independence(tree: Tree, pivots: Vector, counting: Counting | None = None) -> Scalar:
    """Positive where the equations that count, whose pivots of S these are, do not depend on one
    another."""
    angles = kept(_as_angles(tree), counting)
    sizes = [s * s * pivot for s, pivot in zip(angles, pivots, strict=True)]
    most = reduce(maximum, sizes)
    return reduce(minimum, sizes) - no_finer(_PIVOT, most, _ROUNDINGS) * most


def _as_angles(tree: Tree) -> Vector:
    """Factors that make residuals of loop equations comparable: 1 for angles, one over the
    mechanism's length for lengths."""
    per_length = 1.0 / mechanism_length(tree)
    return tuple(per_length if of_length else 1.0 for of_length in equations_of_lengths(tree))


_PIVOT = 1e-10
"""The smallest pivot of S relative to the largest, from which the equations are independent enough
to project with."""
_OPEN = 1e-5
"""rad, or lengths of the mechanism: loops that a Newton step leaves open by more are not closed."""
_ROUNDINGS = 128.0
"""Both limits in units of rounding, for numbers of 32 bits."""


def one_if_positive(*margins: Scalar) -> Scalar:
    """1 where all are positive, else NaN."""
    count: Scalar = 0.5 - len(margins)
    for margin in margins:
        count = count + sign(margin)
    return sqrt(sign(count))


def kept(values: tuple[Any, ...], counting: Counting | None) -> tuple[Any, ...]:
    """The values of the counted equations, out of a value for every loop equation; all where
    counting is None."""
    return values if counting is None else tuple(values[k] for k in counting.rows)


def _nearest(
    tree: Tree, factors: Factors, phi: Matrix, start: Vector, excess: Vector
) -> tuple[Vector, Vector, Vector]:
    """The x nearest to a start in the metric M with Φ_q x = Φ_q start - excess, the multipliers λ
    of the difference (M (start - x) = Φ_qᵀ λ), and the pivots of S."""
    columns = [substitute(tree, factors, row) for row in phi]
    multipliers, pivots = solved([[dot(row, x) for x in columns] for row in phi], excess)
    # one at a time from the start: near singular positions the sum of all is much larger than what
    # is left
    for multiplier, column in zip(multipliers, columns, strict=True):
        start = sub(start, scale(multiplier, column))
    return start, multipliers, pivots


def solved(S: list[list[Scalar]], right: Vector) -> tuple[Vector, Vector]:
    """x with S x = right for a symmetric positive definite S = L D Lᵀ, and D."""
    n = len(S)
    L: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    inverse: list[Scalar] = []
    pivots: list[Scalar] = []
    x = list(right)
    for k in range(n):
        scaled = [S[k][j] for j in range(k)]
        for j in range(k):
            for i in range(j):
                scaled[j] = scaled[j] - L[j][i] * scaled[i]
        pivot = S[k][k]
        for j in range(k):
            L[k][j] = scaled[j] * inverse[j]
            pivot = pivot - L[k][j] * scaled[j]
            x[k] = x[k] - L[k][j] * x[j]
        inverse.append(1.0 / pivot)
        pivots.append(pivot)
    for k in reversed(range(n)):
        x[k] = x[k] * inverse[k]
        for j in range(k + 1, n):
            x[k] = x[k] - L[j][k] * x[j]
    return tuple(x), tuple(pivots)


def loop_ends(tree: Tree, q: Vector) -> list[tuple[Pose, Pose]]:
    """The poses of each loop's frames in the world."""
    world = world_poses(tree, joint_poses(tree, q))
    return [_ends(tree, world, loop) for loop in tree.loops]


def _ends(tree: Tree, world: list[Pose], loop: TreeLoop) -> tuple[Pose, Pose]:
    """The poses of a loop's frames A and B in the world."""
    a, b = loop.frames
    return frame_pose(tree, world, a), frame_pose(tree, world, b)


def _rates(tree: Tree, world: list[Pose], pose: Pose, frame: str) -> Iterator[tuple[int, Column]]:
    """Pairs of the index of each rate that moves a frame and the motion of the frame's origin per
    unit of it."""
    for i, columns in frame_columns(tree, world, pose[1], frame).items():
        at = tree.bodies[i].coordinates
        for k, (angular, linear) in zip(at.v, columns, strict=True):
            yield k, (scale(at.ratio, angular), scale(at.ratio, linear))
