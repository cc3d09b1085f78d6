"""Names of branches, from where the arm stands.

Shoulder right, left: a positive turn of joint 2 lifts, lowers what it carries along joint 1's axis
(Lee and Ziegler 1984). Elbow up, down (left, right for arms that move level): on which side of the
line from shoulder to wrist it lies, seen with the wrist to the right. Wrist flipped: the other of
two ways to point the last axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import singledispatch

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
from freebody.algorithms.joint_lines import parallel, perpendicular
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.loops.dyads.geometry import side_of

Words = tuple[str, str]
"""What two elbows are called."""


@singledispatch
def of_recipe(recipe: Recipe, x: Array, words: Words) -> list[np.ndarray]:
    """Names (...) of the branches of solutions x (..., n), in parts; words: of an arm whose turning
    axes are all parallel."""
    raise TypeError(f"no names of branches of a {type(recipe).__name__}")


@of_recipe.register
def _(recipe: PositionByThree, x: Array, words: Words) -> list[np.ndarray]:
    return arm(recipe.screws, recipe.c, x)


@of_recipe.register
def _(recipe: OrientationByThree, x: Array, words: Words) -> list[np.ndarray]:
    return wrist(recipe.wrist.screws, x)


@of_recipe.register
def _(recipe: SphericalWrist, x: Array, words: Words) -> list[np.ndarray]:
    return arm(recipe.screws[:3], recipe.c, x[..., :3]) + wrist(recipe.screws[3:], x[..., 3:])


@of_recipe.register
def _(recipe: ThreeParallel, x: Array, words: Words) -> list[np.ndarray]:
    s1, s2, s3, s4, s5, s6 = recipe.screws
    carried = s3.moved(x[..., 2], s4.moved(x[..., 3], recipe.c))
    side = shoulder(s1, s2, s2.moved(x[..., 1], carried))
    return [side, elbow(s2, s3, s4.p, x[..., 1:3], side), flip(s2.w, s5, s6.w, x[..., 4])]


@of_recipe.register
def _(recipe: SeenFromTip, x: Array, words: Words) -> list[np.ndarray]:
    return of_recipe(recipe.forward, -x[..., ::-1], words)


@of_recipe.register
def _(recipe: OneJointHeld, x: Array, words: Words) -> list[np.ndarray]:
    return of_recipe(recipe.rest, x[..., 1:] if recipe.first else x[..., :-1], words)


@of_recipe.register
def _(recipe: Across, x: Array, words: Words) -> list[np.ndarray]:
    s, y = [recipe.screws[i] for i in recipe.across], x[..., list(recipe.across)]
    if len(s) == 3 and not s[2].turning and s[0].turning:
        s, y = s[::-1], -y[..., ::-1]
    if len(s) < 2 or (len(s) == 3 and not s[2].turning):
        return []
    c = s[2].p if len(s) == 3 else recipe.c
    if not (s[0].turning and s[1].turning):
        return pair(s[0], s[1], c, y[..., :2])
    # names do not depend on the sense of the axes
    upper, fore = (replace(screw, w=recipe.normal) for screw in s[:2])
    bent = y[..., :2] * [screw.w @ recipe.normal for screw in s[:2]]
    return [elbow(upper, fore, c, bent, words=words)]


def shoulder(s1: Screw, s2: Screw, wrist: Array) -> np.ndarray:
    """Of two turning joints that are not parallel; wrist: the carried point (..., 3) before joint 1
    turns."""
    value = (wrist - s2.p) @ np.cross(s1.w, s2.w)
    size = _size(wrist - s1.p)
    return side_of(value, size, "shoulder right", "shoulder left", "shoulder overhead")


def elbow(
    s2: Screw,
    s3: Screw,
    c: Array,
    x: Array,
    side: str | np.ndarray = "",
    words: tuple[str, str] = ("up", "down"),
) -> np.ndarray:
    """Of two parallel turning joints at x (..., 2) that carry c; on the left side it is seen from
    the back."""
    upper = _across(s2.w, s3.p - s2.p)
    fore = _across(s2.w, s3.moved(x[..., 1], c) - s3.p)
    bend = _cross(upper, fore) @ s2.w
    up, down = (f"elbow {word}" for word in words)
    between = np.where(fore @ upper > 0, "elbow straight", "elbow folded")
    facing = np.where(np.asarray(side) == "shoulder left", 1.0, -1.0)
    return side_of(facing * bend, _size(upper) * _size(fore), up, down, between)


def flip(u: Array, s5: Screw, v: Array, x5: Array) -> np.ndarray:
    """Of the joint at x5 (...) between two directions u and v, which it bends one way or the
    other."""
    value = _cross(u, s5.turned(x5, v)) @ s5.w
    return side_of(value, 1.0, "wrist not flipped", "wrist flipped", "wrist straight")


def wrist(screws: Sequence[Screw], x: Array) -> list[np.ndarray]:
    """Of three turning joints at x (..., 3)."""
    s4, s5, s6 = screws
    return [flip(s4.w, s5, s6.w, x[..., 1])]


def pair(
    s1: Screw, s2: Screw, c: Array, x: Array, words: tuple[str, str] = ("up", "down")
) -> list[np.ndarray]:
    """Of two joints at x (..., 2) that bring c to a point."""
    if s1.turning and s2.turning:
        if parallel(s1.w, s2.w):
            return [elbow(s1, s2, c, x, words=words)]
        return [shoulder(s1, s2, s2.moved(x[..., 1], c))]
    if s1.turning != s2.turning and perpendicular(s1.w, s2.w):
        return [_forward(s1, s2, c, x)]
    return []


def _forward(s1: Screw, s2: Screw, c: Array, x: Array) -> np.ndarray:
    """Of a turning and a sliding joint: whether the arm reaches out along the slide or against
    it."""
    turning, sliding = (s1, s2) if s1.turning else (s2, s1)
    way = s2.moved(x[..., 1], c) - turning.p
    return side_of(
        way @ sliding.w, _size(way), "reaching forward", "reaching backward", "reaching across"
    )


def arm(screws: Sequence[Screw], c: Array, x: Array) -> list[np.ndarray]:
    """Of three joints at x (..., 3) that bring c to a point."""
    s1, s2, s3 = screws
    carried = s3.moved(x[..., 2], c)
    names = pair(s1, s2, carried, x[..., :2])
    if (
        s2.turning
        and s3.turning
        and parallel(s2.w, s3.w)
        and _size(_across(s2.w, s3.p - s2.p)) > 1e-9
    ):
        if s1.turning and parallel(s1.w, s2.w):  # the elbow has its name
            return names
        return [*names, elbow(s2, s3, c, x[..., 1:], names[0] if names else "")]
    if s2.turning != s3.turning and perpendicular(s2.w, s3.w):
        return [*names, _forward(s2, s3, c, x[..., 1:])]
    return names


def joined(parts: list[np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """Names (...) from their parts, with commas between."""
    if not parts:
        return np.full(shape, "")
    whole = np.broadcast_to(parts[0], shape)
    for part in parts[1:]:
        whole = np.char.add(np.char.add(whole, ", "), part)
    return whole


def _cross(a: Array, b: Array) -> Array:
    """a × b over the last axis."""
    a, b = np.broadcast_arrays(a, b)
    return np.asarray(np.cross(a, b), dtype=float)


def _across(w: Array, v: Array) -> Array:
    """The part of v at right angles to the unit vector w."""
    return v - (v @ w)[..., None] * w


def _size(v: Array) -> Array:
    """Length over the last axis."""
    return np.sqrt(np.sum(v * v, axis=-1))
