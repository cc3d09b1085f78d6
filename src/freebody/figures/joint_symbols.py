"""A joint's symbol, as its kind describes it (`model/joints`: `mark`, `solids`): a mark in the
plane, solids in space. What a mark looks like: `svg_symbols.MARKS`."""

from __future__ import annotations

from freebody.arrays import Array
from freebody.figures.drawing import Element, Mark, Prism, point
from freebody.figures.skeleton import BodyPlace
from freebody.model.joints.kind import Solid

_SIZES = {"joint": 6.0}
"""Of the marks, pixels; others are larger."""
_LARGER = 8.0


def flat_joint(body: BodyPlace) -> list[Element]:
    """The joint that carries a body, in the plane."""
    mark = body.kind.mark
    direction = None if body.axis is None else point(body.axis)
    at, name, size = point(body.origin), f"joint {body.number}", _SIZES.get(mark, _LARGER)
    return [Mark(at, mark, name, "joint", direction, size)] if mark else []


def solid_joint(body: BodyPlace, radius: float) -> list[Element]:
    """The same in space, of about a radius in metres; without solids its mark, which looks alike
    from everywhere."""
    name = f"joint {body.number}"
    if not body.kind.solids:
        return flat_joint(body)
    return [
        Prism(
            point(body.origin if part.moves else body.carrier),
            point(along),
            part.radius * radius,
            part.half * radius,
            name,
            "joint",
            part.sides,
        )
        for part in body.kind.solids
        if (along := _along(body, part)) is not None
    ]


def _along(body: BodyPlace, part: Solid) -> Array | None:
    """The direction of a part, in the world."""
    if part.along == "axis":
        return body.axis
    axes = body.rotation if part.moves else body.carrier_rotation
    return axes[:, "xyz".index(part.along)]
