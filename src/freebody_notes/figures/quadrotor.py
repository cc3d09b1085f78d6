"""Figure 6.3: the bundled quadrotor, its frames and rotors, its thrusts, weight and velocity."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Drawing, Element, Label, Line, Mark, Prism, point
from freebody.figures.figure import Figure
from freebody.figures.layers import bare_robot
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import View, axonometric
from freebody.formats.loading import load

_EULER = (math.pi / 4, 0.1, 0.2)  # Z-X-Z, rad
_THRUSTS = (3.2, 1.4, 2.5, 3.6)  # along the body's z, N
_PLACE, _VELOCITY = (0.75, 0.75, 0.6), (0.5, 0.9, 0.5)  # of O, world axes, m and m/s
_RADIUS = 0.19


def quadrotor() -> Figure:
    """Figure 6.3: (a) the vehicle; (b) frames XYZ and xyz, rotors A to D, s_1; (c) F_1 to F_4 along
    body z, m g, v."""
    rotation = zxz(_EULER)
    model = load("quadrotor")
    q = [*_PLACE, *_quaternion(rotation)]
    wrenches = {
        f"rotor{k}": [*(rotation[:, 2] * f), 0.0, 0.0, 0.0] for k, f in enumerate(_THRUSTS, 1)
    }
    qd = [*(rotation.T @ np.asarray(_VELOCITY)), 0.0, 0.0, 0.0]
    seen = snapshot(model, q, qd, np.zeros(6), wrenches)
    view = axonometric(-75.0, 26.0)
    first = _vehicle(seen, view, "(a) the vehicle")
    second = _vehicle(seen, view, "(b) frames and rotors")
    _frames(second, seen)
    third = _vehicle(seen, view, "(c) forces and velocity")
    _forces(third, seen, np.asarray(_THRUSTS))
    return Figure("A quadrotor", (first, second, third), 3, 360.0, 360.0)


def zxz(angles: Sequence[float]) -> Array:
    """The rotation Rz(a) Rx(b) Rz(c) (6.8)."""

    def turned(k: int, angle: float) -> Array:
        c, s = math.cos(angle), math.sin(angle)
        R = np.eye(3)
        i, j = (k + 1) % 3, (k + 2) % 3
        R[i, i] = R[j, j] = c
        R[i, j], R[j, i] = -s, s
        return R

    return turned(2, angles[0]) @ turned(0, angles[1]) @ turned(2, angles[2])


def _quaternion(R: Array) -> tuple[float, ...]:
    """The quaternion w, x, y, z of a rotation matrix by less than half a turn."""
    w = math.sqrt(max(1.0 + np.trace(R), 1e-12)) / 2
    return (
        w,
        *(
            (R[2, 1] - R[1, 2]) / (4 * w),
            (R[0, 2] - R[2, 0]) / (4 * w),
            (R[1, 0] - R[0, 1]) / (4 * w),
        ),
    )


def _rotors(seen: Snapshot) -> list[Array]:
    """Positions of the rotors, from the model's frames."""
    body = seen.pose.bodies[0]
    local = [seen.model.tree.frames[f"rotor{k}"][2] for k in (1, 2, 3, 4)]
    return [body.origin + body.rotation @ np.asarray(p, dtype=float) for p in local]


def _vehicle(seen: Snapshot, view: View, note: str) -> Drawing:
    drawing = Drawing(view, f"A quadrotor: {note}")
    body = seen.pose.bodies[0]
    up = body.rotation[:, 2]
    parts: list[Element] = []
    for k, place in enumerate(_rotors(seen), 1):
        parts.append(Line((point(body.origin), point(place)), f"arm {k}", "link", width=7.0))
        parts.append(
            Prism(point(place + 0.03 * up), point(up), _RADIUS, 0.012, f"rotor {k}", "joint", 36)
        )
    parts.append(Prism(point(body.origin), point(up), 0.12, 0.05, "hull", "joint", 4))
    drawing.add(*sorted(parts, key=lambda e: bare_robot.depth(e, view)))
    drawing.notes = [note]
    return drawing


def _frames(drawing: Drawing, seen: Snapshot) -> None:
    body = seen.pose.bodies[0]
    bare_robot.triad(drawing, np.zeros(3), np.eye(3), 0.45, ("X", "Y", "Z"))
    bare_robot.triad(drawing, body.origin, body.rotation, 0.85, ("x", "y", "z"))
    drawing.add(Label(point(body.origin), "O", "O", direction=(0.0, 0.0, -1.0)))
    for letter, place in zip("ABCD", _rotors(seen), strict=True):
        drawing.add(Mark(point(place), "dot", f"rotor {letter}", "position-head", size=2.5))
        drawing.add(Label(point(place), letter, letter, direction=point(place - body.origin)))
    first = _rotors(seen)[0]
    drawing.arrow(body.origin, first, "s_1", "position", first - body.origin, "m", beside=0.5)


def _forces(drawing: Drawing, seen: Snapshot, thrusts: Array) -> None:
    """Add the thrusts, drawn to one scale, and the weight, several times as large, to another."""
    body = seen.pose.bodies[0]
    up = body.rotation[:, 2]
    scale = 0.7 / thrusts.max()
    for k, (place, thrust) in enumerate(zip(_rotors(seen), thrusts, strict=True), 1):
        value = thrust * up
        drawing.arrow(place, place + scale * value, f"F_{k}", "external", value, "N")
    weight = body.mass * seen.model.gravity
    end = body.com + 0.7 * weight / np.linalg.norm(weight)
    drawing.arrow(body.com, end, "m g", "weight", weight, "N", label="m *g*")
    v = seen.velocity_at(body, body.com)
    drawing.arrow(body.com, body.com + 0.55 * v / np.linalg.norm(v), "v", "velocity", v, "m/s")
    drawing.add(Mark(point(body.com), "com", "C", "com", size=5.0))
    bar = float(thrusts.max()) / 2
    drawing.ruler(bar, bar * scale, "N (thrust)", "external")
