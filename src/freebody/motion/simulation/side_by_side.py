"""Many motions at once by steps: equal ones, or steps that each motion chooses. Blocks of lanes
that fit the processor's caches are shared among threads."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, warn
from freebody.kernels.structural import Bound
from freebody.loops.closure_checks import require_closed
from freebody.motion.simulation.contact_events import ContactEvents
from freebody.motion.simulation.first_order_system import (
    System,
    TorqueLaw,
    loads_over,
    step_tolerance,
    system,
)
from freebody.motion.simulation.one_step import (
    Driving,
    FunctionRates,
    FunctionStepper,
    HeldTorque,
    KernelRates,
    KernelStepper,
    LaneKernel,
    LaneTorque,
    SteadyWrench,
    Stepper,
    TableTorque,
    driving_of,
    steady,
)
from freebody.motion.simulation.prepared_simulation import (
    CompiledTorque,
    MotionLanes,
    Simulation,
    instants,
    some_of,
)
from freebody.motion.simulation.results import Simulated, SimulationStopped
from freebody.motion.simulation.step_kernels import STEP_METHODS, driven_rates, driven_step
from freebody.motion.simulation.step_sizes import (
    STAYING,
    Advance,
    CompiledSteps,
    ControlledSteps,
    FixedSteps,
    LaneMotions,
    SpanBySpan,
    StepTimes,
    step_counts,
    step_times,
)
from freebody.motion.simulation.stiffness import ShortSteps, lane_drive, lane_system
from freebody.motion.simulation.unending import (
    GivenUp,
    SampledGrowth,
    endless,
    too_late,
    why_sampled,
)
from freebody.motion.smooth_friction import without_laws
from freebody.targets.threads import cpus
from freebody.trees.position_rates import layout

_LOOKED_AT = 3  # motions whose stiffness is looked at
_FEW_STEPS = 8  # between two calls of a controller, to which Python may as well see itself
_NONE = np.zeros(0)
_LOOK = 0.05  # s
_FEWEST = 256
"""The number of motions that is worth a thread."""
_Blocks = deque[tuple[int, slice]]
"""Blocks that are to be moved, and which they are."""


def side_by_side(run: Simulation, method: str, result: Simulated) -> None:
    """Fill in all motions by steps; method: one with equal steps, or "auto"."""
    model, lanes = run.model, run.lanes
    if model.loops:
        require_closed("simulate", model, run.q, run.qd)
    fixed = "rk4" if method == "auto" else method
    calls = _NONE
    if run.sample_time is not None:
        calls = instants(float(run.t[0]), float(run.t[-1]), run.sample_time)
    times = step_times(run.t, run.every, run.breakpoints, calls)
    driving = driving_of(run)
    if isinstance(run.torque, CompiledTorque):
        driving.drive(run.t[0], run.q, run.qd)  # refused here, where it acts at a passive joint
    q, qd = (lanes.all(x, 1) for x in (run.q, run.qd))
    events = None if run.contacts is None else _events(run, driving, qd)
    stepper = _stepper(run, fixed, driving, events)
    if method != "auto":
        _warn_unstable(run, fixed, times, driving)
    stop = threading.Event()
    watch = ShortSteps(run, driving)
    given_up: dict[int, GivenUp] = {}
    advance = _advance(run, method, times, stepper, events, watch, stop, given_up)
    result.used["method"] = fixed if method != "auto" else f"{fixed}, steps chosen by their error"
    if method != "auto":
        result.used["step"] = _longest(run, times)
    if driving.held is not None:
        result.tau = np.full(result.qd.shape, np.nan)
    else:
        result.given = lambda now, q, qd: driving.drive(np.asarray(now), q, qd)
    state = q.reshape(stepper.rows, -1), qd.reshape(stepper.rows, -1)
    controller = None if driving.held is None else driving.drive
    growth = None if run.sample_time is None else SampledGrowth(len(times.calls))
    _LaneRun(
        LaneMotions(times, state, result),
        advance,
        lanes,
        controller,
        driving.held,
        growth,
        run.threads,
        watch.while_telling(run.tell),
        stop,
    ).run()
    watch.tell()
    _tell_stopped(run, fixed, result, given_up, stepper.rows < lanes.count)


def _events(run: Simulation, driving: Driving, qd: Array) -> ContactEvents:
    """The events of dry friction and stops in all motions; qd (lanes, nv): the rates at the start;
    None without contacts."""
    assert run.contacts is not None
    torque = driving.torque
    if torque is None and run.lanes.shape:
        raise FreebodyError(
            f"simulate: dry friction and stops end the steps of each motion at its own times, but "
            f"a Python function is called with all motions at once: {_remedy(run)}."
        )
    law = None if torque is None else torque.law
    robot, given = run.contacts.robot, (law, driving.adds, run.contacts.dry)
    kernel = _lane_kernel(run, driven_rates(robot, *_frames(run), *given))
    rates = (
        FunctionRates(kernel, driving.acting)
        if torque is None
        else KernelRates(kernel, torque, driving.added)
    )
    return ContactEvents.of(run.contacts, run.lanes, rates, run.duration, qd)


def _remedy(run: Simulation) -> str:
    """Advice on replacing a Python function that is called within steps."""
    if callable(run.forces) and not isinstance(run.forces, CompiledTorque):
        return "compile the forces with fb.compile"
    return "compile the torque with fb.compile, or give sample_time="


def _lane_kernel(run: Simulation, kernel: Bound) -> LaneKernel:
    rows = [run.lanes.each(w, 2) for w in run.wrenches.values()]
    loads = [
        SteadyWrench(w[..., 0, :]) if w.shape[-2] == 1 else TableTorque(run.t, w) for w in rows
    ]
    return LaneKernel.of(kernel, run.width, run.lanes, loads)


def _frames(run: Simulation) -> tuple[tuple[str, ...], tuple[bool, ...]]:
    """The frames of the wrenches, and for each whether its wrench changes over time."""
    return tuple(run.wrenches), tuple(w.shape[-2] > 1 for w in run.wrenches.values())


def _stepper(
    run: Simulation,
    method: str,
    driving: Driving,
    events: ContactEvents | None,
) -> Stepper:
    model, (frames, varying), torque = run.model, _frames(run), driving.torque
    holding = None if events is None else (events.senses, events.held)
    if torque is not None:
        contacts = run.contacts
        robot, dry = (model, False) if contacts is None else (contacts.robot, contacts.dry)
        more = torque.law, driving.adds, holding is not None, dry
        kernel = _lane_kernel(run, driven_step(robot, method, frames, varying, *more))
        return KernelStepper(kernel, torque, run.lanes.count, driving.added, holding)
    if model.loops:
        raise FreebodyError(
            f"simulate: the steps of a closed chain cannot call a Python function: {_remedy(run)}."
        )
    if STEP_METHODS[method].implicit:
        raise FreebodyError(
            f"simulate: method 'implicit' needs the derivatives of the torque and forces, which a "
            f"Python function does not give: {_remedy(run)}."
        )
    whole = system(model, run.width, *loads_over(run.t, run.wrenches))
    if holding is not None:
        whole = _holding(run, whole, holding)
    return FunctionStepper(whole, driving.acting, run.lanes.shape, classical=method == "rk4")


def _holding(run: Simulation, whole: System, holding: tuple[Array, Array]) -> System:
    """The first-order system of one motion with some coordinates held."""
    assert run.contacts is not None
    frames, _ = _frames(run)
    dry = run.contacts.dry
    robot = without_laws(  # `whole` has these
        run.contacts.robot, lambda law: law.signed and not (dry and law.grips)
    )
    kernel = _lane_kernel(run, driven_rates(robot, frames, (False,) * len(frames), None, dry=dry))

    def forward(q: Array, qd: Array, tau: Array, *loads: Array) -> Array:
        given = (*steady(tau), *(x[0] for x in holding))
        now = replace(kernel, wrenches=[SteadyWrench(w) for w in loads])
        return now(0, (q, qd), 0.0, 0.0, given)[0]

    return replace(whole, forward=forward)


def _advance(
    run: Simulation,
    method: str,
    times: StepTimes,
    stepper: Stepper,
    events: ContactEvents | None,
    watch: ShortSteps,
    stop: threading.Event,
    given_up: dict[int, GivenUp],
) -> Advance:
    if method != "auto":
        each = step_counts(times.ends - times.begins, run.step).sum() / max(1, len(times.calls))
        if isinstance(stepper, KernelStepper) and events is None and each > _FEW_STEPS:
            block = SpanBySpan.block if times.calls else STAYING
            return CompiledSteps(stepper, run.step, stop, block)
        return SpanBySpan(FixedSteps(stepper, run.step, stop, events), stop)
    flat = layout(run.model).flat and not run.model.loops
    first = np.full(stepper.rows, run.duration / 100)
    tolerance = step_tolerance("rk4", run.tolerance)
    own = None if stepper.rows < run.lanes.count or run.model.loops else watch.look
    steps = ControlledSteps(
        stepper,
        tolerance,
        run.max_step,
        run.duration,
        float(run.t[-1]),
        flat,
        first,
        stop,
        events,
        own,
        given_up=given_up,
    )
    return SpanBySpan(steps, stop)


def _longest(run: Simulation, times: StepTimes) -> float:
    """The length (s) of the longest of a run's equal steps."""
    gaps = np.diff(times.edges)
    return float((gaps / step_counts(gaps, run.step)).max())


def _warn_unstable(run: Simulation, method: str, times: StepTimes, driving: Driving) -> None:
    """Warn where equal steps of an explicit method are too long for the motion at its start, or for
    the smooth friction of its joints where they come to rest."""
    model, lanes, reach = run.model, run.lanes, STEP_METHODS[method].reach
    function = any(
        callable(x) and not isinstance(x, CompiledTorque) for x in (run.torque, run.forces)
    )
    if model.loops or STEP_METHODS[method].implicit or (function and lanes.shape):
        return
    step = _longest(run, times)
    for k in sorted({0, lanes.count // 2, lanes.count - 1})[:_LOOKED_AT]:
        where, whole = at_sample(lanes.index(k)), lane_system(run, k)
        drive = lane_drive(run, k, driving)
        y = np.concatenate([some_of(lanes.each(x, 1), 1, k) for x in (run.q, run.qd)])
        rate = whole.fastest(run.t[0], y, drive)
        if rate * step > reach:
            warn(
                f"simulate: the motion{where} is stiff: a part of it changes within "
                f"{1.0 / rate:.1g} s, and {_stable(method, reach / rate, step)}. Take a shorter "
                f"step= or method 'implicit'.",
            )
            return
        rate = whole.fastest_at_rest(run.t[0], y, drive, run.width)
        if rate * step > reach:
            warn(
                f"simulate: smooth friction is stiff where joints of the motion{where} come to "
                f"rest: it acts there within {1.0 / rate:.1g} s, and "
                f"{_stable(method, reach / rate, step)}. A joint that comes to rest would not stay "
                f"so: take a shorter step=, a larger friction_width= or method 'implicit'.",
            )
            return


def _stable(method: str, longest: float, step: float) -> str:
    """A clause on steps (s) that are too long, and the length up to which they are stable."""
    told = 0.95 * longest  # so that its two digits are not above it
    return f"steps of {method!r} are stable up to {told:.2g} s; these are {step:.2g} s"


def _tell_stopped(
    run: Simulation,
    method: str,
    result: Simulated,
    given_up: dict[int, GivenUp],
    alike: bool,
) -> None:
    """Raise an error for a single motion that could not go on, warn about some of many; alike:
    whether all take the same steps."""
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
    lane = int(np.ravel_multi_index(index, run.lanes.shape)) if index else 0
    advice = why_sampled(run, lane) or too_late(run.t) or advice
    # those that Python calls at once step alike
    last = given_up.get(0 if alike else lane)
    if last is not None:
        advice = endless(run, last, lane)
    if not run.lanes.shape:
        raise SimulationStopped(f"simulate: {method} stopped after t = {at:.6g} s. {advice}")
    warn(
        f"simulate: {len(stopped)} of {run.lanes.count} motions could not go on and are NaN from "
        f"there, the first{at_sample(index)} after t = {at:.6g} s. {advice}",
    )


def _going(result: Simulated, at: tuple[Any, ...]) -> NDArray[np.bool_]:
    """Flags of the motions whose positions and rates at an index of the result are finite."""
    q, qd = (np.isfinite(x[at]).all(axis=-1) for x in (result.q, result.qd))
    return np.asarray(np.logical_and(q, qd))


@dataclass(eq=False)
class _LaneRun:
    """The run of all lanes, in blocks, through the times at which steps end.

    controller: of (t, q, qd) of all lanes, what the torque holds from each call to the next.
    growth: looks at the rates there; motions without hope are NaN from there.
    """

    motions: LaneMotions
    advance: Advance
    lanes: MotionLanes
    controller: TorqueLaw | None
    torque: LaneTorque | None
    growth: SampledGrowth | None
    threads: int | None
    tell: Callable[[float], None]
    stop: threading.Event
    """Set where an interrupt ends the steps; `advance` looks at it too."""

    def run(self) -> None:
        """Run all steps and fill in the result."""
        times, rows = self.motions.times, self.motions.rows
        starts = times.calls or (0,)
        ends = (*starts[1:], len(times.edges) - 1)
        threads = self.threads or cpus()
        size = min(self.advance.block, max(_FEWEST, ceil(rows / threads)))
        blocks = [slice(k, min(k + size, rows)) for k in range(0, rows, size)]
        threads = min(threads, len(blocks))
        self.motions.record(slice(0, rows), 0, self.motions.state)
        reached = np.zeros(len(blocks))
        with ThreadPoolExecutor(threads) as pool:
            for first, last in zip(starts, ends, strict=True):
                if self.controller is not None:
                    self._call(self.controller, first, last)
                todo = deque(enumerate(blocks))
                if threads > 1:
                    self._shared(pool, threads, todo, first, last, reached)
                for _ in self._section(todo, first, last, reached):
                    self.tell(float(reached.mean()))

    def _shared(
        self,
        pool: ThreadPoolExecutor,
        threads: int,
        todo: _Blocks,
        first: int,
        last: int,
        reached: Array,
    ) -> None:
        """Move blocks through a section by as many threads as the system starts, all of them where
        it starts one; an interrupt ends them soon."""

        def run() -> None:
            for _ in self._section(todo, first, last, reached):
                pass

        running = []
        with contextlib.suppress(RuntimeError):  # no more threads; in a browser there is no other
            for _ in range(threads):
                running.append(pool.submit(run))
        try:
            # in slices of time: an interrupt may have come to another thread
            while wait(running, timeout=_LOOK).not_done:
                self.tell(float(reached.mean()))
        except BaseException:
            self.stop.set()
            raise
        for future in running:
            future.result()

    def _section(self, todo: _Blocks, first: int, last: int, reached: Array) -> Iterator[None]:
        """Move blocks that no thread has taken from one edge to another, with pauses in between;
        reached: the fraction of the whole time that each block has behind it."""
        begin, end = self.motions.times.edges[[0, -1]]
        while not self.stop.is_set():
            try:
                at, block = todo.popleft()
            except IndexError:
                return
            for now in self.advance(self.motions, block, first, last):
                reached[at] = (now - begin) / (end - begin)
                yield

    def _call(self, controller: TorqueLaw, first: int, last: int) -> None:
        """Call the controller at an edge; its torque is recorded until the next call, at the very
        end that of the call before."""
        assert isinstance(self.torque, HeldTorque)
        if self.growth is not None and self.motions.rows == self.lanes.count:
            lost = self.growth.hopeless(self.motions.state[1])
            for x in self.motions.state:
                x[lost] = np.nan
        q, qd = (x.reshape(*self.lanes.shape, -1) for x in self.motions.state)
        times, result = self.motions.times, self.motions.result
        now = np.asarray(times.edges[first])
        self.torque.tau[:] = self.lanes.all(controller(now, q, qd), 1)
        if result.tau is not None:
            every = result.tau.reshape(self.lanes.count, *result.tau.shape[-2:])
            rows = times.rows[first : last + (last == len(times.edges) - 1)]
            every[:, rows[rows >= 0]] = self.torque.tau[:, None]
