"""Loads of brakes and bearings along a motion, and at other paces of it.

A brake holds the robot where it stands still, whatever the pace. What a bearing bears at the pace k
is a wrench W(k) = A k² + B k + C, as the torques are (`time_scaling`): of a closed chain too, for
friction that is constant, or proportional to the rate, at k > 0. Three paces tell A, B and C; a
fourth tells whether that is all there is to it. What is compared with a limit is a sum of sizes of
such vectors, which is no polynomial of k, and is looked at over intervals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import static_torque
from freebody.arrays import Array
from freebody.capacity.fitted_parts import (
    BEARING_LIMITS,
    FittedBearing,
    FittedParts,
    LimitedBearings,
    MotionStates,
    vectors_on_bearings,
)
from freebody.capacity.limited_loads import LimitedLoads, constant, efforts_named
from freebody.model.model import Model
from freebody.motion.intervals import Interval, for_each

_PACES = (0.5, 1.0, 2.0)
_CONFIRMED = 3.0
"""A further pace, at which the polynomial through the others has to be right."""
_SAME = 1e-9
"""Share of the largest load by which it may be off."""


def part_loads(
    function: str,
    model: Model,
    parts: FittedParts,
    time: Array,
    states: MotionStates,
    wrenches: Mapping[str, Array] | None,
) -> tuple[LimitedLoads, ...]:
    """The loads of brakes and bearings at the samples of a motion, times (T,) and states, under
    constant wrenches on the robot by frame."""
    found = []
    if parts.brakes:
        found.append(_of_brakes(model, parts, time, states[0], wrenches))
    if parts.bearings:
        vectors, known = _over_paces(function, model, parts.bearings, states, wrenches)
        for limit in BEARING_LIMITS:
            these = limit.of(parts.bearings)
            if these.fitted:
                found.append(_of_bearings(these, time, vectors, known))
    return tuple(found)


def _of_brakes(
    model: Model,
    parts: FittedParts,
    time: Array,
    q: Array,
    wrenches: Mapping[str, Array] | None,
) -> LimitedLoads:
    """Loads that hold the robot still: without the wrenches on it, which may end, and with them."""
    columns = [x.column for x in parts.brakes]
    cases = (None, wrenches) if wrenches else (None,)
    held = [static_torque(model, q, x)[:, columns] for x in cases]
    size = np.abs(held).max(axis=0)
    quantities, units = efforts_named(np.array([x.turns for x in parts.brakes]))
    return LimitedLoads(
        tuple(x.joint for x in parts.brakes),
        tuple(f"brake {what}" for what in quantities),
        units,
        np.array([x.limit for x in parts.brakes]),
        time,
        lambda k: size,
        constant(size),
    )


_Polynomial = tuple[Array, Array, Array]
"""Coefficients (T, n, d) of the square of the pace, of the pace, and of 1."""


def _over_paces(
    function: str,
    model: Model,
    bearings: tuple[FittedBearing, ...],
    states: MotionStates,
    wrenches: Mapping[str, Array] | None,
) -> tuple[Sequence[_Polynomial], bool]:
    """The polynomials of axial force, radial force and tilting moment, and whether they are right
    at other paces than their own."""
    q, qd, qdd = states

    def at(k: float) -> tuple[Array, Array, Array]:
        return vectors_on_bearings(function, model, bearings, (q, k * qd, k**2 * qdd), wrenches)

    polynomials = [_through(*values) for values in zip(*map(at, _PACES), strict=True)]
    known = True
    for polynomial, right in zip(polynomials, at(_CONFIRMED), strict=True):
        off = np.abs(_vector(polynomial, _CONFIRMED) - right).max(initial=0.0)
        known &= bool(off <= _SAME * np.abs(right).max(initial=0.0))
    return polynomials, known


def _through(first: Array, second: Array, third: Array) -> _Polynomial:
    """The polynomial that has these values at the three paces."""
    x, y, z = _PACES
    rise, later = (second - first) / (y - x), (third - second) / (z - y)
    a = (later - rise) / (z - x)
    b = rise - a * (x + y)
    return a, b, second - (a * y + b) * y


def _vector(polynomial: _Polynomial, k: Any) -> Any:
    a, b, c = polynomial
    pace = for_each(k, 3)
    return (a * pace + b) * pace + c


def _of_bearings(
    these: LimitedBearings, time: Array, vectors: Sequence[_Polynomial], known: bool
) -> LimitedLoads:
    here = [(a[:, these.places], b[:, these.places], c[:, these.places]) for a, b, c in vectors]
    terms = [(w, x) for w, x in zip(these.weights.T, here, strict=True) if w.any()]

    def at(k: Any) -> Array:
        """Sizes of the loads at a pace; over an interval of paces, bounds of them."""
        sizes = (_vector(polynomial, k) for _, polynomial in terms)
        each = [x.size if isinstance(x, Interval) else x for x in sizes]
        total = [w * np.linalg.norm(x, axis=-1) for (w, _), x in zip(terms, each, strict=True)]
        return np.sum(total, axis=0)

    return LimitedLoads(
        tuple(x.joint for x in these.fitted),
        (these.limit.name,) * len(these.fitted),
        (these.limit.unit,) * len(these.fitted),
        these.limits,
        time,
        at,
        None,
        known,
    )
