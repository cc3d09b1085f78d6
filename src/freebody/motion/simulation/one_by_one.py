"""The motion of one state, or of several one after another, by scipy's integrators, which choose
their steps by the error; its torque comes in pieces between which it jumps or bends, so that an
integrator meets neither within a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import OdeSolver

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.loops.closure_checks import require_closed
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.simulation.first_order_system import (
    IMPLICIT,
    METHODS,
    Scheme,
    System,
    TorqueLaw,
    closed_chain_scheme,
    loads_over,
    open_scheme,
    step_tolerance,
    suited_method,
    system,
)
from freebody.motion.simulation.prepared_simulation import (
    SAME,
    CompiledTorque,
    MotionLanes,
    Simulation,
    TorqueInput,
    function_of,
    instants,
    merged,
    one_lane,
    some_of,
)
from freebody.motion.simulation.results import Simulated, SimulationStopped
from freebody.motion.simulation.stiffness import LongRun, StiffnessWatch
from freebody.motion.simulation.unending import stopping_endless, too_late, unless_hopeless
from freebody.trees.special_joints import all_driven


def one_by_one(run: Simulation, method: str, result: Simulated) -> None:
    """Fill in the motions of one state, or of many states one after another, whose torque is a
    table or compiled."""
    if not run.lanes.shape:
        _one(run, method, result)
        return
    for name, given in (("torque", run.torque), ("forces", run.forces)):
        if callable(given) and not isinstance(given, CompiledTorque):
            raise FreebodyError(
                f"simulate: {method} integrates one state after another, and a function of "
                f"{name} is called with all of them: take method 'auto', 'rk4' or "
                f"'semi-implicit', or compile it with fb.compile."
            )
    lanes, (q, qd) = run.lanes, (run.q, run.qd)
    q, qd = lanes.all(q, 1), lanes.all(qd, 1)
    result.tau = np.full(result.qd.shape, np.nan)
    filled, torques = (
        [x.reshape(lanes.count, *x.shape[-2:]) for x in some]
        for some in ((result.q, result.qd), (result.tau,))
    )
    warned = False
    for k in range(lanes.count):
        index = lanes.index(k)
        own = replace(
            run,
            model=member_at(run.model, index),
            q=q[k],
            qd=qd[k],
            torque=_of_lane(run, k, run.torque),
            forces=None if run.forces is None else _of_lane(run, k, run.forces),
            wrenches={n: some_of(lanes.each(w, 2), 2, k) for n, w in run.wrenches.items()},
            lanes=MotionLanes(()),
            tell=lambda done, k=k: run.tell((k + done) / lanes.count),
        )
        part = Simulated(result.t, filled[0][k], filled[1][k], result.used)
        warned = _one(own, method, part, warned)
        torques[0][k] = part.torques()


def _of_lane(run: Simulation, k: int, given: Any) -> Any:
    """The torque or forces of one motion of a batch."""
    if isinstance(given, CompiledTorque):
        return one_lane(given, run.lanes, k)
    return some_of(run.lanes.each(given, 2), 2, k)


def _one(run: Simulation, method: str, result: Simulated, warned: bool = False) -> bool:
    """Fill in the motion of one state with error control; method: "auto" or one of scipy's.

    warned: whether it has been said that motions are stiff. Returns whether it has by now.
    """
    model, t = run.model, run.t
    whole = system(model, run.width, *loads_over(t, run.wrenches))
    planned, acting = _planned(run)
    if model.loops:
        require_closed("simulate", model, run.q, run.qd)
    chosen, scheme = _scheme(run, method, whole, acting)
    scheme = replace(scheme, stopped=too_late(t) or scheme.stopped)
    if run.sample_time is not None:
        planned = replace(planned, begin=unless_hopeless(run, planned.edges, planned.begin))
    watch = StiffnessWatch(
        whole, run.duration, switches=method == "auto", done=bool(model.loops) or warned
    )
    state, states = np.concatenate([run.q, run.qd]), list[Array]()
    result.given = planned.given
    try:
        passed = stopping_endless(run, whole)
        motion = _OneMotion(run, whole, scheme, planned, watch, passed, states)
        motion.integrate(state, chosen)
    finally:
        kept = np.array(states[:: run.every])
        result.q[: len(kept)], result.qd[: len(kept)] = whole.split(kept)
    used = f"{chosen}, {watch.method} from {watch.since:.6g} s" if watch.method else chosen
    result.used["method"] = used
    return warned or watch.since > run.t[0]


def _planned(run: Simulation) -> tuple[Schedule, list[Schedule]]:
    """The schedule of everything that acts on one motion, and the schedules of torque and forces
    alone."""
    model, t = run.model, run.t
    planned = schedule(model, t, run.torque, run.breakpoints, run.sample_time)
    acting = [planned]
    if run.forces is not None:
        driven = all_driven(model)
        acting.append(schedule(driven, t, run.forces, run.breakpoints, name="forces"))
        planned = along_with(*acting)
    if any(w.shape[-2] > 1 for w in run.wrenches.values()):
        planned = with_edges(planned, t)
    return planned, acting


def _scheme(
    run: Simulation, method: str, whole: System, acting: list[Schedule]
) -> tuple[str, Scheme]:
    """The integrator for one motion, with "auto" replaced, and its integration scheme."""
    if run.model.loops:
        # near a singular position accelerations are known to ten digits, and finer steps would
        # chase their rounding
        scheme = closed_chain_scheme(whole, run.tolerance, run.max_step)
        return "DOP853" if method == "auto" else method, scheme

    def decay() -> float:
        drives = [x.begin(0, run.q, run.qd) for x in acting if x.feedback]
        if not drives:
            return 0.0
        state = np.concatenate([run.q, run.qd])
        return whole.fastest_decay(
            run.t[0], state, lambda *at: np.sum([drive(*at) for drive in drives], axis=0)
        )

    chosen = suited_method(whole, run.q, run.duration, decay) if method == "auto" else method
    return chosen, open_scheme(whole, step_tolerance(chosen, run.tolerance), run.max_step)


@dataclass(eq=False)
class _OneMotion:
    """One motion on its way: what moves it, how it is stepped and watched, and its states so far.

    passed: called at each step with its two times and the state behind it.
    """

    run: Simulation
    system: System
    scheme: Scheme
    schedule: Schedule
    watch: StiffnessWatch
    passed: Callable[[float, float, Array], None]
    states: list[Array]
    """The states (nq + nv,) at the times of the run, as they are reached."""

    def integrate(self, y: Array, method: str) -> None:
        """Find the states, the first of them y.

        The solver begins anew at each edge of the schedule, with the step that it had reached, and
        where the watch has found another method.
        """
        t, watch, pace = self.run.t, self.watch, LongRun(self.run)
        self.states.append(y)
        first: float | None = None
        for k, (start, end) in enumerate(pairwise(self.schedule.edges)):
            drive = self.schedule.begin(k, *self.system.split(y))
            if k == 0:
                self.scheme.require(drive, start, y)
            method = watch.method or method
            solver = self._solver(drive, method, (start, end), y, first)
            while solver.status == "running":
                before = solver.t
                message = solver.step()
                if solver.status == "failed" or not np.isfinite(solver.y).all():
                    _refuse(self.scheme, method, before, message)
                self.passed(before, solver.t, solver.y)
                pace.step(solver.t)
                self.states += _reached(solver, self.scheme, t[(t > before) & (t <= solver.t)])
                self.run.tell((solver.t - t[0]) / (t[-1] - t[0]))
                if watch.steps(method):
                    watch.look(drive, before, solver.t, solver.y)
                if solver.status == "running" and watch.method not in ("", method):
                    method, y = watch.method, solver.y
                    solver = self._solver(drive, method, (solver.t, end), y, None)
            y, first = solver.y, getattr(solver, "h_abs", solver.step_size)

    def _solver(
        self,
        drive: TorqueLaw,
        method: str,
        span: tuple[float, float],
        y: Array,
        first: float | None,
    ) -> OdeSolver:
        """The integrator over a span of time, from the state y, with a first step."""
        (start, end), settings = span, self.scheme.settings
        extra: dict[str, Any] = {}
        if first is not None:
            extra["first_step"] = min(first, end - start, settings["max_step"])
        if method in IMPLICIT:
            extra["jac"] = lambda now, y: self.system.jacobian_under(np.asarray(now), y, drive)
        solver = METHODS[method](self.scheme.rate(drive), start, y, end, **settings, **extra)
        if np.isnan(
            getattr(solver, "h_abs", 0.0)
        ):  # a rate of NaN; scipy would step by it for ever
            _refuse(self.scheme, method, start, None)
        return solver


def _reached(solver: OdeSolver, scheme: Scheme, due: Array) -> list[Array]:
    """The states at the due times within the solver's last step; where states are corrected after
    each step, the solver goes on from the corrected one."""
    inside = due[due < solver.t]
    found: list[Array] = []
    if len(inside):
        found += [scheme.settled(state) for state in solver.dense_output()(inside).T]
    if scheme.every_step or solver.status == "finished":
        solver.y = scheme.settled(solver.y)
    if len(due) > len(inside):
        found.append(scheme.settled(solver.y))
    if scheme.every_step and solver.status == "running":
        # Runge-Kutta methods go on from f, which their base class does not have
        solver.f = solver.fun(solver.t, solver.y)  # type: ignore[attr-defined]
    return found


def _refuse(scheme: Scheme, method: str, before: float, message: str | None) -> None:
    reason = f" ({message.rstrip('.')})" if message else ""
    raise SimulationStopped(
        f"simulate: {method} stopped after t = {before:.6g} s{reason}. {scheme.stopped}"
    )


# ---------------------------------------------------------------- torques in pieces
@dataclass(frozen=True, eq=False)
class Schedule:
    """A torque over time in pieces, so that an integrator never steps across a jump or bend."""

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
    """The schedule of the torque of one motion; t (T,): its times; name: of the argument."""
    ends = t[[0, -1]]
    if isinstance(torque, np.ndarray):
        if len(torque) > 1:
            return _of_table(t, torque)
        (row,) = torque
        return Schedule(ends, lambda k, q, qd: lambda now, q, qd: row, lambda now, q, qd: row)
    function = function_of(model, torque, (), name)
    if sample_time is None:
        inside = breakpoints[(breakpoints > t[0]) & (breakpoints < t[-1])]
        return _of_function(function, np.concatenate([ends, inside]))
    return _sampled(function, instants(float(t[0]), float(t[-1]), sample_time), sample_time, t[-1])


def with_edges(plan: Schedule, times: Array) -> Schedule:
    """The schedule in pieces that also end at the given times."""
    edges = merged(plan.edges, times, SAME * np.diff(plan.edges).min())
    return replace(plan, edges=edges, begin=_begin_within(plan, edges))


def along_with(plan: Schedule, other: Schedule) -> Schedule:
    """The schedule of the sum of two torques; `given` is that of the first."""
    near = SAME * min(np.diff(plan.edges).min(), np.diff(other.edges).min())
    edges = merged(plan.edges, other.edges, near)
    own, more = (_begin_within(x, edges) for x in (plan, other))

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        one, two = own(k, q, qd), more(k, q, qd)
        return lambda now, q, qd: one(now, q, qd) + two(now, q, qd)

    return Schedule(edges, begin, plan.given, plan.feedback or other.feedback)


def _begin_within(plan: Schedule, edges: Array) -> Callable[[int, Array, Array], TorqueLaw]:
    """The function `begin` of a schedule for pieces between other edges, which include the
    schedule's own."""
    piece = np.searchsorted(plan.edges, 0.5 * (edges[:-1] + edges[1:]), side="right") - 1
    drives: list[TorqueLaw] = []

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        if k == 0 or piece[k] != piece[k - 1]:
            drives[:] = [plan.begin(int(piece[k]), q, qd)]
        return drives[0]

    return begin


def _of_table(t: Array, table: Array) -> Schedule:
    """The schedule of a table of torques, linear between its rows."""
    slopes = np.diff(table, axis=0) / np.diff(t)[:, None]

    def line(k: int) -> TorqueLaw:
        return lambda now, q, qd: table[k] + (now - t[k]) * slopes[k]

    def given(now: Array, q: Array, qd: Array) -> Array:
        return table[np.searchsorted(t, now)]  # asked for at the rows' times alone

    return Schedule(t, lambda k, q, qd: line(k), given)


def _of_function(function: TorqueLaw, edges: Array) -> Schedule:
    """The schedule of a function that is smooth between the edges, and whose value at an edge may
    belong to either side."""
    edges = np.unique(edges)
    first, last = edges[:-1].copy(), edges[1:].copy()
    first[1:], last[:-1] = np.nextafter(first[1:], np.inf), np.nextafter(last[:-1], -np.inf)

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        if len(first) == 1:
            return function
        return lambda now, q, qd: function(np.clip(now, first[k], last[k]), q, qd)

    return Schedule(edges, begin, function, feedback=True)


def _sampled(function: TorqueLaw, instants: Array, sample_time: float, end: float) -> Schedule:
    """The schedule of a function that is called at every sampling instant with the state there, and
    whose value is held until the next."""
    held: list[Array] = []

    def begin(k: int, q: Array, qd: Array) -> TorqueLaw:
        value = function(instants[k], q, qd)
        held.append(value)
        return lambda now, q, qd: value

    def given(now: Array, q: Array, qd: Array) -> Array:
        last = int(np.searchsorted(instants, now + SAME * sample_time, side="right")) - 1
        return held[min(last, len(held) - 1)]  # a run that was interrupted has fewer

    return Schedule(np.append(instants, end), begin, given)
