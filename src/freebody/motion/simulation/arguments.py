"""The arguments of `simulate`, checked: sizes, names, times and contacts; torques, forces and
wrenches as constants, tables over time, Python functions, or laws compiled by `fb.compile`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import (
    Array,
    above_zero,
    as_floats,
    check_core,
    is_count,
    refuse_not_finite,
)
from freebody.errors import FreebodyError, KindError, UnknownNameError, listed, shown
from freebody.kernels.formula_variants import several
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.formulas.record import INPUTS
from freebody.kernels.lookup import ColumnKernel, KernelList
from freebody.kernels.parameter_inputs import InputKernel
from freebody.labels import is_labelled, row_times
from freebody.model.drives import LAWS
from freebody.model.losses import lossy_joints, require_lossless
from freebody.model.model import Model
from freebody.motion.simulation.dry_friction_and_stops import JointContacts, joint_contacts
from freebody.motion.simulation.first_order_system import FINEST
from freebody.motion.simulation.prepared_simulation import (
    CompiledTorque,
    TorqueArgument,
    TorqueFunction,
    TorqueInput,
)
from freebody.motion.simulation.results import RECORDED
from freebody.motion.simulation.step_kernels import STATE
from freebody.motion.smooth_friction import WIDTH, smooth_friction
from freebody.outputs.number_text import compared
from freebody.program import Argument, Program
from freebody.targets import Kernel
from freebody.trees.controllers import not_negative
from freebody.trees.public_calls import FrameWrenchTable, JointVector, vector, wrenches_by_frame
from freebody.trees.special_joints import all_driven, refuse_passive

TOLERANCE = 1e-10
_FRICTION = ("smooth", "dry")
_DRY = next(law.numbers[0] for law in LAWS.values() if law.signed)
_SAME_TIME = 1e-9  # of the duration: how far the label of a row may be from its time


def require_counts(**given: Any) -> None:
    """Refuse arguments that are neither None nor a whole number above 0."""
    for name, value in given.items():
        if value is not None and not is_count(value):
            raise FreebodyError(
                f"simulate: {name} is {shown(value)}, expected a whole number above 0."
            )


def require_sizes(
    step: float | None, tolerance: float | None, friction_width: float | None, max_step: float
) -> None:
    """Refuse steps, tolerances and widths that are not above 0, and too fine a tolerance."""
    above_zero("simulate", "friction_width", WIDTH if friction_width is None else friction_width)
    above_zero("simulate", "step", 1.0 if step is None else step, "seconds")
    above_zero("simulate", "tolerance", TOLERANCE if tolerance is None else tolerance)
    above_zero("simulate", "max_step", 1.0 if max_step == np.inf else max_step, "seconds")
    if tolerance is not None and tolerance < FINEST:
        raise FreebodyError(
            f"simulate: tolerance is {tolerance:g}, finer than the rounding of numbers lets any "
            f"motion be known; from about 1e-12 on it has a meaning."
        )


def require_friction(model: Model, friction: str, width: float | None) -> None:
    """Refuse a width of friction where friction is dry or absent."""
    if width is None:
        return
    if friction == "dry":
        raise FreebodyError(
            "simulate: friction_width= is of friction='smooth'; dry friction has no width. Leave "
            "one of them out."
        )
    if not has_friction(model):
        raise FreebodyError(
            f"simulate: friction_width= is of dry friction, and no joint of {model.name!r} has "
            f"any: leave it out, or give a joint some (model.with_drive(joint, {_DRY.name}=…))."
        )


def has_friction(model: Model) -> bool:
    """Whether some drive of the model has friction that depends on the sign of a rate."""
    return smooth_friction(model)[1].acts or bool(lossy_joints(model.bodies))


def recorded(model: Model, names: Sequence[str] | str | None) -> tuple[str, ...]:
    """Names of the quantities that are wanted; None: all that the model has."""
    known = [name for name, quantity in RECORDED.items() if model.loops or not quantity.loops]
    if names is None:
        return tuple(known)
    listed = several("simulate", "record=", names)
    for name in listed:
        if name not in known:
            raise UnknownNameError("quantity", name, "record=", known)
    if not listed or len(set(listed)) < len(listed):
        raise FreebodyError("simulate: record= names at least one quantity, and each once.")
    return listed


def times_of(t: ArrayLike) -> Array:
    """The times t (T,), at least two, which increase."""
    times = as_floats("simulate", "t", t)
    if times.ndim != 1 or len(times) < 2:
        raise FreebodyError(f"simulate: t has shape {times.shape}, expected at least two times.")
    refuse_not_finite("simulate", "t", times, 0)
    if (np.diff(times) <= 0).any():
        raise FreebodyError("simulate: the times t must increase.")
    return times


def contacts_of(
    model: Model, friction: str, restitution: JointVector | float | None
) -> JointContacts | None:
    """The dry friction and stops of a model as given; None where there are none."""
    if friction not in _FRICTION:
        raise UnknownNameError("model of friction", friction, "simulate", _FRICTION)
    share = None
    if restitution is not None:
        share = restitution if is_labelled(restitution) else np.asarray(restitution)
        if isinstance(share, np.ndarray) and not share.ndim:
            share = np.full(model.nv, as_floats("simulate", "restitution", share))
        share = vector("simulate", model, "restitution", share)
        refuse_not_finite("simulate", "restitution", share, 1, model.velocity_names)
        if ((share < 0.0) | (share > 1.0)).any():
            bad = share[(share < 0.0) | (share > 1.0)].flat[0]
            raise FreebodyError(
                f"simulate: restitution is {bad:g}, expected from 0 (no rebound) to 1 (elastic)."
            )
    if friction == "smooth" and share is None:
        return None
    require_lossless(
        "simulate: friction='dry' and restitution=",
        model,
        " (friction='smooth' and method='implicit' are)",
    )
    if model.loops:
        raise FreebodyError(
            f"simulate: friction='dry' and restitution= need an open chain, and {model.name!r} has "
            f"loops, in which several joints hold one motion and what each of them holds is not "
            f"determined: leave them out (friction is then smooth), and give stops as part of the "
            f"torque."
        )
    contacts = joint_contacts(model, friction == "dry", share)
    if share is not None and not np.isfinite([contacts.lower, contacts.upper]).any():
        raise FreebodyError(
            f"simulate: restitution= is of stops at the limits of joints, and no joint of "
            f"{model.name!r} has one: leave it out, or give its joints limits."
        )
    return contacts


def torque_of(
    model: Model,
    t: Array,
    torque: TorqueArgument,
    inputs: Mapping[str, Any] | None,
    breakpoints: Array,
    sample_time: float | None,
    forces: TorqueInput | None,
) -> TorqueInput:
    """The torque argument of `simulate`, checked; forces: those that act in addition."""
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
    """The forces argument of `simulate`, checked, which may act at passive joints; None for
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
    """Each wrench by its frame, with the argument's name for messages: (..., 1, six), or (..., T,
    six) at the times t (T,)."""
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
    """The torque law of a kernel, with its inputs checked; given: inputs other than t, q and qd, by
    name. name: of the argument; only `torque` takes such inputs."""
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
    """Refuse a law made for another robot: t, q, qd and the single output must have the model's
    shapes."""
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
    """Refuse inputs that the law does not know, and a law some of whose inputs are not given."""
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
    """A further input of a law as an array (..., *core); gain: whether it must not be negative."""
    name, shape = f"torque_inputs[{argument.name!r}]", argument.shape
    array = as_floats("simulate", name, given)
    check_core("simulate", name, array, shape, "as it was compiled")
    refuse_not_finite("simulate", name, array, len(shape))
    if gain:
        rows = model.velocity_names if shape == (model.nv,) else range(*shape)
        not_negative("simulate", name, array, [*map(str, rows)])
    return array


def _gains(law: Program) -> tuple[str, ...]:
    """Names of the inputs of a kernel from `FORMULAS` that must not be negative, such as gains;
    none for laws of the user's own, whose names are arbitrary."""
    formula, names = FORMULAS.get(law.name), tuple(x.name for x in law.inputs)
    if formula is None or names != formula.inputs:
        return ()
    return tuple(name for name in names if INPUTS[name].positive is not None)


def _table(model: Model, t: Array, given: ArrayLike, name: str) -> Array:
    """A table of torques or forces, checked: (nv,) or (..., T, nv)."""
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
    """Refuse a table (T, …) whose rows are labelled with other times than t (T,)."""
    if rows is not None and np.abs(rows - t).max() > _SAME_TIME * (t[-1] - t[0]):
        k = int(np.argmax(np.abs(rows - t)))
        label, time = compared(rows[k], t[k], digits=6)
        raise FreebodyError(
            f"simulate: the rows of {name} are labelled with other times than t: row {k} with "
            f"{label}, where t[{k}] = {time} s. Interpolate the table at t, or give its plain "
            f"array if its rows are those at t."
        )
