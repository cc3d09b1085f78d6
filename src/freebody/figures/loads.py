"""Every force and moment on each body at one instant, and what they add up to.

On body i act: the parent's reaction f_{i-1,i} with moment n_{i-1,i} (τ_i where a turn in the plane carries nothing but
its motor's torque), the reactions -f_{i,k} of its children, its weight m_i g and external wrenches. Their sum is m a_c,
and their moment about the centre of mass the rate of angular momentum there (4.12-4.15, 6.28, 6.29).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freebody.algorithms.rnea import Recursion, rnea
from freebody.arrays import Array
from freebody.figures.skeleton import BodyPlace, Skeleton, skeleton
from freebody.model.model import Model
from freebody.numerics.calls import Vector, Wrenches, vector
from freebody.numerics.dynamics import joint_wrenches
from freebody.numerics.kinematics import forward_kinematics


@dataclass(frozen=True)
class Load:
    """A force (dim,) and a moment on a body at a place, world axes; moment (3,), or (1,) in the plane."""

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


@dataclass(frozen=True)
class BodyLoads:
    """All that acts on one body, and its motion."""

    body: BodyPlace
    loads: tuple[Load, ...]
    inertial_force: Array
    """m a_c (dim,)."""
    inertial_moment: Array
    """Rate of the angular momentum about the centre of mass."""

    @property
    def force_residual(self) -> float:
        """|Σ F - m a_c| (N)."""
        return float(np.linalg.norm(sum(load.force for load in self.loads) - self.inertial_force))

    @property
    def moment_residual(self) -> float:
        """|Σ M - Ḣ| about the centre of mass (N m)."""
        total = sum(load.moment + moment(load.place - self.body.com, load.force) for load in self.loads)
        return float(np.linalg.norm(total - self.inertial_moment))


def moment(arm: Array, force: Array) -> Array:
    """arm × force: (3,), or (1,) in the plane."""
    if len(arm) == 2:
        return np.array([arm[0] * force[1] - arm[1] * force[0]])
    return np.cross(arm, force)


def body_loads(model: Model, q: Vector, qd: Vector = None, qdd: Vector = None, wrenches: Wrenches = None) -> tuple[BodyLoads, ...]:  # type: ignore[assignment]
    """The loads on every body; q (nq,); qd, qdd (nv,), default rest; wrenches as for `inverse_dynamics`."""
    position = vector("free_body_diagram", model, "q", q)
    still = np.zeros(model.nv)
    first = still if qd is None else vector("free_body_diagram", model, "qd", qd)
    second = still if qdd is None else vector("free_body_diagram", model, "qdd", qdd)
    pose = skeleton(model, position)
    reactions = np.asarray(joint_wrenches(model, position, first, second, wrenches))
    tree = model.tree
    recursion = rnea(tree, *(tuple(map(float, x)) for x in (position, first, second)), gravity="explicit")
    external = _external(model, position, wrenches)
    return tuple(_on_body(model, pose, body, reactions, recursion, external) for body in pose.bodies)


def _on_body(
    model: Model, pose: Skeleton, body: BodyPlace, reactions: Array, recursion: Recursion, external: list[tuple[int, Load]]
) -> BodyLoads:
    dim, n = model.dim, body.number
    before = "0" if body.parent < 0 else str(body.parent + 1)
    wrench = reactions[body.index]
    names = _moment_names(model, body, before)
    by = pose.bodies[body.parent].name if body.parent >= 0 else "its drives" if body.kind == "free" else "the ground"
    loads = [Load(f"f_{{{before},{n}}}", names[0], "reaction", by, body.origin, wrench[:dim], wrench[dim:])]
    for child in pose.bodies:
        if child.parent == body.index:
            w, (name, _) = reactions[child.index], _moment_names(model, child, str(n))
            loads.append(Load(f"−f_{{{n},{child.number}}}", f"−{name}", "counter", child.name, child.origin, -w[:dim], -w[dim:]))
    no_moment = np.zeros(len(wrench) - dim)
    if body.mass:
        loads.append(Load(f"m_{n} g", "", "weight", "gravity", body.com, body.mass * model.gravity, no_moment))
    loads += [load for on, load in external if on == body.index]
    force, turning = _rates(model, body, recursion)
    return BodyLoads(body, tuple(loads), force, turning)


def _moment_names(model: Model, body: BodyPlace, before: str) -> tuple[str, bool]:
    """Name of the moment by the parent, and whether it is the motor's torque alone."""
    drive = model.tree.bodies[model.tree.body_of[body.index]].drive
    alone = model.dim == 2 and body.kind in ("revolute", "continuous") and drive is None
    if alone and model.bodies[body.index].joint.mimic is None:
        return f"τ_{body.number}", True
    return (f"M_{body.number}" if model.dim == 2 else f"n_{{{before},{body.number}}}"), False


def _rates(model: Model, body: BodyPlace, recursion: Recursion) -> tuple[Array, Array]:
    """m a_c and the rate of angular momentum about the body's centre of mass, world axes."""
    at = model.tree.body_of[body.index]
    R, dim = body.rotation, model.dim
    force, turning = np.zeros(dim), np.zeros(1 if dim == 2 else 3)
    for mass, F, N in zip(model.tree.bodies[at].masses, recursion.F[at], recursion.N[at], strict=True):
        f = R @ np.asarray(F)
        force += f
        arm = body.origin + R @ np.asarray(mass.c) - body.com
        turning += moment(arm, f) + (np.asarray(N) if dim == 2 else R @ np.asarray(N))
    return force, turning


def _external(model: Model, q: Array, wrenches: Wrenches) -> list[tuple[int, Load]]:
    """(body, load) of each external wrench."""
    if wrenches is None:
        return []
    given = wrenches if isinstance(wrenches, Mapping) else {model.frame().name: wrenches}
    found = []
    for k, (frame, value) in enumerate(given.items()):
        w = np.asarray(value, dtype=float)
        place = np.asarray(forward_kinematics(model, q, frame))[: model.dim, -1]
        suffix = str(k + 1) if len(given) > 1 else "e"
        load = Load(f"f_{suffix}", f"n_{suffix}", "external", frame, place, w[: model.dim], w[model.dim :])
        found.append((model.frame(frame).body, load))
    return found
