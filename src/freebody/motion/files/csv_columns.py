"""A table over time, of a motion or of torques, as a CSV file holds it: columns by name, SI units.

A header names the columns, with a unit where it is not the SI's: `t` or `time`, `joint1 (deg)`,
`joint1.v [deg/s]`. Columns are separated by commas, semicolons or tabs, whichever the header has;
with the latter two a comma may be the decimal sign. What follows # is a comment.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from freebody.arrays import Array
from freebody.errors import FileError, listed, shown
from freebody.formats import read_file
from freebody.model.model import Model
from freebody.motion.ranges import angular
from freebody.outputs.harmless_text import as_meant

TIMES = ("t", "time")
_LARGEST, _MOST_VALUES = 256 * 2**20, 10_000_000
"""Bytes and cells of a file: hours of a robot's log."""
_DEGREE = math.pi / 180.0
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9},
    "angle": {"rad": 1.0, "deg": _DEGREE, "°": _DEGREE},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "number": {"1": 1.0},
    "torque": {"N m": 1.0, "Nm": 1.0, "N·m": 1.0, "mN m": 1e-3, "kN m": 1e3},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
}
"""The units in which a table may give a quantity, with their sizes in SI units."""
_PER = {"": ("",), ".v": ("/s",), ".a": ("/s²", "/s^2", "/s2")}
_LIKE_TIMES = re.compile(r"t[\W_]|time|.*(stamp|seconds)", re.IGNORECASE)
_SHOWN = 9
"""Columns of a header that are shown as an example."""
_NAMED = re.compile(r"(.*\S)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\])")


@dataclass(frozen=True)
class CsvColumns:
    """The columns of a CSV file, by the names in its header."""

    path: Path
    header: list[str]
    """Names of the columns; `t` is the time."""
    factors: Array
    """Factors (columns,) that turn each column into SI units."""
    stated: frozenset[str]
    """Columns whose unit the header states."""
    separator: str
    rows: list[tuple[int, str]]
    """Line number and text of the header, then of each row."""

    def values(self) -> Array:
        """The values (rows, columns) in SI units. Raises FileError with the line of a cell that is
        no number."""
        found = np.empty((len(self.rows) - 1, len(self.header)))
        for k, (line, text) in enumerate(self.rows[1:]):
            cells = read_file.cells(self.path, line, text.split("#")[0], self.separator)
            if len(cells) == len(self.header) + 1 and not cells[-1]:
                cells.pop()  # a separator at the end
            found[k] = _numbers(self.path, line, self.header, cells, self.separator)
        return found * self.factors

    def refusal(self, text: str, row: int | None = None) -> FileError:
        """An error about a row of numbers, or about the header, with its line."""
        return FileError(self.path, self.rows[0 if row is None else row + 1][0], text)


def kinds(model: Model) -> dict[str, str]:
    """The kind of each position by name: "angle", "length", or "number" (a quaternion's
    component)."""
    found = dict.fromkeys(model.position_names, "number")
    turns = angular(model)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None and body.kind.nq == body.kind.nv:
            for q, v in zip(at.q, at.v, strict=True):
                found[model.position_names[q]] = "angle" if turns[v] else "length"
        elif body.joint.mimic is None and body.kind.nq == 7:
            found.update(dict.fromkeys((model.position_names[q] for q in at.q[:3]), "length"))
    return found


def factor(column: str, unit: str, quantities: Mapping[str, str]) -> float | str:
    """The factor from a column's unit to SI units (1 for an unknown quantity), or a sentence on
    what is wrong with the unit."""
    ending = column[-2:] if column[-2:] in (".v", ".a") and column not in quantities else ""
    if column != "t" and column.removesuffix(ending) not in quantities:
        return 1.0  # refused where columns are looked up
    kind = "time" if column == "t" else quantities[column.removesuffix(ending)]
    known = {name + per: size for name, size in UNITS[kind].items() for per in _PER[ending]}
    if unit in known:
        return known[unit]
    what = {
        "": f"a{'n' if kind == 'angle' else ''} {kind}",
        ".v": "this rate",
        ".a": "this acceleration",
    }
    return f"{shown(unit)} is not a unit of {what[ending]}; units: {', '.join(known)}."


def read_columns(
    model: Model,
    path: Path,
    timed: bool = True,
    what: str = "a motion",
    quantities: Mapping[str, str] | None = None,
) -> CsvColumns:
    """The table in a CSV file; timed: it must have times. quantities: the kind of each column by
    name; None: positions. Raises FileError with the line."""
    row = "one row per time" if timed else "a row each"
    text = read_file.decoded(str(path), read_file.read(path, _LARGEST, what))
    lines = enumerate(read_file.lines(text), 1)
    rows = [(line, row) for line, row in lines if row.split("#")[0].strip(" ,;\t")]
    if not rows:
        names = "t and joint names" if timed else "joint names"
        raise FileError(path, None, f"the file is empty; {what} has a header, {names}, and {row}.")
    line, first = rows[0]
    separator = next((mark for mark in (";", "\t") if mark in first), ",")
    cells = [as_meant(cell) for cell in read_file.cells(path, line, first, separator)]
    if len(cells) > 1 and not cells[-1]:
        cells.pop()
    if len(cells) * (len(rows) - 1) > _MOST_VALUES:
        raise FileError(path, None, f"the file has more than {_MOST_VALUES} values.")
    known = quantities or kinds(model)
    if all(read_file.number(cell) is not None for cell in cells):
        names = [*(("t",) if timed else ()), *known]
        raise FileError(
            path,
            line,
            f"the first line holds numbers, and {what} has a header; write one above them, "
            f"{separator.join(names[:_SHOWN])}{separator + '…' if len(names) > _SHOWN else ''}.",
        )
    header, factors, stated = _header(known, path, line, cells)
    if timed and "t" not in header:
        raise FileError(
            path,
            line,
            f"the header has no column 't' (time in s); it has {quoted(cells)}{_hint(cells)}.",
        )
    return CsvColumns(path, header, factors, stated, separator, rows)


def _header(
    quantities: Mapping[str, str], path: Path, line: int, cells: list[str]
) -> tuple[list[str], Array, frozenset[str]]:
    """The names in the header, their factors to SI units, and the names whose units are stated."""
    header: dict[str, str] = {}  # name -> its cell
    factors, stated = [], set()
    for cell in cells:
        name, unit = named_unit(cell, quantities)
        if name in header:
            before = header[name]
            problem = (
                f"column {name!r} occurs twice in the header; remove one."
                if before == cell
                else f"columns {before!r} and {cell!r} are the same; remove one."
            )
            raise FileError(path, line, problem)
        size = 1.0 if unit is None else factor(name, unit, quantities)
        if isinstance(size, str):
            raise FileError(path, line, f"column {cell!r}: {size}")
        header[name] = cell
        factors.append(size)
        stated |= set() if unit is None else {name}
    return list(header), np.array(factors), frozenset(stated)


def named_unit(cell: str, quantities: Mapping[str, str]) -> tuple[str, str | None]:
    """The name in a header's cell, `t` for the time, and the unit behind it or None."""
    name, unit = cell, None
    match = _NAMED.fullmatch(cell)
    if cell not in quantities and match:
        name, unit = match[1], (match[2] if match[3] is None else match[3]).strip()
    if name.lower() in TIMES and name not in quantities:
        name = "t"
    return name, unit


def _hint(cells: list[str]) -> str:
    """A likely reason for a header without a time."""
    if cells[0].startswith(("%", "//", "!")):
        return "; a line that is not part of the table starts with #"
    if len(cells) == 1 and cells[0].lower().startswith(("t ", "time ")):
        return "; separate the columns by commas, semicolons or tabs"
    likely = next((cell for cell in cells if _LIKE_TIMES.match(cell)), None)
    if likely is None:
        return "; add it, with the time of each row"
    return f"; if {likely!r} holds the times, call it 't', or with its unit 't (ms)'"


def _numbers(
    path: Path, line: int, header: list[str], cells: list[str], separator: str
) -> list[float]:
    if len(cells) != len(header):
        hint = ""
        if separator == "," and len(cells) in (2 * len(header), 2 * len(header) - 1):
            hint = "; with decimal commas, separate the columns by semicolons"
        raise FileError(
            path, line, f"{len(cells)} values, the header names {len(header)} columns{hint}."
        )
    values = []
    for name, cell in zip(header, cells, strict=True):
        value = read_file.number(cell if separator == "," else cell.replace(",", ".", 1))
        if value is None:
            what = f"{shown(cell)} is not a number" if cell else "there is no number"
            if any(cell in units for units in UNITS.values()):
                what += "; write a unit after the name in the header, as in 'joint1 (deg)'"
            raise FileError(path, line, f"column {name!r}: {what}.")
        problem = read_file.fault(value)
        if problem:
            raise FileError(path, line, f"column {name!r}: {shown(cell)} is {problem}.")
        values.append(value)
    return values


def quoted(names: Iterable[str]) -> str:
    """A list of names in quotes, of many the first few."""
    return listed(map(repr, names), 8)
