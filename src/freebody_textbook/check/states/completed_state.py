"""Completing a state of a closed chain by its loop equations from some coordinates, rates and
accelerations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.scalars.generators import SIGN, function_of, generators_in, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.states.admissible_states import Rows, StateSampler
from freebody_textbook.check.states.state_values import AnyArray, StateValues

_STRIDE, _STEPS = 0.05, 30
"""Radians or metres of a step from the home to the state, and Newton's steps at each."""
_CLOSED, _DETERMINED = 1e-11, 1e-8


def completed(setting: RightEquations, given: Mapping[str, float]) -> dict[str, float]:
    """Values of other names that follow from the given ones; {} if they are not determined or the
    loops cannot be closed. The assembly is reached by moving from the home position."""
    drawing = StateSampler(setting)
    names = setting.symbols.coordinates
    if setting.system is None or not any(x in given for x in names):
        return {}
    values = dict.fromkeys(setting.ring.names, 0.0) | dict(given)
    home = dict(zip(names, map(float, drawing.home), strict=True))
    free = [x for x in names if x not in given]
    far = max(abs(given[x] - home[x]) for x in names if x in given)
    rows, found = Rows(drawing.loops[0], free), dict[str, float]()
    if not _names(drawing.loops[0]) <= {*names, *given}:
        return {}
    values |= {x: home[x] for x in free}
    count = 1 + int(far / _STRIDE)
    for k in range(count + 1):
        way = {x: home[x] + (given[x] - home[x]) * k / count for x in names if x in given}
        if not _closed(rows, free, values | way, values):
            return {}
    values |= {x: given[x] for x in names if x in given}
    found |= {x: values[x] for x in _determined(rows, free, values)}
    if len(found) < len(free):  # nothing is taken for 0
        return found
    return found | _of_motion(drawing, given, values)


def _of_motion(
    drawing: StateSampler, given: Mapping[str, float], values: dict[str, float]
) -> dict[str, float]:
    """The rates, accelerations and multipliers that follow when all coordinates are known; each
    kind only if the previous one is determined."""
    names, found = drawing.setting.symbols.coordinates, dict[str, float]()
    for order, ending in enumerate((RATE, SECOND), 1):
        free = [x + ending for x in names if x + ending not in given]
        more = _solved(Rows(drawing.loops[order], free), free, values)
        found |= more
        if len(more) < len(free):
            return found
    unknown = list(drawing.multipliers)
    if not _names(drawing.passive) <= {*_moving(names), *given, *unknown}:
        return found
    return found | _solved(Rows(drawing.passive, unknown), unknown, values)


def _moving(coordinates: Sequence[str]) -> list[str]:
    """Names of coordinates, their rates and accelerations."""
    return [x + ending for x in coordinates for ending in ("", RATE, SECOND)]


def _names(rows: Sequence[Trig]) -> set[str]:
    """The symbols in polynomials, without signs of rates."""
    return {symbol_of(name) for name in generators_in(*rows) if function_of(name) != SIGN}


def _closed(
    rows: Rows, free: Sequence[str], at: Mapping[str, float], values: dict[str, float]
) -> bool:
    """Whether changing the free coordinates can close the loops; the closing values are stored in
    `values`."""
    here = dict(at)
    for _ in range(_STEPS):
        states = _one(here)
        gap = rows.at(states)[0]
        if np.abs(gap).max(initial=0.0) < _CLOSED:
            values |= {x: here[x] for x in free}
            return True
        step = np.linalg.pinv(rows.slopes_at(states)[0], rcond=_DETERMINED) @ gap
        for x, by in zip(free, step, strict=True):
            here[x] -= float(by)
    return False


def _solved(rows: Rows, free: Sequence[str], values: dict[str, float]) -> dict[str, float]:
    """The names that linear equations determine, with values; all are stored in `values`."""
    values |= dict.fromkeys(free, 0.0)
    if not free or not rows.polynomials:
        return {}
    states = _one(values)
    found = np.linalg.pinv(rows.slopes_at(states)[0], rcond=_DETERMINED) @ -rows.at(states)[0]
    values |= dict(zip(free, map(float, found), strict=True))
    return {x: values[x] for x in _determined(rows, free, values)}


def _determined(rows: Rows, free: Sequence[str], values: Mapping[str, float]) -> list[str]:
    """The names whose values the equations determine uniquely."""
    if not free:
        return []
    slopes: AnyArray = rows.slopes_at(_one(values))[0]
    _, sizes, turned = np.linalg.svd(slopes)
    rank = int((sizes > _DETERMINED * sizes.max(initial=0.0)).sum())
    left = np.abs(turned[rank:]).max(axis=0, initial=0.0)
    return [x for x, share in zip(free, left, strict=True) if share < _DETERMINED]


def _one(values: Mapping[str, float]) -> StateValues:
    """A collection of a single state with these values."""
    return StateValues({x: np.array([y]) for x, y in values.items()})
