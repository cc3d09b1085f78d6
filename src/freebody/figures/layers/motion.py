"""Layers that show how a robot moves: joint rates as turning arrows, velocities and accelerations
of its tip and its centres of mass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Drawing, Turn, point
from freebody.figures.layers.structure import clear_way, of_each
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

LONGEST = 0.34
"""The longest velocity or acceleration, of the drawing's size."""
_ORDERS = (("velocity", "/s", ""), ("acceleration", "/s²", "\u0307"))
"""Velocities and accelerations: the role of their arrows, what follows the unit, the dots on v."""


@of_each
def rates(drawing: Drawing, seen: Snapshot, body: BodyPlace, second: bool = False) -> None:
    """Draw joint rates, θ̇_i around turning joints and ḋ_i along slides; second: accelerations θ̈_i
    and d̈_i as well."""
    at = seen.model.coordinates[body.index].v
    for k, values in enumerate((seen.qd, seen.qdd)[: 2 if second else 1]):
        (role, per, _), name = _ORDERS[k], seen.names.coordinate(body, k + 1)
        if len(at) != 1 or not name:
            continue
        value = float(values[at[0]])
        slides = body.kind.slides
        unit = ("m" if slides else "rad") + per
        if body.axis is not None:  # of a turn in space a vector with two heads, beyond that of z_i
            start = body.origin + (0.0 if slides else 0.2 + 0.12 * k) * seen.size * body.axis
            end = start + math.copysign(0.16 if slides else 0.1, value) * seen.size * body.axis
            how = {"aside": -16.0 - 14.0 * k} if slides else {"heads": 2}
            drawing.arrow(start, end, name, role, (value,), unit, label=name, **how)
        else:
            u, v = clear_way(seen, body)
            shape = 18.0 + 9.0 * k, math.degrees(math.atan2(v, u)), 150.0
            drawing.add(Turn(point(body.origin), value, name, role, name, unit, *shape))


def of_tip(drawing: Drawing, seen: Snapshot, name: str, second: bool = False) -> None:
    """Draw the velocity of the tip, or with `second` its acceleration."""
    if seen.pose.tip is None or seen.model.frame().body < 0:
        return
    body = seen.pose.bodies[seen.model.frame().body]
    _arrows(drawing, seen, [(body, seen.pose.tip, name)], second)


def of_centres(
    drawing: Drawing, seen: Snapshot, scaled: bool = False, second: bool = False
) -> None:
    """Draw velocities v_ci of the centres of mass to one scale, or with `second` accelerations
    v̇_ci; scaled: with a scale bar."""
    letter = "v" + _ORDERS[second][2]
    bodies = [body for body in seen.pose.bodies if body.mass > 0]
    places = [(body, body.com, seen.names.on(letter, body.number, "c")) for body in bodies]
    _arrows(drawing, seen, places, second, scaled)


def partial_of_centres(drawing: Drawing, seen: Snapshot, joint: int) -> None:
    """Draw partial velocities v_ci,r of the centres of mass: those when joint r (from 1) alone
    moves, at the rate 1."""
    alone = replace(seen, qd=np.eye(seen.model.nv)[seen.model.coordinates[joint - 1].v[0]])
    bodies = [body for body in seen.pose.bodies if body.mass > 0]
    _arrows(drawing, alone, [(b, b.com, f"v_{{c{b.number},{joint}}}") for b in bodies])


def _arrows(
    drawing: Drawing,
    seen: Snapshot,
    places: Sequence[tuple[BodyPlace, Array, str]],
    second: bool = False,
    scaled: bool = False,
) -> None:
    """Draw the velocities or accelerations of given points of bodies with their names, the longest
    a third of the drawing's size."""
    (role, per, _), moving = _ORDERS[second], (seen.velocity_at, seen.acceleration_at)[second]
    values = [moving(body, place) for body, place, _ in places]
    longest = max((float(np.linalg.norm(v)) for v in values), default=0.0)
    if not longest:
        return
    scale = LONGEST * seen.size / longest
    for (_, place, name), value in zip(places, values, strict=True):
        if np.linalg.norm(value) > 1e-6 * longest:
            drawing.arrow(place, place + scale * value, name, role, value, "m" + per)
    if scaled:
        drawing.ruler(longest / 2.0, longest / 2.0 * scale, "m" + per, role)
