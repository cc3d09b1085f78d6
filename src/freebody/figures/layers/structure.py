"""A robot without names of its geometry: its parts, in the plane or in space, and how layers are
put on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

from freebody.figures.drawing import FLAT, Drawing, View
from freebody.figures.layers import plane, space
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

Layer = Callable[..., None]
"""layer(drawing, seen, names, bodies=None, **how): draws one kind of thing, of all bodies or of
some."""


def of_each(layer: Callable[..., None]) -> Layer:
    """A layer from what draws it of one body: layer(drawing, seen, names, body, **how)."""

    @wraps(layer)
    def drawn(
        drawing: Drawing,
        seen: Snapshot,
        names: Names,
        bodies: Sequence[BodyPlace] | None = None,
        **how: Any,
    ) -> None:
        for body in seen.pose.bodies if bodies is None else bodies:
            layer(drawing, seen, names, body, **how)

    return drawn


def view_of(seen: Snapshot) -> View:
    """From where a robot is seen best."""
    return FLAT if seen.model.dim == 2 else space.viewed(seen)


def drawn(
    seen: Snapshot,
    names: Names,
    title: str,
    layers: Sequence[Layer] = (),
    faint: bool = False,
) -> Drawing:
    """A robot with layers on it; faint: vectors lie on the links of a planar one."""
    drawing = Drawing(view_of(seen), f"{seen.model.name}: {title}")
    structure(drawing, seen, names, faint)
    for layer in layers:
        layer(drawing, seen, names)
    return drawing


def structure(drawing: Drawing, seen: Snapshot, names: Names, faint: bool = False) -> None:
    """The parts of a robot, its joints and the world's axes."""
    if seen.model.dim == 2:
        plane.structure(drawing, seen, names, faint)
    else:
        space.structure(drawing, seen, names)
