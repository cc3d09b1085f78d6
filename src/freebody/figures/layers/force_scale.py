"""How long the arrow of a force or a moment is drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.figures.body_loads import BodyLoads
from freebody.figures.layers.plane import bars
from freebody.figures.layers.space import round_down
from freebody.outputs.numbers import significant

_SHORTEST = 0.12
"""Of the longest arrow."""
_ALIKE = 6.0  # bodies and forces that differ by less than this factor are drawn to one scale


@dataclass(frozen=True)
class Scale:
    """The largest force (N) and moment (N m) of a drawing, and how long they are, metres."""

    force: float
    moment: float
    longest: float

    def arrow(self, place: Array, value: Array, largest: float, share: float = 1.0) -> Array:
        """Where the arrow of a force or moment at a place ends."""
        size = float(np.linalg.norm(value))
        return place + max(size / largest, _SHORTEST) * share * self.longest * value / size

    def bar(self, role: str) -> tuple[float, str, str]:
        """A scale bar of the forces."""
        force = round_down(self.force / 2.5)
        return force / self.force * self.longest, f"{significant(force, 1)} N", role


def scale_of(bodies: Iterable[BodyLoads], longest: float) -> Scale:
    """One scale for some bodies."""
    loads = [load for body in bodies for load in body.loads]
    force = max((float(np.linalg.norm(load.force)) for load in loads), default=0.0)
    moment = max((float(np.linalg.norm(load.moment)) for load in loads), default=0.0)
    return Scale(force, moment, longest)


def common_or_own_scales(bodies: Sequence[BodyLoads]) -> tuple[Scale, ...]:
    """Of bodies each drawn alone; one for all where their sizes and forces allow it."""
    sizes = [extent_with_forces(body) for body in bodies]
    alone = [scale_of((body,), 0.75 * size) for body, size in zip(bodies, sizes, strict=True)]
    forces = [scale.force for scale in alone]
    if max(sizes) <= _ALIKE * min(sizes) and max(forces) <= _ALIKE * min(forces):
        return (scale_of(bodies, 0.75 * max(sizes)),) * len(bodies)
    return tuple(alone)


def extent_with_forces(loads: BodyLoads) -> float:
    """Of a body as it is drawn and of where forces act on it, metres."""
    drawn = bars(loads.body, rod=len(loads.body.origin) == 3)
    ends = [place for _, segment in drawn for place in segment]
    places = np.array([*(load.place for load in loads.loads), *ends])
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return size if size > 1e-3 else 0.1
