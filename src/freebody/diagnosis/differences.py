"""Differences of two robots that are laid onto each other: one record for each aspect."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from freebody.diagnosis.alignment import Alignment, MatchedJoint
from freebody.diagnosis.bodies_in_space import BodyTree, cross, pose_in_space
from freebody.diagnosis.facts import norm
from freebody.errors import listed
from freebody.model.description import Drive, Loop
from freebody.model.drives import LAWS, DriveLaw
from freebody.model.placement import ArrayPose, composed
from freebody.model.quantity_reader import VALUES
from freebody.model.struts import Strut
from freebody.outputs.display import InWords
from freebody.outputs.number_text import compared

_LIMITS = {"lower": "lower limit", "upper": "upper limit", "velocity": "speed limit",
           "effort": "effort limit"}  # fmt: skip


@dataclass(frozen=True, repr=False)
class RobotDifference(InWords):
    """One difference between two robots: its aspect (a name of `ASPECTS`), the joint or body by its
    names in both, the difference in words, and its size: m, rad, kg, kg m², or relative."""

    aspect: str
    place: tuple[str, str]
    text: str
    size: float

    def __str__(self) -> str:
        a, b = self.place
        name = f"{a!r}" if a == b or not b else f"{b!r}" if not a else f"{a!r} ({b!r})"
        return f"{self.aspect}: {name}: {self.text}"

    def _title(self) -> str:
        return str(self)


@dataclass(frozen=True)
class Aspect:
    """Something that robots may differ in: its name; the sorts of numbers that a robot gives at
    all; and what finds the differences in those that both give."""

    name: str
    find: Callable[[Alignment, frozenset[str]], Iterator[RobotDifference]]
    given: Callable[[BodyTree], frozenset[str]] = lambda robot: frozenset()


def _structure(found: Alignment, _: frozenset[str]) -> Iterator[RobotDifference]:
    for which, part in found.alone:
        other = (found.b, found.a)[which].model.name
        place = (part.joint, "") if which == 0 else ("", part.joint)
        own = "" if part.body.joint.kind[0] not in "aeiou" else "n"
        text = f"a{own} {part.body.joint.kind} joint that {other!r} has no counterpart of"
        yield RobotDifference(
            "joints", place, text, 1.0 + (found.a, found.b)[which].count[part.index]
        )
    for pair in found.pairs:
        kinds = pair.a.sort, pair.b.sort
        if kinds[0] != kinds[1]:
            yield _of_joint("joints", pair, f"is {kinds[0]} and {kinds[1]}", math.inf)
        own = [tuple(map(VALUES.quantity, x.body.joint.numbers)) for x in (pair.a, pair.b)]
        if kinds[0] == kinds[1] and own[0] != own[1]:
            off = norm(np.subtract(*own))
            if off > found.tolerances.length:
                yield _of_joint("joints", pair, f"its pitch differs by {off:.3g} m/rad", off)
        shafts = [x.shaft.joint.name if x.shaft else "" for x in (pair.a, pair.b)]
        if bool(shafts[0]) != bool(shafts[1]):
            who, shaft = ((found.a, found.b)[not shafts[0]].model.name, shafts[0] or shafts[1])
            text = f"has a shaft that twists, {shaft!r}, in {who!r} alone"
            yield _of_joint("joints", pair, text, math.inf)
    for pair in (*found.pairs, *_shafts(found)):
        passive = pair.a.body.joint.passive, pair.b.body.joint.passive
        if passive[0] != passive[1]:
            who = (found.a, found.b)[passive[1]].model.name
            yield _of_joint("joints", pair, f"is passive in {who!r} alone", math.inf)
    yield from _mimics(found)
    yield from _loops(found)


def _loops(found: Alignment) -> Iterator[RobotDifference]:
    """Loops that hold no such points of the same bodies in the other robot."""
    own = [(loop, _ends(found.a, loop, {})) for loop in found.a.model.loops]
    others = [(loop, _ends(found.b, loop, _stand_for(found))) for loop in found.b.model.loops]
    for loop, ends in own:
        same = [k for k, (_, other) in enumerate(others) if _coincide(ends, other, found)]
        if same:
            del others[same[0]]
        else:
            yield _lone("joints", found, 0, loop)
    for loop, _ in others:
        yield _lone("joints", found, 1, loop)


def _lone(aspect: str, found: Alignment, which: int, part: Loop | Strut) -> RobotDifference:
    """The difference that a loop or strut of one robot has no counterpart in the other."""
    other = (found.b, found.a)[which].model.name
    place = (part.name, "") if which == 0 else ("", part.name)
    what = "loop" if isinstance(part, Loop) else "strut"
    return RobotDifference(
        aspect, place, f"a {what} that {other!r} has no counterpart of", math.inf
    )


def _stand_for(found: Alignment) -> dict[int, tuple[int, ArrayPose]]:
    """The body, and the pose in it, that stands for each body of the second robot."""
    bodies = {pair.b.index: (pair.a.index, pair.pose) for pair in found.pairs}
    return {-1: (-1, found.base), **bodies}


class _HeldEnd(NamedTuple):
    """One end of a loop or strut: the part's kind and distance, and the body, point and axis where
    the end is attached."""

    kind: str
    distance: float
    body: int
    point: np.ndarray
    axis: np.ndarray


def _ends(
    robot: BodyTree, part: Loop | Strut, bodies: Mapping[int, tuple[int, ArrayPose]]
) -> list[_HeldEnd]:
    """Both ends of a loop or strut, on the bodies and in the poses that stand for its own."""
    kind, along, distance = "strut", (), 0.0
    if isinstance(part, Loop):
        in_plane = robot.model.dim == 2 and part.kind == "revolute"
        kind, along = part.kind, (0.0, 0.0, 1.0) if in_plane else part.axis
        distance = 0.0 if part.distance is None else float(VALUES.quantity(part.distance))
    found = []
    for name in part.frames:
        frame = next(x for x in robot.model.frames if x.name == name)
        body, pose = bodies.get(frame.body, (frame.body, (np.eye(3), np.zeros(3))))
        R, p = composed(pose, pose_in_space(frame.placement, robot.model.dim))
        axis = np.array([*along, 0.0, 0.0, 0.0][:3])
        found.append(_HeldEnd(kind, distance, body, p, R @ axis))
    return found


def _coincide(ends: list[_HeldEnd], others: list[_HeldEnd], found: Alignment) -> bool:
    """Whether two loops or struts hold the same parts together, taken from either end; points may
    differ along an axis."""
    return any(
        all(
            x.kind == y.kind
            and x.body == y.body
            and abs(x.distance - y.distance) <= found.tolerances.length
            and norm(cross(x.axis, y.axis)) <= found.tolerances.share
            and norm(y.point - x.point - x.axis * (x.axis @ (y.point - x.point)))
            <= 3.0 * found.tolerances.length
            for x, y in zip(ends, way, strict=True)
        )
        for way in (others, others[::-1])
    )


def _mimics(found: Alignment) -> Iterator[RobotDifference]:
    by_name = {pair.b.joint: pair for pair in found.pairs}
    for pair in found.pairs:
        one, two = pair.a.body.joint.mimic, pair.b.body.joint.mimic
        if one is None and two is None:
            continue
        if one is None or two is None:
            who = (found.b if one is None else found.a).model.name
            yield _of_joint("joints", pair, f"follows another joint in {who!r} alone", math.inf)
            continue
        leader = by_name.get(two.joint)
        if leader is None or leader.a.joint != one.joint:
            text = f"follows {one.joint!r} and {two.joint!r}"
            yield _of_joint("joints", pair, text, math.inf)
            continue
        # theirs as a polynomial of our leader's position, which is flip · theirs + offset
        seen = two.seen_at(leader.flip, -leader.flip * leader.offset)
        theirs = [pair.flip * x for x in (seen.offset, *seen.coefficients)]
        theirs[0] += pair.offset
        ours = (one.offset, *one.coefficients)
        for k, (x, y) in enumerate(zip_longest(ours, theirs, fillvalue=0.0)):
            what = ("offset", "ratio")[k] if k < 2 else f"coefficient {k}"
            if abs(x - y) > found.tolerances.share * max(1.0, abs(x)):
                a = "an" if what[0] == "o" else "a"
                text = f"follows by {a} {what} of {' and '.join(compared(x, y, digits=6))}"
                yield _of_joint("joints", pair, text, abs(x - y))


def _geometry(found: Alignment, _: frozenset[str]) -> Iterator[RobotDifference]:
    for pair in found.pairs:
        gap = pair.gap
        if pair.a.sort != pair.b.sort or found.tolerances.same(gap):
            continue
        on = pair.a.body.parent
        above = f"on {found.a.parts[on].body.name!r}" if on >= 0 else "on the base"
        parts = []
        if gap.distance > found.tolerances.length:
            parts.append(f"{1e3 * gap.distance:.4g} mm")
        if gap.angle > found.tolerances.share:
            parts.append(f"{gap.angle:.4g} rad ({math.degrees(gap.angle):.3g}°)")
        text = f"its axis is elsewhere {above}, by {listed(parts)}"
        yield _of_joint("geometry", pair, text, max(gap.distance, gap.angle))
    model, other = found.a.model, found.b.model
    own, theirs = VALUES.quantity(model.gravity_size), VALUES.quantity(other.gravity_size)
    if abs(own - theirs) > 1e3 * found.tolerances.share:
        text = f"gravity is {own:.6g} and {theirs:.6g} m/s²"
        yield RobotDifference("geometry", ("base", "base"), text, abs(own - theirs))


def _of_joint(aspect: str, pair: MatchedJoint, text: str, size: float) -> RobotDifference:
    return RobotDifference(aspect, (pair.a.joint, pair.b.joint), text, size)


# ------------------------------------------------------------ masses
def _masses_given(robot: BodyTree) -> frozenset[str]:
    return frozenset(["masses"] if any(part.weight for part in robot.parts) else [])


def _masses(found: Alignment, compared: frozenset[str]) -> Iterator[RobotDifference]:
    share = found.tolerances.share
    # writers of formats that lack massless bodies make up traces of mass
    least = share**2 * max(x.model.mass for x in (found.a, found.b))
    for pair in found.pairs if compared else ():
        place = pair.a.body.name, pair.b.body.name
        one, two = pair.a.weight, pair.b.weight
        if one is None or two is None:
            has = one or two
            if has is not None and has.mass > least:
                who = (found.a if two is None else found.b).model.name
                text = f"has a mass in {who!r} alone, {has.mass:.6g} kg"
                yield RobotDifference("masses", place, text, has.mass)
            continue
        if abs(one.mass - two.mass) > share * max(abs(one.mass), abs(two.mass)):
            text = f"its mass is {one.mass:.6g} and {two.mass:.6g} kg"
            yield RobotDifference("masses", place, text, abs(one.mass - two.mass))
        R, p = pair.pose
        normal = _normal(pair)
        centre = R @ two.com + p
        apart = centre - one.com
        off = norm(apart if normal is None else apart - normal * (normal @ apart))
        if off > 3.0 * found.tolerances.length and one.mass:
            text = f"its centre of mass is {1e3 * off:.4g} mm away, at {_shown(one.com)} and "
            yield RobotDifference("masses", place, text + f"{_shown(centre)} m", off)
        tensor = R @ two.tensor @ R.T
        own, other = (
            x if normal is None else np.array([[normal @ x @ normal]]) for x in (one.tensor, tensor)
        )
        size = max(norm(own.ravel()), norm(other.ravel()))
        change = norm((own - other).ravel())
        # no difference is less than that of a radius of gyration within the tolerance
        small = max(abs(one.mass), abs(two.mass)) * found.tolerances.length**2
        if change > 10.0 * share * size and change > small:
            entries = _entries(own, other)
            text = (
                f"its inertia differs by {change:.3g} kg m² ({change / size:.2g} of it): {entries}"
            )
            yield RobotDifference("masses", place, text, change)


def _normal(pair: MatchedJoint) -> np.ndarray | None:
    """The normal of the plane in which one of two bodies moves, in the first's axes; a planar robot
    says nothing along it. None where both are in space."""
    z = np.array([0.0, 0.0, 1.0])
    if pair.a.dim == 2:
        return z
    return pair.pose[0] @ z if pair.b.dim == 2 else None


def _shown(vector: np.ndarray) -> str:
    return f"[{', '.join(f'{x:.6g}' for x in vector)}]"


def _entries(one: np.ndarray, two: np.ndarray) -> str:
    """The entry in which two inertia tensors differ most, with both values, as text."""
    if one.shape == (1, 1):
        return f"{one[0, 0]:.6g} and {two[0, 0]:.6g}"
    i, j = np.unravel_index(int(np.abs(one - two).argmax()), one.shape)
    return f"I{'xyz'[i]}{'xyz'[j]} is {one[i, j]:.6g} and {two[i, j]:.6g}"


# ------------------------------------------------------------ limits and drives
def _limits_given(robot: BodyTree) -> frozenset[str]:
    return frozenset(
        f"{what}s"
        for key, what in _LIMITS.items()
        if any(math.isfinite(getattr(x.body.joint.limits.meant, key)) for x in robot.parts)
    )


def _limits(found: Alignment, compared: frozenset[str]) -> Iterator[RobotDifference]:
    for pair in found.pairs:
        one, two = pair.a.body.joint.limits.meant, pair.b.body.joint.limits.meant
        lower, upper = sorted(pair.flip * x + pair.offset for x in (two.lower, two.upper))
        mapped = {"lower": lower, "upper": upper, "velocity": two.velocity, "effort": two.effort}
        for key, what in _LIMITS.items():
            x, y = getattr(one, key), mapped[key]
            if (
                f"{what}s" not in compared
                or x == y
                or abs(x - y) <= _rounding(found, key) * max(1.0, abs(x))
            ):
                continue
            shown = [f"{z:.6g}" if math.isfinite(z) else "not given" for z in (x, y)]
            text = f"its {what} is {shown[0]} and {shown[1]}"
            yield _of_joint("limits", pair, text, abs(x - y))


def _rounding(found: Alignment, key: str) -> float:
    """The relative difference of two limits that counts as rounding; positions are often written
    with few digits."""
    return found.tolerances.share * (10.0 if key in ("lower", "upper") else 1.0)


def _drives_given(robot: BodyTree) -> frozenset[str]:
    return frozenset(law.term for law in LAWS.values() if any(_strengths(robot, law)))


def _strengths(robot: BodyTree, law: DriveLaw) -> list[float]:
    bodies = (body for part in robot.parts for body in (part.body, part.shaft) if body)
    drives = (body.joint.drive for body in bodies)
    return [float(VALUES.quantity(getattr(drive, law.strength))) for drive in drives]


def _drives(found: Alignment, compared: frozenset[str]) -> Iterator[RobotDifference]:
    for pair in (*found.pairs, *_shafts(found)):
        for law in LAWS.values():
            if law.term in compared and law.inertia is not None:
                yield from _rotors(found, pair)
            elif law.term in compared and law.losses is not None:
                yield from _losses(found, pair, law)
            elif law.term in compared:
                yield from _numbers(found, pair, law)


def _shafts(found: Alignment) -> Iterator[MatchedJoint]:
    """The shafts of flexible joints in both robots, as pairs; they count from where they are
    straight."""
    for pair in found.pairs:
        if pair.a.shaft and pair.b.shaft:
            one, two = (replace(x, body=x.shaft, shaft=None) for x in (pair.a, pair.b))
            yield replace(pair, a=one, b=two, offset=0.0)


def _numbers(found: Alignment, pair: MatchedJoint, law: DriveLaw) -> Iterator[RobotDifference]:
    one, two = (
        tuple([float(VALUES.quantity(getattr(x.body.joint.drive, n.name))) for n in law.numbers])
        for x in (pair.a, pair.b)
    )
    if one[0] == two[0] == 0.0:
        return
    one = law.counted_otherwise(one, 1.0, 0.0)
    two = law.counted_otherwise(two, pair.flip, pair.offset)
    for number, x, y in zip(law.numbers, one, two, strict=True):
        apart = abs(math.remainder(x - y, number.period))
        scale = max(abs(x), abs(y), 1e-9) if math.isinf(number.period) else number.period
        if apart > found.tolerances.share * scale:
            text = f"its {number.words} is {x:.6g} and {y:.6g}"
            yield _of_joint("friction", pair, text, apart)


def _losses(found: Alignment, pair: MatchedJoint, law: DriveLaw) -> Iterator[RobotDifference]:
    """The parts that joints lose of the torque transmitted; an efficiency of 1 loses none."""
    one, two = (_parts_lost(part.body.joint.drive, law) for part in (pair.a, pair.b))
    for who, x, y in zip(("the motor", "the joint"), one, two, strict=True):
        if abs(x - y) > found.tolerances.share:
            text = (
                f"its {law.term} takes {x:.6g} and {y:.6g} of the torque that it transmits while "
                f"{who} drives"
            )
            yield _of_joint("friction", pair, text, abs(x - y))


def _parts_lost(drive: Drive, law: DriveLaw) -> tuple[float, float]:
    assert law.losses is not None
    numbers = tuple(float(VALUES.quantity(getattr(drive, x.name))) for x in law.numbers)
    if not getattr(drive, law.strength):
        return 0.0, 0.0
    driving, driven = law.losses(numbers)
    return float(driving), float(driven)


def _rotors(found: Alignment, pair: MatchedJoint) -> Iterator[RobotDifference]:
    """Rotors as the joint feels them: one behind a gear is another one without."""
    x, y = (
        float(VALUES.quantity(drive.rotor) * VALUES.quantity(drive.gear) ** 2)
        for drive in (pair.a.body.joint.drive, pair.b.body.joint.drive)
    )
    if abs(x - y) > found.tolerances.share * max(abs(x), abs(y)):
        text = f"its rotor's inertia is {x:.6g} and {y:.6g} behind the gear"
        yield _of_joint("friction", pair, text, abs(x - y))


# ------------------------------------------------------------ struts
def _struts(found: Alignment, _: frozenset[str]) -> Iterator[RobotDifference]:
    """Differences of struts: those without counterpart between the same points, and differing
    numbers of the others."""
    own = [(strut, _ends(found.a, strut, {})) for strut in found.a.model.struts]
    others = [(strut, _ends(found.b, strut, _stand_for(found))) for strut in found.b.model.struts]
    for strut, ends in own:
        same = [
            (list(_of_strut(found, strut, other)), k)
            for k, (other, held) in enumerate(others)
            if _coincide(ends, held, found)
        ]
        if not same:
            yield _lone("struts", found, 0, strut)
            continue
        differences, k = min(same, key=lambda one: len(one[0]))  # some may stand side by side
        del others[k]
        yield from differences
    for lone in others:
        yield _lone("struts", found, 1, lone[0])


def _of_strut(found: Alignment, one: Strut, two: Strut) -> Iterator[RobotDifference]:
    """The differences of two struts between the same points. Where both have springs, a preload is
    as good as another rest length, and the length without force is compared."""
    (k, rest, damping, preload), (other_k, other_rest, other_damping, other_preload) = (
        tuple(map(float, map(VALUES.quantity, strut.numbers))) for strut in (one, two)
    )
    if k and other_k:
        force = (
            "length without force",
            "m",
            rest - preload / k,
            other_rest - other_preload / other_k,
        )
    else:
        force = ("preload", "N", preload, other_preload)
    for what, unit, x, y in (
        ("stiffness", "N/m", k, other_k),
        force,
        ("damping", "N s/m", damping, other_damping),
    ):
        least = found.tolerances.length if unit == "m" else 0.0
        if abs(x - y) > max(found.tolerances.share * max(abs(x), abs(y)), least):
            text = f"its {what} is {x:.6g} and {y:.6g} {unit}"
            yield RobotDifference("struts", (one.name, two.name), text, abs(x - y))


ASPECTS: tuple[Aspect, ...] = (
    Aspect("joints", _structure),
    Aspect("geometry", _geometry),
    Aspect("masses", _masses, _masses_given),
    Aspect("limits", _limits, _limits_given),
    Aspect("friction", _drives, _drives_given),
    Aspect("struts", _struts),
)
"""All aspects, in the order in which a difference counts as the first."""
