"""Shapes of links as a file gives them. The dynamics do not depend on them: they serve to check or
estimate masses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from freebody.errors import IncludedLine
from freebody.model.inertia import Inertia
from freebody.model.placement import Placement

DENSEST, LIGHTEST = 20e3, 5.0
"""kg/m³: gold and tungsten are near the one, air is 1.2."""


@dataclass(frozen=True)
class Shape:
    """A box, cylinder or sphere, or the mesh in a file, placed in the link's frame; boxes and
    cylinders are centred."""

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...]
    """Sides (m); radius and length along z (m); radius (m); of a mesh the scales along x, y, z."""
    placement: Placement
    role: Literal["collision", "visual"]
    file: str = ""
    """The file of a mesh, as written."""
    line: int | IncludedLine | None = None

    @property
    def volume(self) -> float:
        """Volume of the shape, m³; NaN of a mesh, whose file would have to be opened."""
        if self.kind == "box":
            return float(np.prod(self.size))
        if self.kind == "cylinder":
            return float(np.pi * self.size[0] ** 2 * self.size[1])
        return float(4 / 3 * np.pi * self.size[0] ** 3) if self.kind == "sphere" else float("nan")

    @property
    def radius(self) -> float:
        """The largest distance of a point of the shape from its centre (m); 0 for a mesh, which is
        not opened."""
        if self.kind == "box":
            return 0.5 * float(np.linalg.norm(self.size))
        if self.kind == "cylinder":
            return float(np.hypot(self.size[0], 0.5 * self.size[1]))
        return self.size[0] if self.kind == "sphere" else 0.0

    def uniform(self, density: float) -> Inertia:
        """The inertia (own frame) of a box, cylinder or sphere filled with a density (kg/m³)."""
        mass = density * self.volume
        if self.kind == "box":
            return Inertia.box(mass, self.size)
        return (
            Inertia.cylinder(mass, *self.size)
            if self.kind == "cylinder"
            else Inertia.sphere(mass, self.size[0])
        )
