"""Steps for a chain whose ends stay a distance apart: by its one unknown pin, or by its one unknown
slide."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Chain, Complex, Crossing, Posture
from freebody.loops.dyads.plane_vectors import across, along, coincident, corner, root, side
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
