"""The step for a chain with two unknown slides, P P, which has one solution."""

from __future__ import annotations

from freebody.arrays import Array
from freebody.loops.dyads.chain import Posture
from freebody.loops.dyads.geometry import shifted
from freebody.loops.dyads.step import ConstructionStep, OfOne


class TwoSlides(ConstructionStep):
    """A step that closes a chain by two slides; its only solution needs no name."""

    def solve(self, at: Posture) -> list[Array]:
        first, second = self.crossings
        start, end = (at.point(frame) for frame in self.chain.ends)
        return [shifted(at, first, second, start - end)]


TWO_SLIDES = OfOne("PP", False, lambda chain, free, _: TwoSlides((chain,), tuple(free)))
