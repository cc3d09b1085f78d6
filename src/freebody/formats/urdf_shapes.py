"""The shapes of URDF links. What cannot be read as a shape is passed over: nothing of the dynamics
depends on it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from freebody.formats import number_text
from freebody.formats.xml import Element
from freebody.model.placement import Placement, rpy, shift
from freebody.model.shapes import Shape

_ROLES: tuple[Literal["collision", "visual"], ...] = ("collision", "visual")


def shapes(link: Element) -> tuple[Shape, ...]:
    """All shapes of a <link> that are whole: sizes finite and above 0, a mesh with the name of its
    file."""
    return tuple(
        shape for role in _ROLES for element in link.all(role) for shape in _shapes(element, role)
    )


def _shapes(element: Element, role: Literal["collision", "visual"]) -> Iterator[Shape]:
    try:
        placement = _origin(element)
        for geometry in element.all("geometry"):
            for part in geometry.children:
                yield from _shape(part, placement, role)
    except (ValueError, KeyError):  # no number, or none at all
        return


def _shape(
    part: Element, placement: Placement, role: Literal["collision", "visual"]
) -> Iterator[Shape]:
    given, line = part.attributes, part.line
    if part.tag == "box":
        yield Shape("box", _sizes(given["size"], 3), placement, role, line=line)
    elif part.tag == "cylinder":
        size = _sizes(f"{given['radius']} {given['length']}", 2)
        yield Shape("cylinder", size, placement, role, line=line)
    elif part.tag == "sphere":
        yield Shape("sphere", _sizes(given["radius"], 1), placement, role, line=line)
    elif part.tag == "mesh" and given.get("filename", "").strip():
        size = tuple(abs(x) for x in _numbers(given.get("scale", "1 1 1"), 3))
        yield Shape("mesh", size, placement, role, given["filename"].strip(), line)


def _origin(element: Element) -> Placement:
    for origin in element.all("origin"):
        position = _numbers(origin.attributes.get("xyz", "0 0 0"), 3)
        angles = _numbers(origin.attributes.get("rpy", "0 0 0"), 3)
        return shift(*position).then(rpy(*angles))
    return Placement()


def _sizes(text: str, count: int) -> tuple[float, ...]:
    values = _numbers(text, count)
    if min(values) <= 0.0:
        raise ValueError(text)
    return values


def _numbers(text: str, count: int) -> tuple[float, ...]:
    values = tuple(
        x
        for x in map(number_text.number, text.split())
        if x is not None and not number_text.fault(x)
    )
    if len(values) != count:
        raise ValueError(text)
    return values
