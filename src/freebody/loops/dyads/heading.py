"""The step that turns a frame to the wanted direction by its last unknown pin."""

from __future__ import annotations

from freebody.arrays import Array
from freebody.loops.dyads.chain import Crossing, Posture
from freebody.loops.dyads.step import ConstructionStep


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
