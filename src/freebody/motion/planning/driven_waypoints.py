"""Waypoints of closed chains: of the driven joints, or closed positions of all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, LoopError, ShapeError
from freebody.loops.assembly import assemble
from freebody.loops.equations import require_closed
from freebody.model.model import Model
from freebody.motion.closed_chain_motion import followed, home, leaders
from freebody.motion.planning.planning_limits import PlanningLimits, refuse_beyond

_STEP = 0.05
"""rad, m: of the driven joints from home to the first waypoint."""


@dataclass(frozen=True, eq=False)
class DrivenWaypoints:
    """q: (k, n) of the driven joints. start: the closed position (nq,) at the first. every: (k, nq)
    where all positions were given, else None."""

    q: Array
    start: Array
    every: Array | None


def driven_waypoints(
    function: str, model: Model, given: Any, limits: PlanningLimits, one: str = ""
) -> DrivenWaypoints:
    """Waypoints (k, n) of the driven joints, which are reached from home on its branch, or closed
    positions (k, nq), the first of which says which branch is meant. Raises FreebodyError."""
    columns, n = _columns(function, model), len(model.driven)
    name = one or "waypoints"
    array = as_floats(function, name, given)
    refuse_not_finite(function, name, array, 1)
    if array.ndim != 2 or array.shape[1] not in (n, model.nq) or len(array) < 2:
        shape, rows = (array.shape[1:], "") if one else (array.shape, "k, ")
        raise ShapeError(
            function,
            name,
            shape,
            f"({rows}{n}) or ({rows}{model.nq})",
            f"positions of the driven joints of {model.name!r}, or all, two rows at least",
        )
    if array.shape[1] == n:
        refuse_beyond(function, model, array, model.driven, limits, one)
        return DrivenWaypoints(array, _from_home(function, model, columns, array[0]), None)
    require_closed(function, model, array[0] if one else array)
    q = array[:, columns]
    refuse_beyond(function, model, q, model.driven, limits, one)
    others = [x for k, x in enumerate(model.velocity_names) if k not in model.driven]
    return DrivenWaypoints(q, assemble(model, array[0], free=others), array)


def _columns(function: str, model: Model) -> list[int]:
    """Positions of the driven joints."""
    names = model.driven_names
    if not set(names) <= set(model.position_names):
        raise FreebodyError(
            f"{function}: a driven joint of {model.name!r} has a quaternion; give samples to "
            f"fb.Motion.of."
        )
    return [model.position_names.index(name) for name in names]


def _from_home(function: str, model: Model, columns: list[int], first: Array) -> Array:
    """The closed position (nq,) with the driven joints at the first waypoint, as they are moved
    there from home."""
    start = home(model)
    if list(model.driven) != leaders(model, start):
        raise LoopError(
            f"{function}: the driven joints of {model.name!r}, {', '.join(model.driven_names)}, "
            f"are too few or too many to determine the others; give samples to fb.Motion.of."
        )
    way = first - start[columns]
    count = int(np.ceil(np.abs(way).max() / _STEP)) + 1
    try:
        return followed(model, start, model.driven, np.linspace(0, 1, count + 1)[1:, None] * way)[
            -1
        ]
    except LoopError:
        raise LoopError(
            f"{function}: the loops of {model.name!r} block the driven joints on the way from "
            f"home to waypoint 0; give closed positions of all joints, (k, {model.nq}): "
            f"fb.assemble(model, q)."
        ) from None
