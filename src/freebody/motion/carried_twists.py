"""The twists of flexible joints along a motion of the links: each shaft twists by what it carries.

Where the links move as told, what their shafts transmit follows by inverse dynamics, and from it
the twists, by the shafts' springs and dampers; the rotors turn by so much less. The rates of the
twists contain the third derivatives of the links' positions, and the rotors' accelerations the
fourth, so that a motion has to be smooth (De Luca and Book, Robots with flexible elements, 2016).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.errors import listed
from freebody.model.description import Drive
from freebody.model.drives import LAWS
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.model.shafts import Untwisted, least, shaft_entries, shaft_names, untwisted
from freebody.motion.files.measured_motions import rested
from freebody.motion.motion import Motion, derivatives
from freebody.motion.planning.planned import SAMPLES
from freebody.trees.position_rates import layout

SMOOTH = 5
"""The power of time with which a motion whose twists start from rest leaves its start, at least."""
_WORDS = ", shafts twisted by what they carry"
_PASSES = 2
"""The first is exact where springs and dampers are all that acts in shafts."""
_CORNER = 1e-3
"""Share of the largest rate, or third derivative, by which one jumps where it is worth a word."""


class _Shafts:
    """The twists of springs and dampers side by side over time."""

    def __init__(self, model: Model, entries: np.ndarray, t: Array):
        drives = {body.joint.name: body.joint.drive for body in model.bodies}
        own = [drives[model.velocity_names[k]] for k in entries]
        self.numbers = [
            (float(VALUES.quantity(drive.stiffness)), float(VALUES.quantity(drive.viscous)))
            for drive in own
        ]
        self.t = t

    def twists(self, torque: Array) -> Array:
        """The twists (T, n) that torques (T, n) make."""
        columns = [
            self._twist(stiffness, damping, column)
            for (stiffness, damping), column in zip(self.numbers, torque.T, strict=True)
        ]
        return np.stack(columns, axis=-1)

    def _twist(self, stiffness: float, damping: float, torque: Array) -> Array:
        """The twist x (T,) of k x + d x' = torque (T,), a cubic spline over time, exactly; at the
        start as if the torque had changed so before, too."""
        if not damping:
            return torque / stiffness
        curve = CubicSpline(self.t, torque)
        lag = damping / stiffness
        begin, end = (np.zeros(len(self.t) - 1) for _ in range(2))
        for order in range(4):  # a polynomial that obeys the equation between two samples
            part = curve.derivative(order) if order else curve
            factor = (-lag) ** order / stiffness
            begin += factor * part.c[-1]
            end += factor * np.polyval(list(part.c), np.diff(self.t))
        decay = np.exp(-np.diff(self.t) / lag)
        x = np.empty_like(torque)
        x[0] = (torque[0] - lag * curve.c[-2, 0]) / stiffness
        for k in range(len(decay)):
            x[k + 1] = end[k] + decay[k] * (x[k] - begin[k])
        return x


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
    under wrenches (..., six) by frame."""
    q, qd, qdd = rigid.at(motion.q), rigid.at_rates(motion.qd), rigid.at_rates(motion.qdd)
    iq, iv, to_q, to_v = np.array(rigid.twists).T
    rotors = rigid.positions[to_q], rigid.rates[to_v]
    twist, give = np.zeros((len(motion.t), len(iv))), _Shafts(model, iv, motion.t)
    for _ in range(_PASSES):
        twist = twist - give.twists(inverse_dynamics(model, q, qd, qdd, wrenches)[:, iv])
        rate, second = derivatives(motion.t, twist)
        q[:, iq], q[:, rotors[0]] = twist, motion.q[:, to_q] - twist
        qd[:, iv], qd[:, rotors[1]] = rate, motion.qd[:, to_v] - rate
        qdd[:, iv], qdd[:, rotors[1]] = second, motion.qdd[:, to_v] - second
    words = motion.source if _WORDS in motion.source else f"{motion.source}{_WORDS}"
    found = replace(motion, q=q, qd=qd, qdd=qdd, source=words, layout=layout(model), pieces=None)
    return rested(model, found)


# ------------------------------------------------------------ motions that tell of links alone
def tells_links_alone(model: Model, motion: Motion) -> bool:
    """Whether a robot has flexible joints, and no shaft twists along a motion."""
    k = list(shaft_entries(model))
    return bool(k) and not (motion.qd[:, k].any() or motion.qdd[:, k].any())


def carried(
    model: Model, motion: Motion, wrenches: Mapping[str, Array] | None, noisy: bool
) -> Motion:
    """A motion that tells of links alone, its shafts twisted by what they carry, under wrenches
    (..., six) by frame; as it is where that is not known. A notice says which. noisy: whether the
    motion's accelerations are full of noise."""
    rigid, names = untwisted(model), listed(shaft_names(model), 4)
    assert rigid is not None
    if why := _not_known(model, motion, noisy):
        said = f"The twist of the flexible joints' shafts ({names}) stays as it is given: {why}."
        return replace(motion, notices=(*motion.notices, said))
    links = links_alone(rigid, _dense(motion))
    found = with_carried_twists(model, rigid, links, wrenches)
    said = (
        f"Twists of the shafts ({names}): by what they carry, static and inertial, of the links' "
        f"motion; the rotors turn by so much less.",
        *_corners(rigid, motion, found),
    )
    return replace(found, notices=(*motion.notices, *said))


def _not_known(model: Model, motion: Motion, noisy: bool) -> str:
    """Why the twists along a motion of the links are not known; empty where they are."""
    twists = shaft_names(model)
    dry = [b.joint.name for b in model.bodies if b.joint.name in twists and _rubs(b.joint.drive)]
    if model.loops:
        return "what they carry is told of open chains alone, and this one is closed"
    if dry:
        return f"dry friction in {listed(dry, 4)} jumps, and no twist follows it"
    if len(motion.jumps):
        return (
            f"the motion's accelerations jump, first at t = {motion.jumps[0]:.4g} s, and with them "
            f"what the shafts carry, which no twist follows; plan a motion with continuous "
            f"accelerations, such as fb.quintic"
        )
    if noisy:
        return "the motion is too noisy for its derivatives; smooth it (--smooth auto, smooth=True)"
    return ""


def _rubs(drive: Drive) -> bool:
    """Whether a drive has friction that depends on the sign of the rate."""
    return any(least(getattr(drive, law.strength)) != 0.0 for law in LAWS.values() if law.signed)


def _dense(motion: Motion) -> Motion:
    """The motion with as many samples as planned motions have at least, where it is known between
    them exactly."""
    if motion.pieces is None or len(motion.t) >= SAMPLES:
        return motion
    t = np.union1d(motion.t, np.linspace(motion.t[0], motion.t[-1], SAMPLES))
    q, qd, qdd = motion.at(t)
    return replace(motion, t=t, q=q, qd=qd, qdd=qdd)


def _corners(rigid: Untwisted, links: Motion, found: Motion) -> Iterator[str]:
    """A sentence on instants at which the links' motion has a corner in its accelerations, so that
    rotors would have to change their speeds at once."""
    times = []
    twist = np.abs(found.qd[:, [at for _, at, _, _ in rigid.twists]])
    largest = np.abs(found.qd).max(initial=0.0)
    for k in (0, -1):
        still = not found.qd[k, rigid.rates].any() or not rigid.link_rates(links.qd)[k].any()
        if still and twist[k].max() > _CORNER * largest:
            times.append(float(links.t[k]))
    if links.pieces is not None:
        third = links.pieces.derivative(3)
        jump = np.abs(third.coefficients[-1][1:] - third.at_ends[:-1]).max(axis=1)
        corner = jump > _CORNER * np.abs(third.coefficients).max(initial=0.0)
        times += third.breaks[1:-1][corner].tolist()
    if times:
        told = listed((f"{t:.4g}" for t in sorted(times)), 4)
        yield (
            f"At t = {told} s the third derivative of the links' positions jumps, where rotors "
            f"would have to change their speeds at once: there the links follow only nearly."
        )
