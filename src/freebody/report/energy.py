"""Energies, powers and their balance along a motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.loops import drive_torques as closed
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import with_drive
from freebody.trees import dynamics

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_MOST_PARTS = 64


def energies(model: Model, motion: Motion) -> dict[str, Any]:
    """Kinetic and potential energy, and what is left of the energy balance.

    The residual is ∫ (τ - τ_friction) · q̇ dt - (E(t) - E(0)), the integral by Gauss's rule with 6
    points in each interval of the motion's curve, or in parts of it.
    """
    kinetic = dynamics.kinetic_energy(model, motion.q, motion.qd)
    potential = dynamics.potential_energy(model, motion.q)
    total = kinetic + potential
    work = supplied_work(model, motion)
    return {
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "supplied_work": work,
        "energy_residual": work - (total - total[0]),
    }


def supplied_work(model: Model, motion: Motion) -> Array:
    """∫ (τ - τ_friction) · q̇ dt up to each sample (T,); intervals are halved until the integral no
    longer changes."""
    smooth = model.without("friction")  # τ - τ_friction, free of the jumps of sign(q̇)
    parts, coarse = 1, _integral(smooth, motion, 1)
    while parts < _MOST_PARTS:
        parts *= 2
        fine = _integral(smooth, motion, parts)
        change, size = np.abs(fine - coarse).max(), np.abs(fine).max()
        coarse = fine
        if change <= 1e-12 * size:
            break
    return coarse


def _integral(model: Model, motion: Motion, parts: int) -> Array:
    """The work up to each sample, by Gauss's rule in `parts` equal parts between knots."""
    knots = motion.knots
    h = np.diff(knots)[:, None] / parts
    starts = knots[:-1, None] + h * np.arange(parts)
    q, qd, qdd = motion.at(starts[..., None] + 0.5 * h[..., None] * (1.0 + _NODES))
    torques = closed.torques if model.loops else inverse_dynamics
    power = np.sum(torques(model, q, qd, qdd) * qd, axis=-1)
    work = np.concatenate([[0.0], np.cumsum(np.sum(0.5 * h * (power @ _WEIGHTS), axis=-1))])
    return work[np.searchsorted(knots, motion.t)]


def powers(model: Model, found: dict[str, Any], motion: Motion) -> dict[str, Any]:
    """Mechanical power of each drive and their sum, and what friction takes, by the torques found;
    joints without a drive give none."""
    power = np.where(with_drive(model), found["tau"] * motion.qd, 0.0)
    friction = np.sum(found["tau_friction"] * motion.qd, axis=-1)
    return {"power": power, "motor_power": power.sum(axis=-1), "friction_power": friction}
