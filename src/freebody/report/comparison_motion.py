"""The moving part of a comparison's page: the robots beside each other under one cursor, with one
camera and one scale for their arrows."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array
from freebody.figures.plots import Plot
from freebody.moving.placements import NAME, placements
from freebody.moving.renderer import renderer
from freebody.moving.scene import Scene, scene
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
from freebody.report.shown_motion import MOST

if TYPE_CHECKING:
    from freebody.report.comparison import DriveRow, StudyComparison
    from freebody.report.study import Study

_FILES = "templates/cursor.js", "templates/together.js"


@dataclass(frozen=True)
class MovingComparison:
    """The parts of a comparison's page that move: the script, and what its template writes."""

    script: str
    instants: tuple[Instant, ...]
    rows: tuple[NowRow, ...]
    """The torque or force of each drive at the instant, study by study."""
    arrows: tuple[ArrowKey, ...]
    """The arrows on the robots, and their scales."""
    bodies: str
    """Words on the solids that stand for the robots' bodies."""
    ends: tuple[float | None, ...]
    """The ends of the motions that end before another does, s."""


def moving_comparison(found: StudyComparison, plots: Sequence[Plot]) -> MovingComparison:
    """The moving parts of a page with some plots over the time since each motion's start, numbered
    in order."""
    studies, t = found.studies, _shown(found)
    columns, arrows = FollowedCurves(t), arrow_scales(*studies)
    kernels: dict[str, int] = {}
    seen = _seen_alike([scene(study.model, study.motion.q) for study in studies])
    efforts: list[dict[str, NowCell]] = []
    robots: list[dict[str, Any]] = []
    for study, own in zip(studies, seen, strict=True):
        since = _since(study)
        drives = list(_drives(study, columns))
        efforts.append({x["name"]: NowCell(x["effort"], x["unit"]) for x in drives})
        tip = [columns.number(since, x) for x in tip_velocity(study).T]
        robots.append(
            {
                "scene": own.data,
                "bodies": len(study.model.bodies),
                "nq": study.model.nq,
                "kernel": kernels.setdefault(placements(study.model), len(kernels)),
                "positions": packed_numbers(_positions(study, t), study.model.nq),
                "drives": drives,
                "arrows": {"lengths": arrows.lengths, "tip": tip},
            }
        )
    instants = tuple(_worst(found, t))
    data = {
        "robots": robots,
        "plots": [followed_plot(plot, columns, {}) for plot in plots],
        "first": instants[0].index,
    }
    script = joined("freebody.report", _FILES)
    packs = {
        "COMPARISON": packed(json.dumps(data, allow_nan=False, separators=(",", ":"))),
        "TIMES": packed_numbers(t),
        "VALUES": packed_numbers(np.array(columns.found, dtype=np.float32)),
    }
    for word, pack in packs.items():
        script = script.replace(f'"{word}"', f'"{pack}"')
    alone = ",\n".join(f"(() => {{\n{text}\nreturn {NAME};\n}})()" for text in kernels)
    longest = t[-1]
    return MovingComparison(
        f'"use strict";\nconst kernels = [{alone}];\n{renderer()}\n{script}\n',
        instants,
        tuple(_rows(found.drives, efforts)),
        arrows.keys,
        " ".join(
            dict.fromkeys(filter(None, (drawn_shapes(study.model).words for study in studies)))
        ),
        tuple(float(end) if (end := _since(s)[-1]) < longest else None for s in studies),
    )


def _since(study: Study) -> Array:
    """The times (T,) of a study's samples since its motion's start, s."""
    return study.motion.t - study.motion.t[0]


def _shown(found: StudyComparison) -> Array:
    """The instants (n,) that a page shows: samples of all studies, of many some evenly apart, and
    the worst of each."""
    times = [_since(study) for study in found.studies]
    every = np.unique(np.concatenate(times))
    even = np.linspace(0, len(every) - 1, min(len(every), MOST)).round().astype(int)
    own = [
        [time[study.worst.index], time[-1]]
        for time, study in zip(times, found.studies, strict=True)
    ]
    return np.unique(np.concatenate([every[even], *own]))


def _positions(study: Study, t: Array) -> Array:
    """The positions (n, nq) of a robot at times t (n,) since its motion's start, and at its end
    afterwards; of closed chains at the nearest samples, where the loops are closed."""
    motion, since = study.motion, _since(study)
    if not study.model.loops:
        return motion.at(np.minimum(t, since[-1]) + motion.t[0])[0]
    middles = (since[1:] + since[:-1]) / 2.0
    return motion.q[np.searchsorted(middles, t)]


def _drives(study: Study, columns: FollowedCurves) -> Iterator[dict[str, Any]]:
    """The drives of one study, with its own torques and speeds."""
    since = _since(study)

    def number(variable: str, k: int) -> int:
        return columns.number(since, study.data[variable].values[:, k])

    return followed_drives(study, lambda k: number("tau", k), lambda k: number("qd", k))


def _seen_alike(scenes: Sequence[Scene]) -> list[Scene]:
    """The scenes with one view and one floor for those of the plane, and for those of space."""
    found = []
    for own in scenes:
        like = [other for other in scenes if other.dim == own.dim]
        boxes = np.array([other.box for other in like])
        found.append(
            replace(
                own,
                view=like[0].view,
                box=np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]),
                level=min(other.level for other in like),
                step=max(other.step for other in like),
            )
        )
    return found


def _worst(found: StudyComparison, t: Array) -> Iterator[Instant]:
    """The worst instant of each study, and the start."""
    for name, study in zip(found.names, found.studies, strict=True):
        time = float(_since(study)[study.worst.index])
        index = int(np.argmin(np.abs(t - time)))
        words = f"{name}: worst {effort_word([study.worst.unit])}, {study.worst.coordinate}"
        yield Instant(index, f"{time:.3g}", words)
    yield Instant(0, "0", "start")


def _rows(drives: Sequence[DriveRow], efforts: Sequence[dict[str, NowCell]]) -> Iterator[NowRow]:
    """The rows of the table of an instant; none where the robots have many drives."""
    if len(drives) <= SHOWN_DRIVES:
        for row in drives:
            cells = zip(efforts, row.of, strict=True)
            yield NowRow(row.name, tuple(own.get(drive) for own, drive in cells))
