"""The joints on the way between two frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from freebody.algorithms.kinematics import ancestors
from freebody.model.tree import Tree

Crossing = tuple[int, float]
"""A joint on the way from the first end to the second, and the sign with which it moves what comes
behind."""


@dataclass(frozen=True)
class Chain:
    """The joints between two frames that meet, or stay `distance` apart; the first may be a target,
    None."""

    name: str
    ends: tuple[str | None, str]
    path: tuple[Crossing, ...]
    distance: float = 0.0

    @property
    def frames(self) -> tuple[str, ...]:
        """Its ends on the robot."""
        return tuple(end for end in self.ends if end is not None)


def chain(tree: Tree, name: str, ends: tuple[str | None, str], distance: float = 0.0) -> Chain:
    """The chain between two frames of a tree."""
    first, second = (
        ancestors(tree, tree.frames[frame][0]) if frame is not None else [] for frame in ends
    )
    up = [(i, -1.0) for i in first if i not in second]
    down = [(i, 1.0) for i in reversed(second) if i not in first]
    return Chain(name, ends, (*up, *down), distance)


def is_turning(tree: Tree, crossing: Crossing) -> bool:
    """Whether a joint on the way turns; else it slides."""
    return tree.bodies[crossing[0]].primitive.turns


def coordinate(tree: Tree, crossing: Crossing) -> int:
    """Which coordinate a joint on the way is, as an index in q."""
    return tree.bodies[crossing[0]].coordinates.q[0]


def coordinates(tree: Tree, crossings: Iterable[Crossing]) -> set[int]:
    """The same of several."""
    return {coordinate(tree, crossing) for crossing in crossings}
