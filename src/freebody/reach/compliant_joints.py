"""Which joints of a robot yield while its drives stand still, and how stiff they are: shafts and
springs of the model itself, and the stiffness of drives that a caller gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array, as_floats, check_core
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.kernels.formulas import Option
from freebody.kernels.structural import Bound, Over, fetch_own
from freebody.kernels.tracing import program
from freebody.labels import aligned
from freebody.model.model import Model
from freebody.program import Argument, Program
from freebody.trees.position_rates import Index
from freebody.trees.public_calls import JointVector

Stiffness = JointVector | None
"""The stiffness of drives: (..., nv), by name, or one number for all of one coordinate, N m/rad and
N/m."""


@dataclass(frozen=True)
class CompliantJoints:
    """The coordinates that may move, and the springs between drives at rest and their links.

    model: without friction, and without the rotors that stand still behind a spring. moving: (k,),
    entries of q̇. given: (..., k), N m/rad or N/m, of springs besides the model's own. notices: in
    which units one number for all counts.
    """

    model: Model
    moving: Index
    given: Array
    notices: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates that may move."""
        return tuple(self.model.velocity_names[k] for k in self.moving)

    @property
    def still(self) -> Index:
        """Entries (nv - k,) of q̇ that stand still."""
        return np.setdiff1d(np.arange(self.model.nv), self.moving)


def compliant_joints(
    function: str,
    model: Model,
    stiffness: Stiffness,
    held: Sequence[str] | None,
    resting: bool,
) -> CompliantJoints:
    """The joints of a chain that yield.

    stiffness: of drives; infinite, or left out of a mapping, is rigid. held: names of what stands
    still; None: the drives without a given stiffness where one is given, or where all drives rest
    anyway (`resting`), else none.
    """
    model.require_values(function)
    given = _given(function, model, stiffness)
    if held is None:
        _refuse_slack(function, model, stiffness, given)
    every = tuple(range(given.ndim - 1))
    rigid = np.isinf(given).any(axis=every)
    if (rigid & ~np.isinf(given).all(axis=every)).any():
        raise FreebodyError(
            f"{function}: stiffness is infinite in some samples alone; a joint is rigid in all of "
            f"them or in none."
        )
    if held is not None:
        still = rigid | _named(function, model, held)
    elif stiffness is not None or resting:
        driven = np.isin(np.arange(model.nv), model.driven)
        still = rigid | (driven & (given == 0.0).all(axis=every))
    elif has_springs(model):
        still = rigid
    else:
        still = np.ones(model.nv, dtype=bool)
    moving = np.flatnonzero(~still)
    if not len(moving):
        names = [model.velocity_names[k] for k in _of_one_coordinate(model)]
        such = f", such as {{{names[0]!r}: 2e4}}" if names else ""
        raise FreebodyError(
            f"{function}: no joint of {model.name!r} yields: it has neither springs nor flexible "
            f"joints. Give stiffness=, that of each drive (N m/rad, N/m){such}, or a model with "
            f"model.with_flexible_joint."
        )
    sprung = moving[(given[..., moving] > 0.0).any(axis=every)]
    return CompliantJoints(
        _at_rest(model, tuple(sprung.tolist())), moving, given[..., moving],
        _units(model, stiffness),
    )  # fmt: skip


def quaternion_coordinates(model: Model) -> Index:
    """Entries of q̇ of joints with quaternions, about which no spring acts."""
    return np.array(
        [k for body, at in zip(model.bodies, model.coordinates, strict=True)
         if body.kind.quaternion is not None for k in at.v], dtype=np.intp,
    )  # fmt: skip


def _given(function: str, model: Model, stiffness: Stiffness) -> Array:
    """Stiffnesses (nv,) of drives as a user gives them, 0 for coordinates to which none is
    given."""
    if stiffness is None:
        return np.zeros(model.nv)
    names = model.velocity_names
    if isinstance(stiffness, Mapping):
        stiffness = dict.fromkeys(names, 0.0) | dict(stiffness)
    elif np.ndim(stiffness) == 0:
        one = as_floats(function, "stiffness", stiffness)
        if not one > 0.0:
            raise _not_positive(function, one)
        return np.where(np.isin(np.arange(model.nv), _of_one_coordinate(model)), one, 0.0)
    told = aligned(function, "stiffness", stiffness, names, ("velocity", "joint"))
    found = as_floats(function, "stiffness", told)
    check_core(
        function, "stiffness", found, (len(names),),
        f"one for each of {listed(names, 8)}, or one number for all drives",
    )  # fmt: skip
    if not (found >= 0.0).all():
        raise _not_positive(function, found)
    for k in quaternion_coordinates(model):
        if (found[..., k] > 0.0).any():
            raise FreebodyError(
                f"{function}: {names[k]!r} of {model.name!r} is a coordinate of a joint with a "
                f"quaternion, about which no spring acts: leave it out of stiffness=."
            )
    return found


def _of_one_coordinate(model: Model) -> list[int]:
    """Driven coordinates of joints of one coordinate."""
    return [
        at.v[0] for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.kind.nv == 1 and body.joint.mimic is None and not body.joint.passive
    ]  # fmt: skip


def _units(model: Model, stiffness: Stiffness) -> tuple[str, ...]:
    """The sentence on the units of one number for all drives, where these turn and slide."""
    if stiffness is None or isinstance(stiffness, Mapping) or np.ndim(stiffness):
        return ()
    names: dict[str, list[str]] = {"N m/rad": [], "N/m": []}
    angles = turning(model)
    for k in _of_one_coordinate(model):
        names["N m/rad" if angles[k] else "N/m"].append(model.velocity_names[k])
    if not all(names.values()):
        return ()
    units = (f"N m/rad of {listed(names['N m/rad'], 8)}", f"N/m of {listed(names['N/m'], 8)}")
    return (f"The one stiffness {float(np.asarray(stiffness)):.6g} is {' and '.join(units)}.",)


def turning(model: Model) -> list[bool]:
    """Whether each entry of q̇ is the rate of an angle."""
    return [x for body in model.bodies if body.joint.mimic is None for x in body.kind.angular]


def _refuse_slack(function: str, model: Model, stiffness: Stiffness, given: Array) -> None:
    """Refuse a stiffness of 0 that is given for a drive, which is neither rigid nor left out."""
    if stiffness is None or (not isinstance(stiffness, Mapping) and np.ndim(stiffness) == 0):
        return
    told = stiffness if isinstance(stiffness, Mapping) else model.driven_names
    drives = np.isin(model.velocity_names, [name for name in model.driven_names if name in told])
    drives[quaternion_coordinates(model)] = False
    if (given[..., drives] == 0.0).any():
        raise _not_positive(function, given)


def _not_positive(function: str, given: Array) -> FreebodyError:
    return FreebodyError(
        f"{function}: stiffness must be numbers above 0 (N m/rad, N/m; infinite where a joint is "
        f"rigid); got {given.tolist()}."
    )


def _named(function: str, model: Model, held: Sequence[str]) -> np.ndarray:
    """Flags (nv,) of the coordinates that are called so, or whose joint is."""
    names = (held,) if isinstance(held, str) else tuple(held)
    of = {name: [k] for k, name in enumerate(model.velocity_names)}
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None:
            of[body.joint.name] = list(at.v)
    for name in names:
        if name not in of:
            raise UnknownNameError("joint", name, f"{function}: held=", of)
    return np.isin(np.arange(model.nv), [k for name in names for k in of[name]])


def _at_rest(model: Model, sprung: tuple[int, ...]) -> Model:
    """The model without friction, and without the rotors of drives behind which a spring is
    given."""
    key = ("compliant joints", sprung)
    found = model.compiled.get(key)
    if found is None:
        found = model.without("friction")
        names = {model.velocity_names[k] for k in sprung}
        for body in model.bodies:
            if body.joint.name in names and body.joint.drive.rotor != 0.0:
                found = found.with_drive(body.joint.name, rotor=0.0)
        model.compiled[key] = found
    return found


def has_springs(model: Model) -> bool:
    """Whether joints have springs, or struts pull."""
    return bool(model.struts) or len(sprung_coordinates(model)) > 0


def sprung_coordinates(model: Model) -> Index:
    """Entries of q̇ of joints with springs."""
    return np.array(
        [
            at.v[0]
            for body, at in zip(model.bodies, model.coordinates, strict=True)
            for law in body.joint.drive.listed_laws
            if law.feature == "springs" and getattr(body.joint.drive, law.strength) != 0.0
        ],
        dtype=np.intp,
    )


def tangent(
    joints: CompliantJoints,
    q: Array,
    weightless: bool = False,
    wrenches: Mapping[str, Array] | None = None,
) -> Array:
    """(..., k, k): the slopes of the torques of the moving coordinates at rest by these, loops cut,
    of springs and struts, of weights unless `weightless`, of wrenches that keep their direction,
    and of the springs given."""
    at = joints.moving
    model = joints.model.replace(gravity=0) if weightless else joints.model
    loads = wrenches or {}
    K = _slopes(model.opened, tuple(loads))(q, *loads.values())[1]
    if len(at) < model.nv:
        K = np.ascontiguousarray(K[..., at[:, None], at])
    if joints.given.any():
        shape = np.broadcast_shapes(K.shape[:-2], joints.given.shape[:-1])
        K = K if shape == K.shape[:-2] else np.array(np.broadcast_to(K, (*shape, *K.shape[-2:])))
        diagonal = np.einsum("...ii->...i", K)  # a view
        diagonal += joints.given
    return K


def _slopes(model: Model, frames: tuple[str, ...]) -> Bound:
    """The kernel q, wrenches -> torques at rest, and their derivatives by q."""
    option = Option(wrench_frames=frames)

    def made(p: Argument, over: Over) -> Program:
        return program(model, ("static_torque",), option, p, over, ("q",))

    return fetch_own(model, ("static_torque by q",), option, made)
