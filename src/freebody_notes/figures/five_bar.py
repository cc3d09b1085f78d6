"""Figure 2.2: the planar parallel robot with five bars, closed at P for the cranks' angles."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.figures.drawing import Arc, Dimension, Drawing, Label, Line, Mark, point
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.layers.structure import axes
from freebody.figures.view import FLAT
from freebody.formats.loading import load
from freebody.outputs.number_text import compared


def five_bar(
    lengths: Sequence[float] | None = None,
    base: float | None = None,
    angles: Sequence[float] = (2.0, 1.0),
    assembly: int = 1,
) -> Figure:
    """Figure 2.2: A (-d/2, 0), C (d/2, 0), cranks AB and CD, bars BP and DP; lengths, and the
    vectors of (2.29)-(2.32).

    lengths: l1 (AB), l2 (CD), l3 (BP), l4 (DP), m, and base: d, m; default: those of the bundled
    five_bar. angles: of the cranks from x, rad. assembly: 1 for P left of the line from B to D, -1
    for the other side. Raises FreebodyError where the bars do not meet.
    """
    known = load("five_bar").parameters
    chosen = [known[f"l{k}"] or 0.0 for k in range(1, 5)] if lengths is None else lengths
    places = closed(chosen, 2 * (known["b"] or 0.0) if base is None else base, angles, assembly)
    first = _robot(places, angles, "(a) lengths and angles")
    _lengths(first, places)
    second = _robot(places, angles, "(b) the vectors of the two limbs")
    for start, end in ("AB", "CD", "AP", "CP"):
        second.position(places[start], places[end], start + end)
    for drawing in (first, second):
        drawing.add(Label(point(places["P"]), "P(x, y)", "label P", direction=(0.0, 1.0)))
    to_one_scale((first, second))
    return Figure("A planar five-bar parallel robot", (first, second))


def closed(
    lengths: Sequence[float], base: float, angles: Sequence[float], assembly: int = 1
) -> dict[str, Array]:
    """Places of O, A, B, C, D and P (2,) for the cranks' angles; P is where the circles about B and
    D meet."""
    l1, l2, l3, l4 = lengths
    A, C = np.array([-base / 2, 0.0]), np.array([base / 2, 0.0])
    B = A + l1 * np.array([math.cos(angles[0]), math.sin(angles[0])])
    D = C + l2 * np.array([math.cos(angles[1]), math.sin(angles[1])])
    across = D - B
    distance = float(np.linalg.norm(across))
    if not abs(l3 - l4) <= distance <= l3 + l4 or not distance:
        given, least, most = compared(distance, abs(l3 - l4), l3 + l4)
        raise FreebodyError(
            f"five_bar: B and D are {given} m apart; bars of {l3:g} m and {l4:g} m meet only if "
            f"the distance is from {least} m to {most} m. Choose other crank angles."
        )
    along = (l3**2 - l4**2 + distance**2) / (2 * distance)
    height = math.sqrt(max(l3**2 - along**2, 0.0))
    u = across / distance
    P = B + along * u + assembly * height * np.array([-u[1], u[0]])
    return {"O": np.zeros(2), "A": A, "B": B, "C": C, "D": D, "P": P}


def _robot(places: dict[str, Array], angles: Sequence[float], note: str) -> Drawing:
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
    for crank, (name, turned) in enumerate(zip("AC", angles, strict=True), 1):
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
