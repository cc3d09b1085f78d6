"""`Segment` and `DutyCycle`: what a robot does over and over, with what it carries meanwhile."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats
from freebody.by_value import ByValue
from freebody.design.tip_places import TipPlaces
from freebody.errors import FreebodyError, KindError, UnknownNameError, listed, require_kind, shown
from freebody.formats import read_file
from freebody.formats.toml_table import TomlTable, table_of
from freebody.model.inertia import Inertia
from freebody.model.model import Model
from freebody.motion.files.csv_files import read_motion
from freebody.motion.motion import Motion, require_motion
from freebody.motion.planning.point_to_point import quintic
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import compared

_MEET = 1e-6
"""rad, m: how far apart one motion may end and the next begin."""
_JUMP = 0.01
"""Share of the highest rate by which rates may differ there, as in measured motions."""

CarriedLoad = float | Inertia | Mapping[str, Any] | None
"""A mass (kg) at the tip, an Inertia in the tip's axes, or arguments of `Model.with_payload`."""


@dataclass(frozen=True, eq=False)
class Segment(ByValue):
    """One motion of a duty cycle, what the robot carries meanwhile, and the rest behind it.

    motion: of the robot. payload: a mass (kg) at the tip, an `fb.Inertia` in its axes, or a dict of
    the arguments of `Model.with_payload`, such as {"mass": 15, "com": [0, 0, 0.1]}; None: none.
    wrenches: {frame: (6,) or (T, 6)}, or an array for the tip: forces (N) and moments (N m) that
    the surroundings exert on the robot at the frame's origin, world axes, constant or at each
    sample of the motion; in the plane (3,) or (T, 3). dwell: how long the drives then hold the
    robot where the motion ends (s), under the last wrench.
    """

    motion: Motion
    payload: CarriedLoad = None
    wrenches: Any = None
    dwell: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.motion, Motion):
            raise KindError("Segment", "motion", self.motion, "a Motion")
        dwell = self.dwell
        if isinstance(dwell, bool) or not isinstance(dwell, int | float | np.number):
            raise FreebodyError(f"Segment: dwell is {shown(dwell)}, expected seconds.")
        if not 0.0 <= dwell < np.inf:
            raise FreebodyError(f"Segment: dwell is {dwell:g} s, expected 0 or more.")
        object.__setattr__(self, "dwell", float(dwell))
        if isinstance(self.payload, Mapping):
            for name in self.payload:
                if name not in (*_LOAD, "name"):
                    raise UnknownNameError("entry", name, "Segment: payload", _LOAD)
        elif isinstance(self.payload, bool):
            raise KindError("Segment", "payload", self.payload, "a mass (kg)")
        wrenches = self.wrenches
        if isinstance(wrenches, Mapping):
            wrenches = {
                name: as_floats("Segment", f"wrenches[{name!r}]", w) for name, w in wrenches.items()
            }
        elif wrenches is not None:
            wrenches = as_floats("Segment", "wrenches", wrenches)
        object.__setattr__(self, "wrenches", wrenches)
        super().__post_init__()

    @property
    def duration(self) -> float:
        """Duration of the motion and of the rest behind it, s."""
        return self.motion.duration + self.dwell

    def carried_by(self, model: Model) -> Model:
        """The model with the segment's payload."""
        if self.payload is None:
            return model
        if isinstance(self.payload, Mapping):
            loaded = model.with_payload(**self.payload)
        else:
            loaded = model.with_payload(self.payload)
        if loaded.family:
            raise FreebodyError(
                "Segment: payload has arrays of numbers; give one payload, and a segment or a duty "
                "cycle for each other one."
            )
        return loaded

    def states(self) -> tuple[Array, Array, Array, Any, Array]:
        """(q, qd, qdd, wrenches, seconds) at the samples, and once more where the robot rests:
        seconds (T,) is how long each stands for, by trapezia."""
        m, rests = self.motion, self.dwell > 0.0
        half = 0.5 * np.diff(m.t)
        seconds = np.append(half, 0.0) + np.append(0.0, half)
        q, qd, qdd = m.q, m.qd, m.qdd
        if rests:
            q = np.concatenate([q, q[-1:]])
            qd, qdd = (np.concatenate([x, 0.0 * x[-1:]]) for x in (qd, qdd))
            seconds = np.append(seconds, self.dwell)
        return q, qd, qdd, self._wrenches(len(m.t), rests), seconds

    def _wrenches(self, samples: int, rests: bool) -> Any:
        def of(w: Array) -> Array:
            if w.ndim == 1:
                return w
            if w.ndim != 2 or len(w) != samples:
                raise FreebodyError(
                    f"Segment: a wrench has shape {w.shape}; give one, or one for each of the "
                    f"{samples} samples of the motion."
                )
            return np.concatenate([w, w[-1:]]) if rests else w

        if self.wrenches is None:
            return None
        if isinstance(self.wrenches, Mapping):
            return {name: of(w) for name, w in self.wrenches.items()}
        return of(self.wrenches)


@dataclass(frozen=True, eq=False, repr=False)
class DutyCycle(Tabled, ByValue):
    """Segments that a robot goes through one after another, over and over: loaded there, empty
    back.

    Each begins where the one before ends; FreebodyError otherwise. It should end and begin at the
    same rates, at rest where it dwells: `jumps` tells where not.
    """

    segments: Sequence[Segment]
    source: str = ""
    """Words for where the cycle comes from."""
    _aside = ("source",)

    def __post_init__(self) -> None:
        given: Any = self.segments
        alone = (given,) if isinstance(given, Segment | Motion) else given
        require_kind("DutyCycle", "segments", alone, Iterable, "segments, fb.Segment(motion, …)")
        parts = tuple(alone)
        parts = tuple(Segment(x) if isinstance(x, Motion) else x for x in parts)
        for part in parts:
            if not isinstance(part, Segment):
                raise KindError("DutyCycle", "segments", part, "segments, fb.Segment(motion, …)")
        if not parts:
            raise FreebodyError("DutyCycle: there is no segment; give fb.Segment(motion, …).")
        object.__setattr__(self, "segments", parts)
        for k, (first, second) in enumerate(pairwise(parts), 1):
            self._refuse_gap(k, first, second)
        super().__post_init__()

    @staticmethod
    def _refuse_gap(k: int, first: Segment, second: Segment) -> None:
        end, start = first.motion.q[-1], second.motion.q[0]
        if end.shape != start.shape:
            raise FreebodyError(
                f"DutyCycle: segments {k} and {k + 1} are of robots with {len(end)} and "
                f"{len(start)} positions."
            )
        off = np.abs(end - start)
        j = int(np.argmax(off))
        if off[j] > _MEET:
            ends, begins = compared(end[j], start[j], digits=6)
            raise FreebodyError(
                f"DutyCycle: segment {k} ends with q[{j}] = {ends}, segment {k + 1} begins with "
                f"{begins}; put a segment with the motion between them."
            )

    @property
    def duration(self) -> float:
        """Duration of one cycle, s."""
        return sum(segment.duration for segment in self.segments)

    @property
    def closes(self) -> bool:
        """Whether it ends where it begins."""
        first, last = self.segments[0].motion, self.segments[-1].motion
        return bool(np.abs(last.q[-1] - first.q[0]).max() <= _MEET)

    @property
    def jumps(self) -> tuple[str, ...]:
        """Sentences on rates that change at once between segments, or where one dwells."""
        behind = list(pairwise(self.segments))
        if self.closes:
            behind.append((self.segments[-1], self.segments[0]))
        found = []
        for k, (first, second) in enumerate(behind, 1):
            ends, starts = first.motion.qd[-1], second.motion.qd[0]
            off = np.abs(ends - starts)
            if first.dwell > 0.0:
                off = np.maximum(np.abs(ends), np.abs(starts))
            most = max(float(np.abs(x.motion.qd).max()) for x in (first, second))
            j = int(np.argmax(off))
            if off[j] > _JUMP * most:
                found.append(
                    f"Behind segment {k} qd[{j}] jumps by {off[j]:.4g}: the torque that this takes "
                    f"is not counted."
                )
        return tuple(found)

    @staticmethod
    def read(model: Model, path: str | os.PathLike[str]) -> DutyCycle:
        """The duty cycle of a model that a TOML file describes, a table [[segment]] for each
        segment.

        Its keys: `motion`, a CSV file beside it as `read_motion` reads it; or `points`, positions
        of the joints, or `tip`, places of the tip, to go through from rest to rest, with their
        `times` in s or within the model's limits and an `acceleration`. A place is a point (m,
        world axes), or with an orientation behind it, roll, pitch and yaw, in the plane one angle;
        of all positions that reach it the one nearest to the position before, first to the model's
        home, or the one at which the tip was there before. `payload`, a table of the arguments of
        `Model.with_payload`; `wrench`,
        tables with `frame`, `force` and `moment`; `dwell` in s. Raises FileError with the line.
        """
        file = Path(read_file.path_of("DutyCycle.read", "path", path, "a TOML file"))
        text = read_file.decoded(str(file), read_file.read(file, what="a duty cycle"))
        top = table_of(str(file), text).only("segment")
        places = TipPlaces(model)
        segments = [
            _segment(model, table.called(f"[[segment]] {k}"), file.parent, places)
            for k, table in enumerate(top.tables("segment"), 1)
        ]
        if not segments:
            top.refuse("there is no segment; write [[segment]] above each.")
        try:
            return DutyCycle(tuple(segments), source=file.name)
        except FreebodyError as problem:
            top.refuse(str(problem))

    def _title(self) -> str:
        return (
            f"Duty cycle: {counted(len(self.segments), 'segment')} in {self.duration:.4g} s"
            f"{'; ' if self.source else ''}{self.source}"
        )

    def _table(self) -> TextTable:
        rows = [
            (str(k), f"{x.motion.duration:.4g} s", f"{x.dwell:.4g} s", _load_words(x.payload),
             x.motion.source)
            for k, x in enumerate(self.segments, 1)
        ]  # fmt: skip
        return TextTable(("segment", "motion", "dwell", "payload", "source"), rows)


def _load_words(payload: CarriedLoad) -> str:
    mass = payload.get("mass") if isinstance(payload, Mapping) else payload
    mass = mass.mass if isinstance(mass, Inertia) else mass
    return "none" if mass is None else f"{mass:.4g} kg"


_WAYS = ("motion", "points", "tip")
"""Keys that say where a segment leads."""


def _segment(model: Model, table: TomlTable, folder: Path, places: TipPlaces) -> Segment:
    table.only(*_WAYS, "times", "acceleration", "payload", "wrench", "dwell")
    if sum(key in table for key in _WAYS) != 1:
        table.refuse(
            "give the file of a motion, motion = ..., or points or places of the tip to go "
            "through, points = ... or tip = ..., and one of these."
        )
    try:
        motion = (
            read_motion(model, folder / table.text("motion"))
            if "motion" in table
            else _planned(model, table, places)
        )
        places.arrived(motion.q[-1])
        segment = Segment(
            motion, _payload(table), _wrenches(table, model), table.number("dwell", default=0.0)
        )
        segment.carried_by(model)
    except FreebodyError as problem:
        if str(problem).startswith(table.file):
            raise
        table.refuse(str(problem))
    return segment


def _planned(model: Model, table: TomlTable, places: TipPlaces) -> Motion:
    rows = _points(model, table) if "points" in table else places.reached(table)
    times = table.vector("times", len(rows)) if "times" in table else None
    return quintic(model, rows, times, acceleration=table.number("acceleration", "number", None))


def _points(model: Model, table: TomlTable) -> list[list[float]]:
    """Positions of the joints, of a closed chain of the driven ones."""
    names = model.driven_names if model.loops else model.position_names
    rows = table.listed(table.data["points"], "points", None)
    each = listed(names, 8)
    return [
        [table.read_number(x, "angle", ("points", i, j)) for j, x in enumerate(row)]
        for i, row in enumerate(
            table.listed(row, "points", len(names), i, each=each) for i, row in enumerate(rows)
        )
    ]


_LOAD = ("mass", "com", "box", "cylinder", "inertia", "frame")


def _payload(table: TomlTable) -> dict[str, Any] | None:
    given = table.table("payload")
    if given is None:
        return None
    given = given.called(f"{table.where}, payload").only(*_LOAD)
    found: dict[str, Any] = {"mass": given.number("mass")}
    for key in _LOAD[1:-1]:
        if key in given:
            numbers = given.listed(given.data[key], key, None)
            found[key] = [given.read_number(x, "number", (key, k)) for k, x in enumerate(numbers)]
    return found | ({"frame": given.text("frame")} if "frame" in given else {})


def _wrenches(table: TomlTable, model: Model) -> dict[str, Array] | None:
    found: dict[str, Array] = {}
    dim = model.dim
    for one in table.tables("wrench"):
        one = one.called(f"{table.where}, wrench").only("frame", "force", "moment")
        frame = one.text("frame")
        if frame not in model.frame_names:
            one.unknown("frame", frame, model.frame_names, "frame")
        zero = (0.0,) * (3 if dim == 3 else 1)
        force = one.vector("force", dim, default=(0.0,) * dim)
        wrench = np.array((*force, *one.vector("moment", len(zero), default=zero)))
        found[frame] = found.get(frame, 0.0) + wrench
    return found or None


Cycles = DutyCycle | Segment | Motion | Sequence[DutyCycle | Segment | Motion]
"""One duty cycle, or several that a robot has to be able to do alike; a motion is a cycle of its
own."""


def duty_cycles(function: str, model: Model, given: Cycles) -> tuple[DutyCycle, ...]:
    """The duty cycles of a model that a function was given; their motions fit the model."""
    alone = isinstance(given, DutyCycle | Segment | Motion)
    several: Any = (given,) if alone else given
    if isinstance(several, str | os.PathLike) or not isinstance(several, Iterable):
        raise KindError(function, "cycles", given, "a DutyCycle, a Motion, or a list of these")
    several = tuple(several)
    for k, one in enumerate(several):
        kinds = DutyCycle, Segment, Motion
        require_kind(function, f"cycles[{k}]", one, kinds, "a DutyCycle, a Segment or a Motion")
    found = tuple(
        one if isinstance(one, DutyCycle) else DutyCycle((one,))
        for one in (Segment(x) if isinstance(x, Motion) else x for x in several)
    )
    if not found:
        raise FreebodyError(f"{function}: there is no duty cycle; give one, or a motion.")
    for cycle in found:
        for segment in cycle.segments:
            require_motion(function, model, segment.motion)
    return found
