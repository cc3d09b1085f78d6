"""`simulate`: the motion that torques cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, as_floats, is_count, refuse_not_finite
from freebody.errors import FreebodyError, UnknownNameError, listed, shown, warn
from freebody.labels import is_labelled
from freebody.loops.equations import taken_at
from freebody.model.model import Model
from freebody.motion.friction import WIDTH, smooth_friction
from freebody.motion.simulation.alone import one_by_one
from freebody.motion.simulation.closed_chain_integration import EXPLICIT
from freebody.motion.simulation.compiled_torque import CompiledTorque
from freebody.motion.simulation.driven_steps import STEP_METHODS
from freebody.motion.simulation.integration import FINEST, METHODS
from freebody.motion.simulation.interrupted import SimulationInterrupted, SimulationStopped
from freebody.motion.simulation.joint_contacts import JointContacts, joint_contacts, refuse_beyond
from freebody.motion.simulation.motion_lanes import MotionLanes
from freebody.motion.simulation.paced import Progress, paced
from freebody.motion.simulation.simulation import Simulated, Simulation
from freebody.motion.simulation.simulation_dataset import dataset, recorded
from freebody.motion.simulation.stepped import stepped
from freebody.motion.simulation.torques import (
    Given,
    Torque,
    breakpoints_of,
    forces_of,
    torque_of,
)
from freebody.motion.simulation.unending import MOST
from freebody.motion.simulation.wrench_tables import all_wrenches, warn_of_tables
from freebody.targets import result_memory
from freebody.trees.public_calls import Vector, Wrenches, vector
from freebody.trees.special_joints import refuse_massless

if TYPE_CHECKING:
    import xarray as xr

_TOLERANCE = 1e-10
MOST_COMPILED = 1e12
"""Equal steps in compiled code: beyond these a run would take days."""
_FRICTION = ("smooth", "dry")
_TO_EVENTS = ("auto", "rk4", "semi-implicit")


def simulate(
    model: Model,
    q: Vector,
    qd: Vector,
    t: ArrayLike,
    torque: Torque = None,
    wrenches: Wrenches = None,
    method: str = "auto",
    *,
    step: float | None = None,
    tolerance: float | None = None,
    friction: str = "smooth",
    friction_width: float | None = None,
    restitution: Vector | float | None = None,
    max_step: float = np.inf,
    breakpoints: ArrayLike = (),
    sample_time: float | None = None,
    torque_inputs: Mapping[str, Any] | None = None,
    wrench_tables: Wrenches = None,
    forces: Torque = None,
    record: str | Sequence[str] | None = None,
    every: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """The motion over the times t (T,) from the state q (..., nq), qd (..., nv) at t[0]; of many
    states, or a family of robots, all at once.

    torque: of the drives (N m, N): None for none; (nv,) constant; (..., T, nv) at the times t,
    linear between them, integrated from row to row; a function f(t, q, qd) -> (..., nv), called
    with all states; or a kernel of `fb.compile` with inputs t, q, qd or some of them, which is
    compiled into the steps; what else it takes is given by name in torque_inputs, arrays (...,
    *core). A function or law must be smooth except at its `breakpoints` (s), where the integration
    restarts, so that no jump or kink is stepped over; max_step (s) bounds the steps elsewhere:
    without either, a pulse between two of the times at which it is evaluated is not seen. With
    sample_time (s) it is a controller: called once at t[0], t[0] + sample_time, …, with the state
    there, its torque held until the next. wrenches: constant, as for `inverse_dynamics`;
    wrench_tables: (..., T, six) at the times t, given and integrated as a table of torques. forces:
    generalized forces that no drive gives, of springs between links or drag, at passive joints too:
    constant, a table, a function or a compiled law (of t, q and qd alone), as torque, but not
    sampled.

    method: "rk4", "semi-implicit" and "implicit" take equal steps of at most `step` (s; None: from
    each time of t to the next) without error control. One of scipy's integrators, and "auto",
    choose their steps. "auto" takes of one state DOP853, or an implicit method where the motion is
    stiff, that is where a part of it dies away a thousand times within the duration: Radau if
    friction does that, LSODA if the torque function does, from the start or from where the steps of
    DOP853 show it; of many states "rk4", each step made whole and in halves, of a size of its own
    for each state (of a Python function one for all); with `step` given "rk4". An explicit method
    asked for by name warns where the motion is stiff. tolerance (1e-10): how near the end is to be,
    relative to the motion: the relative error of a step is a hundredth of it (of Radau and BDF,
    which damp errors, as much), the absolute one a hundredth of that.

    friction: "smooth": Coulomb friction acts as c tanh(q̇ / friction_width), 1e-3 rad/s or m/s (c
    q̇ / √(q̇² + width²) in "implicit"), so that a joint at rest creeps instead of sticking. "dry": as
    c sign(q̇), and a joint that comes to rest stays there as long as at most c is needed to hold it.
    restitution: None: nothing stops a joint at its limit. A number from 0 to 1, or (..., nv): a
    joint rebounds from stops at its limits with this fraction of its speed; the others change as
    the impulse demands (Newton's law of impact); below 1e-5 rad/s or m/s it comes to rest there.
    Dry friction and stops need an open chain and the method "auto", "rk4" or "semi-implicit":
    steps end at the time of each change.

    record: names of what is wanted of the result; None: all. every: of the times t each so many-th
    is kept. threads: how many share many states; by default all processors. progress: called with a
    text and the fraction done.

    Closed chains: the state must satisfy the loops; explicit methods and the three of equal steps,
    each step projected back onto the loops (positions and rates), so that there is no drift;
    loop_gap (m) and loop_rate (m/s) are part of the result.

    Returns a dataset over `time`, of many states over `sample`, of a family over `member` too, with
    q, qd, qdd, tau, energies and powers, units as attributes; what was used stands in its
    attributes. Raises SingularError for joints without inertia, PassiveJointError for a torque at a
    joint that nothing drives, FreebodyError when the integration cannot go on or would not end,
    as where a sampled torque is unstable; of many motions, those that cannot go on are NaN from
    there, with a warning. The `result` of this error, and of the KeyboardInterrupt that Ctrl-C
    raises, is the dataset of what there was.
    """
    _require_counts(every=every, threads=threads)
    _require_sizes(step, tolerance, friction_width, max_step)
    _require_friction(model, friction, friction_width)
    names = recorded(model, record)
    times = _times(t)
    if every >= len(times):
        raise FreebodyError(
            f"simulate: every is {every}, beyond the {len(times)} times of t: only the start would "
            f"be kept."
        )
    others = forces_of(model, times, forces)
    ends = breakpoints_of(breakpoints, sample_time, others)
    contacts = _contacts(model, friction, restitution)
    asked = _asked(
        model if contacts is None else smooth_friction(model)[0] if friction == "dry" else model,
        (q, qd),
        times,
        torque_of(model, times, torque, torque_inputs, ends, sample_time, others),
        others,
        all_wrenches(model, times, wrenches, wrench_tables),
        contacts=contacts,
        tolerance=_TOLERANCE if tolerance is None else tolerance,
        width=WIDTH if friction_width is None else friction_width,
        max_step=max_step,
        step=step,
        breakpoints=ends,
        sample_time=sample_time,
        every=every,
        threads=threads,
        tell=paced(progress, "simulating"),
    )
    chosen = _method(model, method, tolerance, asked)
    _refuse_endless(asked, chosen)
    if not model.loops:
        refuse_massless(model, "simulate")
    if contacts is not None:
        refuse_beyond(model, contacts, asked.q)
    result = _nothing_yet(asked, _used(model, asked, chosen, friction))
    try:
        _run(asked, chosen, result)
        return dataset(asked, result, names)
    except SimulationStopped as stopped:
        stopped.result = dataset(asked, result.until_now(), names)
        raise
    except KeyboardInterrupt:
        raise SimulationInterrupted(dataset(asked, result.until_now(), names)) from None


def _nothing_yet(asked: Simulation, used: dict[str, Any]) -> Simulated:
    """Where the motions are put."""
    kept = asked.t[:: asked.every]
    q, qd = (
        result_memory.empty((*asked.lanes.shape, len(kept), n))
        for n in (asked.model.nq, asked.model.nv)
    )
    for made, start in ((q, asked.q), (qd, asked.qd)):
        made[...] = np.nan
        made[..., 0, :] = start
    return Simulated(kept, q, qd, used)


def _run(asked: Simulation, method: str, result: Simulated) -> None:
    """Fill in the motions: all at once by steps, or one by one by scipy's integrators."""
    if not asked.lanes.count:
        return
    by_steps = asked.lanes.shape or asked.contacts is not None
    if method in STEP_METHODS or (method == "auto" and by_steps):
        stepped(asked, method, result)
    else:
        one_by_one(asked, method, result)


def _require_counts(**given: Any) -> None:
    for name, value in given.items():
        if value is not None and not is_count(value):
            raise FreebodyError(
                f"simulate: {name} is {shown(value)}, expected a whole number above 0."
            )


def _require_sizes(
    step: float | None, tolerance: float | None, friction_width: float | None, max_step: float
) -> None:
    above_zero("simulate", "friction_width", WIDTH if friction_width is None else friction_width)
    above_zero("simulate", "step", 1.0 if step is None else step, "seconds")
    above_zero("simulate", "tolerance", _TOLERANCE if tolerance is None else tolerance)
    above_zero("simulate", "max_step", 1.0 if max_step == np.inf else max_step, "seconds")
    if tolerance is not None and tolerance < FINEST:
        raise FreebodyError(
            f"simulate: tolerance is {tolerance:g}, finer than the rounding of numbers lets any "
            f"motion be known; from about 1e-12 on it has a meaning."
        )


def _require_friction(model: Model, friction: str, width: float | None) -> None:
    """Refuse a width of friction that is not there, or not smooth."""
    if width is None:
        return
    if friction == "dry":
        raise FreebodyError(
            "simulate: friction_width= is of friction='smooth'; dry friction has no width. Leave "
            "one of them out."
        )
    if not _rubs(model):
        raise FreebodyError(
            f"simulate: friction_width= is of Coulomb friction, and no joint of {model.name!r} has "
            f"any: leave it out, or give a joint some (model.with_drive(joint, coulomb=…))."
        )


def _rubs(model: Model) -> bool:
    return any(b.drive is not None and np.any(b.drive.coulomb) for b in model.tree.bodies)


def _refuse_endless(asked: Simulation, chosen: str) -> None:
    """Refuse steps of which there would be too many, whether they are equal or at most so long."""
    equal = chosen in STEP_METHODS
    name, size = ("step", asked.step) if equal else ("max_step", asked.max_step)
    if size is None:
        return
    functions = [
        x
        for x in (asked.torque if asked.sample_time is None else None, asked.forces)
        if callable(x) and not isinstance(x, CompiledTorque)
    ]
    quick = equal and not functions and asked.contacts is None
    most, count = MOST_COMPILED if quick else MOST, asked.duration / size
    if count > most:
        said = "" if quick else " where Python makes each of them"
        raise FreebodyError(
            f"simulate: {name} is {size:g} s, {count:.3g} steps in this run; {most:g} are the most"
            f"{said}."
        )


def _asked(
    model: Model,
    state: tuple[Vector, Vector],
    t: Array,
    torque: Given,
    forces: Given | None,
    wrenches: Mapping[str, tuple[str, Array]],
    **others: Any,
) -> Simulation:
    """The arrays checked, and the batch that they make."""
    named = {
        name: vector("simulate", model, name, value)
        for name, value in zip(("q", "qd"), state, strict=True)
    }
    for name, array in named.items():
        refuse_not_finite("simulate", name, array, 1)
    model = taken_at(model, named["q"])
    batches = {name: x.shape[:-1] for name, x in named.items()}
    batches |= {name: w.shape[:-2] for name, w in wrenches.values()}
    warn_of_tables(t, wrenches, named["q"])
    for name, table in (("torque", torque), ("forces", forces)):
        if not isinstance(table, np.ndarray):
            continue
        batches[name] = table.shape[:-2]
        if table.shape[:-1] == (len(t),) == batches["q"]:
            one = "one torque" if name == "torque" else "one row"
            warn(
                f"simulate: {name} {table.shape} is taken as a table over the {len(t)} times, the "
                f"same for all motions; {one} for each is {(len(t), 1, model.nv)}, a table "
                f"{(1, *table.shape)} says the same as this without a warning.",
            )
    if isinstance(torque, CompiledTorque):
        batches |= torque.batches
    if model.family:
        batches["model.family"] = model.family
    contacts = others["contacts"]
    if contacts is not None:
        batches["restitution"] = contacts.restitution.shape[:-1]
    try:
        shape = np.broadcast_shapes(*batches.values())
    except ValueError:
        said = ", ".join(f"{name} {batch}" for name, batch in batches.items())
        raise FreebodyError(
            f"simulate: the batch shapes do not broadcast together: {said}."
        ) from None
    loads = {frame: w for frame, (_, w) in wrenches.items()}
    state = named["q"], named["qd"]
    return Simulation(model, *state, t, torque, forces, loads, MotionLanes(shape), **others)


def _method(model: Model, method: str, tolerance: float | None, asked: Simulation) -> str:
    """The method itself, where it is known and all that was given is of it; with a step "rk4" for
    "auto"."""
    known, of = (EXPLICIT, "simulate of a closed chain") if model.loops else (METHODS, "simulate")
    if method != "auto" and method not in (*known, *STEP_METHODS):
        raise UnknownNameError("method", method, of, ("auto", *known, *STEP_METHODS))
    chosen = "rk4" if method == "auto" and asked.step is not None else method
    if asked.contacts is not None and chosen not in _TO_EVENTS:
        raise FreebodyError(
            f"simulate: friction='dry' and restitution= need steps that end where a joint "
            f"sticks, slides or meets its stop; method {chosen!r} has none: take one of "
            f"{listed(_TO_EVENTS)}."
        )
    if chosen in STEP_METHODS:
        for name, given in (
            ("tolerance", tolerance is not None),
            ("max_step", np.isfinite(asked.max_step)),
        ):
            if given:
                raise FreebodyError(
                    f"simulate: {name}= is of methods that choose their steps; those of "
                    f"{chosen!r} are equal: give step= instead, or method='auto'."
                )
    elif asked.step is not None:
        raise FreebodyError(
            f"simulate: step= is of the methods of equal steps, {', '.join(STEP_METHODS)}; "
            f"{chosen} chooses its steps: bound them by max_step=."
        )
    return chosen


def _contacts(
    model: Model, friction: str, restitution: Vector | float | None
) -> JointContacts | None:
    """Dry friction and stops, where there are any."""
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
    if model.loops:
        raise FreebodyError(
            f"simulate: friction='dry' and restitution= need an open chain, and {model.name!r} has "
            f"loops: leave them out, and give stops as part of the torque."
        )
    contacts = joint_contacts(model, friction == "dry", share)
    if share is not None and not np.isfinite([contacts.lower, contacts.upper]).any():
        raise FreebodyError(
            f"simulate: restitution= is of stops at the limits of joints, and no joint of "
            f"{model.name!r} has one: leave it out, or give its joints limits."
        )
    return contacts


def _used(model: Model, asked: Simulation, chosen: str, friction: str) -> dict[str, Any]:
    """What stands in the result's attributes."""
    coulomb = STEP_METHODS["rk4" if chosen not in STEP_METHODS else chosen].coulomb
    told = "c sign(q̇), sticking at rest" if friction == "dry" else coulomb
    stops = (
        asked.contacts is not None
        and np.isfinite([asked.contacts.lower, asked.contacts.upper]).any()
    )
    return {
        "method": chosen,
        **({"tolerance": asked.tolerance} if chosen not in STEP_METHODS else {}),
        "coulomb_friction": told.format(width=asked.width) if _rubs(model) else "none",
        "friction_width": asked.width,
        **({"stops": "at the limits, rebound with the fraction restitution="} if stops else {}),
    }


def _times(t: ArrayLike) -> Array:
    times = as_floats("simulate", "t", t)
    if times.ndim != 1 or len(times) < 2:
        raise FreebodyError(f"simulate: t has shape {times.shape}, expected at least two times.")
    refuse_not_finite("simulate", "t", times, 0)
    if (np.diff(times) <= 0).any():
        raise FreebodyError("simulate: the times t must increase.")
    return times
