"""Coulomb friction that an integrator can follow: sign(q̇) made smooth over a stated width."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.simulation_steps import FRICTION_WIDTH
from freebody.arrays import Array
from freebody.lazy import cached_property, kept
from freebody.model.model import Model
from freebody.trees.position_rates import Index

WIDTH = FRICTION_WIDTH
"""rad/s or m/s: sticking creeps at rates below this."""


@dataclass(frozen=True, eq=False)
class SmoothFriction:
    """c tanh(q̇ / width) of each joint that has Coulomb friction, in place of c sign(q̇)."""

    coordinate: Index
    ratio: Array
    coulomb: Array
    nv: int
    width: float

    @property
    def acts(self) -> bool:
        """Whether there is any Coulomb friction."""
        return len(self.coordinate) > 0

    def torque(self, qd: Array) -> Array:
        """Torques (..., nv) that the drives need to overcome friction at rates qd (..., nv)."""
        if not self.acts:
            return np.zeros(qd.shape)
        each = (
            self.ratio
            * self.coulomb
            * np.tanh(qd[..., self.coordinate] * (self.ratio / self.width))
        )
        return each @ self._sum

    @cached_property
    def _sum(self) -> Array:
        """1 where a joint (row) acts on a coordinate (column)."""
        return (self.coordinate[:, None] == np.arange(self.nv)).astype(float)

    def steepest(self) -> Array:
        """Largest slope d tau / d q̇ of each coordinate (nv,)."""
        slope = np.zeros(self.nv)
        np.add.at(slope, self.coordinate, self.ratio**2 * self.coulomb / self.width)
        return slope


def smooth_friction(model: Model, width: float = WIDTH) -> tuple[Model, SmoothFriction]:
    """(the model without its Coulomb friction, that friction made smooth)."""
    rows = [
        (b.coordinates.v[0], b.coordinates.ratio, b.drive.coulomb)
        for b in model.tree.bodies
        if b.drive is not None and np.any(b.drive.coulomb)
    ]
    friction = SmoothFriction(
        np.array([row[0] for row in rows], dtype=int),
        np.array([row[1] for row in rows]),
        np.stack([np.broadcast_to(row[2], model.family) for row in rows], axis=-1)
        if rows
        else np.zeros(0),
        model.nv,
        width,
    )
    if not rows:
        return model, friction
    bodies = tuple(
        replace(body, joint=replace(body.joint, drive=replace(body.joint.drive, coulomb=0.0)))
        for body in model.bodies
    )
    return replace(model, bodies=bodies), friction


def drive_arrays(model: Model) -> tuple[Array, Array, Array]:
    """Viscous and Coulomb friction and rotor inertia of each coordinate (nv,); what followers add
    is included.

    The Coulomb entry is the largest that the coordinate can feel. Arrays that cannot be written to.
    """
    return kept(model, "_drive_arrays", _drive_arrays, model)


def _drive_arrays(model: Model) -> tuple[Array, Array, Array]:
    arrays = np.zeros((3, model.nv))
    for body in model.tree.bodies:
        if body.drive is not None:
            at, d = body.coordinates, body.drive
            arrays[:, at.v[0]] += (
                d.viscous * at.ratio**2,
                d.coulomb * abs(at.ratio),
                d.rotor * at.ratio**2,
            )
    arrays.flags.writeable = False
    return arrays[0], arrays[1], arrays[2]
