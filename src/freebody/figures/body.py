"""One body alone with all that acts on it, drawn: forces from where they act, moments, the stick of
the body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.figures import plane, space
from freebody.figures.drawing import FLAT, Arrow, Drawing, Line, Mark, Turn, View, best_view, point
from freebody.figures.joints import flat_joint
from freebody.figures.loads import BodyLoads, Load
from freebody.figures.svg import natural_scale
from freebody.figures.text import number

PANEL, TALLEST = 430.0, 400.0
"""Size of one diagram, pixels."""

_SHORTEST = 0.07  # of the longest arrow
_ALIKE = 6.0  # bodies and forces that differ by less than this factor are drawn to one scale
_ROLES = {"reaction": "reaction", "counter": "reaction", "weight": "weight", "external": "external"}


def diagrams(bodies: Sequence[BodyLoads], dim: int) -> tuple[Drawing, ...]:
    """Drawings of bodies, all seen from one side; lengths and forces to one scale where their sizes
    allow it."""
    view = FLAT if dim == 2 else _common_view(bodies)
    sizes, forces, moments = ([f(b) for b in bodies] for f in (_size, _longest, _peak))
    together = max(sizes) <= _ALIKE * min(sizes) and max(forces) <= _ALIKE * min(forces)
    if together:
        sizes, forces, moments = (
            [max(values)] * len(bodies) for values in (sizes, forces, moments)
        )
    drawings = tuple(
        _diagram(b, view, *scale) for b, *scale in zip(bodies, sizes, forces, moments, strict=True)
    )
    if together:
        common = min((natural_scale(drawing, PANEL, TALLEST) for drawing in drawings), default=1.0)
        for drawing in drawings:
            drawing.scale = common
    return drawings


def _diagram(loads: BodyLoads, view: View, size: float, longest: float, peak: float) -> Drawing:
    """A body of about `size` metres, drawn so that `longest` N take three quarters of that and
    `peak` N m less."""
    body = loads.body
    drawing = Drawing(view, f"Free-body diagram of body {body.number}, {body.name}")
    drawing.heading, drawing.compass = f"Body {body.number} · {body.name}", True
    if len(view.rows[0]) == 2:
        plane.add_body(drawing, body)
    else:
        parts = space.solids_of(body, 0.05 * size)
        drawing.add(*sorted(parts, key=lambda e: space.depth(e, view)))
    _joints(drawing, loads)
    scale = 0.75 * size / longest if longest else 0.0
    for load in loads.loads:
        _reach(drawing, loads, load)
        _force(drawing, load, scale, longest)
    _inertia(drawing, loads, scale, longest)
    for k, load in enumerate(loads.loads):
        _moment(drawing, load, peak, size, k)
    if longest:
        force = plane.round_down(longest / 2.5)
        drawing.rulers.append((force * scale, f"{number(force, 1)} N", "reaction"))
    drawing.rulers.append(plane.ruler(size))
    drawing.notes = _notes(loads)
    return drawing


def _joints(drawing: Drawing, loads: BodyLoads) -> None:
    """The joint that carries the body, where it is a flat symbol, those of its children, and its
    centre of mass."""
    body = loads.body
    if len(drawing.view.rows[0]) == 2:
        drawing.add(*flat_joint(body))
    for end in body.ends:
        if end.child is not None and np.linalg.norm(end.place - body.origin) > 1e-6:
            drawing.add(
                Mark(point(end.place), "joint", f"joint {end.child + 1}", "joint", size=4.5)
            )
    if body.mass:
        drawing.add(Mark(point(body.com), "com", f"C_{body.number}", "com", size=6.0))


def _reach(drawing: Drawing, loads: BodyLoads, load: Load) -> None:
    """A guide to where a force acts off the stick: on a slider along its rail, on a frame beside
    it."""
    ends = [load.place, loads.body.origin, loads.body.com, *(end.place for end in loads.body.ends)]
    nearest = min(ends[1:], key=lambda place: float(np.linalg.norm(place - load.place)))
    if np.linalg.norm(nearest - load.place) > 1e-6:
        drawing.add(Line((point(nearest), point(load.place)), f"reach {load.name}", "guide"))


def _force(drawing: Drawing, load: Load, scale: float, longest: float) -> None:
    size = float(np.linalg.norm(load.force))
    if not size:
        return
    length = max(size * scale, _SHORTEST * longest * scale)
    end = load.place + load.force / size * length
    label = f"{load.name}\u2002{number(size)} N"
    drawing.add(
        Arrow(
            point(load.place),
            point(end),
            load.name,
            _ROLES[load.role],
            label,
            point(load.force),
            "N",
        )
    )


def _inertia(drawing: Drawing, loads: BodyLoads, scale: float, longest: float) -> None:
    """m a_c, dashed: what the forces add up to."""
    size = float(np.linalg.norm(loads.inertial_force))
    if size <= 0.01 * longest:
        return
    name, com = f"{loads.mass_name} a_{loads.body.number}", loads.body.com
    end = com + loads.inertial_force / size * max(size * scale, _SHORTEST * longest * scale)
    drawing.add(
        Arrow(
            point(com),
            point(end),
            name,
            "inertia",
            f"{name}\u2002{number(size)} N",
            point(loads.inertial_force),
            "N",
        )
    )


def _moment(drawing: Drawing, load: Load, peak: float, size: float, k: int) -> None:
    value = float(np.linalg.norm(load.moment))
    if not load.moment_name or not value:
        return
    if len(load.moment) == 1:
        label = f"{load.moment_name} = {number(float(load.moment[0]))} N m"
        drawing.add(
            Turn(
                point(load.place),
                float(load.moment[0]),
                load.moment_name,
                "moment",
                label,
                radius=22.0 + 5 * (k % 2),
            )
        )
        return
    label = f"{load.moment_name}\u2002{number(value)} N m"
    length = size * max(0.45 * value / peak, 0.1)
    end = load.place + load.moment / value * length
    drawing.add(
        Arrow(
            point(load.place),
            point(end),
            load.moment_name,
            "moment",
            label,
            point(load.moment),
            "N m",
            heads=2,
        )
    )


def _notes(loads: BodyLoads) -> list[str]:
    """What is nothing, and the balance."""
    small = [x.name for x in loads.loads if not any(x.force)]
    small += [x.moment_name for x in loads.loads if x.moment_name and not any(x.moment)]
    n = loads.body.number
    force, moment = number(loads.force_residual, 2), number(loads.moment_residual, 2)
    balance = f"|ΣF − {loads.mass_name} a_{n}| = {force} N,\u2003|ΣM − Ḣ_{n}| = {moment} N m"
    return [*([f"≈ 0: {', '.join(small)}"] if small else []), balance]


def _longest(loads: BodyLoads) -> float:
    """The largest force (N)."""
    return max((float(np.linalg.norm(load.force)) for load in loads.loads), default=0.0)


def _peak(loads: BodyLoads) -> float:
    """The largest moment (N m)."""
    return max((float(np.linalg.norm(load.moment)) for load in loads.loads), default=0.0)


def _size(loads: BodyLoads) -> float:
    """Extent of a body and of where forces act on it, metres."""
    places = np.array(
        [load.place for load in loads.loads]
        + [p for segment in loads.body.outline for p in segment]
    )
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return size if size > 1e-3 else 0.1


def _common_view(bodies: Sequence[BodyLoads]) -> View:
    """From where sticks and forces are seen best."""
    segments = [s for b in bodies for s in b.body.outline]
    for b in bodies:
        size, longest = _size(b), _longest(b)
        segments += [(np.zeros(3), x.force / longest * size) for x in b.loads if longest]
    return best_view(segments or [(np.zeros(3), np.ones(3))])
