"""Columns of a report's tables: which variable of the data is printed in which unit, and tables
whose rows are coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from freebody.report.tables import Cell, Head, PrintedNumber, ReportTable, WordsCell, table
from freebody.report.variables import VARIABLES

if TYPE_CHECKING:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study import Study


EVERYDAY = {
    "rad": (180.0 / np.pi, "°"), "m": (1e3, "mm"),
    "rad/s": (30.0 / np.pi, "rpm"), "m/s": (1e3, "mm/s"),
}  # fmt: skip
"""Units in which people speak of positions and speeds."""
_BESIDE = "°", "rpm"
"""Everyday units that stand beside those of the SI: from m to mm the decimal point is shifted."""

TableColumn = tuple[Head, Sequence[Cell]]


@dataclass(frozen=True)
class Printed:
    """A column of numbers in a table: a variable of the data along one dimension, with fixed labels
    `at` of its other dimension.

    A share is printed in percent, one of a limit with a bar.
    """

    title: str
    variable: str
    at: tuple[tuple[str, str], ...] = ()
    scale: float = 1.0
    unit: str | None = None
    """The unit, where it is not that of the variable."""
    tip: str | None = None
    everyday: bool = False
    """Whether the numbers are printed in degrees and rpm: a column beside that of the SI, blank
    for what slides."""

    def column(
        self, study: Study | CycleStudy, book: xr.Dataset, dim: str, names: Sequence[str]
    ) -> TableColumn:
        """The head and the cells of the column, for the rows `names`."""
        of = VARIABLES[self.variable]
        values = book[self.variable].sel(dict(self.at)).sel({dim: list(names)}).values
        units, scales = self._printed_in(units_of(study, dim, names, of.unit))
        known = list(dict.fromkeys(unit for unit in units if unit is not None))
        one = known[0] if len(known) == 1 else None
        cells: list[Cell] = [
            self._cell(float(x), {dim: name, **dict(self.at)}, unit, scale, unit == one)
            for x, name, unit, scale in zip(values, names, units, scales, strict=True)
        ]
        repeated = of.meaning == self.title.lower()
        tip = self.tip if self.tip is not None else "" if repeated or self.everyday else of.meaning
        return Head(self.title, one or "", tip), cells

    @property
    def _limited(self) -> bool:
        return self.variable.endswith("_fraction")

    def _printed_in(self, units: Sequence[str]) -> tuple[list[str | None], list[float]]:
        """The unit in which each row is printed, None where it is left blank, and how many of it
        are one of the data's."""
        if self._limited or self.variable.endswith("_share"):
            return ["%"] * len(units), [100.0] * len(units)
        if self.everyday:
            scales, spoken = zip(*map(EVERYDAY.__getitem__, units), strict=True)
            return [unit if unit in _BESIDE else None for unit in spoken], list(scales)
        own = units if self.unit is None else [self.unit] * len(units)
        return list(own), [self.scale] * len(units)

    def _cell(
        self, x: float, at: dict[str, str], unit: str | None, scale: float, told: bool
    ) -> Cell:
        """The cell of a number; told: whether the head of the column has its unit."""
        if unit is None or np.isinf(x):
            return WordsCell("" if self.everyday else "none", css="n none")
        counted = f"{x:.0f}" if self.variable.endswith("_segment") else ""
        own, bar = "" if told else unit, x if self._limited else None
        return PrintedNumber(x, self.variable, at, own, scale, counted, bar)


def units_of(study: Study | CycleStudy, dim: str, names: Sequence[str], unit: str) -> list[str]:
    """The units of a variable's rows."""
    turning, _, sliding = unit.removesuffix("|1").partition("|")
    if not sliding:
        return [unit if unit != "1" else ""] * len(names)
    own = {body.joint.name: "m" if body.kind.slides else "rad" for body in study.model.bodies}
    if dim == "coordinate":
        own = dict(zip(study.model.velocity_names, study.summary["unit"].values, strict=True))
    return [sliding if own.get(name) == "m" else turning for name in names]


def words_column(title: str, texts: Iterable[str], css: str = "") -> TableColumn:
    return Head(title, number=False), [WordsCell(text, css=css) for text in texts]


def effort_title(study: Study | CycleStudy, names: Sequence[str]) -> str:
    """The title of the column of peak torques, of forces where all drives slide."""
    efforts = {*units_of(study, "coordinate", names, VARIABLES["peak_torque"].unit)}
    if len(efforts) > 1:
        return "Peak torque, force"
    return "Peak force" if efforts == {"N"} else "Peak torque"


def by_coordinate(
    caption: str, study: Study | CycleStudy, names: Sequence[str], titles: Mapping[str, str],
    more: Iterable[Printed] = (), book: xr.Dataset | None = None,
) -> ReportTable:  # fmt: skip
    """A table whose rows are coordinates, numbered as their bodies are in the drawings; columns
    without a finite number are left out. titles: of the columns, with their variables; positions
    and speeds in everyday units too. book: of the numbers, by default the summary."""
    asked: list[Printed] = []
    for title, variable in titles.items():
        asked.append(Printed(title, variable))
        units = units_of(study, "coordinate", names, VARIABLES[variable].unit)
        if {EVERYDAY[x][1] for x in units if x in EVERYDAY} & {*_BESIDE}:
            asked.append(Printed("", variable, everyday=True))
    book = study.summary if book is None else book
    shown = [
        p.column(study, book, "coordinate", names)
        for p in (*asked, *more)
        if np.isfinite(book[p.variable].sel(coordinate=list(names)).values).any()
    ]
    return named_rows(caption, "Coordinate", names, shown, _numbers(study, names))


def _numbers(study: Study | CycleStudy, names: Sequence[str]) -> Sequence[int] | None:
    """The numbers in the drawings of the bodies that coordinates move; None where these are no help
    to find a row: in loops, and where a joint has several coordinates."""
    model = study.model
    if model.loops or any(body.kind.nv > 1 for body in model.bodies):
        return None
    numbers = {body.joint.name: k for k, body in enumerate(model.bodies, 1)}
    return [numbers[name] for name in names]


def named_rows(
    caption: str, title: str, names: Sequence[str], columns: Sequence[TableColumn],
    numbers: Sequence[int | str] | None,
) -> ReportTable:  # fmt: skip
    """A table of named rows, numbered where there are numbers."""
    first: list[Cell] = [WordsCell(name, strong=True) for name in names]
    heads = [Head(title, number=False), *(head for head, _ in columns)]
    listed = [first, *(cells for _, cells in columns)]
    if numbers is not None:
        heads.insert(0, Head(""))
        listed.insert(0, [WordsCell(str(n), css="count") for n in numbers])
    return table(caption, heads, listed)
