"""Curves that follow the cursor of a page, and arrows on its robots: of drives, and of the velocity
of the tip."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.figures.plots import Plot, axes_of
from freebody.moving.scene import joint_axes
from freebody.report.page_figures import TOTAL
from freebody.report.what_if import limits, round_up

if TYPE_CHECKING:
    from freebody.report.study import Study

SHOWN_DRIVES = 12
"""Drives in the table of an instant, at most."""
_KEPT = "\N{NO-BREAK SPACE}"
_KEYS = {
    "N m": ("moment", "torque of a drive: ¾ of a turn is"),
    "N": ("external", "force of a drive: this long is"),
    "m/s": ("velocity", "velocity of the tip: this long is"),
}
"""Arrows by their unit: their class (of `figures.colours`), and words that a number follows."""


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
    mark: str = ""
    """The mark that its joint has on the robot; empty without one."""


class FollowedCurves:
    """Curves at the instants t (n,) that a page shows, each once."""

    def __init__(self, t: Array):
        self._t, self._numbers = t, dict[bytes, int]()
        self.found: list[NDArray[np.float32]] = []

    def number(self, t: Array, curve: Array) -> int:
        """The number of a curve (T,) over t (T,); between these it is straight, as it is drawn, and
        after them there is none."""
        values = np.interp(self._t, t, np.asarray(curve, dtype=float), right=np.nan)
        column = values.astype(np.float32)
        number = self._numbers.setdefault(column.tobytes(), len(self.found))
        if number == len(self.found):
            self.found.append(column)
        return number

    def own(self, exact: Array) -> int:
        """The number of a curve by its numbers (n,) at the instants, which the page may compute
        anew: no other has it."""
        self.found.append(np.asarray(exact, dtype=np.float32))
        return len(self.found) - 1


def followed_drives(
    study: Study, effort: Callable[[int], int], speed: Callable[[int], int]
) -> Iterator[dict[str, Any]]:
    """The drives as a page reads them: coordinate, unit, limit, place and axis on the robot, and
    the numbers of the curves that `effort` and `speed` give each coordinate."""
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
            "effort": effort(k),
            "speed": speed(k),
            "unit": str(data["effort_unit"].values[k]),
            "limit": allowed[k],
        }


def followed_plot(
    plot: Plot, columns: FollowedCurves, efforts: Mapping[str, int]
) -> dict[str, Any]:
    """A plot's axes and curves as a page reads them; efforts: the column of each drive's torque,
    which is the total in the plot of its name."""

    def column(name: str, curve: Array) -> int:
        own = efforts.get(plot.title) if name == TOTAL else None
        return columns.number(plot.t, curve) if own is None else own

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


def tip_velocity(study: Study) -> Array:
    """The velocity (T, dim) of the tip of a study, m/s; no columns where it has none."""
    if study.tip is None or "tip_velocity" not in study.data:
        return np.empty((len(study.motion.t), 0))
    return study.data["tip_velocity"].values


@dataclass(frozen=True)
class ArrowKey:
    """A kind of arrows on robots as a key shows it: its class, whether it is an arc, and words that
    tell what the arrow beside them stands for."""

    css: str
    turns: bool
    words: str


@dataclass(frozen=True)
class ArrowScales:
    """The values of the longest arrows on robots, by unit, and their keys."""

    lengths: dict[str, float]
    keys: tuple[ArrowKey, ...]


def arrow_scales(*studies: Study) -> ArrowScales:
    """The scales of the arrows on the robots of studies, the same for all: the torque or force of
    each drive, the velocity of the tip."""
    largest: dict[str, float] = {}
    for study in studies:
        model, data = study.model, study.data
        for k in map(model.velocity_names.index, model.driven_names):
            unit = str(data["effort_unit"].values[k])
            most = float(np.abs(data["tau"].values[:, k]).max())
            largest[unit] = max(largest.get(unit, 0.0), most)
        speed = np.linalg.norm(tip_velocity(study), axis=1)
        largest["m/s"] = max(largest.get("m/s", 0.0), float(speed.max()))
    lengths = {unit: round_up(x) for unit, x in largest.items() if x > 0.0}
    keys = (
        ArrowKey(css, unit == "N m", f"{words} {f'{lengths[unit]:g} {unit}'.replace(' ', _KEPT)}")
        for unit, (css, words) in _KEYS.items()
        if unit in lengths
    )
    return ArrowScales(lengths, tuple(keys))


def effort_word(units: Iterable[str]) -> str:
    """The word for the efforts of drives by their units: torque, force, or both."""
    turns = [unit == "N m" for unit in units]
    return "torque" if all(turns) else "torque, force" if any(turns) else "force"
