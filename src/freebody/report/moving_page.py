"""The moving parts of a study's page: the robot, one cursor through all curves, and the instants
that matter."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.figures.plots import Plot
from freebody.moving.placements import placements
from freebody.moving.renderer import renderer
from freebody.moving.scene import joint_marks, scene
from freebody.moving.shape_solids import drawn_shapes
from freebody.outputs.pages import joined, packed, packed_numbers
from freebody.report.followed import (
    SHOWN_DRIVES,
    ArrowKey,
    FollowedCurves,
    Instant,
    NowCell,
    NowRow,
    arrow_scales,
    effort_word,
    followed_drives,
    followed_plot,
    tip_velocity,
)
from freebody.report.shown_motion import ShownMotion, shown_motion
from freebody.report.tables import shortened
from freebody.report.what_if import WhatIf, peaks, what_if

if TYPE_CHECKING:
    from freebody.report.study import Study

_MARKS = 6  # instants with a button of their own
_PLAYER = "what_if", "cursor", "player"
_USED = 3  # limits whose nearest instants are marked


@dataclass(frozen=True)
class WhatRow:
    """A drive whose torques the page computes itself: its number among the drives, and what its
    joint is called on the robot."""

    name: str
    column: int
    mark: str


@dataclass(frozen=True)
class MovingPage:
    """The parts of a study's page that move: the script, and what its template writes."""

    script: str
    instants: tuple[Instant, ...]
    heads: tuple[str, ...]
    rows: tuple[NowRow, ...]
    arrows: tuple[ArrowKey, ...]
    """The arrows on the robot, and their scales."""
    bodies: str
    """Words on the solids that stand for the robot's bodies."""
    what: WhatIf
    what_rows: tuple[WhatRow, ...]


def moving_page(study: Study, plots: Sequence[Plot]) -> MovingPage:
    """The moving parts of a page with some plots over the motion's time, numbered in order."""
    marks = list(_marks(study))
    shown = shown_motion(study, [time for time, _ in marks], peaks(study))
    columns = FollowedCurves(shown.t)
    drives = list(
        followed_drives(
            study,
            lambda k: columns.own(shown.tau[:, k]),
            lambda k: columns.own(shown.qd[:, k]),
        )
    )
    efforts = {drive["name"]: drive["effort"] for drive in drives}
    drawn = [followed_plot(plot, columns, efforts) for plot in plots]
    marks_of = _marks_of(study)
    rows = tuple(_rows(study, columns, drives, shown, marks_of))
    what, arrows = what_if(study, shown), arrow_scales(study)
    bodies = drawn_shapes(study.model).words
    instants = tuple(
        Instant(k, f"{shown.t[k]:.3g}", words)
        for k, words in ((shown.index(time), words) for time, words in marks)
    )
    data = {
        "scene": scene(study.model, study.motion.q).data,
        "bodies": len(study.model.bodies),
        "nq": study.model.nq,
        "plots": drawn,
        "first": instants[0].index,
        "what": what.data,
        "nv": study.model.nv,
        "drives": drives,
        "arrows": {
            "lengths": arrows.lengths,
            "tip": [columns.number(study.motion.t, x) for x in tip_velocity(study).T],
        },
    }
    player = joined("freebody.report", [f"templates/{name}.js" for name in _PLAYER])
    nv = study.model.nv
    packs = {
        "STUDY": packed(json.dumps(data, allow_nan=False, separators=(",", ":"))),
        "TIMES": packed_numbers(shown.t),
        "POSITIONS": packed_numbers(shown.q, study.model.nq),
        "VALUES": packed_numbers(np.array(columns.found, dtype=np.float32)),
        "RATES": "" if what.rates is None else packed_numbers(what.rates, nv),
        "EXPECTED": "" if what.expected is None else packed_numbers(what.expected, nv),
    }
    for word, pack in packs.items():
        player = player.replace(f'"{word}"', f'"{pack}"')
    text = f'"use strict";\n{placements(study.model)}\n{what.script}\n{renderer()}\n{player}\n'
    names = enumerate(shortened([drive["name"] for drive in drives]))
    what_rows = tuple(WhatRow(name, k, marks_of[k]) for k, name in names)
    heads = ("position", "speed", effort_word(str(drive["unit"]) for drive in drives))
    return MovingPage(text, instants, heads, rows, arrows.keys, bodies, what, what_rows)


def _marks_of(study: Study) -> list[str]:
    """The mark that the joint of each drive has on the robot; empty without one."""
    model, marks = study.model, joint_marks(study.model, study.motion.q[0])
    return [marks[model.velocity_names.index(name)] for name in model.driven_names]


def _marks(study: Study) -> Iterator[tuple[float, str]]:
    """Times that a reader wants to see, and why: the worst instant, where limits are used most, the
    nearest singular pose."""
    t, taken = study.motion.t, set[float]()
    worst = study.worst
    words = f"worst {effort_word([worst.unit])}, {worst.coordinate}"
    wanted = [(float(t[worst.index]), words)]
    for use in study.verdict.uses[:_USED]:
        if math.isfinite(use.time):
            bound = "half range" if use.quantity == "position" else "limit"
            share = f"{100 * use.fraction:.0f} % of its {bound}"
            wanted.append((float(use.time), f"{use.quantity} of {use.coordinate}, {share}"))
    if study.singularity is not None:
        wanted.append((float(study.singularity.time), "nearest singular pose"))
    wanted.append((float(t[0]), "start"))
    for time, words in wanted[:_MARKS]:
        if time not in taken:
            taken.add(time)
            yield time, words


def _rows(
    study: Study,
    columns: FollowedCurves,
    drives: Sequence[Mapping[str, Any]],
    shown: ShownMotion,
    marks: Sequence[str],
) -> Iterator[NowRow]:
    """The rows of the table of an instant; none where a robot has many drives."""
    model, data = study.model, study.data
    driven = list(model.driven_names)
    if len(driven) > SHOWN_DRIVES:
        return
    positions = [str(x) for x in data["position"].values]
    for drive, name, short, mark in zip(drives, driven, shortened(driven), marks, strict=True):
        k = drive["coordinate"]
        unit, effort = (str(data[x].values[k]) for x in ("unit", "effort_unit"))
        at = columns.own(shown.q[:, positions.index(name)]) if name in positions else None
        yield NowRow(
            short,
            (
                None if at is None else NowCell(at, unit),
                NowCell(drive["speed"], f"{unit}/s"),
                NowCell(drive["effort"], effort),
            ),
            mark,
        )
