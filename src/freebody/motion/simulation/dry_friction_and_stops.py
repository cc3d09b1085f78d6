"""Dry friction that sticks and stops at the limits of joints: which coordinates are held, and how a
stop turns a motion back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, listed
from freebody.model.model import Model
from freebody.motion.ranges import Flags, position_columns, ranges
from freebody.motion.smooth_friction import refuse_bent, sticking_friction
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import Index

if TYPE_CHECKING:
    from freebody.motion.simulation.prepared_simulation import MotionLanes, Some

REST = 1e-5
"""rad/s or m/s: slower than this no stop turns a motion back."""
_ROUND = 1e-13  # of the largest change: a change that only rounding makes
_TURNS = 50  # per coordinate: choices of what is held, of which a few are enough


class Contact(NamedTuple):
    """The result of contact at joints: flags of held coordinates (..., nv), torques that push in
    addition (..., nv), and accelerations (..., nv)."""

    held: Flags
    push: Array
    qdd: Array


@dataclass(frozen=True, eq=False)
class JointContacts:
    """Dry friction and stops of motions, one row for all or one each (..., nv): the most that
    friction holds at rest, position limits (infinite without stops), and the fraction of speed that
    each stop returns.

    robot: with its friction. dry: whether that sticks. place (nv,): the entry of q that is a
    coordinate's position.
    """

    robot: Model
    dry: bool
    grip: Array
    lower: Array
    upper: Array
    restitution: Array
    place: Index

    def lanes(self, lanes: MotionLanes) -> JointContacts:
        """Friction and stops with a row for each of the given motions of a batch."""
        shape = (lanes.count, len(self.place))
        return self._each(lambda x: np.broadcast_to(lanes.each(x, 1), shape))

    def repeated(self, times: int) -> JointContacts:
        """Friction and stops with the rows (n, nv) repeated, one copy after the other."""
        return self._each(lambda x: np.broadcast_to(x, (times, *x.shape)).reshape(-1, x.shape[-1]))

    def some(self, which: Some) -> JointContacts:
        """Friction and stops of selected motions."""
        return self._each(lambda x: x[which])

    def _each(self, change: Callable[[Array], Array]) -> JointContacts:
        given = map(change, (self.grip, self.lower, self.upper, self.restitution))
        return JointContacts(self.robot, self.dry, *given, place=self.place)

    @property
    def jumps(self) -> Flags:
        """Flags of the coordinates whose friction depends on the sign of the rate."""
        return self.grip > 0.0

    def positions(self, q: Array) -> Array:
        """The entries of q (..., nq) that may have stops."""
        return q[..., self.place]

    def at_stops(self, q: Array) -> tuple[Flags, Flags]:
        """Flags of the coordinates at their lower and at their upper stop."""
        x = self.positions(q)
        return x <= self.lower, x >= self.upper

    def bounds(self, q: Array) -> tuple[Array, Array]:
        """The lowest and the highest torque that hold each coordinate at rest: friction resists
        both ways, a stop pushes inward with any force."""
        below, above = self.at_stops(q)
        return np.where(above, -np.inf, -self.grip), np.where(below, np.inf, self.grip)

    def resting(self, q: Array, qd: Array) -> Flags:
        """Flags of the coordinates that are at rest and may be held, by dry friction or by a
        stop."""
        below, above = self.at_stops(q)
        return (qd == 0.0) & ((self.grip > 0.0) | below | above)

    def hitting(self, q: Array, qd: Array) -> Flags:
        """Flags of the coordinates at a stop that move on into it."""
        below, above = self.at_stops(q)
        return (below & (qd < 0.0)) | (above & (qd > 0.0))

    def contact(self, q: Array, qd: Array, M: Array, forces: Array, drag: Array) -> Contact:
        """The contacts in states (n, ...), given the forces (n, nv) other than dry friction, of
        size drag (n, nv), and stops.

        A coordinate at rest stays there where friction and stop can hold it, together with all
        others; else it begins to move, against its friction. Of moving ones friction resists.
        """
        push = -drag * np.sign(qd)
        found = complementary(M, forces + push, self.resting(q, qd), *self.bounds(q))
        return Contact(found.held, push + found.push, found.qdd)

    def rebound(self, q: Array, qd: Array, M: Array) -> Array:
        """Rates after impacts (n, nv): a coordinate that moves into its stop moves back with the
        share `restitution` of its speed, or not at all where it is slower than `REST`; the others
        change as the impulses of the stops demand, M (q̇₁ - q̇) = impulses, against which dry
        friction, which is bounded, can do nothing.

        Where one impact makes others, none of their stops lets a coordinate through (Newton's law
        of impact for several contacts, after Moreau 1988).
        """
        below, above = self.at_stops(q)
        touching = (below & (qd <= 0.0)) | (above & (qd >= 0.0))
        back = np.where(touching & (np.abs(qd) > REST), self.restitution * qd, 0.0)
        least, most = np.where(above, -np.inf, 0.0), np.where(below, np.inf, 0.0)
        momentum = np.einsum("...ij,...j->...i", M, qd + back)
        after = complementary(M, momentum, touching, least, most).qdd - back
        changed = np.abs(after - qd)
        nothing = changed <= _ROUND * changed.max(axis=-1, keepdims=True)
        return np.where(nothing, qd, after)


def joint_contacts(model: Model, dry: bool, restitution: Array | None) -> JointContacts:
    """The dry friction and stops of a model, for a family (*family, nv) each; dry: whether friction
    sticks."""
    nv, friction = model.nv, sticking_friction(model)[1]
    if dry:
        refuse_bent("simulate", model, lambda law: law.grips, "use friction='smooth'")
    grip = friction.grip(model.family) if dry else np.zeros((*model.family, nv))
    iq, iv = position_columns(model)
    place = np.zeros(nv, dtype=int)
    place[iv] = iq
    if restitution is None:
        free = np.full(nv, np.inf)
        return JointContacts(model, dry, grip, -free, free, np.zeros(nv), place)
    return JointContacts(model, dry, grip, *_stops(model), restitution, place)


def _stops(model: Model) -> tuple[Array, Array]:
    """Positions of the lower and upper stops: the limits of the joints, those of followers
    included."""
    if model.family:
        if any(body.joint.mimic is not None for body in model.bodies):
            raise FreebodyError(
                f"simulate: restitution= needs the stops of {model.name!r}, a family whose joints "
                f"follow others; simulate its members, model[0], …, one by one."
            )
        lower, upper = model.limits.lower, model.limits.upper
        none = lower == upper
        return np.where(none, -np.inf, lower), np.where(none, np.inf, upper)
    found = ranges(model)
    if found.apart:
        raise FreebodyError(
            f"simulate: restitution= needs stops that leave room to move; the range of "
            f"{listed(found.apart)} has nothing in common with that of the joint it follows."
        )
    return found.lower, found.upper


def refuse_beyond(model: Model, contacts: JointContacts, q: Array) -> None:
    """Refuse a start (..., nq) beyond a stop."""
    x = contacts.positions(q)
    x, lower, upper = np.broadcast_arrays(x, contacts.lower, contacts.upper)
    beyond = np.argwhere((x < lower) | (x > upper))
    if len(beyond):
        *sample, k = map(int, beyond[0])
        here = (*sample, k)
        side, stop = ("above", upper[here]) if x[here] > upper[here] else ("below", lower[here])
        at, limit = compared(float(x[here]), float(stop), digits=6)
        raise FreebodyError(
            f"simulate: q is {at} for {model.velocity_names[k]!r}{at_sample(sample)}, {side} its "
            f"limit {limit}, where restitution= puts a stop: start within the limits, change them "
            f"(model.bind), or leave restitution= out."
        )


def complementary(M: Array, forces: Array, candidates: Flags, least: Array, most: Array) -> Contact:
    """The contact at joints that may be held (`candidates`): accelerations, or rates after an
    impact, x (n, nv) with M x = forces + push.

    A candidate has x = 0 and a push between least and most, or x above 0 and push = least, or x
    below 0 and push = most; all other coordinates have no push.

    M being positive definite there is one such x. All candidates are held at first; as long as
    something is wrong, the first that is wrong changes: what is held too hard is let go, what moves
    along its push is held (least-index pivoting; Murty 1974, for bounds Judice and Pires 1992).
    """
    held, push = candidates.copy(), np.zeros(forces.shape)
    x, lacking = _solved(M, forces, held)
    wrong = np.arange(len(x))
    for _ in range(_TURNS * x.shape[-1] + 1):
        own, h = x[wrong], held[wrong]
        low = h & (lacking[wrong] < least[wrong])
        high = h & (lacking[wrong] > most[wrong])
        turned = candidates[wrong] & ~h & ((push[wrong] == least[wrong]) & (own < 0.0))
        turned |= candidates[wrong] & ~h & ((push[wrong] == most[wrong]) & (own > 0.0))
        any_ = low | high | turned
        rows = np.flatnonzero(any_.any(axis=-1))
        if not len(rows):
            break
        first = any_[rows].argmax(axis=-1)
        wrong, low, high = wrong[rows], low[rows, first], high[rows, first]
        held[wrong, first] = ~(low | high)
        push[wrong, first] = np.where(low, least[wrong, first], 0.0)
        push[wrong, first] += np.where(high, most[wrong, first], 0.0)
        x[wrong], lacking[wrong] = _solved(M[wrong], forces[wrong] + push[wrong], held[wrong])
    return Contact(held, push, x)


def _solved(M: Array, forces: Array, held: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The solution x with x = 0 for held coordinates and M x = forces in the rows of the others,
    and the residual M x - forces in the rows of held ones."""
    free = (~held).astype(float)
    reduced = M * free[..., :, None] * free[..., None, :]
    reduced += held[..., :, None] * np.eye(M.shape[-1])
    x = np.linalg.solve(reduced, (free * forces)[..., None])[..., 0]
    x = np.where(held, 0.0, x)
    return x, np.where(held, np.einsum("...ij,...j->...i", M, x) - forces, 0.0)
