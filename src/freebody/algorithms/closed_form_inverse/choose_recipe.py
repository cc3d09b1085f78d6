"""The choice of a recipe for an arm: by how its lines lie, never by a name.

A calibrated arm is nearly one with a closed form: axes that are nearly parallel are made so, and
axes that nearly meet are made to meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np

from freebody.algorithms.closed_form_inverse.across import Across
from freebody.algorithms.closed_form_inverse.recipe import Recipe
from freebody.algorithms.closed_form_inverse.recipes import (
    OneJointHeld,
    OrientationByThree,
    PositionByThree,
    SeenFromTip,
    SphericalWrist,
    ThreeParallel,
)
from freebody.algorithms.closed_form_inverse.two_and_three_joints import Wrist, arm
from freebody.algorithms.joint_lines import (
    can_meet,
    changes_distance,
    common_point,
    nearest_points,
    off_axis,
    parallel,
    perpendicular,
)
from freebody.algorithms.screws import SAME, Screw, ScrewChain
from freebody.arrays import Array

TargetKind = Literal["pose", "position", "orientation"]
"""The part of a frame's pose that a target tells."""


def recipe_for(chain: ScrewChain, kind: TargetKind, plane: bool) -> Recipe | None:
    """The recipe that gives all branches, or None; of seven joints with one of them held."""
    s, length = chain.screws, chain.length
    level = _across(chain, kind, np.array([0.0, 0.0, 1.0]) if plane else None)
    if level is not None or plane:
        return level
    if kind == "pose":
        if len(s) == 7:
            return _with_one_held(s, length)
        return _six(s, length) if len(s) == 6 else None
    if len(s) != 3:
        return None
    if kind == "position":
        found = arm(s, chain.p, length)
        return None if found is None else PositionByThree(found, s, chain.p)
    return OrientationByThree(Wrist(s)) if _wristed(s) else None


def without_idle(chain: ScrewChain) -> ScrewChain:
    """The chain but for its last joints that turn about the frame's origin: they do not move it."""
    n = len(chain.screws)
    while n > 1 and chain.screws[n - 1].turning:
        if off_axis(chain.screws[n - 1], chain.p) > SAME * chain.length:
            break
        n -= 1
    return replace(
        chain,
        screws=chain.screws[:n],
        index=chain.index[:n],
        ratio=chain.ratio[:n],
        offset=chain.offset[:n],
    )


NEARLY = 0.03
"""Axes as near to parallel (rad), and to each other (of the arm's length), are so but for errors of
making."""


def nearby(chain: ScrewChain) -> ScrewChain:
    """The arm with a closed form that this one nearly is."""
    screws = _straightened(chain.screws)
    reach, met = NEARLY * chain.length, [False] * len(screws)
    for first in (len(screws) - 3, 0):  # a wrist, a shoulder
        three = screws[first : first + 3] if first >= 0 else []
        if len(three) == 3 and _may_meet(three) and not any(met[first : first + 3]):
            c = common_point(three, reach / 1e-9)
            if c is not None:
                screws[first : first + 3] = [replace(s, p=c) for s in three]
                met[first : first + 3] = [True] * 3
    for i in range(len(screws) - 1):
        one, other = screws[i : i + 2]
        if not met[i + 1] and _may_meet((one, other)):
            a, b = nearest_points(one, other)
            if float(np.linalg.norm(a - b)) < reach:
                screws[i + 1] = replace(other, p=other.p + a - b)
    return replace(chain, screws=tuple(screws))


def _with_one_held(s: Sequence[Screw], length: float) -> Recipe | None:
    found: list[Recipe] = []
    for held, rest, first in ((s[6], s[:6], False), (s[0], s[1:], True)):
        one = _six(rest, length)
        if one is not None:
            found.append(OneJointHeld(one, held, first))
    return _simplest(found)


def _six(s: Sequence[Screw], length: float) -> Recipe | None:
    found: list[Recipe] = []
    for turned in (s, [x.undone() for x in s[::-1]]):
        one = _spherical_wrist(turned, length) or _three_parallel(turned, length)
        if one is not None:
            found.append(one if turned is s else SeenFromTip(one))
    return _simplest(found)


def _simplest(found: Sequence[Recipe]) -> Recipe | None:
    """The first of the recipes that are found; one that solves a quartic only where there is no
    other."""
    return min(found, key=lambda one: one.by_quartic, default=None)


def _wristed(s: Sequence[Screw]) -> bool:
    bent = not parallel(s[0].w, s[1].w) and not parallel(s[1].w, s[2].w)
    return bent and all(x.turning for x in s)


def _spherical_wrist(s: Sequence[Screw], length: float) -> Recipe | None:
    if not _wristed(s[3:]):
        return None
    c = common_point(s[3:], length)
    found = None if c is None else arm(s[:3], c, length)
    return None if c is None or found is None else SphericalWrist(found, Wrist(s[3:]), s, c)


def _three_parallel(s: Sequence[Screw], length: float) -> Recipe | None:
    if not all(x.turning for x in s):
        return None
    if not (parallel(s[1].w, s[2].w) and parallel(s[2].w, s[3].w)):
        return None
    if parallel(s[0].w, s[1].w) or parallel(s[3].w, s[4].w) or parallel(s[4].w, s[5].w):
        return None
    if not can_meet(s[1], s[2], length) or not changes_distance(s[2], s[3].p, length):
        return None
    c = common_point(s[4:], length)
    return None if c is None else ThreeParallel(s, c, length)


def _across(chain: ScrewChain, kind: TargetKind, normal: Array | None) -> Recipe | None:
    """The recipe for an arm whose turning axes are all parallel: to the normal, if one is given."""
    s, n = chain.screws, normal
    if n is None:
        n = next((x.w for x in s if x.turning), None)
    if kind == "orientation" or n is None or not _in_layers(s, n):
        return None
    lifts = [i for i, x in enumerate(s) if not x.turning and parallel(x.w, n)]
    if len(lifts) > 1:
        return None
    across = tuple(i for i in range(len(s)) if i not in lifts)
    if not _regular([s[i] for i in across], kind == "pose", chain.length):
        return None
    return Across(s, n, across, lifts[0] if lifts else None, chain.p, chain.length)


def _in_layers(s: Sequence[Screw], normal: Array) -> bool:
    """Whether every joint turns about the normal, slides across it, or slides along it."""
    return all(parallel(x.w, normal) or (not x.turning and perpendicular(x.w, normal)) for x in s)


def _regular(s: Sequence[Screw], turned: bool, length: float) -> bool:
    """Whether joints that move across a normal are exactly as many as the task needs, and none
    repeats what another one does."""
    if len(s) == 3 and turned and any(x.turning for x in s):
        if s[2].turning or s[0].turning:
            first, second, last = s if s[2].turning else s[::-1]
            return can_meet(first, second, length) and changes_distance(second, last.p, length)
        return s[1].turning
    return len(s) == 1 or (len(s) == 2 and can_meet(s[0], s[1], length))


def _straightened(screws: Sequence[Screw]) -> list[Screw]:
    """The axes, each turned along the first one that it is nearly parallel to."""
    done: list[Screw] = []
    for s in screws:
        for other in done:
            if float(np.linalg.norm(np.cross(s.w, other.w))) < NEARLY:
                s = replace(s, w=other.w * np.sign(s.w @ other.w))
                break
        done.append(s)
    return done


def _may_meet(screws: Sequence[Screw]) -> bool:
    """Whether all axes turn and none is nearly parallel to the next, so that two neighbours may
    meet in a point."""
    crossed = all(float(np.linalg.norm(np.cross(a.w, b.w))) > NEARLY for a, b in pairwise(screws))
    return crossed and all(s.turning for s in screws)
