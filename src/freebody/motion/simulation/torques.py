"""The torque of a simulation over time: the times between which it is smooth, and what it is
there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, as_floats, check_core, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError
from freebody.kernels.column_by_column import ColumnKernel, KernelList
from freebody.kernels.inputs import InputKernel
from freebody.labels import is_labelled, row_times
from freebody.model.model import Model
from freebody.motion.simulation.compiled_torque import CompiledTorque, compiled_torque
from freebody.motion.simulation.first_order_system import Drive, row_at
from freebody.outputs.number_text import compared
from freebody.targets import Kernel
from freebody.trees.passive_joints import all_driven, refuse_passive
from freebody.trees.public_calls import vector

TorqueFunction = Callable[[float, Array, Array], ArrayLike]
Torque = ArrayLike | TorqueFunction | Kernel | None
Given = Array | TorqueFunction | CompiledTorque
"""What was given, checked: a table (..., T, nv), one row (..., 1, nv) that counts at all times, a
function, or one that was compiled."""

_MOST = 1_000_000  # sampling instants: beyond these a run would take hours
_SAME = 1e-9  # of a sampling interval: instants this close to a time are that time


@dataclass(frozen=True, eq=False)
class Schedule:
    """A torque, in pieces that an integrator can step through without meeting a jump or a bend."""

    edges: Array
    """(k + 1,) increasing: start, what lies between the pieces, end."""
    begin: Callable[[int, Array, Array], Drive]
    """The torque on piece k, from the state (q, qd) at its start."""
    given: Drive
    """The torque at any time of the run that is over; at a jump the one after it."""
    feedback: bool = False
    """Whether the torque depends on the state within a piece."""


def torque_of(
    model: Model,
    t: Array,
    torque: Torque,
    inputs: Mapping[str, Any] | None,
    breakpoints: Array,
    sample_time: float | None,
    forces: Given | None,
) -> Given:
    """What `simulate` was given as torque, checked; forces: what acts besides."""
    if inputs is not None and not isinstance(torque, Kernel):
        raise FreebodyError(
            "simulate: torque_inputs= is about a torque from fb.compile; a Python function has its "
            "own variables. Leave it out."
        )
    found = _given(model, t, np.zeros(model.nv) if torque is None else torque, "torque", inputs)
    breaks = len(breakpoints) and not callable(forces)
    for name, told in (("breakpoints", breaks), ("sample_time", sample_time is not None)):
        if told and not callable(found):
            raise FreebodyError(
                f"simulate: {name}= applies only to a torque that is a function f(t, q, qd); a "
                f"table is integrated from row to row. Leave it out."
            )
    return found


def forces_of(model: Model, t: Array, forces: Torque) -> Given | None:
    """The same of what was given as forces, which may act at passive joints; None for none."""
    return None if forces is None else _given(all_driven(model), t, forces, "forces")


def _given(
    model: Model,
    t: Array,
    given: ArrayLike | TorqueFunction | Kernel,
    name: str,
    inputs: Mapping[str, Any] | None = None,
) -> Given:
    if isinstance(given, InputKernel | ColumnKernel | KernelList):
        raise FreebodyError(
            f"simulate: a kernel with numbers as inputs, or of a large robot, is no {name} by "
            f"itself: call it in a function f(t, q, qd)."
        )
    if isinstance(given, Kernel):
        return compiled_torque(model, given, {} if inputs is None else inputs, name)
    if callable(given):
        return given
    table = _table(model, t, given, name)
    return table[None] if table.ndim == 1 else table


def schedule(
    model: Model,
    t: Array,
    torque: Given,
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
    """The same in pieces that end at these times too."""
    edges = merged(plan.edges, times, _SAME * np.diff(plan.edges).min())
    return replace(plan, edges=edges, begin=_begin_within(plan, edges))


def along_with(plan: Schedule, other: Schedule) -> Schedule:
    """Both at once; what is given is the first."""
    near = _SAME * min(np.diff(plan.edges).min(), np.diff(other.edges).min())
    edges = merged(plan.edges, other.edges, near)
    own, more = (_begin_within(x, edges) for x in (plan, other))

    def begin(k: int, q: Array, qd: Array) -> Drive:
        one, two = own(k, q, qd), more(k, q, qd)
        return lambda now, q, qd: one(now, q, qd) + two(now, q, qd)

    return Schedule(edges, begin, plan.given, plan.feedback or other.feedback)


def _begin_within(plan: Schedule, edges: Array) -> Callable[[int, Array, Array], Drive]:
    """`Schedule.begin` of pieces between other edges, among them the schedule's own."""
    piece = np.searchsorted(plan.edges, 0.5 * (edges[:-1] + edges[1:]), side="right") - 1
    drives: list[Drive] = []

    def begin(k: int, q: Array, qd: Array) -> Drive:
        if k == 0 or piece[k] != piece[k - 1]:
            drives[:] = [plan.begin(int(piece[k]), q, qd)]
        return drives[0]

    return begin


def merged(times: Array, others: Array, near: float) -> Array:
    """Increasing: times, and what lies between them of others, but for those that are near one."""
    inside = others[(others > times[0]) & (others < times[-1])]
    k = np.searchsorted(times, inside)
    apart = np.minimum(inside - times[k - 1], times[k] - inside)
    return np.unique(np.concatenate([times, inside[apart > near]]))


def _of_table(t: Array, table: Array) -> Schedule:
    """Straight lines from row to row."""
    slopes = np.diff(table, axis=0) / np.diff(t)[:, None]

    def line(k: int) -> Drive:
        return lambda now, q, qd: table[k] + (now - t[k]) * slopes[k]

    def given(now: Array, q: Array, qd: Array) -> Array:
        return table[np.searchsorted(t, now)]  # asked for at the rows' times alone

    return Schedule(t, lambda k, q, qd: line(k), given)


def _of_function(function: Drive, edges: Array) -> Schedule:
    """A function that is smooth between the edges, on either side of which its value at an edge may
    count."""
    edges = np.unique(edges)
    first, last = edges[:-1].copy(), edges[1:].copy()
    first[1:], last[:-1] = np.nextafter(first[1:], np.inf), np.nextafter(last[:-1], -np.inf)

    def begin(k: int, q: Array, qd: Array) -> Drive:
        if len(first) == 1:
            return function
        return lambda now, q, qd: function(np.clip(now, first[k], last[k]), q, qd)

    return Schedule(edges, begin, function, feedback=True)


def instants(start: float, end: float, sample_time: float) -> Array:
    """When a controller is called."""
    above_zero("simulate", "sample_time", sample_time, "seconds")
    count = (end - start) / sample_time
    if count > _MOST:
        raise FreebodyError(
            f"simulate: sample_time is {sample_time:g} s, {count:.3g} instants in this run; "
            f"{_MOST} are the most."
        )
    return start + sample_time * np.arange(max(1, int(np.ceil(count - _SAME))), dtype=float)


def _sampled(function: Drive, instants: Array, sample_time: float, end: float) -> Schedule:
    """Called at every sampling instant with the state there, and held until the next."""
    held: list[Array] = []

    def begin(k: int, q: Array, qd: Array) -> Drive:
        value = function(instants[k], q, qd)
        held.append(value)
        return lambda now, q, qd: value

    def given(now: Array, q: Array, qd: Array) -> Array:
        last = int(np.searchsorted(instants, now + _SAME * sample_time, side="right")) - 1
        return held[min(last, len(held) - 1)]  # a run that was interrupted has fewer

    return Schedule(np.append(instants, end), begin, given)


def breakpoints_of(given: ArrayLike, sample_time: float | None, forces: Given | None) -> Array:
    """The times at which a function of torques or forces has jumps or bends."""
    times = as_floats("simulate", "breakpoints", given)
    if times.ndim != 1:
        raise FreebodyError(
            f"simulate: breakpoints has shape {times.shape}, expected a list of times."
        )
    refuse_not_finite("simulate", "breakpoints", times, 0)
    if len(times) and sample_time is not None and not callable(forces):
        raise FreebodyError(
            "simulate: breakpoints= and sample_time= exclude each other; give one of them."
        )
    return times


def _table(model: Model, t: Array, given: ArrayLike, name: str) -> Array:
    """(nv,) or (..., T, nv)."""
    rows = row_times(given)
    if is_labelled(given):
        given = vector("simulate", model, name, given)
    table = as_floats("simulate", name, given)
    if table.shape != (model.nv,):
        check_core(
            "simulate", name, table, (model.nv,), f"model {model.name!r} has nv = {model.nv}"
        )
        if table.shape[-2] not in (1, len(t)):
            raise FreebodyError(
                f"simulate: {name} has shape {table.shape}, expected ({model.nv},), ({len(t)}, "
                f"{model.nv}) or a function. Of many motions at once it is (..., {len(t)}, "
                f"{model.nv}), or (..., 1, {model.nv}) where it does not change."
            )
    if table.ndim == 2:
        refuse_other_times(name, rows, t)
    refuse_not_finite("simulate", name, table, 1, model.velocity_names)
    refuse_passive("simulate", model, table)
    return table


def refuse_other_times(name: str, rows: Array | None, t: Array) -> None:
    """Refuse a table of (T, …) whose rows carry other times than t (T,)."""
    if rows is not None and np.abs(rows - t).max() > _SAME * (t[-1] - t[0]):
        k = int(np.argmax(np.abs(rows - t)))
        label, time = compared(rows[k], t[k], digits=6)
        raise FreebodyError(
            f"simulate: the rows of {name} are labelled with other times than t: row {k} with "
            f"{label}, where t[{k}] = {time} s. Interpolate the table at t, or give its plain "
            f"array if its rows are those at t."
        )


def drive_of(
    model: Model, t: Array, given: Given, batch: tuple[int, ...], name: str = "torque"
) -> Drive:
    """What was given, of all motions of a batch at once: at any time from the first of t to the
    last, linear between them where it is a table. name: of the argument."""
    if isinstance(given, np.ndarray):
        whole = (*batch, model.nv)
        return lambda now, q, qd: np.broadcast_to(row_at(now, t, given), whole)
    return given if isinstance(given, CompiledTorque) else batched(model, given, batch, name)


def batched(
    model: Model, function: TorqueFunction, batch: tuple[int, ...], name: str = "torque"
) -> Drive:
    """A function that is called for all motions of a batch at once; what it returns broadcasts to
    (*batch, nv). name: of the argument."""
    whole, returned = (*batch, model.nv), f"what {name}(t, q, qd) returns"

    def drive(now: Array, q: Array, qd: Array) -> Array:
        tau = function(float(now), q.copy(), qd.copy())  # which may work in place
        if is_labelled(tau):
            tau = vector("simulate", model, returned, tau)
        tau = np.array(as_floats("simulate", returned, tau))
        if tau.shape not in (whole, (model.nv,)):
            told = "it is called with all motions at once"
            raise ShapeError("simulate", returned, tau.shape, str(whole), told)
        if model.passive and np.isfinite(tau).all():
            refuse_passive("simulate", model, tau)
        return np.broadcast_to(tau, whole)

    return drive


def _checked(model: Model, function: TorqueFunction, name: str) -> Drive:
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
