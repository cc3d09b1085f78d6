"""Connects and welds of a model of MuJoCo, and the bodies that they hold together: two connects may
hold an axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.model.placement import Placement, rotate, shift
from freebody.spatial import space

_APART = 1e-6
"""m between two connects that hold an axis."""
_EQUAL = 1e-9
_TRACE = 1e-14


@dataclass
class HeldBodies:
    """A connect or weld: the bodies that it holds together, and where, as points and as frames of
    their links."""

    name: str
    kind: str
    bodies: list[int]
    points: list[np.ndarray]
    places: list[Placement]
    axis: tuple[float, ...] = ()

    def with_other(self, other: HeldBodies) -> HeldBodies | None:
        """The axis that two connects hold, from midway on it; None where they hold none."""
        if not self.kind == other.kind == "spherical" or {*self.bodies} != {*other.bodies}:
            return None
        way = 1 if self.bodies == other.bodies else -1
        ends = [*zip(self.points, other.points[::way], strict=True)]
        along = [there - here for here, there in ends]
        lengths = [float(np.linalg.norm(x)) for x in along]
        if min(lengths) < _APART or abs(lengths[0] - lengths[1]) > _EQUAL * max(lengths):
            return None
        axes = [_clean(x / length) for x, length in zip(along, lengths, strict=True)]
        middles = [moved(0.5 * (here + there)) for here, there in ends]
        axis = tuple(axes[0].tolist())
        if not np.allclose(*axes, rtol=0.0, atol=_EQUAL):
            middles = [at.then(_from_z(x)) for at, x in zip(middles, axes, strict=True)]
            axis = (0.0, 0.0, 1.0)
        return replace(self, kind="revolute", places=middles, axis=axis)


def joined(given: list[HeldBodies]) -> tuple[list[HeldBodies], list[tuple[str, str]]]:
    """The same with one in the place of two connects that hold an axis, and the names of these."""
    waiting, found, pairs = list(given), [], []
    while waiting:
        first, *waiting = waiting
        for second in waiting:
            if (both := first.with_other(second)) is not None:
                waiting = [x for x in waiting if x is not second]
                pairs.append((first.name, second.name))
                first = both
                break
        found.append(first)
    return found, pairs


def moved(by: np.ndarray) -> Placement:
    """A shift (m), nothing at all where it is none."""
    return shift(*by.tolist()) if by.any() else Placement()


def turned(quaternion: Any) -> Placement:
    """The rotation of a quaternion w, x, y, z of any length."""
    w, x, y, z = (float(c) for c in quaternion)
    if not (x or y or z):
        return Placement()
    return rotate(space.quaternion((w, x, y, z)), "quaternion")


def _clean(direction: np.ndarray) -> np.ndarray:
    """A unit vector, without the traces that rounding leaves across axes."""
    kept = np.where(abs(direction) < _TRACE, 0.0, direction)
    return kept / np.linalg.norm(kept)


def _from_z(direction: np.ndarray) -> Placement:
    """A rotation that takes z to a direction."""
    x, y, z = direction
    if z < -0.5:
        return rotate(((1, 0, 0), (0, -1, 0), (0, 0, -1)), "pose").then(
            _from_z(np.array((x, -y, -z)))
        )
    return turned((1.0 + z, -y, x, 0.0))
