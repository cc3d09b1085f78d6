"""Motors and gears in pairs: what a joint asks of each pair, and each limit that a pair must keep.

Everything is computed for all pairs at once, motors along the first axis (M) and gears along the
second (G); one drive is a table of one pair. With N the factor of the gear, the motor gives

    τ_m = (k τ + τ_f) / N + (J_motor + J_gear) N q̈

where τ is what the gear transmits and k = 1/η while the motor drives the joint (τ q̇ > 0), η' while
the joint drives the motor (τ q̇ < 0), and 1 at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.design.parts import Gear, Motor
from freebody.lazy import Keeps, cached_property, kept
from freebody.outputs.number_text import percent
from freebody.trees.position_rates import Index


def motor_torque(
    torque: Array,
    friction: Array,
    speed: Array,
    acceleration: Array,
    factor: Array | float,
    efficiencies: tuple[Array, Array] | tuple[float, float],
    inertia: Array | float,
) -> Array:
    """The motor's torque, N m, of the torque that a gear transmits, the friction on the motor's
    side and the joint's rate and acceleration; arrays that broadcast."""
    through = _drawn(torque, speed, *efficiencies)
    return (through + friction) / factor + inertia * factor * acceleration


def _drawn(torque: Array, speed: Array, forward: Array | float, back: Array | float) -> Array:
    """The torque before the losses of the gear, in units behind it."""
    flow = torque * speed
    return np.where(flow > 0.0, torque / forward, np.where(flow < 0.0, torque * back, torque))


@dataclass(frozen=True, eq=False)
class Demand(Keeps):
    """The load of one joint at all samples, as the masses of the drives that it carries make it.

    shares (C, T): of each cycle's time, for which samples stand. spans: the samples of each cycle.
    torque, friction, speed, acceleration (T,). life: hours that gears have to last. holding: the
    torque that a brake has to hold, N m or N at the joint.
    """

    shares: Array
    spans: Sequence[slice]
    torque: Array
    friction: Array
    speed: Array
    acceleration: Array
    life: float = 0.0
    holding: float = 0.0

    @cached_property
    def peak_torque(self) -> float:
        """The largest torque that the gear transmits."""
        return float(np.abs(self.torque).max())

    @cached_property
    def peak_speed(self) -> float:
        """The largest rate of the joint."""
        return float(np.abs(self.speed).max())

    @cached_property
    def mean_speed(self) -> Array:
        """The mean rate (C,) of the joint, of any sign, rests included."""
        return self.shares @ np.abs(self.speed)

    @cached_property
    def columns(self) -> Array:
        """The torque while the motor drives, the torque while the joint does, what no efficiency
        changes, and the acceleration (4, T): what motors' torques are made of."""
        flow = self.torque * self.speed
        rest = np.where(flow == 0.0, self.torque, 0.0)
        return np.stack(
            [
                np.where(flow > 0.0, self.torque, 0.0),
                np.where(flow < 0.0, self.torque, 0.0),
                rest + self.friction,
                self.acceleration,
            ]
        )

    @cached_property
    def gram(self) -> Array:
        """Mean products (C, 4, 4) of the columns: all that RMS torques need."""
        return self.mean_products(self.columns)

    def mean_products(self, others: Array) -> Array:
        """Mean products (C, 4, k) of the columns with others (k, T), over each cycle."""
        return np.stack(
            [(self.columns[:, at] * share[at]) @ others[:, at].T
             for share, at in zip(self.shares, self.spans, strict=True)]
        )  # fmt: skip

    def mean_torque(self, exponent: float) -> Array:
        """The mean torque (C,) by which a gear of that exponent wears; see `mean_load`."""
        return kept(self, f"_mean_torque_{exponent!r}", self._mean_torque, exponent)

    def _mean_torque(self, exponent: float) -> Array:
        turned, largest = self.mean_speed, self.peak_torque
        if largest == 0.0:
            return np.zeros(len(turned))
        relative = np.abs(self.torque) / largest
        power = relative**3 if exponent == 3.0 else relative**exponent
        worn = self.shares @ (np.abs(self.speed) * power)
        return largest * ratio(worn, turned) ** (1.0 / exponent)


def ratio(used: Array, allowed: Array) -> Array:
    """used/allowed, infinite where something is used and nothing is allowed, 0 where nothing is
    used."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(used > 0.0, used / allowed, 0.0)


class PairTable:
    """All pairs of motors and gears, their numbers as arrays (M, 1), (1, G) or (M, G); what a part
    does not have a limit of is infinite."""

    def __init__(self, motors: Sequence[Motor], gears: Sequence[Gear]):
        self.motors, self.gears = tuple(motors), tuple(gears)
        self.max_speed = _column(self.motors, "max_speed")
        self.continuous = _column(self.motors, "continuous_torque")
        brakes = [[motor.brake_torque or 0.0] for motor in self.motors]
        self.brake = np.array(brakes)
        self.factor = np.array([[gear.factor for gear in self.gears]])
        efficiencies = np.array([gear.efficiencies for gear in self.gears]).reshape(-1, 2)
        self.forward, self.back = efficiencies.T[:, None]
        self.inertia = _column(self.motors, "inertia") + _column(self.gears, "inertia").T
        self.mass = _column(self.motors, "mass") + _column(self.gears, "mass").T
        self.price = _column(self.motors, "price") + _column(self.gears, "price").T
        self.gear_peak = _column(self.gears, "peak_torque").T
        self.gear_mean = _column(self.gears, "average_torque").T
        self.gear_speed = _column(self.gears, "max_speed").T
        self.gear_mean_speed = _column(self.gears, "average_speed").T
        self.exponents = np.array([gear.life_exponent or 3.0 for gear in self.gears])
        self.rated_torque = _column(self.gears, "rated_torque").T
        # turns that a gear makes at its rated torque, where it is rated
        self.rated_turns = (
            _column(self.gears, "rated_life").T * _column(self.gears, "rated_speed").T
        )
        self.fits = np.array(
            [[not g.fits or m.name in g.fits for g in self.gears] for m in self.motors]
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Number of motors, number of gears."""
        return len(self.motors), len(self.gears)

    def taken(self, motors: Index, gears: Index) -> PairTable:
        """The pairs of some of the motors with some of the gears."""
        parts = {"motors": (self.motors, motors), "gears": (self.gears, gears)}
        taken: dict[str, object] = {
            name: tuple(every[k] for k in at) for name, (every, at) in parts.items()
        }
        taken["exponents"] = self.exponents[gears]
        for name, value in vars(self).items():
            if name not in taken:
                rows = value[motors] if len(value) == len(self.motors) else value
                taken[name] = rows[:, gears] if rows.shape[1] == len(self.gears) else rows
        found = copy(self)
        vars(found).update(taken)
        return found

    def torques(self, demand: Demand, at: Index) -> Array:
        """The torques (k, M, G) of all motors at the samples `at` (k,)."""
        return self.through_gears(demand, at)[:, None, :] + self.of_rotors(demand, at)

    def through_gears(self, demand: Demand, at: Index) -> Array:
        """The parts (k, G) of motors' torques that gears ask for at the samples `at` (k,)."""
        torque, friction, speed = (
            x[at][:, None] for x in (demand.torque, demand.friction, demand.speed)
        )
        return (_drawn(torque, speed, self.forward, self.back) + friction) / self.factor

    def of_rotors(self, demand: Demand, at: Index) -> Array:
        """The parts (k, M, G) of motors' torques that speed up rotors and gears."""
        return self.inertia * (self.factor * demand.acceleration[at][:, None])[:, None, :]

    def allowed(self, speed: Array) -> Array:
        """The peak torques (k, M, G) of all motors at rates (k,) of the joint."""
        at = np.abs(speed)[:, None] * self.factor
        return np.stack([_told(motor, at, motor.peak_at(at)) for motor in self.motors], axis=1)

    def peak_use(self, demand: Demand, at: Index, allowed: Array | None = None) -> Array:
        """The largest share (M, G) of the peak torque at the samples `at` (k,); allowed: what
        `allowed` says of them, where it is known."""
        limit = self.allowed(demand.speed[at]) if allowed is None else allowed
        return ratio(np.abs(self.torques(demand, at)), limit).max(axis=0, initial=0.0)

    def whole_peak_use(self, demand: Demand) -> Array:
        """The largest share (M, G) of the peak torque at any sample."""
        found = np.zeros(self.shape)
        for start in range(0, len(demand.torque), _BLOCK):
            at = np.arange(start, min(start + _BLOCK, len(demand.torque)))
            np.maximum(found, self.peak_use(demand, at), out=found)
        return found

    def peak_of(self, demand: Demand, m: int, g: int) -> tuple[float, int]:
        """The largest share of the peak torque of one pair at any sample, and which."""
        motor, gear = self.motors[m], self.gears[g]
        torque = motor_torque(
            demand.torque, demand.friction, demand.speed, demand.acceleration,
            gear.factor, gear.efficiencies, motor.inertia + gear.inertia,
        )  # fmt: skip
        speed = demand.speed * gear.factor
        use = ratio(np.abs(torque), _told(motor, speed, motor.peak_at(speed)))
        worst = int(np.argmax(use))
        return float(use[worst]), worst

    @property
    def _shares(self) -> Array:
        """The shares (3, G) that motors feel of the first three of a demand's columns."""
        N = self.factor[0]
        return np.stack([1.0 / (self.forward[0] * N), self.back[0] / N, 1.0 / N])

    def mean_products(self, demand: Demand, other: Array) -> Array:
        """The mean products (C, M, G) of the torques of all motors with something else (T,)."""
        means = demand.mean_products(other[None])[:, :, 0]
        gears = (means[:, :3] @ self._shares)[:, None]
        return gears + self.inertia * self.factor * means[:, 3, None, None]

    def mean_squares(self, demand: Demand) -> Array:
        """The mean squares (C, M, G) of the torques of all motors."""
        N, gear = self.factor[0], self._shares
        G = demand.gram
        a = np.einsum("ig,cij,jg->cg", gear, G[:, :3, :3], gear)
        b = 2.0 * (G[:, :3, 3] @ gear) * N
        c = G[:, 3, 3][:, None] * N**2
        found = self.inertia * c[:, None]
        found += b[:, None]
        found *= self.inertia
        found += a[:, None]
        return np.maximum(found, 0.0, out=found)


def _told(motor: Motor, speed: Array, torque: Array) -> Array:
    """The torques (...) that a motor gives at speeds (...), infinite beyond its top speed: what is
    exceeded there is the limit of speed, and no torque mends it."""
    return np.where(np.abs(speed) > motor.max_speed * (1.0 + _ROUNDING), np.inf, torque)


_ROUNDING = 1e-12

_BLOCK = 64


def _column(parts: Sequence[Motor | Gear], name: str) -> Array:
    given = (getattr(part, name) for part in parts)
    return np.array([[np.inf if x is None else x] for x in given], dtype=float)


@dataclass(frozen=True)
class DriveLimit:
    """A limit of motors or gears: its name, which part has it by which of its numbers, what is used
    of it in words, the share (M, G) that is used of it, whether a demand asks for it at all, and
    whether parts that do not give it then fail."""

    name: str
    part: str
    number: str
    words: str
    use: Callable[[Demand, PairTable], Array]
    asked: Callable[[Demand], bool] = lambda demand: True
    needed: bool = False

    def given(self, motor: Motor, gear: Gear) -> bool:
        """Whether a pair gives the limit."""
        return getattr(motor if self.part == "motor" else gear, self.number) is not None

    def checks(self, motor: Motor, gear: Gear) -> bool:
        """Whether the limit is one of the pair: that it gives, or lacks where it is needed."""
        return self.needed or self.given(motor, gear)


def continuous_use(demand: Demand, pairs: PairTable, squares: Array) -> Array:
    """The share (M, G) of the continuous torque, of mean squares (C, M, G) of motors' torques."""
    if not any(motor.continuous_curve for motor in pairs.motors):
        return np.sqrt(squares.max(axis=0)) / pairs.continuous
    speed = demand.mean_speed[:, None] * pairs.factor
    allowed = np.stack(
        [_told(motor, speed, motor.continuous_at(speed)) for motor in pairs.motors], axis=1
    )
    return ratio(np.sqrt(squares), allowed).max(axis=0)


def _mean_torques(demand: Demand, pairs: PairTable) -> Array:
    """The mean torques (C, G) by which gears wear."""
    values, which = np.unique(pairs.exponents, return_inverse=True)
    return np.stack([demand.mean_torque(float(p)) for p in values], axis=-1)[:, which]


def _gear_life(demand: Demand, pairs: PairTable) -> Array:
    """The mean torque over that at which the gear lasts as long as it has to."""
    turns = demand.life * demand.mean_speed[:, None] * pairs.factor / pairs.rated_turns
    worn = _mean_torques(demand, pairs) / pairs.rated_torque * turns ** (1.0 / pairs.exponents)
    return worn.max(axis=0)[None]


def gear_lives(demand: Demand, gear: Gear) -> Array:
    """The life (C,) of a gear in h, were it to go through one cycle alone; NaN where it is not
    rated."""
    means = demand.mean_torque(gear.life_exponent or 3.0)
    return np.array(
        [gear.life(T, n * gear.factor) for T, n in zip(means, demand.mean_speed, strict=True)]
    )


def holding_torque(motor: Motor, gear: Gear) -> float:
    """The torque (N m, of a slide N) that a motor's brake holds at its joint, through the gear as
    at rest: what the gear loses then is not counted on. 0 without a brake."""
    return (motor.brake_torque or 0.0) * gear.factor


def _brake(demand: Demand, pairs: PairTable) -> Array:
    return ratio(np.array([[demand.holding]]), pairs.brake * pairs.factor)


LIMITS: tuple[DriveLimit, ...] = (
    DriveLimit("speed", "motor", "max_speed", "top speed",
          lambda d, p: d.peak_speed * p.factor / p.max_speed),
    DriveLimit("peak torque", "motor", "peak_torque", "peak torque at its speed",
          lambda d, p: p.whole_peak_use(d)),
    DriveLimit("continuous torque", "motor", "continuous_torque", "RMS torque",
          lambda d, p: continuous_use(d, p, p.mean_squares(d))),
    DriveLimit("gear torque", "gear", "peak_torque", "torque at starts and stops",
          lambda d, p: d.peak_torque / p.gear_peak),
    DriveLimit("gear mean torque", "gear", "average_torque", "mean torque",
          lambda d, p: _mean_torques(d, p).max(axis=0) / p.gear_mean),
    DriveLimit("gear speed", "gear", "max_speed", "input speed",
          lambda d, p: d.peak_speed * p.factor / p.gear_speed),
    DriveLimit("gear mean speed", "gear", "average_speed", "mean input speed",
          lambda d, p: d.mean_speed.max() * p.factor / p.gear_mean_speed),
    DriveLimit("gear life", "gear", "rated_life", "torque for its life", _gear_life,
          lambda demand: demand.life > 0.0),
    DriveLimit("brake", "motor", "brake_torque", "holding torque", _brake,
          lambda demand: demand.holding > 0.0, needed=True),
)  # fmt: skip
"""All limits that a pair must keep; a new one is a line here."""


def margin_of(share: float) -> float:
    """The ratio of what is allowed to what is used, infinite where nothing is used."""
    return 1.0 / share if share > 0.0 else np.inf


def used(share: float) -> str:
    """How much is used of a limit, infinite where a part gives nothing of what is needed."""
    return "beyond it" if np.isinf(share) else percent(share)


def used_of(share: float, limit: str) -> str:
    """How much is used of a limit that is called so, such as 'its brake'."""
    return f"more than {limit}" if np.isinf(share) else f"{percent(share)} of {limit}"


PEAK, CONTINUOUS = (
    [limit.name for limit in LIMITS].index(name) for name in ("peak torque", "continuous torque")
)


def uses(demand: Demand, pairs: PairTable, known: Mapping[int, Array] | None = None) -> Array:
    """The share (limits, M, G) that each pair uses of each of `LIMITS`, infinite where motor and
    gear do not fit; known: shares of some limits, by their number."""
    found = np.empty((len(LIMITS), *pairs.shape))
    for k, limit in enumerate(LIMITS):
        if not limit.asked(demand):
            found[k] = 0.0
        else:
            found[k] = known[k] if known and k in known else limit.use(demand, pairs)
    found[:, ~pairs.fits] = np.inf
    return found
