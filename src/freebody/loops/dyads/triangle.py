"""The step for a chain with two unknown pins: R R R, a triangle with known sides, whose third
corner is where the loop was cut."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Chain, Complex, Crossing, Posture
from freebody.loops.dyads.geometry import coincident, corner, side
from freebody.loops.dyads.step import ConstructionStep, NameOf, OfOne, Reach


class Triangle(ConstructionStep):
    """A step that closes a chain by two pins as a triangle; names: the first pin, the second, the
    cut."""

    @property
    def called(self) -> str:
        return (self.names[2], self.names[0], self.names[1])[self._elbow]

    def solve(self, at: Posture) -> list[Array]:
        first, second = self.crossings
        start, p, r, end = self._pins(at)
        a, b, c = self._sides(at)
        here = np.angle((r - p) / (start - p)), np.angle((end - r) / (p - r))
        wanted = corner(c, a, b), corner(a, b, c)
        return [
            at.turned((first, s * wanted[0] - here[0]), (second, s * wanted[1] - here[1]))
            for s in (1.0, -1.0)
        ]

    def anywhere(self, at: Posture) -> NDArray[np.bool_]:
        return coincident(*self._sides(at))

    def label(self, at: Posture) -> Array:
        start, p, r, _ = self._pins(at)
        base, other, elbow = {2: (p, start, r), 1: (r, start, p), 0: (p, r, start)}[self._elbow]
        return side(base, other, elbow)

    def reach(self, at: Posture) -> Reach:
        a, b, c = self._sides(at)
        one, two, cut = self.names
        base, legs, ends = {
            2: (a, (b, c), (one, cut)),
            1: (c, (a, b), (two, cut)),
            0: (b, (a, c), (one, two)),
        }[self._elbow]
        return *ends, base, np.abs(legs[0] - legs[1]), legs[0] + legs[1]

    @property
    def _elbow(self) -> int:
        """Which corner of the triangle is the elbow: 1 or 2 for a pin, 0 for the cut; the other two
        corners are held in place by the rest of the robot."""
        signs = tuple(sign for _, sign in self.crossings)
        return 2 if signs == (1.0, 1.0) else 1 if signs == (-1.0, -1.0) else 0

    def _pins(self, at: Posture) -> tuple[Complex, Complex, Complex, Complex]:
        """The positions of the cut's first end, of both pins, and of the cut's second end."""
        start, end = (at.point(end) for end in self.chain.ends)
        p, r = (at.pivot(body) for body, _ in self.crossings)
        return start, p, r, end

    def _sides(self, at: Posture) -> tuple[Array, Array, Array]:
        start, p, r, end = self._pins(at)
        return np.abs(start - p), np.abs(r - p), np.abs(end - r)


def _made(chain: Chain, free: Sequence[Crossing], name_of: NameOf) -> ConstructionStep:
    one, two = free
    return Triangle(
        (chain,), (one, two), (name_of(one), name_of(two), chain.ends[0] or chain.ends[1])
    )


TRIANGLE = OfOne("RR", False, _made)
