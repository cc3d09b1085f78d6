"""Parts from which the notes' figures of planar arms are put together."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.figures.drawing import Drawing
from freebody.figures.layers import measures
from freebody.figures.layers.bare_robot import Layer, structure
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT
from freebody.formats.loading import load
from freebody.trees.public_calls import FrameWrenchTable, JointVector

GEOMETRY: tuple[Layer, ...] = (
    measures.angles,
    measures.lengths,
    measures.centres,
)
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
    """The bundled arm 2R at a pose that is seen well; at rest unless rates are given."""
    return snapshot(load("2R"), q, qd or [0.0, 0.0], qdd or [0.0, 0.0], wrenches)


def panel(seen: Snapshot, note: str, layers: Sequence[Layer], faint: bool = False) -> Drawing:
    """An arm with some layers, and a line of words below."""
    drawing = Drawing(FLAT, f"{seen.model.name}: {note}")
    structure(drawing, seen, faint)
    for layer in layers:
        layer(drawing, seen)
    drawing.notes = [note]
    return drawing
