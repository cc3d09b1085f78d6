"""Loads of drives over duty cycles: what gears must transmit at each sample, before any motor and
gear is chosen, and what each kilogram of a drive adds to it; and the postures at which gravity
loads each joint most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics, static_torque
from freebody.arrays import Array
from freebody.by_value import key
from freebody.design.duty_cycle import DutyCycle, Segment
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.lazy import Keeps, kept
from freebody.model.model import Model
from freebody.model.shafts import untwisted
from freebody.motion.ranges import position_columns, ranges
from freebody.motion.smooth_friction import friction_torque, motor_springs, without_laws
from freebody.trees import dynamics
from freebody.trees.positions import integrate, random_state

_SAMPLES = 4096
_ROUNDS, _TRIES = 24, 128


def heaviest_postures(model: Model) -> Array:
    """For each coordinate of an open chain the posture (nv, nq), within the limits, of the largest
    gravity torque found.

    4096 random ones (the same every time); the best of each coordinate is then improved by random
    steps of shrinking size. Shafts of flexible joints are untwisted, and carry what their joints
    do.
    """
    rigid = untwisted(model)
    if rigid is not None:
        whole, found = rigid.at(heaviest_postures(rigid.model)), np.empty((model.nv, model.nq))
        found[rigid.rates] = whole
        for _, at, _, to in rigid.twists:
            found[at] = whole[to]
        return found
    q, _, _ = random_state(model, seed=0, batch=_SAMPLES)
    load = np.abs(dynamics.gravity_torque(model, q))
    return _improved(model, q[np.argmax(load, axis=0)])


def _improved(model: Model, poses: Array) -> Array:
    """Poses (nv, nq), each moved towards a larger gravity torque of its own coordinate."""
    rng = np.random.default_rng(0)
    allowed = ranges(model)
    each = np.arange(model.nv)
    for k in range(_ROUNDS):
        step = 0.5 * 0.75**k * np.minimum(allowed.width, np.pi)
        steps = rng.normal(size=(model.nv, _TRIES, model.nv)) * step
        steps[:, 0] = 0.0
        tried = _clipped(model, integrate(model, np.repeat(poses[:, None], _TRIES, axis=1), steps))
        load = np.abs(dynamics.gravity_torque(model, tried)[each, :, each])
        poses = tried[each, np.argmax(load, axis=1)]
    return poses


def _clipped(model: Model, q: Array) -> Array:
    """q brought within the limits."""
    allowed = ranges(model)
    iq, iv = position_columns(model)
    q = q.copy()
    q[..., iq] = np.clip(q[..., iq], allowed.lower[iv], allowed.upper[iv])
    return q


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
    def load(self) -> str:
        """The name of its drive among the loads of a model."""
        return f"drive of {self.name}"


@dataclass(frozen=True, eq=False)
class CycleLoads(Keeps):
    """Loads at the samples of all cycles, one after another (T samples, C cycles).

    shares (C, T): of its cycle's time, for which each sample stands. spans: the samples of each
    cycle. periods (C,): s.
    transmitted (T, n): the torque of each joint behind its gear, with no rotor, friction of the
    motor's side or mass of a drive. friction (T, n): what that friction takes, at the joint.
    speed, acceleration (T, n). per_kg (n, n, T): what a kilogram of the drive of each joint (second
    index) adds to the torque of each (first).
    """

    joints: tuple[DriveJoint, ...]
    shares: Array
    spans: tuple[slice, ...]
    periods: Array
    transmitted: Array
    friction: Array
    speed: Array
    acceleration: Array
    per_kg: Array

    def torque(self, k: int, masses: Array) -> Array:
        """The torque (T,) that joint k transmits, where the drives have masses (n,) kg."""
        found = self.transmitted[:, k]
        for j in np.flatnonzero(masses * self.burdens[:, k]):
            found = found + masses[j] * self.per_kg[k, j]
        return found

    @property
    def burdens(self) -> Array:
        """(n, n) bool: whether the mass of a joint's drive (first index) loads a joint (last)."""
        return kept(self, "_burdens", self._burdens)

    def _burdens(self) -> Array:
        size = np.abs(self.per_kg).max(axis=2).T
        largest = max(float(np.abs(self.transmitted).max()), float(size.max()), 1e-300)
        return size > _NOTHING * largest


_NOTHING = 1e-12
"""Share of the largest torque that a kilogram may add by rounding alone."""


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
    names = (joints,) if isinstance(joints, str) else tuple(possible if joints is None else joints)
    if not names:
        raise FreebodyError(f"{function}: there is no joint to choose a drive for; name some.")
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
    """The loads of a model's joints over duty cycles; rotors and losses of gears that
    they have do not count."""
    bare = without_drives(model, joints)
    models: dict[Any, _Loaded] = {}
    parts: dict[str, list[Array]] = {}
    for cycle in cycles:
        for segment in cycle.segments:
            carried = key(segment.payload)
            if carried not in models:
                models[carried] = _Loaded.of(segment.carried_by(bare), joints)
            for name, value in models[carried].loads(segment, joints).items():
                parts.setdefault(name, []).append(value)
    counts = [sum(len(x.motion.t) + (x.dwell > 0.0) for x in cycle.segments) for cycle in cycles]
    seconds = np.concatenate(parts.pop("seconds"))
    ends = np.cumsum(counts)
    spans = tuple(slice(int(end - n), int(end)) for end, n in zip(ends, counts, strict=True))
    shares = np.zeros((len(cycles), len(seconds)))
    for k, (cycle, span) in enumerate(zip(cycles, spans, strict=True)):
        shares[k, span] = seconds[span] / cycle.duration
    per_kg = np.concatenate(parts.pop("per_kg"), axis=2)
    joined = {name: np.concatenate(value) for name, value in parts.items()}
    periods = np.array([cycle.duration for cycle in cycles])
    return CycleLoads(tuple(joints), shares, spans, periods, per_kg=per_kg, **joined)


def without_drives(model: Model, joints: Sequence[DriveJoint]) -> Model:
    """The model without losses of gears, and without rotors in some joints."""
    found = without_laws(model, lambda law: law.losses is not None)
    for joint in joints:
        found = found.with_drive(joint.name, rotor=0.0)
    return found


@dataclass(frozen=True, eq=False)
class _Loaded:
    """A model with a payload, the same without struts, whose dampers are no friction of drives, and
    for each joint with a kilogram more where its drive rides."""

    model: Model
    own: Model
    heavier: tuple[Model | None, ...]

    @staticmethod
    def of(model: Model, joints: Sequence[DriveJoint]) -> _Loaded:
        return _Loaded(
            model,
            model.without("struts") if model.struts else model,
            tuple(
                None
                if x.frame is None
                else model.with_payload(1.0, com=x.at, frame=x.frame, name=x.load)
                for x in joints
            ),
        )

    def loads(self, segment: Segment, joints: Sequence[DriveJoint]) -> dict[str, Array]:
        """The arrays of `CycleLoads` for one segment."""
        q, qd, qdd, wrenches, seconds = segment.states()
        columns = [joint.column for joint in joints]
        total = inverse_dynamics(self.model, q, qd, qdd, wrenches)
        friction = motor_springs(self.model, q, qd) + friction_torque(self.own, q, qd)
        per_kg = np.zeros((len(joints), len(joints), len(q)))
        for j, heavier in enumerate(self.heavier):
            if heavier is not None:
                more = inverse_dynamics(heavier, q, qd, qdd, wrenches) - total
                per_kg[:, j] = more[:, columns].T
        return {
            "seconds": seconds,
            "transmitted": (total - friction)[:, columns],
            "friction": friction[:, columns],
            "speed": qd[:, columns],
            "acceleration": qdd[:, columns],
            "per_kg": per_kg,
        }

    def at_rest(self, q: Array, joints: Sequence[DriveJoint]) -> tuple[Array, Array]:
        """The arrays of `RestLoads` at postures q (P, nq)."""
        columns = [joint.column for joint in joints]
        static = static_torque(self.model, q)
        per_kg = np.zeros((len(joints), len(joints), len(q)))
        for j, heavier in enumerate(self.heavier):
            if heavier is not None:
                per_kg[:, j] = (static_torque(heavier, q) - static)[:, columns].T
        return static[:, columns], per_kg


@dataclass(frozen=True, eq=False)
class RestLoads:
    """Torques that hold a robot still at some postures (P of them), with each payload of its duty
    cycles: static (P, n), and what a kilogram of the drive of each joint adds, per_kg (n, n, P) as
    in `CycleLoads`."""

    static: Array
    per_kg: Array

    def holding(self, k: int, masses: Array) -> float:
        """The largest torque that holds joint k, where the drives have masses (n,) kg."""
        return float(np.abs(self.static[:, k] + masses @ self.per_kg[k]).max())

    def least_holding(self, k: int, least: Array, most: Array) -> float:
        """The torque that holding joint k takes at least, with drives of masses between two
        (n,)."""
        at, added = (
            self.static[:, k] + least @ self.per_kg[k],
            (most - least)[:, None] * self.per_kg[k],
        )
        low = at + np.minimum(added, 0.0).sum(axis=0)
        high = at + np.maximum(added, 0.0).sum(axis=0)
        return float(np.abs(np.clip(0.0, low, high)).max())


_POSTURES = 200
"""Postures of a motion, evenly taken, at which a robot may have to be held."""


def rest_loads(
    model: Model, cycles: Sequence[DutyCycle], joints: Sequence[DriveJoint]
) -> RestLoads:
    """The torques that hold a robot at postures of its motions and, in open chains, at those within
    its limits where gravity loads each joint most; process forces do not count."""
    bare = without_drives(model, joints)
    postures: dict[Any, tuple[_Loaded, list[Array]]] = {}
    for segment in (segment for cycle in cycles for segment in cycle.segments):
        carried = key(segment.payload)
        if carried not in postures:
            loaded = segment.carried_by(bare)
            worst = [] if model.loops else [heaviest_postures(loaded)]
            postures[carried] = _Loaded.of(loaded, joints), worst
        at = np.linspace(0, len(segment.motion.t) - 1, _POSTURES).astype(int)
        postures[carried][1].append(segment.motion.q[np.unique(at)])
    parts = [loaded.at_rest(np.concatenate(q), joints) for loaded, q in postures.values()]
    return RestLoads(
        np.concatenate([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts], axis=2),
    )


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
