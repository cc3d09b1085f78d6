"""The largest efforts of a robot's drives and of joints that follow others: the one rule of what is
a limit.

A limit of 0 is none (`Limits.meant`), and so is one of a joint that nothing drives. A joint that
follows another has a limit of its own: its coordinate feels the torques of both together, but what
reaches the follower passes through the follower's joint alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics, joint_wrenches
from freebody.arrays import Array, refuse_not_finite
from freebody.errors import FreebodyError, listed
from freebody.model.kept_facts import fact
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.trees.public_calls import JointVector, vector


def effort_limits(model: Model) -> Array:
    """The largest efforts (*family, nv) of the coordinates, infinite where nothing drives one or no
    limit is given."""
    written = model.limits.effort
    driven = np.isin(np.arange(model.nv), model.driven)
    return np.where(driven & (written != 0.0), written, np.inf)


def chosen_efforts(function: str, model: Model, effort: JointVector | None = None) -> Array:
    """The largest efforts (*family, nv): those that a caller gives, else the model's.

    A mapping may leave out what nothing drives. Refuses what is not positive, and a model without
    any limit.
    """
    if effort is not None:
        return _given(function, model, effort)
    found = effort_limits(model)
    if not np.isfinite(found).any():
        raise FreebodyError(
            f"{function}: no joint of {model.name!r} has an effort limit. Give effort= (--effort), "
            f"the largest torque or force of each joint ({listed(model.driven_names, 8)})."
        )
    return found


def _given(function: str, model: Model, effort: JointVector) -> Array:
    names = model.velocity_names
    if isinstance(effort, Mapping):
        effort = dict.fromkeys(set(names) - set(model.driven_names), np.inf) | dict(effort)
    found = vector(function, model, "effort", effort)
    refuse_not_finite(function, "effort", np.where(np.isposinf(found), 1.0, found), 1, names)
    if found.shape[:-1] not in ((), model.family) or not (found > 0).all():
        raise FreebodyError(
            f"{function}: effort must be one positive number for each of the {model.nv} joints; "
            f"got {found.tolist()}."
        )
    driven = np.isin(np.arange(model.nv), model.driven)
    return np.where(driven, found, np.inf)


@dataclass(frozen=True, eq=False)
class Followers:
    """The joints of a robot that follow others and have effort limits of their own.

    freed: the robot with all followers moving by themselves. names, limits (*family, n), columns
    (n,) of their torques in freed's, and the indices (n,) of their bodies.
    """

    model: Model
    freed: Model
    names: tuple[str, ...]
    limits: Array
    columns: np.ndarray
    bodies: np.ndarray

    def states(self, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array, Array]:
        """Positions, rates and accelerations of the freed robot that moves in the same way."""
        at = tuple(tuple(np.moveaxis(x, -1, 0)) for x in (q, qd, qdd))
        own = self.model.coordinates
        parts = (
            [x for c in own for x in c.position(at[0])],
            [x for c in own for x in c.rates(*at[:2])],
            [x for c in own for x in c.second_rates(*at)],
        )
        return tuple(np.stack(np.broadcast_arrays(*x), axis=-1) for x in parts)  # type: ignore

    def torques(self, q: Array, qd: Array, qdd: Array, wrenches: Any = None) -> Array:
        """The torques or forces (..., n) that reach the followers."""
        if not self.model.loops:
            free = inverse_dynamics(self.freed, *self.states(q, qd, qdd), wrenches)
            return free[..., self.columns]
        # what reaches the child, and in addition what drive and spring of the joint take
        carried = joint_wrenches(self.model, q, qd, qdd, wrenches, "child")[..., self.bodies, :]
        tree = self.model.tree
        axes = [tree.bodies[tree.body_of[k]].columns[0] for k in self.bodies]
        along = np.stack([np.array([*v, *w]) for w, v in axes])
        states, cut = self.states(q, qd, qdd), self.freed.opened
        bare = cut.without("friction", "rotors", "springs")
        taken = inverse_dynamics(cut, *states) - inverse_dynamics(bare, *states)
        return (carried[..., : along.shape[1]] * along).sum(axis=-1) + taken[..., self.columns]


def followers(model: Model) -> Followers | None:
    """The followers of a robot that have effort limits of their own; None where there are none."""
    return _followers(model)


@fact
def _followers(model: Model) -> Followers | None:
    limited = [
        k
        for k, body in enumerate(model.bodies)
        if body.joint.mimic is not None
        and np.isfinite(VALUES.quantity(body.joint.limits.meant.effort)).any()
    ]
    if not limited:
        return None
    freed = replace(
        model,
        bodies=tuple(replace(body, joint=replace(body.joint, mimic=None)) for body in model.bodies),
    )
    own = [VALUES.quantity(model.bodies[k].joint.limits.meant.effort) for k in limited]
    return Followers(
        model,
        freed,
        tuple(model.bodies[k].joint.name for k in limited),
        np.stack([np.broadcast_to(np.float64(x), model.family) for x in own], axis=-1),
        np.array([freed.coordinates[k].v[0] for k in limited]),
        np.array(limited),
    )
