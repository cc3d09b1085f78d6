"""A planar robot as textbooks draw it: bars, pins, sliders, ground, centres of mass, angles and
lengths."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import FLAT, Arc, Arrow, Drawing, Label, Line, Mark, point
from freebody.figures.joints import flat_joint
from freebody.figures.names import names_of
from freebody.figures.skeleton import BodyPlace, Skeleton, extent
from freebody.figures.text import number
from freebody.model.model import Model


def draw(model: Model, pose: Skeleton, ghosts: Sequence[Skeleton], path: Array | None) -> Drawing:
    """The drawing of one pose, with fainter ones behind it."""
    size = extent([pose, *ghosts], path)
    drawing = Drawing(
        FLAT, f"{model.name}: stick drawing with joint angles, lengths and centres of mass"
    )
    for ghost in ghosts:
        for body in ghost.bodies:
            for a, b in sticks(body):
                drawing.add(Line((point(a), point(b)), f"ghost {body.number}", "ghost"))
    if path is not None:
        drawing.add(Line(tuple(map(point, path)), "tip path", "tippath"))
        drawing.add(Mark(point(path[0]), "dot", "path start", "tipdot", size=3.0))
    _axes(drawing, size)
    drawing.add(Mark((0.0, 0.0), "ground", "ground", "ground", (0.0, 1.0), 9.0))
    for body in pose.bodies:
        _guides(drawing, model, pose, body, size)
    for body in pose.bodies:
        add_body(drawing, body)
    for body in pose.bodies:
        add_joint(drawing, body)
        if body.mass > 0:
            drawing.add(Mark(point(body.com), "com", f"C_{body.number}", "com", size=6.0))
            drawing.add(
                Label(
                    point(body.com),
                    f"C_{body.number}",
                    f"label C_{body.number}",
                    direction=_aside(body),
                )
            )
    if pose.tip is not None:
        drawing.add(Mark(point(pose.tip), "dot", "tip", "soft-head", size=3.0))
        drawing.add(Label(point(pose.tip), "P", "label tip", direction=(1.0, 0.6)))
    drawing.rulers.append(ruler(size))
    return drawing


def sticks(body: BodyPlace) -> list[tuple[Array, Array]]:
    """A body's segments, with the rod of a prismatic joint from where it slides."""
    rod = [(body.carrier, body.origin)] if body.kind.slides else []
    return rod + list(body.outline)


def add_body(drawing: Drawing, body: BodyPlace) -> None:
    """The bar of a link."""
    for k, (a, b) in enumerate(body.outline):
        drawing.add(
            Line(
                (point(a), point(b)),
                f"link {body.number}" + ("" if k == 0 else f".{k + 1}"),
                "link",
                width=11.0,
            )
        )


def add_joint(drawing: Drawing, body: BodyPlace) -> None:
    """A pin, or a slider with its rail."""
    if body.kind.slides:
        drawing.add(Line((point(body.carrier), point(body.origin)), f"rail {body.number}", "rail"))
    drawing.add(*flat_joint(body))


def ruler(size: float) -> tuple[float, str, str]:
    """A round length of about a fifth of the drawing."""
    length = round_down(size / 5)
    return (
        length,
        f"{number(length, 2)} m" if length >= 0.1 else f"{number(1000 * length, 2)} mm",
        "length",
    )


def round_down(value: float) -> float:
    """1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(k * power for k in (1, 2, 5) if k * power <= value * (1 + 1e-12))


def _axes(drawing: Drawing, size: float) -> None:
    for name, end in (("x", (0.2 * size, 0.0)), ("y", (0.0, 0.2 * size))):
        drawing.add(
            Arrow((0.0, 0.0), end, f"axis {name}", "soft"),
            Label(end, name, f"label {name}", direction=end),
        )


def _guides(drawing: Drawing, model: Model, pose: Skeleton, body: BodyPlace, size: float) -> None:
    """The joint's variable: an angle from the line before, or a slide; and the link's length."""
    names, n = names_of(model), body.number
    variable = names.coordinate(body) or f"joint {n}"
    if body.kind.slides and body.axis is not None:
        middle = (body.carrier + body.origin) / 2
        slide = float((body.origin - body.carrier) @ body.axis)
        drawing.add(
            Label(
                point(middle),
                f"{variable} = {slide:.3f} m".replace("-", "−"),
                variable,
                direction=_normal(body.axis),
            )
        )
    elif body.kind.turns:
        before = math.atan2(body.carrier_rotation[1, 0], body.carrier_rotation[0, 0])
        now = math.atan2(body.rotation[1, 0], body.rotation[0, 0])
        turned = math.remainder(now - before, 2 * math.pi)
        reach = 0.17 * size
        end = body.origin + reach * 1.25 * np.array([math.cos(before), math.sin(before)])
        drawing.add(
            Line((point(body.origin), point(end)), f"reference {n}", "guide"),
            Arc(
                point(body.origin),
                reach,
                before,
                turned,
                variable,
                label=f"{variable} = {number(math.degrees(turned))}°",
            ),
        )
    for end in body.ends:
        a, b = body.origin, end.place
        length, name = float(np.linalg.norm(b - a)), names.length(body, end)
        if length > 0.05 * size:
            along = (a + b) / 2 + 0.12 * (b - a)
            text = f"{name} = {length:.3f} m" if name else f"{length:.3f} m"
            drawing.add(Label(point(along), text, name or f"length {n}", direction=_normal(a - b)))


def _normal(direction: Array) -> tuple[float, float]:
    return (-float(direction[1]), float(direction[0]))


def _aside(body: BodyPlace) -> tuple[float, float]:
    along = body.outline[0][1] - body.outline[0][0] if body.outline else np.array([1.0, 0.0])
    return _normal(along)
