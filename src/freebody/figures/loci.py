"""`singularity_diagram`: a planar parallel robot with the curves on which its tip stands at
singular positions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from freebody.errors import FreebodyError
from freebody.figures.drawing import Drawing
from freebody.figures.figure import Figure, of_one
from freebody.figures.layers.structure import structure
from freebody.figures.snapshot import snapshot
from freebody.figures.view import FLAT
from freebody.loops.singularity_loci import Locus, singularity_loci
from freebody.model.model import Model
from freebody.trees.kinematics import forward_kinematics

_KINDS: dict[Literal["first", "second"], str] = {"first": "type 1", "second": "type 2"}
_POINT = 1e-6  # m: a curve shorter than this is one place


def singularity_diagram(
    model: Model,
    *,
    frame: str | None = None,
    rows: Sequence[str] | None = None,
    hold: Mapping[str, float] | None = None,
) -> Figure:
    """The robot at home, and the tip positions at which it is singular (first and second type),
    each curve a named element.

    Arguments as for `singularity_loci`. `.named("type 1, curve 1")` is a polyline in world
    coordinates.
    """
    if model.dim != 2:
        raise FreebodyError(
            f"singularity_diagram: {model.name!r} is in space; loci are drawn in the plane only."
        )
    drawing = Drawing(FLAT, f"Singular positions of {model.name}")
    for kind, name in _KINDS.items():
        loci = singularity_loci(model, kind, frame=frame, rows=rows, hold=hold)
        _curves(drawing, model, loci, name, kind, frame)
    seen = snapshot(model)
    structure(drawing, seen)
    drawing.notes = [
        "type 1, blue: the tip cannot move in some direction, whatever the drives do",
        "type 2, red: the tip can move though the drives are locked",
    ]
    return of_one(drawing.title, drawing, "singularity_diagram")


def _curves(
    drawing: Drawing, model: Model, loci: Sequence[Locus], name: str, kind: str, frame: str | None
) -> None:
    """Draw the tip's path along each locus; a path that several working modes share is drawn
    once."""
    drawn: list[np.ndarray] = []
    for locus in loci:
        tip = forward_kinematics(model, locus.q, frame)[:, :2, 2]
        if any(_same(tip, other) for other in drawn):
            continue
        drawn.append(tip)
        role = f"locus-{kind}"
        label = f"{name}, curve {len(drawn)}"
        if np.ptp(tip, axis=0).max() < _POINT:
            drawing.mark(tip[0], "dot", label, role, 4.0)
        else:
            drawing.line(tip, label, role)


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether every fifth point of polyline a lies on b, within half the spacing of b's points."""
    spacing = np.linalg.norm(np.diff(b, axis=0), axis=1).max(initial=_POINT)
    away = np.linalg.norm(a[::5, None] - b[None], axis=-1).min(axis=1)
    return len(b) > 1 and bool((away < spacing).all())
