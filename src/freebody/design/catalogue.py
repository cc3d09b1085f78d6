"""`catalogue`: motors, gears and bearings from a TOML file, each a row; every refusal names the row
and its line."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field
from importlib import resources
from typing import Any, TypeVar

from freebody.by_value import ByValue
from freebody.design.parts import Bearing, Gear, Motor
from freebody.errors import FreebodyError, UnknownNameError, require_kind, shown
from freebody.formats import read_file
from freebody.formats.toml_table import TomlTable, table_of
from freebody.outputs.display import Tabled, TextTable, counted

INVENTED = "invented"
"""The name of the catalogue that comes with freebody."""

PartType = TypeVar("PartType", Motor, Gear, Bearing)
_TEXTS: dict[type, tuple[str, ...]] = {Motor: (), Gear: ("kind",), Bearing: ("kind",)}
"""Keys whose values are words, by the kind of part."""


@dataclass(frozen=True, eq=False, repr=False)
class PartCatalogue(Tabled, ByValue):
    """Motors, gears and bearings to choose from, each kind by name, in the order of its file."""

    motors: tuple[Motor, ...] = ()
    gears: tuple[Gear, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    note: str = ""
    """The catalogue's words about itself, such as where its numbers are from."""
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        for name, kind in (("motors", Motor), ("gears", Gear), ("bearings", Bearing)):
            parts, seen = getattr(self, name), set[str]()
            require_kind("PartCatalogue", name, parts, Iterable, f"a list of fb.{kind.__name__}")
            for part in parts:
                if not isinstance(part, kind):
                    raise FreebodyError(
                        f"Catalogue: {shown(part)} stands among {kind.WHAT}s; give "
                        f"fb.{kind.__name__}(...)."
                    )
                if part.name in seen:
                    raise part.refusal("there are two of this name; call one otherwise")
                seen.add(part.name)
        known = {motor.name for motor in self.motors}
        for gear in self.gears:
            for name in gear.fits:
                if self.motors and name not in known:
                    raise UnknownNameError("motor", name, f"fits of gear {gear.name!r}", known)
        super().__post_init__()

    def motor(self, name: str) -> Motor:
        """The motor of that name."""
        return _named(self.motors, "motor", name, self)

    def gear(self, name: str) -> Gear:
        """The gear of that name."""
        return _named(self.gears, "gear", name, self)

    def bearing(self, name: str) -> Bearing:
        """The bearing of that name."""
        return _named(self.bearings, "bearing", name, self)

    def _title(self) -> str:
        counts = (
            counted(len(parts), what)
            for parts, what in (
                (self.motors, "motor"), (self.gears, "gear"), (self.bearings, "bearing")
            )
        )  # fmt: skip
        return f"Catalogue: {', '.join(counts)}. {self.note}"

    def _table(self) -> TextTable:
        rows = [
            ("motor", m.name, f"{m.continuous_torque:.4g} N m", f"{m.mass:.4g} kg")
            for m in self.motors
        ]
        rows += [("gear", g.name, f"{g.factor:.4g}", f"{g.mass:.4g} kg") for g in self.gears]
        rows += [("bearing", b.name, f"{b.dynamic_load:.4g} N", "") for b in self.bearings]
        return TextTable(("part", "name", "torque, ratio, load", "mass"), rows, [self.note])


def _named(parts: Sequence[PartType], what: str, name: str, owner: PartCatalogue) -> PartType:
    found: Mapping[str, PartType] = {part.name: part for part in parts}
    if name not in found:
        raise UnknownNameError(what, name, owner.source or "the catalogue", found)
    return found[name]


def catalogue(path: str | os.PathLike[str]) -> PartCatalogue:
    """The motors, gears and bearings that a TOML file lists.

    Parameters
    ----------
    path
        A file with tables [[motor]], [[gear]] and [[bearing]], whose keys are the fields of
        `fb.Motor`, `fb.Gear` and `fb.Bearing`; SI units, speeds also as text such as "3000 rpm".
        Or "invented": a small catalogue that comes with freebody, for trying out; no maker sells
        what is in it.

    Raises
    ------
    FileError
        What cannot be read, a row that lacks a number, or has one that no such part has, with the
        row's name and line.
    """
    given = read_file.path_of("catalogue", "path", path, f"a TOML file, or {INVENTED!r}")
    if given == INVENTED:
        source = f"{INVENTED}.toml"
        at = resources.files("freebody").joinpath("design", "catalogues", source)
        text = at.read_text(encoding="utf-8")
    else:
        source = given
        data = read_file.read(given, what="a catalogue")
        text = read_file.decoded(source, data)
    return _read(table_of(source, text).only("note", "motor", "gear", "bearing"))


def _read(top: TomlTable) -> PartCatalogue:
    motors, gears, bearings = _rows(top, Motor), _rows(top, Gear), _rows(top, Bearing)
    if not (motors or gears or bearings):
        top.refuse("the catalogue is empty; write [[motor]] and [[gear]] above each row.")
    try:
        return PartCatalogue(motors, gears, bearings, top.text("note", ""), top.file)
    except FreebodyError as problem:
        top.refuse(str(problem))


def _rows(top: TomlTable, kind: type[PartType]) -> tuple[PartType, ...]:
    return tuple(
        _part(table.called(f"[[{kind.WHAT}]] {k}"), kind)
        for k, table in enumerate(top.tables(kind.WHAT), 1)
    )


def _part(table: TomlTable, kind: type[PartType]) -> PartType:
    given: dict[str, Any] = {"name": table.text("name")}
    table = table.called(f"{table.where}, {given['name']!r}")
    numbers = {number.name: number for number in kind.NUMBERS}
    texts, lists = _TEXTS[kind], ("fits",) if kind is Gear else ()
    table.only("name", *numbers, *kind.CURVES, *texts, *lists)
    defaults = kind.__dataclass_fields__
    for name, number in numbers.items():
        if name in table or (number.needed and not _has_default(defaults[name])):
            given[name] = table.number(name, number.kind)
    given |= {name: _curve(table, name) for name in kind.CURVES if name in table}
    needed = [name for name in texts if name in table or not _has_default(defaults[name])]
    given |= {name: table.text(name) for name in needed}
    for name in lists:
        if name in table:
            given[name] = _names(table, name)
    try:
        return kind(**given)
    except FreebodyError as problem:
        table.refuse(str(problem).removeprefix(f"{kind.WHAT} {given['name']!r}: "))


def _has_default(entry: Any) -> bool:
    return entry.default is not MISSING


def _curve(table: TomlTable, key: str) -> tuple[tuple[float, float], ...]:
    points = []
    for k, pair in enumerate(table.listed(table.data[key], key, None)):
        speed, torque = table.listed(pair, key, 2, k)
        points.append(
            (
                table.read_number(speed, "speed", (key, k, 0)),
                table.read_number(torque, "number", (key, k, 1)),
            )
        )
    return tuple(points)


def _names(table: TomlTable, key: str) -> tuple[str, ...]:
    names = table.data[key]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        table.refuse(f"{key} must be a list of names in quotes.", key)
    return tuple(names)
