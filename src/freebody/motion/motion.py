"""`Motion`: positions, rates and accelerations over time, the smooth curve through them, and their
extremes, between samples too."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from freebody.arrays import (
    Array,
    above_zero,
    as_floats,
    at_sample,
    is_count,
    refuse_not_finite,
)
from freebody.errors import FreebodyError, KindError
from freebody.lazy import cached_property
from freebody.model.doubts import Doubt, in_one_line, named
from freebody.model.model import Model
from freebody.motion.piecewise import Extremes, PiecewisePolynomial, hermite
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import (
    CoordinateLayout,
    continuous,
    layout,
    position_acceleration,
    position_rate,
    state_of,
)
from freebody.trees.public_calls import vector
from freebody.values import ByValue, key

FEWEST = 4
"""Samples that a motion needs: fewer do not determine an acceleration."""
_ON_CURVE = 1e-9  # rad, m: how far samples may lie from the curve that they are samples of
NEAR = 1e-9  # of the duration: a break this near to a sample is that
_JUMP = 1e-9  # of the largest acceleration
_MEET = 1e-9  # of the largest position or rate: by how much motions in a row may miss each other
_BETWEEN = 16
"""Places in each piece at which rates of joints with quaternions, which are no polynomials, are
looked at."""


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Tabled, ByValue):
    """Samples of a motion, with quintic interpolation of position, rate and acceleration between
    them, or exactly the curve on which they lie.

    t: (T,) increasing, s. q: (T, nq). qd, qdd: (T, nv). rad and m. The interpolated curve has
    continuous accelerations; where those of an exact one jump, `qdd` has the later value.
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array
    source: str
    """Words for where the motion comes from."""
    layout: CoordinateLayout
    notices: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    """Doubts about the robot on which a planned motion rests: about its limits, of a time-optimal
    one about its masses and drives too."""
    differentiated: Literal["", "positions", "rates"] = ""
    """The samples of which the accelerations are derivatives, where they were not given."""
    pieces: PiecewisePolynomial | None = None
    """The positions (nq,) over time as they were planned; None: interpolated."""
    _aside = ("source", "notices", "doubts")
    _copies = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pieces is not None:
            breaks = self.pieces.breaks
            at_breaks = breaks is self.t or np.array_equal(breaks, self.t)
            values = self.pieces.at_breaks if at_breaks else self.pieces(self.t)
            off = np.abs(values - self.q).max()
            if not (off <= _ON_CURVE or off <= _ON_CURVE * (1.0 + np.abs(self.q).max())):
                raise FreebodyError(
                    f"Motion: its samples lie off its pieces by {off:.3g}; give pieces=None where "
                    f"q or t are replaced."
                )

    @staticmethod
    def of(
        model: Model,
        t: Any,
        q: Any = None,
        qd: Any = None,
        qdd: Any = None,
    ) -> Motion:
        """The motion of samples: arrays t (T,) in s, q (T, nq), and if known qd, qdd (T, nv); or
        one table by names.

        A table (dict, DataFrame or Dataset) is given in the place of t: `t` or `time` and the names
        of the model's positions, `name.v` and `name.a` for rates and accelerations, units as in
        `read_motion`; or what `simulate` returned, or a study's data, of one motion. Arrays may be
        by name too. At least 4 samples. What is not given is differentiated: by the quintic spline
        through the positions, or through the rates. Raises FreebodyError.
        """
        # above this module: tables are completed and smoothed there, which takes motions
        from freebody.motion.files.tables import motion_of_samples

        return motion_of_samples(model, t, q, qd, qdd)

    def _title(self) -> str:
        return (
            f"Motion: {counted(len(self.t), 'sample')}, {self.t[0]:.4g} to {self.t[-1]:.4g} s, "
            f"{self.layout.nq} positions; {self.source}{named(self.doubts)}"
        )

    def _table(self) -> TextTable:
        found, notes = self.peaks, (*filter(None, [in_one_line(self.doubts)]), *self.notices)
        rows = [
            (f"q[{k}]", f"{low:.4g} … {high:.4g}")
            for k, (low, high) in enumerate(
                zip(found.position.low, found.position.high, strict=True)
            )
        ]
        rates = [
            (f"{v:.4g}", f"{a:.4g}")
            for v, a in zip(found.velocity.size, found.acceleration.size, strict=True)
        ]
        if self.layout.flat:
            rows = [(*row, *rate) for row, rate in zip(rows, rates, strict=True)]
            return TextTable(
                (
                    "position",
                    "range (rad, m)",
                    "largest rate (rad/s, m/s)",
                    "largest acceleration (rad/s², m/s²)",
                ),
                rows,
                notes,
            )
        return TextTable(("position", "range (rad, m; quaternions 1)"), rows, notes)

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""
        return float(self.t[-1] - self.t[0])

    def at(self, t: ArrayLike, around: Array | None = None) -> tuple[Array, Array, Array]:
        """The state (q, qd, qdd) at any times t (...) within the motion: (..., nq), (..., nv),
        (..., nv).

        around: (...) other times, whose polynomials are taken and continued where t is beyond them,
        as on the near side of a jump. Raises FreebodyError for times outside the motion without it.
        """
        times = as_floats("Motion.at", "t", t)
        refuse_not_finite("Motion.at", "t", times, 0)
        if around is None:
            self._require_within(times)
            return state_of(self.layout, *(curve(times) for curve in self._curves))
        return state_of(self.layout, *(x.continued(times, around) for x in self._curves))

    def _require_within(self, times: Array) -> None:
        """Refuse times before or after the motion, apart from rounding."""
        first, last = float(self.t[0]), float(self.t[-1])
        beyond = np.maximum(first - times, times - last)
        outside = np.argwhere(beyond > NEAR * max(last - first, abs(first), abs(last)))
        if len(outside):
            index = tuple(map(int, outside[0]))
            bound = first if times[index] < first else last
            at, end = compared(float(times[index]), bound)
            end_word = "begins" if bound == first else "ends"
            raise FreebodyError(
                f"Motion.at: t is {at} s{at_sample(index)}, and the motion {end_word} at {end} s."
            )

    @cached_property
    def curve(self) -> PiecewisePolynomial:
        """The positions over time, (nq,) functions; quaternions in it are of unit length at the
        samples."""
        if self.pieces is not None:
            return self.pieces
        x = continuous(self.layout, self.q)
        return hermite(
            self.t,
            x,
            position_rate(self.layout, x, self.qd),
            position_acceleration(self.layout, x, self.qd, self.qdd),
        )

    @property
    def knots(self) -> Array:
        """Times (k,) between which the curve is a single polynomial: those of the samples and of
        the pieces' breaks."""
        if self.pieces is None:
            return self.t
        breaks = self.pieces.breaks
        breaks = breaks[np.append(True, np.diff(breaks) > NEAR * self.duration)]
        every = np.union1d(self.t, breaks)
        own = np.isin(every, self.t)
        near = np.diff(every) <= NEAR * self.duration
        twin = np.append(False, near & own[:-1]) | np.append(near & own[1:], False)
        return every[own | ~twin]

    @cached_property
    def jumps(self) -> Array:
        """Times (k,) within the motion at which accelerations jump."""
        if self.pieces is None:
            return np.empty(0)
        knots, second = self.knots, self._curves[2]
        t, between = knots[1:-1], 0.5 * (knots[1:] + knots[:-1])
        before, after = (second.continued(t, side) for side in (between[:-1], between[1:]))
        size = np.abs(before - after).max(axis=1)
        return t[size > _JUMP * second.extremes.size.max()]

    @cached_property
    def peaks(self) -> Peaks:
        """Extremes of positions, rates and accelerations, between samples too, with their times."""
        return peaks_of(self.curve, self.layout)

    @cached_property
    def _curves(self) -> tuple[PiecewisePolynomial, PiecewisePolynomial, PiecewisePolynomial]:
        return self.curve, self.curve.derivative(), self.curve.derivative(2)

    def faster(self, factor: float) -> Motion:
        """The motion run `factor` times as fast along its path from the same start (below 1:
        slower)."""
        factor = above_zero("faster", "factor", factor)
        return replace(
            self,
            t=self.t[0] + (self.t - self.t[0]) / factor,
            qd=self.qd * factor,
            qdd=self.qdd * factor**2,
            source=f"{self.source}; {factor:.4g} times as fast",
            pieces=None if self.pieces is None else self.pieces.scaled(factor),
        )

    def then(self, other: Motion) -> Motion:
        """This motion followed by the other one, whose times continue from this one's end.

        The other begins where this one ends, and as fast. Accelerations may differ; the later one
        counts at the time between. Raises FreebodyError with the entry that does not fit.
        """
        _refuse_gap(self, other)
        x = continuous(self.layout, np.stack([self.curve(self.t[-1]), other.q[0]]))
        sign = np.where(x[1] * other.curve(other.t[0]) < 0.0, -1.0, 1.0)  # of a quaternion
        turned = replace(other.curve, coefficients=other.curve.coefficients * sign)
        joined = {
            name: np.concatenate([getattr(self, name)[:-1], getattr(other, name)])
            for name in ("q", "qd", "qdd")
        }
        t = np.concatenate([self.t, self.t[-1] + (other.t[1:] - other.t[0])])
        pieces = self.curve.then(turned)
        if not self.layout.flat:
            joined["q"] = pieces(t)
        notices = tuple(dict.fromkeys((*self.notices, *other.notices)))
        doubts = tuple(dict.fromkeys((*self.doubts, *other.doubts)))
        source = self.source if other.source == self.source else f"{self.source}; {other.source}"
        both = (self.differentiated, other.differentiated)
        how = "positions" if "positions" in both else max(both)
        return Motion(
            t, **joined, source=source, layout=self.layout, notices=notices, doubts=doubts,
            differentiated=how, pieces=pieces,
        )  # fmt: skip

    def repeated(self, times: int) -> Motion:
        """The motion `times` times in a row; it ends where, and as fast as, it begins."""
        if not is_count(times):
            raise FreebodyError(f"repeated: times is {times!r}, expected a whole number from 1 on.")
        found = self
        for digit in f"{times:b}"[1:]:  # twice as many at a time: nothing is copied often
            found = found.then(found)
            found = found.then(self) if digit == "1" else found
        return replace(found, source=f"{self.source}; {times} times") if times > 1 else found


def _refuse_gap(first: Motion, second: Motion) -> None:
    """Refuse two motions the second of which does not start where the first ends."""
    if not isinstance(second, Motion):
        raise KindError("then", "other", second, "a Motion")
    if key(first.layout) != key(second.layout):
        raise FreebodyError(
            f"then: the motions are of different robots, with {first.layout.nq} and "
            f"{second.layout.nq} positions; both must be of one model."
        )
    ends = continuous(first.layout, np.stack([first.q[-1], second.q[0]]))
    speed = max(np.abs(first.qd).max(), np.abs(second.qd).max())
    for what, before, after, slack in (
        ("q", *ends, _MEET * (1.0 + np.abs(ends).max())),
        ("qd", first.qd[-1], second.qd[0], _MEET * speed),
    ):
        off = np.abs(after - before)
        k = int(np.argmax(off))
        if off[k] > slack:
            end, start = compared(before[k], after[k], digits=6)
            raise FreebodyError(
                f"then: the first motion ends with {what}[{k}] = {end}, the second begins with "
                f"{start}; plan a motion between them, such as "
                f"fb.quintic(model, [first.q[-1], second.q[0]], acceleration=...)."
            )


def require_motion(function: str, model: Model, motion: object) -> Motion:
    """The motion itself if it is one of the model; raises KindError or FreebodyError otherwise."""
    if not isinstance(motion, Motion):
        raise KindError(
            function,
            "motion",
            motion,
            "a Motion",
            "fb.read_motion reads one from a file, fb.Motion.of makes one of arrays and tables.",
        )
    if motion.q.shape[-1] != model.nq or motion.qd.shape[-1] != model.nv:
        raise FreebodyError(
            f"{function}: the motion has {motion.q.shape[-1]} positions and "
            f"{motion.qd.shape[-1]} rates, {model.name!r} has nq = {model.nq} and nv = {model.nv}."
        )
    return motion


def motion_of(model: Model, t: ArrayLike, q: ArrayLike, source: str = "given as arrays") -> Motion:
    """A motion from samples t (T,), q (T, nq): rates and accelerations are those of the quintic
    spline through q (cubic below 6 samples)."""
    times = vector_of_times(t)
    positions = vector("motion", model, "q", q)
    where = layout(model)
    if positions.shape[0] != len(times):
        raise FreebodyError(
            f"motion: q has {positions.shape[0]} rows, t has {len(times)}; they must be as many."
        )
    positions = continuous(where, positions)
    states = state_of(where, positions, *derivatives(times, positions))
    return Motion(times, *states, source, where, differentiated="positions")


def derivatives(t: Array, x: Array, at_rest: bool = False) -> tuple[Array, Array]:
    """First and second derivative of samples x (T, n): of the quintic spline through them, cubic
    below 6 samples.

    at_rest: with rate and acceleration zero at both ends; otherwise not-a-knot.
    """
    degree = 5 if len(t) >= 6 else 3
    ends = [(k, np.zeros(x.shape[1])) for k in range(1, (degree + 1) // 2)]
    spline = make_interp_spline(t, x, k=degree, bc_type=(ends, ends) if at_rest else None)
    return spline.derivative()(t), spline.derivative(2)(t)


def vector_of_times(t: ArrayLike) -> Array:
    """The times t as (T,) increasing finite floats, at least `FEWEST`."""
    times = as_floats("motion", "t", t)
    if times.ndim != 1 or len(times) < FEWEST:
        raise FreebodyError(f"motion: t has shape {times.shape}, expected at least {FEWEST} times.")
    if not np.isfinite(times).all():
        raise FreebodyError("motion: t holds a value that is not finite.")
    late = np.flatnonzero(np.diff(times) <= 0)
    if len(late):
        k = int(late[0]) + 1
        now, before = compared(times[k], times[k - 1], digits=6)
        raise FreebodyError(f"motion: t must increase; t[{k}] = {now} follows {before}.")
    return times


@dataclass(frozen=True, eq=False, repr=False)
class Peaks(Tabled, ByValue):
    """Extremes of a motion's positions (nq,), rates and accelerations (nv,), with their times (s).

    Exact for coordinates that are numbers of their own; of joints with quaternions the extremes of
    16 places between neighbouring samples.
    """

    position: Extremes
    velocity: Extremes
    acceleration: Extremes

    def _title(self) -> str:
        return f"Peaks of {counted(len(self.position.low), 'position')}"

    def _table(self) -> TextTable:
        named = {"q": self.position, "qd": self.velocity, "qdd": self.acceleration}
        rows = [
            (f"{name}[{k}]", *entries)
            for name, found in named.items()
            for k, *entries in found._table().rows
        ]
        units = ("Units: rad or m, and s.",)
        return TextTable(("", "lowest", "at t (s)", "highest", "at t (s)"), rows, units)


def peaks_of(curve: PiecewisePolynomial, where: CoordinateLayout) -> Peaks:
    """Extremes of position coordinates along a curve, of their rates and accelerations."""
    functions = curve, curve.derivative(), curve.derivative(2)
    exact = [function.extremes for function in functions]
    if where.flat:
        return Peaks(*exact)
    t = np.unique(np.linspace(curve.breaks[:-1], curve.breaks[1:], _BETWEEN + 1))
    seen = state_of(where, *(function(t) for function in functions))
    found = []
    for columns, values, of in zip(
        (where.plain[0], where.plain[1], where.plain[1]), seen, exact, strict=True
    ):
        entries = _sampled(t, values)
        for name in ("low", "low_at", "high", "high_at"):
            entries[name][columns] = getattr(of, name)[where.plain[0]]
        found.append(Extremes(**entries))
    return Peaks(*found)


def _sampled(t: Array, values: Array) -> dict[str, Array]:
    low, high = values.argmin(axis=0), values.argmax(axis=0)
    return {
        "low": values.min(axis=0),
        "low_at": t[low],
        "high": values.max(axis=0),
        "high_at": t[high],
    }
