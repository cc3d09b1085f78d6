"""Margins of pairs of motors and gears at each joint of a robot, for given drives that the joint
carries, and at best for drives of masses in a range.

The share of peak torque, which needs every sample, is first taken at the few samples that were the
worst of some pair, which is never too much; what is chosen is then looked at everywhere, and where
it was worse elsewhere, that sample is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.design.bounds import MassRange, least_uses
from freebody.design.catalogue import PartCatalogue
from freebody.design.choices import PartialChoice
from freebody.design.drive_loads import demand_of, refuse_no_gear
from freebody.design.loads import CycleLoads, DriveJoint, RestLoads
from freebody.design.pairs import PEAK, Demand, PairTable, uses
from freebody.motion.ranges import Flags
from freebody.trees.position_rates import Index

_SAME = 1e-12
_ROUNDING = 1e-9
_LEAST = 1e-300
_KEPT = 16
"""Margins that are kept for each joint, by the drives that it carries."""


def pairs_for(catalogue: PartCatalogue, joint: DriveJoint) -> PairTable:
    """The pairs of a catalogue for a joint; FreebodyError where no gear suits it."""
    return PairTable(catalogue.motors, refuse_no_gear("size", joint, catalogue.gears))


class PairMargins:
    """The margins of all pairs of one catalogue at all joints; each joint has its pairs and the
    samples that were the worst of some."""

    def __init__(
        self, loads: CycleLoads, rest: RestLoads | None, catalogue: PartCatalogue, life: float
    ):
        self.loads, self.rest, self.life = loads, rest, life
        tables: dict[bool, PairTable] = {}
        for joint in loads.joints:
            if joint.turns not in tables:
                tables[joint.turns] = pairs_for(catalogue, joint)
        self.pairs = [tables[joint.turns] for joint in loads.joints]
        self.priced = all(np.isfinite(pairs.price).all() for pairs in tables.values())
        self.price = {k: x.price if self.priced else 0.0 * x.mass for k, x in enumerate(self.pairs)}
        self.worst: list[Index] = [self._first_samples(k) for k in range(len(loads.joints))]
        self.allowed = [
            pairs.allowed(loads.speed[at, k])
            for k, (pairs, at) in enumerate(zip(self.pairs, self.worst, strict=True))
        ]
        self._kept: list[dict[Any, Array]] = [{} for _ in loads.joints]

    def _first_samples(self, k: int) -> Index:
        """Samples that are the worst of a few pairs far apart, without drives."""
        demand, pairs = self._demand(k, np.zeros(len(self.loads.joints))), self.pairs[k]
        gears = np.argsort(pairs.factor[0])[[0, len(pairs.gears) // 2, -1]]
        motors = np.argsort([motor.inertia for motor in pairs.motors])[
            [0, len(pairs.motors) // 2, -1]
        ]
        found = {pairs.peak_of(demand, m, g)[1] for m in motors for g in gears}
        for size in (demand.torque, demand.speed, demand.acceleration):
            found.add(int(np.argmax(np.abs(size))))
        return np.array(sorted(found), dtype=np.intp)

    def _demand(self, k: int, masses: Array) -> Demand:
        return demand_of(self.loads, k, masses, self.life, self.rest)

    def carried(self, k: int, masses: Array) -> Array:
        """The masses (n,) of those drives that joint k carries, 0 of the others."""
        return masses * self.loads.burdens[:, k]

    def margins(self, k: int, masses: Array, among: Flags | None = None) -> Array:
        """The margin (M, G) of each pair of joint k with drives of masses (n,), at most too large;
        among: those that are asked for, others have 0."""
        carried, kept = self.carried(k, masses), self._kept[k]
        key = carried.tobytes(), len(self.worst[k])
        if key in kept:
            return kept[key] if among is None else np.where(among, kept[key], 0.0)
        demand, (pairs, allowed, at) = self._demand(k, carried), self._part(k, among)
        peak = pairs.peak_use(demand, self.worst[k], allowed)
        found = 1.0 / np.maximum(uses(demand, pairs, {PEAK: peak}).max(axis=0), _LEAST)
        if among is not None:
            return self._whole(k, found, at, among)
        if len(kept) >= _KEPT:
            kept.clear()
        kept[key] = found
        return found

    def best_margins(self, k: int, masses: MassRange, among: Flags) -> Array:
        """Margins (M, G) that no pair of joint k exceeds with drives of masses in a range; among:
        those that are asked for, others have 0."""
        pairs, allowed, at = self._part(k, among)
        known = self.worst[k], allowed
        used = least_uses(self.loads, self.rest, k, pairs, self.life, masses, known)
        return self._whole(k, (1.0 + _ROUNDING) / np.maximum(used, _LEAST), at, among)

    def _part(self, k: int, among: Flags | None) -> tuple[PairTable, Array, tuple[Index, ...]]:
        """Pairs of joint k that contain those asked for, what is allowed of them at the worst
        samples, and where they stand among all."""
        pairs, allowed = self.pairs[k], self.allowed[k]
        if among is None:
            return pairs, allowed, ()
        at = np.flatnonzero(among.any(axis=1)), np.flatnonzero(among.any(axis=0))
        return pairs.taken(*at), allowed[:, at[0]][:, :, at[1]], at

    def _whole(self, k: int, margins: Array, at: tuple[Index, ...], among: Flags) -> Array:
        found = np.zeros(self.pairs[k].shape)
        found[np.ix_(*at)] = margins
        return np.where(among, found, 0.0)

    def is_true(self, k: int, partial: PartialChoice) -> bool:
        """Whether the samples known to be the worst are that of the pair of joint k; else they
        are from now on."""
        demand, pairs, (m, g) = self._demand(k, partial.masses), self.pairs[k], partial.picks[k]
        use, at = pairs.peak_of(demand, m, g)
        one = PairTable([pairs.motors[m]], [pairs.gears[g]])
        known = float(one.peak_use(demand, self.worst[k])[0, 0])
        if use <= known * (1.0 + _SAME):
            return True
        self.worst[k] = np.append(self.worst[k], at)
        more = pairs.allowed(self.loads.speed[[at], k])
        self.allowed[k] = np.concatenate([self.allowed[k], more])
        return False

    def lower(self, k: int, known: int, masses: Sequence[Array], margins: Sequence[Array]) -> None:
        """Lower margins (M, G) of joint k, each with drives of masses (n,), to what the worst
        samples allow that were not among the first `known`."""
        samples, allowed = self.worst[k][known:], self.allowed[k][known:]
        for carried, margin in zip(masses, margins, strict=True):
            peak = self.pairs[k].peak_use(self._demand(k, carried), samples, allowed)
            np.minimum(margin, 1.0 / np.maximum(peak, _LEAST), out=margin)

    def worst_use(self, k: int, partial: PartialChoice) -> tuple[float, int]:
        """(the largest share that the pair of joint k uses of a limit, which limit), at all
        samples."""
        demand, pairs, (m, g) = self._demand(k, partial.masses), self.pairs[k], partial.picks[k]
        one = PairTable([pairs.motors[m]], [pairs.gears[g]])
        peak = np.array([[pairs.peak_of(demand, m, g)[0]]])
        shares = uses(demand, one, {PEAK: peak})[:, 0, 0]
        return float(shares.max()), int(shares.argmax())

    def extended(self, partial: PartialChoice, k: int, at: Any, margins: Array) -> PartialChoice:
        """A choice with the pair `at` (m, g) for joint k, whose margins are (M, G)."""
        m, g = (int(x) for x in at)
        return partial.with_pair(
            k,
            (m, g),
            float(self.pairs[k].mass[m, g]),
            float(self.price[k][m, g]),
            float(margins[m, g]),
        )
