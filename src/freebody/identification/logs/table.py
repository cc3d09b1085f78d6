"""The table in a log's file or in memory, before anything is known of its columns: names, and on
request the numbers of some columns with the lines that they stand on.

Text is parsed by NumPy, some thousand lines at a time; where these do not fit, line by line, so
that a broken line is named and the others are kept.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FileError, FreebodyError, KindError, MissingPackageError, shown
from freebody.formats import read_file
from freebody.identification.logs.list_cells import has_lists, lists_as_cells, without_lists
from freebody.outputs.harmless_text import as_meant

_LARGEST = 1024 * 2**20
"""Bytes of a file: a day of a robot's log."""
_AT_ONCE = 5000  # lines
_LOOKED_AT = 200
"""Lines at the head of a file by which its separator, its header and its width are known."""
_SEPARATORS = ";\t, "
_MARKS = "#%"
"""Signs in front of a line that is a remark, or a header that its writer took for one."""


class LogRows(NamedTuple):
    """Numbers of some columns of a log."""

    values: Array
    """Numbers (n, columns) as they are written, NaN where there is none."""
    lines: NDArray[np.int64]
    """Lines (n,) of the file, from 1, or rows of a table in memory."""
    broken: tuple[tuple[int, str], ...] = ()
    """Lines that are left out, each with the reason."""


@dataclass(frozen=True, eq=False)
class LogText:
    """The table in a text file: columns between separators, perhaps below a header."""

    file: str
    lines: list[str]
    separator: str
    names: tuple[str, ...] | None
    header: int | None
    """Line of the header, from 1."""
    data: int
    """RowPlace of the first row of numbers in `lines`."""
    first: tuple[str, ...]
    unit = "line"
    """The word for a row."""

    @property
    def width(self) -> int:
        """The number of columns."""
        return len(self.first)

    def refusal(self, problem: str, line: int | None = None) -> FreebodyError:
        """An error about the table, at one of its rows or at its head."""
        return FileError(self.file, self.header if line is None else line, problem)

    def rows(self, columns: Sequence[int]) -> LogRows:
        """The numbers of some columns."""
        values: list[Array] = []
        lines: list[Sequence[int]] = []
        broken: list[tuple[int, str]] = []
        for start in range(self.data, len(self.lines), _AT_ONCE):
            chunk = self.lines[start : start + _AT_ONCE]
            found = self._at_once(chunk, columns)
            if found is not None:
                values.append(found)
                lines.append(range(start + 1, start + 1 + len(chunk)))
                continue
            kept = list(self._one_by_one(start + 1, chunk, columns, broken))
            values.append(np.array([row for _, row in kept]).reshape(-1, len(columns)))
            lines.append([line for line, _ in kept])
        where = np.concatenate([np.asarray(x, dtype=np.int64) for x in lines])
        return LogRows(np.concatenate(values), where, tuple(broken))

    def _at_once(self, chunk: list[str], columns: Sequence[int]) -> Array | None:
        """The numbers of many lines, or None where a line does not fit."""
        text = "\n".join(chunk)
        if "#" in text or (self.separator == " " and _uneven_blanks(text)):
            return None
        whole = sorted(columns) == list(range(self.width))
        # NumPy itself refuses rows of several widths where it is to read them whole
        if not whole and set(map(str.count, chunk, repeat(self.separator))) != {self.width - 1}:
            return None
        if self.separator != ",":
            chunk = text.replace(",", ".").split("\n")
        try:
            found = np.loadtxt(
                chunk, delimiter=self.separator, usecols=None if whole else columns, ndmin=2,
                comments=None, quotechar='"',
            )  # fmt: skip
        except ValueError:
            return None
        if found.shape != (len(chunk), len(columns)):
            return None
        return found[:, columns] if whole else found

    def _one_by_one(
        self, line: int, chunk: list[str], columns: Sequence[int], broken: list[tuple[int, str]]
    ) -> Iterator[tuple[int, list[float]]]:
        """Lines and their numbers; what has too few or too many cells, or a word where others have
        numbers, goes to `broken`."""
        for at, text in enumerate(chunk, line):
            text = text.split("#")[0]
            if not text.strip(" \t,;"):
                continue
            try:
                cells = _cells(self.file, at, text, self.separator)
            except FileError as error:
                broken.append((at, error.problem.rstrip(".")))
                continue
            if len(cells) == self.width + 1 and not cells[-1]:
                cells.pop()  # a separator at the end
            if len(cells) != self.width:
                broken.append((at, f"{len(cells)} values where the others have {self.width}"))
                continue
            row, problem = [], ""
            for k in columns:
                value = _number(cells[k], self.separator)
                if value is None and cells[k].lower() not in _ABSENT:
                    problem = problem or f"{self._column(k)}: {shown(cells[k])} is not a number"
                row.append(np.nan if value is None else value)
            if problem:
                broken.append((at, problem))
            else:
                yield at, row

    def _column(self, k: int) -> str:
        return f"column {k + 1 if self.names is None else repr(self.names[k])}"


_ABSENT = ("", "null", "none", "na", "n/a", "-")
"""Texts that loggers write where they have no number."""


@dataclass(frozen=True, eq=False)
class LogColumns:
    """The table in memory, or in a file that holds columns of numbers."""

    file: str
    names: tuple[str, ...]
    columns: tuple[Any, ...]
    first: tuple[str, ...]
    unit = "row"

    @property
    def width(self) -> int:
        """The number of columns."""
        return len(self.columns)

    def refusal(self, problem: str, line: int | None = None) -> FreebodyError:
        """An error about the table, at one of its rows or at its head."""
        return FileError(self.file, None, problem if line is None else f"row {line}: {problem}")

    def rows(self, columns: Sequence[int]) -> LogRows:
        """The numbers of some columns."""
        count = {len(self.columns[k]) for k in columns}
        if len(count) > 1:
            raise self.refusal(
                f"its columns have between {min(count)} and {max(count)} rows; make them equal."
            )
        values = [self._numbers(k) for k in columns]
        return LogRows(np.stack(values, axis=-1), np.arange(1, count.pop() + 1))

    def _numbers(self, k: int) -> Array:
        try:
            column = np.asarray(self.columns[k])
            if column.dtype.kind in "mM":
                column = column.astype("int64")
            found = column.astype(np.float64)
        except (TypeError, ValueError):
            raise self.refusal(f"column {self.names[k]!r} holds no numbers.") from None
        if found.ndim != 1:
            raise self.refusal(
                f"column {self.names[k]!r} has shape {found.shape}, expected one number a row; "
                f"give a column for each joint."
            )
        return found


LogTable = LogText | LogColumns
"""Columns of numbers, perhaps with names; `first` is the first row's cells as text, which of a
column of words tell what it is about."""


def table_of_log(source: Any, function: str = "read_log") -> LogTable:
    """The table of a log: of a CSV or Parquet file, or of a dict or DataFrame of columns. function:
    the public one that reads it, for messages."""
    if hasattr(source, "items") and not isinstance(source, str | os.PathLike):
        return _in_memory(source)
    if not isinstance(source, str | os.PathLike):
        raise KindError(function, "path", source, "the path of a CSV or Parquet file, or a table")
    path = Path(source)
    if path.suffix.lower() in (".parquet", ".pq"):
        return _of_parquet(path)
    return _of_text(path)


def _in_memory(table: Mapping[str, Any]) -> LogColumns:
    pairs = [(str(name), np.asarray(column)) for name, column in table.items()]
    first = tuple(str(column.flat[0]) if column.size else "" for _, column in pairs)
    return LogColumns(
        "the table", tuple(name for name, _ in pairs), tuple(x for _, x in pairs), first
    )


def _of_parquet(path: Path) -> LogColumns:
    try:
        from pyarrow import ArrowInvalid, BufferReader, parquet  # type: ignore[import-not-found]  # an extra
    except ImportError:
        raise MissingPackageError("read_log: Parquet", "pyarrow", "parquet") from None
    data = read_file.contents(path, _LARGEST, "a log")
    try:
        found = parquet.read_table(BufferReader(data))
    except (ArrowInvalid, OSError) as error:
        problem = str(error).split("\n")[0].rstrip(".")
        raise FileError(path, None, f"this is not a Parquet file: {problem}.") from None
    columns = tuple(column.to_numpy() for column in found.columns)
    first = tuple(str(column[0]) if len(column) else "" for column in columns)
    return LogColumns(str(path), tuple(map(str, found.column_names)), columns, first)


def _of_text(path: Path) -> LogText:
    lines = read_file.lines(read_file.decoded(str(path), read_file.read(path, _LARGEST, "a log")))
    while lines and not lines[-1].strip(" \t,;\0"):
        lines.pop()
    if has_lists(lines[:_LOOKED_AT]):
        lines = lists_as_cells(lines, _separator(without_lists(lines[:_LOOKED_AT])))
    head = [(k, x) for k, x in enumerate(lines[:_LOOKED_AT]) if x.strip(" \t,;")]
    separator = _separator([text for _, text in head])
    rows = [
        (k, text.lstrip()[:1] in _MARKS, _cells(path, k + 1, _unmarked(text), separator))
        for k, text in head
    ]
    numeric = [(k, cells) for k, marked, cells in rows if not marked and _is_data(cells, separator)]
    if not numeric:
        raise FileError(
            path,
            head[0][0] + 1 if head else None,
            f"there is no row of numbers in the first {len(head)} lines; a log has a header and "
            f"one row per time, separated by commas, semicolons or tabs.",
        )
    width = Counter(len(cells) for _, cells in numeric).most_common(1)[0][0]
    at = next(k for k, _ in numeric)
    first = next(cells for _, cells in numeric if len(cells) == width)
    above = [(k, cells) for k, _, cells in rows if k < at]
    names, header = _header(path, above, width, separator)
    return LogText(str(path), lines, separator, names, header, at, tuple(first))


def _header(
    path: Path, above: list[tuple[int, list[str]]], width: int, separator: str
) -> tuple[tuple[str, ...] | None, int | None]:
    """The names of the columns and their line, from the rows above the numbers; a second row of
    names as long is of units."""
    for _, cells in above:
        if len(cells) > 1 and not cells[-1] and len(cells) == width + 1:
            cells.pop()
    fitting = [(k, cells) for k, cells in above if len(cells) == width]
    if fitting:
        k, cells = fitting[0]
        below = [units for _, units in fitting[1:2]]
        for units in below:
            cells = [f"{n} ({u.strip('()[]')})" if u else n for n, u in zip(cells, units)]  # noqa: B905  # both are of the width
        return tuple(as_meant(cell) for cell in cells), k + 1
    long = [(k, cells) for k, cells in above if len(cells) > 2]
    if long:
        k, cells = long[-1]
        hint = ""
        if separator == "," and width in (2 * len(cells), 2 * len(cells) - 1):
            hint = "; with decimal commas, separate the columns by semicolons"
        raise FileError(
            path, k + 1, f"the header names {len(cells)} columns, the rows have {width}{hint}."
        )
    return None, None


def _unmarked(text: str) -> str:
    """A line without the sign of a remark in front."""
    return text.lstrip().lstrip(_MARKS) if text.lstrip()[:1] in _MARKS else text


def _cells(file: str | Path, line: int, text: str, separator: str) -> list[str]:
    if separator == " ":
        return text.split()
    return read_file.cells(file, line, text, separator)


def _uneven_blanks(text: str) -> bool:
    """Whether blanks between columns are more than one, or stand at the ends of lines."""
    return "  " in text or " \n" in text or "\n " in text or text[:1] == " " or text[-1:] == " "


def _separator(lines: list[str]) -> str:
    """The separator by which most lines have the same number of cells."""

    def alike(mark: str) -> int:
        counts = Counter(n for n in (line.strip().count(mark) for line in lines) if n)
        return counts.most_common(1)[0][1] if counts else 0

    return max(_SEPARATORS, key=alike)


def _number(cell: str, separator: str) -> float | None:
    return read_file.number(cell if separator == "," else cell.replace(",", ".", 1))


def _is_data(cells: list[str], separator: str) -> bool:
    """Whether a row is one of numbers: half of what stands in it, at least."""
    full = [cell for cell in cells if cell]
    numbers = sum(_number(cell, separator) is not None for cell in full)
    return numbers > 0 and 2 * numbers >= len(full)
