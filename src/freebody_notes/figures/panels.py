"""Building blocks for the notes' figures of planar arms."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.figures.drawing import Drawing
from freebody.figures.layers import geometry
from freebody.figures.layers.structure import Layer, structure
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT
from freebody.formats.loading import load
from freebody.trees.public_calls import FrameWrenchTable, JointVector

GEOMETRY: tuple[Layer, ...] = (geometry.angles, geometry.lengths, geometry.centres)
RATES, SECOND = [0.9, 1.1], [1.5, 1.0]
"""Joint rates (rad/s) and accelerations (rad/s²) of the two-link arm in the figures that show its
motion."""
TIP = [-4.5, -3.0, 0.0]
"""The tip load of section 2.4: force (N), moment (N m)."""


def two_links(
    q: JointVector | None = None,
    qd: JointVector | None = None,
    qdd: JointVector | None = None,
    wrenches: FrameWrenchTable = None,
) -> Snapshot:
    """The bundled 2R arm at a pose suitable for figures; at rest unless rates are given."""
    return snapshot(load("2R"), q, qd or [0.0, 0.0], qdd or [0.0, 0.0], wrenches)


def panel(seen: Snapshot, note: str, layers: Sequence[Layer], faint: bool = False) -> Drawing:
    """A drawing of an arm with some layers and a caption below."""
    drawing = Drawing(FLAT, f"{seen.model.name}: {note}")
    structure(drawing, seen, faint)
    for layer in layers:
        layer(drawing, seen)
    drawing.notes = [note]
    return drawing
