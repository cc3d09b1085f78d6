"""Figures 4.1 and 4.2: velocities from link to link, and one link among its neighbours."""

from __future__ import annotations

import math

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arc, Drawing, Label, Line, Mark, Turn, point
from freebody.figures.figure import Figure
from freebody.figures.layers import bare_robot, forces, measures
from freebody.figures.layers.measures import BESIDE
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT
from freebody.model.planar_arms import planar
from freebody_notes.figures.pattern_names import called

_INDICES = {1: "i−2", 2: "i−1", 3: "i", 4: "i+1"}


def relative_velocity() -> Figure:
    """Figure 4.1: links O-B and B-A with their angles and rates; v_A = v_B + ω × s, drawn to
    scale."""
    model = planar("RR", l=[1.0, 0.9], lc=[0.5, 0.45], m=[1.0, 1.0], I=[0.1, 0.1])
    seen = called(
        snapshot(model, (0.45, 0.6), (0.8, 0.7), [0.0, 0.0]),
        index=lambda n: "0" if n == 1 else "",
        letters=lambda n: "O" if n == 1 else "B",
        tip="A",
    )
    return Figure("Velocities of two points of a link", (_two_rates(seen), _construction(seen)))


def _two_rates(seen: Snapshot) -> Drawing:
    drawing = Drawing(FLAT, "Two links with their angular velocities")
    bare_robot.structure(drawing, seen)
    measures.angles(drawing, seen)
    first, second = seen.pose.bodies
    drawing.position(second.origin, _tip(seen), "s", -BESIDE)
    scale = _speed_scale(seen)
    _speed(drawing, seen, second, second.origin, "v_B", scale)
    _speed(drawing, seen, second, _tip(seen), "v_A", scale)
    for body, name in ((first, "ω_0"), (second, "ω")):
        _turning(drawing, seen, body, name)
    drawing.notes = ["(a) angles and rates"]
    return drawing


def _construction(seen: Snapshot) -> Drawing:
    """Drawing of link B-A alone with v_B at both ends, ω × s added to it at A, and their sum
    v_A."""
    drawing = Drawing(FLAT, "v_A as the sum of v_B and ω × s")
    body, tip, scale = seen.pose.bodies[1], _tip(seen), _speed_scale(seen)
    bare_robot.axes(drawing, seen.size)
    drawing.add(*bare_robot.link(body))
    for place, name, way in ((body.origin, "B", (1.0, -0.6)), (tip, "A", (1.0, 0.3))):
        drawing.add(Mark(point(place), "joint", name, "joint", size=6.0))
        drawing.add(Label(point(place), name, f"label {name}", direction=way))
    drawing.position(np.zeros(2), body.origin, "r")
    drawing.position(body.origin, tip, "s", -BESIDE)
    v_b, v_a = (seen.velocity_at(body, place) for place in (body.origin, tip))
    middle = tip + scale * v_b
    _speed(drawing, seen, body, body.origin, "v_B", scale)
    drawing.arrow(tip, middle, "v_B at A", "inertia", v_b, "m/s", label="*v*_B", beside=0.5)
    end, turned = middle + scale * (v_a - v_b), "*ω* × *s*"
    drawing.arrow(middle, end, "ω × s", "velocity", v_a - v_b, "m/s", label=turned, beside=0.5)
    _speed(drawing, seen, body, tip, "v_A", scale)
    _turning(drawing, seen, body, "ω")
    _inclination(drawing, seen, body)
    drawing.notes = ["(b) the velocities of B and A"]
    return drawing


def _inclination(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Add the angle φ from the x axis to the vector s."""
    reach = 0.15 * seen.size
    end = body.origin + np.array([1.6 * reach, 0.0])
    drawing.add(Line((point(body.origin), point(end)), "reference φ", "guide"))
    along = seen.heading(body)
    drawing.add(Arc(point(body.origin), reach, 0.0, math.atan2(along[1], along[0]), "φ", label="φ"))


def _tip(seen: Snapshot) -> Array:
    if seen.pose.tip is None:
        raise ValueError("an arm with a tip is needed")
    return seen.pose.tip


def _speed_scale(seen: Snapshot) -> float:
    v = seen.velocity_at(seen.pose.bodies[1], _tip(seen))
    return 0.38 * seen.size / float(np.linalg.norm(v))


def _speed(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, place: Array, name: str, scale: float
) -> None:
    v = seen.velocity_at(body, place)
    drawing.arrow(place, place + scale * v, name, "velocity", v, "m/s")


def _turning(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, name: str, share: float = 0.5
) -> None:
    """Add the angular velocity arrow of a body, drawn on its left side, around the point at a
    fraction `share` of its length."""
    end, along = seen.end(body), seen.heading(body)
    at = body.origin + share * ((body.com if end is None else end) - body.origin)
    left, value = math.degrees(math.atan2(along[0], -along[1])), float(seen.angular(body)[0])
    drawing.add(Turn(point(at), value, name, "velocity", name, "rad/s", 24.0, left, 140.0))


def one_of_many() -> Figure:
    """Figure 4.2: link i between links i-1 and i+1, with all vectors of the planar recursion."""
    n = 4
    model = planar(
        "R" * n, l=[0.7, 0.9, 1.1, 0.8], lc=[0.3, 0.45, 0.6, 0.4], m=[2.0] * n, I=[0.15] * n
    )
    seen = snapshot(
        model.replace(gravity=0.0),
        (-0.5, 0.7, 0.75, -0.9),
        (0.5, 0.3, 0.4, 0.3),
        (0.5, 0.9, -3.0, 0.2),
    )
    seen = called(seen, index=lambda n: _INDICES[n], letters=lambda n: "·ABC"[n - 1], moment="M")
    drawing = Drawing(FLAT, "Link i of a planar arm with the forces on it")
    before, body, after = seen.pose.bodies[1:4]
    for link in (before, after):
        name = f"link {_INDICES[link.number]}"
        drawing.add(
            *(
                Line((point(a), point(b)), name, "link", width=9.0, far=True)
                for a, b in link.outline
            )
        )
    drawing.add(*bare_robot.link(body))
    for link in (before, body, after):
        drawing.add(*bare_robot.joint(link))
        name = seen.names.point(seen.pose, link.number)
        drawing.add(Label(point(link.origin), name, f"label {name}", direction=(0.7, -1.0)))
    drawing.add(Mark(point(body.com), "com", "C_i", "com", size=6.0))
    drawing.add(Label(point(body.com), "C_i", "label C_i", direction=(0.5, -1.0)))
    drawing.position(before.origin, body.origin, "s_{i−1}", -BESIDE)
    drawing.position(body.origin, after.origin, "s_i", -BESIDE - 6)
    drawing.position(body.origin, body.com, "s_{ci}", BESIDE)
    speeds = [seen.velocity_at(link, link.origin) for link in (before, body)]
    scale = 0.2 * seen.size / max(float(np.linalg.norm(v)) for v in speeds)
    _speed(drawing, seen, before, before.origin, "v_{i−1}", scale)
    _speed(drawing, seen, body, body.origin, "v_i", scale)
    a = seen.acceleration_at(body, body.com)
    end = body.com + 0.2 * seen.size * a / np.linalg.norm(a)
    drawing.arrow(body.com, end, "v\u0307_{ci}", "acceleration", a, "m/s²")
    _turning(drawing, seen, body, "ω_i", 0.78)
    forces.act(drawing, seen, body, ("reaction", "counter"))
    return Figure("Forces on a single body", (drawing,), 1, 560.0, 460.0)
