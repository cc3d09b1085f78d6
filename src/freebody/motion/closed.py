"""Integration of closed chains without drift: every step ends on the loops.

The state is that of all joints, its acceleration from (5.29). Stages and steps of an explicit Runge-Kutta method leave
the loops by their local error; they are moved back, positions and rates, by the shortest way.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import DOP853, RK45

from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError
from freebody.motion.system import Drive, System
from freebody.numerics.closed.dynamics import regular, require_way
from freebody.numerics.closed.equations import rate_scale, residual, row_scale, scaled_jacobian
from freebody.numerics.states import integrate

METHODS = {"auto": DOP853, "DOP853": DOP853, "RK45": RK45}
_LEAST = 1e-13  # relative tolerance: rounding
_SEEN = 1e-7  # singular values, relative to the largest, that a correction acts on
_STRAIGHT = 0.1  # of a singular value: how far a position may be corrected along its direction


def integrated_closed(
    system: System, drive: Drive, t: Array, y0: Array, method: str, tolerance: float
) -> Array:
    """States (T, nq + nv) at the times t."""
    if method not in METHODS:
        raise UnknownNameError("method", method, "simulate of a closed chain", METHODS)

    def rate(now: float, y: Array) -> Array:
        # near a singular position the loops would pull back a stage that has left them, with great force
        on = y if regular(system.model, system.split(y)[0]) else settled(system, y)
        return system.rate(np.asarray(now), on, drive(np.asarray(now), *system.split(on)))

    now, state = np.asarray(t[0]), system.split(y0)
    require_way(system.model, *state, system.acceleration(now, *state, drive(now, *state)))
    # an angle of many turns is worth no less than a small one, so errors are not relative to the positions
    scale = np.concatenate([np.ones(system.layout.nq), rate_scale(system.model)])
    solver = METHODS[method](rate, t[0], y0, t[-1], rtol=_LEAST, atol=tolerance * scale)
    states = [y0]
    while solver.status == "running":
        before = solver.t
        solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            raise FreebodyError(
                f"simulate: {method} stopped at t = {before:.6g} s: the motion runs away, or the mechanism reaches a "
                "position from which its loops let it go no further."
            )
        due = t[(t > before) & (t <= solver.t)]
        if len(due):
            between = solver.dense_output()
            states += [settled(system, y) for y in between(due).T]
        solver.y = settled(system, solver.y)
        solver.f = rate(solver.t, solver.y)
    return np.array(states)


def settled(system: System, y: Array) -> Array:
    """The state (nq + nv,) brought back onto the loops."""
    model = system.model
    q, qd = system.split(system.normalised(y))
    rows, rates = row_scale(model), rate_scale(model)
    for _ in range(2):
        U, s, Vt = np.linalg.svd(scaled_jacobian(model, q), full_matrices=False)
        way = _divided(U.T @ (rows * residual(model, q)), s)
        # a way longer than the singular value has left the neighbourhood in which the equation is straight
        way[np.abs(way) > _STRAIGHT * s] = 0.0
        q = integrate(model, q, -rates * (Vt.T @ way))
    J = scaled_jacobian(model, q)
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    v = qd / rates
    return np.concatenate([q, rates * (v - Vt.T @ _divided(U.T @ (J @ v), s))])


def _divided(x: Array, s: Array) -> Array:
    """x / s, 0 where s is nothing but rounding."""
    seen = s > _SEEN * s.max(initial=1e-300)
    return np.where(seen, x, 0.0) / np.where(seen, s, 1.0)
