"""Figures 6.4 and 6.5: a link in space with all forces and moments on it, and a sliding joint."""

from __future__ import annotations

import numpy as np

from freebody.figures.drawing import Arrow, Drawing, Label, Line, Mark, point
from freebody.figures.figure import Figure
from freebody.figures.layers import structure
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import axonometric
from freebody.model.dh import dh
from freebody.model.model import Model


def link_symbols() -> Figure:
    """Figure 6.4: link i of an arm in space, between joints i and i+1, with every vector of the
    recursion."""
    seen = snapshot(
        _three_links(),
        (0.4, -0.5, 0.7),
        (0.7, 0.9, 0.8),
        (0.8, -1.2, 0.9),
        {"link3": [30.0, 20.0, -15.0, 25.0, 0.0, 5.0]},
    )
    before, body, after = seen.pose.bodies
    view = axonometric(-62.0, 16.0)
    drawing = Drawing(view, "Link i of an arm in space with the symbols of its dynamics")
    parts = [
        *_faint(before),
        *_faint(after),
        *structure.solids_of(body, 0.05, 11.0),
        *structure.joint(after, 0.05),
    ]
    drawing.add(*sorted(parts, key=lambda e: structure.depth(e, view)))
    _axis(drawing, body, "z_i", "θ\u0307_i", float(seen.qd[1]))
    _axis(drawing, after, "z_{i+1}", "θ\u0307_{i+1}", float(seen.qd[2]))
    drawing.add(Mark(point(body.com), "com", "C_i", "com", size=6.0))
    drawing.add(Label(point(body.com), "C_i", "label C_i", direction=(0.0, 0.0, 1.0)))
    drawing.arrow(
        body.origin,
        after.origin,
        "s_i",
        "position",
        after.origin - body.origin,
        "m",
        beside=0.5,
    )
    drawing.arrow(
        body.origin,
        body.com,
        "s_{ci}",
        "position",
        body.com - body.origin,
        "m",
        beside=0.5,
    )
    a = seen.acceleration_at(body, body.com)
    end = body.com + 0.42 * a / np.linalg.norm(a)
    drawing.arrow(body.com, end, "v\u0307_{ci}", "acceleration", a, "m/s²")
    _loads(drawing, seen, body)
    return Figure("Symbols for the dynamics of a link in space", (drawing,), 1, 600.0, 470.0)


def _three_links() -> Model:
    """A spatial arm whose second link has axes that are not parallel and a centre of mass off the
    line between them."""
    parts = {"I": [0.05, 0.0, 0.0, 0.05, 0.0, 0.05]}
    rows = [
        {"a": 0.0, "alpha": 0.0, "d": 0.35, "m": 3.0, "com": [0.0, 0.0, 0.0], **parts},
        {"a": 0.35, "alpha": 0.35, "d": 0.0, "m": 4.0, "com": [0.55, -0.14, 0.0], **parts},
        {"a": 1.1, "alpha": -0.5, "d": 0.0, "m": 2.5, "com": [0.4, 0.0, 0.1], **parts},
    ]
    return dh(rows, convention="modified")


def _faint(body: BodyPlace) -> list[Line]:
    return [Line((point(a), point(b)), f"link {body.number}", "ghost") for a, b in body.outline]


def _axis(drawing: Drawing, body: BodyPlace, name: str, rate: str, value: float) -> None:
    """Add a joint's axis with its unit vector, and the joint's rate along it."""
    if body.axis is None:
        return
    axis = body.axis
    drawing.add(
        Line((point(body.origin - 0.3 * axis), point(body.origin)), f"axis {name}", "axisline")
    )
    drawing.add(
        Arrow(point(body.origin), point(body.origin + 0.34 * axis), name, "z", name, point(axis))
    )
    start, end = body.origin + 0.4 * axis, body.origin + (0.4 + 0.14) * axis
    value_vector = value * axis
    drawing.add(
        Arrow(
            point(start), point(end), rate, "velocity", rate, point(value_vector), "rad/s", heads=2
        )
    )


def _loads(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Add the forces on a body, in one scale, and the moments as double-headed arrows, in
    another."""
    names = {
        "reaction": ("f_{i−1,i}", "n_{i−1,i}", "reaction"),
        "counter": ("−f_{i,i+1}", "−n_{i,i+1}", "reaction"),
        "weight": ("m_i g", "", "weight"),
    }
    loads = seen.loads[body.index].loads
    force = 0.6 / max(float(np.linalg.norm(acting.force)) for acting in loads)
    moment = 0.5 / max(float(np.linalg.norm(acting.moment)) for acting in loads)
    for acting in loads:
        name, turning, role = names[acting.role]
        end = acting.place + force * acting.force
        label = "m_i *g*" if acting.role == "weight" else None
        drawing.arrow(acting.place, end, name, role, acting.force, "N", label=label)
        if turning:
            end = acting.place + moment * acting.moment
            drawing.arrow(acting.place, end, turning, "moment", acting.moment, "N m", heads=2)


def slide() -> Figure:
    """Figure 6.5: a prismatic joint with frames i-1 and i, d_i along z_i, p^{i-1}_i, c_i, v_{i-1},
    v_ci."""
    parts = {"I": [0.05, 0.0, 0.0, 0.05, 0.0, 0.05]}
    rows = [
        {"a": 0.0, "alpha": 0.0, "d": 0.0, "m": 3.0, "com": [0.1, 0.0, 0.0], **parts},
        {"a": 0.6, "alpha": 0.25, "d": 0.2, "m": 3.0, "com": [0.1, 0.0, 0.0], **parts},
        {
            "joint": "P",
            "a": 0.6,
            "alpha": -1.2,
            "d": 0.0,
            "m": 2.0,
            "com": [0.3, 0.12, 0.2],
            **parts,
        },
    ]
    seen = snapshot(
        dh(rows, convention="modified"), (-0.4, 0.6, 0.75), (0.9, 0.5, 0.7), (0.0, 0.0, 0.0)
    )
    _, before, body = seen.pose.bodies
    view = axonometric(-35.0, 22.0)
    drawing = Drawing(view, "A prismatic joint with the frames of both links")
    parts = [
        Line((point(before.origin), point(body.carrier)), "link i−1", "link", width=9.0),
        Line((point(body.carrier), point(body.origin)), "rod i", "link", width=5.0),
        Line((point(body.origin), point(body.com)), "link i", "link", width=9.0),
        *structure.joint(body, 0.055), *structure.joint(before, 0.045),
    ]  # fmt: skip
    drawing.add(*sorted(parts, key=lambda e: structure.depth(e, view)))
    structure.triad(
        drawing, before.origin, before.rotation, 0.33, ("X_{i−1}", "Y_{i−1}", "Z_{i−1}")
    )
    structure.triad(drawing, body.origin, body.rotation, 0.3, ("X_i", "Y_i", "Z_i"))
    slid, how = body.origin - body.carrier, {"aside": 14.0, "beside": 0.5}
    drawing.arrow(body.carrier, body.origin, "d_i", "external", slid, "m", label="d_i", **how)
    drawing.arrow(
        before.origin,
        body.origin,
        "p^{i−1}_i",
        "position",
        body.origin - before.origin,
        "m",
        beside=0.5,
    )
    drawing.arrow(body.origin, body.com, "c_i", "position", body.com - body.origin, "m", beside=0.5)
    drawing.add(Mark(point(body.com), "com", "C_i", "com", size=6.0))
    drawing.add(Label(point(body.com), "C_i", "label C_i", direction=(0.0, 0.0, -1.0)))
    places = ((before, before.origin, "v_{i−1}"), (body, body.com, "v_{ci}"))
    speeds = [seen.velocity_at(link, place) for link, place, _ in places]
    scale = 0.5 / max(float(np.linalg.norm(v)) for v in speeds)
    for (_, place, name), v in zip(places, speeds, strict=True):
        drawing.arrow(place, place + scale * v, name, "velocity", v, "m/s")
    omega = seen.angular(before)
    end = before.origin + 0.5 * omega / np.linalg.norm(omega)
    drawing.arrow(before.origin, end, "ω_{i−1}", "velocity", omega, "rad/s", heads=2)
    return Figure("A prismatic joint", (drawing,), 1, 560.0, 440.0)
