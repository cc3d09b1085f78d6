"""A construction step: unknown joints of chains, found from the known ones; and the step that turns
a frame to the wanted direction, and closes no chain."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Chain, Crossing, Posture
from freebody.model.tree import Tree

Reach = tuple[str, str, Array, Array, Array]
"""Two points, how far apart they are (N, K), and how far apart what joins them can hold them: from,
to."""


@dataclass(frozen=True)
class ConstructionStep(ABC):
    """A step that finds the unknown joints of one or two chains from the known ones."""

    chains: tuple[Chain, ...]
    crossings: tuple[Crossing, ...]
    """Joints that the construction finds."""
    names: tuple[str, ...] = ()
    """Names of the dyad's points, as each kind needs them."""
    ways: ClassVar[tuple[str, str]] = ("left", "right")
    """Words for the solutions with a positive and a negative label."""

    @property
    def chain(self) -> Chain:
        """Chain of a construction that has a single one."""
        return self.chains[0]

    @property
    def frames(self) -> tuple[str, ...]:
        """The names of the robot's frames at the ends of the step's chains."""
        return tuple(frame for chain in self.chains for frame in chain.frames)

    @property
    def called(self) -> str:
        """The name of the part that lies on one side or the other in the step's two solutions."""
        return self.names[0]

    @abstractmethod
    def solve(self, at: Posture) -> list[Array]:
        """The positions q (N, K, nq) of each solution of the step; NaN where there is none."""

    def anywhere(self, at: Posture) -> NDArray[np.bool_]:
        """Flags (N, K) of the postures in which pins coincide, so that any angle solves the
        step."""
        return np.zeros(at.q.shape[:-1], dtype=bool)

    def label(self, at: Posture) -> Array | None:
        """Which of the step's solutions a posture is, as a positive or negative number (N, K); None
        where there is only one."""
        del at
        return None

    def reach(self, at: Posture) -> Reach | None:
        """The distance to be bridged and the lengths that cannot do it; None where the step always
        closes."""
        del at
        return None


NameOf = Callable[[Crossing], str]
"""Name of the coordinate of a joint on the way."""


@dataclass(frozen=True)
class OfOne:
    """A kind of step that closes a single chain."""

    joints: str
    """The unknown joints in their order: R pins, P slides."""
    rod: bool
    """Whether the chain's ends stay a distance apart, or meet."""
    make: Callable[[Chain, Sequence[Crossing], NameOf], ConstructionStep]


OfTwo = Callable[
    [Tree, tuple[Chain, Chain], tuple[list[Crossing], list[Crossing]]], ConstructionStep | None
]
"""A kind of step that closes two chains at once, whose unknown joints are these; None where it is
not made for them."""


class Heading(ConstructionStep):
    """A step that turns a frame to the wanted direction; its name is the frame's, and it closes no
    chain."""

    @property
    def frames(self) -> tuple[str, ...]:
        return self.names

    def solve(self, at: Posture) -> list[Array]:
        assert at.angle is not None
        return [at.turned((self.crossings[0], at.angle - at.heading(self.names[0])))]


def heading(frame: str, turn: Crossing) -> ConstructionStep:
    """The step that turns a frame to the wanted direction by a joint."""
    return Heading((), (turn,), (frame,))
