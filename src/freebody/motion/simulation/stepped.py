"""Motions by steps, all at once: of equal steps, or of steps that each motion chooses."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, warn
from freebody.kernels.structural import Bound
from freebody.loops.equations import require_closed
from freebody.motion.simulation.compiled_steps import STAYING, CompiledSteps
from freebody.motion.simulation.compiled_torque import CompiledTorque
from freebody.motion.simulation.contact_events import ContactEvents
from freebody.motion.simulation.course import Course, Track, course
from freebody.motion.simulation.driven_steps import STEP_METHODS, driven_rates, driven_step
from freebody.motion.simulation.driving import Driving, driving_of
from freebody.motion.simulation.first_order_system import System, loads_over, system
from freebody.motion.simulation.integration import step_tolerance
from freebody.motion.simulation.interrupted import SimulationStopped
from freebody.motion.simulation.lane_torques import SteadyWrench, TableTorque, steady
from freebody.motion.simulation.motion_lanes import some_of
from freebody.motion.simulation.short_steps import ShortSteps, lane_drive, lane_system
from freebody.motion.simulation.side_by_side import Walk
from freebody.motion.simulation.simulation import Simulated, Simulation
from freebody.motion.simulation.step_sizes import (
    Advance,
    ControlledSteps,
    FixedSteps,
    SpanBySpan,
    step_counts,
)
from freebody.motion.simulation.steppers import (
    FunctionRates,
    FunctionStepper,
    KernelRates,
    KernelStepper,
    LaneKernel,
    Stepper,
)
from freebody.motion.simulation.torques import instants
from freebody.motion.simulation.unending import (
    GivenUp,
    SampledGrowth,
    endless,
    too_late,
    why_sampled,
)
from freebody.trees.position_rates import layout

_LOOKED_AT = 3  # motions whose stiffness is looked at
_FEW_STEPS = 8  # between two calls of a controller, to which Python may as well see itself
_NONE = np.zeros(0)


def stepped(asked: Simulation, method: str, result: Simulated) -> None:
    """Fill in the motions; method: one of equal steps, or "auto"."""
    model, lanes = asked.model, asked.lanes
    if model.loops:
        require_closed("simulate", model, asked.q, asked.qd)
    fixed = "rk4" if method == "auto" else method
    calls = _NONE
    if asked.sample_time is not None:
        calls = instants(float(asked.t[0]), float(asked.t[-1]), asked.sample_time)
    way = course(asked.t, asked.every, asked.breakpoints, calls)
    driving = driving_of(asked)
    if isinstance(asked.torque, CompiledTorque):
        driving.drive(
            asked.t[0], asked.q, asked.qd
        )  # refused here, where it acts at a passive joint
    q, qd = (lanes.all(x, 1) for x in (asked.q, asked.qd))
    events = None if asked.contacts is None else _events(asked, driving, qd)
    stepper = _stepper(asked, fixed, driving, events)
    if method != "auto":
        _warn_unstable(asked, fixed, way, driving)
    stop = threading.Event()
    watch = ShortSteps(asked, driving)
    given_up: dict[int, GivenUp] = {}
    advance = _advance(asked, method, way, stepper, events, watch, stop, given_up)
    result.used["method"] = fixed if method != "auto" else f"{fixed}, steps chosen by their error"
    if method != "auto":
        result.used["step"] = _longest(asked, way)
    if driving.held is not None:
        result.tau = np.full(result.qd.shape, np.nan)
    else:
        result.given = lambda now, q, qd: driving.drive(np.asarray(now), q, qd)
    state = q.reshape(stepper.rows, -1), qd.reshape(stepper.rows, -1)
    controller = None if driving.held is None else driving.drive
    growth = None if asked.sample_time is None else SampledGrowth(len(way.calls))
    Walk(
        Track(way, state, result),
        advance,
        lanes,
        controller,
        driving.held,
        growth,
        asked.threads,
        watch.while_telling(asked.tell),
        stop,
    ).run()
    watch.tell()
    _tell_stopped(asked, fixed, result, given_up, stepper.rows < lanes.count)


def _events(asked: Simulation, driving: Driving, qd: Array) -> ContactEvents:
    """Where dry friction and stops change the motions; qd (lanes, nv): their rates at the start."""
    assert asked.contacts is not None
    torque = driving.torque
    if torque is None and asked.lanes.shape:
        raise FreebodyError(
            f"simulate: dry friction and stops end the steps of each motion at its own times, but "
            f"a Python function is called with all motions at once: {_remedy(asked)}."
        )
    law = None if torque is None else torque.law
    kernel = _lane_kernel(asked, driven_rates(asked.model, *_frames(asked), law, driving.adds))
    rates = (
        FunctionRates(kernel, driving.acting)
        if torque is None
        else KernelRates(kernel, torque, driving.added)
    )
    return ContactEvents.of(asked.contacts, asked.lanes, rates, asked.duration, qd)


def _remedy(asked: Simulation) -> str:
    """Instead of a Python function within steps."""
    if callable(asked.forces) and not isinstance(asked.forces, CompiledTorque):
        return "compile the forces with fb.compile"
    return "compile the torque with fb.compile, or give sample_time="


def _lane_kernel(asked: Simulation, kernel: Bound) -> LaneKernel:
    rows = [asked.lanes.each(w, 2) for w in asked.wrenches.values()]
    loads = [
        SteadyWrench(w[..., 0, :]) if w.shape[-2] == 1 else TableTorque(asked.t, w) for w in rows
    ]
    return LaneKernel.of(kernel, asked.width, asked.lanes, loads)


def _frames(asked: Simulation) -> tuple[tuple[str, ...], tuple[bool, ...]]:
    """Of wrenches, and whether each changes."""
    return tuple(asked.wrenches), tuple(w.shape[-2] > 1 for w in asked.wrenches.values())


def _stepper(
    asked: Simulation,
    method: str,
    driving: Driving,
    events: ContactEvents | None,
) -> Stepper:
    model, (frames, varying), torque = asked.model, _frames(asked), driving.torque
    holding = None if events is None else (events.push, events.held)
    if torque is not None:
        more = torque.law, driving.adds, holding is not None
        kernel = _lane_kernel(asked, driven_step(model, method, frames, varying, *more))
        return KernelStepper(kernel, torque, asked.lanes.count, driving.added, holding)
    if model.loops:
        raise FreebodyError(
            f"simulate: the steps of a closed chain cannot call a Python function: "
            f"{_remedy(asked)}."
        )
    if STEP_METHODS[method].implicit:
        raise FreebodyError(
            f"simulate: method 'implicit' needs the derivatives of the torque and forces, which a "
            f"Python function does not give: {_remedy(asked)}."
        )
    whole = system(model, asked.width, *loads_over(asked.t, asked.wrenches))
    if holding is not None:
        whole = _holding(asked, whole, holding)
    return FunctionStepper(whole, driving.acting, asked.lanes.shape, classical=method == "rk4")


def _holding(asked: Simulation, whole: System, holding: tuple[Array, Array]) -> System:
    """The system of one motion some of whose coordinates are held."""
    frames, _ = _frames(asked)
    kernel = _lane_kernel(asked, driven_rates(asked.model, frames, (False,) * len(frames), None))

    def forward(q: Array, qd: Array, tau: Array, *loads: Array) -> Array:
        given = (*steady(tau), *(x[0] for x in holding))
        now = replace(kernel, wrenches=[SteadyWrench(w) for w in loads])
        return now(0, (q, qd), 0.0, 0.0, given)[0]

    return replace(whole, forward=forward)


def _advance(
    asked: Simulation,
    method: str,
    way: Course,
    stepper: Stepper,
    events: ContactEvents | None,
    watch: ShortSteps,
    stop: threading.Event,
    given_up: dict[int, GivenUp],
) -> Advance:
    if method != "auto":
        each = step_counts(way.ends - way.begins, asked.step).sum() / max(1, len(way.calls))
        if isinstance(stepper, KernelStepper) and events is None and each > _FEW_STEPS:
            block = SpanBySpan.block if way.calls else STAYING
            return CompiledSteps(stepper, asked.step, stop, block)
        return SpanBySpan(FixedSteps(stepper, asked.step, stop, events), stop)
    flat = layout(asked.model).flat and not asked.model.loops
    first = np.full(stepper.rows, asked.duration / 100)
    tolerance = step_tolerance("rk4", asked.tolerance)
    own = None if stepper.rows < asked.lanes.count or asked.model.loops else watch.look
    steps = ControlledSteps(
        stepper,
        tolerance,
        asked.max_step,
        asked.duration,
        float(asked.t[-1]),
        flat,
        first,
        stop,
        events,
        own,
        given_up=given_up,
    )
    return SpanBySpan(steps, stop)


def _longest(asked: Simulation, way: Course) -> float:
    """The longest of equal steps (s)."""
    gaps = np.diff(way.edges)
    return float((gaps / step_counts(gaps, asked.step)).max())


def _warn_unstable(asked: Simulation, method: str, way: Course, driving: Driving) -> None:
    """Say where equal steps of an explicit method are too long for the motion at its start."""
    model, lanes, reach = asked.model, asked.lanes, STEP_METHODS[method].reach
    function = any(
        callable(x) and not isinstance(x, CompiledTorque) for x in (asked.torque, asked.forces)
    )
    if model.loops or STEP_METHODS[method].implicit or (function and lanes.shape):
        return
    step = _longest(asked, way)
    for k in sorted({0, lanes.count // 2, lanes.count - 1})[:_LOOKED_AT]:
        index = lanes.index(k)
        y = np.concatenate([some_of(lanes.each(x, 1), 1, k) for x in (asked.q, asked.qd)])
        rate = lane_system(asked, k).fastest(asked.t[0], y, lane_drive(asked, k, driving))
        if rate * step > reach:
            where = at_sample(index)
            warn(
                f"simulate: the motion{where} is stiff: a part of it changes within "
                f"{1.0 / rate:.1g} s, and steps of {method!r} are stable up to {reach / rate:.1g} "
                f"s; these are {step:.1g} s. Take a shorter step= or method 'implicit'.",
            )
            return


def _tell_stopped(
    asked: Simulation,
    method: str,
    result: Simulated,
    given_up: dict[int, GivenUp],
    alike: bool,
) -> None:
    """Refuse the one motion that could not go on, warn of some among many; alike: whether all take
    the same steps."""
    # what has stopped is NaN to the end
    stopped = np.argwhere(~_going(result, (..., -1)))
    if not len(stopped):
        return
    index = tuple(map(int, stopped[0]))
    at = result.t[max(0, int(np.argmin(_going(result, index))) - 1)]
    advice = (
        "It may diverge, pass a state without finite acceleration, or, in a closed chain, come to "
        "a position where its equations do not tell; shorter steps or method 'implicit' may help."
    )
    lane = int(np.ravel_multi_index(index, asked.lanes.shape)) if index else 0
    advice = why_sampled(asked, lane) or too_late(asked.t) or advice
    # those that Python calls at once step alike
    last = given_up.get(0 if alike else lane)
    if last is not None:
        advice = endless(asked, last, lane)
    if not asked.lanes.shape:
        raise SimulationStopped(f"simulate: {method} stopped after t = {at:.6g} s. {advice}")
    warn(
        f"simulate: {len(stopped)} of {asked.lanes.count} motions could not go on and are NaN from "
        f"there, the first{at_sample(index)} after t = {at:.6g} s. {advice}",
    )


def _going(result: Simulated, at: tuple[Any, ...]) -> NDArray[np.bool_]:
    """Which positions and rates there are numbers."""
    q, qd = (np.isfinite(x[at]).all(axis=-1) for x in (result.q, result.qd))
    return np.asarray(np.logical_and(q, qd))
