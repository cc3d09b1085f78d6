"""A joint's symbol, by the `mark` that its kind names (`model/joints`): flat in the plane, a solid
in space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from freebody.figures.drawing import Element, Mark, Prism, point
from freebody.figures.skeleton import BodyPlace

Solid = Callable[[BodyPlace, float, str], list[Element]]
"""The symbol in space of the joint that carries a body, of about a radius in metres, with its
name."""


@dataclass(frozen=True)
class JointSymbol:
    """How joints of one mark are drawn."""

    flat: str
    """In the plane: one of `symbols.MARKS`; "" for none."""
    solid: Solid
    size: float = 6.0
    """Of the flat one, pixels."""


def _cylinder(body: BodyPlace, radius: float, name: str) -> list[Element]:
    """Along the axis, where the body's origin is."""
    if body.axis is None:
        return []
    at, axis = point(body.origin), point(body.axis)
    return [Prism(at, axis, radius, 1.35 * radius, name, "joint")]


def _box(body: BodyPlace, radius: float, name: str) -> list[Element]:
    """Along the axis, where the slide begins."""
    if body.axis is None:
        return []
    at, axis = point(body.carrier), point(body.axis)
    return [Prism(at, axis, 1.15 * radius, 1.5 * radius, name, "joint", sides=4)]


def _sleeve(body: BodyPlace, radius: float, name: str) -> list[Element]:
    """A tube along the axis, where the joint begins, and the rod in it."""
    if body.axis is None:
        return []
    at, axis = point(body.carrier), point(body.axis)
    return [
        Prism(at, axis, 0.5 * radius, 2.6 * radius, name, "joint"),
        Prism(at, axis, 1.1 * radius, 1.5 * radius, name, "joint"),
    ]


def _screw(body: BodyPlace, radius: float, name: str) -> list[Element]:
    """A nut where the joint begins, and the spindle that turns in it."""
    if body.axis is None:
        return []
    axis = point(body.axis)
    return [
        Prism(point(body.origin), axis, 0.55 * radius, 2.6 * radius, name, "joint"),
        Prism(point(body.carrier), axis, 1.3 * radius, 0.8 * radius, name, "joint", sides=6),
    ]


def _cross(body: BodyPlace, radius: float, name: str) -> list[Element]:
    """Two pins that cross: one held by what is before, one by the body."""
    at = point(body.origin)
    first, second = point(body.carrier_rotation[:, 0]), point(body.rotation[:, 1])
    return [Prism(at, axis, 0.5 * radius, 1.7 * radius, name, "joint") for axis in (first, second)]


def _ball(body: BodyPlace, radius: float, name: str) -> list[Element]:
    return [Mark(point(body.origin), "sphere", name, "joint", size=8.0)]


def _nothing(body: BodyPlace, radius: float, name: str) -> list[Element]:
    return []


JOINTS = {
    "joint": JointSymbol("joint", _cylinder),
    "slider": JointSymbol("slider", _box, 8.0),
    "sleeve": JointSymbol("slider", _sleeve, 8.0),
    "screw": JointSymbol("joint", _screw),
    "cross": JointSymbol("joint", _cross),
    "sphere": JointSymbol("sphere", _ball, 8.0),
    "": JointSymbol("", _nothing),
}
"""By mark."""


def flat_joint(body: BodyPlace) -> list[Element]:
    """The joint that carries a body, in the plane."""
    symbol = JOINTS[body.kind.mark]
    direction = None if body.axis is None else point(body.axis)
    at, name = point(body.origin), f"joint {body.number}"
    return [Mark(at, symbol.flat, name, "joint", direction, symbol.size)] if symbol.flat else []


def solid_joint(body: BodyPlace, radius: float) -> list[Element]:
    """The same in space."""
    return JOINTS[body.kind.mark].solid(body, radius, f"joint {body.number}")
