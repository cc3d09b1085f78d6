"""`Motion`: positions, rates and accelerations over time, and the smooth curve through them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from freebody.arrays import Array, as_floats
from freebody.errors import FreebodyError
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.motion.piecewise import PiecewisePolynomial, hermite
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.trees.position_rates import (
    CoordinateLayout,
    continuous,
    layout,
    position_acceleration,
    position_rate,
    state_of,
)
from freebody.trees.public_calls import vector
from freebody.values import ByValue

FEWEST = 4
"""Samples that a motion needs: fewer do not determine an acceleration."""


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Tabled, ByValue):
    """Samples of a motion, with quintic interpolation of position, rate and acceleration between
    them.

    t: (T,) increasing, s. q: (T, nq). qd, qdd: (T, nv). rad and m. The curve has continuous
    accelerations.
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array
    source: str
    """Where the motion comes from, in words."""
    layout: CoordinateLayout
    notices: tuple[str, ...] = ()
    differentiated: Literal["", "positions", "rates"] = ""
    """What samples the accelerations are derivatives of, where they were not given."""
    _aside = ("source", "notices")
    _copies = True

    def _title(self) -> str:
        return (
            f"Motion: {counted(len(self.t), 'sample')}, {self.t[0]:.4g} to {self.t[-1]:.4g} s, "
            f"{self.layout.nq} "
            f"positions; {self.source}"
        )

    def _table(self) -> TextTable:
        rows = [(f"q[{k}]", f"{x.min():.4g} … {x.max():.4g}") for k, x in enumerate(self.q.T)]
        rates = [
            (f"{abs(v).max():.4g}", f"{abs(a).max():.4g}")
            for v, a in zip(self.qd.T, self.qdd.T, strict=True)
        ]
        if self.layout.flat:
            rows = [(*row, *rate) for row, rate in zip(rows, rates, strict=True)]
            return TextTable(
                ("position", "range", "largest rate", "largest acceleration"), rows, self.notices
            )
        return TextTable(("position", "range"), rows, self.notices)

    @property
    def duration(self) -> float:
        """s."""
        return float(self.t[-1] - self.t[0])

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """(q, qd, qdd) at any times t (...) within the motion: (..., nq), (..., nv), (..., nv)."""
        curve, rate, second = self._curves
        return state_of(self.layout, curve(t), rate(t), second(t))

    @cached_property
    def curve(self) -> PiecewisePolynomial:
        """The positions over time, (nq,) functions; quaternions in it are of unit length at the
        samples."""
        x = continuous(self.layout, self.q)
        return hermite(
            self.t,
            x,
            position_rate(self.layout, x, self.qd),
            position_acceleration(self.layout, x, self.qd, self.qdd),
        )

    @cached_property
    def _curves(self) -> tuple[PiecewisePolynomial, PiecewisePolynomial, PiecewisePolynomial]:
        return self.curve, self.curve.derivative(), self.curve.derivative(2)


def motion_of(
    model: Model,
    t: ArrayLike,
    q: ArrayLike,
    qd: ArrayLike | None = None,
    qdd: ArrayLike | None = None,
    source: str = "given as arrays",
    notices: tuple[str, ...] = (),
) -> Motion:
    """A motion from samples t (T,), q (T, nq); rates and accelerations that are not given are
    differentiated.

    Missing rates are those of the quintic spline through q (cubic below 6 samples); missing
    accelerations are those of the same spline, or where qd is given, of the spline through qd.
    """
    times = vector_of_times(t)
    positions = vector("motion", model, "q", q)
    where = layout(model)
    if positions.shape[0] != len(times):
        raise FreebodyError(
            f"motion: q has {positions.shape[0]} rows, t has {len(times)}; they must be as many."
        )
    positions = continuous(where, positions)
    first, second = derivatives(times, positions)
    found = state_of(where, positions, first, second)
    rates = found[1] if qd is None else vector("motion", model, "qd", qd)
    if qdd is not None:
        accelerations = vector("motion", model, "qdd", qdd)
    else:
        accelerations = found[2] if qd is None else derivatives(times, rates)[0]
    differentiated = "" if qdd is not None else "positions" if qd is None else "rates"
    return Motion(times, found[0], rates, accelerations, source, where, notices, differentiated)


def derivatives(t: Array, x: Array, at_rest: bool = False) -> tuple[Array, Array]:
    """First and second derivative of samples x (T, n): of the quintic spline through them, cubic
    below 6 samples.

    at_rest: with rate and acceleration zero at both ends; otherwise not-a-knot.
    """
    degree = 5 if len(t) >= 6 else 3
    ends = [(k, np.zeros(x.shape[1])) for k in range(1, (degree + 1) // 2)]
    spline = make_interp_spline(t, x, k=degree, bc_type=(ends, ends) if at_rest else None)  # type: ignore[arg-type]
    return spline.derivative()(t), spline.derivative(2)(t)


def vector_of_times(t: ArrayLike) -> Array:
    """t as (T,) increasing finite floats, at least `FEWEST`."""
    times = as_floats("motion", "t", t)
    if times.ndim != 1 or len(times) < FEWEST:
        raise FreebodyError(f"motion: t has shape {times.shape}, expected at least {FEWEST} times.")
    if not np.isfinite(times).all():
        raise FreebodyError("motion: t holds a value that is not finite.")
    late = np.flatnonzero(np.diff(times) <= 0)
    if len(late):
        k = int(late[0]) + 1
        raise FreebodyError(
            f"motion: t must increase; t[{k}] = {times[k]:g} follows {times[k - 1]:g}."
        )
    return times
