"""Torques, forces and wrenches as a simulation is given them, checked: constants, tables over its
times, Python functions, and laws that `fb.compile` compiled."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, check_core, refuse_not_finite
from freebody.errors import FreebodyError, KindError, ShapeError, UnknownNameError, listed, warn
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.formulas.inputs import INPUTS
from freebody.kernels.inputs import InputKernel
from freebody.kernels.lookup import ColumnKernel, KernelList
from freebody.labels import is_labelled, row_times
from freebody.lazy import cached_property
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.simulation.first_order_system import TorqueLaw, row_at
from freebody.motion.simulation.lanes import MotionLanes, some_of
from freebody.motion.simulation.step_kernels import STATE, law_inputs
from freebody.outputs.number_text import compared
from freebody.program import Argument, Program
from freebody.targets import Kernel, compile_program
from freebody.trees.controllers import not_negative
from freebody.trees.public_calls import FrameWrenchTable, vector, wrenches_by_frame
from freebody.trees.special_joints import all_driven, refuse_passive

_SAME_TIME = 1e-9  # of the duration: how far the label of a row may be from its time

TorqueFunction = Callable[[float, Array, Array], ArrayLike]
TorqueArgument = ArrayLike | TorqueFunction | Kernel | None


def torque_of(
    model: Model,
    t: Array,
    torque: TorqueArgument,
    inputs: Mapping[str, Any] | None,
    breakpoints: Array,
    sample_time: float | None,
    forces: TorqueInput | None,
) -> TorqueInput:
    """The torque that `simulate` was given, checked; forces: those that act besides."""
    if inputs is not None and not isinstance(torque, Kernel):
        raise FreebodyError(
            "simulate: torque_inputs= is about a torque from fb.compile; a Python function has its "
            "own variables. Leave it out."
        )
    found: TorqueInput = np.zeros((1, model.nv))
    if torque is not None:
        found = _given(model, t, torque, "torque", inputs)
    breaks = len(breakpoints) and not callable(forces)
    for name, present in (("breakpoints", breaks), ("sample_time", sample_time is not None)):
        if present and not callable(found):
            raise FreebodyError(
                f"simulate: {name}= applies only to a torque that is a function f(t, q, qd); a "
                f"table is integrated from row to row. Leave it out."
            )
    return found


def forces_of(model: Model, t: Array, forces: TorqueArgument) -> TorqueInput | None:
    """The forces that `simulate` was given, checked, which may act at passive joints; None for
    none."""
    return None if forces is None else _given(all_driven(model), t, forces, "forces")


def breakpoints_of(
    given: ArrayLike, sample_time: float | None, forces: TorqueInput | None
) -> Array:
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


def all_wrenches(
    model: Model, t: Array, wrenches: FrameWrenchTable, tables: FrameWrenchTable
) -> dict[str, tuple[str, Array]]:
    """Each wrench by its frame, with its name in messages: (..., 1, six), or (..., T, six) at the
    times t (T,)."""
    given = wrenches_by_frame("simulate", model, wrenches)
    found = {frame: (f"wrenches[{frame!r}]", w[..., None, :]) for frame, w in given.items()}
    over = tables if isinstance(tables, Mapping) else {None: tables}
    named = wrenches_by_frame("simulate", model, tables, name="wrench_tables")
    for (frame, w), value in zip(named.items(), over.values(), strict=tables is not None):
        name = f"wrench_tables[{frame!r}]"
        if w.ndim < 2 or w.shape[-2] != len(t):
            raise FreebodyError(
                f"simulate: {name} has shape {w.shape}, expected (..., {len(t)}, {w.shape[-1]}): a "
                f"row for each of the {len(t)} times of t. A constant wrench is given as wrenches=."
            )
        if frame in found:
            raise FreebodyError(
                f"simulate: wrenches and wrench_tables both have frame {frame!r}; add the constant "
                f"wrench to each row of the table."
            )
        if w.ndim == 2:
            refuse_other_times(name, row_times(value), t)
        found[frame] = name, w
    for name, w in found.values():
        refuse_not_finite("simulate", name, w, 1)
    return found


def warn_of_tables(t: Array, wrenches: Mapping[str, tuple[str, Array]], state: Array) -> None:
    """Say where wrenches of many motions from one state may have been meant as a table."""
    for name, w in wrenches.values():
        if w.shape[:-1] == (len(t), 1) and state.ndim == 1:
            warn(
                f"simulate: {name} {(len(t), w.shape[-1])} is taken as a constant wrench for each "
                f"of {len(t)} motions; a table over the {len(t)} times t is given as "
                f"wrench_tables=."
            )


@dataclass(frozen=True, eq=False)
class CompiledTorque:
    """A law's program, and what it takes besides time and state, (..., *core) each, in its
    order."""

    model: Model
    law: Program
    more: tuple[Array, ...]

    @property
    def cores(self) -> tuple[int, ...]:
        """The number of axes of each further input's core."""
        return tuple(len(x.shape) for x in self.law.inputs if x.name not in STATE)

    @property
    def batches(self) -> dict[str, tuple[int, ...]]:
        """The leading shapes of the further inputs."""
        own = [x.name for x in self.law.inputs if x.name not in STATE]
        pairs = zip(self.more, self.cores, strict=True)
        shapes = [x.shape[: x.ndim - core] for x, core in pairs]
        return dict(zip((f"torque_inputs[{n!r}]" for n in own), shapes, strict=True))

    @cached_property
    def _kernel(self) -> Kernel:
        return compile_program(self.law)

    def __call__(self, t: Array, q: Array, qd: Array) -> Array:
        """The torque tau (..., nv) at a time, in a state."""
        state = {"t": t, "q": q, "qd": qd}
        found = self._kernel(*law_inputs(self.law, state, self.more))
        if self.model.passive and np.isfinite(found).all():
            refuse_passive("simulate", self.model, found)
        return np.broadcast_to(found, np.broadcast_shapes(found.shape, qd.shape))


TorqueInput = Array | TorqueFunction | CompiledTorque
"""A torque or force as it was given, checked: a table (..., T, nv), one row (..., 1, nv) that
counts at all times, a function, or one that was compiled."""


def _given(
    model: Model,
    t: Array,
    given: ArrayLike | TorqueFunction | Kernel,
    name: str,
    inputs: Mapping[str, Any] | None = None,
) -> TorqueInput:
    if isinstance(given, InputKernel | ColumnKernel | KernelList):
        raise FreebodyError(
            f"simulate: a kernel with numbers as inputs, or of a large robot, is no {name} by "
            f"itself: call it in a function f(t, q, qd)."
        )
    if isinstance(given, Kernel):
        return _compiled_torque(model, given, {} if inputs is None else inputs, name)
    if callable(given):
        return given
    table = _table(model, t, given, name)
    return table[None] if table.ndim == 1 else table


def _compiled_torque(
    model: Model, kernel: Kernel, given: Mapping[str, Any], name: str = "torque"
) -> CompiledTorque:
    """The torque of a kernel, its inputs checked; given: those besides t, q and qd, by name. name:
    of the argument, of which `torque` alone takes such inputs."""
    if not isinstance(given, Mapping):
        raise KindError("simulate", "torque_inputs", given, "a dict of names and values")
    law = kernel.program
    _require_shapes(model, law, name)
    further = [x for x in law.inputs if x.name not in STATE]
    _require_inputs([x.name for x in further], given, name)
    gains = _gains(law)
    more = tuple(_input(model, x, given[x.name], x.name in gains) for x in further)
    return CompiledTorque(model, law, more)


def _require_shapes(model: Model, law: Program, name: str) -> None:
    """Refuse a law of another robot: t, q, qd and the one output have the model's shapes."""
    sizes = {"t": (), "q": (model.nq,), "qd": (model.nv,)}
    for x in law.inputs:
        if x.name in sizes and x.shape != sizes[x.name]:
            raise FreebodyError(
                f"simulate: the compiled {name} takes {x}, but of {model.name!r} {x.name} has "
                f"shape {sizes[x.name]}."
            )
    if [x.shape for x in law.outputs] != [(model.nv,)]:
        raise FreebodyError(
            f"simulate: the compiled {name} returns {listed(map(str, law.outputs))}; expected one "
            f"output of shape ({model.nv},)."
        )


def _require_inputs(known: list[str], given: Mapping[str, Any], name: str) -> None:
    """Refuse further inputs that the law does not know, and a law that lacks some of them."""
    for one in given:
        if one not in known:
            raise UnknownNameError("input", one, "torque_inputs=", known)
    lacking = [x for x in known if x not in given]
    if not lacking:
        return
    remedy = (
        f"give torque_inputs={{{lacking[0]!r}: …}}"
        if name == "torque"
        else "compile it with these numbers inside"
    )
    raise FreebodyError(
        f"simulate: the compiled {name} takes {listed(lacking)} besides t, q and qd: {remedy}."
    )


def _input(model: Model, argument: Argument, given: Any, gain: bool) -> Array:
    """A further input of a law as an array (..., *core); gain: whether it makes no sense below
    0."""
    name, shape = f"torque_inputs[{argument.name!r}]", argument.shape
    array = as_floats("simulate", name, given)
    check_core("simulate", name, array, shape, "as it was compiled")
    refuse_not_finite("simulate", name, array, len(shape))
    if gain:
        rows = model.velocity_names if shape == (model.nv,) else range(*shape)
        not_negative("simulate", name, array, [*map(str, rows)])
    return array


def _gains(law: Program) -> tuple[str, ...]:
    """Names of the inputs that make no sense below 0, of a kernel that is one of `FORMULAS`:
    control laws refuse it there as where they are called; in a law of the user's own a name says
    nothing."""
    formula, names = FORMULAS.get(law.name), tuple(x.name for x in law.inputs)
    if formula is None or names != formula.inputs:
        return ()
    return tuple(name for name in names if INPUTS[name].positive is not None)


def _table(model: Model, t: Array, given: ArrayLike, name: str) -> Array:
    """A checked table: (nv,) or (..., T, nv)."""
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
    if rows is not None and np.abs(rows - t).max() > _SAME_TIME * (t[-1] - t[0]):
        k = int(np.argmax(np.abs(rows - t)))
        label, time = compared(rows[k], t[k], digits=6)
        raise FreebodyError(
            f"simulate: the rows of {name} are labelled with other times than t: row {k} with "
            f"{label}, where t[{k}] = {time} s. Interpolate the table at t, or give its plain "
            f"array if its rows are those at t."
        )


def drive_of(
    model: Model, t: Array, given: TorqueInput, batch: tuple[int, ...], name: str = "torque"
) -> TorqueLaw:
    """The torque or force of all motions of a batch at once: at any time from the first of t to the
    last, linear between them where it is a table. name: of the argument."""
    if isinstance(given, np.ndarray):
        whole = (*batch, model.nv)
        return lambda now, q, qd: np.broadcast_to(row_at(now, t, given), whole)
    return given if isinstance(given, CompiledTorque) else batched(model, given, batch, name)


def batched(
    model: Model, function: TorqueFunction, batch: tuple[int, ...], name: str = "torque"
) -> TorqueLaw:
    """A function that is called for all motions of a batch at once; what it returns broadcasts to
    (*batch, nv). name: of the argument."""
    whole, returned = (*batch, model.nv), f"what {name}(t, q, qd) returns"

    def drive(now: Array, q: Array, qd: Array) -> Array:
        tau = function(float(now), q.copy(), qd.copy())  # which may work in place
        if is_labelled(tau):
            tau = vector("simulate", model, returned, tau)
        tau = np.array(as_floats("simulate", returned, tau))
        if tau.shape not in (whole, (model.nv,)):
            hint = "it is called with all motions at once"
            raise ShapeError("simulate", returned, tau.shape, str(whole), hint)
        if model.passive and np.isfinite(tau).all():
            refuse_passive("simulate", model, tau)
        return np.broadcast_to(tau, whole)

    return drive


def one_lane(torque: CompiledTorque, lanes: MotionLanes, k: int) -> CompiledTorque:
    """The compiled torque with the further inputs of one motion."""
    pairs = zip(torque.more, torque.cores, strict=True)
    more = tuple(some_of(lanes.each(x, core), core, k) for x, core in pairs)
    return replace(torque, model=member_at(torque.model, lanes.index(k)), more=more)
