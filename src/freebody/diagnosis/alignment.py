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
from dataclasses import dataclass, replace
from itertools import islice, product
from math import isfinite
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.diagnosis.bodies_in_space import (
    BodyTree,
    Part,
    Weight,
    cross,
    inverse,
    rotation_between,
    turned,
)
from freebody.diagnosis.facts import ArrayPose, composed, norm

_HERE: ArrayPose = np.eye(3), np.zeros(3)
_NO_OFFSET = 1e-9
_FOLLOWED = 8
"""Ways of laying bodies onto each other that are followed at a time."""
_WAYS = 4
"""Ways of one joint that are."""
_MATCHINGS = 720
"""Ways of matching joints on a body that are tried."""


class Gap(NamedTuple):
    """The difference between two joint axes: their distance (m), the angle between them (rad), and
    1 or -1 where they point in opposite directions."""

    distance: float
    angle: float
    flip: float


@dataclass(frozen=True)
class MatchedJoint:
    """A joint with its body in both robots; pose: the second body's frame in the first's. The first
    joint's position is flip times the second's, plus offset."""

    a: Part
    b: Part
    pose: ArrayPose
    gap: Gap
    offset: float = 0.0

    @property
    def flip(self) -> float:
        """The factor between the positions of both joints: 1, or -1 where they count in opposite
        directions."""
        return self.gap.flip


@dataclass(frozen=True)
class Tolerances:
    """The differences between two robots that count as none: lengths in m, angles in rad, others
    relative."""

    length: float
    share: float

    def same(self, gap: Gap) -> bool:
        """Whether two axes coincide within the tolerances."""
        return gap.distance <= self.length and gap.angle <= self.share


@dataclass(frozen=True)
class Alignment:
    """Two robots laid onto each other: base is the second robot's base in the first's axes, alone
    the joints without counterpart, each with its robot's index (0 or 1)."""

    a: BodyTree
    b: BodyTree
    base: ArrayPose
    pairs: tuple[MatchedJoint, ...]
    alone: tuple[tuple[int, Part], ...]
    tolerances: Tolerances
    misfit: Misfit


class Misfit(NamedTuple):
    """How much of two robots does not coincide, the gravest first: the number of axes, of masses,
    of ends of ranges and of names that differ, then of zeros and of directions of joints."""

    axes: int = 0
    masses: int = 0
    ranges: int = 0
    names: int = 0
    zeros: int = 0
    flips: int = 0

    def plus(self, *others: Misfit) -> Misfit:
        """The sum of several misfits."""
        return Misfit(*map(sum, zip(self, *others, strict=True)))


class _Partial(NamedTuple):
    """Two robots of which some bodies are laid onto each other, and the pairs whose joints come
    next, with their poses."""

    misfit: Misfit
    pairs: tuple[MatchedJoint, ...]
    alone: tuple[tuple[int, Part], ...]
    waiting: tuple[tuple[int, int, ArrayPose], ...]


def align(a: BodyTree, b: BodyTree, tolerances: Tolerances) -> Alignment:
    """The best of all ways in which the base may stand."""
    best, most = None, -1
    for base in _bases(a, b):
        coincide = max(
            sum(tolerances.same(_gap(one, two, base)[1]) for one, two in matched)
            for matched in _matchings(a, b, (-1, -1), base, tolerances)
        )
        if coincide < most:
            continue
        most = coincide
        found = _walked(a, b, base, tolerances)
        laid = Alignment(a, b, base, found.pairs, found.alone, tolerances, found.misfit)
        if best is None or laid.misfit[:3] < best.misfit[:3]:
            best = laid
        if not any(best.misfit[:3]):
            break
    assert best is not None
    return _with_first_zero(best)


def _with_first_zero(found: Alignment) -> Alignment:
    """The alignment with the zero of a single joint on the base settled, which cannot be told from
    the base's turn about the joint's axis: chosen so that the ranges are equal, else as the base
    stands, or with equal zeros."""
    roots = [pair for pair in found.pairs if pair.a.body.parent < 0]
    if len(roots) != 1 or roots[0].a.axis is None:
        return found
    first = roots[0]
    offsets = sorted(_offsets_by_limits(first.a, first.b, first.flip))
    if len(offsets) == 2 and offsets[1] - offsets[0] <= 10.0 * found.tolerances.share:
        offset = offsets[0]
    elif found.base is _HERE:
        return found
    else:
        offset = 0.0
    if abs(offset - first.offset) <= found.tolerances.share:
        return found
    turn = composed(first.a.pose, _moved(first.a, offset - first.offset))
    base = composed(composed(turn, inverse(first.a.pose)), found.base)
    moved = replace(first, offset=offset)
    pairs = tuple(moved if pair is first else pair for pair in found.pairs)
    return replace(found, base=base, pairs=pairs)


def _bases(a: BodyTree, b: BodyTree) -> Iterator[ArrayPose]:
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
def _walked(a: BodyTree, b: BodyTree, base: ArrayPose, tolerances: Tolerances) -> _Partial:
    """The robots laid onto each other from the base outwards. Where several ways are equally good,
    a few are followed until something tells them apart."""
    states = [_Partial(Misfit(), (), (), ((-1, -1, base),))]
    while any(state.waiting for state in states):
        states = [one for state in states for one in _further(a, b, state, tolerances)]
        states = sorted(states, key=lambda state: state.misfit)[:_FOLLOWED]
    return states[0]


def _further(
    a: BodyTree, b: BodyTree, state: _Partial, tolerances: Tolerances
) -> Iterator[_Partial]:
    """A state with all joints of its next pair of bodies laid onto each other."""
    if not state.waiting:
        yield state
        return
    (i, j, pose), *waiting = state.waiting
    for matched in _matchings(a, b, (i, j), pose, tolerances):
        alone = [
            (k, part)
            for k, robot, at in ((0, a, i), (1, b, j))
            for part in robot.children[at]
            if part.index not in {pair[k].index for pair in matched}
        ]
        ways = [_laid(a, b, one, two, pose, tolerances) for one, two in matched]
        for chosen in islice(product(*ways), _FOLLOWED):
            yield _Partial(
                state.misfit.plus(*(way[0] for way in chosen), Misfit(axes=len(alone))),
                (*state.pairs, *(pair for _, pair in chosen)),
                (*state.alone, *alone),
                (*((x.a.index, x.b.index, x.pose) for _, x in chosen), *waiting),
            )


def _matchings(
    a: BodyTree, b: BodyTree, at: tuple[int, int], pose: ArrayPose, tolerances: Tolerances
) -> list[list[tuple[Part, Part]]]:
    """The ways to match the joints on two bodies: by equal names; else by equal kind and number of
    joints beyond, with coinciding axes if any coincide."""
    own, others = a.children[at[0]], b.children[at[1]]
    by_name = {x.joint: x for x in others}
    if {x.joint for x in own} == {*by_name}:
        return [[(x, by_name[x.joint]) for x in own]]
    if len(own) == len(others) == 1:
        return [[(own[0], others[0])]]
    choices = [
        [
            *(x for x in others if x.sort == one.sort and b.count[x.index] == a.count[one.index]),
            None,
        ]
        for one in own
    ]
    found: dict[float, list[list[tuple[Part, Part]]]] = {}
    for choice in islice(_each_once(choices), _MATCHINGS):
        pairs = [(x, y) for x, y in zip(own, choice, strict=True) if y]
        off = sum(not tolerances.same(_gap(x, y, pose)[1]) for x, y in pairs)
        lost = max(len(own), len(others)) - len(pairs)
        found.setdefault(off + 2 * lost, []).append(pairs)
    return found[min(found)][:_FOLLOWED]


def _each_once(
    choices: Sequence[Sequence[Part | None]], taken: tuple[Part | None, ...] = ()
) -> Iterator[tuple[Part | None, ...]]:
    """The ways to choose one candidate for each part, none of them twice."""
    if len(taken) == len(choices):
        yield taken
        return
    used = {x.index for x in taken if x}
    for one in choices[len(taken)]:
        if one is None or one.index not in used:
            yield from _each_once(choices, (*taken, one))


def _gap(one: Part, two: Part, pose: ArrayPose) -> tuple[ArrayPose, Gap]:
    """The second joint's frame in the first's, and the difference of their axes."""
    R, p = composed(inverse(one.pose), composed(pose, two.pose))
    if one.axis is None or two.axis is None:
        return (R, p), Gap(norm(p), 0.0, 1.0)
    other = R @ two.axis
    flip = -1.0 if one.axis @ other < 0.0 else 1.0
    angle = float(np.arctan2(norm(cross(one.axis, other)), abs(one.axis @ other)))
    aside = norm(p - one.axis * (one.axis @ p))
    return (R, p), Gap(aside if one.turns and two.turns else 0.0, angle, flip)


def _laid(
    a: BodyTree, b: BodyTree, one: Part, two: Part, pose: ArrayPose, tolerances: Tolerances
) -> list[tuple[Misfit, MatchedJoint]]:
    """The equally good ways in which two bodies lie on each other, with what does not coincide."""
    (R, p), gap = _gap(one, two, pose)
    here = Misfit(axes=not tolerances.same(gap), names=one.joint != two.joint)
    if one.axis is None or two.axis is None:
        free = one.body.kind.frees(one.dim) and two.body.kind.frees(two.dim)
        pair = MatchedJoint(
            one, two, _HERE if free else (R, p), Gap(0.0, 0.0, 1.0) if free else gap
        )
        return [(here if not free else here._replace(axes=0), pair)]
    if here.axes:
        R = rotation_between(gap.flip * (R @ two.axis), one.axis) @ R
        p = one.axis * (one.axis @ p)
    ways: dict[tuple[int, ...], list[tuple[Misfit, MatchedJoint]]] = {}
    known: list[float] = []
    limits = [*_offsets_by_limits(one, two, gap.flip)]
    for offset in (0.0, *limits, *_offsets(a, b, one, two, (R, p))):
        if any(abs(offset - x) < _NO_OFFSET for x in known):
            continue
        known.append(offset)
        moved = composed(_moved(one, -offset), (R, p))
        ahead = _carried(a, b, one, two, moved, tolerances)
        own = here._replace(
            masses=_masses_off(one, two, moved, tolerances),
            ranges=sum(abs(offset - x) > 10.0 * tolerances.share for x in limits),
            zeros=int(abs(offset) > _NO_OFFSET),
            flips=int(gap.flip < 0.0),
        )
        key = (ahead, own.masses, own.ranges)
        ways.setdefault(key, []).append((own, MatchedJoint(one, two, moved, gap, offset)))
    equal = sorted(ways[min(ways)], key=lambda way: way[0])
    return equal[:_WAYS]


def _moved(part: Part, position: float) -> ArrayPose:
    """The pose of a body in its joint's frame at a joint position (rad or m)."""
    assert part.axis is not None
    if part.turns:
        return turned(part.axis, position), np.zeros(3)
    return np.eye(3), position * part.axis


def _offsets(a: BodyTree, b: BodyTree, one: Part, two: Part, pose: ArrayPose) -> Iterator[float]:
    """Offsets between two joints' zeros at which something that their bodies carry coincides."""
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


def _offsets_by_weight(one: Part, own: Weight, other: Weight, pose: ArrayPose) -> Iterator[float]:
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


def _offsets_by_limits(one: Part, two: Part, flip: float) -> Iterator[float]:
    """Offsets of a joint's zero at which an end of its range is the same."""
    own, other = one.body.joint.limits.meant, two.body.joint.limits.meant
    lower, upper = sorted(flip * x for x in (other.lower, other.upper))
    for x, y in ((own.lower, lower), (own.upper, upper)):
        if isfinite(x) and isfinite(y):
            yield x - y


def _carried(
    a: BodyTree, b: BodyTree, one: Part, two: Part, pose: ArrayPose, tolerances: Tolerances
) -> int:
    """The number of joints carried by two bodies that do not coincide."""
    return min(
        sum(not tolerances.same(_gap(own, other, pose)[1]) for own, other in matched)
        for matched in _matchings(a, b, (one.index, two.index), pose, tolerances)
    )


def _masses_off(one: Part, two: Part, pose: ArrayPose, tolerances: Tolerances) -> int:
    """How many of the centre of mass and the inertia tensor do not coincide, where both bodies have
    mass."""
    if one.weight is None or two.weight is None:
        return 0
    R, p = pose
    off = norm(R @ two.weight.com + p - one.weight.com)
    change = norm((R @ two.weight.tensor @ R.T - one.weight.tensor).ravel())
    size = max(norm(one.weight.tensor.ravel()), norm(two.weight.tensor.ravel()))
    return (off > 3.0 * tolerances.length) + (change > 10.0 * tolerances.share * size)
