"""`CycleStudy`: the study of a duty cycle, from the studies of its segments.

Each is the study of the robot as it is then loaded; over the whole cycle there are RMS values,
energies, the worst instants and one verdict, rests included.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.capacity.fitted_parts import NO_PARTS, FittedParts
from freebody.capacity.limited_loads import EFFORTS, LimitedLoads
from freebody.capacity.part_loads import part_loads
from freebody.capacity.segments import LoadedSegment
from freebody.capacity.time_scaling import HeldStill, held_still, resting
from freebody.design.drive_loads import cycle_notices
from freebody.design.duty_cycle import DutyCycle
from freebody.model.doubt_rules.aspects import DYNAMIC
from freebody.model.doubts import attribute, doubts_used
from freebody.model.model import Model
from freebody.motion.ranges import ranges
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.files import write
from freebody.outputs.number_text import percent
from freebody.outputs.pdf import pdf
from freebody.report.card import Card, card
from freebody.report.load_case import LoadCase, carried_mass
from freebody.report.results import LimitUse, MotionVerdict
from freebody.report.series import coordinates
from freebody.report.summary import drive_table, energy_text, share
from freebody.report.variables import dataset
from freebody.report.verdict import judged_motion, part_uses, verdict

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.study import Study


@dataclass(frozen=True, eq=False, repr=False)
class CycleStudy(Tabled, ByValue):
    """The dynamic study of a robot over a duty cycle."""

    model: Model
    """The robot without the payloads of the segments."""
    cycle: DutyCycle
    """The cycle as it is studied: as fast as asked for."""
    segments: tuple[Study, ...]
    """The study of each segment, of the robot with its payload; rests are not in them."""
    summary: xr.Dataset
    """Along `coordinate`, over the whole cycle with its rests: RMS values, means, work, and peaks
    with their segment (from 1) and the time in it; works of all drives together."""
    verdict: MotionVerdict
    """Whether the robot can go through the cycle; uses of limits name their segment."""
    card: Card
    """Answers: what it carries besides in every segment, how much faster it can go, and what gives
    out first."""
    notices: tuple[str, ...]
    """Sentences that a reader must know: of all segments, and where they do not meet."""
    warnings: tuple[str, ...] = ()
    """About the motions, as for `Study`."""
    seconds: dict[str, float] = field(default_factory=dict)
    """The time that each part took (s), all segments together."""
    wrenches: dict[str, Array] = field(default_factory=dict)
    """Constant ones on the robot in every segment, besides those of the segments."""
    speed: float = 1.0
    """How many times as fast as given the motions are run; rests are as long as given."""
    parts: FittedParts = NO_PARTS
    """The brakes and bearings that are judged besides the drives."""
    command: str = ""
    """The command line that makes it again, where one made it."""
    _aside = ("seconds", "command")

    @property
    def load_cases(self) -> tuple[LoadCase, ...]:
        """The load case of each segment."""
        return tuple(segment.load_case for segment in self.segments)

    @property
    def loads(self) -> tuple[float, ...]:
        """The mass (kg) of the load of each segment, without what the robot carries in all."""
        always = carried_mass(self.model)
        return tuple(max(case.payload - always, 0.0) for case in self.load_cases)

    @property
    def checked(self) -> bool:
        """Whether all of freebody's checks on itself passed, in every segment."""
        return all(segment.checked for segment in self.segments)

    @property
    def passed(self) -> bool:
        """Whether the cycle is feasible beyond doubt, and all checks passed."""
        return self.checked and self.verdict.good and self.verdict.outcome == "feasible"

    @property
    def finding(self) -> bool:
        """Whether something has to be mended, as for `Study`."""
        return not (self.checked and self.verdict.good)

    @property
    def energy(self) -> str:
        """A sentence on work, braking and peak power in one cycle."""
        return energy_text(self.summary, self.cycle.duration)

    @property
    def worst(self) -> TextTable:
        """The worst instant of each segment: which drive, when, how much."""
        rows = []
        for k, study in enumerate(self.segments, 1):
            of, load = study.worst, self.loads[k - 1]
            share = "" if np.isnan(of.fraction) else percent(of.fraction)
            value = f"{of.value:.4g} {of.unit}"
            rows.append((str(k), f"{load:.4g} kg", of.coordinate, value, f"{of.time:.3g} s", share))
        head = ("segment", "its load", "worst", "torque", "at", "of effort limit")
        return TextTable(head, rows)

    def _title(self) -> str:
        count = counted(len(self.segments), "segment")
        return (
            f"Study of {self.model.name!r} over a duty cycle: {count} in "
            f"{self.cycle.duration:.4g} s; {self.verdict.heading}"
        )

    def _table(self) -> TextTable:
        found = drive_table(self.model, self.summary)
        return replace(found, notes=[self.verdict.text, *self.warnings])

    def save(self, directory: str | os.PathLike[str], *, report: bool = False) -> list[Path]:
        """The paths of the files written into a folder: card.json, summary.csv, cycle.nc and
        manifest.json of the whole, and a folder `segment-1`, … with the files of each study.

        report: report.html of the whole and of each segment as well. Raises as `Study.save`.
        """
        from freebody.report.study_files import save_cycle

        return save_cycle(self, Path(directory), report)

    def to_html(self, path: str | os.PathLike[str]) -> Path:
        """The path of the report of the whole cycle that is written as one HTML file, which opens
        offline."""
        from freebody.report.cycle_page import cycle_page

        return write(path, cycle_page(self))

    def to_pdf(self, path: str | os.PathLike[str]) -> Path:
        """The path of the report of the whole cycle that is written as PDF, as of
        `Study.to_pdf`."""
        from freebody.report.cycle_page import cycle_page

        return write(path, pdf(cycle_page(self)))


def cycle_study(
    model: Model,
    cycle: DutyCycle,
    segments: Sequence[LoadedSegment],
    studies: Sequence[Study],
    noisy: bool,
    parts: FittedParts,
) -> CycleStudy:
    """The study of a duty cycle from those of its segments; noisy: whether the noise of a motion is
    part of its torques."""
    done = [_StudiedSegment.of(x, study, parts) for x, study in zip(segments, studies, strict=True)]
    studied = DutyCycle(
        [
            replace(segment, motion=x.study.motion, wrenches=x.study.wrenches or None)
            for segment, x in zip(cycle.segments, done, strict=True)
        ],
        source=cycle.source,
    )
    found = _summary(model, done, studied)
    motions = [
        judged_motion(y.model, y.motion, y.data, y.summary, y.wrenches, x.number, parts)
        for x, y in zip(done, studies, strict=True)
    ]
    uses = [use for one in motions for use in one.uses if not use.quantity.startswith(_RMS)]
    uses += [use for x in done for use in x.held_uses()]
    rests = [resting(x.held, x.end, x.number, x.fitted) for x in done if x.held is not None]
    judged = verdict(motions, noisy, _most([*uses, *_rms_uses(model, found)]), rests)
    jumps = cycle_notices((studied,))
    warned = (*dict.fromkeys(words for study in studies for words in study.warnings), *jumps)
    told = dict.fromkeys(words for study in studies for words in study.notices)
    return CycleStudy(
        model=model,
        cycle=studied,
        segments=tuple(studies),
        summary=found,
        verdict=judged,
        card=card(model, studied, judged, None, parts),
        notices=(*told, *jumps),
        warnings=warned,
        seconds={part: sum(x.seconds[part] for x in studies) for part in studies[0].seconds},
        parts=parts,
    )


_RMS = "RMS "


@dataclass(frozen=True, eq=False)
class _StudiedSegment:
    """A segment with its study, what holds the robot still behind it (None without a rest), and
    what its brakes hold and its bearings bear there."""

    number: int
    study: Study
    dwell: float
    held: HeldStill | None
    fitted: tuple[LimitedLoads, ...] = ()

    @staticmethod
    def of(segment: LoadedSegment, study: Study, parts: FittedParts) -> _StudiedSegment:
        if not segment.dwell > 0.0:
            return _StudiedSegment(segment.number, study, segment.dwell, None)
        model, loads, q = study.model, study.wrenches, study.motion.q[-1:]
        rest, end = np.zeros((1, model.nv)), study.motion.t[-1:]
        return _StudiedSegment(
            segment.number,
            study,
            segment.dwell,
            held_still(model, q[0], loads),
            part_loads("study", model, parts, end, (q, rest, rest), loads),
        )

    @property
    def end(self) -> float:
        """The time at which its motion ends."""
        return float(self.study.motion.t[-1])

    @property
    def resting(self) -> Array:
        """The efforts (nv,) of the rest; 0 without one."""
        count = self.study.model.nv
        return np.zeros(count) if self.held is None else self.held.efforts[:count]

    def held_uses(self) -> Iterator[LimitUse]:
        """The uses of limits of torque and force, of brakes and bearings, by the rest."""
        if self.held is None:
            return
        yield from (replace(use, segment=self.number) for use in part_uses(self.fitted))
        for name, turns, value, limit in zip(
            self.held.names, self.held.turns, self.held.efforts, self.held.limits, strict=True
        ):
            if np.isfinite(limit):
                what, unit = EFFORTS[bool(turns)]
                share = abs(float(value)) / float(limit)
                yield LimitUse(what, name, float(value), float(limit), share, self.end, unit,
                               segment=self.number)  # fmt: skip


def _summary(model: Model, done: Sequence[_StudiedSegment], cycle: DutyCycle) -> xr.Dataset:
    """The dataset that `CycleStudy.summary` describes."""
    period = cycle.duration
    parts = [x.study.summary for x in done]
    moving = np.array([x.study.motion.duration for x in done])[:, None]

    def each(name: str) -> Array:
        return np.array([part[name].values for part in parts])

    still = np.array([x.resting for x in done])
    dwell = np.array([x.dwell for x in done])[:, None]
    squares = (each("rms_torque") ** 2 * moving + still**2 * dwell).sum(axis=0)
    rms = np.sqrt(squares / period)
    most = ranges(model)
    limited = np.where(np.isfinite(most.effort), most.effort, np.nan)
    work = {
        name: each(name).sum(axis=0)
        for name in (
            "work_done", "work_braked", "net_work", "total_work_done", "total_work_braked",
            "total_net_work", "shared_work_done", "shared_work_braked",
        )
    }  # fmt: skip
    higher = np.abs(still) > np.abs(each("peak_torque"))
    torque = np.where(higher, still, each("peak_torque"))
    ends = np.array([x.end for x in done])[:, None]
    found: dict[str, Any] = {
        **_largest("peak_torque", torque, np.where(higher, ends, each("peak_torque_time"))),
        **_largest("peak_speed", each("peak_speed"), each("peak_speed_time")),
        **_largest("peak_power", each("peak_power"), each("peak_power_time")),
        "rms_torque": rms,
        "mean_power": (each("mean_power") * moving).sum(axis=0) / period,
        **work,
        "regenerated_share": share(work["work_braked"], work["work_done"]),
        "total_regenerated_share": share(work["total_work_braked"], work["total_work_done"]),
        "total_peak_power": max(each("total_peak_power"), key=abs),
        "velocity_fraction": np.nanmax(each("velocity_fraction"), axis=0, initial=-np.inf),
        "effort_fraction": np.abs(torque).max(axis=0) / limited,
        "rms_fraction": rms / limited,
        "power_fraction": np.nanmax(each("power_fraction"), axis=0, initial=-np.inf),
    }
    for name in ("velocity_fraction", "power_fraction"):
        found[name] = np.where(np.isinf(found[name]), np.nan, found[name])
    wanted = ("coordinate", "unit", "effort_unit")
    named = {name: x for name, x in coordinates(model).items() if name in wanted}
    doubts = dict.fromkeys(x for one in done for x in doubts_used(one.study.model, *DYNAMIC))
    about = {"robot": model.name, "motion": cycle.source, **attribute(tuple(doubts))}
    return dataset(found, named, about)


def _largest(name: str, values: Array, times: Array) -> dict[str, Array]:
    """The value of largest magnitude of each coordinate, of values (segments, nv), with its time in
    the segment, and which that is."""
    k = np.argmax(np.abs(values), axis=0)[None]
    return {
        name: np.take_along_axis(values, k, axis=0)[0],
        f"{name}_time": np.take_along_axis(times, k, axis=0)[0],
        f"{name}_segment": k[0] + 1.0,
    }


def _rms_uses(model: Model, found: xr.Dataset) -> Iterator[LimitUse]:
    """The RMS torques and forces over the whole cycle, over the limits of effort."""
    most, driven = ranges(model), set(model.driven_names)
    for k, name in enumerate(model.velocity_names):
        limit, value = float(most.effort[k]), float(found["rms_torque"].values[k])
        if np.isfinite(limit) and name in driven:
            what, unit = EFFORTS[bool(most.turns[k])]
            yield LimitUse(_RMS + what, name, value, limit, value / limit, np.nan, unit)


def _most(uses: Sequence[LimitUse]) -> list[LimitUse]:
    """The largest use of each limit."""
    found: dict[tuple[str, str], LimitUse] = {}
    for use in uses:
        known = found.setdefault((use.quantity, use.coordinate), use)
        if use.fraction > known.fraction:
            found[use.quantity, use.coordinate] = use
    return list(found.values())
