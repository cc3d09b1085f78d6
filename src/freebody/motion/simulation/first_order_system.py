"""A model as first-order differential equations ẏ = f(t, y), y = (q, q̇), on compiled kernels: the
integrator that suits it, and the projection of states onto loops and unit quaternions.

The state of a closed chain is that of all joints, its acceleration from (5.29). Stages and steps of
an explicit Runge-Kutta method leave the loops by their local error; they are moved back, positions
and rates, by the way of least energy: that takes out what wrong forces of the loops have added,
which near a singular position are large, and nothing of the motion that the loops allow (Blajer
2011)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import BDF, DOP853, LSODA, RK45, OdeSolver, Radau

from freebody.arrays import Array
from freebody.kernels.formulas import Option
from freebody.kernels.structural import Bound, fetch
from freebody.loops.accelerations import accelerations, regular, require_way
from freebody.loops.closure_checks import (
    blurred,
    require_within_tolerance,
    scaled_jacobian,
    scaled_residual,
)
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import rate_scale
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.motion.simulation.step_kernels import smooth_kernel
from freebody.motion.smooth_friction import (
    WIDTH,
    DryFriction,
    largest_square,
    smooth_friction,
    strut_damping,
)
from freebody.trees.dynamics import mass_matrix
from freebody.trees.position_rates import CoordinateLayout, layout, normalised, position_rate
from freebody.trees.positions import integrate
from freebody.trees.special_joints import refuse_massless

TorqueLaw = Callable[[Array, Array, Array], Array]
"""(t, q, qd) -> tau, all with the same leading shape."""
WrenchLaw = Callable[[Array], tuple[Array, ...]]
"""External wrenches, one array (*t.shape, ..., six) a frame, at times t."""
_STEP = 1e-6  # of central differences, relative to 1 + |y|
_IMPLICIT_FROM = 1e3
"""Decay rate times duration from which an explicit method wastes its steps on stability."""
METHODS: dict[str, type[OdeSolver]] = {
    "DOP853": DOP853,
    "RK45": RK45,
    "Radau": Radau,
    "BDF": BDF,
    "LSODA": LSODA,
}
EXPLICIT, IMPLICIT = ("DOP853", "RK45"), ("Radau", "BDF", "LSODA")
"""Methods by kind; those of closed chains are explicit."""
_DAMPING = ("Radau", "BDF")  # what they are chosen for damps their errors
# a robot's errors grow on the way, tenfold and more in a second; other steps are as much finer
_FEWER = 100.0
FINEST = 2.3e-14
"""The finest tolerance of a step that rounding leaves any meaning."""
_FINEST_ON_LOOPS = 1e-13  # relative tolerance: rounding
# singular values, relative to the largest, that a correction acts on where nothing is rounded
_SEEN = 1e-7
_TURN = 1e-10  # rad: how far an open loop may turn the direction of the rates that are corrected
_ROUNDED = 1e-16  # to which an equation can be closed
_LIGHT = 1e-9  # of all inertia: what is taken for the inertia of what has none
_STRAIGHT = 0.1  # of a singular value: how far a position may be corrected along its direction


@dataclass(frozen=True, eq=False)
class System:
    """The right-hand side of a model's first-order equations and its derivative; both accept
    batches of states."""

    model: Model
    layout: CoordinateLayout
    friction: DryFriction
    forward: Callable[..., Array]
    inverse: Callable[..., Array]
    loads: WrenchLaw

    @property
    def size(self) -> int:
        """The number of states: nq + nv."""
        return self.layout.nq + self.layout.nv

    def split(self, y: Array) -> tuple[Array, Array]:
        """Positions and rates (q, q̇) of states y (..., nq + nv)."""
        return y[..., : self.layout.nq], y[..., self.layout.nq :]

    def rate(self, t: Array, y: Array, tau: Array) -> Array:
        """ẏ (..., nq + nv) under drive torques tau (..., nv).

        A quaternion's rate is linear in it, so its length, which the integrator does not keep
        exactly, never affects the rotation; kernels normalise.
        """
        q, qd = self.split(y)
        return np.concatenate(
            [position_rate(self.layout, q, qd), self.acceleration(t, q, qd, tau)], axis=-1
        )

    def acceleration(self, t: Array, q: Array, qd: Array, tau: Array) -> Array:
        """Accelerations q̈ (..., nv) under drive torques tau (..., nv)."""
        if self.friction.acts:
            tau = tau - self.friction.torque(q, qd)
        return self.forward(q, qd, tau, *self.loads(t))

    def torque(self, t: Array, q: Array, qd: Array, qdd: Array) -> Array:
        """Inverse dynamics (..., nv) of the tree, with smoothed friction."""
        return self.inverse(q, qd, qdd, *self.loads(t)) + self.friction.torque(q, qd)

    def jacobian(self, t: Array, y: Array, tau: Array) -> Array:
        """∂ẏ/∂y (..., n, n) at constant torque, by central differences of the kernel."""
        return self._slopes(t, y, lambda now, q, qd: tau[..., None, :])

    def jacobian_under(self, t: Array, y: Array, drive: TorqueLaw) -> Array:
        """The derivative ∂ẏ/∂y (n, n) at one state, with the torque varying with the state."""
        return self._slopes(t, y, drive)

    def _slopes(self, t: Array, y: Array, drive: TorqueLaw) -> Array:
        h = _STEP * (1.0 + np.abs(y))
        shifts, times = np.eye(self.size) * h[..., None, :], np.asarray(t)[..., None]
        plus, minus = (
            self.rate(times, shifted, drive(t, *self.split(shifted)))
            for shifted in (y[..., None, :] + shifts, y[..., None, :] - shifts)
        )
        return np.swapaxes((plus - minus) / (2.0 * h[..., None]), -1, -2)

    def fastest_decay(self, t: Array, y: Array, drive: TorqueLaw) -> float:
        """The rate (1/s) at which the fastest motion near a state decays: the largest -Re λ of the
        eigenvalues of ∂ẏ/∂y; 0 where none decays, or the torque cannot be evaluated nearby."""
        return max(0.0, -float(self._eigenvalues(t, y, drive).real.min(initial=0.0)))

    def fastest(self, t: Array, y: Array, drive: TorqueLaw) -> float:
        """The rate (1/s) of the fastest motion near a state that does not grow, oscillations
        included: the largest |λ| of the eigenvalues of ∂ẏ/∂y."""
        found = self._eigenvalues(t, y, drive)
        return float(np.abs(found[found.real < 0.1 * np.abs(found)]).max(initial=0.0))

    def fastest_at_rest(self, t: Array, y: Array, drive: TorqueLaw, width: float) -> float:
        """The rate (1/s) of the fastest motion that does not grow near rest at a state's positions,
        at the steepest slope of friction smoothed over `width`; 0 without such friction."""
        friction, q = smooth_friction(self.model, width)[1], self.split(y)[0]
        if not friction.acts and not lossy_joints(self.model.bodies):
            return 0.0
        resting = np.concatenate([q, np.zeros(self.model.nv)])
        # laws may be steeper beside rest than in it
        return max(self.fastest(t, resting, drive), decay_rate(self.model, friction, q))

    def _eigenvalues(self, t: Array, y: Array, drive: TorqueLaw) -> NDArray[np.complex128]:
        slopes = self.jacobian_under(t, y, drive)
        if not np.isfinite(slopes).all():
            return np.zeros(0, dtype=np.complex128)
        return np.linalg.eigvals(slopes).astype(np.complex128)

    def normalised(self, y: Array) -> Array:
        """The states with quaternions scaled to unit length."""
        q, qd = self.split(y)
        return np.concatenate([normalised(self.layout, q), qd], axis=-1)


def system(
    model: Model,
    width: float = WIDTH,
    wrench_frames: tuple[str, ...] = (),
    loads: WrenchLaw | None = None,
) -> System:
    """The system of a model; dry friction is smoothed over `width`. Raises SingularError if M
    is singular."""
    smooth, friction = smooth_friction(model, width)
    forward: Callable[..., Array]
    if lossy_joints(model.bodies):  # what is lost depends on all friction, and accelerations
        refuse_massless(model, "simulate")
        forward, whole = (
            _of_width(smooth_kernel(model, name, wrench_frames), width)
            for name in ("forward_dynamics", "inverse_dynamics")
        )
        friction = replace(friction, drives=())  # they have it
        return System(model, layout(model), friction, forward, whole, loads or (lambda t: ()))
    if model.loops:
        forward = partial(accelerations, smooth, wrench_frames)
    else:
        refuse_massless(model, "simulate")
        forward = fetch(smooth, ("forward_dynamics",), Option(wrench_frames=wrench_frames))
    inverse = fetch(smooth.opened, ("inverse_dynamics",), Option(wrench_frames=wrench_frames))
    return System(model, layout(model), friction, forward, inverse, loads or (lambda t: ()))


def _of_width(kernel: Bound, width: float) -> Callable[..., Array]:
    def dynamics(q: Array, qd: Array, given: Array, *loads: Array) -> Array:
        found: Array = kernel(q, qd, given, width, *loads)
        return found

    return dynamics


def loads_over(t: Array, wrenches: Mapping[str, Array]) -> tuple[tuple[str, ...], WrenchLaw]:
    """(frames, loads) of wrenches (..., T, six) at the times t (T,), linear in between, or constant
    ones (..., 1, six)."""
    return tuple(wrenches), lambda now: tuple(row_at(now, t, rows) for rows in wrenches.values())


def row_at(now: Array, t: Array, rows: Array) -> Array:
    """Values (*now.shape, ..., n) at the times `now`, from a table (..., T or 1, n) over the times
    t (T,)."""
    if rows.shape[-2] == 1:
        return rows[..., 0, :]
    k = np.clip(np.searchsorted(t, now, side="right") - 1, 0, len(t) - 2)
    by_time, part = np.moveaxis(rows, -2, 0), np.asarray((now - t[k]) / (t[k + 1] - t[k]))
    first = by_time[k]
    return first + part.reshape(part.shape + (1,) * (rows.ndim - 1)) * (by_time[k + 1] - first)


def suited_method(
    system: System, q: Array, duration: float, decay: Callable[[], float] = lambda: 0.0
) -> str:
    """The name of the integrator: Radau where friction makes the system stiff over the duration,
    LSODA where feedback does (`decay` (1/s)), else DOP853.

    Both are implicit. Of tanh(q̇ / width) steps of many stages see the bend, and methods that look
    back at earlier steps lose their order there; where all is smooth these take a tenth of the
    time.
    """
    lossy = bool(lossy_joints(system.model.bodies))  # what is lost bends as friction does
    if lossy or decay_rate(system.model, system.friction, q) * duration > _IMPLICIT_FROM:
        return "Radau"
    return "LSODA" if decay() * duration > _IMPLICIT_FROM else "DOP853"


def decay_rate(model: Model, friction: DryFriction, q: Array) -> float:
    """The fastest rate (1/s) at which friction damps a motion at q (..., nq): largest eigenvalue of
    M⁻¹ D."""
    damping, at_rest = friction.steepest(q), ((0.0,) * model.nq, (0.0,) * model.nv)
    for body in model.tree.bodies:
        if body.drive is not None:
            steepest = max(0.0, body.drive.slopes(*at_rest)[1])
            damping[body.coordinates.v[0]] += largest_square(body.drive.at, q) * steepest
    D = np.diag(np.abs(damping))
    if model.struts:
        D = D + strut_damping(model, np.broadcast_to(q, (model.nv, model.nq)), np.eye(model.nv))
    if not D.any():
        return 0.0
    M = mass_matrix(model, normalised(layout(model), q))
    return float(np.abs(np.linalg.eigvals(np.linalg.solve(M, D))).max())


def step_tolerance(method: str, tolerance: float) -> float:
    """The relative error allowed in a step for a motion that shall end within about `tolerance`."""
    return tolerance if method in _DAMPING else max(tolerance / _FEWER, FINEST)


@dataclass(frozen=True, eq=False)
class Scheme:
    """The integration scheme of a system: its right-hand side under a torque, and the correction of
    the states reached."""

    rate: Callable[[TorqueLaw], Callable[[float, Array], Array]]
    settled: Callable[[Array], Array]
    settings: dict[str, Any]
    """Settings of scipy's solver: tolerances, the largest step."""
    require: Callable[[TorqueLaw, float, Array], None]
    """Refuses a start (torque, time, state) from which no motion leads on."""
    every_step: bool
    """Whether each step is settled before the next, not the ends of the pieces alone."""
    stopped: str
    """A sentence on what a run that cannot go on may have met."""


def open_scheme(system: System, tolerance: float, max_step: float) -> Scheme:
    """The scheme of a tree with a tolerance for each step: quaternions are brought back to unit
    length."""

    def rate(drive: TorqueLaw) -> Callable[[float, Array], Array]:
        return lambda now, y: system.rate(
            np.asarray(now), y, drive(np.asarray(now), *system.split(y))
        )

    settings = {"rtol": tolerance, "atol": tolerance / 100, "max_step": max_step}
    reason = (
        "The motion may diverge or pass a state without finite acceleration; shorten the time, or "
        "check torques and masses."
    )
    return Scheme(rate, system.normalised, settings, lambda drive, t, y: None, False, reason)


def closed_chain_scheme(system: System, tolerance: float, max_step: float) -> Scheme:
    """The scheme of a closed chain with a tolerance for each step: every step is brought back onto
    the loops."""

    def rate(drive: TorqueLaw) -> Callable[[float, Array], Array]:
        def at(now: float, y: Array) -> Array:
            # near a singular position the loops would pull back a stage that has left them, with
            # great force
            on = y if regular(system.model, system.split(y)[0]) else _settled(system, y)
            return system.rate(np.asarray(now), on, drive(np.asarray(now), *system.split(on)))

        return at

    # an angle of many turns is worth no less than a small one, so errors are not relative to the
    # positions
    scale = np.concatenate([np.ones(system.layout.nq), rate_scale(system.model)])
    settings = {"rtol": _FINEST_ON_LOOPS, "atol": tolerance * scale, "max_step": max_step}
    reason = (
        "The motion diverges, or the mechanism reaches a position beyond which its loops do not "
        "let it move."
    )

    def require(drive: TorqueLaw, t: float, y0: Array) -> None:
        now, state = np.asarray(t), system.split(y0)
        require_way(system.model, *state, system.acceleration(now, *state, drive(now, *state)))

    def onto_loops(y: Array) -> Array:
        on = _settled(system, y)
        require_within_tolerance("simulate", system.model, system.split(on)[0], np.array(True))
        return on

    return Scheme(rate, onto_loops, settings, require, True, reason)


def _settled(system: System, y: Array) -> Array:
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
    """The inverse mass matrix (nv, nv) over scaled rates; directions without mass are given a
    little."""
    (M,) = (fetch(model, ("mass_matrix",), Option())(q),)
    M = rates[:, None] * M * rates
    return np.linalg.inv(M + _LIGHT * np.trace(M) * np.eye(len(M)))


def _lightest(mobility: Array, Vt: Array, way: Array) -> Array:
    """The rates x of least kinetic energy with Vt x = way."""
    push = mobility @ Vt.T
    return push @ np.linalg.solve(Vt @ push, way)


def _divided(x: Array, s: Array, seen: float) -> Array:
    """The quotients x / s, and 0 where s is only rounding relative to the largest."""
    clear = s > seen * s.max(initial=1e-300)
    return np.where(clear, x, 0.0) / np.where(clear, s, 1.0)
