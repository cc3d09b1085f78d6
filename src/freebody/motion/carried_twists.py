"""The twists of flexible joints along a motion of the links: each shaft twists by what it carries.

Where the links move as told, what their shafts transmit follows by inverse dynamics, and from it
the twists, by the shafts' springs and dampers; the rotors turn by so much less. The rates of the
twists contain the third derivatives of the links' positions, and the rotors' accelerations the
fourth, so that a motion has to be smooth (De Luca and Book, Robots with flexible elements, 2016).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.shafts import Untwisted
from freebody.motion.files.measured_motions import rested
from freebody.motion.motion import Motion, derivatives
from freebody.trees.position_rates import layout

SMOOTH = 5
"""The power of time with which a motion whose twists start from rest leaves its start, at least."""
_WORDS = ", shafts twisted by what they carry"
_PASSES = 12
_SETTLED = 1e-9
"""Share of the torques of shafts that may be left at them."""


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
    springs = {body.joint.name: body.joint.drive.stiffness for body in model.bodies}
    stiffness = np.array([springs[model.velocity_names[k]] for k in iv], dtype=float)
    twist = np.zeros((len(motion.t), len(iv)))
    most = 0.0
    for _ in range(_PASSES):
        missing = inverse_dynamics(model, q, qd, qdd, wrenches)[:, iv]
        most = max(most, float(np.abs(missing).max()))
        if np.abs(missing).max() <= _SETTLED * most:
            break
        twist = twist - missing / stiffness
        found = (twist, *derivatives(motion.t, twist, at_rest=True))
        links = (motion.q, motion.qd, motion.qdd)
        for x, own, link, at, of, to in zip(
            (q, qd, qdd), found, links, (iq, iv, iv), (rotors[0], rotors[1], rotors[1]),
            (to_q, to_v, to_v), strict=True,
        ):  # fmt: skip
            x[:, at], x[:, of] = own, link[:, to] - own
    words = motion.source if _WORDS in motion.source else f"{motion.source}{_WORDS}"
    found = replace(motion, q=q, qd=qd, qdd=qdd, source=words, layout=layout(model), pieces=None)
    return rested(model, found)
