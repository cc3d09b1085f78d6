"""A model as a system of first-order differential equations, ẏ = f(t, y) with y = (q, q̇), on
compiled kernels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.accelerations import accelerations
from freebody.model.model import Model
from freebody.motion.friction import WIDTH, SmoothFriction, smooth_friction
from freebody.trees.dynamics import mass_matrix
from freebody.trees.position_rates import CoordinateLayout, layout, normalised, position_rate
from freebody.trees.special_joints import refuse_massless

Drive = Callable[[Array, Array, Array], Array]
"""(t, q, qd) -> tau, all with the same leading shape."""
Loads = Callable[[Array], tuple[Array, ...]]
"""External wrenches, one array (*t.shape, ..., six) a frame, at times t."""

_STEP = 1e-6  # of central differences, relative to 1 + |y|
_IMPLICIT_FROM = 1e3
"""Decay rate times duration from which an explicit method wastes its steps on stability."""


@dataclass(frozen=True, eq=False)
class System:
    """The right-hand side and its derivative; batches of states are welcome everywhere."""

    model: Model
    layout: CoordinateLayout
    friction: SmoothFriction
    forward: Callable[..., Array]
    inverse: Callable[..., Array]
    loads: Loads

    @property
    def size(self) -> int:
        """nq + nv."""
        return self.layout.nq + self.layout.nv

    def split(self, y: Array) -> tuple[Array, Array]:
        """(q, q̇) of states y (..., nq + nv)."""
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
        """q̈ (..., nv)."""
        if self.friction.acts:
            tau = tau - self.friction.torque(qd)
        return self.forward(q, qd, tau, *self.loads(t))

    def torque(self, t: Array, q: Array, qd: Array, qdd: Array) -> Array:
        """Inverse dynamics (..., nv) of the tree, with the same smooth friction."""
        return self.inverse(q, qd, qdd, *self.loads(t)) + self.friction.torque(qd)

    def jacobian(self, t: Array, y: Array, tau: Array) -> Array:
        """∂ẏ/∂y (..., n, n) at constant torque, by central differences of the kernel."""
        return self._slopes(t, y, lambda now, q, qd: tau[..., None, :])

    def jacobian_under(self, t: Array, y: Array, drive: Drive) -> Array:
        """The same of one state, with what the torque takes from it."""
        return self._slopes(t, y, drive)

    def _slopes(self, t: Array, y: Array, drive: Drive) -> Array:
        h = _STEP * (1.0 + np.abs(y))
        shifts, times = np.eye(self.size) * h[..., None, :], np.asarray(t)[..., None]
        plus, minus = (
            self.rate(times, shifted, drive(t, *self.split(shifted)))
            for shifted in (y[..., None, :] + shifts, y[..., None, :] - shifts)
        )
        return np.swapaxes((plus - minus) / (2.0 * h[..., None]), -1, -2)

    def fastest_decay(self, t: Array, y: Array, drive: Drive) -> float:
        """How fast (1/s) the quickest motion near a state dies away: the largest -Re λ of the
        eigenvalues of ∂ẏ/∂y; 0 where there is none, or the torque cannot be told nearby."""
        return max(0.0, -float(self._eigenvalues(t, y, drive).real.min(initial=0.0)))

    def fastest(self, t: Array, y: Array, drive: Drive) -> float:
        """The same of motions that oscillate too: the largest |λ| of those that do not grow."""
        found = self._eigenvalues(t, y, drive)
        return float(np.abs(found[found.real < 0.1 * np.abs(found)]).max(initial=0.0))

    def _eigenvalues(self, t: Array, y: Array, drive: Drive) -> NDArray[np.complex128]:
        slopes = self.jacobian_under(t, y, drive)
        if not np.isfinite(slopes).all():
            return np.zeros(0, dtype=np.complex128)
        return np.linalg.eigvals(slopes).astype(np.complex128)

    def normalised(self, y: Array) -> Array:
        """States with unit quaternions."""
        q, qd = self.split(y)
        return np.concatenate([normalised(self.layout, q), qd], axis=-1)


def system(
    model: Model,
    width: float = WIDTH,
    wrench_frames: tuple[str, ...] = (),
    loads: Loads | None = None,
) -> System:
    """The system of a model; Coulomb friction is smoothed over `width`. Raises SingularError if M
    is singular."""
    smooth, friction = smooth_friction(model, width)
    if model.loops:
        forward: Callable[..., Array] = partial(accelerations, smooth, wrench_frames)
    else:
        refuse_massless(model, "simulate")
        forward = fetch(smooth, ("forward_dynamics",), Option(wrench_frames=wrench_frames))
    inverse = fetch(smooth.opened, ("inverse_dynamics",), Option(wrench_frames=wrench_frames))
    return System(model, layout(model), friction, forward, inverse, loads or (lambda t: ()))


def decay_rate(model: Model, friction: SmoothFriction, q: Array) -> float:
    """The fastest rate (1/s) at which friction damps a motion at q (..., nq): largest eigenvalue of
    M⁻¹ D."""
    damping = friction.steepest()
    for body in model.tree.bodies:
        if body.drive is not None:
            damping[body.coordinates.v[0]] += body.coordinates.ratio**2 * body.drive.viscous
    if not damping.any():
        return 0.0
    root = np.sqrt(np.abs(damping))
    M = mass_matrix(model, normalised(layout(model), q))
    similar = root[:, None] * np.linalg.inv(M) * root  # the same eigenvalues, symmetric
    return float(np.abs(np.linalg.eigvalsh(similar)).max())


def suited_method(
    system: System, q: Array, duration: float, decay: Callable[[], float] = lambda: 0.0
) -> str:
    """Radau where friction makes the system stiff over the duration, LSODA where feedback does
    (`decay` (1/s), where there is any), else DOP853.

    Both are implicit. Of tanh(q̇ / width) steps of many stages see the bend, and methods that look
    back at earlier steps lose their order there; where all is smooth these take a tenth of the
    time.
    """
    if decay_rate(system.model, system.friction, q) * duration > _IMPLICIT_FROM:
        return "Radau"
    return "LSODA" if decay() * duration > _IMPLICIT_FROM else "DOP853"


def loads_over(t: Array, wrenches: Mapping[str, Array]) -> tuple[tuple[str, ...], Loads]:
    """(frames, loads) of wrenches (..., T, six) at the times t (T,), linear between them, or (...,
    1, six), which do not change."""
    return tuple(wrenches), lambda now: tuple(row_at(now, t, rows) for rows in wrenches.values())


def row_at(now: Array, t: Array, rows: Array) -> Array:
    """(*now.shape, ..., n) of a table (..., T or 1, n) over the times t (T,)."""
    if rows.shape[-2] == 1:
        return rows[..., 0, :]
    k = np.clip(np.searchsorted(t, now, side="right") - 1, 0, len(t) - 2)
    by_time, part = np.moveaxis(rows, -2, 0), np.asarray((now - t[k]) / (t[k + 1] - t[k]))
    first = by_time[k]
    return first + part.reshape(part.shape + (1,) * (rows.ndim - 1)) * (by_time[k + 1] - first)
