"""How far, how fast and how hard a motion goes: between its samples too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.motion.piecewise import Extremes, PiecewisePolynomial
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.trees.position_rates import CoordinateLayout, state_of
from freebody.values import ByValue

_BETWEEN = 16
"""Places in each piece at which rates of joints with quaternions, which are no polynomials, are
looked at."""


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
    """Of position coordinates along a curve."""
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
