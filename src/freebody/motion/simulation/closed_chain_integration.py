"""Integration of closed chains without drift: every step ends on the loops.

The state is that of all joints, its acceleration from (5.29). Stages and steps of an explicit
Runge-Kutta method leave the loops by their local error; they are moved back, positions and rates,
by the way of least energy: that takes out what wrong forces of the loops have added, which near a
singular position are large, and nothing of the motion that the loops allow (Blajer 2011).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from freebody.arrays import Array
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.accelerations import regular, require_way
from freebody.loops.equations import (
    blurred,
    require_within_tolerance,
    scaled_jacobian,
    scaled_residual,
)
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import rate_scale
from freebody.model.model import Model
from freebody.motion.simulation.first_order_system import Drive, System
from freebody.motion.simulation.integration import Scheme
from freebody.trees.states import integrate

EXPLICIT = ("DOP853", "RK45")
_LEAST = 1e-13  # relative tolerance: rounding
# singular values, relative to the largest, that a correction acts on where nothing is rounded
_SEEN = 1e-7
_TURN = 1e-10  # rad: how far an open loop may turn the direction of the rates that are corrected
_ROUNDED = 1e-16  # to which an equation can be closed
_LIGHT = 1e-9  # of all inertia: what is taken for the inertia of what has none
_STRAIGHT = 0.1  # of a singular value: how far a position may be corrected along its direction


def closed_chain_scheme(system: System, tolerance: float, max_step: float) -> Scheme:
    """Of a closed chain, tolerance being that of a step: every step is brought back onto the
    loops."""

    def rate(drive: Drive) -> Callable[[float, Array], Array]:
        def at(now: float, y: Array) -> Array:
            # near a singular position the loops would pull back a stage that has left them, with
            # great force
            on = y if regular(system.model, system.split(y)[0]) else settled(system, y)
            return system.rate(np.asarray(now), on, drive(np.asarray(now), *system.split(on)))

        return at

    # an angle of many turns is worth no less than a small one, so errors are not relative to the
    # positions
    scale = np.concatenate([np.ones(system.layout.nq), rate_scale(system.model)])
    settings = {"rtol": _LEAST, "atol": tolerance * scale, "max_step": max_step}
    reason = (
        "The motion diverges, or the mechanism reaches a position beyond which its loops do not "
        "let it move."
    )

    def require(drive: Drive, t: float, y0: Array) -> None:
        now, state = np.asarray(t), system.split(y0)
        require_way(system.model, *state, system.acceleration(now, *state, drive(now, *state)))

    def onto_loops(y: Array) -> Array:
        on = settled(system, y)
        require_within_tolerance("simulate", system.model, system.split(on)[0], np.array(True))
        return on

    return Scheme(rate, onto_loops, settings, require, True, reason)


def settled(system: System, y: Array) -> Array:
    """The state (nq + nv,) brought back onto the loops."""
    model = system.model
    q, qd = system.split(system.normalised(y))
    rates = rate_scale(model)
    seen = _SEEN if redundancy(model).rank is None else blurred(model)
    mobility = _mobility(model, q, rates)
    for _ in range(2):
        U, s, Vt = np.linalg.svd(scaled_jacobian(model, q), full_matrices=False)
        way = _divided(U.T @ scaled_residual(model, q), s, seen)
        # a way longer than the singular value has left the neighbourhood in which the equation is
        # straight
        way[np.abs(way) > _STRAIGHT * s] = 0.0
        q = integrate(model, q, -rates * _lightest(mobility, Vt, way))
    J = scaled_jacobian(model, q)
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    # an open loop turns the direction of the rates that close it by its gap over s²
    sure = s**2 * _TURN > np.maximum(np.abs(U.T @ scaled_residual(model, q)), _ROUNDED)
    v = qd / rates
    away = np.where(sure, _divided(U.T @ (J @ v), s, seen), 0.0)
    return np.concatenate([q, rates * (v - _lightest(mobility, Vt, away))])


def _mobility(model: Model, q: Array, rates: Array) -> Array:
    """M⁻¹ (nv, nv) over scaled rates; what moves no mass moves a little."""
    (M,) = (fetch(model, ("mass_matrix",), Option())(q),)
    M = rates[:, None] * M * rates
    return np.linalg.inv(M + _LIGHT * np.trace(M) * np.eye(len(M)))


def _lightest(mobility: Array, Vt: Array, way: Array) -> Array:
    """Of the rates x with Vt x = way those of least energy."""
    push = mobility @ Vt.T
    return push @ np.linalg.solve(Vt @ push, way)


def _divided(x: Array, s: Array, seen: float) -> Array:
    """x / s, 0 where s, relative to the largest, is nothing but rounding."""
    clear = s > seen * s.max(initial=1e-300)
    return np.where(clear, x, 0.0) / np.where(clear, s, 1.0)
