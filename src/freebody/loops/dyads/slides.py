"""Steps for a chain with unknown slides: a pin and a slide, R P or P R, which make a right-angled
triangle, and two slides, P P, with one solution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Chain, Complex, Crossing, Posture
from freebody.loops.dyads.plane_vectors import across, along, coincident, root, shifted
from freebody.loops.dyads.step import ConstructionStep, NameOf, OfOne


class TurnAndSlide(ConstructionStep):
    """A step that closes a chain by a pin and a slide, its crossings in this order; its name is the
    slide's."""

    ways = ("forward", "backward")

    def solve(self, at: Posture) -> list[Array]:
        turn, slide = self.crossings
        rigid, sliding, e, behind = self._parts(at)
        ahead, aside = along(e, sliding), across(e, sliding)
        half = root(np.abs(rigid), aside)
        found = []
        for s in (1.0, -1.0):
            way = s * half - ahead
            arrived = sliding + way * e
            angle = np.angle(rigid / arrived)
            slid = at.moved(at.slid(slide, way))
            found.append(slid.turned((turn, angle if behind else -angle)))
        return found

    def anywhere(self, at: Posture) -> NDArray[np.bool_]:
        rigid, sliding, e, _ = self._parts(at)
        # what is rigid has no length, and what slides can reach the pin
        far = np.abs(sliding)
        return coincident(np.abs(rigid), far, np.sqrt(far**2 + across(e, sliding) ** 2))

    def label(self, at: Posture) -> Array:
        _, sliding, e, _ = self._parts(at)
        return along(e, sliding) / np.maximum(np.abs(sliding), 1e-300)

    def _parts(self, at: Posture) -> tuple[Complex, Complex, Complex, bool]:
        """Vectors from the pin to the end that only turns and to the end that also slides, the
        slide's direction, and whether the slide lies behind the pin."""
        turn, slide = self.crossings
        o = at.pivot(turn[0])
        near, far = (at.point(end) - o for end in self.chain.ends)
        behind = self.chain.path.index(slide) > self.chain.path.index(turn)
        e = at.slide(slide)
        return (near, far, e, behind) if behind else (far, near, -e, behind)


def _turn_first(chain: Chain, free: Sequence[Crossing], name_of: NameOf) -> ConstructionStep:
    turn, slide = free
    return TurnAndSlide((chain,), (turn, slide), (name_of(slide),))


TURN_AND_SLIDE = OfOne("RP", False, _turn_first)
SLIDE_AND_TURN = OfOne(
    "PR", False, lambda chain, free, name_of: _turn_first(chain, free[::-1], name_of)
)


class TwoSlides(ConstructionStep):
    """A step that closes a chain by two slides; its only solution needs no name."""

    def solve(self, at: Posture) -> list[Array]:
        first, second = self.crossings
        start, end = (at.point(frame) for frame in self.chain.ends)
        return [shifted(at, first, second, start - end)]


TWO_SLIDES = OfOne("PP", False, lambda chain, free, _: TwoSlides((chain,), tuple(free)))
