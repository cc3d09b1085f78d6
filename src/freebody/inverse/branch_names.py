"""Names of branches, from where the arm stands.

Shoulder right, left: a positive turn of joint 2 lifts, lowers what it carries along joint 1's axis
(Lee and Ziegler 1984). Elbow up, down (left, right for arms that move level): on which side of the
line from shoulder to wrist it lies, seen with the wrist to the right. Wrist flipped: the other of
two ways to point the last axis.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.algorithms.joint_lines import parallel, perpendicular
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.inverse import subproblems as sp
from freebody.trees.triangle_solutions import side_of


def shoulder(s1: Screw, s2: Screw, wrist: Array) -> np.ndarray:
    """Of two turning joints that are not parallel; wrist: the carried point (..., 3) before joint 1
    turns."""
    value = (wrist - s2.p) @ np.cross(s1.w, s2.w)
    size = sp.size(wrist - s1.p)
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
    upper = sp.across(s2.w, s3.p - s2.p)
    fore = sp.across(s2.w, s3.moved(x[..., 1], c) - s3.p)
    bend = sp.cross(upper, fore) @ s2.w
    up, down = (f"elbow {word}" for word in words)
    between = np.where(fore @ upper > 0, "elbow straight", "elbow folded")
    facing = np.where(np.asarray(side) == "shoulder left", 1.0, -1.0)
    return side_of(facing * bend, sp.size(upper) * sp.size(fore), up, down, between)


def flip(u: Array, s5: Screw, v: Array, x5: Array) -> np.ndarray:
    """Of the joint at x5 (...) between two directions u and v, which it bends one way or the
    other."""
    value = sp.cross(u, s5.turned(x5, v)) @ s5.w
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
        way @ sliding.w, sp.size(way), "reaching forward", "reaching backward", "reaching across"
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
        and sp.size(sp.across(s2.w, s3.p - s2.p)) > 1e-9
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
