"""Every force and moment on each body at one instant, and the residual of their balance.

On body i act: the parent's reaction, the opposite of what it does to its children, those of loops,
struts, its weight and external wrenches, all called as in the equations (`Naming`). Their sum is
m a_c, and their moment about the centre of mass the rate of angular momentum there (4.12-4.15,
6.28, 6.29).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from freebody.algorithms.rnea import Recursion, rnea
from freebody.any_chain.dynamics import joint_wrenches
from freebody.arrays import Array
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.naming import Naming
from freebody.figures.skeleton import BodyPlace, Skeleton, extent
from freebody.figures.text import label
from freebody.model.joints import JointKind
from freebody.model.model import Model
from freebody.trees.dynamics import strut_states
from freebody.trees.public_calls import FrameWrenchTable, wrenches_by_frame

NOISE = 1e-9
"""Share of the largest force or moment on the mechanism: components below are rounding, and 0 in
all drawings and tables."""


@dataclass(frozen=True)
class Load:
    """A force (dim,) and a moment on a body at a place, world axes; moment (3,), or (1,) in the
    plane."""

    name: str
    """The force's name in the notes' notation."""
    moment_name: str
    role: str
    """reaction (by the parent), counter (by a child), weight, or external (struts too)."""
    other: str
    """Name of what exerts the load."""
    place: Array
    force: Array
    moment: Array
    joint: int | None = None
    """Index among `model.reaction_names` of what it is a reaction of; None for weights, struts and
    external wrenches."""
    kind: JointKind | None = None
    """The kind of the joint that it is a reaction of."""


@dataclass(frozen=True)
class BodyLoads:
    """All forces and moments on one body, and its motion."""

    body: BodyPlace
    loads: tuple[Load, ...]
    mass_name: str
    """The name of the body's mass."""
    inertial_force: Array
    """Mass times acceleration, m a_c (dim,)."""
    force_residual: float
    """|Σ F - m a_c| (N), rounding included."""
    moment_residual: float
    """|Σ M - Ḣ| about the centre of mass (N m)."""


def moment(arm: Array, force: Array) -> Array:
    """The moment arm × force: (3,), or (1,) in the plane."""
    if len(arm) == 2:
        return np.array([arm[0] * force[1] - arm[1] * force[0]])
    return np.cross(arm, force)


def body_loads(
    names: Naming, pose: Skeleton, q: Array, qd: Array, qdd: Array, wrenches: FrameWrenchTable
) -> tuple[BodyLoads, ...]:
    """The loads on every body in a state: q (nq,); qd, qdd (nv,); wrenches as for
    `inverse_dynamics`."""
    model = names.model
    given = wrenches_by_frame("free_body_diagram", model, wrenches, single=True)
    reactions = np.asarray(joint_wrenches(model, q, qd, qdd, wrenches=given))
    first, second, third = (tuple(map(float, x)) for x in (q, qd, qdd))
    recursion = rnea(model.tree, first, second, third, gravity="explicit")
    joined, applied = _transmitted(names, pose, reactions), _external(names, pose, given)
    acting = [*joined, *_weights(names, pose), *_struts(model, pose, q, qd), *applied]
    found, cleared = [], _without_noise([load for _, load in acting], extent([pose]))
    for body in pose.bodies:
        at = [k for k, (on, _) in enumerate(acting) if on == body.index]
        force, spun = _rates(model, body, recursion)
        balance = _residuals(body, [acting[k][1] for k in at], force, spun)
        loads = tuple(_named(names, cleared[k]) for k in at)
        found.append(BodyLoads(body, loads, label(names.mass(body.number)), force, *balance))
    return tuple(found)


def _without_noise(loads: Sequence[Load], size: float) -> list[Load]:
    """The loads on all bodies of a mechanism of `size` metres, with values set to 0 that are only
    rounding beside the largest."""
    force = max((float(np.linalg.norm(load.force)) for load in loads), default=0.0)
    turning = max((float(np.linalg.norm(load.moment)) for load in loads), default=0.0)
    least = NOISE * max(force, turning / size)

    def cleared(load: Load) -> Load:
        seen, turns = abs(load.force) > least, abs(load.moment) > least * size
        return replace(
            load, force=np.where(seen, load.force, 0.0), moment=np.where(turns, load.moment, 0.0)
        )

    return list(map(cleared, loads))


def _named(names: Naming, load: Load) -> Load:
    """The load, with a name given to a moment at a pin without motor that is not 0: there a moment
    is missing for the state shown."""
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
    """The residuals of a body's force balance (N) and moment balance about its centre of mass (N
    m), given m a and the rate of angular momentum."""
    force = sum((load.force for load in loads), -force)
    arms = ((load, load.place - body.com) for load in loads)
    turning = sum((load.moment + moment(arm, load.force) for load, arm in arms), -turning)
    return float(np.linalg.norm(force)), float(np.linalg.norm(turning))


def _transmitted(names: Naming, pose: Skeleton, wrenches: Array) -> Iterator[tuple[int, Load]]:
    """Pairs (index of the body, load) of the wrenches transmitted by joints and loops: on the child
    or the body of the loop's second frame, and the opposite on the other body."""
    called, d = [*(body.name for body in pose.bodies), "the ground"], pose.dim

    def pair(
        force: Expression, moment: Expression, bodies: tuple[int, int], places: tuple[Array, Array],
        kind: JointKind | None = None,
    ) -> Iterator[tuple[int, Load]]:  # fmt: skip
        k, (first, second), (counter, place) = next(rows), bodies, places
        by = "what moves it" if first < 0 and kind and kind.frees(d) else called[first]
        on, w = called[second], wrenches[k]
        own, other = label(ex.neg(force)), label(ex.neg(moment))
        yield (
            second,
            Load(label(force), label(moment), "reaction", by, place, w[:d], w[d:], k, kind),
        )
        yield first, Load(own, other, "counter", on, counter, -w[:d], -w[d:], k, kind)

    rows = count()
    for body in pose.bodies:
        n, joined = body.number, (body.parent, body.index)
        force, moment = names.force(body.parent + 1, n), names.joint_moment(n)
        yield from pair(force, moment, joined, (body.origin, body.origin), body.kind)
    # a loop's wrench acts at the origin of the second frame; that of a rod, which pulls along
    # itself, at each end
    for k, loop in enumerate(pose.loops):
        ends, places = (loop.parent, loop.index), (loop.origin, loop.origin)
        if loop.rod:
            places = loop.carrier, loop.origin
        yield from pair(names.loop_force(k), names.loop_moment(k), ends, places)


def _weights(names: Naming, pose: Skeleton) -> Iterator[tuple[int, Load]]:
    """(index of the body, load) of each weight."""
    nothing = np.zeros(1 if names.planar else 3)
    for body in pose.bodies:
        if body.mass:
            name, force = f"{label(names.mass(body.number))} g", body.mass * names.model.gravity
            yield body.index, Load(name, "", "weight", "gravity", body.com, force, nothing)


def _struts(model: Model, pose: Skeleton, q: Array, qd: Array) -> Iterator[tuple[int, Load]]:
    """(index of the body, load) of the force of each strut at each of its ends."""
    if not pose.struts:
        return
    nothing = np.zeros(1 if model.dim == 2 else 3)
    tensions = strut_states(model, q, qd)[2]
    for k, (strut, tension) in enumerate(zip(pose.struts, tensions, strict=True), 1):
        name = f"f_{{s{k}}}" if len(pose.struts) > 1 else "f_s"
        way = strut.ends[1] - strut.ends[0]
        pull = tension / np.linalg.norm(way) * way
        for body, place, force in zip(strut.bodies, strut.ends, (pull, -pull), strict=True):
            yield body, Load(name, "", "external", strut.name, place, force, nothing)


def _external(names: Naming, pose: Skeleton, given: dict[str, Array]) -> Iterator[tuple[int, Load]]:
    """(index of the body, load) of each external wrench."""
    d = pose.dim
    for k, (frame, w) in enumerate(given.items(), 1):
        low = f"_{k}" if len(given) > 1 else ""
        load = Load(f"f{low}", f"n{low}", "external", frame, pose.frames[frame], w[:d], w[d:])
        yield names.model.frame(frame).body, load


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
