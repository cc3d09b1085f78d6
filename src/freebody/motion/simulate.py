"""`simulate`: the motion that torques cause."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from freebody.arrays import Array, as_floats, check_core, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError, UnknownNameError
from freebody.model.model import Model
from freebody.motion.closed import integrated_closed
from freebody.motion.friction import WIDTH
from freebody.motion.ranges import angular
from freebody.motion.system import Drive, System, constant_loads, suited_method, system
from freebody.numerics import dynamics
from freebody.numerics.calls import Vector, Wrenches, vector
from freebody.numerics.closed.equations import gaps, rate_of_loops, require_closed, residual
from freebody.numerics.passive import refuse_passive

if TYPE_CHECKING:
    import xarray as xr

METHODS = ("auto", "DOP853", "RK45", "Radau", "BDF", "LSODA")
Torque = ArrayLike | Callable[[float, Array, Array], ArrayLike] | None


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
) -> xr.Dataset:
    """The motion over the times t (T,) from the state q (nq,), qd (nv,) at t[0].

    torque: of the drives (N m, N): None for none; (nv,) constant; (T, nv) at the times t, straight lines between them;
    or a function f(t, q, qd) -> (nv,). wrenches: constant, as for `inverse_dynamics`. method: one of scipy's
    integrators; "auto" takes DOP853, or Radau (implicit) where friction makes the system stiff: where M⁻¹ times the
    slope of the friction has an eigenvalue above 1000 over the duration. tolerance: relative error per step; absolute a
    hundredth of it. friction_width: Coulomb friction acts as c tanh(q̇ / width), rad/s or m/s, so that a joint at rest
    creeps instead of sticking.

    Closed chains: the state must satisfy the loops; explicit methods only, each step projected back onto the loops
    (positions and rates), so that there is no drift; loop_gap (m) and loop_rate (m/s) are part of the result.

    Returns a dataset over `time` with q, qd, qdd, tau, energies and powers, units as attributes; what was used stands
    in its attributes. Raises SingularError for joints without inertia, PassiveJointError for a torque at a joint that
    nothing drives, FreebodyError when the integration cannot go on.
    """
    times = _times(t)
    start = vector("simulate", model, "q", q), vector("simulate", model, "qd", qd)
    for name, value, size in (("q", start[0], model.nq), ("qd", start[1], model.nv)):
        if value.shape != (size,):
            raise ShapeError("simulate", name, value.shape, f"({size},)", "one state is simulated at a time")
        refuse_not_finite("simulate", name, value, 1)
    if method not in METHODS:
        raise UnknownNameError("method", method, "simulate", METHODS)
    if not tolerance > 0.0:
        raise FreebodyError(f"simulate: tolerance is {tolerance:g}, expected more than 0.")
    frames, loads = constant_loads(_wrenches(model, wrenches))
    whole = system(model, friction_width, frames, loads)
    drive = _drive(model, times, torque)
    if model.loops:
        require_closed("simulate", model, *start)
        y = integrated_closed(whole, drive, times, np.concatenate(start), method, tolerance)
        return _dataset(whole, times, y, drive, "DOP853" if method == "auto" else method, tolerance)
    if method == "auto":
        method = suited_method(model, whole.friction, start[0], float(times[-1] - times[0]))
    y = integrated(whole, drive, times, np.concatenate(start), method, tolerance)
    return _dataset(whole, times, y, drive, method, tolerance)


def integrated(system: System, drive: Drive, t: Array, y0: Array, method: str, tolerance: float) -> Array:
    """States (T, nq + nv) at the times t."""

    def rate(now: float, y: Array) -> Array:
        return system.rate(np.asarray(now), y, drive(np.asarray(now), *system.split(y)))

    def slope(now: float, y: Array) -> Array:
        return system.jacobian(np.asarray(now), y, drive(np.asarray(now), *system.split(y)))

    implicit: dict[str, Any] = {"jac": slope} if method in ("Radau", "BDF", "LSODA") else {}
    found = solve_ivp(
        rate, (t[0], t[-1]), y0, method=method, t_eval=t, rtol=tolerance, atol=tolerance / 100, **implicit
    )
    if not found.success:
        reached = found.t[-1] if len(found.t) else t[0]
        raise FreebodyError(
            f"simulate: {method} stopped after t = {reached:.6g} s ({found.message.rstrip('.')}). The motion may run "
            "away or pass a state without finite acceleration; shorten the time, or check torques and masses."
        )
    return system.normalised(found.y.T)


def _times(t: ArrayLike) -> Array:
    times = as_floats("simulate", "t", t)
    if times.ndim != 1 or len(times) < 2:
        raise FreebodyError(f"simulate: t has shape {times.shape}, expected at least two times.")
    refuse_not_finite("simulate", "t", times, 0)
    if (np.diff(times) <= 0).any():
        raise FreebodyError("simulate: the times t must increase.")
    return times


def _wrenches(model: Model, wrenches: Wrenches) -> dict[str, Array]:
    if wrenches is None:
        return {}
    six = 6 if model.dim == 3 else 3
    given: dict[str, Any] = dict(wrenches) if hasattr(wrenches, "items") else {model.frame().name: wrenches}  # type: ignore[call-overload]
    found = {}
    for frame, value in given.items():
        name = model.frame(frame).name
        found[name] = as_floats("simulate", f"wrenches[{name!r}]", value)
        check_core(
            "simulate", f"wrenches[{name!r}]", found[name], (six,), "force, then moment, constant, world axes"
        )
        refuse_not_finite("simulate", f"wrenches[{name!r}]", found[name], 1)
    return found


def _drive(model: Model, t: Array, torque: Torque) -> Drive:
    """The torque as a function of time and state."""
    if torque is None:
        still = np.zeros(model.nv)
        return lambda now, q, qd: still
    if callable(torque):
        function = torque
        return lambda now, q, qd: _returned(model, function(float(now), q, qd))
    table = as_floats("simulate", "torque", torque)
    if table.shape not in ((model.nv,), (len(t), model.nv)):
        check_core("simulate", "torque", table, (model.nv,), f"model {model.name!r} has nv = {model.nv}")
        raise FreebodyError(
            f"simulate: torque has shape {table.shape}, expected ({model.nv},), ({len(t)}, {model.nv}) or a function."
        )
    refuse_not_finite("simulate", "torque", table, 1, model.velocity_names)
    refuse_passive("simulate", model, table)
    if table.ndim == 1:
        return lambda now, q, qd: table
    return lambda now, q, qd: _between(t, table, now)


def _returned(model: Model, value: ArrayLike) -> Array:
    tau = np.asarray(value, dtype=float)
    if tau.shape != (model.nv,):
        check_core("simulate", "what torque(t, q, qd) returns", tau, (model.nv,), f"model {model.name!r}")
    refuse_passive("simulate", model, tau)
    return tau


def _between(t: Array, table: Array, now: Array) -> Array:
    k = np.clip(np.searchsorted(t, now, side="right") - 1, 0, len(t) - 2)
    part = (now - t[k]) / (t[k + 1] - t[k])
    return table[k] + part * (table[k + 1] - table[k])


def _dataset(system: System, t: Array, y: Array, drive: Drive, method: str, tolerance: float) -> xr.Dataset:
    import xarray as xr

    model = system.model
    q, qd = system.split(y)
    tau = np.stack([drive(now, *state) for now, state in zip(t, zip(q, qd, strict=True), strict=True)])
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
        "potential_energy": (("time",), dynamics.potential_energy(model, q), "J", "of gravity and springs"),
        "power": (at, tau * qd, "W", "mechanical power of the drive"),
    }
    if model.loops:
        for name, value, unit, text in (
            ("loop_gap", residual(model, q), "m", "how far each loop is open"),
            ("loop_rate", rate_of_loops(model, q, qd), "m/s", "how fast each loop opens"),
        ):
            variables[name] = (("time", "loop"), gaps(model, value), unit, text)
    friction = system.friction
    return xr.Dataset(
        {name: (d, v, {"units": u, "long_name": text}) for name, (d, v, u, text) in variables.items()},
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
