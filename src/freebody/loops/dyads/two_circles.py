"""The step for two slides that carry the ends of two rods: an intersection of two circles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Chain, Complex, Crossing, Posture, is_turning
from freebody.loops.dyads.geometry import coincident, corner, shifted, side
from freebody.loops.dyads.step import ConstructionStep, Reach
from freebody.model.tree import Tree


@dataclass(frozen=True)
class TwoCircles(ConstructionStep):
    """A step that closes the chains of two rods by two slides; its name is that of the part the
    slides carry."""

    signs: tuple[float, ...] = ()
    """Signs with which the slides move the second end of each chain against its first."""

    def solve(self, at: Posture) -> list[Array]:
        one, two = self._gaps(at)
        between = one - two  # from the first centre to the second
        r, t = (np.full(one.shape, c.distance) for c in self.chains)
        d = np.abs(between)
        angle, (first, second) = corner(t, r, d), self.crossings
        return [
            shifted(at, first, second, between / d * r * np.exp(1j * s * angle) - one)
            for s in (1.0, -1.0)
        ]

    def anywhere(self, at: Posture) -> NDArray[np.bool_]:
        one, two = self._gaps(at)
        return coincident(np.abs(one - two), *(np.full(one.shape, c.distance) for c in self.chains))

    def label(self, at: Posture) -> Array:
        one, two = self._gaps(at)
        return side(np.zeros_like(one), one - two, one)

    def reach(self, at: Posture) -> Reach:
        one, two = self._gaps(at)
        r, t = (np.full(one.shape, c.distance) for c in self.chains)
        a, b = (
            c.ends[0] if s > 0 else c.ends[1] for c, s in zip(self.chains, self.signs, strict=True)
        )
        return str(a), str(b), np.abs(one - two), np.abs(r - t), r + t

    def _gaps(self, at: Posture) -> list[Complex]:
        """The vectors from the centre of each circle to the carried end."""
        return [
            sign * (at.point(c.ends[1]) - at.point(c.ends[0]))
            for c, sign in zip(self.chains, self.signs, strict=True)
        ]


def two_circles(
    tree: Tree, chains: tuple[Chain, Chain], free: tuple[list[Crossing], list[Crossing]]
) -> ConstructionStep | None:
    """The step for two rods whose unknown joints are the same two slides."""
    bodies = [sorted(i for i, _ in row) for row in free]
    signs = [{sign for _, sign in row} for row in free]
    rods = all(c.distance > 0.0 for c in chains)
    slides = not any(is_turning(tree, x) for row in free for x in row)
    if not (rods and slides and len(bodies[0]) == 2 and bodies[0] == bodies[1]):
        return None
    if any(len(s) != 1 for s in signs):
        return None
    (a, b), (first,), (second,) = bodies[0], *signs
    carried = chains[0].ends[1] if first > 0 else chains[0].ends[0]
    return TwoCircles(chains, ((a, 1.0), (b, 1.0)), (str(carried),), (first, second))
