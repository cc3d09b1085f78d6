"""Figure 2.2: the planar parallel robot with five bars, closed at P for the cranks' angles."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arc, Dimension, Drawing, Label, Line, Mark, point
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.layers.bare_robot import axes
from freebody.figures.view import FLAT
from freebody.formats.loading import load
from freebody.loops.assembly import assemble
from freebody.trees.kinematics import forward_kinematics

_CRANKS = {"theta1": 2.0, "theta2": 1.0}
"""Angles of the cranks from x, rad."""
_FRAMES = {"A": "crank1", "B": "distal1", "C": "crank2", "D": "distal2", "P": "P"}
"""The frame at each point of the figure."""


def five_bar() -> Figure:
    """Figure 2.2: A (-d/2, 0), C (d/2, 0), cranks AB and CD, bars BP and DP; lengths, and the
    vectors of (2.29)-(2.32)."""
    model = load("five_bar")
    q = assemble(model, _CRANKS, free=["B", "D"])
    places = {x: forward_kinematics(model, q, frame)[:2, 2] for x, frame in _FRAMES.items()}
    places["O"] = np.zeros(2)
    first = _robot(places, "(a) lengths and angles")
    _lengths(first, places)
    second = _robot(places, "(b) the vectors of the two limbs")
    for start, end in ("AB", "CD", "AP", "CP"):
        second.position(places[start], places[end], start + end)
    for drawing in (first, second):
        drawing.add(Label(point(places["P"]), "P(x, y)", "label P", direction=(0.0, 1.0)))
    to_one_scale((first, second))
    return Figure("A planar five-bar parallel robot", (first, second))


def _robot(places: dict[str, Array], note: str) -> Drawing:
    drawing = Drawing(FLAT, f"A planar five-bar robot: {note}")
    size = float(np.linalg.norm(places["P"] - places["A"]))
    axes(drawing, size, share=0.55)
    drawing.add(Label((0.0, 0.0), "O", "label O", direction=(0.7, -0.8)))
    for k, ends in enumerate(("AB", "CD", "BP", "DP"), 1):
        drawing.add(
            Line((point(places[ends[0]]), point(places[ends[1]])), f"link {k}", "link", width=10.0)
        )
    for name, way in (("A", (-1.0, 0.3)), ("C", (1.0, 0.3))):
        drawing.add(
            Mark(point(places[name]), "ground", f"ground {name}", "ground", (0.0, 1.0), 9.0)
        )
        drawing.add(Label(point(places[name]), name, f"label {name}", direction=way))
    for name, way in (("B", (-1.0, 0.4)), ("D", (1.0, 0.4))):
        drawing.add(Label(point(places[name]), name, f"label {name}", direction=way))
    for name in "ABCDP":
        drawing.add(Mark(point(places[name]), "joint", name, "joint", size=6.0))
    for crank, (name, turned) in enumerate(zip("AC", _CRANKS.values(), strict=True), 1):
        end = places[name] + np.array([0.3 * size, 0.0])
        drawing.add(Line((point(places[name]), point(end)), f"reference θ_{crank}", "guide"))
        drawing.add(
            Arc(point(places[name]), 0.16 * size, 0.0, turned, f"θ_{crank}", label=f"θ_{crank}")
        )
    drawing.notes = [note]
    return drawing


def _lengths(drawing: Drawing, places: dict[str, Array]) -> None:
    """Add the labels l_1 to l_4 outside the loop, and of both halves of the base."""
    for name, ends, aside in (
        ("l_1", "AB", 14.0),
        ("l_2", "CD", -14.0),
        ("l_3", "BP", 14.0),
        ("l_4", "DP", -14.0),
    ):
        drawing.add(
            Dimension(point(places[ends[0]]), point(places[ends[1]]), name, label=name, aside=aside)
        )
    for name, start, end in (("d/2 left", "A", "O"), ("d/2 right", "O", "C")):
        drawing.add(
            Dimension(point(places[start]), point(places[end]), name, label="d/2", aside=-36.0)
        )
