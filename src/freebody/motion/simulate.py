"""`simulate`: the motion that torques cause."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError, UnknownNameError
from freebody.loops.equations import gaps, require_closed, scaled_rate, scaled_residual
from freebody.model.model import Model
from freebody.motion.closed_chain_integration import EXPLICIT, closed_chain_scheme
from freebody.motion.first_order_system import System, constant_loads, suited_method, system
from freebody.motion.friction import WIDTH
from freebody.motion.integration import METHODS, integrated, open_scheme, step_tolerance
from freebody.motion.ranges import angular
from freebody.motion.stiffness_watch import StiffnessWatch
from freebody.motion.torques import Schedule, Torque, schedule
from freebody.trees import dynamics
from freebody.trees.public_calls import Vector, Wrenches, vector, wrenches_by_frame

if TYPE_CHECKING:
    import xarray as xr


def simulate(
    model: Model,
    q: Vector,
    qd: Vector,
    t: ArrayLike,
    torque: Torque = None,
    wrenches: Wrenches = None,
    method: str = "auto",
    *,
    tolerance: float = 1e-10,
    friction_width: float = WIDTH,
    max_step: float = np.inf,
    breakpoints: ArrayLike = (),
    sample_time: float | None = None,
) -> xr.Dataset:
    """The motion over the times t (T,) from the state q (nq,), qd (nv,) at t[0].

    torque: of the drives (N m, N): None for none; (nv,) constant; (T, nv) at the times t, linear
    between them, integrated from row to row; or a function f(t, q, qd) -> (nv,). A function must be
    smooth except at its `breakpoints` (s), where the integration restarts, so that no jump or kink
    is stepped over; max_step (s) bounds the steps elsewhere. With sample_time (s) the function
    is a controller: called once at t[0], t[0] + sample_time, …, with the state there, its torque
    held until the next. wrenches: constant, as for `inverse_dynamics`. method: one of scipy's
    integrators; "auto" takes DOP853, or an implicit method where the motion is stiff, that is where
    a part of it dies away a thousand times within the duration: Radau if friction does that, LSODA
    if the torque function does, from the start or from where the steps of DOP853 show it. An
    explicit method asked for by name warns there. tolerance: how near the end is to be, relative to
    the motion: the relative error of a step is a hundredth of it (of Radau and BDF, which damp
    errors, as much), the absolute one a hundredth of that. friction_width: Coulomb friction acts as
    c tanh(q̇ / width), rad/s or m/s, so that a joint at rest creeps instead of sticking.

    Closed chains: the state must satisfy the loops; explicit methods only, each step projected back
    onto the loops (positions and rates), so that there is no drift; loop_gap (m) and loop_rate
    (m/s) are part of the result.

    Returns a dataset over `time` with q, qd, qdd, tau, energies and powers, units as attributes;
    what was used stands in its attributes. Raises SingularError for joints without inertia,
    PassiveJointError for a torque at a joint that nothing drives, FreebodyError when the
    integration cannot go on.
    """
    times = _times(t)
    start = vector("simulate", model, "q", q), vector("simulate", model, "qd", qd)
    for name, value, size in (("q", start[0], model.nq), ("qd", start[1], model.nv)):
        if value.shape != (size,):
            raise ShapeError(
                "simulate", name, value.shape, f"({size},)", "one state is simulated at a time"
            )
        refuse_not_finite("simulate", name, value, 1)
    known, of = (EXPLICIT, "simulate of a closed chain") if model.loops else (METHODS, "simulate")
    if method != "auto" and method not in known:
        raise UnknownNameError("method", method, of, ("auto", *known))
    if not tolerance > 0.0:
        raise FreebodyError(f"simulate: tolerance is {tolerance:g}, expected more than 0.")
    if not max_step > 0.0:
        raise FreebodyError(f"simulate: max_step is {max_step:g}, expected seconds above 0.")
    frames, loads = constant_loads(_wrenches(model, wrenches))
    whole = system(model, friction_width, frames, loads)
    planned = schedule(model, times, torque, breakpoints, sample_time)
    state, duration = np.concatenate(start), float(times[-1] - times[0])

    def decay() -> float:
        if not planned.feedback:
            return 0.0
        return whole.fastest_decay(times[0], state, planned.begin(0, *start))

    if model.loops:
        require_closed("simulate", model, *start)
        chosen = "DOP853" if method == "auto" else method
        # near a singular position accelerations are known to ten digits, and finer steps would
        # chase their rounding
        scheme = closed_chain_scheme(whole, tolerance, max_step)
    else:
        chosen = method
        if method == "auto":
            chosen = suited_method(whole, start[0], duration, decay)
        scheme = open_scheme(whole, step_tolerance(chosen, tolerance), max_step)
    watch = StiffnessWatch(whole, duration, switches=method == "auto", done=bool(model.loops))
    y = integrated(whole, scheme, planned, times, state, chosen, watch)
    used = f"{chosen}, {watch.method} from {watch.since:.6g} s" if watch.method else chosen
    return _dataset(whole, times, y, planned, used, tolerance)


def _times(t: ArrayLike) -> Array:
    times = as_floats("simulate", "t", t)
    if times.ndim != 1 or len(times) < 2:
        raise FreebodyError(f"simulate: t has shape {times.shape}, expected at least two times.")
    refuse_not_finite("simulate", "t", times, 0)
    if (np.diff(times) <= 0).any():
        raise FreebodyError("simulate: the times t must increase.")
    return times


def _wrenches(model: Model, wrenches: Wrenches) -> dict[str, Array]:
    found = wrenches_by_frame("simulate", model, wrenches, single=True)
    for name, wrench in found.items():
        refuse_not_finite("simulate", f"wrenches[{name!r}]", wrench, 1)
    return found


def _dataset(
    system: System, t: Array, y: Array, planned: Schedule, method: str, tolerance: float
) -> xr.Dataset:
    import xarray as xr

    model = system.model
    q, qd = system.split(y)
    tau = np.stack(
        [planned.given(now, *state) for now, state in zip(t, zip(q, qd, strict=True), strict=True)]
    )
    qdd = system.acceleration(t, q, qd, tau)
    turns = angular(model)
    at = ("time", "coordinate")
    variables = {
        "q": (("time", "position"), q, "rad|m|1", "position"),
        "qd": (at, qd, "rad/s|m/s", "rate"),
        "qdd": (at, qdd, "rad/s²|m/s²", "acceleration"),
        "tau": (at, tau, "N m|N", "torque or force of the drive"),
        "kinetic_energy": (
            ("time",),
            dynamics.kinetic_energy(model, q, qd),
            "J",
            "kinetic energy, rotors included",
        ),
        "potential_energy": (
            ("time",),
            dynamics.potential_energy(model, q),
            "J",
            "of gravity and springs",
        ),
        "power": (at, tau * qd, "W", "mechanical power of the drive"),
    }
    if model.loops:
        for name, value, unit, text in (
            ("loop_gap", scaled_residual(model, q), "m", "how far each loop is open"),
            ("loop_rate", scaled_rate(model, q, qd), "m/s", "how fast each loop opens"),
        ):
            variables[name] = (("time", "loop"), gaps(model, value), unit, text)
    friction = system.friction
    return xr.Dataset(
        {
            name: (d, v, {"units": u, "long_name": text})
            for name, (d, v, u, text) in variables.items()
        },
        {
            "time": ("time", t, {"units": "s", "long_name": "time"}),
            "position": list(model.position_names),
            "coordinate": list(model.velocity_names),
            "unit": ("coordinate", np.where(turns, "rad", "m")),
            "effort_unit": ("coordinate", np.where(turns, "N m", "N")),
            **({"loop": [loop.name for loop in model.loops]} if model.loops else {}),
        },
        {
            "robot": model.name,
            "method": method,
            "tolerance": tolerance,
            "coulomb_friction": f"c tanh(q̇ / {friction.width:g})" if friction.acts else "none",
            "friction_width": friction.width,
        },
    )
