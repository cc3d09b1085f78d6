"""`simulate`: the motions that torques cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.model.model import Model
from freebody.motion.friction import WIDTH, sticking_friction
from freebody.motion.simulation.arguments import (
    TOLERANCE,
    all_wrenches,
    breakpoints_of,
    contacts_of,
    forces_of,
    has_friction,
    recorded,
    require_counts,
    require_friction,
    require_sizes,
    times_of,
    torque_of,
)
from freebody.motion.simulation.first_order_system import EXPLICIT, METHODS
from freebody.motion.simulation.joint_contacts import refuse_beyond
from freebody.motion.simulation.one_by_one import one_by_one
from freebody.motion.simulation.results import (
    Simulated,
    SimulationInterrupted,
    SimulationStopped,
    dataset,
)
from freebody.motion.simulation.run import (
    CompiledTorque,
    Progress,
    Simulation,
    TorqueArgument,
    paced,
    simulation_of,
)
from freebody.motion.simulation.side_by_side import side_by_side
from freebody.motion.simulation.step_kernels import STEP_METHODS
from freebody.motion.simulation.unending import MOST
from freebody.targets import result_memory
from freebody.trees.public_calls import FrameWrenchTable, JointVector, refuse_without_length
from freebody.trees.special_joints import refuse_massless

if TYPE_CHECKING:
    import xarray as xr

_MOST_COMPILED = 1e12
"""Equal steps in compiled code: beyond these a run would take days."""
_TO_EVENTS = ("auto", "rk4", "semi-implicit")


def simulate(
    model: Model,
    q: JointVector,
    qd: JointVector,
    t: ArrayLike,
    torque: TorqueArgument = None,
    wrenches: FrameWrenchTable = None,
    method: str = "auto",
    *,
    step: float | None = None,
    tolerance: float | None = None,
    friction: str = "smooth",
    friction_width: float | None = None,
    restitution: JointVector | float | None = None,
    max_step: float = np.inf,
    breakpoints: ArrayLike = (),
    sample_time: float | None = None,
    torque_inputs: Mapping[str, Any] | None = None,
    wrench_tables: FrameWrenchTable = None,
    forces: TorqueArgument = None,
    record: str | Sequence[str] | None = None,
    every: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """The motion that torques cause over given times from a given state; of many states, or of a
    family of robots, all at once.

    Parameters
    ----------
    model
        The robot. The state of a closed chain must satisfy its loops.
    q : (..., nq), rad or m
        Positions at t[0]; leading axes are those of many motions.
    qd : (..., nv), rad/s or m/s
        Rates at t[0].
    t : (T,), s
        The times of the result, increasing.
    torque : N m or N
        Torques of the drives: None for none; (nv,) constant; (..., T, nv) at the times t, linear
        between them, integrated from row to row; a function f(t, q, qd) -> (..., nv), called with
        all states; or a kernel of `fb.compile` with inputs t, q, qd or some of them, which is
        compiled into the steps. A function or law must be smooth except at its `breakpoints`.
    wrenches
        Constant external wrenches, as for `inverse_dynamics`.
    method
        "rk4", "semi-implicit" and "implicit" take equal steps without error control. One of scipy's
        integrators (DOP853, RK45, Radau, BDF, LSODA), and "auto", choose their steps. "auto" takes
        of one state DOP853, or an implicit method where the motion is stiff, that is where a part
        of it dies away a thousand times within the duration: Radau if friction does that, LSODA if
        the torque function does, from the start or from where the steps of DOP853 show it; of many
        states "rk4", each step made whole and in halves, of a size of its own for each state (of a
        Python function one for all); with `step` given "rk4". An explicit method asked for by name
        warns where the motion is stiff. Closed chains: explicit methods and the three of equal
        steps, each step projected back onto the loops (positions and rates), so that there is no
        drift.
    step : s
        The longest of equal steps; None: from each time of t to the next.
    tolerance
        How near the end is to be, relative to the motion (1e-10): the relative error of a step is
        a hundredth of it (of Radau and BDF, which damp errors, as much), the absolute one a
        hundredth of that.
    friction
        "smooth": dry friction acts as c tanh(q̇ / friction_width) (c q̇ / √(q̇² + width²) in
        "implicit"), so that a joint at rest creeps instead of sticking. "dry": as c sign(q̇), and a
        joint that comes to rest stays there as long as at most c is needed to hold it. Dry friction
        and stops need an open chain and the method "auto", "rk4" or "semi-implicit": steps end at
        the time of each change.
    friction_width : rad/s or m/s
        The rate over which smooth friction turns round (1e-3).
    restitution : a number from 0 to 1, or (..., nv)
        A joint rebounds from stops at its limits with this fraction of its speed; the others change
        as the impulse demands (Newton's law of impact); below 1e-5 rad/s or m/s it comes to rest
        there. None: nothing stops a joint at its limit.
    max_step : s
        The longest of steps that a method chooses. Without it and `breakpoints` a pulse between two
        of the times at which a torque function is evaluated is not seen.
    breakpoints : (k,), s
        Times at which a torque function jumps or bends: the integration restarts there, so that no
        jump or kink is stepped over.
    sample_time : s
        The torque function is a controller: called once at t[0], t[0] + sample_time, …, with the
        state there, its torque held until the next.
    torque_inputs
        Further inputs of a compiled torque by name, arrays (..., *core).
    wrench_tables : (..., T, six), N m and N
        External wrenches at the times t, given as `wrenches`, integrated as a table of torques.
    forces : N m or N
        Generalized forces that no drive gives, of springs between links or drag, at passive joints
        too: constant, a table, a function or a compiled law (of t, q and qd alone), as torque, but
        not sampled.
    record
        Names of the quantities that the result has; None: all.
    every
        Of the times t each so many-th is kept.
    threads
        How many threads share many states; None: one for each processor.
    progress
        A function that is called with a text and the fraction done.

    Returns
    -------
    xarray.Dataset
        Over `time`, of many states over `sample`, of a family over `member` too: q, qd, qdd, tau,
        energies and powers, of a closed chain loop_gap (m) and loop_rate (m/s), with units as
        attributes. The attributes of the dataset say what was used.

    Raises
    ------
    SingularError
        A joint moves no inertia.
    PassiveJointError
        A torque acts at a joint that nothing drives.
    FreebodyError
        The integration cannot go on or would not end, as where a sampled torque is unstable. Of
        many motions, those that cannot go on are NaN from there, with a warning. The `result` of
        this error, and of the KeyboardInterrupt that Ctrl-C raises, is the dataset up to there.
    """
    require_counts(every=every, threads=threads)
    require_sizes(step, tolerance, friction_width, max_step)
    require_friction(model, friction, friction_width)
    names = recorded(model, record)
    times = times_of(t)
    if every >= len(times):
        raise FreebodyError(
            f"simulate: every is {every}, beyond the {len(times)} times of t: only the start would "
            f"be kept."
        )
    others = forces_of(model, times, forces)
    ends = breakpoints_of(breakpoints, sample_time, others)
    contacts = contacts_of(model, friction, restitution)
    run = simulation_of(
        model if contacts is None else sticking_friction(model)[0] if friction == "dry" else model,
        (q, qd),
        times,
        torque_of(model, times, torque, torque_inputs, ends, sample_time, others),
        others,
        all_wrenches(model, times, wrenches, wrench_tables),
        contacts=contacts,
        tolerance=TOLERANCE if tolerance is None else tolerance,
        width=WIDTH if friction_width is None else friction_width,
        max_step=max_step,
        step=step,
        breakpoints=ends,
        sample_time=sample_time,
        every=every,
        threads=threads,
        tell=paced(progress, "simulating"),
    )
    chosen = _method(model, method, tolerance, run)
    _refuse_endless(run, chosen)
    if not model.loops:
        refuse_massless(model, "simulate")
    refuse_without_length("simulate", model, run.q)
    if contacts is not None:
        refuse_beyond(model, contacts, run.q)
    result = _empty_result(run, _used(model, run, chosen, friction))
    try:
        _integrate(run, chosen, result)
        return dataset(run, result, names)
    except SimulationStopped as stopped:
        stopped.result = dataset(run, result.until_now(), names)
        raise
    except KeyboardInterrupt:
        raise SimulationInterrupted(dataset(run, result.until_now(), names)) from None


def _method(model: Model, method: str, tolerance: float | None, run: Simulation) -> str:
    """The name of the method, "rk4" for "auto" with a step; refuses unknown methods, and arguments
    that belong to another method."""
    known, of = (EXPLICIT, "simulate of a closed chain") if model.loops else (METHODS, "simulate")
    if method != "auto" and method not in (*known, *STEP_METHODS):
        raise UnknownNameError("method", method, of, ("auto", *known, *STEP_METHODS))
    chosen = "rk4" if method == "auto" and run.step is not None else method
    if run.contacts is not None and chosen not in _TO_EVENTS:
        raise FreebodyError(
            f"simulate: friction='dry' and restitution= need steps that end where a joint "
            f"sticks, slides or meets its stop; method {chosen!r} has none: take one of "
            f"{listed(_TO_EVENTS)}."
        )
    if chosen in STEP_METHODS:
        for name, given in (
            ("tolerance", tolerance is not None),
            ("max_step", np.isfinite(run.max_step)),
        ):
            if given:
                raise FreebodyError(
                    f"simulate: {name}= is of methods that choose their steps; those of "
                    f"{chosen!r} are equal: give step= instead, or method='auto'."
                )
    elif run.step is not None:
        raise FreebodyError(
            f"simulate: step= is of the methods of equal steps, {', '.join(STEP_METHODS)}; "
            f"{chosen} chooses its steps: bound them by max_step=."
        )
    return chosen


def _refuse_endless(run: Simulation, chosen: str) -> None:
    """Refuse a step or a longest step so short that there would be too many steps."""
    equal = chosen in STEP_METHODS
    name, size = ("step", run.step) if equal else ("max_step", run.max_step)
    if size is None:
        return
    functions = [
        x
        for x in (run.torque if run.sample_time is None else None, run.forces)
        if callable(x) and not isinstance(x, CompiledTorque)
    ]
    quick = equal and not functions and run.contacts is None
    most, count = _MOST_COMPILED if quick else MOST, run.duration / size
    if count > most:
        reason = "" if quick else " where Python makes each of them"
        raise FreebodyError(
            f"simulate: {name} is {size:g} s, {count:.3g} steps in this run; {most:g} are the most"
            f"{reason}."
        )


def _used(model: Model, run: Simulation, chosen: str, friction: str) -> dict[str, Any]:
    """The attributes of the result: method, tolerance, friction and stops."""
    smooth = STEP_METHODS["rk4" if chosen not in STEP_METHODS else chosen].friction
    words = "c sign(q̇), sticking at rest" if friction == "dry" else smooth
    stops = run.contacts is not None and np.isfinite([run.contacts.lower, run.contacts.upper]).any()
    return {
        "method": chosen,
        **({"tolerance": run.tolerance} if chosen not in STEP_METHODS else {}),
        "dry_friction": words.format(width=run.width) if has_friction(model) else "none",
        "friction_width": run.width,
        **({"stops": "at the limits, rebound with the fraction restitution="} if stops else {}),
    }


def _empty_result(run: Simulation, used: dict[str, Any]) -> Simulated:
    """Arrays for the result, filled with the start and NaN for everything else."""
    kept = run.t[:: run.every]
    q, qd = (
        result_memory.empty((*run.lanes.shape, len(kept), n)) for n in (run.model.nq, run.model.nv)
    )
    for made, start in ((q, run.q), (qd, run.qd)):
        made[...] = np.nan
        made[..., 0, :] = start
    return Simulated(kept, q, qd, used)


def _integrate(run: Simulation, method: str, result: Simulated) -> None:
    """Fill in the motions: all at once by steps, or one by one by scipy's integrators."""
    if not run.lanes.count:
        return
    by_steps = run.lanes.shape or run.contacts is not None
    if method in STEP_METHODS or (method == "auto" and by_steps):
        side_by_side(run, method, result)
    else:
        one_by_one(run, method, result)
