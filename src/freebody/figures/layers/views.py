"""What a drawing of a robot may show, and of what layers it is made."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from freebody.figures.drawing import Drawing
from freebody.figures.layers import axes, geometry, motion, vectors
from freebody.figures.layers.structure import Layer, drawn
from freebody.figures.names import Names
from freebody.figures.snapshot import Snapshot

_BENT: tuple[Layer, ...] = (geometry.angles, geometry.slides)
_GEOMETRY: tuple[Layer, ...] = (*_BENT, geometry.centres)
VIEWS: dict[int, dict[str, tuple[Layer, ...]]] = {
    2: {
        "geometry": (*_GEOMETRY, geometry.all_lengths),
        "vectors": (*_BENT, vectors.links, vectors.to_tip),
        "centres": (*_GEOMETRY, vectors.of_centres),
        "velocities": (*_GEOMETRY, motion.rates, motion.of_centres),
        "accelerations": (
            *_GEOMETRY, partial(motion.rates, second=True), partial(motion.of_centres, second=True)
        ),
    },
    3: {
        "frames": (axes.joint_axes, axes.variables),
        "normals": (axes.joint_axes, axes.normals),
        "vectors": (vectors.links, geometry.centres),
    },
}  # fmt: skip
"""Of planar robots, and of those in space."""


def view(seen: Snapshot, show: str, names: Names, more: Sequence[Layer] = ()) -> Drawing:
    """One of `VIEWS`, with more layers on it."""
    layers = (*VIEWS[seen.model.dim][show], *more)
    return drawn(seen, names, show, layers, faint=show == "vectors")
