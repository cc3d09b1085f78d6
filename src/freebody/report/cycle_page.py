"""The page of a duty cycle: its verdict and card, what each drive has to give over the whole, and
each segment with its load."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.figures.plots import Plot, plot
from freebody.motion.ranges import ranges
from freebody.outputs.display import counted
from freebody.outputs.number_text import percent
from freebody.report.page import rendered, source
from freebody.report.page_figures import CaptionedDrawing, robot
from freebody.report.page_tables import drives
from freebody.report.printed_columns import by_coordinate
from freebody.report.tables import Head, ReportTable, WordsCell, table, typeset

if TYPE_CHECKING:
    from freebody.report.cycle_study import CycleStudy

_CONTENTS = (
    ("verdict", "Verdict"),
    ("answer", "Drives"),
    ("segments", "Segments"),
    ("torques", "Torques"),
    ("power", "Power"),
)
_NAMED = 6
"""Segments whose curves have colours and names of their own."""


def cycle_page(study: CycleStudy) -> str:
    """The HTML text of the page of a duty cycle."""
    checks = [check for segment in study.segments for check in segment.checks]
    name, _ = source(study.model)
    return rendered(
        "cycle.html",
        study=study,
        model=study.model,
        contents=_CONTENTS,
        math_style="",
        source=name,
        checks=checks,
        failed=[check for check in checks if not check.passed],
        notices={"findings": list(study.warnings), "reading": []},
        robot=_robot(study),
        drives=drives(study),
        work=work(study),
        segments=segments(study),
        cases=[(k, case.words) for k, case in enumerate(study.load_cases, 1)],
        torques=list(torques(study)),
        power=power(study),
        count=counted(len(study.segments), "segment"),
    )


def work(study: CycleStudy) -> ReportTable:
    """The table of the work that each drive delivers and absorbs in one cycle."""
    columns = {
        "Work done": "work_done",
        "Work braked": "work_braked",
        "Net": "net_work",
        "Braked / done": "regenerated_share",
        "Mean power": "mean_power",
        "Power / limits": "power_fraction",
    }
    caption = "Work of each drive in one cycle"
    return by_coordinate(caption, study, study.model.driven_names, columns)


def segments(study: CycleStudy) -> ReportTable:
    """The table of the segments: how long each is, what it carries, and its worst instant."""
    rows = []
    each = zip(study.cycle.segments, study.segments, study.loads, strict=True)
    for given, segment, load in each:
        worst = segment.worst
        rows.append(
            (
                f"{segment.motion.duration:.4g} s",
                f"{given.dwell:.4g} s" if given.dwell else "–",
                f"{load:.4g} kg",
                worst.coordinate,
                f"{worst.value:.4g} {worst.unit}",
                f"{worst.time:.3g} s",
                percent(worst.fraction) if np.isfinite(worst.fraction) else "–",
            )
        )
    heads = ("moves", "rests", "its load", "worst drive", "torque, force", "at", "of its limit")
    columns = [[WordsCell(typeset(text)) for text in column] for column in zip(*rows, strict=True)]
    names = [WordsCell(str(k), strong=True) for k in range(1, len(rows) + 1)]
    return table(
        "Segments of the cycle",
        [Head("Segment", number=False), *(Head(text, number=False) for text in heads)],
        [names, *columns],
    )


def torques(study: CycleStudy) -> Iterator[CaptionedDrawing]:
    """Plots of the torque of each drive over the whole cycle, interrupted while it rests."""
    limits, units = ranges(study.model).effort, study.summary["effort_unit"].values
    for name in study.model.driven_names:
        k = study.model.velocity_names.index(name)
        t, curves = _over_cycle(study, [x.data["tau"].values[:, k] for x in study.segments])
        bounds = (-float(limits[k]), float(limits[k])) if np.isfinite(limits[k]) else ()
        what = Plot(name, t, curves, str(units[k]), bounds, peaks=False, names=len(curves) > 1)
        yield CaptionedDrawing(plot(what))


def power(study: CycleStudy) -> CaptionedDrawing:
    """The plot of the power of all drives together over the whole cycle."""
    t, curves = _over_cycle(study, [x.data["motor_power"].values for x in study.segments])
    what = Plot("Power of all drives", t, curves, "W", peaks=False, names=len(curves) > 1)
    return CaptionedDrawing(plot(what))


def _over_cycle(study: CycleStudy, values: list[Array]) -> tuple[Array, dict[str, Array]]:
    """Times of all samples of a cycle from its start, and curves over them: one a segment, of many
    segments one for all."""
    times, ends, now = [], [], 0.0
    for given, segment in zip(study.cycle.segments, study.segments, strict=True):
        own = segment.motion.t - segment.motion.t[0] + now
        times += [own, [own[-1]]]  # behind the segment a gap
        now = float(own[-1]) + given.dwell
        ends.append(len(own) + 1)
    joined = np.concatenate([part for x in values for part in (x, [np.nan])])
    t = np.concatenate([*times, [now]])
    joined = np.append(joined, np.nan)
    if len(values) > _NAMED or len(values) == 1:
        return t, {"all segments": joined}
    starts = np.cumsum([0, *ends])
    k = np.arange(len(joined))
    return t, {
        f"segment {n}": np.where((k >= a) & (k < b), joined, np.nan)
        for n, (a, b) in enumerate(pairwise(starts), 1)
    }


def _robot(study: CycleStudy) -> CaptionedDrawing:
    """The drawing of the robot at the worst instant of all segments."""
    shares = [np.nan_to_num(segment.worst.fraction) for segment in study.segments]
    k = int(np.argmax(shares))
    drawing = robot(study.segments[k])
    return CaptionedDrawing(drawing.picture, f"Segment {k + 1}. {drawing.caption}")
