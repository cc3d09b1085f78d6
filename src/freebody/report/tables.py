"""Tables of a report as data: every number keeps its full value and its place in the data."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from markupsafe import Markup, escape

from freebody.motion.ranges import CLOSE
from freebody.outputs.number_text import decade, fixed, significant, superscript

_NOISE = 1e-9  # of the largest in a column: rounding, printed as 0


@dataclass(frozen=True)
class PrintedNumber:
    """A printed number: the entry `at` (labels; for time the sample's index) of an array `variable`
    of the data file.

    Printed is `sign · scale · value`; NaN is printed as a dash.
    """

    value: float
    variable: str
    at: Mapping[str, str | int]
    unit: str = ""
    """Printed behind the number, where the column has no single unit."""
    scale: float = 1.0
    text: str = ""
    bar: float | None = None
    """Share of a limit, drawn as a bar behind the number."""

    @property
    def over(self) -> bool:
        """Whether the number is beyond its limit; a number equal to it is within, as in the
        verdict."""
        return self.bar is not None and self.bar > 1.0 + CLOSE

    @property
    def selector(self) -> str:
        """The coordinates in the study's dataset at which the printed number stands, as JSON."""
        return json.dumps(dict(self.at))  # in ASCII: names arrive as they are

    @property
    def exact(self) -> str:
        """The value to the last bit."""
        return repr(float(self.value))


@dataclass(frozen=True)
class WordsCell:
    """A cell of words; `strong` for the subject of a row."""

    text: str
    strong: bool = False
    css: str = ""


Cell = PrintedNumber | WordsCell


@dataclass(frozen=True)
class Head:
    """The head of a column: its title, its unit, and what the title means."""

    text: str
    unit: str = ""
    tip: str = ""
    number: bool = True


_LETTER, _BETWEEN, _CELL = 7.0, 11.0, 34.0
"""Pixels: a letter, what is between two columns, and the least of a column of numbers."""
_COLUMN = 360.0
"""Width of one of the page's columns, pixels."""
_WHOLE = 24
"""Rows that still stay together on one sheet of paper."""


@dataclass(frozen=True)
class ReportTable:
    """A table: rows under heads; `caption` says what it shows."""

    caption: str
    heads: tuple[Head, ...]
    rows: tuple[tuple[Cell, ...], ...]

    @property
    def columns(self) -> int:
        """How many of the page's columns the table needs at least, 3 for all that there are."""
        wide = 0.0
        for k, head in enumerate(self.heads):
            texts = [head.text, head.unit, *(_whole_text(row[k]) for row in self.rows)]
            longest = max(map(len, texts)) * _LETTER
            wide += _BETWEEN + (max(longest, _CELL) if head.number and head.text else longest)
        return min(3, math.ceil(wide / _COLUMN))

    @property
    def whole(self) -> bool:
        """Whether the table stays together on one sheet of paper."""
        return len(self.rows) <= _WHOLE


def _whole_text(cell: Cell) -> str:
    """The text of a cell with the unit behind it."""
    return (
        f"{cell.text} {cell.unit}" if isinstance(cell, PrintedNumber) and cell.unit else cell.text
    )


def table(caption: str, heads: Sequence[Head], columns: Sequence[Sequence[Cell]]) -> ReportTable:
    """A table made of columns, in each of which numbers have the same number of decimals."""
    printed = [aligned(column) for column in columns]
    return ReportTable(caption, tuple(heads), tuple(zip(*printed, strict=True)))


def aligned(column: Sequence[Cell]) -> list[Cell]:
    """Cells with their text: with as many decimals as give a typical number three digits, and no
    more than five."""
    sizes = sorted(
        abs(cell.value * cell.scale)
        for cell in column
        if isinstance(cell, PrintedNumber) and math.isfinite(cell.value) and cell.value != 0
    )
    if not sizes:
        return [_printed(cell, 0, 0.0) for cell in column]
    decimals = 2 - decade(sizes[len(sizes) // 2])
    decimals = max(0, min(decimals, 4 - decade(sizes[-1])))
    return [_printed(cell, decimals, _NOISE * sizes[-1]) for cell in column]


def typeset(text: str) -> Markup:
    """Sentences as HTML, with real minus signs and powers of ten."""
    text = re.sub(r"\b10\^([\d.]+)", r"10<sup>\1</sup>", str(escape(text)))
    text = re.sub(r"(?<=\d)e([+-]\d+)", lambda m: f"·10{superscript(int(m.group(1)))}", text)
    return Markup(re.sub(r"(?<![\w.])-(?=\d)", "−", text))


def alone(number: PrintedNumber, digits: int = 3) -> PrintedNumber:
    """A number printed with digits of its own, for columns of unequal sizes."""
    return replace(number, text=significant(number.value * number.scale, digits))


def opened(text: str, most: int = 480) -> tuple[str, str]:
    """A text in two parts, the second of which a page folds: up to its last sentence or clause
    within `most` letters, and what goes on from there; all of it and "" where it is not longer."""
    if len(text) <= most:
        return text, ""
    end = max(text.rfind(mark, 0, most) for mark in (". ", "; ")) + 1
    return (text[:end], text[end:].lstrip()) if end else (text, "")


def _printed(cell: Cell, decimals: int, noise: float) -> Cell:
    """A cell printed with a given number of decimals; with digits of its own where that would give
    0, and as 0 where it is lost in `noise`."""
    if isinstance(cell, WordsCell) or cell.text:
        return cell
    size = cell.value * cell.scale
    if not math.isfinite(size):
        return replace(cell, text=significant(size))
    if abs(size) <= noise:
        return replace(cell, text="0")
    if decimals > 5 or float(f"{size:.{decimals}f}") == 0.0:
        return alone(cell, 2)
    return replace(cell, text=fixed(size, decimals))


def shortened(names: Sequence[str]) -> list[str]:
    """The names without the words that all of them begin or end with."""
    if len(names) < 2:
        return list(names)
    words = [name.split("_") for name in names]
    shortest = min(map(len, words))
    before = after = 0
    while before < shortest - 1 and len({w[before] for w in words}) == 1:
        before += 1
    while after < shortest - 1 - before and len({w[-1 - after] for w in words}) == 1:
        after += 1
    return ["_".join(w[before : len(w) - after]) for w in words]
