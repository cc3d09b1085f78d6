"""Figures of plane bodies with an outline: pinned and loaded (1.5), and the three kinds of motion
(5.1)."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arrow, Drawing, Label, Line, Mark, Turn, point
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.layers.bare_robot import axes
from freebody.figures.marked_text import bold
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT
from freebody.model.model import Model
from freebody.model.planar_arms import planar

_REACH = 0.32  # metres: the longest arrow
_OUTLINE = (
    (-0.16, 0.0),
    (0.0, 0.17),
    (0.35, 0.21),
    (0.75, 0.28),
    (1.12, 0.12),
    (1.02, -0.2),
    (0.55, -0.19),
    (0.1, -0.14),
)


def outline(body: BodyPlace, corners: Array) -> Line:
    """A smooth closed curve around a body through places given in its axes (k, 2), metres."""
    smooth = _rounded(np.asarray(corners, dtype=float))
    return Line(
        tuple(point(body.origin + body.rotation @ p) for p in smooth), "body", "solid", closed=True
    )


def _rounded(corners: Array) -> Array:
    """Rounded corners of a closed polygon, by Chaikin's corner cutting."""
    for _ in range(5):
        after = np.roll(corners, -1, axis=0)
        corners = np.stack(
            [0.75 * corners + 0.25 * after, 0.25 * corners + 0.75 * after], axis=1
        ).reshape(-1, 2)
    return corners


def pinned(seen: Snapshot, note: str, answered: bool) -> Drawing:
    """Drawing of a body on a pin at O with the force F; answered: with the pin's reaction f, a_G
    and α too."""
    body, drawing = (
        seen.pose.bodies[0],
        Drawing(FLAT, f"A body rotating about a fixed axis: {note}"),
    )
    drawing.add(outline(body, np.array(_OUTLINE)))
    drawing.add(Mark((0.0, 0.0), "ground", "ground", "ground", (0.0, 1.0), 9.0))
    drawing.add(Mark((0.0, 0.0), "joint", "O", "joint", size=6.0))
    drawing.add(Label((0.0, 0.0), "O", "label O", direction=(1.0, -0.4)))
    drawing.add(Mark(point(body.com), "com", "G", "com", size=7.0))
    drawing.add(Label(point(body.com), "G", "label G", direction=(0.6, -1.0)))
    forces = {load.role: load for load in seen.loads[0].loads}
    longest = max(float(np.linalg.norm(load.force)) for load in forces.values())
    for role, name, css in (("external", "F", "external"), ("reaction", "f", "reaction")):
        load = forces[role]
        if role == "external" or answered:
            end = load.place + 1.4 * _REACH * load.force / longest
            drawing.add(
                Arrow(point(load.place), point(end), name, css, bold(name), point(load.force), "N")
            )
    if answered:
        a = seen.acceleration_at(body, body.com)
        end = body.com + _REACH * a / np.linalg.norm(a)
        drawing.add(
            Arrow(point(body.com), point(end), "a_G", "acceleration", "*a*_{G}", point(a), "m/s²")
        )
        alpha = float(seen.qdd[0])
        drawing.add(Turn((0.0, 0.0), alpha, "α", "acceleration", "α", "rad/s²", 26.0, 150.0, 130.0))
    drawing.notes = [note]
    return drawing


def motions() -> Figure:
    """Figure 5.1: a body in translation, in rotation about a fixed axis, and in general motion,
    with velocities of its points."""
    quarter = np.pi / 2
    sliding, turning = _last("PP", [0.0, quarter]), _last("R", [0.0])
    moving = _last("PPR", [0.0, quarter, -quarter])
    drawings = (
        _moving(sliding, [0.5, 0.3], [1.0, 0.45], "translation", -1.2),
        _moving(turning, [0.6], [1.0], "rotation about a fixed axis", 0.0),
        _moving(moving, [0.45, 0.25, 0.5], [0.5, 0.45, 0.7], "general motion", 0.0),
    )
    for letter, drawing in zip("abc", drawings, strict=True):
        drawing.notes = [f"({letter}) {drawing.notes[0]}"]
    to_one_scale(drawings, 330.0, 330.0)
    return Figure("Three types of rigid-body motion", drawings, 3, 330.0, 330.0)


def _last(word: str, angles: list[float]) -> Model:
    """A planar arm whose last body alone has mass and length; word: the joint types."""
    before = [0.0] * (len(word) - 1)
    return planar(
        word, angles=angles, l=[*before, 1.0], lc=[*before, 0.5], m=[*before, 1.0], I=[*before, 0.1]
    )


def _moving(model: Model, q: list[float], qd: list[float], kind: str, turned: float) -> Drawing:
    """Drawing of a body on the last joint of a model, with the velocities of some of its points."""
    seen = snapshot(model, q, qd, [0.0] * model.nv)
    body, drawing = seen.pose.bodies[-1], Drawing(FLAT, f"A body in {kind}")
    axes(drawing, 1.0, share=0.4)
    c, s = np.cos(turned), np.sin(turned)
    shape = np.array(_OUTLINE) @ np.array([[c, s], [-s, c]])
    centre = shape.mean(axis=0)
    drawing.add(outline(body, shape))
    places = {"G": centre, "1": shape[2], "2": shape[4]}
    found = {k: body.origin + body.rotation @ p for k, p in places.items()}
    speeds = {k: seen.velocity_at(body, p) for k, p in found.items()}
    names = {"G": "v" if kind == "translation" else "v_G", "1": "v_1", "2": "v_2"}
    scale = 0.5 / max(float(np.linalg.norm(v)) for v in speeds.values())
    for k, place in found.items():
        v, name = speeds[k], names[k]
        label = bold(name) if k == "G" else ""
        drawing.add(
            Arrow(point(place), point(place + scale * v), name, "velocity", label, point(v), "m/s")
        )
        drawing.add(
            Mark(
                point(place),
                "com" if k == "G" else "dot",
                k,
                "position-head",
                size=6.0 if k == "G" else 3.0,
            )
        )
    drawing.add(Label(point(found["G"]), "G", "label G", direction=(0.4, -1.0)))
    omega = float(seen.angular(body)[0])
    if kind.startswith("rotation"):
        drawing.add(Mark(point(body.origin), "joint", "axis", "joint", size=6.0))
        drawing.add(Label(point(body.origin), "O", "label O", direction=(-1.0, 1.0)))
    if omega:
        at = body.origin if kind.startswith("rotation") else found["G"]
        drawing.add(Turn(point(at), omega, "ω", "velocity", "ω", "rad/s", 24.0, -80.0, 150.0))
    drawing.notes = [kind]
    return drawing
