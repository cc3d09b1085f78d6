"""The torque of one motion over time, in pieces between which it jumps or bends, so that an
integrator meets neither within a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array, above_zero, check_core
from freebody.errors import FreebodyError
from freebody.labels import is_labelled
from freebody.model.model import Model
from freebody.motion.simulation.first_order_system import TorqueLaw
from freebody.motion.simulation.torques import CompiledTorque, TorqueFunction, TorqueInput
from freebody.trees.public_calls import vector
from freebody.trees.special_joints import refuse_passive

_MOST = 1_000_000  # sampling instants: beyond these a run would take hours
_SAME = 1e-9  # of a sampling interval: instants this close to a time are that time


@dataclass(frozen=True, eq=False)
class Schedule:
    """A torque, in pieces that an integrator can step through without meeting a jump or a bend."""

    edges: Array
    """(k + 1,) increasing: start, what lies between the pieces, end."""
    begin: Callable[[int, Array, Array], TorqueLaw]
    """The torque on piece k, from the state (q, qd) at its start."""
    given: TorqueLaw
    """The torque at any time of the run that is over; at a jump the one after it."""
    feedback: bool = False
    """Whether the torque depends on the state within a piece."""


def schedule(
    model: Model,
    t: Array,
    torque: TorqueInput,
    breakpoints: Array,
    sample_time: float | None = None,
    name: str = "torque",
) -> Schedule:
    """The schedule of one motion; t (T,) are its times. name: of the argument."""
    ends = t[[0, -1]]
    if isinstance(torque, np.ndarray):
        if len(torque) > 1:
            return _of_table(t, torque)
        (row,) = torque
        return Schedule(ends, lambda k, q, qd: lambda now, q, qd: row, lambda now, q, qd: row)
    function = torque if isinstance(torque, CompiledTorque) else _checked(model, torque, name)
    if sample_time is None:
        inside = breakpoints[(breakpoints > t[0]) & (breakpoints < t[-1])]
        return _of_function(function, np.concatenate([ends, inside]))
    return _sampled(function, instants(float(t[0]), float(t[-1]), sample_time), sample_time, t[-1])


def with_edges(plan: Schedule, times: Array) -> Schedule:
    """The schedule in pieces that end at these times too."""
    edges = merged(plan.edges, times, _SAME * np.diff(plan.edges).min())
    return replace(plan, edges=edges, begin=_begin_within(plan, edges))


def along_with(plan: Schedule, other: Schedule) -> Schedule:
    """The schedule of both at once; `given` is that of the first."""
    near = _SAME * min(np.diff(plan.edges).min(), np.diff(other.edges).min())
    edges = merged(plan.edges, other.edges, near)
    own, more = (_begin_within(x, edges) for x in (plan, other))

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        one, two = own(k, q, qd), more(k, q, qd)
        return lambda now, q, qd: one(now, q, qd) + two(now, q, qd)

    return Schedule(edges, begin, plan.given, plan.feedback or other.feedback)


def _begin_within(plan: Schedule, edges: Array) -> Callable[[int, Array, Array], TorqueLaw]:
    """`Schedule.begin` of pieces between other edges, among them the schedule's own."""
    piece = np.searchsorted(plan.edges, 0.5 * (edges[:-1] + edges[1:]), side="right") - 1
    drives: list[TorqueLaw] = []

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        if k == 0 or piece[k] != piece[k - 1]:
            drives[:] = [plan.begin(int(piece[k]), q, qd)]
        return drives[0]

    return begin


def merged(times: Array, others: Array, near: float) -> Array:
    """Times in order: `times`, and the entries of `others` between them, except those closer than
    `near` to one of `times`."""
    inside = others[(others > times[0]) & (others < times[-1])]
    k = np.searchsorted(times, inside)
    apart = np.minimum(inside - times[k - 1], times[k] - inside)
    return np.unique(np.concatenate([times, inside[apart > near]]))


def _of_table(t: Array, table: Array) -> Schedule:
    """The schedule of a table, in straight lines from row to row."""
    slopes = np.diff(table, axis=0) / np.diff(t)[:, None]

    def line(k: int) -> TorqueLaw:
        return lambda now, q, qd: table[k] + (now - t[k]) * slopes[k]

    def given(now: Array, q: Array, qd: Array) -> Array:
        return table[np.searchsorted(t, now)]  # asked for at the rows' times alone

    return Schedule(t, lambda k, q, qd: line(k), given)


def _of_function(function: TorqueLaw, edges: Array) -> Schedule:
    """A function that is smooth between the edges, on either side of which its value at an edge may
    count."""
    edges = np.unique(edges)
    first, last = edges[:-1].copy(), edges[1:].copy()
    first[1:], last[:-1] = np.nextafter(first[1:], np.inf), np.nextafter(last[:-1], -np.inf)

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        if len(first) == 1:
            return function
        return lambda now, q, qd: function(np.clip(now, first[k], last[k]), q, qd)

    return Schedule(edges, begin, function, feedback=True)


def instants(start: float, end: float, sample_time: float) -> Array:
    """Times at which a controller is called."""
    above_zero("simulate", "sample_time", sample_time, "seconds")
    count = (end - start) / sample_time
    if count > _MOST:
        raise FreebodyError(
            f"simulate: sample_time is {sample_time:g} s, {count:.3g} instants in this run; "
            f"{_MOST} are the most."
        )
    return start + sample_time * np.arange(max(1, int(np.ceil(count - _SAME))), dtype=float)


def _sampled(function: TorqueLaw, instants: Array, sample_time: float, end: float) -> Schedule:
    """Called at every sampling instant with the state there, and held until the next."""
    held: list[Array] = []

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        value = function(instants[k], q, qd)
        held.append(value)
        return lambda now, q, qd: value

    def given(now: Array, q: Array, qd: Array) -> Array:
        last = int(np.searchsorted(instants, now + _SAME * sample_time, side="right")) - 1
        return held[min(last, len(held) - 1)]  # a run that was interrupted has fewer

    return Schedule(np.append(instants, end), begin, given)


def _checked(model: Model, function: TorqueFunction, name: str) -> TorqueLaw:
    """The function, called for one state at a time, what it returns looked at."""
    returned = f"what {name}(t, q, qd) returns"

    def drive(now: Array, q: Array, qd: Array) -> Array:
        if q.ndim > 1:
            return np.stack([drive(now, *state) for state in zip(q, qd, strict=True)])
        tau = function(float(now), q.copy(), qd.copy())  # which may work in place
        if is_labelled(tau):
            tau = vector("simulate", model, returned, tau)
        tau = np.array(tau, dtype=float)
        if tau.shape != (model.nv,):
            check_core("simulate", returned, tau, (model.nv,), f"model {model.name!r}")
        if model.passive and np.isfinite(tau).all():
            refuse_passive("simulate", model, tau)
        return tau

    return drive
