"""Every force and moment on each body at one instant, and what they add up to.

On body i act: the parent's reaction, the opposite of what it does to its children, those of loops,
its weight and external wrenches, all called as in the equations (`Naming`). Their sum is m a_c, and
their moment about the centre of mass the rate of angular momentum there (4.12-4.15, 6.28, 6.29).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.rnea import Recursion, rnea
from freebody.arrays import Array
from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.expression import Expression
from freebody.derivations.naming import Naming
from freebody.figures.skeleton import BodyPlace, Skeleton, extent, skeleton
from freebody.figures.text import label
from freebody.model.joints import JointKind
from freebody.model.model import Model
from freebody.trees.dynamics import joint_wrenches
from freebody.trees.public_calls import Vector, Wrenches, single_vector, wrenches_by_frame

NOISE = 1e-9
"""Of the largest force or moment on the mechanism: components below are rounding, and 0 in all
drawings and tables."""


@dataclass(frozen=True)
class Load:
    """A force (dim,) and a moment on a body at a place, world axes; moment (3,), or (1,) in the
    plane."""

    name: str
    """The force's name in the notes' notation."""
    moment_name: str
    role: str
    """reaction (by the parent), counter (by a child), weight, or external."""
    other: str
    """Who exerts it."""
    place: Array
    force: Array
    moment: Array
    joint: int | None = None
    """Index among `model.reaction_names` of what it is a reaction of; None for weights and external
    wrenches."""
    kind: JointKind | None = None
    """Of the joint that it is a reaction of."""


@dataclass(frozen=True)
class BodyLoads:
    """All that acts on one body, and its motion."""

    body: BodyPlace
    loads: tuple[Load, ...]
    mass_name: str
    """What the body's mass is called."""
    inertial_force: Array
    """m a_c (dim,)."""
    inertial_moment: Array
    """Rate of the angular momentum about the centre of mass."""
    force_residual: float
    """|Σ F - m a_c| (N), rounding included."""
    moment_residual: float
    """|Σ M - Ḣ| about the centre of mass (N m)."""


def moment(arm: Array, force: Array) -> Array:
    """arm × force: (3,), or (1,) in the plane."""
    if len(arm) == 2:
        return np.array([arm[0] * force[1] - arm[1] * force[0]])
    return np.cross(arm, force)


def body_loads(
    model: Model,
    q: Vector,
    qd: Vector | None = None,
    qdd: Vector | None = None,
    wrenches: Wrenches = None,
) -> tuple[BodyLoads, ...]:
    """The loads on every body; q (nq,); qd, qdd (nv,), default rest; wrenches as for
    `inverse_dynamics`."""
    still = np.zeros(model.nv)
    given = {"q": q, "qd": still if qd is None else qd, "qdd": still if qdd is None else qdd}
    caller = "free_body_diagram"
    state = [single_vector(caller, model, name, value) for name, value in given.items()]
    pose = skeleton(model, state[0])
    given = wrenches_by_frame(caller, model, wrenches, single=True)
    names, reactions = Naming(model), np.asarray(joint_wrenches(model, *state, wrenches=given))
    first, second, third = (tuple(map(float, x)) for x in state)
    recursion = rnea(model.tree, first, second, third, gravity="explicit")
    acting = {body.index: _reactions(names, pose, body, reactions) for body in pose.bodies}
    for body in pose.bodies:
        if body.mass:
            acting[body.index].append(_weight(names, body))
    for on, load in _external(model, pose, given):
        acting.setdefault(on, []).append(load)
    found = []
    cleared = _without_noise([acting[body.index] for body in pose.bodies], extent([pose]))
    for body, shown in zip(pose.bodies, cleared, strict=True):
        rates = _rates(model, body, recursion)
        balance = _residuals(body, acting[body.index], *rates)
        loads = tuple(_named(names, load) for load in shown)
        found.append(BodyLoads(body, loads, label(names.mass(body.number)), *rates, *balance))
    return tuple(found)


def _without_noise(acting: Sequence[Sequence[Load]], size: float) -> list[list[Load]]:
    """The loads on each body of a mechanism of `size` metres, with 0 for what is only rounding
    beside the largest."""
    loads = [load for loads in acting for load in loads]
    force = max((float(np.linalg.norm(load.force)) for load in loads), default=0.0)
    turning = max((float(np.linalg.norm(load.moment)) for load in loads), default=0.0)
    least = NOISE * max(force, turning / size)

    def cleared(load: Load) -> Load:
        return replace(
            load,
            force=np.where(abs(load.force) > least, load.force, 0.0),
            moment=np.where(abs(load.moment) > least * size, load.moment, 0.0),
        )

    return [list(map(cleared, loads)) for loads in acting]


def _named(names: Naming, load: Load) -> Load:
    """A pin without motor has no moment, but where it could not hold still (or move so) one is
    missing: it is named."""
    joint = load.joint
    if load.moment_name or not any(load.moment) or joint is None:
        return load
    if joint >= len(names.model.bodies):
        return load
    moment = names.moment(names.parent(joint + 1), joint + 1)
    return replace(load, moment_name=label(ex.neg(moment) if load.role == "counter" else moment))


def _residuals(
    body: BodyPlace, loads: Sequence[Load], force: Array, turning: Array
) -> tuple[float, float]:
    """What is left of force and moment when the body's motion is taken off."""
    force = sum((load.force for load in loads), -force)
    arms = ((load, load.place - body.com) for load in loads)
    turning = sum((load.moment + moment(arm, load.force) for load, arm in arms), -turning)
    return float(np.linalg.norm(force)), float(np.linalg.norm(turning))


def _reactions(names: Naming, pose: Skeleton, body: BodyPlace, wrenches: Array) -> list[Load]:
    """By the parent, the opposite of what each child receives, and by loops."""
    called = [*(other.name for other in pose.bodies), "the ground"]
    found = []

    def add(
        k: int,
        force: Expression,
        moment: Expression,
        role: str,
        by: int,
        at: Array,
        kind: JointKind | None = None,
    ) -> None:
        if role == "counter":
            force, moment = ex.neg(force), ex.neg(moment)
        w, d = (-1.0 if role == "counter" else 1.0) * wrenches[k], pose.dim
        by_name = "what moves it" if by < 0 and body.kind.frees(d) else called[by]
        found.append(Load(label(force), label(moment), role, by_name, at, w[:d], w[d:], k, kind))

    for other in pose.bodies:
        n = other.number
        pair = names.force(other.parent + 1, n), names.joint_moment(n)
        if other is body:
            add(other.index, *pair, "reaction", body.parent, body.origin, other.kind)
        elif other.parent == body.index:
            add(other.index, *pair, "counter", other.index, other.origin, other.kind)
    # a loop's wrench acts at the origin of the second frame; that of a rod, which pulls along
    # itself, at each end
    for k, loop in enumerate(pose.loops):
        index, (first, second) = len(pose.bodies) + k, loop.bodies
        pair = names.loop_force(k), names.loop_moment(k)
        if second == body.index:
            add(index, *pair, "reaction", first, loop.origin)
        if first == body.index:
            add(index, *pair, "counter", second, loop.carrier if loop.rod else loop.origin)
    return found


def _weight(names: Naming, body: BodyPlace) -> Load:
    nothing = np.zeros(1 if names.planar else 3)
    name = f"{label(names.mass(body.number))} g"
    return Load(name, "", "weight", "gravity", body.com, body.mass * names.model.gravity, nothing)


def _rates(model: Model, body: BodyPlace, recursion: Recursion) -> tuple[Array, Array]:
    """m a_c and the rate of angular momentum about the body's centre of mass, world axes."""
    at = model.tree.body_of[body.index]
    R, dim = body.rotation, model.dim
    force, turning = np.zeros(dim), np.zeros(1 if dim == 2 else 3)
    masses = model.tree.bodies[at].masses
    for mass, F, N in zip(masses, recursion.F[at], recursion.N[at], strict=True):
        f = R @ np.asarray(F)
        force += f
        arm = body.origin + R @ np.asarray(mass.c) - body.com
        turning += moment(arm, f) + (np.asarray(N) if dim == 2 else R @ np.asarray(N))
    return force, turning


def _external(model: Model, pose: Skeleton, given: dict[str, Array]) -> list[tuple[int, Load]]:
    """(body, load) of each external wrench."""
    found = []
    for k, (frame, w) in enumerate(given.items(), 1):
        low = f"_{k}" if len(given) > 1 else ""
        force, moment = w[: model.dim], w[model.dim :]
        load = Load(f"f{low}", f"n{low}", "external", frame, pose.frames[frame], force, moment)
        found.append((model.frame(frame).body, load))
    return found
