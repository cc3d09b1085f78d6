"""The limits of payloads, a limit a line: of drives, joints that follow others, brakes, bearings.

At given positions, rates and accelerations every load of a joint is affine in the mass of a
payload of given shape and place, F₀ + m F₁: F₁ is what a kilogram adds. What a limit is compared
with is the size of such a load, or a sum of sizes with weights: the torque at a joint, the tilting
moment on its bearing, the static equivalent load |F_r| + 2/d |M| + 0.44 |F_a|. The sum of sizes is
convex in m. So the masses that are carried are an interval, whose end is a root: of one size in
closed form, of several by Newton's method from above, which comes down to it without passing it.

A drive gives in addition what friction and rotor take, which no mass changes, and what the gear
loses of what it transmits, a part that depends on the way of the power alone. So its torque rises
or falls with m all the way, and the mass at its limit has a closed form too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.capacity.fitted_parts import BEARING_LIMITS, BearingLimit
from freebody.capacity.loaded_case import AffineLoad, CaseAtStates, LoadedCase, without_rounding
from freebody.errors import listed
from freebody.model.losses import lossy_joints
from freebody.motion.ranges import CLOSE
from freebody.motion.smooth_friction import lost_torque, motor_springs, rotor_torque

Reached = tuple[Array, np.ndarray]
"""Masses (T, n) at which limits are reached, and whether they are exceeded without payload."""


class LimitedPart(NamedTuple):
    """A part that has a limit: the name of its joint, the name of its limit in `PAYLOAD_LIMITS`,
    and words for the part, unlike those of any other."""

    joint: str
    limit: str
    words: str


@dataclass(frozen=True)
class PayloadLimit:
    """A limit of payloads: its name, what kind of part has it, what is said of one beyond it
    without payload, which parts of a case have it, as pairs (joint, words), and the masses at which
    they reach it at states."""

    name: str
    what: str
    beyond: str
    parts: Callable[[LoadedCase], Sequence[tuple[str, str]]]
    reached: Callable[[CaseAtStates], Reached]


def limited_parts(case: LoadedCase) -> tuple[LimitedPart, ...]:
    """All that may limit a payload: the coordinates, then what has the other limits (K in all)."""
    return tuple(
        LimitedPart(joint, limit.name, words)
        for limit in PAYLOAD_LIMITS
        for joint, words in limit.parts(case)
    )


def reached(at: CaseAtStates) -> Reached:
    """(masses (T, K) at which each part reaches its limit, 0 where it exceeds it without, infinite
    where a mass changes nothing; whether it exceeds it without)."""
    found = [limit.reached(at) for limit in PAYLOAD_LIMITS if limit.parts(at.case)]
    mass, over = (np.concatenate(x, axis=-1) for x in zip(*found, strict=True))
    return mass, over


# ------------------------------------------------------------ drives
def _coordinates(case: LoadedCase) -> list[tuple[str, str]]:
    return [(name, name) for name in case.model.velocity_names]


def _of_drives(at: CaseAtStates) -> Reached:
    case, (q, qd, qdd) = at.case, at.states
    model, carrying = case.model, case.carrying
    tau = inverse_dynamics(model, q, qd, qdd, case.wrenches)
    lossy = bool(lossy_joints(model.bodies))
    whole, sent, rest = tau, tau, np.zeros_like(tau)
    if lossy:
        bare, carrying = model.without("friction"), carrying.without("friction")
        whole = inverse_dynamics(bare, q, qd, qdd, case.wrenches)
        sent = whole - rotor_torque(model, q, qd, qdd) - motor_springs(model, q, qd)
        rest = tau - sent - lost_torque(model, qd, sent)
    slope = without_rounding(inverse_dynamics(carrying, q, qd, qdd, case.wrenches) - whole, whole)
    limited = np.isfinite(case.effort)
    most = np.sign(slope) * np.where(limited, case.effort, 0.0) - rest
    if lossy:  # of what is transmitted at the limit, by the way of its power
        lost = lost_torque(model, qd, most)
        most = most / (1.0 + lost / np.where(most == 0.0, 1.0, most))
    with np.errstate(divide="ignore", invalid="ignore"):
        mass = np.where(slope == 0.0, np.inf, (most - sent) / slope)
    over = limited & (np.abs(tau) > case.effort * (1.0 + CLOSE))
    mass = np.where(limited, np.maximum(mass, 0.0), np.inf)
    return np.where(over, 0.0, mass), over


# ------------------------------------------------------------ followers
def _followers(case: LoadedCase) -> list[tuple[str, str]]:
    return [] if case.followers is None else [(name, name) for name in case.followers[0].names]


def _of_followers(at: CaseAtStates) -> Reached:
    assert at.case.followers is not None
    (bare, loaded), loads = at.case.followers, at.case.wrenches
    torque = AffineLoad.between(*(x.torques(*at.states, loads)[..., None] for x in (bare, loaded)))
    return masses_within([(1.0, torque)], bare.limits)


# ------------------------------------------------------------ brakes
def _brakes(case: LoadedCase) -> list[tuple[str, str]]:
    return [(x.joint, f"brake of {x.joint} ({x.part})") for x in case.parts.brakes]


def _of_brakes(at: CaseAtStates) -> Reached:
    brakes = at.case.parts.brakes
    columns, limits = [x.column for x in brakes], np.array([x.limit for x in brakes])
    found = [masses_within([(1.0, load.at(columns))], limits) for load in at.held]
    mass, over = zip(*found, strict=True)
    return np.min(mass, axis=0), np.any(over, axis=0)


# ------------------------------------------------------------ bearings
def _bearings(limit: BearingLimit) -> Callable[[LoadedCase], list[tuple[str, str]]]:
    def parts(case: LoadedCase) -> list[tuple[str, str]]:
        return [
            (x.joint, f"{limit.name} on the bearing of {x.joint} ({x.bearing.name})")
            for x in limit.of(case.parts.bearings).fitted
        ]

    return parts


def _of_bearings(limit: BearingLimit) -> Callable[[CaseAtStates], Reached]:
    def reached(at: CaseAtStates) -> Reached:
        these = limit.of(at.case.parts.bearings)
        terms = zip(these.weights.T, at.on_bearings, strict=True)
        return masses_within([(w, x.at(these.places)) for w, x in terms if w.any()], these.limits)

    return reached


_EFFORT, _BEARING = ("effort", "effort limit"), "bearing"
_WEAK, _LARGE = "is overloaded already", "is too large already"

PAYLOAD_LIMITS: tuple[PayloadLimit, ...] = (
    PayloadLimit(*_EFFORT, _WEAK, _coordinates, _of_drives),
    PayloadLimit(*_EFFORT, _WEAK, _followers, _of_followers),
    PayloadLimit("brake", "brake", _WEAK, _brakes, _of_brakes),
    *(PayloadLimit(limit.name, _BEARING, _LARGE, _bearings(limit), _of_bearings(limit))
      for limit in BEARING_LIMITS),
)  # fmt: skip
"""All limits of payloads; a new one is a line here."""

LIMIT_OF_NAME = {limit.name: limit for limit in PAYLOAD_LIMITS}
"""A limit of each name; those of one name have the same words."""


def by_limits(names: Iterable[str]) -> str:
    """Words on what judges a payload where limits of these names do: 'by its effort limits and
    brakes'."""
    kinds = dict.fromkeys(LIMIT_OF_NAME[name].what for name in names)
    return f"by its {listed(f'{kind}s' for kind in kinds)}"


# ------------------------------------------------------------ the mass at a limit
_Terms = Sequence[tuple[Array | float, AffineLoad]]
"""Weights (n,), each with a load (T, n, d)."""
_STEPS = 100


def masses_within(terms: _Terms, limits: Array) -> Reached:
    """(the masses (T, n) at which sums of sizes with weights reach limits (n,), 0 where they exceed
    them without payload, infinite where they never do; whether they exceed them without)."""
    finite = np.isfinite(limits)
    limit = np.where(finite, limits, 1.0)
    over = finite & (_total(terms, 0.0)[0] > limit * (1.0 + CLOSE))
    mass = np.min([_alone(load, limit / weight) for weight, load in terms], axis=0)
    if len(terms) > 1:
        mass = _from_above(terms, limit, mass)
    return np.where(over, 0.0, np.where(finite, mass, np.inf)), over


def _alone(load: AffineLoad, limit: Array) -> Array:
    """The largest mass (T, n) at which the size |F₀ + m F₁| of a load alone is at its limit (n,): a
    root of a quadratic, in the form that loses no digits. Infinite where no mass changes it."""
    bare, slope = load.bare, load.slope
    a, b = (slope**2).sum(axis=-1), (bare * slope).sum(axis=-1)
    size = np.linalg.norm(bare, axis=-1)
    left = np.maximum((limit - size) * (limit + size), 0.0)
    root = np.sqrt(b**2 + a * left)
    with np.errstate(divide="ignore", invalid="ignore"):
        mass = np.where(b > 0.0, left / (b + root), (root - b) / a)
    return np.where(a == 0.0, np.inf, mass)


def _from_above(terms: _Terms, limit: Array, start: Array) -> Array:
    """The mass (T, n) at which the sum is at its limit, from masses at which it is beyond: those at
    which one size alone is at it."""
    free = np.isinf(start)
    mass = np.where(free, 0.0, start)
    for _ in range(_STEPS):
        total, slope = _total(terms, mass)
        rises = ~free & (total > limit) & (slope > 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            lower = np.where(rises, np.maximum(mass - (total - limit) / slope, 0.0), mass)
        if (mass - lower <= _SAME * mass).all():
            break
        mass = lower
    return np.where(free, np.inf, mass)


_SAME = 4.0 * np.finfo(float).eps
"""Share of a mass by which rounding moves it."""


def _total(terms: _Terms, mass: Array | float) -> tuple[Array, Array]:
    """The sum (T, n) of sizes with weights at masses (T, n), and its slope."""
    total, slope = np.zeros(()), np.zeros(())
    for weight, load in terms:
        vector = load.bare + np.asarray(mass)[..., None] * load.slope
        size = np.linalg.norm(vector, axis=-1)
        along = (vector * load.slope).sum(axis=-1)
        total = total + weight * size
        slope = slope + weight * np.divide(along, size, out=np.zeros_like(size), where=size > 0.0)
    return total, slope
