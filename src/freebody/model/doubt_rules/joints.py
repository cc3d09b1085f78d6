"""Rules on drives and limits of joints: placeholders, what no robot has, and what is not given."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freebody.errors import listed
from freebody.model.doubt_rules.aspects import EFFORTS, NAMES, RANGES, SPEEDS, DoubtedJoints
from freebody.model.drives import LAWS
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import parents_first
from freebody.model.usable_limits import UsableLimits, usable_limits
from freebody.spatial import Vector, add, of_dimension, times

if TYPE_CHECKING:
    from freebody.model.model import Model

_SEVERAL = 3
"""Joints with the same limits that tell a placeholder, and the masses that they move."""
_APART = 1.01
"""Ratio of masses that are not the same."""
_STRONGEST = {"N m": 200.0, "N": 10_000.0}
"""For each kilogram of the whole robot, its drives included: the effort limit of no joint."""
_ON_THE_GROUND = 10.0
"""Factor on that limit where the motor stands on the ground and is no part of the robot's mass."""
_DENSEST = 75.0
"""N m for each kilogram of the whole robot: all motors together that it carries have no more. Arms
of makers have 15 to 45, legged robots 20 to 30; motors on the ground are not part of its mass."""
_FASTEST = 340.0
"""m/s: the speed of no robot's end, which is that of sound."""


class _MotorLimits(NamedTuple):
    """Limits of one coordinate, and what its motor moves: mass, and how far that reaches (m)."""

    name: str
    slides: bool
    carried: bool
    """Whether the motor is part of the robot's mass, which that of its base is too; else it stands
    on the ground."""
    speed: float
    effort: float
    mass: float
    reach: float

    @property
    def most(self) -> str:
        """The effort limit in words."""
        return f"{self.effort:g} {'N' if self.slides else 'N m'}"

    @property
    def fastest(self) -> str:
        """The speed limit in words."""
        return f"{self.speed:g} {'m' if self.slides else 'rad'}/s"


def placeholders(model: Model, _: Sequence[str]) -> Iterator[DoubtedJoints]:
    """Limits that are placeholders: equal round numbers on joints that move different masses, or
    such as no robot has."""
    motors = _motors(model)
    alike = [*_alike(motors)]
    yield from alike
    said = {name for doubt in alike for name in doubt.joints}
    mass = abs(model.mass)
    strong = [d for d in motors if _is_strong(d, mass)] or [*_overloading(motors, mass)]
    fast = [d for d in motors if isfinite(d.speed) and d.speed * (d.slides or d.reach) > _FASTEST]
    yield from _beyond_belief("effort", [(x.name, x.most) for x in strong if x.name not in said])
    yield from _beyond_belief("speed", [(x.name, x.fastest) for x in fast if x.name not in said])


def _beyond_belief(what: str, found: Sequence[tuple[str, str]]) -> Iterator[DoubtedJoints]:
    """A doubt on limits that no robot has: names of joints with their limits in words."""
    if found:
        names, several = tuple(name for name, _ in found), len(found) > 1
        text = (
            f"no such robot has the {what} limit{'s' if several else ''} of "
            f"{listed(names, NAMES)}, {'such as ' if several else ''}{found[0][1]}."
        )
        yield DoubtedJoints(text, names)


def _motors(model: Model) -> list[_MotorLimits]:
    """The limits of all coordinates that a motor of their own moves."""
    given, moved = usable_limits(model).given, _moved(model)
    based = any(VALUES.quantity(part.inertia.mass) for part in model.base_inertias)
    return [
        _MotorLimits(
            body.joint.name,
            body.kind.slides,
            based or body.parent >= 0,
            float(given[2, at.v[0]]),
            float(given[3, at.v[0]]),
            *moves,
        )
        for body, at, moves in zip(model.bodies, model.coordinates, moved, strict=True)
        if body.joint.mimic is None and body.kind.nv == 1 and not body.joint.passive
    ]


def _alike(motors: Sequence[_MotorLimits]) -> Iterator[DoubtedJoints]:
    """Round limits that several joints share, though they move different masses."""
    groups: dict[tuple[str, str], list[_MotorLimits]] = {}
    for motor in motors:
        if _is_round(motor.speed) and _is_round(motor.effort):
            groups.setdefault((motor.most, motor.fastest), []).append(motor)
    for (most, fastest), group in groups.items():
        if _different(motor.mass for motor in group) >= _SEVERAL:
            names = tuple(motor.name for motor in group)
            text = (
                f"the limits of {listed(names, NAMES)} are placeholders, {most} and {fastest} of "
                f"each."
            )
            yield DoubtedJoints(text, names)


def _is_strong(drive: _MotorLimits, mass: float) -> bool:
    """Whether no joint of a robot of this mass (kg) has such an effort."""
    strongest = _STRONGEST["N" if drive.slides else "N m"] * mass
    strongest *= 1.0 if drive.carried else _ON_THE_GROUND
    return isfinite(drive.effort) and drive.effort > strongest > 0.0


def _overloading(drives: Sequence[_MotorLimits], mass: float) -> Iterator[_MotorLimits]:
    """Motors too strong for the robot of this mass (kg) that carries them: the strongest, and all
    that are as strong, until the others are not too strong together."""
    carried = [d for d in drives if d.carried and not d.slides and isfinite(d.effort)]
    total, least = sum(drive.effort for drive in carried), math.inf
    for drive in sorted(carried, key=lambda drive: -drive.effort):
        if total <= _DENSEST * mass or mass == 0.0:
            break
        total, least = total - drive.effort, drive.effort
    return (drive for drive in carried if drive.effort >= least)


def _is_round(x: float) -> bool:
    """Whether a number is positive and has a single digit that is not 0, as guesses have."""
    return isfinite(x) and x > 0.0 and float(f"{x:.0e}") == x


def _different(masses: Iterable[float]) -> int:
    """The number of masses, those that are almost the same counted once."""
    count, last = 0, 0.0
    for mass in sorted(masses):
        if mass > _APART * last:
            count, last = count + 1, mass
    return count


def _moved(model: Model) -> list[tuple[float, float]]:
    """For each joint the mass that it moves, and how far that reaches from it at most (m)."""
    space = of_dimension(model.dim)

    def far(placement: Placement, beyond: Vector = ()) -> float:
        R, p = placement.lower(space, VALUES)
        return math.hypot(*(add(p, times(R, beyond)) if beyond else p))

    count = len(model.bodies)
    masses, reaches = [0.0] * count, [0.0] * count
    for frame in model.frames:
        if frame.body >= 0:
            reaches[frame.body] = max(reaches[frame.body], far(frame.placement))
    for i, body in enumerate(model.bodies):
        for part in body.inertias:
            mass, com, _ = part.inertia.lower(VALUES)
            masses[i] += mass
            reaches[i] = max(reaches[i], far(part.placement, com) if mass else 0.0)
    for i in reversed(parents_first(model.bodies)):
        body = model.bodies[i]
        if body.parent >= 0:
            masses[body.parent] += masses[i]
            beyond = far(body.joint.placement) + reaches[i]
            reaches[body.parent] = max(reaches[body.parent], beyond)
    return list(zip(masses, reaches, strict=True))


def missing(model: Model, aspects: Sequence[str]) -> Iterator[str]:
    """Limits that the description does not give, and joints of which nothing tells what moves
    them."""
    allowed = usable_limits(model)
    found = _absent_limits(model, allowed, aspects)
    if allowed.apart and RANGES in aspects:
        found.append(f"a range that suits {listed(allowed.apart, NAMES)}")
    several = [b.joint.name for b in model.bodies if b.kind.nv > 1 and not b.joint.passive]
    if several and not model.loops and EFFORTS in aspects:
        have = "has no motor of its" if len(several) == 1 else "have no motors of their"
        found.append(f"what moves {listed(several, NAMES)}, which {have} own")
    if found:
        yield f"the description lacks {'; '.join(found)}."


def _absent_limits(model: Model, allowed: UsableLimits, aspects: Sequence[str]) -> list[str]:
    """The limits of driven joints that are not given, in words, those of the same joints
    together."""
    driven = [
        (body, at.v[0])
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None and body.kind.nv == 1 and not body.joint.passive
    ]
    ranged = [(body, k) for body, k in driven if body.kind.ranged]
    bounded = np.isfinite(allowed.lower) & np.isfinite(allowed.upper)
    absent: dict[tuple[str, ...], list[str]] = {}
    """All that is not given, by the names of joints."""
    for aspect, what, joints, given in (
        (EFFORTS, "an effort limit", driven, np.isfinite(allowed.effort)),
        (SPEEDS, "a speed limit", driven, np.isfinite(allowed.velocity)),
        (RANGES, "a position range", ranged, bounded),
    ):
        names = tuple(body.joint.name for body, k in joints if not given[k])
        if names and aspect in aspects:
            absent.setdefault(names, []).append(what)
    return [f"{listed(parts)} of {listed(names, NAMES)}" for names, parts in absent.items()]


def no_drive(model: Model, _: Sequence[str]) -> Iterator[str]:
    """Joints with a drive that no motor has."""
    wrong = [
        f"joint {body.joint.name!r}: {fault}"
        for body in model.bodies
        if (fault := body.joint.drive.fault())
    ]
    if wrong:
        more = f" ({len(wrong) - 1} more)" if len(wrong) > 1 else ""
        yield f"no motor has such a drive: {wrong[0]}{more}."


_ROTORS = tuple(law.strength for law in LAWS.values() if law.inertia is not None)


def no_rotor(model: Model, _: Sequence[str]) -> Iterator[str]:
    """Rotor inertias that are missing in joints whose drive is described otherwise; a textbook's
    have none."""
    described_joints, without = 0, []
    for body in model.bodies:
        limits, drive = body.joint.limits.meant, body.joint.drive
        described = isfinite(limits.effort) or isfinite(limits.velocity)
        if body.joint.passive or body.joint.mimic or body.kind.nv != 1 or not described:
            continue
        described_joints += 1
        if all(VALUES.quantity(getattr(drive, name)) == 0.0 for name in _ROTORS):
            without.append(body.joint.name)
    if without:
        of = "" if len(without) == described_joints else f" of {listed(without, NAMES)}"
        yield f"rotor inertia{of} is not given; its torque is left out."
