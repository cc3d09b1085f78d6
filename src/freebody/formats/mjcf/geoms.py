"""Shapes of an MJCF file's bodies: what MuJoCo makes of its geoms, whatever angles, defaults and
ends they are written with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from freebody.model.placement import Placement
from freebody.model.shapes import Shape, ShapeRole, SolidKind

_SIZES: dict[SolidKind, Callable[..., tuple[float, ...]]] = {
    "box": lambda x, y, z: (2 * x, 2 * y, 2 * z),
    "cylinder": lambda r, half, _: (r, 2 * half),
    "sphere": lambda r, *_: (r,),
    "capsule": lambda r, half, _: (r, 2 * half),
    "ellipsoid": lambda *half: half,
}
"""The sizes of each kind of solid from the three numbers that MuJoCo has for it."""


def shapes_of(
    geoms: Sequence[dict[str, Any]], placed: Callable[[Any, Any], Placement]
) -> Iterator[Shape]:
    """The shapes of a body's geoms. placed: from a position and a quaternion in the body's frame to
    the placement in its link's.

    What a viewer shows counts as visual, whether or not it collides, all else as collision; planes
    and height fields are no shapes of a robot.
    """
    for geom in geoms:
        if not all(map(math.isfinite, (*geom["pos"], *geom["quat"]))):
            continue
        role: ShapeRole = "visual" if geom["seen"] else "collision"
        at = placed(geom["pos"], geom["quat"])
        if geom["points"]:
            points = tuple((float(x), float(y), float(z)) for x, y, z in geom["points"])
            if all(math.isfinite(x) for point in points for x in point):
                yield Shape("hull", (), at, role, points=points)
        elif geom["type"] in _SIZES:
            size = _SIZES[geom["type"]](*geom["size"])
            if all(math.isfinite(x) and x > 0.0 for x in size):
                yield Shape(geom["type"], size, at, role)
