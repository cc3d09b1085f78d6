"""The step for a chain with one unknown slide, whose ends stay a distance apart."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.loops.dyads.chain import Posture
from freebody.loops.dyads.geometry import across, along, root
from freebody.loops.dyads.step import ConstructionStep, OfOne


class Stretch(ConstructionStep):
    """A step that closes a chain by its slide; its name is the slide's."""

    ways = ("forward", "backward")

    def solve(self, at: Posture) -> list[Array]:
        ahead, aside = self._gap(at)
        half = root(np.full(ahead.shape, self.chain.distance), aside)
        return [at.slid(self.crossings[0], s * half - ahead) for s in (1.0, -1.0)]

    def label(self, at: Posture) -> Array:
        return self._gap(at)[0] / self.chain.distance

    def _gap(self, at: Posture) -> tuple[Array, Array]:
        """Components, along and across the slide, of the vector from first to second end."""
        start, end = (at.point(frame) for frame in self.chain.ends)
        e = at.slide(self.crossings[0])
        return along(e, end - start), across(e, end - start)


STRETCH = OfOne(
    "P", True, lambda chain, free, name_of: Stretch((chain,), tuple(free), (name_of(free[0]),))
)
