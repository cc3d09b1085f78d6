"""The case that a payload is asked for: a robot without and with a kilogram, what limits it, and
its loads at states, each affine in the mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import static_torque
from freebody.any_chain.effort_limits import Followers, followers
from freebody.arrays import Array
from freebody.capacity.fitted_parts import FittedParts, MotionStates, vectors_on_bearings
from freebody.lazy import Keeps, cached_property
from freebody.model.model import Model
from freebody.reach.payload_map import NO_SLOPE

_ROUNDING = 1e-13
"""Change of a torque, as a part of it, that is none."""


@dataclass(frozen=True)
class LoadedCase:
    """A robot without and with a kilogram, the limits of its drives (nv,), wrenches on it, its
    followers that have limits, without and with the kilogram, and other parts that limit it."""

    model: Model
    carrying: Model
    effort: Array
    wrenches: Mapping[str, Array] | None
    followers: tuple[Followers, Followers] | None
    parts: FittedParts

    @staticmethod
    def of(
        model: Model,
        kilogram: Mapping[str, Any],
        frame: str,
        effort: Array,
        wrenches: Mapping[str, Array] | None,
        parts: FittedParts,
    ) -> LoadedCase:
        """The case of a robot that carries a load, of which `kilogram` tells a kilogram as
        arguments of `Model.with_payload`, at a frame."""
        carrying = _carrying(model, kilogram, frame)
        bare, loaded = followers(model), followers(carrying)
        both = None if bare is None or loaded is None else (bare, loaded)
        return LoadedCase(model, carrying, effort, wrenches, both, parts)


def _carrying(model: Model, kilogram: Mapping[str, Any], frame: str) -> Model:
    name = "carried"
    taken = {part.link for body in model.bodies for part in body.inertias}
    while name in taken:
        name += "_"
    return model.with_payload(**kilogram, frame=frame, name=name)


def without_rounding(values: Array, whole: Array) -> Array:
    """Values (T, n), such as what a kilogram adds, 0 where they are what rounding leaves of loads
    `whole` (T, n)."""
    rounding = _ROUNDING * np.abs(whole).max(axis=-1, keepdims=True, initial=0.0)
    return np.where(np.abs(values) <= np.maximum(rounding, NO_SLOPE), 0.0, values)


@dataclass(frozen=True)
class AffineLoad:
    """A load (T, n, d) of n parts at T states: what it is without payload, and what a kilogram
    adds; its size is that of the vector."""

    bare: Array
    slope: Array

    @staticmethod
    def between(bare: Array, loaded: Array) -> AffineLoad:
        """The load (T, n, d) of which the values without and with a kilogram are known; what
        rounding alone leaves of either is 0."""
        count = len(bare)
        whole, slope = bare.reshape(count, -1), (loaded - bare).reshape(count, -1)
        parts = (without_rounding(x, whole).reshape(bare.shape) for x in (whole, slope))
        return AffineLoad(*parts)

    def at(self, columns: list[int] | slice) -> AffineLoad:
        """Loads of the chosen parts alone."""
        return AffineLoad(self.bare[:, columns], self.slope[:, columns])


@dataclass(frozen=True, eq=False)
class CaseAtStates(Keeps):
    """A case at states: q (T, nq), qd and qdd (T, nv)."""

    case: LoadedCase
    states: MotionStates

    @cached_property
    def held(self) -> tuple[AffineLoad, ...]:
        """The torques that brakes hold, (T, nv, 1), where the robot stands still: without
        the wrenches on it, which may end as the drives do, and with them."""
        case, q = self.case, self.states[0]
        cases = (None, case.wrenches) if case.wrenches else (None,)
        return tuple(
            AffineLoad.between(
                *(static_torque(x, q, loads)[..., None] for x in (case.model, case.carrying))
            )
            for loads in cases
        )

    @cached_property
    def on_bearings(self) -> tuple[AffineLoad, AffineLoad, AffineLoad]:
        """Axial force (T, n, 1), radial force (T, n, dim) and tilting moment (T, n, 3) of the
        bearings; refuses loads that rigid bodies do not determine."""
        case = self.case
        bare, loaded = (
            vectors_on_bearings("payload", model, case.parts.bearings, self.states, case.wrenches)
            for model in (case.model, case.carrying)
        )
        axial, radial, tilting = (
            AffineLoad.between(x, y) for x, y in zip(bare, loaded, strict=True)
        )
        return axial, radial, tilting
