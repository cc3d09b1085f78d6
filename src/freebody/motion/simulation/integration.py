"""Integration of a system, from one end of its torque's smooth pieces to the next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import BDF, DOP853, LSODA, RK45, OdeSolver, Radau

from freebody.arrays import Array
from freebody.motion.simulation.first_order_system import Drive, System
from freebody.motion.simulation.interrupted import SimulationStopped
from freebody.motion.simulation.stiffness_watch import StiffnessWatch
from freebody.motion.simulation.torques import Schedule

METHODS: dict[str, type[OdeSolver]] = {
    "DOP853": DOP853,
    "RK45": RK45,
    "Radau": Radau,
    "BDF": BDF,
    "LSODA": LSODA,
}
IMPLICIT = ("Radau", "BDF", "LSODA")
_DAMPING = ("Radau", "BDF")  # what they are chosen for damps their errors
# a robot's errors grow on the way, tenfold and more in a second; other steps are as much finer
_FEWER = 100.0
FINEST = 2.3e-14
"""The finest tolerance of a step that rounding leaves any meaning."""


def step_tolerance(method: str, tolerance: float) -> float:
    """Relative error of a step for a motion that is to land within about `tolerance`."""
    return tolerance if method in _DAMPING else max(tolerance / _FEWER, FINEST)


@dataclass(frozen=True, eq=False)
class Scheme:
    """How the states of a system move on: its rate under a torque, and what becomes of a state that
    was reached."""

    rate: Callable[[Drive], Callable[[float, Array], Array]]
    settled: Callable[[Array], Array]
    settings: dict[str, Any]
    """Of scipy's solver: tolerances, the largest step."""
    require: Callable[[Drive, float, Array], None]
    """Refuses a start (torque, time, state) from which no motion leads on."""
    every_step: bool
    """Whether each step is settled before the next, not the ends of the pieces alone."""
    stopped: str
    """What a run that cannot go on may have met, as a sentence."""


def open_scheme(system: System, tolerance: float, max_step: float) -> Scheme:
    """Of a tree, tolerance being that of a step: quaternions are brought back to unit length."""

    def rate(drive: Drive) -> Callable[[float, Array], Array]:
        return lambda now, y: system.rate(
            np.asarray(now), y, drive(np.asarray(now), *system.split(y))
        )

    settings = {"rtol": tolerance, "atol": tolerance / 100, "max_step": max_step}
    reason = (
        "The motion may diverge or pass a state without finite acceleration; shorten the time, or "
        "check torques and masses."
    )
    return Scheme(rate, system.normalised, settings, lambda drive, t, y: None, False, reason)


def integrated(
    system: System,
    scheme: Scheme,
    schedule: Schedule,
    t: Array,
    y0: Array,
    method: str,
    watch: StiffnessWatch,
    states: list[Array],
    tell: Callable[[float], None],
    passed: Callable[[float, float, Array], None],
) -> None:
    """Put the states (nq + nv,) at the times t (T,) into a list as they are reached, the first of
    them y0. tell: of the part that is done. passed: told of each step its two times and the state
    that it led to.

    The solver begins anew at each edge of the schedule, with the step that it had reached, and
    where the watch has found another method.
    """
    states.append(y0)
    y = y0
    first: float | None = None
    for k, (start, end) in enumerate(pairwise(schedule.edges)):
        drive = schedule.begin(k, *system.split(y))
        if k == 0:
            scheme.require(drive, start, y)
        method = watch.method or method
        solver = _solver(system, scheme, drive, method, start, y, end, first)
        while solver.status == "running":
            before = solver.t
            message = solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                _refuse(scheme, method, before, message)
            passed(before, solver.t, solver.y)
            states += _reached(solver, scheme, t[(t > before) & (t <= solver.t)])
            tell((solver.t - t[0]) / (t[-1] - t[0]))
            if watch.steps(method):
                watch.look(drive, before, solver.t, solver.y)
            if solver.status == "running" and watch.method not in ("", method):
                method, y = watch.method, solver.y
                solver = _solver(system, scheme, drive, method, solver.t, y, end, None)
        y, first = solver.y, getattr(solver, "h_abs", solver.step_size)


def _reached(solver: OdeSolver, scheme: Scheme, due: Array) -> list[Array]:
    """The states at times of the last step; where it is settled, the solver goes on from there."""
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


def _solver(
    system: System,
    scheme: Scheme,
    drive: Drive,
    method: str,
    start: float,
    y: Array,
    end: float,
    first: float | None,
) -> OdeSolver:
    extra: dict[str, Any] = {}
    if first is not None:
        extra["first_step"] = min(first, end - start, scheme.settings["max_step"])
    if method in IMPLICIT:
        extra["jac"] = lambda now, y: system.jacobian_under(np.asarray(now), y, drive)
    solver = METHODS[method](scheme.rate(drive), start, y, end, **scheme.settings, **extra)
    if np.isnan(getattr(solver, "h_abs", 0.0)):  # a rate of NaN; scipy would step by it for ever
        _refuse(scheme, method, start, None)
    return solver


def _refuse(scheme: Scheme, method: str, before: float, message: str | None) -> None:
    told = f" ({message.rstrip('.')})" if message else ""
    raise SimulationStopped(
        f"simulate: {method} stopped after t = {before:.6g} s{told}. {scheme.stopped}"
    )
