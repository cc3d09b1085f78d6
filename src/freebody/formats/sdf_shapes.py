"""Shapes of an SDF file's links: boxes, cylinders, spheres, capsules, ellipsoids, and meshes by the
names of their files, each with its pose in the link."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from freebody.errors import FileError, IncludedLine
from freebody.formats.urdf_elements import XmlElement
from freebody.model.shapes import SHAPE_KINDS, Shape, ShapeRole, SolidKind

if TYPE_CHECKING:
    from freebody.formats.sdf import SdfReader

_ROLES: tuple[ShapeRole, ...] = ("collision", "visual")
_SIZES: dict[str, tuple[SolidKind, tuple[str, ...]]] = {
    "box": ("box", ("size",)),
    "cylinder": ("cylinder", ("radius", "length")),
    "sphere": ("sphere", ("radius",)),
    "capsule": ("capsule", ("radius", "length")),
    "ellipsoid": ("ellipsoid", ("radii",)),
}
"""The kind of solid that an element stands for, and the elements inside with its sizes."""


def shapes_of(reader: SdfReader, link: XmlElement) -> Iterator[Shape]:
    """The shapes of a <link> that can be read. A notice names what cannot, which is no reason to
    refuse a robot, since its dynamics do not depend on shapes."""
    for role in _ROLES:
        for element in link.all(role):
            try:
                yield from list(_shapes_in(reader, link, element, role))
            except FileError as problem:
                told = f"warning: {problem.problem.rstrip('.')}; this shape is left out."
                reader.notice("ignored", element, told)


def _shapes_in(
    reader: SdfReader, link: XmlElement, element: XmlElement, role: ShapeRole
) -> Iterator[Shape]:
    where = f"<{role}> of link {link.name()!r}"
    for geometry in element.all("geometry"):
        for part in geometry.children:
            if part.tag in _SIZES:
                kind, tags = _SIZES[part.tag]
                size = _sizes(reader, part, tags, len(SHAPE_KINDS[kind].sizes), where)
                yield Shape(kind, size, reader.placed_in(link, element), role, line=part.line)
            elif part.tag == "mesh":
                yield _mesh(reader, part, link, element, role)


def _mesh(
    reader: SdfReader, part: XmlElement, link: XmlElement, element: XmlElement, role: ShapeRole
) -> Shape:
    where = f"<{role}> of link {link.name()!r}"
    uri, scale = (reader.one(part, tag, where) for tag in ("uri", "scale"))
    if uri is None or not uri.content:
        reader.refuse(part, f"{where}: <mesh> has no <uri>; name a file in it.")
    if part.all("submesh"):
        reader.refuse(part, f"{where}: of its mesh a part alone is used.")
    x, y, z = reader.numbers(scale, 3, where) if scale is not None else (1.0, 1.0, 1.0)
    own = part.file if isinstance(part.line, IncludedLine) else ""
    folders = (os.path.dirname(os.path.abspath(own)),) if own else ()
    at = reader.placed_in(link, element)
    return Shape("mesh", (x, y, z), at, role, uri.content, part.line, folders=folders)


def _sizes(
    reader: SdfReader, part: XmlElement, tags: tuple[str, ...], count: int, where: str
) -> tuple[float, ...]:
    found: list[float] = []
    for tag in tags:
        given = reader.one(part, tag, where)
        if given is None:
            reader.refuse(part, f"{where}: <{part.tag}> has no <{tag}>.")
        found += reader.numbers(given, count if len(tags) == 1 else 1, where)
    if min(found) <= 0.0:
        reader.refuse(part, f"{where}: a size of <{part.tag}> is not above 0.")
    return tuple(found)
