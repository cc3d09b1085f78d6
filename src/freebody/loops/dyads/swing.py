"""The step for a chain with one unknown pin, whose ends stay a distance apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Chain, Complex, Crossing, Posture
from freebody.loops.dyads.geometry import coincident, corner, side
from freebody.loops.dyads.step import ConstructionStep, NameOf, OfOne, Reach


class Swing(ConstructionStep):
    """A step that closes a chain by turning a pin; names: the pin, and the end that turns about
    it."""

    @property
    def called(self) -> str:
        return self.names[1]

    def solve(self, at: Posture) -> list[Array]:
        (turn,) = self.crossings
        near, far = self._arms(at)
        a, b = np.abs(near), np.abs(far)
        here, wanted = np.angle(far / near), corner(np.full(a.shape, self.chain.distance), a, b)
        return [at.turned((turn, s * wanted - here)) for s in (1.0, -1.0)]

    def anywhere(self, at: Posture) -> NDArray[np.bool_]:
        a, b = map(np.abs, self._arms(at))
        return coincident(a, b, np.full(a.shape, self.chain.distance))

    def label(self, at: Posture) -> Array:
        ((body, sign),) = self.crossings
        start, end = (at.point(frame) for frame in self.chain.ends)
        o = at.pivot(body)
        return side(o, start, end) if sign > 0 else side(o, end, start)

    def reach(self, at: Posture) -> Reach:
        ((_, sign),) = self.crossings
        near, far = map(np.abs, self._arms(at))
        base, leg = (near, far) if sign > 0 else (far, near)
        other = self.chain.ends[0 if sign > 0 else 1] or "the target"
        d = self.chain.distance
        return self.names[0], other, base, np.abs(leg - d), leg + d

    def _arms(self, at: Posture) -> tuple[Complex, Complex]:
        """Vectors from the pin to both ends of the chain."""
        ((body, _),) = self.crossings
        near, far = (at.point(end) - at.pivot(body) for end in self.chain.ends)
        return near, far


def _made(chain: Chain, free: Sequence[Crossing], name_of: NameOf) -> ConstructionStep:
    (turn,) = free
    end = chain.ends[1] if turn[1] > 0 else chain.ends[0]
    return Swing((chain,), (turn,), (name_of(turn), str(end)))


SWING = OfOne("R", True, _made)
