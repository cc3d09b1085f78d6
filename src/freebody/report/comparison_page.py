"""The page of a comparison: what differs, the verdicts, what the drives have to give, and their
curves over each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.errors import listed
from freebody.figures.plots import Plot, plot
from freebody.report.comparison_motion import moving_comparison
from freebody.report.page import filled
from freebody.report.page_figures import CaptionedDrawing, numbered, robot
from freebody.report.tables import Cell, Head, ReportTable, WordsCell, table, typeset

if TYPE_CHECKING:
    from collections.abc import Sequence

    from freebody.report.comparison import Compared, DriveRow, StudyComparison
    from freebody.report.study import Study

_CONTENTS = (
    ("differences", "What differs"),
    ("robots", "Robots"),
    ("drives", "Drives"),
    ("torques", "Torques"),
    ("speeds", "Speeds"),
    ("power", "Power"),
)


def comparison_page(found: StudyComparison) -> str:
    """The HTML text of a comparison's page."""
    alike = [one.title for one in found.quantities if found.alike(one)]
    plots, over_time = numbered(
        {
            "torques": list(_over_time(found, "tau", "effort_unit", limited=True)),
            "speeds": list(_over_time(found, "qd", "unit", suffix="/s")),
            "power": _power(found),
        }
    )
    moving = moving_comparison(found, over_time)
    return filled(
        "comparison.html",
        scripts=(moving.script,),
        moving=moving,
        found=found,
        contents=_CONTENTS,
        math_style="",
        robot=_only([study.model.name for study in found.studies]),
        differences=_differences(found),
        robots=[
            ComparedRobot(name, study, robot(study), end)
            for name, study, end in zip(found.names, found.studies, moving.ends, strict=True)
        ],
        drives=[_drives(found, one) for one in found.quantities if one.title not in alike],
        alike=listed(alike),
        plots=plots,
        apart=_apart(found),
    )


@dataclass(frozen=True)
class ComparedRobot:
    """A robot beside others on the page: its name, its study, how it is drawn still, and the end of
    its motion (s) where others go on."""

    name: str
    study: Study
    still: CaptionedDrawing
    end: float | None

    @property
    def tone(self) -> str:
        """The class of its verdict, by which the page colours it."""
        return _tone(self.study)


def _tone(study: Study) -> str:
    good = study.verdict.good
    return "ok" if good and study.verdict.outcome == "feasible" else "" if good else "bad"


def _only(names: Sequence[str]) -> str:
    """The name that all have; empty where they differ."""
    return names[0] if len(set(names)) == 1 else ""


def _apart(found: StudyComparison) -> str:
    """Words on drives that no plot shows, since one turns and one slides."""
    rows = listed(found.unlike_kinds)
    return f" Not drawn, since one turns and one slides: {rows}." if rows else ""


def _differences(found: StudyComparison) -> ReportTable:
    """The table of what differs and what comes of it, a column a study."""
    subjects = [WordsCell(x.what, strong=True) for x in (*found.differences, *found.answers)]
    subjects.insert(len(found.differences), WordsCell("verdict", strong=True))
    columns = []
    for k, study in enumerate(found.studies):
        given, answers = (
            [WordsCell(typeset(one.each[k]), css="said") for one in rows]
            for rows in (found.differences, found.answers)
        )
        verdict = WordsCell(study.verdict.heading, css=f"said {_tone(study)}")
        columns.append([*given, verdict, *answers])
    return table("What differs, and what comes of it", _heads(found), [subjects, *columns])


def _heads(found: StudyComparison, numbers: bool = False) -> list[Head]:
    return [Head("", number=False), *(Head(name, number=numbers) for name in found.names)]


def _drives(found: StudyComparison, quantity: Compared) -> ReportTable:
    """The table of one quantity of all drives."""
    texts = [found.texts(quantity, row) for row in found.drives]
    names: list[Cell] = [WordsCell(row.name, strong=True) for row in found.drives]
    columns: list[list[Cell]] = [
        [WordsCell(typeset(one), css="n") for one in column] for column in zip(*texts, strict=True)
    ]
    title = quantity.title[0].upper() + quantity.title[1:]
    return table(title, _heads(found, numbers=True), [names, *columns])


def _over_time(
    found: StudyComparison, variable: str, unit: str, suffix: str = "", limited: bool = False
) -> Iterator[CaptionedDrawing]:
    """Plots of a variable of each drive, a curve a study."""

    def values(study: Study, drive: str) -> Array:
        return study.data[variable].sel(coordinate=drive).values

    for row in found.drives:
        units = {
            str(study.data[unit].sel(coordinate=drive).values)
            for study, drive in _having(found, row)
        }
        if row.name in found.unlike_kinds:
            continue
        limits = found.limits(row)
        same = limited and len(limits) == 1 and np.isfinite(next(iter(limits)))
        bounds = (-min(limits), min(limits)) if same else ()
        yield _plot(found, row, row.name, units.pop() + suffix, values, bounds)


def _having(found: StudyComparison, row: DriveRow) -> list[tuple[Study, str]]:
    return [pair for pair in zip(found.studies, row.of, strict=True) if pair[1]]


def _power(found: StudyComparison) -> list[CaptionedDrawing]:
    """The plot of the power of all drives together, a curve a study."""
    every = found.together
    return [_plot(found, every, every.name, "W", lambda study, _: study.data["motor_power"].values)]


def _plot(
    found: StudyComparison, row: DriveRow, title: str, unit: str,
    values: Callable[[Study, str], Array], limits: tuple[float, ...] = (),
) -> CaptionedDrawing:  # fmt: skip
    t, curves = found.over_time(row, values)
    colours = {name: k for k, name in enumerate(found.names)}
    what = Plot(title, t, curves, unit, limits, peaks=False, colours=colours)
    return CaptionedDrawing(plot(what), plot=what)
