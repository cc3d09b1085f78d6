"""Figures of chapter 1 without an arm: a trajectory, and the centre of mass of particles."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from freebody.arrays import Array
from freebody.figures.drawing import Arrow, Drawing, Label, Line, Mark, point
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.layers.bare_robot import axes
from freebody.figures.marked_text import bold
from freebody.figures.view import FLAT

_X, _Y = (0.8, 2.6), (1.0, 3.4, -1.5)
"""Coefficients of t^0, t^1, … of the coordinates of a point (m)."""
_MASSES = (2.0, 1.0, 1.5, 2.5, 1.0)  # kg
_PLACES = ((0.6, 1.6), (1.3, 2.3), (2.2, 0.2), (3.2, 1.7), (3.3, 0.9))  # m


def trajectory() -> Figure:
    """Figure 1.1: a curve with r(t) and, along its tangent, v(t), at one time."""
    curve, at, until = (Polynomial(_X), Polynomial(_Y)), 0.8, 2.0  # s
    here, v, a = (np.array([c.deriv(k)(at) for c in curve]) for k in range(3))
    drawing = Drawing(FLAT, "Planar trajectory and velocity")
    track = tuple(point(c(t) for c in curve) for t in np.linspace(0.0, until, 80))
    size = float(np.ptp(np.array(track), axis=0).max())
    axes(drawing, size, share=0.9)
    drawing.add(Line(track, "Γ", "curveline"), Label(track[-1], "Γ", "label Γ"))
    drawing.position(np.zeros(2), here, "r(t)")
    scale = 0.45 * size / float(np.linalg.norm(v))
    _vector(drawing, here, v, scale, "v(t)", "velocity", "m/s")
    _vector(drawing, here, a, 0.6 * scale, "a(t)", "acceleration", "m/s²")
    drawing.add(Mark(point(here), "dot", "P", "position-head", size=4.0))
    drawing.add(Label(point(here), "P", "label P", direction=(0.3, -1.0)))
    return Figure("Planar trajectory and velocity", (drawing,), 1)


def _vector(
    drawing: Drawing, at: Array, value: Array, scale: float, name: str, role: str, unit: str
) -> None:
    drawing.add(
        Arrow(point(at), point(at + scale * value), name, role, bold(name), point(value), unit)
    )


def centre_of_mass() -> Figure:
    """Figure 1.3: particles with r_i and their centre r_G; the same from G, ρ_i."""
    m, r = np.array(_MASSES), np.array(_PLACES)
    centre = m @ r / m.sum()
    first = _cloud(m, r, "O", "r", "(a) from any origin O")
    first.position(np.zeros(2), centre, "r_{G}")
    first.add(
        Mark(point(centre), "com", "G", "com", size=7.0), Label(point(centre), "G", "label G")
    )
    second = _cloud(m, r - centre, "G", "ρ", "(b) from the centre of mass G")
    second.add(Mark((0.0, 0.0), "com", "G", "com", size=7.0))
    to_one_scale((first, second))
    return Figure("Determination of the centre of mass", (first, second))


def _cloud(masses: Array, places: Array, origin: str, letter: str, note: str) -> Drawing:
    """Drawing of particles with vectors from the origin; the area of each is proportional to its
    mass."""
    drawing = Drawing(FLAT, f"Particles and their centre of mass {note}")
    size = float(np.ptp(places, axis=0).max())
    axes(drawing, size, share=0.45)
    if origin != "G":
        drawing.add(Mark((0.0, 0.0), "dot", origin, "position-head", size=2.5))
    drawing.add(Label((0.0, 0.0), origin, f"label {origin}", direction=(-1.0, -1.0)))
    for k, (mass, place) in enumerate(zip(masses, places, strict=True), 1):
        name = f"{letter}_{k}"
        drawing.add(
            Arrow(
                (0.0, 0.0), point(place), name, "soft", bold(name), point(place), "m", beside=0.75
            )
        )
        radius = 6.0 * float(np.sqrt(mass / masses.mean()))
        drawing.add(Mark(point(place), "joint", f"m_{k}", "joint", size=radius))
        drawing.add(Label(point(place), f"m_{k}", f"label m_{k}", direction=point(place)))
    drawing.notes = [note]
    return drawing
