"""`Identification`: what logs tell of a robot, how surely, and the model made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.errors import UnknownNameError
from freebody.identification.reported import Reported
from freebody.identification.structure import JudgedStructure
from freebody.model.model import Model
from freebody.outputs.display import TextTable, counted
from freebody.outputs.number_text import weighted_sum

_KNOWN = 0.1
"""Part by which the scale of torques may be off, where it counts as known."""
_ROUNDING = 1e-9
"""Part of the largest weight of a sum below which a weight is rounding."""

if TYPE_CHECKING:
    from freebody.identification.drift import FrictionDrift
    from freebody.identification.evidence import LogFit

IdentificationOutcome = Literal["predicts", "fails", "not validated"]


def is_known(scale: tuple[float, float]) -> bool:
    """Whether an interval of a factor leaves it open by a tenth at most."""
    return scale[0] >= 1.0 / (1.0 + _KNOWN) and scale[1] <= 1.0 + _KNOWN


@dataclass(frozen=True)
class IdentifiedParameter:
    """A base parameter or a number of a joint's friction. value: of the regression, before prior
    and constraints, with its interval of 95 %, lower … upper; of base parameters, where friction
    may be any odd function of the rate with a slope of its own in each direction. in_model: the
    value in the physical model, whose friction follows the laws. told: whether the interval says
    more than that the parameter is small or unknown. withdrawn: why it has no interval, or ""."""

    name: str
    kind: Literal["inertial", "friction"]
    unit: str
    value: float
    lower: float
    upper: float
    in_model: float
    told: bool
    withdrawn: str = ""


@dataclass(frozen=True)
class JointFit:
    """How well a joint's torque is predicted while it moves. torque: its RMS, N m (N). regression,
    model: RMS of what is left, over it, of the regression and of the physical model. validation:
    the same of the model on logs that it has not seen, or None. independent: by which the variance
    of estimates is larger than with independent samples. law_fits: whether friction by the rate
    differs from the laws by no more than noise. friction: what the regression takes for it, as far
    as it goes with the rate, over the torque; negative where it pushes instead of braking."""

    joint: str
    torque: float
    regression: float
    model: float
    validation: float | None
    independent: float
    law_fits: bool
    friction: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Reported, ByValue):
    """The knowledge of a robot that logs give.

    model: physical, with the masses, rotors and friction that predict the logs. parameters: base
    parameters, then friction joint by joint. joints: how well each is predicted. combinations:
    (b, p), of which inertial parameters π the base parameters are made. inertial_names: of π.
    prior_alone: those of them that the logs do not determine, so that they are the prior's.
    untold: base parameters that the motion does not tell. gains: of currents, N m/A (N/A), (n,), or
    None. scale: factors by which these, masses and frictions may all be smaller and larger (95 %),
    (1, 1) where torques are logged, (0, inf) where nothing tells it. prior_weight: how much the
    prior counts.
    """

    model: Model
    parameters: tuple[IdentifiedParameter, ...]
    joints: tuple[JointFit, ...]
    combinations: Array
    inertial_names: tuple[str, ...]
    prior_alone: tuple[str, ...]
    untold: tuple[str, ...]
    gains: Array | None
    scale: tuple[float, float]
    prior_weight: float
    outcome: IdentificationOutcome
    """Whether the model predicts logs that it has not seen about as well as those it was made
    from."""
    verdict: str
    notices: tuple[str, ...]
    drift: tuple[FrictionDrift, ...] = ()
    """Friction of each joint block by block of time, where it is a notable part of the torque."""
    next: tuple[str, ...] = ()
    """Advice on what to measure next, so that more is told."""
    fits: tuple[LogFit, ...] = ()
    """The logs beside what the model predicts, those to validate with last."""
    structure: JudgedStructure = JudgedStructure()
    """The judgement of logs on what is taken as known: the time of torques, the places of joints,
    and that parts of them agree."""
    _aside = ("verdict", "notices", "drift", "next", "fits")

    @property
    def scale_known(self) -> bool:
        """Whether torques and masses are known in N m and kg, to a tenth."""
        return is_known(self.scale)

    @property
    def trusted(self) -> bool:
        """Whether the model predicts logs that it has not seen, its scale is known, and nothing in
        the logs speaks against its structure, so that intervals hold."""
        return self.outcome == "predicts" and self.scale_known and self.structure.fits

    def __getitem__(self, name: str) -> IdentifiedParameter:
        for x in self.parameters:
            if x.name == name:
                return x
        raise UnknownNameError(
            "parameter", name, "identification", [x.name for x in self.parameters]
        )

    def combination(self, name: str) -> dict[str, float]:
        """The inertial parameters that make up a base parameter, with their weights."""
        bases = [x.name for x in self.parameters if x.kind == "inertial"]
        row = self.combinations[bases.index(name)]
        return {other: float(w) for other, w in zip(self.inertial_names, row, strict=True) if w}

    def written(self, name: str) -> str:
        """A base parameter as a sum of inertial parameters, such as link2.hx + 0.4 link3.m."""
        weights = self.combination(name).items()
        least = _ROUNDING * max(abs(w) for _, w in weights)
        return weighted_sum([(other, w) for other, w in weights if abs(w) > least], 4)

    def _title(self) -> str:
        count = sum(x.kind == "inertial" for x in self.parameters)
        what = counted(count, "base parameter")
        return f"Identification of {self.model.name}: {what}; {self.outcome}"

    def _table(self) -> TextTable:
        rows = [
            (
                x.joint,
                f"{x.torque:.4g}",
                f"{100.0 * x.regression:.2f}",
                f"{100.0 * x.model:.2f}",
                "" if x.validation is None else f"{100.0 * x.validation:.2f}",
            )
            for x in self.joints
        ]
        head = ("joint", "RMS torque (N m, N)", "regression (%)", "model (%)", "unseen logs (%)")
        return TextTable(head, rows, (self.verdict, *self.notices))

    def _sections(self) -> list[tuple[str, TextTable]]:
        head = ("parameter", "value", "95 %", "in the model", "unit", "")
        rows = [
            (x.name, f"{x.value:.4g}", _interval(x), f"{x.in_model:.4g}", x.unit, _remark(x))
            for x in self.parameters
        ]
        sums = [
            (x.name, f"= {self.written(x.name)}") for x in self.parameters if x.kind == "inertial"
        ]
        return [("", TextTable(head, rows)), ("Base parameters are sums:", TextTable((), sums))]

    def lines(self) -> list[str]:
        """The identification in words and tables, line by line, and what to measure next."""
        more = ["", "What to measure next:", *self.next] if self.next else []
        return [*super().lines(), *more]


def _interval(x: IdentifiedParameter) -> str:
    return "–" if np.isnan(x.lower) else f"{x.lower:.4g} … {x.upper:.4g}"


def _remark(x: IdentifiedParameter) -> str:
    return x.withdrawn or ("" if x.told else "not told by these motions")
