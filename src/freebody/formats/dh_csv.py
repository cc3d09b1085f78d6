"""A Denavit-Hartenberg table as CSV: a header of column names, one row a joint, SI units, angles
also as "90 deg".

Comment lines start with #; `# convention: standard` (or modified) says what the columns mean,
unless the caller does.
"""

from __future__ import annotations

import re
from typing import Any, NoReturn

from freebody.errors import FileError, UnknownNameError, shown
from freebody.formats import read_file
from freebody.formats.toml_table import in_units, is_name
from freebody.model import dh
from freebody.model.description import INFINITE, MOST_LINKS, Limits, RobotDescription
from freebody.model.parameters import Parameter, Quantity
from freebody.model.placement import Placement, rpy, shift

_COM, _TENSOR = ("cx", "cy", "cz"), ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
_DIRECT = ("theta", "d", "a", "alpha", "m", "rotor", "gear")
_DRIVE, _RANGE = ("viscous", "coulomb"), ("lower", "upper", "velocity", "effort")
COLUMNS = (
    "joint",
    "name",
    *_DIRECT[:5],
    *_COM,
    *_TENSOR,
    *_DIRECT[5:],
    *_DRIVE,
    *_RANGE,
    "joint_name",
)
_REMARK = re.compile(r"#\s*(convention|name|source|gravity|base|tool)\s*[:=](.*)")


def describe(
    file: str, text: str, *, name: str, convention: dh.Convention | None
) -> RobotDescription:
    """The description in a DH table. Raises FileError with the line."""
    remarks, lines = _split(file, text)
    if not lines:
        example = ", ".join(COLUMNS[:6])
        raise FileError(
            file, None, f"there is no table; the first line names the columns, such as {example}."
        )
    if len(lines) > MOST_LINKS:
        raise FileError(file, None, f"the table has more than {MOST_LINKS} rows, one per joint.")
    header = _Header(file, *lines[0])
    chosen = _convention(file, lines[0][0], remarks.get("convention"), convention)
    rows = [_DhRow(header, i, number, line).as_dh() for i, (number, line) in enumerate(lines[1:])]
    if not rows:
        raise FileError(file, lines[0][0], "the table has a header but no rows; add one per joint.")
    number, given = remarks.get("gravity", (None, "9.81"))
    gravity = in_units(given, "number")
    if gravity is None or read_file.fault(gravity):
        raise FileError(file, number, f"gravity is {shown(given)}, expected a number in m/s².")
    return dh.describe(
        rows,
        convention=chosen,
        gravity=gravity,
        name=remarks["name"][1] if "name" in remarks else name,
        source=remarks["source"][1] if "source" in remarks else "",
        file=file,
        lines=[number for number, _ in lines[1:]],
        joint_names=[row.pop("joint_name", None) for row in rows],
        base=_placement(file, remarks, "base"),
        tool=_placement(file, remarks, "tool"),
    )


def _placement(file: str, remarks: dict[str, tuple[int, str]], name: str) -> Placement | None:
    """The placement given by a remark's numbers x, y, z (m), roll, pitch, yaw (rad); None where the
    remark is absent."""
    if name not in remarks:
        return None
    line, text = remarks[name]
    words = re.sub(r" (?=deg\b)", "", text.replace(",", " ")).split()
    values = [in_units(word, "angle" if k > 2 else "number") for k, word in enumerate(words)]
    numbers = [x for x in values if x is not None and not read_file.fault(x)]
    if len(numbers) != len(words) or len(numbers) != 6:
        raise FileError(
            file,
            line,
            f"{name} is {shown(text)}, expected x, y, z in m and roll, pitch, yaw, such as "
            f"0 0 0.1 0 0 90deg.",
        )
    return shift(*numbers[:3]).then(rpy(*numbers[3:]))


def _split(file: str, text: str) -> tuple[dict[str, tuple[int, str]], list[tuple[int, str]]]:
    """The remarks by name, and the lines of the table, each with its number."""
    remarks: dict[str, tuple[int, str]] = {}
    lines: list[tuple[int, str]] = []
    for number, line in enumerate(read_file.lines(text), 1):
        if line.lstrip().startswith("#"):
            remark = _REMARK.fullmatch(line.strip())
            if remark and not remark[2].strip():
                raise FileError(
                    file,
                    number,
                    f"{remark[1]} is empty; write it after the colon, or remove the line.",
                )
            if remark:
                remarks[remark[1]] = number, remark[2].strip()
        elif line.strip(" ,;\t"):
            lines.append((number, line))
    return remarks, lines


def _convention(
    file: str, line: int, written: tuple[int, str] | None, given: dh.Convention | None
) -> dh.Convention:
    """The convention that the file or the caller states; it is never guessed."""
    known = ("standard", "modified")
    if written and written[1] not in known:
        raise FileError(
            file, written[0], str(UnknownNameError("convention", written[1], "the file", known))
        )
    if given and written and given != written[1]:
        raise FileError(
            file, written[0], f"the file says its convention is {written[1]}, the caller {given}."
        )
    chosen: Any = given or (written and written[1])
    if chosen is None:
        raise FileError(
            file,
            line,
            "the table does not state its convention; add a line '# convention: standard' or '# "
            "convention: modified', or load it with convention=.",
        )
    return chosen


class _Header:
    """Columns of a DH file, from its first line."""

    def __init__(self, file: str, line: int, text: str):
        self.file = file
        self.delimiter = ";" if ";" in text and "," not in text else ","
        self.columns = self.cells(line, text)
        for i, column in enumerate(self.columns):
            if column not in COLUMNS:
                raise FileError(
                    file, line, str(UnknownNameError("column", column, "a DH table", COLUMNS))
                )
            if column in self.columns[:i]:
                raise FileError(file, line, f"column {column!r} appears twice; keep one.")

    def cells(self, line: int, text: str) -> list[str]:
        return read_file.cells(self.file, line, text, self.delimiter)


class _DhRow:
    """One row of a DH table: its cells by column, empty ones left out."""

    def __init__(self, header: _Header, i: int, line: int, text: str):
        self.file, self.line, self.where = header.file, line, f"dh row {i + 1}"
        cells = header.cells(line, text)
        if len(cells) != len(header.columns):
            self.refuse(f"it has {len(cells)} cells, the header {len(header.columns)}.")
        self.cells = {
            column: cell for column, cell in zip(header.columns, cells, strict=True) if cell
        }
        self.kind = self.cells.get("joint", "R")

    def as_dh(self) -> dict[str, Any]:
        """The row as the dictionary that `fb.dh` takes."""
        row: dict[str, Any] = {
            key: self.cells[key] for key in ("joint", "name", "joint_name") if key in self.cells
        }
        row.update({key: self.quantity(key) for key in _DIRECT if key in self.cells})
        for key, columns in (("com", _COM), ("I", _TENSOR)):
            if any(column in self.cells for column in columns):
                row[key] = tuple(self.quantity(column) for column in columns)
        row["friction"] = tuple(self.quantity(column) for column in _DRIVE)
        row["limits"] = Limits(
            self.number("lower", -INFINITE),
            self.number("upper", INFINITE),
            self.number("velocity", INFINITE),
            self.number("effort", INFINITE),
        )
        return row

    def unit(self, column: str) -> str:
        if column in ("theta", "alpha") or (column in ("lower", "upper") and self.kind == "R"):
            return "angle"
        return "rate" if column == "velocity" and self.kind == "R" else "number"

    def number(self, column: str, default: float) -> float:
        if column not in self.cells:
            return default
        value = in_units(self.cells[column], self.unit(column))
        if value is None or read_file.fault(value, infinite=True):
            self.refuse(
                f"{column} is {shown(self.cells[column])}, expected a number{self.hint(column)}."
            )
        return value

    def quantity(self, column: str) -> Quantity:
        cell = self.cells.get(column, "0")
        value = in_units(cell, self.unit(column))
        if value is None and is_name(cell):
            return Parameter(cell)
        if value is None:
            self.refuse(
                f"{column} is {shown(cell)}, expected a number or a name{self.hint(column)}."
            )
        problem = read_file.fault(value)
        if problem:
            self.refuse(f"{column} is {value:g}, {problem}.")
        return value

    def hint(self, column: str) -> str:
        hints = {"angle": ", or an angle such as 30 deg", "rate": ", or a speed such as 90 deg/s"}
        return hints.get(self.unit(column), "")

    def refuse(self, problem: str) -> NoReturn:
        raise FileError(self.file, self.line, f"{self.where}: {problem}")
