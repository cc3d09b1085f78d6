"""Loads of drives over duty cycles: what gears must transmit at each sample, before any motor and
gear is chosen, and what each kilogram of a drive adds to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.design.duty_cycle import DutyCycle
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.lazy import Keeps, kept
from freebody.model.model import Model
from freebody.motion.friction import friction_torque, motor_springs, without_laws


@dataclass(frozen=True)
class DriveJoint:
    """A joint that a motor and a gear can be chosen for: its column in q̇, and where on the robot
    their mass rides (a frame, and a point in it, m); frame None: on the ground."""

    name: str
    column: int
    turns: bool
    frame: str | None
    at: tuple[float, ...]

    @property
    def unit(self) -> str:
        """The unit of its torque or force."""
        return "N m" if self.turns else "N"


@dataclass(frozen=True, eq=False)
class CycleLoads(Keeps):
    """Loads at the samples of all cycles, one after another (T samples, C cycles).

    shares (C, T): of its cycle's time, for which each sample stands. periods (C,): s.
    transmitted (T, n): the torque of each joint behind its gear, with no rotor, friction of the
    motor's side or mass of a drive. friction (T, n): what that friction takes, at the joint.
    speed, acceleration (T, n). per_kg (n, T, n): what a kilogram of the drive of each joint (first
    index) adds to the torque of each (last).
    """

    joints: tuple[DriveJoint, ...]
    shares: Array
    periods: Array
    transmitted: Array
    friction: Array
    speed: Array
    acceleration: Array
    per_kg: Array

    def torque(self, k: int, masses: Array) -> Array:
        """The torque (T,) that joint k transmits, where the drives have masses (n,) kg."""
        heavy = np.flatnonzero(masses * self.burdens[:, k])
        if not len(heavy):
            return self.transmitted[:, k]
        return self.transmitted[:, k] + masses[heavy] @ self.per_kg[heavy, :, k]

    @property
    def burdens(self) -> Array:
        """(n, n) bool: whether the mass of a joint's drive (first index) loads a joint (last)."""
        return kept(self, "_burdens", self._burdens)

    def _burdens(self) -> Array:
        size = np.abs(self.per_kg).max(axis=1)
        largest = max(float(np.abs(self.transmitted).max()), float(size.max()), 1e-300)
        return size > _NOTHING * largest


_NOTHING = 1e-12
"""Of the largest torque: what a kilogram adds by rounding alone."""


def drive_joints(
    function: str,
    model: Model,
    joints: Sequence[str] | None,
    mounts: Mapping[str, str | None] | None,
) -> tuple[DriveJoint, ...]:
    """The joints to be driven, default all that something drives, with where their drives ride: on
    the link before the joint, at the joint, or at the origin of the frame that `mounts` names
    (None: on the ground)."""
    possible: dict[str, DriveJoint] = {}
    for k, (body, at) in enumerate(zip(model.bodies, model.coordinates, strict=True)):
        motion = body.kind.motion
        if body.joint.mimic or body.joint.passive or body.kind.nv != 1 or motion is None:
            continue
        parent = None if body.parent < 0 else model.bodies[body.parent].name
        point = tuple(map(float, model.tree.bodies[model.tree.body_of[k]].p))
        possible[body.joint.name] = DriveJoint(
            body.joint.name, at.v[0], motion.turns, parent, point
        )
    if not possible:
        raise FreebodyError(
            f"{function}: {model.name!r} has no driven joint of one coordinate to choose a motor "
            f"for."
        )
    names = tuple(possible) if joints is None else tuple(joints)
    for name in (*names, *(mounts or ())):
        if name not in possible:
            raise UnknownNameError("driven joint", name, model.name, possible)
    found = []
    for name in dict.fromkeys(names):
        joint = possible[name]
        if mounts and name in mounts:
            frame = mounts[name]
            if frame is not None and frame not in model.frame_names:
                raise UnknownNameError("frame", frame, model.name, model.frame_names)
            joint = DriveJoint(name, joint.column, joint.turns, frame, (0.0,) * model.dim)
        found.append(joint)
    return tuple(found)


def cycle_loads(
    model: Model, cycles: Sequence[DutyCycle], joints: Sequence[DriveJoint]
) -> CycleLoads:
    """The loads of a model's joints over duty cycles; the model's own rotors and losses of gears do
    not count."""
    bare = without_laws(model, lambda law: law.losses is not None).without("rotors")
    columns = [joint.column for joint in joints]
    parts: dict[str, list[Array]] = {}
    for cycle in cycles:
        for segment in cycle.segments:
            for name, value in _of_segment(bare, segment, joints, columns).items():
                parts.setdefault(name, []).append(value)
    counts = [sum(len(x.motion.t) + (x.dwell > 0.0) for x in cycle.segments) for cycle in cycles]
    seconds = np.concatenate(parts.pop("seconds"))
    shares, start = np.zeros((len(cycles), len(seconds))), 0
    for k, (cycle, count) in enumerate(zip(cycles, counts, strict=True)):
        shares[k, start : start + count] = seconds[start : start + count] / cycle.duration
        start += count
    per_kg = np.concatenate(parts.pop("per_kg"), axis=1)
    joined = {name: np.concatenate(value) for name, value in parts.items()}
    periods = np.array([cycle.duration for cycle in cycles])
    return CycleLoads(tuple(joints), shares, periods, per_kg=per_kg, **joined)


def _of_segment(
    bare: Model, segment: Any, joints: Sequence[DriveJoint], columns: list[int]
) -> dict[str, Array]:
    q, qd, qdd, wrenches, seconds = segment.states()
    loaded = segment.carried_by(bare)
    total = inverse_dynamics(loaded, q, qd, qdd, wrenches)
    own = motor_springs(loaded, q, qd) + friction_torque(loaded.without("struts"), q, qd)
    per_kg = np.zeros((len(joints), len(q), len(joints)))
    for k, joint in enumerate(joints):
        if joint.frame is not None:
            heavier = loaded.with_payload(
                1.0, com=joint.at, frame=joint.frame, name=f"drive of {joint.name}"
            )
            per_kg[k] = (inverse_dynamics(heavier, q, qd, qdd, wrenches) - total)[:, columns]
    return {
        "seconds": seconds,
        "transmitted": (total - own)[:, columns],
        "friction": own[:, columns],
        "speed": qd[:, columns],
        "acceleration": qdd[:, columns],
        "per_kg": per_kg,
    }


def order(loads: CycleLoads) -> list[int]:
    """The joints in an order in which each comes behind those whose drives it carries. Raises
    FreebodyError where drives carry each other, or a joint its own."""
    burdens = loads.burdens
    left, found = set(range(len(loads.joints))), list[int]()
    while left:
        ready = [k for k in sorted(left, reverse=True) if not any(burdens[j, k] for j in left)]
        if not ready:
            names = listed(repr(loads.joints[k].name) for k in sorted(left))
            raise FreebodyError(
                f"size: {names} carry the mass of each other's drives, or of their own, so none "
                f"can be chosen first; say with mounts={{joint: frame}} where they ride, None on "
                f"the ground."
            )
        found.append(ready[0])
        left.remove(ready[0])
    return found
