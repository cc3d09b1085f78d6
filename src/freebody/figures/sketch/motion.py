"""How a planar arm moves: joint rates as turning arrows, velocities and accelerations of its
centres of mass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arrow, Drawing, Turn, point
from freebody.figures.names import Names, bold
from freebody.figures.plane import round_down
from freebody.figures.sketch.arm import clear_way
from freebody.figures.sketch.snapshot import Snapshot
from freebody.figures.text import number

LONGEST = 0.34
"""The longest velocity or acceleration, of the drawing's size."""


def rates(drawing: Drawing, seen: Snapshot, names: Names, second: bool = False) -> None:
    """θ̇_i around the joints, ḋ_i along the slides; and θ̈_i, d̈_i."""
    orders = [(1, seen.qd, "velocity", "/s")]
    if second:
        orders.append((2, seen.qdd, "acceleration", "/s²"))
    for body, at in zip(seen.pose.bodies, seen.model.coordinates, strict=True):
        for k, (order, values, role, per) in enumerate(orders):
            name = names.coordinate(body, order)
            if len(at.v) != 1 or not name:
                continue
            value = float(values[at.v[0]])
            if body.kind.slides and body.axis is not None:
                end = body.origin + 0.16 * seen.size * math.copysign(1.0, value) * body.axis
                aside = -16.0 - 14.0 * k
                arrow = Arrow(
                    point(body.origin),
                    point(end),
                    name,
                    role,
                    name,
                    (value,),
                    "m" + per,
                    aside=aside,
                )
                drawing.add(arrow)
            else:
                u, v = clear_way(seen, body)
                away, radius = math.degrees(math.atan2(v, u)), 18.0 + 9.0 * k
                drawing.add(
                    Turn(
                        point(body.origin),
                        value,
                        name,
                        role,
                        name,
                        "rad" + per,
                        radius,
                        away,
                        150.0,
                    )
                )


def of_tip(drawing: Drawing, seen: Snapshot, name: str, second: bool = False) -> None:
    """The velocity of the tip, or its acceleration."""
    if seen.pose.tip is None or seen.model.frame().body < 0:
        return
    moving = seen.acceleration_at if second else seen.velocity_at
    found = moving(seen.pose.bodies[seen.model.frame().body], seen.pose.tip)
    role, unit = ("acceleration", "m/s²") if second else ("velocity", "m/s")
    arrows(drawing, [seen.pose.tip], [found], [name], role, unit, seen.size, scaled=False)


def of_centres(drawing: Drawing, seen: Snapshot, names: Names, scaled: bool = False) -> None:
    """v_ci at the centres of mass, all to one scale."""
    bodies = [body for body in seen.pose.bodies if body.mass > 0]
    found = [seen.velocity_at(body, body.com) for body in bodies]
    labels = [names.on("v", body.number, "c") for body in bodies]
    arrows(drawing, [b.com for b in bodies], found, labels, "velocity", "m/s", seen.size, scaled)


def partial_of_centres(drawing: Drawing, seen: Snapshot, joint: int) -> None:
    """v_ci,r: velocities of the centres of mass when joint r alone moves, at the rate 1; joints
    count from 1."""
    alone = replace(seen, qd=np.eye(seen.model.nv)[seen.model.coordinates[joint - 1].v[0]])
    bodies = [body for body in seen.pose.bodies if body.mass > 0]
    found = [alone.velocity_at(body, body.com) for body in bodies]
    labels = [f"v_{{c{body.number},{joint}}}" for body in bodies]
    arrows(
        drawing, [b.com for b in bodies], found, labels, "velocity", "m/s", seen.size, scaled=False
    )


def second_of_centres(drawing: Drawing, seen: Snapshot, names: Names, scaled: bool = False) -> None:
    """v̇_ci at the centres of mass, all to one scale."""
    bodies = [body for body in seen.pose.bodies if body.mass > 0]
    found = [seen.acceleration_at(body, body.com) for body in bodies]
    labels = [names.on("v\u0307", body.number, "c") for body in bodies]
    arrows(
        drawing, [b.com for b in bodies], found, labels, "acceleration", "m/s²", seen.size, scaled
    )


def arrows(
    drawing: Drawing,
    places: Sequence[Array],
    values: Sequence[Array],
    labels: Sequence[str],
    role: str,
    unit: str,
    size: float,
    scaled: bool = True,
) -> None:
    """Vectors from their places, the longest a third of the drawing's size; scaled: with a bar that
    says how long."""
    longest = max((float(np.linalg.norm(v)) for v in values), default=0.0)
    if not longest:
        return
    scale = LONGEST * size / longest
    for place, value, name in zip(places, values, labels, strict=True):
        if np.linalg.norm(value) > 1e-6 * longest:
            end = place + scale * value
            drawing.add(Arrow(point(place), point(end), name, role, bold(name), point(value), unit))
    if scaled:
        bar = round_down(longest / 2.0)
        drawing.rulers.append((bar * scale, f"{number(bar, 1)} {unit}", role))
