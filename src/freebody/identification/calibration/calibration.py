"""`Calibration`: the geometry of a robot as measured poses tell it, how surely, and what they do
not tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, check_core
from freebody.by_value import ByValue
from freebody.errors import UnknownNameError
from freebody.identification.reported import Reported
from freebody.model.model import Model
from freebody.outputs.display import TextTable, counted

CalibrationOutcome = Literal["calibrated", "no better", "does not fit"]
NumberSource = Literal["measured", "partly", "prior"]

_MEASURED, _PRIOR = 0.25, 0.9
"""Share of the prior's variance that is left of what counts as measured, and from which on it is
the prior's."""
_TERMS, _VISIBLE = 4, 0.01
"""Terms of a combination that are printed at most, and the weight from which on one is."""


def source_of(share: float) -> NumberSource:
    """Where a number comes from by the share of the prior's variance that is left of it."""
    if share <= _MEASURED:
        return "measured"
    return "prior" if share >= _PRIOR else "partly"


@dataclass(frozen=True)
class CalibratedParameter:
    """A number of the geometry: by how much it is off from the model's. lower … upper: its interval
    of 95 %. prior: its standard deviation beforehand. share: of the prior's variance that is left,
    1 where the poses tell nothing of it by itself. source: measured, partly, or the prior's."""

    name: str
    unit: str
    value: float
    lower: float
    upper: float
    prior: float
    share: float
    source: NumberSource


@dataclass(frozen=True)
class Combination:
    """A combination of the geometry's numbers, each counted in standard deviations of its prior.
    weights: by name, of length 1. value, deviation: what it is found to be, and how surely, where 0
    and 1 are the prior's. source: measured, partly, or the prior's."""

    weights: Mapping[str, float]
    value: float
    deviation: float
    source: NumberSource

    def __str__(self) -> str:
        visible = [x for x in self.weights.items() if abs(x[1]) > _VISIBLE]
        largest = sorted(visible, key=lambda x: -abs(x[1]))
        terms = [f"{w:+.2f} {name}" for name, w in largest[:_TERMS]]
        return " ".join([*terms, *(["…"] if len(largest) > _TERMS else [])])


@dataclass(frozen=True)
class PoseErrors:
    """Root mean squares of distances (m) and turns (rad; None where points were measured) between
    measured and predicted poses."""

    position: float
    rotation: float | None

    def __str__(self) -> str:
        said = f"{1e3 * self.position:.3g} mm"
        return said if self.rotation is None else f"{said}, {1e3 * self.rotation:.3g} mrad"


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Reported, ByValue):
    """The geometry of a robot that measured poses give.

    model: with the geometry found. parameters: how far its numbers are off, joint by joint.
    combinations: what the poses tell, the surest first, and what they leave to the prior.
    covariance: (k, k) of the parameters, in their units. instrument: (4, 4), its pose in the world.
    marker: (4, 4), its pose in `frame`; without measured rotations turned as it was assumed. noise:
    standard deviation of each coordinate, m and rad. before: errors of the model as it was, after:
    as it is now; apart: of each pose predicted from the others; validation, validation_before: of
    poses that were used for nothing else, or None. left_out: indices of wild poses. misfits: in
    words, what the errors that are left depend on. next_poses: (m, nq), which to measure next.
    """

    model: Model
    frame: str
    parameters: tuple[CalibratedParameter, ...]
    combinations: tuple[Combination, ...]
    covariance: Array
    gears: Array
    """Factors (nq,) of the readings, 1 where none was asked for."""
    instrument: Array
    marker: Array
    noise: PoseErrors
    before: PoseErrors
    after: PoseErrors
    apart: PoseErrors
    validation: PoseErrors | None
    validation_before: PoseErrors | None
    left_out: tuple[int, ...]
    misfits: tuple[str, ...]
    next_poses: Array
    outcome: CalibrationOutcome
    """Whether poses are predicted better than before, and as well as they were measured."""
    verdict: str
    notices: tuple[str, ...]
    _aside = ("verdict", "notices")

    @property
    def trusted(self) -> bool:
        """Whether the geometry predicts poses better than before, and nothing else is left."""
        return self.outcome == "calibrated"

    def __getitem__(self, name: str) -> CalibratedParameter:
        for x in self.parameters:
            if x.name == name:
                return x
        raise UnknownNameError("parameter", name, "calibration", [x.name for x in self.parameters])

    def positions(self, readings: ArrayLike) -> Array:
        """The positions (..., nq) of the calibrated model's joints at readings (..., nq) of the
        robot's encoders: these times the gear factors."""
        given = as_floats("positions", "readings", readings)
        check_core("positions", "readings", given, (self.model.nq,))
        return given * self.gears

    def _of_source(self, source: NumberSource) -> list[Combination]:
        return [x for x in self.combinations if x.source == source]

    def _title(self) -> str:
        told = counted(len(self._of_source("measured")), "measured combination")
        return f"Calibration of {self.model.name} at {self.frame}: {told}; {self.outcome}"

    def _table(self) -> TextTable:
        wanted = {
            "before": self.before,
            "after": self.after,
            "each from the others": self.apart,
            "held out, before": self.validation_before,
            "held out, after": self.validation,
        }
        rows = [
            (
                name,
                f"{1e3 * x.position:.4g}",
                "" if x.rotation is None else f"{1e3 * x.rotation:.4g}",
            )
            for name, x in wanted.items()
            if x is not None
        ]
        head = ("errors", "position (RMS, mm)", "rotation (RMS, mrad)")
        return TextTable(head, rows, (self.verdict, *self.notices))

    def _sections(self) -> list[tuple[str, TextTable]]:
        head = ("parameter", "off by", "95 %", "beforehand ±", "unit", "comes from")
        rows = [
            (
                x.name,
                f"{x.value:.4g}",
                "–" if x.source == "prior" else f"{x.lower:.4g} … {x.upper:.4g}",
                f"{x.prior:.4g}",
                x.unit,
                _SOURCES[x.source],
            )
            for x in self.parameters
        ]
        prior = [(f"  {x}",) for x in self._of_source("prior")]
        said = "Not told by these poses, in standard deviations of the prior:"
        return [("", TextTable(head, rows)), *([(said, TextTable((), prior))] if prior else [])]


_SOURCES = {"measured": "the poses", "partly": "poses and prior", "prior": "the prior"}


def combinations_of(names: tuple[str, ...], covariance: Array, values: Array) -> list[Combination]:
    """The combinations of numbers, in standard deviations of their prior, from the surest to the
    prior's own; covariance: (k, k) and values (k,) in these units.

    Those that the poses tell are principal axes. What is left to the prior is a space, which any
    basis spans: the one is given in which each combination has a number of its own, so that most
    have few.
    """
    shares, axes = np.linalg.eigh(covariance)
    told = [k for k, share in enumerate(shares) if source_of(share) != "prior"]
    rest = np.delete(axes, told, axis=1)
    chosen = np.concatenate([axes[:, told], _sparse(rest)], axis=1)
    made = []
    for v in chosen.T:
        weights = {name: float(w) for name, w in zip(names, v, strict=True) if w != 0.0}
        share = min(max(float(v @ covariance @ v), 0.0), 1.0)
        made.append(Combination(weights, float(v @ values), share**0.5, source_of(share)))
    return made


def _sparse(basis: Array) -> Array:
    """A basis (k, r) of the same space, of vectors of length 1, reduced by Gauss and Jordan."""
    rows = basis.T.copy()
    free = list(range(rows.shape[1]))
    for r in range(len(rows)):
        # the number that takes the largest part in what is left of the space
        k = max(free, key=lambda c: float(np.sum(rows[r:, c] ** 2)))
        free.remove(k)
        swap = r + int(np.argmax(np.abs(rows[r:, k])))
        rows[[r, swap]] = rows[[swap, r]]
        rows[r] /= rows[r, k]
        others = np.arange(len(rows)) != r
        rows[others] -= np.outer(rows[others, k], rows[r])
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).T
