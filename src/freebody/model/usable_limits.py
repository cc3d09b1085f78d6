"""The limits of a model's coordinates as they can be used: those of followers brought to their
leaders."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.model.description import Limits

if TYPE_CHECKING:
    from freebody.model.model import Model


class UsableLimits(NamedTuple):
    """Per velocity coordinate, arrays (nv,): limits that allow motion (`Limits.meant`), infinite
    where there are none.

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
    """The limits of one robot, not of a family, as they can be used."""
    own = (body for body in model.bodies if body.joint.mimic is None)
    rows = [_numbers(body.joint.limits) for body in own for _ in range(body.kind.nv)]
    given, meant = np.array(rows, dtype=float).reshape(-1, 2, 4).transpose(1, 2, 0)
    lower, upper, velocity, effort = meant.copy()
    apart = tuple(_narrow(model, lower, upper, velocity))
    return UsableLimits(lower, upper, velocity, effort, given, apart)


def _numbers(limits: Limits) -> list[tuple[float, ...]]:
    """Lower, upper, velocity and effort, as written and as they are meant."""
    return [(x.lower, x.upper, x.velocity, x.effort) for x in (limits, limits.meant)]


def _narrow(model: Model, lower: Array, upper: Array, velocity: Array) -> Iterator[str]:
    """Bring the limits of followers to their leaders, where the ranges meet; yields who does not
    meet whom."""
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        limits, k = body.joint.limits.meant, at.v[0] if at.v else -1
        if body.joint.mimic is None or at.ratio == 0.0:
            continue
        low, high = sorted(
            ((limits.lower - at.offset) / at.ratio, (limits.upper - at.offset) / at.ratio)
        )
        low, high = max(low, lower[k]), min(high, upper[k])
        if low < high:
            lower[k], upper[k] = low, high
        else:
            yield f"{body.joint.name}, which follows {model.velocity_names[k]}"
        velocity[k] = min(velocity[k], limits.velocity / abs(at.ratio))
