"""Masses in TOML: mass, centre of mass, and an inertia or the shape that has it."""

from __future__ import annotations

import numpy as np

from freebody.errors import ModelError
from freebody.formats.toml_table import TomlTable
from freebody.model.inertia import Inertia
from freebody.model.parameters import Parameter, Quantity

MASS = ("mass", "com", "inertia", "shape")
_SHAPES: dict[str, tuple[str, ...]] = {
    "point": (),
    "disc": ("radius",),
    "ring": ("radius",),
    "bar": ("length",),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}


def inertia(table: TomlTable, dim: int) -> Inertia:
    """mass, com, and inertia or shape."""
    mass = table.quantity("mass")
    com = table.quantities("com", dim, default=(0.0,) * dim)
    if "shape" in table and "inertia" in table:
        table.refuse("shape and inertia exclude each other; keep one.", "shape")
    try:
        if "shape" in table:
            return _shape(table, dim, mass, com)
        return Inertia(mass, com, _tensor(table, dim))
    except ModelError as error:
        table.refuse(str(error), "inertia" if "inertia" in table else "mass")


def _tensor(table: TomlTable, dim: int) -> tuple[Quantity, ...]:
    """One number in the plane; six in space, or a symmetric 3×3 matrix of numbers."""
    if dim == 2:
        return (table.quantity("inertia", default=0.0),)
    rows = table.data.get("inertia")
    if isinstance(rows, list) and rows and all(isinstance(row, list) for row in rows):
        full = np.array(table.matrix("inertia", 3))
        return Inertia.of(0.0, (0.0,) * 3, full).tensor
    return table.quantities("inertia", 6, default=(0.0,) * 6)


def _shape(table: TomlTable, dim: int, mass: Quantity, com: tuple[Quantity, ...]) -> Inertia:
    """shape = { bar = { length = 0.4 } }"""
    outer = table.inner(table.data["shape"], "shape").only(*_SHAPES)
    if len(outer.data) != 1:
        outer.refuse(f"shape names {len(outer.data)} shapes, expected one of {', '.join(_SHAPES)}.")
    (kind,) = outer.data
    sizes = (
        outer.inner(outer.data[kind], kind).called(f"{table.where}, {kind}").only(*_SHAPES[kind])
    )
    if isinstance(mass, Parameter):
        table.refuse(
            "a shape needs a mass in numbers; give inertia = ... as a name instead.", "mass"
        )
    if kind == "box":
        body = Inertia.box(mass, sizes.vector("size", dim))
    elif kind == "point":
        body = Inertia.point(mass, (0.0,) * dim)
    elif kind in ("disc", "ring", "bar"):
        body = getattr(Inertia, kind)(mass, *(sizes.number(key) for key in _SHAPES[kind]), dim)
    elif dim == 2:
        outer.refuse(f"a {kind} is not a planar shape; use disc, ring, bar or box.")
    else:
        body = getattr(Inertia, kind)(mass, *(sizes.number(key) for key in _SHAPES[kind]))
    return Inertia(mass, com, body.tensor)
