"""The limits of a model's coordinates in usable form: those of followers are applied to their
leaders."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.model.coordinates import Coordinates
from freebody.model.description import Limits

if TYPE_CHECKING:
    from freebody.model.model import Model


_ROUNDED = 1e-9
"""Imaginary part, relative to 1 or the root, that rounding leaves of a real one."""


class UsableLimits(NamedTuple):
    """Usable limits of each velocity coordinate, arrays (nv,), infinite where there are none
    (`Limits.meant`).

    given: (4, nv), as written. apart: joints that follow another and whose range has nothing in
    common with that one's, in words.
    """

    lower: Array
    upper: Array
    velocity: Array
    effort: Array
    given: Array
    apart: tuple[str, ...]


def usable_limits(model: Model) -> UsableLimits:
    """The usable limits of one robot (not of a family)."""
    own = (body for body in model.bodies if body.joint.mimic is None)
    rows = [_numbers(body.joint.limits) for body in own for _ in range(body.kind.nv)]
    given, meant = np.array(rows, dtype=float).reshape(-1, 2, 4).transpose(1, 2, 0)
    lower, upper, velocity, effort = meant.copy()
    apart = tuple(_narrow(model, lower, upper, velocity))
    return UsableLimits(lower, upper, velocity, effort, given, apart)


def _numbers(limits: Limits) -> list[tuple[float, ...]]:
    """Lower, upper, velocity and effort limits, first as written and then as usable."""
    return [(x.lower, x.upper, x.velocity, x.effort) for x in (limits, limits.meant)]


def _narrow(model: Model, lower: Array, upper: Array, velocity: Array) -> Iterator[str]:
    """Bring the limits of followers to their leaders, where the ranges meet; yields who does not
    meet whom.

    Where a ratio changes with the position, the speed is limited by the largest in the range; where
    that has no end, none limits it.
    """
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        limits, k = body.joint.limits.meant, at.v[0] if at.v else -1
        if body.joint.mimic is None or (at.ratio == 0.0 and not at.powers):
            continue
        low, high = _leaders_range(at, limits, float(lower[k]), float(upper[k]))
        if low < high:
            lower[k], upper[k] = low, high
        else:
            yield f"{body.joint.name}, which follows {model.velocity_names[k]}"
        steepest = _steepest(at, float(lower[k]), float(upper[k]))
        if steepest < np.inf:
            velocity[k] = min(velocity[k], limits.velocity / steepest)


def _leaders_range(
    at: Coordinates, limits: Limits, lower: float, upper: float
) -> tuple[float, float]:
    """The range of a leader, within its own, that keeps its follower within limits; of several the
    one at 0, or next to it; empty (low above high) where there is none."""
    if not at.powers:
        ends = sorted(
            ((limits.lower - at.offset) / at.ratio, (limits.upper - at.offset) / at.ratio)
        )
        return max(ends[0], lower), min(ends[1], upper)
    position = np.polynomial.Polynomial((at.offset, at.ratio, *at.powers))
    met = [_real(position - x) for x in (limits.lower, limits.upper) if np.isfinite(x)]
    inside = [x for roots in met for x in roots if lower < x < upper]
    ends, ranges = [lower, *sorted(inside), upper], list[list[float]]()
    for low, high in pairwise(ends):
        if limits.lower <= position(_between(low, high)) <= limits.upper:
            if ranges and ranges[-1][1] == low:
                ranges[-1][1] = high
            else:
                ranges.append([low, high])
    if not ranges:
        return np.inf, -np.inf
    low, high = min(ranges, key=lambda ends: max(ends[0], -ends[1], 0.0))
    return low, high


def _steepest(at: Coordinates, low: float, high: float) -> float:
    """The largest size of a follower's rate, over its leader's, in a range of that."""
    if not at.powers:
        return abs(at.ratio)
    if np.isinf(low) or np.isinf(high):
        return np.inf
    slope = np.polynomial.Polynomial((at.offset, at.ratio, *at.powers)).deriv()
    turns = [x for x in _real(slope.deriv()) if low < x < high]
    return float(np.abs(slope(np.array([low, *turns, high]))).max())


def _real(polynomial: np.polynomial.Polynomial) -> list[float]:
    """The real roots of a polynomial."""
    roots = polynomial.roots()
    return roots.real[np.abs(roots.imag) <= _ROUNDED * (1.0 + np.abs(roots))].tolist()


def _between(low: float, high: float) -> float:
    """A number between two, of which one or both may be infinite."""
    if np.isinf(low):
        return 0.0 if np.isinf(high) else high - 1.0
    return low + 1.0 if np.isinf(high) else 0.5 * (low + high)
