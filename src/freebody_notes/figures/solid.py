"""Figure 6.1: a free body in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.any_chain.dynamics import forward_dynamics
from freebody.figures.drawing import Drawing, Label, Line, Mark, point
from freebody.figures.figure import Figure
from freebody.figures.layers import bare_robot
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import snapshot
from freebody.figures.view import View, axonometric
from freebody.formats.loading import load

_POSE = (0.2, 1.5, 0.75, 0.93, 0.12, -0.12, 0.28)  # x, y, z (m), quaternion w, x, y, z
_RATES = (0.1, 0.7, -0.35, -0.1, -0.35, 0.6)  # v (m/s), ω (rad/s), body axes
_FORCE = (4.0, 6.0, 6.0)  # N, world axes


def free_body() -> Figure:
    """Figure 6.1: one body in space with its frame x_i y_i z_i at the centre of mass, r, v_c and
    its rate, ω, f at the middle of a face, and n_i, the moment of f about the centre of mass; there
    is no weight."""
    model = load("quadrotor").replace(gravity=0.0, name="body")
    unit = np.array(_POSE)
    unit[3:] /= np.linalg.norm(unit[3:])
    wrench = {"rotor2": np.array([*_FORCE, 0.0, 0.0, 0.0])}
    qdd = forward_dynamics(model, unit, _RATES, np.zeros(6), wrenches=wrench)
    seen = snapshot(model, unit, _RATES, qdd, wrench)
    body, load_ = seen.pose.bodies[0], next(x for x in seen.loads[0].loads if x.role == "external")
    view = axonometric(24.0, 18.0)
    drawing = Drawing(view, "A free body in space with global and body-fixed frames")
    bare_robot.triad(drawing, np.zeros(3), np.eye(3), 0.75, ("X", "Y", "Z"))
    drawing.add(*_box(body, (0.42, 0.5, 0.26), view))
    drawing.position(np.zeros(3), body.com, "r")
    bare_robot.triad(drawing, body.com, body.rotation, 0.8, ("x_i", "y_i", "z_i"))
    drawing.add(Mark(point(body.com), "com", "C", "com", size=6.0))
    drawing.add(Label(point(body.com), "C", "label C", direction=(0.0, 0.0, -1.0)))
    a = seen.acceleration_at(body, body.com)
    turning = np.cross(load_.place - body.com, load_.force)
    for start, value, name, role, unit_name, reach, heads in (
        (body.com, seen.velocity_at(body, body.com), "v_c", "velocity", "m/s", 0.7, 1),
        (body.com, a, "v\u0307_c", "acceleration", "m/s²", 0.6, 1),
        (load_.place, load_.force, "f", "reaction", "N", 0.8, 1),
        (body.com, seen.angular(body), "ω", "velocity", "rad/s", 0.95, 2),
        (body.com, turning, "n_i", "moment", "N m", 0.85, 2),
    ):
        way = value / np.linalg.norm(value)
        drawing.arrow(start, start + reach * way, name, role, value, unit_name, heads=heads)
    return Figure(
        "A rigid body in space with global and body-fixed frames", (drawing,), 1, 520.0, 430.0
    )


def _box(body: BodyPlace, half: Sequence[float], view: View) -> list[Line]:
    """The visible faces of a box around a body; half: half the edge lengths along the body's axes,
    metres."""
    faces = []
    for k in range(3):
        for sign in (-1.0, 1.0):
            normal = sign * body.rotation[:, k]
            if normal @ np.asarray(view.towards) > 0:
                u, v = (half[j] * body.rotation[:, j] for j in ((k + 1) % 3, (k + 2) % 3))
                middle = body.com + half[k] * normal
                corners = [middle + a * u + b * v for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
                faces.append(Line(tuple(map(point, corners)), "body", "solid", closed=True))
    return faces
