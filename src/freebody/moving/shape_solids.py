"""The shapes of a robot's file as solids of a scene: boxes, cylinders and spheres, each fixed in
its body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.model.shapes import Shape
from freebody.moving.fitted_solids import DrawnSolid, FramePlace
from freebody.spatial import of_dimension

_ROUND = 24  # sides of a cylinder
_TOLD = 4  # names in a sentence


def shapes_by_body(model: Model) -> dict[int, list[tuple[str, Shape]]]:
    """The shapes with which each body is drawn, by its index (-1: the base): what is to be seen of
    it, or what it collides with; not of a body of which some are meshes, or of the plane."""
    if model.dim == 2:
        return {}
    found: dict[int, dict[str, list[tuple[str, Shape]]]] = {}
    for frame, shape in model.shapes:
        if frame in model.tree.frames:
            roles = found.setdefault(model.frame(frame).body, {})
            roles.setdefault(shape.role, []).append((frame, shape))
    chosen = {body: _plain(roles) for body, roles in found.items()}
    return {body: shapes for body, shapes in chosen.items() if shapes}


def _plain(roles: Mapping[str, list[tuple[str, Shape]]]) -> list[tuple[str, Shape]]:
    """The shapes of the first role that has no meshes; none where each has some."""
    for role in ("visual", "collision"):
        shapes = roles.get(role, [])
        if shapes and all(shape.kind != "mesh" for _, shape in shapes):
            return shapes
    return []


def drawn_as(model: Model) -> str:
    """Words on which bodies are drawn by shapes of the file and which by bars; empty in the plane,
    where there are bars alone."""
    if model.dim == 2:
        return ""
    own, meshes = shapes_by_body(model), any(shape.kind == "mesh" for _, shape in model.shapes)
    why = "; the file's meshes are not opened" if meshes else ""
    shaped, bare = [], []
    for k, body in enumerate(model.bodies):
        (shaped if k in own else bare).append(body.name)
    if not shaped:
        return f"Bodies are drawn as bars between their joints{why}."
    if not bare:
        return "Bodies are drawn by the shapes of the file."
    first = f"{_listed(shaped)} {'is' if len(shaped) == 1 else 'are'} drawn by shapes of the file"
    return f"{first}, {_listed(bare)} as {'a bar' if len(bare) == 1 else 'bars'}{why}."


def _listed(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    told, more = names[:_TOLD], len(names) - _TOLD
    if more > 1:
        return f"{', '.join(told)} and {more} more"
    *before, last = names
    return f"{', '.join(before)} and {last}" if before else last


def shape_solids(model: Model) -> Iterator[DrawnSolid]:
    """The solids of all bodies that are drawn by shapes of the file."""
    space, tree = of_dimension(3), model.tree
    for body, shapes in shapes_by_body(model).items():
        for frame, shape in shapes:
            outer, place = (_array(x) for x in tree.frames[frame][1:])
            R, p = (_array(x) for x in shape.placement.lower(space, VALUES))
            yield _solid(body, shape, outer @ R, place + outer @ p)


def _array(x: Any) -> Array:
    return np.asarray(x, dtype=float)


def _solid(body: int, shape: Shape, R: Array, p: Array) -> DrawnSolid:
    """A shape whose axes and middle are given in its body."""

    def at(z: float) -> FramePlace:
        x, y, above = p + z * R[:, 2]
        return FramePlace(body + 1, (float(x), float(y), float(above)))

    own = (body,) if body >= 0 else ()
    if shape.kind == "sphere":
        return DrawnSolid((at(0.0), at(0.0)), shape.size[0], "link", bodies=own)
    if shape.kind == "cylinder":
        radius, length = shape.size
        ends = at(-length / 2), at(length / 2)
        return DrawnSolid(ends, radius, "link", round=False, sides=_ROUND, bodies=own)
    x, y, z = shape.size
    ends, first = (at(-z / 2), at(z / 2)), FramePlace(body + 1, tuple(map(float, R[:, 0])))
    return DrawnSolid(ends, x / np.sqrt(2.0), "link", False, 4, own, first, y / x if x else 1.0)
