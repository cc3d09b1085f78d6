"""`compare`: two or more studies beside each other: what differs between them, their verdicts, and
what each drive has to give."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, listed
from freebody.model.named_numbers import ModelParameter, parameters
from freebody.motion.motion import Motion
from freebody.motion.ranges import ranges
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.files import write
from freebody.outputs.number_text import percent, significant
from freebody.outputs.pdf import pdf
from freebody.report.card import CardRow
from freebody.report.study import Study

_FEWEST = 2
_MOST = 8
"""Studies whose curves have colours of their own."""


_ALIKE = 5e-4
"""Relative: what differs by less prints alike."""


_SAME = 1e-9
"""rad, m: motions that differ by less are the same."""


_NUMBERS = 8
"""Numbers of robots that are told where they differ."""


class CaseRow(NamedTuple):
    """Something of which studies are made, in words, study by study."""

    what: str
    each: tuple[str, ...]


class DriveRow(NamedTuple):
    """The drives of all studies that stand beside each other, "" where a robot has none."""

    name: str
    """Their name, or their names with a stroke between."""
    of: tuple[str, ...]


@dataclass(frozen=True)
class Compared:
    """A quantity of drives that studies are compared by, a variable of their summaries."""

    title: str
    variable: str
    unit: str
    """The unit of a drive that turns, and behind a stroke that of one that slides."""

    def text(self, study: Study, drive: str) -> str:
        """The quantity of one drive with its unit; a dash where it has none."""
        value = self.value(study, drive)
        if not math.isfinite(value):
            return "–"
        if self.unit == "%":
            return percent(value)
        return f"{significant(value)} {self.unit_of(study, drive)}"

    def unit_of(self, study: Study, drive: str) -> str:
        """The unit of the quantity of one drive, which turns or slides; empty where it has none."""
        if not drive:
            return ""
        turning, _, sliding = self.unit.partition("|")
        slides = str(study.summary["unit"].sel(coordinate=drive).values) == "m"
        return sliding if slides and sliding else turning

    def value(self, study: Study, drive: str) -> float:
        """The quantity of one drive; NaN where it has none."""
        return float(study.summary[self.variable].sel(coordinate=drive)) if drive else math.nan


_QUANTITIES = (
    Compared("peak torque", "peak_torque", "N m|N"),
    Compared("RMS torque", "rms_torque", "N m|N"),
    Compared("peak, of its limit", "effort_fraction", "%"),
    Compared("peak speed", "peak_speed", "rad/s|m/s"),
    Compared("speed, of its limit", "velocity_fraction", "%"),
    Compared("peak power", "peak_power", "W"),
    Compared("work done", "work_done", "J"),
)
"""Drives are compared by these quantities."""


@dataclass(frozen=True, eq=False, repr=False)
class StudyComparison(Tabled):
    """Studies beside each other."""

    names: tuple[str, ...]
    """The names of the studies, in their order."""
    studies: tuple[Study, ...]
    differences: tuple[CaseRow, ...]
    """The differences of the robots, their loads and their motions, in words."""
    drives: tuple[DriveRow, ...]
    by_order: bool
    """Whether drives stand beside each other by their order, since their names are unlike."""

    def _title(self) -> str:
        return f"Comparison of {listed(map(repr, self.names), _MOST)}"

    def _table(self) -> TextTable:
        rows: list[tuple[str, ...]] = [(one.what, *one.each) for one in self.differences]
        rows += [("verdict", *(study.verdict.heading for study in self.studies))]
        rows += [(one.what, *one.each) for one in self.answers]
        peak = _QUANTITIES[0]
        rows += [(f"{peak.title} of {row.name}", *self.texts(peak, row)) for row in self.drives]
        return TextTable(("", *self.names), rows, [self.matched])

    @property
    def quantities(self) -> tuple[Compared, ...]:
        """The quantities that drives are compared by: torques, speeds, power and work."""
        return _QUANTITIES

    @property
    def answers(self) -> tuple[CaseRow, ...]:
        """The rows of the studies' cards beside each other."""
        rows = [study.card.rows for study in self.studies]
        labels = ("carries", "can be run", "gives out first")
        return tuple(
            CaseRow(label, tuple(_answer(own[k], label) for own in rows))
            for k, label in enumerate(labels)
        )

    @property
    def matched(self) -> str:
        """How drives stand beside each other, in a sentence."""
        return (
            "The robots' drives have unlike names; they stand beside each other in their order."
            if self.by_order
            else "Drives stand beside each other by their names."
        )

    def texts(self, quantity: Compared, row: DriveRow) -> tuple[str, ...]:
        """A quantity of one row of drives, study by study: after the first with how many times it
        is what it is there."""
        first = abs(quantity.value(self.studies[0], row.of[0]))
        unit = quantity.unit_of(self.studies[0], row.of[0])
        found = []
        for k, (study, drive) in enumerate(zip(self.studies, row.of, strict=True)):
            ratio = abs(quantity.value(study, drive)) / first if first > 0 else math.nan
            like = quantity.unit_of(study, drive) == unit != "%"
            times = k > 0 and like and math.isfinite(ratio) and abs(ratio - 1.0) >= _ALIKE
            found.append(
                quantity.text(study, drive) + (f" (× {significant(ratio, 3)})" if times else "")
            )
        return tuple(found)

    @property
    def unlike_kinds(self) -> tuple[str, ...]:
        """The rows in which a drive that turns stands beside one that slides: no axis has both."""
        peak = _QUANTITIES[0]
        return tuple(
            row.name
            for row in self.drives
            if len({peak.unit_of(*x) for x in zip(self.studies, row.of, strict=True)} - {""}) > 1
        )

    def alike(self, quantity: Compared) -> bool:
        """Whether a quantity is the same in all studies, drive by drive."""
        for row in self.drives:
            pairs = zip(self.studies, row.of, strict=True)
            values = np.array([quantity.value(study, drive) for study, drive in pairs])
            if not np.allclose(values, values[0], rtol=_ALIKE, atol=0.0, equal_nan=True):
                return False
        return True

    @property
    def together(self) -> DriveRow:
        """The row of all drives of each robot together."""
        return DriveRow("Power of all drives", ("all",) * len(self.studies))

    def limits(self, row: DriveRow) -> set[float]:
        """The effort limits of one row of drives (N m, N); infinite ones where there is none."""
        return {
            float(ranges(study.model).effort[study.model.velocity_names.index(drive)])
            for study, drive in zip(self.studies, row.of, strict=True)
            if drive
        }

    def over_time(
        self, row: DriveRow, values: Callable[[Study, str], Array]
    ) -> tuple[Array, dict[str, Array]]:
        """(t, curves): a quantity of one row of drives over the time since each motion's start, a
        curve a study, at the samples of all; NaN after a motion's end."""
        having = [x for x in zip(self.names, self.studies, row.of, strict=True) if x[2]]
        times = [study.motion.t - study.motion.t[0] for _, study, _ in having]
        t = np.unique(np.concatenate(times))
        curves = {
            name: np.interp(t, own, values(study, drive), right=np.nan)
            for own, (name, study, drive) in zip(times, having, strict=True)
        }
        return t, curves

    def to_html(self, path: str | os.PathLike[str]) -> Path:
        """The path of the comparison that is written as one HTML file, which opens offline."""
        from freebody.report.comparison_page import comparison_page

        return write(path, comparison_page(self))

    def to_pdf(self, path: str | os.PathLike[str]) -> Path:
        """The path of the comparison that is written as PDF, printed by a Chromium, Chrome or Edge
        that is at hand."""
        from freebody.report.comparison_page import comparison_page

        return write(path, pdf(comparison_page(self)))


def compare(studies: Mapping[str, Study] | Sequence[Study]) -> StudyComparison:
    """Studies beside each other: other loads, other designs, other robots.

    Parameters
    ----------
    studies
        Two to eight of `fb.study`, each of one motion: by the names that they shall have, or in a
        list; they are then called after the first thing in which they all differ: the robot, the
        load, the pace, else by their numbers.

    Returns
    -------
    StudyComparison
        What differs, verdicts, answers and the drives' needs; `.to_html("comparison.html")` has the
        curves over each other. Drives stand beside each other by name, and where the names are
        unlike in their order, which it says.

    Raises
    ------
    FreebodyError
        Fewer than two studies or more than eight, or what is no study of one motion.
    """
    if not isinstance(studies, Mapping | Sequence) or isinstance(studies, str):
        raise FreebodyError(
            "compare: studies are a list of studies, or a mapping from names to studies."
        )
    if isinstance(studies, Mapping):
        return compared([str(name) for name in studies], list(studies.values()))
    return compared(None, studies)


def compared(names: Sequence[str] | None, studies: Sequence[Study]) -> StudyComparison:
    """Studies beside each other, which have names of their own or, with None, are called after what
    differs. Refuses what `compare` refuses."""
    given = list(studies)
    for k, study in enumerate(given):
        if not isinstance(study, Study):
            raise FreebodyError(
                f"compare: studies[{k}] is {type(study).__name__}, expected a study of one motion, "
                f"such as fb.study(model); of a duty cycle compare its segments."
            )
    if not _FEWEST <= len(given) <= _MOST:
        raise FreebodyError(
            f"compare: {counted(len(given), 'study')} given, expected {_FEWEST} to {_MOST}."
        )
    called = _called(given) if names is None else _named(names)
    described = [one for one in _given(given) if len(set(one.each)) > 1]
    drives, by_order = _beside(given)
    differences = (*described, *_unlike_numbers(given))
    return StudyComparison(called, tuple(given), differences, drives, by_order)


def _answer(row: CardRow, label: str) -> str:
    """The value of a row of a card, with what its own label says beyond one that all share."""
    beyond = row.label.removeprefix(label) if row.label.startswith(label) else ""
    return f"{row.value} {row.unit}".strip() + beyond


def _given(studies: Sequence[Study]) -> list[CaseRow]:
    """The robots, loads and motions of the studies, in words."""
    cases = [study.load_case.words for study in studies]
    kinds = ("load", "wrenches", "mounting", "parts", "tip", "changed")
    return [
        CaseRow("robot", tuple(study.model.name for study in studies)),
        CaseRow("joints", tuple(counted(len(s.model.driven_names), "drive") for s in studies)),
        CaseRow("mass", tuple(f"{float(s.model.mass):.4g} kg" for s in studies)),
        *(CaseRow(kind, tuple(case.get(kind, "–") for case in cases)) for kind in kinds),
        CaseRow("motion", tuple(_motion_words(study, studies[0]) for study in studies)),
        CaseRow("pace", tuple(f"{study.speed:.4g} times as given" for study in studies)),
        CaseRow("duration", tuple(f"{study.motion.duration:.4g} s" for study in studies)),
    ]


def _unlike_numbers(studies: Sequence[Study]) -> list[CaseRow]:
    """The numbers in which robots differ that are made of the same parts, the first few; gravity
    and loads are told in words."""
    tables = [
        {
            one.name: _number_words(one)
            for one in parameters(study.model)
            if one.name != "g" and not one.name.startswith(("gravity.", "payload."))
        }
        for study in studies
    ]
    if any(table.keys() != tables[0].keys() for table in tables):
        return []
    rows = [CaseRow(name, tuple(table[name] for table in tables)) for name in tables[0]]
    rows = [row for row in rows if len(set(row.each)) > 1]
    further = len(rows) - _NUMBERS
    if further > 0:
        words = f"{further} more differ" if further > 1 else "1 more differs"
        return [*rows[:_NUMBERS], CaseRow("further numbers", (words,) * len(studies))]
    return rows


def _number_words(one: ModelParameter) -> str:
    """A number of a robot with its unit, "none" where it is infinite or not given."""
    value = float("nan") if one.value is None else float(one.value)
    if not math.isfinite(value):
        return "none"
    return f"{value:.4g}".replace("-", "−") + ("" if one.unit == "1" else f" {one.unit}")


def _motion_words(study: Study, first: Study) -> str:
    """Words on a motion, which differ from the first's where the motion does."""
    own, other = study.motion, first.motion
    words = own.source or "given"
    told_apart = own.source != other.source or _alike(own, other)
    return words if told_apart else f"another one: {words}"


def _alike(a: Motion, b: Motion) -> bool:
    """Whether two motions agree where both have samples; each has some of its own, at its peaks."""
    if a.q.shape[1] != b.q.shape[1] or a.duration != b.duration:
        return False
    both, i, j = np.intersect1d(a.t, b.t, return_indices=True)
    return 2 * len(both) > len(a.t) and np.allclose(a.q[i], b.q[j], rtol=0.0, atol=_SAME)


def _named(given: Sequence[str]) -> tuple[str, ...]:
    """The names of studies as they were given; refuses those by which nobody tells them apart."""
    names = tuple(name.strip() for name in given)
    for name in names:
        if not name:
            raise FreebodyError("compare: a study is named ''; give it a word.")
        if names.count(name) > 1:
            raise FreebodyError(f"compare: two studies are named {name!r}; give each its own name.")
    return names


def _called(studies: Sequence[Study]) -> tuple[str, ...]:
    """Names of studies by the first thing in which they all differ, else their numbers."""
    choices = (
        [study.model.name for study in studies],
        [f"{study.load_case.payload:.4g} kg" for study in studies],
        [f"{study.speed:.4g} times as fast" for study in studies],
    )
    numbers = [f"study {k}" for k in range(1, len(studies) + 1)]
    return tuple(next((x for x in choices if len(set(x)) == len(x)), numbers))


def _beside(studies: Sequence[Study]) -> tuple[tuple[DriveRow, ...], bool]:
    """The rows of drives, and whether they stand beside each other by their order: where no two
    robots have a name in common."""
    drives = [study.model.driven_names for study in studies]
    every = list(dict.fromkeys(name for own in drives for name in own))
    if len(every) < sum(map(len, drives)):
        return tuple(
            DriveRow(name, tuple(name if name in own else "" for own in drives)) for name in every
        ), False
    rows = []
    for k in range(max(map(len, drives))):
        of = tuple(own[k] if k < len(own) else "" for own in drives)
        rows.append(DriveRow(" / ".join(filter(None, of)), of))
    return tuple(rows), True
