"""The brakes and bearings by which a robot is judged besides its drives: what of their loads is
compared with which of their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.design.bearings import checked_bearings, turning_joints
from freebody.design.data_sheets import sure
from freebody.design.drive_loads import ChosenDrives, checked_drives, fitting_joints
from freebody.design.joint_loads import bearing_vectors, known_wrenches, undetermined
from freebody.design.pairs import holding_torque
from freebody.design.parts import CROSSED_STATIC_AXIAL, Bearing
from freebody.errors import FreebodyError
from freebody.model.model import Model

MotionStates = tuple[Array, Array, Array]
"""Positions, rates and accelerations of samples."""


@dataclass(frozen=True)
class FittedBrake:
    """A brake at a joint: the joint's name, the motor's, the column of the joint in q̇, whether it
    turns, and what the brake holds there (N m, N)."""

    joint: str
    part: str
    column: int
    turns: bool
    limit: float


@dataclass(frozen=True)
class FittedBearing:
    """A bearing at a joint: the joint's name, and the number of the body behind it."""

    joint: str
    body: int
    bearing: Bearing


@dataclass(frozen=True)
class FittedParts:
    """The brakes and bearings by which a robot is judged besides its drives."""

    brakes: tuple[FittedBrake, ...] = ()
    bearings: tuple[FittedBearing, ...] = ()

    @property
    def words(self) -> tuple[str, ...]:
        """Each part in words."""
        return (
            *(f"the brake of {x.joint} ({x.part})" for x in self.brakes),
            *(f"the bearing of {x.joint} ({x.bearing.name})" for x in self.bearings),
        )

    @staticmethod
    def of(
        function: str,
        model: Model,
        brakes: ChosenDrives | None,
        bearings: Mapping[str, Bearing] | None,
    ) -> FittedParts:
        """The parts that a function was given for joints of a model; refuses a bearing that has no
        limit with which a load could be compared."""
        chosen = {} if brakes is None else checked_drives(function, "brakes", brakes)
        joints = fitting_joints(function, model, chosen) if chosen else ()
        given, turning = checked_bearings(function, model, bearings), turning_joints(model)
        for bearing in given.values():
            if all(limit.most(bearing) is None for limit in BEARING_LIMITS):
                raise bearing.refusal(
                    f"{function}: it limits no load: that takes its moment_limit, or of a "
                    f"crossed roller bearing its static_load; its life fb.bearing_loads tells"
                )
        return FittedParts(
            tuple(
                FittedBrake(x.name, motor.name, x.column, x.turns, holding_torque(motor, gear))
                for x, (motor, gear) in zip(joints, chosen.values(), strict=True)
            ),
            tuple(FittedBearing(name, turning[name], x) for name, x in given.items()),
        )


NO_PARTS = FittedParts()
"""Nothing is judged besides the drives."""


# ------------------------------------------------------------ limits of bearings
@dataclass(frozen=True)
class BearingLimit:
    """A limit of bearings: its name, its unit, the most that a bearing bears (None where it does
    not say), and the weights with which the sizes of axial force, radial force and tilting moment
    add up to what is compared with it."""

    name: str
    unit: str
    most: Callable[[Bearing], float | None]
    weights: Callable[[Bearing], tuple[float, float, float]]

    def of(self, bearings: tuple[FittedBearing, ...]) -> LimitedBearings:
        """The bearings that have this limit."""
        places = [k for k, x in enumerate(bearings) if self.most(x.bearing) is not None]
        fitted = tuple(bearings[k] for k in places)
        return LimitedBearings(
            self,
            places,
            fitted,
            np.array([self.weights(x.bearing) for x in fitted]).reshape(-1, 3),
            np.array([sure(self.most(x.bearing)) for x in fitted]),
        )


@dataclass(frozen=True, eq=False)
class LimitedBearings:
    """Bearings that have a limit: their places among all that are fitted, the weights (n, 3) of
    their loads, and how much they bear (n,)."""

    limit: BearingLimit
    places: list[int]
    fitted: tuple[FittedBearing, ...]
    weights: Array
    limits: Array


def _static_load(bearing: Bearing) -> float | None:
    if bearing.static_load is None or bearing.kind != "crossed roller":
        return None
    return bearing.static_load / bearing.static_factor


def _static_weights(bearing: Bearing) -> tuple[float, float, float]:
    return CROSSED_STATIC_AXIAL, 1.0, 2.0 / sure(bearing.pitch_diameter)


BEARING_LIMITS = (
    BearingLimit("static load", "N", _static_load, _static_weights),
    BearingLimit("tilting moment", "N m", lambda x: x.moment_limit, lambda x: (0.0, 0.0, 1.0)),
)
"""All limits with which loads of bearings are compared; a new one is a line here."""


def vectors_on_bearings(
    function: str,
    model: Model,
    bearings: tuple[FittedBearing, ...],
    states: MotionStates,
    wrenches: Mapping[str, Array] | None,
) -> tuple[Array, Array, Array]:
    """Axial force (T, n, 1), radial force (T, n, dim) and tilting moment (T, n, 3) of bearings at
    states; refuses loads that rigid bodies do not determine."""
    wrench, d = known_wrenches(model, *states, wrenches, "child"), model.dim
    each = [
        bearing_vectors(model.bodies[k], wrench[:, k, :d], wrench[:, k, d:])
        for k in (x.body for x in bearings)
    ]
    axial, radial, tilting = (np.stack(x, axis=1) for x in zip(*each, strict=True))
    unknown = np.isnan(radial).any(axis=(0, 2)) | np.isnan(tilting).any(axis=(0, 2))
    if unknown.any():
        names = [bearings[k].joint for k in np.flatnonzero(unknown)]
        raise FreebodyError(f"{function}: bearing loads are {undetermined(names)[0]}")
    return axial, radial, tilting
