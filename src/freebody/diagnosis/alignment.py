"""Which joint of one robot is which of another, and how the frames of their bodies lie in each
other.

Frames say nothing about a robot: the base may stand elsewhere, a joint's zero may be anywhere and
its axis point either way, a link may have its frame at either end. What remains is how the axes of
a body lie to one another and to its mass. So the bodies are laid onto each other from the base
outwards: that a joint's axes coincide leaves its zero, an angle or a distance, and that is chosen
such that most of what the body carries coincides as well. Where an axis does not, the difference
is noted and the body is laid on anew, so that it is told once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.diagnosis.bodies_in_space import (
    Part,
    Robot,
    Weight,
    cross,
    inverse,
    rotation_between,
    turned,
)
from freebody.diagnosis.facts import Pose, composed, norm

_HERE: Pose = np.eye(3), np.zeros(3)
_NO_OFFSET = 1e-9


class Gap(NamedTuple):
    """By how much an axis is off another one: m between them, rad, and 1 or -1 for the way that it
    points."""

    distance: float
    angle: float
    flip: float


@dataclass(frozen=True)
class Pair:
    """A joint with its body in both robots. pose: the second's frame in the first's. The first's
    joint is at flip times the second's position plus offset."""

    a: Part
    b: Part
    pose: Pose
    gap: Gap
    offset: float = 0.0

    @property
    def flip(self) -> float:
        """1, or -1 where the joints count in opposite directions."""
        return self.gap.flip


@dataclass(frozen=True)
class Tolerances:
    """Differences that are none: m, rad or relative."""

    length: float
    share: float

    def same(self, gap: Gap) -> bool:
        """Whether an axis is another one."""
        return gap.distance <= self.length and gap.angle <= self.share


@dataclass(frozen=True)
class Alignment:
    """Two robots laid onto each other: base is the second's base in the first's; alone are joints
    that the other robot lacks, with the robot's place, 0 or 1."""

    a: Robot
    b: Robot
    base: Pose
    pairs: tuple[Pair, ...]
    alone: tuple[tuple[int, Part], ...]
    tolerances: Tolerances

    @property
    def misfit(self) -> tuple[int, int]:
        """The number of joints that do not coincide, and of centres of mass."""
        wrong = sum(not self.tolerances.same(pair.gap) for pair in self.pairs)
        heavy = [pair for pair in self.pairs if pair.a.weight and pair.b.weight]
        off = sum(not _same_centre(x.a, x.b, x.pose, self.tolerances) for x in heavy)
        return wrong + len(self.alone), off


def align(a: Robot, b: Robot, tolerances: Tolerances) -> Alignment:
    """The best of all ways in which the base may stand."""
    best, most = None, -1
    for base in _bases(a, b):
        coincide = sum(
            tolerances.same(_gap(one, two, base)[1]) for one, two in _matched(a, b, (-1, -1), base)
        )
        if coincide < most:
            continue
        most = coincide
        found = Alignment(a, b, base, *_walked(a, b, base, tolerances), tolerances)
        if best is None or found.misfit < best.misfit:
            best = found
        if best.misfit == (0, 0):
            break
    assert best is not None
    return best


def _bases(a: Robot, b: Robot) -> Iterator[Pose]:
    """Ways in which the second robot's base may stand in the first's."""
    yield _HERE
    lines, others = a.main_chain(), b.main_chain()
    if not lines or not others:
        return
    for signs in product((1.0, -1.0), repeat=2):
        own = _axes([line.direction for line in lines], (1.0, 1.0))
        other = _axes([line.direction for line in others], signs)
        R = own @ other.T
        yield R, a.foot() - R @ b.foot()
    for one, two in product(a.children[-1][1:2], b.children[-1]):  # several joints on the base
        first, second = a.children[-1][0].line(_HERE), one.line(_HERE)
        for root in b.children[-1]:
            line, next_line = root.line(_HERE), two.line(_HERE)
            for signs in product((1.0, -1.0), repeat=2) if root is not two else ():
                across, aside = second.point - first.point, next_line.point - line.point
                own = _axes([first.direction, second.direction, across], (1.0, 1.0, 1.0))
                other = _axes([line.direction, next_line.direction, aside], (*signs, 1.0))
                R = own @ other.T
                yield R, first.point - R @ line.point


def _axes(directions: Sequence[Array], signs: Sequence[float]) -> Array:
    """Axes along the first direction and across to the first that is not parallel."""
    z = signs[0] * directions[0]
    for k, direction in enumerate(directions[1:], 1):
        x = cross(z, direction * (signs[k] if k < len(signs) else signs[-1]))
        if norm(x) > 1e-6 * norm(direction):
            x = x / norm(x)
            break
    else:
        x = cross(z, np.eye(3)[np.argmin(np.abs(z))])
        x = x / norm(x)
    return np.column_stack([x, cross(z, x), z])


# ------------------------------------------------------------ from the base outwards
def _walked(
    a: Robot, b: Robot, base: Pose, tolerances: Tolerances
) -> tuple[tuple[Pair, ...], tuple[tuple[int, Part], ...]]:
    pairs: list[Pair] = []
    alone: list[tuple[int, Part]] = []
    waiting = [(-1, -1, base)]
    while waiting:
        i, j, pose = waiting.pop()
        matched = _matched(a, b, (i, j), pose)
        for k, robot, at in ((0, a, i), (1, b, j)):
            known = {pair[k].index for pair in matched}
            alone += [(k, part) for part in robot.children[at] if part.index not in known]
        laid = [_laid(a, b, one, two, pose, tolerances) for one, two in matched]
        pairs += laid
        waiting += [(x.a.index, x.b.index, x.pose) for x in reversed(laid)]
    return tuple(pairs), tuple(alone)


def _matched(a: Robot, b: Robot, at: tuple[int, int], pose: Pose) -> list[tuple[Part, Part]]:
    """The joints on two bodies that stand for each other: of equal names, else the nearest of
    equal kinds with as much beyond."""
    own, others = a.children[at[0]], list(b.children[at[1]])
    if {x.joint for x in own} == {x.joint for x in others} or len(own) == len(others) == 1:
        by_name = {x.joint: x for x in others}
        return [(x, by_name.get(x.joint, others[0])) for x in own]
    found = []
    for one in own:
        alike = [x for x in others if x.sort == one.sort and b.count[x.index] == a.count[one.index]]
        alike = alike or [x for x in others if x.joint == one.joint]
        if alike:
            nearest = min(alike, key=lambda x: sum(_gap(one, x, pose)[1][:2]))
            found.append((one, nearest))
            others.remove(nearest)
    return found


def _gap(one: Part, two: Part, pose: Pose) -> tuple[Pose, Gap]:
    """The second's joint frame in the first's, and by how much its axis is off."""
    R, p = composed(inverse(one.pose), composed(pose, two.pose))
    if one.axis is None or two.axis is None:
        return (R, p), Gap(norm(p), 0.0, 1.0)
    other = R @ two.axis
    flip = -1.0 if one.axis @ other < 0.0 else 1.0
    angle = float(np.arctan2(norm(cross(one.axis, other)), abs(one.axis @ other)))
    aside = norm(p - one.axis * (one.axis @ p))
    return (R, p), Gap(aside if one.turns and two.turns else 0.0, angle, flip)


def _laid(a: Robot, b: Robot, one: Part, two: Part, pose: Pose, tolerances: Tolerances) -> Pair:
    """A pair of joints with the pose of its bodies in each other."""
    (R, p), gap = _gap(one, two, pose)
    if one.axis is None or two.axis is None:
        free = one.body.kind.frees(one.dim) and two.body.kind.frees(two.dim)
        return Pair(one, two, _HERE if free else (R, p), Gap(0.0, 0.0, 1.0) if free else gap)
    if not tolerances.same(gap):
        R = rotation_between(gap.flip * (R @ two.axis), one.axis) @ R
        p = one.axis * (one.axis @ p)
    best, least = 0.0, None
    for offset in (0.0, *_offsets(a, b, one, two, (R, p))):
        moved = composed(_moved(one, -offset), (R, p))
        alike, turned_round = _alike(a, b, one, two, moved, tolerances)
        score = (-alike, abs(offset) > _NO_OFFSET, turned_round)
        if least is None or score < least:
            best, least = offset, score
    return Pair(one, two, composed(_moved(one, -best), (R, p)), gap, best)


def _moved(part: Part, position: float) -> Pose:
    """A body in its joint's frame at a position."""
    assert part.axis is not None
    if part.turns:
        return turned(part.axis, position), np.zeros(3)
    return np.eye(3), position * part.axis


def _offsets(a: Robot, b: Robot, one: Part, two: Part, pose: Pose) -> Iterator[float]:
    """Offsets of a joint's zero at which something that the body carries coincides."""
    axis = one.axis
    assert axis is not None
    for own, other in product(a.children[one.index], b.children[two.index]):
        if own.sort != other.sort:
            continue
        mine, line = own.line(_HERE), other.line(pose)
        for flip in (1.0, -1.0):
            if not one.turns:
                across = cross(axis, mine.direction)
                off = cross(line.point - mine.point, mine.direction)
                if own.turns and norm(across) > 1e-6:
                    yield float(off @ across / (across @ across))
                continue
            yield from _turn(axis, mine.direction, flip * line.direction)
            if own.turns:
                yield from _turn(
                    axis,
                    cross(mine.point, mine.direction),
                    flip * cross(line.point, line.direction),
                )
    if one.weight and two.weight:
        yield from _offsets_by_weight(one, one.weight, two.weight, pose)


def _turn(axis: Array, v: Array, w: Array) -> Iterator[float]:
    """The angle about an axis from one vector to another, if they are not along it."""
    v, w = (x - axis * (axis @ x) for x in (v, w))
    if min(norm(v), norm(w)) > 1e-6:
        yield float(np.arctan2(axis @ cross(v, w), v @ w))


def _offsets_by_weight(one: Part, own: Weight, other: Weight, pose: Pose) -> Iterator[float]:
    R, p = pose
    axis = one.axis
    assert axis is not None
    centre = R @ other.com + p
    if not one.turns:
        yield float(axis @ (centre - own.com))
        return
    yield from _turn(axis, own.com, centre)
    x = cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    x = x / norm(x)
    frame = np.column_stack([x, cross(axis, x)])
    angles = []
    for tensor in (own.tensor, R @ other.tensor @ R.T):
        flat = frame.T @ tensor @ frame
        angles.append(0.5 * np.arctan2(2.0 * flat[0, 1], flat[0, 0] - flat[1, 1]))
    for half_turns in (0.0, 1.0, -1.0):
        yield float(angles[1] - angles[0] + half_turns * np.pi)


def _alike(
    a: Robot, b: Robot, one: Part, two: Part, pose: Pose, tolerances: Tolerances
) -> tuple[int, int]:
    """How much of what two bodies carry coincides: joints, centre of mass, tensor; and how many of
    the joints point the other way."""
    gaps = [
        _gap(own, other, pose)[1] for own, other in _matched(a, b, (one.index, two.index), pose)
    ]
    alike = 4 * sum(map(tolerances.same, gaps))
    if one.weight is not None and two.weight is not None:
        tensor = pose[0] @ two.weight.tensor @ pose[0].T - one.weight.tensor
        size = max(norm(one.weight.tensor), norm(two.weight.tensor))
        alike += 2 * _same_centre(one, two, pose, tolerances)
        alike += norm(tensor) <= 10.0 * tolerances.share * size
    return alike, sum(gap.flip < 0.0 for gap in gaps)


def _same_centre(one: Part, two: Part, pose: Pose, tolerances: Tolerances) -> bool:
    assert one.weight is not None
    assert two.weight is not None
    centre = pose[0] @ two.weight.com + pose[1]
    return norm(centre - one.weight.com) <= 3.0 * tolerances.length
