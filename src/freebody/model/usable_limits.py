"""The limits of a model's coordinates in usable form: those of followers are applied to their
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
    """Apply the limits of followers to their leaders where the ranges overlap; yields a phrase for
    each follower whose range does not."""
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
