"""The equations of a free body: the forces ΣF = m a and moments ΣM = Ḣ about its joint's origin
that must act so that it moves as it does. Notes 3.1, 3.2, 6.1, 6.2.

Notes 3.1, 3.2, 6.1, 6.2. It takes the bodies' poses with their first and second time derivatives,
whatever these come from; the rate of angular momentum is R̈ P Rᵀ, with P = ½ tr(I) 1 - I the second
moments: its antisymmetric part is Σ r × r̈ dm. Nothing of the Newton-Euler recursion enters, so
this checks reactions by other means than those they were found by.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import NamedTuple

from freebody.algorithms.kinematics import Pose, ancestors, frame_pose
from freebody.algorithms.struts import strut_state
from freebody.elementary import Scalar, absolute, maximum
from freebody.model.tree import Mass, Tree
from freebody.spatial import (
    Matrix,
    Vector,
    add,
    identity,
    neg,
    product,
    scale,
    sub,
    times,
    transposed,
)


class Moving(NamedTuple):
    """A body's pose in the world, with its first and second rates."""

    pose: Pose
    rate: Pose
    second: Pose


class BodyResiduals(NamedTuple):
    """Residuals of every body of the model, about its joint's origin, world axes."""

    force: Matrix
    """Residual of Newton's equation, ΣF - m a."""
    moment: Matrix
    """Residual of Euler's equation, ΣM - Ḣ."""
    largest: Vector
    """The largest entry of a force, and of a moment, that went in."""


def balance(
    tree: Tree,
    moving: Sequence[Moving],
    wrenches: Sequence[Vector],
    external: Sequence[tuple[str, Vector]],
) -> BodyResiduals:
    """The residual forces and moments that reactions and external wrenches (world axes) leave in
    the equations of motion of every body.

    moving: of every body of the tree. wrenches: of joints and loops, as `closed_wrenches` gives
    them; external: (frame, wrench) of each load.
    """
    space, world = tree.space, [body.pose for body in moving]
    acting = _Acting(space.moment, {i: moving[i].pose[1] for i in tree.body_of})
    for i in tree.body_of:
        force, moment = _needed(tree, i, moving[i])
        acting.add(i, neg(force), neg(moment), acting.origins[i])
    links = [(i, _carrier(tree, i), acting.origins[i]) for i in tree.body_of]
    for loop in tree.loops:
        first, second = (tree.frames[name][0] for name in loop.frames)
        links.append((second, first, frame_pose(tree, world, loop.frames[1])[1]))
    for (on, by, place), wrench in zip(links, wrenches, strict=True):
        force, moment = wrench[: space.dim], wrench[space.dim :]
        acting.add(on, force, moment, place)
        acting.add(by, neg(force), neg(moment), place)
    for strut in tree.struts:
        (a, a_rate), (b, b_rate) = (_end(tree, moving, name) for name in strut.frames)
        pull = strut_state(strut, sub(b, a), sub(b_rate, a_rate)).pull
        for name, place, force in zip(strut.frames, (a, b), (pull, neg(pull)), strict=True):
            acting.add(tree.frames[name][0], force, space.zero_angular, place)
    for name, wrench in external:
        place = frame_pose(tree, world, name)[1]
        acting.add(tree.frames[name][0], wrench[: space.dim], wrench[space.dim :], place)
    sums = [(add(*acting.forces[i]), add(*acting.moments[i])) for i in tree.body_of]
    largest = (_largest(acting.forces), _largest(acting.moments))
    return BodyResiduals(tuple(f for f, _ in sums), tuple(n for _, n in sums), largest)


@dataclass
class _Acting:
    """The loads on each body of the model: forces, and moments about its joint's origin."""

    moment: Callable[[Vector, Vector], Vector]
    origins: dict[int, Vector]
    forces: dict[int, list[Vector]] = field(default_factory=dict)
    moments: dict[int, list[Vector]] = field(default_factory=dict)

    def add(self, body: int, force: Vector, moment: Vector, place: Vector) -> None:
        """Add a force at a place, and a moment, to the loads on a body; loads on the ground (-1)
        are ignored."""
        if body >= 0:
            turned = self.moment(sub(place, self.origins[body]), force)
            self.forces.setdefault(body, []).append(force)
            self.moments.setdefault(body, []).extend((moment, turned))


def _end(tree: Tree, moving: Sequence[Moving], frame: str) -> tuple[Vector, Vector]:
    """Place and velocity of a frame's origin."""
    body, _, p = tree.frames[frame]
    if body < 0:
        return p, tree.space.zero
    (R, o), (R_rate, o_rate) = moving[body].pose, moving[body].rate
    return add(o, times(R, p)), add(o_rate, times(R_rate, p))


def _needed(tree: Tree, i: int, body: Moving) -> tuple[Vector, Vector]:
    """The force m (a - g) and the moment Ḣ - c × m g about the joint's origin that the masses of a
    body need."""
    space = tree.space
    force, moment = space.zero, space.zero_angular
    (R, _), (R_second, p_second) = body.pose, body.second
    for mass in tree.bodies[i].masses:
        felt = sub(add(p_second, times(R_second, mass.c)), tree.gravity)
        f = scale(mass.m, felt)
        spun = _axial(product(product(R_second, _second_moments(tree, mass)), transposed(R)))
        if mass.h is not None:
            f = add(f, times(R_second, mass.h))
            spun = add(spun, space.moment(times(R, mass.h), felt))
        force, moment = add(force, f), add(moment, space.moment(times(R, mass.c), f), spun)
    return force, moment


def _second_moments(tree: Tree, mass: Mass) -> Matrix:
    """P = Σ r rᵀ dm about the mass's point c; in the plane half of the inertia along each axis."""
    if tree.space.dim == 2:
        return tuple(scale(0.5 * mass.inertia, row) for row in identity(2))
    inertia = tree.space.inertia_matrix(mass.inertia)
    half = 0.5 * (inertia[0][0] + inertia[1][1] + inertia[2][2])
    return tuple(sub(scale(half, e), row) for e, row in zip(identity(3), inertia, strict=True))


def _axial(A: Matrix) -> Vector:
    """Vector Σ r × a of a matrix A = Σ a rᵀ."""
    turns = [(2, 1), (0, 2), (1, 0)] if len(A) == 3 else [(1, 0)]
    return tuple(A[i][j] - A[j][i] for i, j in turns)


def _carrier(tree: Tree, i: int) -> int:
    """The body of the model that carries a body: a joint may be a chain of several here; -1 the
    ground."""
    return next((k for k in ancestors(tree, i)[1:] if k in tree.body_of), -1)


def _largest(vectors: dict[int, list[Vector]]) -> Scalar:
    entries = [absolute(x) for several in vectors.values() for vector in several for x in vector]
    return reduce(maximum, entries, 0.0)
