"""The twists of flexible joints along a motion of the links: each shaft twists by what it carries.

Where the links move as told, what their shafts transmit follows by inverse dynamics, and from it
the twists, by the shafts' springs and dampers; the rotors turn by so much less. The rates of the
twists contain the third derivatives of the links' positions, and the rotors' accelerations the
fourth, so that a motion has to be smooth (De Luca and Book, Robots with flexible elements, 2016).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.model.shafts import Untwisted
from freebody.motion.files.measured_motions import rested
from freebody.motion.motion import Motion, derivatives
from freebody.trees.position_rates import layout

SMOOTH = 5
"""The power of time with which a motion whose twists start from rest leaves its start, at least."""
_WORDS = ", shafts twisted by what they carry"
_PASSES = 2
"""The first is exact where springs and dampers are all that acts in shafts."""


class _Shafts:
    """The twists of springs and dampers side by side over time, from rest to rest."""

    def __init__(self, model: Model, entries: np.ndarray, t: Array):
        drives = {body.joint.name: body.joint.drive for body in model.bodies}
        own = [drives[model.velocity_names[k]] for k in entries]
        stiffness, damping = (
            [float(VALUES.quantity(x)) for x in numbers]
            for numbers in ([x.stiffness for x in own], [x.viscous for x in own])
        )
        self.springs: list[Any] = stiffness
        if any(damping):
            whole = np.eye(len(t))
            slopes = derivatives(t, whole, at_rest=True)[0]
            self.springs = [k * whole + d * slopes for k, d in zip(stiffness, damping, strict=True)]

    def twists(self, torque: Array) -> Array:
        """The twists (T, n) that torques (T, n) make."""
        columns = [
            x / spring if isinstance(spring, float) else np.linalg.solve(spring, x)
            for x, spring in zip(torque.T, self.springs, strict=True)
        ]
        return np.stack(columns, axis=-1)


def links_alone(rigid: Untwisted, motion: Motion) -> Motion:
    """The motion of the robot with rigid joints whose links move as in one of the flexible
    robot's."""
    return replace(
        motion,
        q=rigid.links(motion.q),
        qd=rigid.link_rates(motion.qd),
        qdd=rigid.link_rates(motion.qdd),
        layout=layout(rigid.model),
        pieces=None,
    )


def with_carried_twists(
    model: Model,
    rigid: Untwisted,
    motion: Motion,
    wrenches: Mapping[str, Array] | None = None,
) -> Motion:
    """The motion of a robot with flexible joints whose links move as in a motion of the rigid one,
    from rest to rest, under wrenches (..., six) by frame."""
    q, qd, qdd = rigid.at(motion.q), rigid.at_rates(motion.qd), rigid.at_rates(motion.qdd)
    iq, iv, to_q, to_v = np.array(rigid.twists).T
    rotors = rigid.positions[to_q], rigid.rates[to_v]
    twist, give = np.zeros((len(motion.t), len(iv))), _Shafts(model, iv, motion.t)
    for _ in range(_PASSES):
        twist = twist - give.twists(inverse_dynamics(model, q, qd, qdd, wrenches)[:, iv])
        rate, second = derivatives(motion.t, twist, at_rest=True)
        q[:, iq], q[:, rotors[0]] = twist, motion.q[:, to_q] - twist
        qd[:, iv], qd[:, rotors[1]] = rate, motion.qd[:, to_v] - rate
        qdd[:, iv], qdd[:, rotors[1]] = second, motion.qdd[:, to_v] - second
    words = motion.source if _WORDS in motion.source else f"{motion.source}{_WORDS}"
    found = replace(motion, q=q, qd=qd, qdd=qdd, source=words, layout=layout(model), pieces=None)
    return rested(model, found)
