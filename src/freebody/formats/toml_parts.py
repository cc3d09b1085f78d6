"""The tables of a robot in TOML: links, frames, payloads, loops, gravity, and the rows of a DH
table."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

from freebody.errors import ModelError
from freebody.formats.toml_inertia import MASS, inertia
from freebody.formats.toml_joint import limits
from freebody.formats.toml_parameters import parameter_table
from freebody.formats.toml_placement import PLACE, direction, placement
from freebody.formats.toml_table import TomlTable
from freebody.model.description import Link, Loop, Mount, Payload
from freebody.model.gravity import gravity_of
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.loops import checked_tolerance
from freebody.model.parameters import Parameter, Quantity
from freebody.model.placement import Placement


def link(table: TomlTable, dim: int) -> Link:
    """[[link]]"""
    table = table.called(f"link {table.text('name')!r}").only("name", *MASS, "inertia_frame")
    inner = table.table("inertia_frame")
    frame = (
        placement(inner.called(f"{table.where}, inertia_frame").only(*PLACE), dim)
        if inner
        else Placement()
    )
    body = inertia(table, dim) if any(key in table for key in MASS) else None
    return Link(table.text("name"), body, frame, table.line)


def mount(table: TomlTable, dim: int, parents: Collection[str]) -> Mount:
    """[[frame]]"""
    table = table.called(f"frame {table.text('name')!r}").only("name", "parent", *PLACE)
    return Mount(table.text("name"), table.choice("parent", parents), placement(table, dim))


def payload(table: TomlTable, dim: int, frames: Collection[str]) -> Payload:
    """[[payload]]"""
    table = table.called(f"payload {table.text('name')!r}").only("name", "frame", *MASS)
    return Payload(table.text("name"), table.choice("frame", frames), inertia(table, dim))


def loop(table: TomlTable, dim: int) -> Loop:
    """[[loop]]"""
    table = table.called(f"loop {table.text('name')!r}").only(
        "name", "kind", "frames", "axis", "distance"
    )
    ends = table.listed(table.get("frames", None), "frames", 2)
    if not all(isinstance(end, str) for end in ends):
        table.refuse("frames must be the names of two frames.", "frames")
    kind = LOOP_KINDS[table.choice("kind", LOOP_KINDS)]
    return Loop(
        table.text("name"),
        kind.name,
        (ends[0], ends[1]),
        direction(table, dim) if "axis" in table else (),
        table.quantity("distance") if "distance" in table else None,
        table.line,
    )


def loop_tolerance(top: TomlTable) -> tuple[float, float] | None:
    """loop_tolerance = [metres, radians]"""
    key = "loop_tolerance"
    if key not in top:
        return None
    metres, radians = top.listed(top.data[key], key, 2)
    given = (
        top.read_number(metres, "number", (key, 0)),
        top.read_number(radians, "angle", (key, 1)),
    )
    try:
        return checked_tolerance(given, top.where)
    except ModelError as error:
        top.refuse(str(error), key)


def home(top: TomlTable) -> tuple[tuple[str, float], ...]:
    """[home]: positions by name."""
    inner = top.table("home")
    if inner is None:
        return ()
    inner = inner.called("[home]")
    return tuple((name, inner.number(name, "angle")) for name in inner.data)


def gravity(top: TomlTable, dim: int) -> tuple[Quantity, tuple[float, ...]]:
    """A size, a name, a vector, or { size, direction }; 9.81 m/s² downwards, called g, where the
    file says nothing."""
    down = (0.0,) * (dim - 1) + (-1.0,)
    given: Any = top.data.get("gravity")
    if isinstance(given, list):
        return gravity_of(top.vector("gravity", dim), dim)
    if isinstance(given, dict) and "direction" in given:
        inner = top.inner(given, "gravity").called("gravity").only("size", "direction")
        along = inner.vector("direction", dim)
        if abs(math.hypot(*along) - 1.0) > 1e-9:
            inner.refuse("direction must have length 1.", "direction")
        return inner.quantity("size"), along
    if "gravity" not in top:
        values, texts = parameter_table(top)
        return Parameter("g", None if "g" in texts else values.get("g", 9.81)), down
    size = top.quantity("gravity")
    return (size if isinstance(size, Parameter) else Parameter("g", size)), down


_DH_NUMBERS = {
    "theta": "angle",
    "d": "number",
    "a": "number",
    "alpha": "angle",
    "rotor": "number",
    "gear": "number",
    "m": "number",
}
_DH_ROW = ("joint", "name", "joint_name", *_DH_NUMBERS, "com", "I", "friction", "limits", "passive")


def dh_row(table: TomlTable) -> dict[str, Any]:
    """One row of a DH table, as `fb.dh` takes it, and joint_name."""
    table.only(*_DH_ROW)
    row: dict[str, Any] = {
        key: table.quantity(key, kind) for key, kind in _DH_NUMBERS.items() if key in table
    }
    row["joint"] = table.choice("joint", "RP", "R")
    for key in ("name", "joint_name"):
        if key in table:
            row[key] = table.text(key)
    if "com" in table:
        row["com"] = table.quantities("com", 3)
    if "I" in table:
        full = isinstance(table.data["I"], list) and len(table.data["I"]) == 3
        row["I"] = table.matrix("I", 3) if full else table.quantities("I", 6)
    if "friction" in table:
        friction = table.inner(table.data["friction"], "friction").only("viscous", "coulomb")
        row["friction"] = (
            friction.quantity("viscous", default=0.0),
            friction.quantity("coulomb", default=0.0),
        )
    if "limits" in table:
        row["limits"] = limits(table, angles=row["joint"] == "R")
    row["passive"] = table.flag("passive")
    return row
