"""The motion of one state, or of several one after another, by scipy's integrators."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.loops.equations import require_closed
from freebody.model.families import member_at
from freebody.motion.simulation.closed_chain_integration import closed_chain_scheme
from freebody.motion.simulation.compiled_torque import CompiledTorque, one_lane
from freebody.motion.simulation.first_order_system import Drive, loads_over, suited_method, system
from freebody.motion.simulation.integration import integrated, open_scheme, step_tolerance
from freebody.motion.simulation.interrupted import SimulationStopped
from freebody.motion.simulation.motion_lanes import MotionLanes, some_of
from freebody.motion.simulation.simulation import Simulated, Simulation
from freebody.motion.simulation.stiffness_watch import StiffnessWatch
from freebody.motion.simulation.torques import Schedule, along_with, schedule, with_edges
from freebody.motion.simulation.unending import (
    GivenUp,
    Growth,
    RunPace,
    SampledGrowth,
    endless,
    hopeless,
    too_late,
)
from freebody.trees.special_joints import all_driven


def alone(asked: Simulation, method: str, result: Simulated, told: bool = False) -> bool:
    """Fill in the motion of one state with error control; method: "auto" or one of scipy's.

    told: whether it has been said that motions are stiff. Returns whether it has by now.
    """
    model, t = asked.model, asked.t
    whole = system(model, asked.width, *loads_over(t, asked.wrenches))
    planned = schedule(model, t, asked.torque, asked.breakpoints, asked.sample_time)
    plans = [planned]
    if asked.forces is not None:
        driven = all_driven(model)
        plans.append(schedule(driven, t, asked.forces, asked.breakpoints, name="forces"))
        planned = along_with(*plans)
    if any(w.shape[-2] > 1 for w in asked.wrenches.values()):
        planned = with_edges(planned, t)
    state = np.concatenate([asked.q, asked.qd])

    def decay() -> float:
        drives = [x.begin(0, asked.q, asked.qd) for x in plans if x.feedback]
        if not drives:
            return 0.0
        return whole.fastest_decay(
            t[0], state, lambda *at: np.sum([drive(*at) for drive in drives], axis=0)
        )

    if model.loops:
        require_closed("simulate", model, asked.q, asked.qd)
        chosen = "DOP853" if method == "auto" else method
        # near a singular position accelerations are known to ten digits, and finer steps would
        # chase their rounding
        scheme = closed_chain_scheme(whole, asked.tolerance, asked.max_step)
    else:
        chosen = method
        if method == "auto":
            chosen = suited_method(whole, asked.q, asked.duration, decay)
        scheme = open_scheme(whole, step_tolerance(chosen, asked.tolerance), asked.max_step)
    if asked.sample_time is not None:
        planned = _growing(asked, planned)
    pace, growth, only = RunPace(float(t[-1])), Growth(1, float(t[-1])), np.zeros(1, dtype=int)

    def passed(before: float, now: float, y: Array) -> None:
        qd = whole.split(y)[1]
        doubling = float(growth.hopeless(only, np.array([now]), qd[None])[0])
        if pace.endless(before, now) or np.isfinite(doubling):
            told = endless(asked, GivenUp(before, now, qd, doubling))
            raise SimulationStopped(f"simulate: {told}")

    scheme = replace(scheme, stopped=too_late(t) or scheme.stopped)

    watch = StiffnessWatch(
        whole, asked.duration, switches=method == "auto", done=bool(model.loops) or told
    )
    states: list[Array] = []

    result.given = planned.given
    try:
        integrated(whole, scheme, planned, t, state, chosen, watch, states, asked.tell, passed)
    finally:
        kept = np.array(states[:: asked.every])
        result.q[: len(kept)], result.qd[: len(kept)] = whole.split(kept)
    used = f"{chosen}, {watch.method} from {watch.since:.6g} s" if watch.method else chosen
    result.used["method"] = used
    return told or watch.since > asked.t[0]


def _growing(asked: Simulation, plan: Schedule) -> Schedule:
    """The same schedule of a sampled torque, given up where the motion grows without hope."""
    growth = SampledGrowth(len(plan.edges) - 1)

    def begin(k: int, q: Array, qd: Array) -> Drive:
        if growth.hopeless(qd[None])[0]:
            raise SimulationStopped(hopeless(asked, float(plan.edges[k]), qd))
        return plan.begin(k, q, qd)

    return replace(plan, begin=begin)


def one_by_one(asked: Simulation, method: str, result: Simulated) -> None:
    """The same of many states, whose torque is a table or compiled."""
    if not asked.lanes.shape:
        alone(asked, method, result)
        return
    for name, given in (("torque", asked.torque), ("forces", asked.forces)):
        if callable(given) and not isinstance(given, CompiledTorque):
            raise FreebodyError(
                f"simulate: {method} integrates one state after another, and a function of "
                f"{name} is called with all of them: take method 'auto', 'rk4' or "
                f"'semi-implicit', or compile it with fb.compile."
            )
    lanes, (q, qd) = asked.lanes, (asked.q, asked.qd)
    q, qd = lanes.all(q, 1), lanes.all(qd, 1)
    result.tau = np.full(result.qd.shape, np.nan)
    filled, torques = (
        [x.reshape(lanes.count, *x.shape[-2:]) for x in some]
        for some in ((result.q, result.qd), (result.tau,))
    )
    told = False
    for k in range(lanes.count):
        index = lanes.index(k)
        own = replace(
            asked,
            model=member_at(asked.model, index),
            q=q[k],
            qd=qd[k],
            torque=_of_lane(asked, k, asked.torque),
            forces=None if asked.forces is None else _of_lane(asked, k, asked.forces),
            wrenches={n: some_of(lanes.each(w, 2), 2, k) for n, w in asked.wrenches.items()},
            lanes=MotionLanes(()),
            tell=lambda done, k=k: asked.tell((k + done) / lanes.count),
        )
        part = Simulated(result.t, filled[0][k], filled[1][k], result.used)
        told = alone(own, method, part, told)
        torques[0][k] = part.torques()


def _of_lane(asked: Simulation, k: int, given: Any) -> Any:
    """The torque or forces of one lane."""
    if isinstance(given, CompiledTorque):
        return one_lane(given, asked.lanes, k)
    return some_of(asked.lanes.each(given, 2), 2, k)
