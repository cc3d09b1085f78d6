"""Planned motions of closed chains: waypoints of the driven joints, or closed positions of all; the
driven joints follow a curve, and the loops move the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, LoopError, ShapeError
from freebody.loops.assembly import assemble
from freebody.loops.closure_checks import require_closed, scaled_residual
from freebody.loops.rates import loop_acceleration, loop_velocity
from freebody.model.model import Model
from freebody.motion.closed_chain_motion import followed, home, leaders
from freebody.motion.motion import Motion
from freebody.motion.piecewise import PiecewisePolynomial, hermite
from freebody.motion.planning.planned import sample_times, times_and_breaks
from freebody.motion.planning.planning_limits import PlanningLimits, refuse_beyond
from freebody.motion.ranges import ranges
from freebody.trees.position_rates import (
    continuous,
    layout,
    normalised,
    position_acceleration,
    position_rate,
    state_of,
)
from freebody.trees.positions import difference

_HALVINGS = 10
_OPEN = 1e-12
"""rad, or of the size of a loop: by which it may open between times at which it is closed."""
_ELSEWHERE = 1e-6
"""rad, m: how far given closed positions may be from where the loops lead."""
_STEP = 0.05
"""rad, m: of the driven joints from home to the first waypoint."""


@dataclass(frozen=True, eq=False)
class DrivenWaypoints:
    """Waypoints q (k, n) of the driven joints. start: the closed position (nq,) at the first.
    every: (k, nq) where all positions were given, else None."""

    q: Array
    start: Array
    every: Array | None


def driven_waypoints(
    function: str, model: Model, given: Any, limits: PlanningLimits, one: str = ""
) -> DrivenWaypoints:
    """Waypoints (k, n) of the driven joints, reached from home on its branch, or closed positions
    (k, nq), the first of which determines the branch. Raises FreebodyError."""
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
    """The indices of the driven joints in q."""
    names = model.driven_names
    if not set(names) <= set(model.position_names):
        raise FreebodyError(
            f"{function}: a driven joint of {model.name!r} has a quaternion; give samples to "
            f"fb.Motion.of."
        )
    return [model.position_names.index(name) for name in names]


def _from_home(function: str, model: Model, columns: list[int], first: Array) -> Array:
    """The closed position (nq,) with the driven joints at the first waypoint, reached by moving
    them there from home."""
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


def through_loops(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    waypoints: DrivenWaypoints,
    words: str,
    step: float | None,
    when: str = "t = {:.4g} s",
) -> Motion:
    """The motion of all joints when the driven ones follow a curve (n,) over time.

    Exact at 401 times and where the curve's polynomials meet, quintic between, and at more times
    where the loops would open between these, near singular positions. when: a time in words. Raises
    LoopError where the loops block it, or lead elsewhere than to a given waypoint.
    """
    where, knots = layout(model), times_and_breaks(curve.breaks)
    for _ in range(_HALVINGS):
        pieces = _pieces(function, model, curve, waypoints.start, knots, when)
        between = 0.5 * (knots[:-1] + knots[1:])
        q = normalised(where, pieces(between))
        opened = np.abs(scaled_residual(model, q)).max(axis=-1) > _OPEN
        if not opened.any():
            break
        knots = np.sort(np.concatenate([knots, between[opened]]))
    t = sample_times(function, curve.breaks, step)
    states = state_of(where, *(pieces.derivative(k)(t) if k else pieces(t) for k in range(3)))
    source = f"{words}; the loops determine the other joints"
    motion = Motion(t, *states, source, where, pieces=pieces)
    _refuse_elsewhere(function, model, curve, waypoints, motion)
    return motion


def _pieces(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    start: Array,
    knots: Array,
    when: str,
) -> PiecewisePolynomial:
    """Quintic polynomials of all joints between the knots, exact there."""
    where = layout(model)
    first = curve.derivative()(knots)
    second = curve.derivative(2)
    way = curve(knots)

    def place(k: int) -> str:
        reached = ", ".join(
            f"{name} = {x:.4g}" for name, x in zip(model.driven_names, way[k + 1], strict=True)
        )
        return f"at {when.format(knots[k + 1])} ({reached}); move the waypoints"

    try:
        moved = followed(model, start, model.driven, way[1:] - way[0], place)
    except LoopError as problem:
        raise LoopError(f"{function}: {problem}") from None
    q = np.concatenate([start[None], moved])
    qd = loop_velocity(model, q, _named(model, first))
    later, before = (
        loop_acceleration(model, q, qd, _named(model, x))
        for x in (second(knots), second.before(knots))
    )
    x = continuous(where, q)
    rates = position_rate(where, x, qd)
    return hermite(
        knots,
        x,
        rates,
        position_acceleration(where, x, qd, later),
        position_acceleration(where, x, qd, before),
    )


def _named(model: Model, values: Array) -> Any:
    return dict(zip(model.driven_names, values.T, strict=True))


def _refuse_elsewhere(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    waypoints: DrivenWaypoints,
    motion: Motion,
) -> None:
    """Refuse closed waypoints that lie on another branch than the first; whole turns of joints that
    the loops lead and nothing stops make no other one."""
    if waypoints.every is None:
        return
    allowed = ranges(model)
    endless = allowed.turns & np.isinf(allowed.lower) & np.isinf(allowed.upper)
    endless[list(model.driven)] = False
    for k, (own, every) in enumerate(zip(waypoints.q, waypoints.every, strict=True)):
        passed = np.abs(curve(motion.knots) - own).max(axis=1)
        q = motion.at(motion.knots[int(np.argmin(passed))])[0]
        off = difference(model, q, every)
        off = np.abs(np.where(endless, np.angle(np.exp(1j * off)), off))
        if off.max() > _ELSEWHERE:
            j = int(np.argmax(off))
            raise LoopError(
                f"{function}: waypoint {k} is on another branch than the first: the loops lead "
                f"{model.velocity_names[j]} to a place {off[j]:.3g} away from it."
            )
