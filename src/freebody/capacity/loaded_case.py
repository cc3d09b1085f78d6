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
from freebody.design.bearings import checked_bearings, turning_joints
from freebody.design.drive_loads import ChosenDrives, checked_drives, fitting_joints
from freebody.design.joint_loads import bearing_vectors
from freebody.design.known_wrenches import known_wrenches, undetermined
from freebody.design.pairs import holding_torque
from freebody.design.parts import Bearing
from freebody.errors import FreebodyError
from freebody.lazy import Keeps, cached_property
from freebody.model.model import Model
from freebody.reach.payload_map import NO_SLOPE

_ROUNDING = 1e-13
"""Change of a torque, as a part of it, that is none."""

MotionStates = tuple[Array, Array, Array]
"""Positions, rates and accelerations of samples."""


@dataclass(frozen=True)
class FittedBrake:
    """A brake at a joint: the joint's name, the motor's, the column of the joint in q̇, and what it
    holds there (N m, N)."""

    joint: str
    part: str
    column: int
    limit: float


@dataclass(frozen=True)
class FittedBearing:
    """A bearing at a joint: the joint's name, and the number of the body behind it."""

    joint: str
    body: int
    bearing: Bearing


@dataclass(frozen=True)
class FittedParts:
    """The brakes and bearings by which a payload is judged besides its drives."""

    brakes: tuple[FittedBrake, ...] = ()
    bearings: tuple[FittedBearing, ...] = ()

    @staticmethod
    def of(
        function: str,
        model: Model,
        brakes: ChosenDrives | None,
        bearings: Mapping[str, Bearing] | None,
    ) -> FittedParts:
        """The parts that a function was given for joints of a model; refuses a bearing that has no
        limit which a payload could be compared with."""
        chosen = {} if brakes is None else checked_drives(function, "brakes", brakes)
        joints = fitting_joints(function, model, chosen) if chosen else ()
        given, turning = checked_bearings(function, model, bearings), turning_joints(model)
        for bearing in given.values():
            if bearing.moment_limit is None and not limits_static_load(bearing):
                raise bearing.refusal(
                    f"{function}: it limits no payload: that takes its moment_limit, or of a "
                    f"crossed roller bearing its static_load; its life fb.bearing_loads tells"
                )
        return FittedParts(
            tuple(
                FittedBrake(x.name, motor.name, x.column, holding_torque(motor, gear))
                for x, (motor, gear) in zip(joints, chosen.values(), strict=True)
            ),
            tuple(FittedBearing(name, turning[name], x) for name, x in given.items()),
        )


def limits_static_load(bearing: Bearing) -> bool:
    """Whether a static equivalent load is told of a bearing, and a rating to compare it with."""
    return bearing.static_load is not None and bearing.kind == "crossed roller"


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
        """The loads of some of the parts."""
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
        case, d = self.case, self.case.model.dim
        both = []
        for model in (case.model, case.carrying):
            wrench = known_wrenches(model, *self.states, case.wrenches, "child")
            each = [
                bearing_vectors(model.bodies[k], wrench[:, k, :d], wrench[:, k, d:])
                for k in (x.body for x in case.parts.bearings)
            ]
            both.append([np.stack(x, axis=1) for x in zip(*each, strict=True)])
        bare, loaded = both
        unknown = np.isnan(bare[1]).any(axis=(0, 2)) | np.isnan(bare[2]).any(axis=(0, 2))
        if unknown.any():
            names = [x.joint for x, bad in zip(case.parts.bearings, unknown, strict=True) if bad]
            raise FreebodyError(f"payload: bearing loads are {undetermined(names)[0]}")
        axial, radial, tilting = (
            AffineLoad.between(x, y) for x, y in zip(bare, loaded, strict=True)
        )
        return axial, radial, tilting
