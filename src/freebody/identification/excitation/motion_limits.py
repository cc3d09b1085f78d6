"""Limits of a motion for identification: of positions, rates, accelerations and torques, and a box
for the origins of frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array, as_floats
from freebody.errors import FreebodyError, ShapeError, listed
from freebody.identification.excitation.fourier import FourierStates
from freebody.kernels.own_functions import compile as compiled
from freebody.model.doubt_rules.aspects import MASSES
from freebody.model.doubts import doubts_on
from freebody.model.model import Model
from freebody.motion.planning.planning_limits import PlanningLimits
from freebody.ways_out.kernel import formula

WITHIN = 0.99
"""Part of a limit from which a sample costs: between samples a motion goes a little beyond."""
_SLOW = 0.2  # rad/s, m/s and by s: limits of quasi-static motions
_MOVES = 1e-8
"""Distance below which a frame counts as one that no joint moves."""


@dataclass(frozen=True)
class Walls:
    """A box for origins of frames: the kernel of their places (..., points, dim), and corners."""

    points: Callable[..., Array]
    low: Array
    high: Array

    def used(self, q: Array) -> Array:
        """How much of the box is used (..., 2 points dim): above 1 outside, by m."""
        places = self.points(q)
        over = np.concatenate([places - self.high, self.low - places], axis=-2)
        return 1.0 + over.reshape(*q.shape[:-1], -1)


@dataclass(frozen=True)
class MotionLimits:
    """The limits of a robot's motion, and the box if there is one."""

    model: Model
    planning: PlanningLimits
    walls: Walls | None

    def used(self, states: FourierStates) -> Array:
        """How much of each limit is used (..., limits), above 1 too much: of positions, rates,
        accelerations, torques, and the box."""
        q, qd, qdd = states
        allowed = self.planning.allowed
        room = 0.5 * allowed.width
        parts = [1.0 + (q - allowed.upper) / room, 1.0 + (allowed.lower - q) / room]
        for x, most in ((qd, self.planning.velocity), (qdd, self.planning.acceleration)):
            parts.append(np.abs(x) / most)
        if np.isfinite(self.planning.torque).any():
            parts.append(np.abs(inverse_dynamics(self.model, q, qd, qdd)) / self.planning.torque)
        if self.walls is not None:
            parts.append(self.walls.used(q))
        return np.concatenate(parts, axis=-1)

    def excess(self, states: FourierStates) -> Array:
        """The squares by which limits are exceeded (...), added up."""
        return (np.maximum(self.used(states) - WITHIN, 0.0) ** 2).sum(axis=-1)

    def of_rates(self, states: FourierStates) -> float:
        """How much of the limits of rates and accelerations is used at most."""
        return max(
            float(np.max(np.abs(states.qd) / self.planning.velocity)),
            float(np.max(np.abs(states.qdd) / self.planning.acceleration)),
        )

    def postures(self, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Random postures (count, n) between the limits of position, half a turn at most, and how
        much of all limits is used at rest there (count,). Refuses limits that no posture keeps."""
        allowed = self.planning.allowed
        low, high = (
            np.where(np.isfinite(x), x, y)
            for x, y in ((allowed.lower, -np.pi), (allowed.upper, np.pi))
        )
        low, high = np.maximum(low, -np.pi), np.minimum(high, np.pi)
        middles = low + (high - low) * rng.random((count, self.model.nv))
        still = np.zeros_like(middles)
        used = self.used(FourierStates(middles, still, still)).max(axis=1)
        if used.min() > WITHIN:
            raise FreebodyError(
                f"excitation: of {count} postures of {self.model.name!r} none is within the "
                f"limits at rest{' and inside the box' if self.walls else ''}; widen the box, or "
                f"look at the effort limits."
            )
        return middles, used

    def words(self) -> tuple[str, ...]:
        """Sentences on limits that are not there."""
        found, names = [], self.model.velocity_names
        free = [x for x, a in zip(names, self.planning.acceleration, strict=True) if a == np.inf]
        if free:
            found.append(f"The acceleration of {listed(free, 6)} has no limit but its frequencies.")
        if self.walls is None:
            found.append("Collisions with the robot itself and its surroundings are not looked at.")
        if np.isfinite(self.planning.torque).any() and doubts_on(self.model, MASSES):
            found.append("The model's masses are doubtful, and torques are limited by them alone.")
        return tuple(found)


def slowed(limits: PlanningLimits) -> PlanningLimits:
    """The limits of a quasi-static motion."""
    slow = (np.minimum(x, _SLOW) for x in (limits.velocity, limits.acceleration))
    return replace(limits, **dict(zip(("velocity", "acceleration"), slow, strict=True)))


def walls_of(model: Model, box: ArrayLike | None, frames: Sequence[str] | None) -> Walls | None:
    """The box (2, dim) for the origins of frames, by default of those that move, and of the tip."""
    if box is None:
        if frames is not None:
            raise FreebodyError("excitation: frames are given without a box; give box=(low, high).")
        return None
    corners = as_floats("excitation", "box", box)
    if corners.shape != (2, model.dim):
        raise ShapeError(
            "excitation", "box", corners.shape, f"(2, {model.dim})", "its lowest and highest corner"
        )
    if not (corners[0] < corners[1]).all():
        raise FreebodyError(
            "excitation: the box has no room: its first corner must be the lowest, its second the "
            "highest."
        )
    names = list(model.frame_names) if frames is None else list(frames)
    poses = [
        formula(model, "forward_kinematics", frame=x)
        for x in (*names, *([None] * (frames is None)))
    ]
    dim = model.dim

    def places(q):
        return {"places": tuple(tuple(T(q)[i][dim] for i in range(dim)) for T in poses)}

    kernel = compiled(places, {"q": (model.nq,)}, {"places": (len(poses), dim)})
    if frames is None:
        q = np.random.default_rng(0).uniform(-1.0, 1.0, (4, model.nq))
        moves = np.ptp(kernel(q), axis=0).max(axis=-1) > _MOVES
        return Walls(lambda q: kernel(q)[..., moves, :], *corners)
    return Walls(kernel, *corners)
