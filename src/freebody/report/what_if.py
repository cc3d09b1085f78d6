"""Computations of a study's page itself: the torques of the motion under another payload, at
another pace, on a tilted base, by a kernel in JavaScript that is held against Python's numbers
first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.regrouped_parameters import lightened
from freebody.any_chain.effort_limits import followers
from freebody.arrays import Array
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.parameter_inputs import inputs_of
from freebody.model.model import Model
from freebody.motion.ranges import ranges
from freebody.program import Argument, Program, trace
from freebody.report.verdict import doubtful
from freebody.targets.text import LANGUAGES, SourceUnit

if TYPE_CHECKING:
    from freebody.report.shown_motion import ShownMotion
    from freebody.report.study import Study

NAME = "torques"
"""The function's name: tau = torques(q, qd, qdd, load, gravity)."""
_LOAD = "further_load"
_CHECKED = 61
"""Instants at which the page has Python's torques with all their digits."""
_SPEEDS = 2.0, 5.0
"""The highest pace that may be asked for: at least, and at most."""
_STEPS = 100  # from end to end of a slider for masses


@dataclass(frozen=True)
class Sliders:
    """The ends of a page's sliders; a mass (kg) of 0 and an angle of 0 where there is none."""

    mass: float
    speed: float
    tilt: int
    """Degrees to either side."""
    tip: str
    thinned: str
    """Words on samples that are left out; empty where there are all."""

    @property
    def mass_step(self) -> float:
        """The step of the slider for masses, kg."""
        return self.mass / _STEPS


@dataclass(frozen=True)
class WhatIf:
    """The sliders of a page with the kernel and the numbers that they need, or the reason why there
    are none."""

    missing: str
    sliders: Sliders | None = None
    script: str = ""
    data: dict[str, Any] | None = None
    rates: Array | None = None
    """Speeds, then accelerations at the instants that are shown (2, T, nv)."""
    expected: Array | None = None
    """Python's torques (K, nv) at the instants `data["checked"]`."""


def peaks(study: Study) -> list[int]:
    """Samples at which a torque or a power is largest."""
    found = (np.abs(study.data[x].values).argmax(axis=0) for x in ("tau", "power"))
    return np.unique(np.concatenate(list(found))).tolist()


def what_if(study: Study, shown: ShownMotion) -> WhatIf:
    """The data with which a page that shows a motion computes itself."""
    reason = _missing(study.model)
    if reason:
        return WhatIf(reason)
    count = len(shown.t)
    checked = np.unique(np.linspace(0, count - 1, min(_CHECKED, count)).astype(int))
    data = {
        "gravity": np.asarray(study.model.gravity, dtype=float).tolist(),
        "whole": shown.whole,
        "between": shown.between.tolist(),
        "barred": any(doubt.of.bars for doubt in study.verdict.doubts),
        "checked": checked.tolist(),
        "uses": _uses(study),
    }
    kept = f"From {count - len(shown.between)} of the motion's {len(shown.samples)} samples."
    words = "" if shown.whole else kept
    return WhatIf(
        "",
        _sliders(study, words),
        LANGUAGES["javascript-script"].emit(SourceUnit(_program(study), NAME)),
        data,
        np.stack([shown.qd, shown.qdd]),
        shown.tau[checked],
    )


def _missing(model: Model) -> str:
    """The reason why a robot's torques under other loads are not those of the same motion, or are
    not computed in the page; empty where they are."""
    if model.loops:
        return (
            "No sliders: the drives of a closed chain share its loads, and this page has no kernel "
            "for that; fb.study with the payload or speed= computes it."
        )
    if model.passive:
        return (
            "No sliders: passive joints and flexible drives would move otherwise under another "
            "load or at another pace; fb.study with the payload or speed= computes it."
        )
    if followers(model) is not None:
        return (
            "No sliders: joints that follow others have limits of their own, which this page does "
            "not compute; fb.study with the payload or speed= does."
        )
    return ""


def _sliders(study: Study, words: str) -> Sliders:
    card, model = study.card, study.model
    mass = 0.0
    if model.tip is not None:
        mass = 2.0 * card.payload if 0.0 < card.payload < math.inf else 0.5 * model.mass
        mass = round_up(mass)
    low, high = _SPEEDS
    faster = card.faster if math.isfinite(card.faster) else low
    return Sliders(
        mass,
        min(max(low, math.ceil(1.5 * faster)), high),
        180 if np.any(model.gravity) else 0,
        model.tip or "",
        words,
    )


def round_up(x: float) -> float:
    """The next of 1, 2, 5, 10, 20, … that is no smaller."""
    if not x > 0.0:
        return 1.0
    size = 10.0 ** math.floor(math.log10(x))
    return next(k * size for k in (1.0, 2.0, 5.0, 10.0) if k * size >= x * (1.0 - 1e-9))


def _uses(study: Study) -> list[dict[str, Any]]:
    """The uses of limits that the verdict judges, as a page recomputes them."""
    names = study.model.velocity_names
    return [
        {
            "quantity": use.quantity,
            "name": use.coordinate,
            "column": names.index(use.coordinate),
            "limit": use.limit,
            "fraction": use.fraction,
            "value": use.value,
            "time": use.time if math.isfinite(use.time) else None,
            "unit": use.unit,
            "words": use.text,
            "doubtful": doubtful(use, study.verdict.doubts),
        }
        for use in study.verdict.uses
    ]


def limits(study: Study) -> list[float | None]:
    """The limit of each coordinate's effort, N m or N; None where there is none."""
    return [float(x) if np.isfinite(x) else None for x in ranges(study.model).effort]


def _program(study: Study) -> Program:
    """Inverse dynamics with a further mass at the tip and with gravity as inputs, under the study's
    wrenches."""
    model = study.model
    given = None
    if model.tip is not None:
        loaded = model.with_payload(1.0, frame=model.tip, name=_LOAD)
        given = inputs_of("the page", loaded, [f"{_LOAD}.mass"])
    option = Option(wrench_frames=tuple(study.wrenches))
    pulls = tuple(tuple(map(float, w)) for w in study.wrenches.values())
    formula = FORMULAS["inverse_dynamics"].evaluate

    def torques(
        q: Sequence[Any], qd: Sequence[Any], qdd: Sequence[Any], load: Sequence[Any], g: Any
    ) -> tuple[Any, ...]:
        tree = model.tree if given is None else given.tree(load)
        tree = lightened(replace(tree, gravity=tuple(g)))
        return formula(tree, option, tuple(q), tuple(qd), tuple(qdd), pulls)

    inputs = (
        Argument("q", (model.nq,)),
        Argument("qd", (model.nv,)),
        Argument("qdd", (model.nv,)),
        Argument("load", (1,)),
        Argument("gravity", (model.dim,)),
    )
    return trace(NAME, torques, inputs, (Argument("tau", (model.nv,)),))
