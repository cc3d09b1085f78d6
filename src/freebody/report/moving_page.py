"""The moving parts of a study's page: the robot, one cursor through all curves, and the instants
that matter."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.figures.plots import Plot, axes_of
from freebody.moving.placements import placements
from freebody.moving.renderer import renderer
from freebody.moving.scene import joint_axes, scene
from freebody.moving.shape_solids import drawn_shapes
from freebody.outputs.page_script import joined, packed, packed_numbers
from freebody.report.page_figures import TOTAL
from freebody.report.shown_motion import ShownMotion, shown_motion
from freebody.report.tables import shortened
from freebody.report.what_if import WhatIf, limits, peaks, round_up, what_if

if TYPE_CHECKING:
    from freebody.report.study import Study

_MARKS = 6  # instants with a button of their own
_LONGEST = 60  # pixels of an arrow on the robot, as `player.js` draws it
_DRIVES = 12  # rows of the table of an instant
_PLAYER = "what_if", "player"
_USED = 3  # limits whose nearest instants are marked


@dataclass(frozen=True)
class Instant:
    """An instant to go to: its number among those that are shown, its time in print, and why."""

    index: int
    time: str
    words: str


@dataclass(frozen=True)
class NowCell:
    """A number that follows the cursor: its column among the curves, and its unit."""

    column: int
    unit: str


@dataclass(frozen=True)
class NowRow:
    """A drive at the instant that is shown; None: it has no such number."""

    name: str
    cells: tuple[NowCell | None, ...]


@dataclass(frozen=True)
class WhatRow:
    """A drive whose torques the page computes itself: its number among the drives."""

    name: str
    column: int


@dataclass(frozen=True)
class MovingPage:
    """The parts of a study's page that move: the script, and what its template writes."""

    script: str
    instants: tuple[Instant, ...]
    heads: tuple[str, ...]
    rows: tuple[NowRow, ...]
    arrows: str
    """Words on the arrows on the robot, and their scales."""
    bodies: str
    """Words on the solids that stand for the robot's bodies."""
    what: WhatIf
    what_rows: tuple[WhatRow, ...]


def moving_page(study: Study, plots: Sequence[Plot]) -> MovingPage:
    """The moving parts of a page with some plots over the motion's time, numbered in order."""
    marks = list(_marks(study))
    shown = shown_motion(study, [time for time, _ in marks], peaks(study))
    columns = _ShownCurves(shown)
    drives = list(_drives(study, columns, shown))
    efforts = {drive["name"]: drive["effort"] for drive in drives}
    drawn = [_plotted(plot, columns, efforts) for plot in plots]
    rows = tuple(_rows(study, columns, drives, shown))
    what, arrows = what_if(study, shown), _arrows(study, columns)
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
        "arrows": {"lengths": arrows.lengths, "tip": arrows.tip},
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
    what_rows = tuple(WhatRow(name, k) for k, name in names)
    heads = ("position", "speed", "torque, force")
    return MovingPage(text, instants, heads, rows, arrows.words, bodies, what, what_rows)


def _marks(study: Study) -> Iterator[tuple[float, str]]:
    """Times that a reader wants to see, and why: the worst instant, where limits are used most, the
    nearest singular pose."""
    t, taken = study.motion.t, set[float]()
    wanted = [(float(t[study.worst.index]), f"worst torque, {study.worst.coordinate}")]
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


class _ShownCurves:
    """Curves at the instants that are shown, each once."""

    def __init__(self, shown: ShownMotion):
        self._shown, self._numbers = shown, dict[bytes, int]()
        self.found: list[NDArray[np.float32]] = []

    def number(self, curve: Array) -> int:
        """The number of a curve (T,)."""
        column = self._shown.curve(curve)
        number = self._numbers.setdefault(column.tobytes(), len(self.found))
        if number == len(self.found):
            self.found.append(column)
        return number

    def own(self, exact: Array) -> int:
        """The number of a curve by its numbers (n,) at the instants, which the page may compute
        anew: no other has it."""
        self.found.append(np.asarray(exact, dtype=np.float32))
        return len(self.found) - 1


def _drives(study: Study, columns: _ShownCurves, shown: ShownMotion) -> Iterator[dict[str, Any]]:
    """The drives as a page reads them: coordinate, columns of torque and speed, unit, limit."""
    model, data, allowed = study.model, study.data, limits(study)
    joints = joint_axes(model, study.motion.q[0])
    body_of = {k: body for body, at in enumerate(model.coordinates) for k in at.v}
    for name in model.driven_names:
        k = model.velocity_names.index(name)
        at, axis = joints[body_of[k]]
        yield {
            "at": at.data,
            "axis": axis and axis.data,
            "name": name,
            "coordinate": k,
            "effort": columns.own(shown.tau[:, k]),
            "speed": columns.own(shown.qd[:, k]),
            "unit": str(data["effort_unit"].values[k]),
            "limit": allowed[k],
        }


def _plotted(plot: Plot, columns: _ShownCurves, efforts: Mapping[str, int]) -> dict[str, Any]:
    """A plot's axes and curves as a page reads them; efforts: the column of each drive's torque,
    which is the total in the plot of its name."""

    def column(name: str, curve: Array) -> int:
        own = efforts.get(plot.title) if name == TOTAL else None
        return columns.number(curve) if own is None else own

    axes = axes_of(plot)
    return {
        "page": axes.box,
        "time": axes.time,
        "range": axes.range,
        "log": axes.log,
        "unit": plot.unit,
        "curves": [
            {"name": name, "colour": plot.colour(name), "column": column(name, curve)}
            for name, curve in plot.curves.items()
        ],
    }


def _rows(
    study: Study,
    columns: _ShownCurves,
    drives: Sequence[Mapping[str, Any]],
    shown: ShownMotion,
) -> Iterator[NowRow]:
    """The rows of the table of an instant; none where a robot has many drives."""
    model, data = study.model, study.data
    driven = list(model.driven_names)
    if len(driven) > _DRIVES:
        return
    positions = [str(x) for x in data["position"].values]
    for drive, name, short in zip(drives, driven, shortened(driven), strict=True):
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
        )


@dataclass(frozen=True)
class _Arrows:
    """The values of the longest arrows on the robot, by unit, the columns of the tip's velocity,
    and words on both."""

    lengths: dict[str, float]
    tip: list[int]
    words: str


def _arrows(study: Study, columns: _ShownCurves) -> _Arrows:
    """The arrows on the robot: the torque or force of each drive, the velocity of the tip."""
    data, model = study.data, study.model
    driven = [model.velocity_names.index(name) for name in model.driven_names]
    largest: dict[str, float] = {}
    for k in driven:
        unit = str(data["effort_unit"].values[k])
        largest[unit] = max(largest.get(unit, 0.0), float(np.abs(data["tau"].values[:, k]).max()))
    tip = []
    if study.tip is not None and "tip_velocity" in data:
        velocity = data["tip_velocity"].values
        largest["m/s"] = float(np.linalg.norm(velocity, axis=1).max())
        tip = [columns.number(x) for x in velocity.T]
    lengths = {unit: round_up(x) for unit, x in largest.items() if x > 0.0}
    forms = {
        "N m": "an arc of three quarters is a torque of {} N m",
        "N": f"an arrow of {_LONGEST} pixels at a drive is {{}} N",
        "m/s": f"an arrow of {_LONGEST} pixels at the tip is a velocity of {{}} m/s",
    }
    told = [form.format(f"{lengths[unit]:g}") for unit, form in forms.items() if unit in lengths]
    return _Arrows(lengths, tip, f"On the robot {'; '.join(told)}." if told else "")
