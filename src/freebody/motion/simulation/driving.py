"""What acts along the joints of many motions: the torques of drives, and forces besides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.motion.simulation.compiled_torque import CompiledTorque
from freebody.motion.simulation.driven_steps import both_laws
from freebody.motion.simulation.first_order_system import Drive
from freebody.motion.simulation.lane_torques import (
    HeldTorque,
    LaneTorque,
    LawTorque,
    TableTorque,
)
from freebody.motion.simulation.simulation import Simulation
from freebody.motion.simulation.torques import batched, drive_of
from freebody.trees.special_joints import all_driven


@dataclass(frozen=True, eq=False)
class Driving:
    """The torque of all motions at a time of a row of the result, the forces besides at any time,
    and the sum of both as steps in Python take it.

    torque, added: as step kernels take them, None where a Python function acts within the steps, or
    nothing is added. held: what a controller gave, where there is one.
    """

    drive: Drive
    forces: Drive | None
    acting: Drive
    torque: LaneTorque | None
    added: LaneTorque | None = None
    held: HeldTorque | None = None

    @property
    def adds(self) -> bool:
        """Whether step kernels take more than the torque."""
        return self.added is not None


def driving_of(asked: Simulation) -> Driving:
    """What was asked for."""
    drive, torque = _torque(asked)
    held = torque if isinstance(torque, HeldTorque) else None
    if asked.forces is None:
        return Driving(drive, None, drive, torque, held=held)
    model, lanes, given = asked.model, asked.lanes, asked.forces
    forces = drive_of(all_driven(model), asked.t, given, lanes.shape, "forces")
    whole = (*lanes.shape, model.nv)
    table = isinstance(asked.torque, np.ndarray)
    own = drive_of(model, asked.t, asked.torque, lanes.shape) if table else drive

    def acting(now: Array, q: Array, qd: Array) -> Array:
        tau = own(now, q, qd) if held is None else held.tau.reshape(whole)
        return tau + forces(now, q, qd)

    if torque is None or not isinstance(given, np.ndarray | CompiledTorque):
        return Driving(drive, forces, acting, None, held=held)
    if isinstance(given, np.ndarray):
        added = TableTorque(asked.t, lanes.each(given, 2))
        return Driving(drive, forces, acting, torque, added, held)
    if isinstance(torque, LawTorque):
        both = LawTorque(both_laws(torque.law, given.law), torque.more, torque.cores)
        return Driving(drive, forces, acting, both, held=held)
    return Driving(drive, forces, acting, LawTorque.of(given.law, lanes, (), ()), torque, held)


def _torque(asked: Simulation) -> tuple[Drive, LaneTorque | None]:
    """The torque of all motions at a time, and as steps take it: None for a Python function that
    acts within them."""
    torque, lanes, nv = asked.torque, asked.lanes, asked.model.nv
    if isinstance(torque, np.ndarray):
        table = TableTorque(asked.t, lanes.each(torque, 2))
        whole = (*lanes.shape, nv)
        return lambda now, q, qd: np.broadcast_to(_shaped(table.given(now), whole), whole), table
    drive: Drive = (
        torque if isinstance(torque, CompiledTorque) else batched(asked.model, torque, lanes.shape)
    )
    if asked.sample_time is not None:
        return drive, HeldTorque(np.zeros((lanes.count, nv)))
    if isinstance(torque, CompiledTorque):
        return drive, LawTorque.of(torque.law, lanes, torque.more, torque.cores)
    return drive, None


def _shaped(tau: Array, whole: tuple[int, ...]) -> Array:
    """One row for all motions as it is, one for each in the shape of the batch."""
    return tau if tau.ndim == 1 else tau.reshape(whole)
