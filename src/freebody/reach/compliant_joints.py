"""Which joints of a robot yield while its drives stand still, and how stiff they are: shafts and
springs of the model itself, and the stiffness of drives that a caller gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array, as_floats, check_core
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.kernels.structural import PLAIN, Bound, Over, fetch_own
from freebody.kernels.tracing import program
from freebody.labels import aligned
from freebody.model.model import Model
from freebody.program import Argument, Program
from freebody.trees.position_rates import Index
from freebody.trees.public_calls import JointVector


@dataclass(frozen=True)
class CompliantJoints:
    """The coordinates that may move, and the springs between drives at rest and their links.

    model: without friction, and without the rotors that stand still behind a spring. moving: (k,),
    entries of q̇. given: (..., k), N m/rad or N/m, of springs besides the model's own.
    """

    model: Model
    moving: Index
    given: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates that may move."""
        return tuple(self.model.velocity_names[k] for k in self.moving)


def compliant_joints(
    function: str,
    model: Model,
    stiffness: JointVector | None,
    held: Sequence[str] | None,
    resting: bool,
) -> CompliantJoints:
    """The joints of an open chain that yield.

    stiffness: (..., nv) or by name, of drives; infinite, or left out of a mapping, is rigid. held:
    names of what stands still; None: the drives without a given stiffness where one is given, or
    where all drives rest anyway (`resting`), else none.
    """
    model.require_values(function)
    model.require_tree(function)
    if model.nq != model.nv:
        raise FreebodyError(
            f"{function}: {model.name!r} has joints with quaternions, about which no spring acts "
            f'here; load it with base="fixed", or without such joints.'
        )
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
        raise FreebodyError(
            f"{function}: no joint of {model.name!r} yields: it has neither springs nor flexible "
            f"joints. Give stiffness=, that of each drive (N m/rad, N/m), such as "
            f"{{{model.velocity_names[0]!r}: 2e4}}, or a model with model.with_flexible_joint."
        )
    sprung = moving[(given[..., moving] > 0.0).any(axis=every)]
    return CompliantJoints(_at_rest(model, tuple(sprung.tolist())), moving, given[..., moving])


def _given(function: str, model: Model, stiffness: JointVector | None) -> Array:
    """(..., nv) as given, 0 where nothing is."""
    if stiffness is None:
        return np.zeros(model.nv)
    names = model.velocity_names
    if isinstance(stiffness, Mapping):
        stiffness = dict.fromkeys(names, 0.0) | dict(stiffness)
    told = aligned(function, "stiffness", stiffness, names, ("velocity", "joint"))
    found = as_floats(function, "stiffness", told)
    check_core(function, "stiffness", found, (len(names),), f"one for each of {listed(names, 8)}")
    if not (found >= 0.0).all():
        raise _not_positive(function, found)
    return found


def _refuse_slack(function: str, model: Model, stiffness: JointVector | None, given: Array) -> None:
    """Refuse a stiffness of 0 that is given for a drive, which is neither rigid nor left out."""
    if stiffness is None:
        return
    told = stiffness if isinstance(stiffness, Mapping) else model.driven_names
    drives = np.isin(model.velocity_names, [name for name in model.driven_names if name in told])
    if (given[..., drives] == 0.0).any():
        raise _not_positive(function, given)


def _not_positive(function: str, given: Array) -> FreebodyError:
    return FreebodyError(
        f"{function}: stiffness must be numbers above 0 (N m/rad, N/m; infinite where a joint is "
        f"rigid); got {given.tolist()}."
    )


def _named(function: str, model: Model, held: Sequence[str]) -> np.ndarray:
    names = (held,) if isinstance(held, str) else tuple(held)
    for name in names:
        if name not in model.velocity_names:
            raise UnknownNameError("joint", name, f"{function}: held=", model.velocity_names)
    return np.isin(model.velocity_names, names)


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
    drives = [body.joint.drive for body in model.bodies]
    acting = (law for x in drives for law in x.listed_laws if getattr(x, law.strength) != 0.0)
    return bool(model.struts) or any(law.feature == "springs" for law in acting)


def tangent(joints: CompliantJoints, q: Array, weightless: bool = False) -> Array:
    """(..., k, k): the slopes of the torques of the moving coordinates at rest by these, of springs
    and struts, of weights unless `weightless`, and of the springs given."""
    at = joints.moving
    model = joints.model.replace(gravity=0) if weightless else joints.model
    K = _slopes(model)(q)[1]
    if len(at) < model.nv:
        K = np.ascontiguousarray(K[..., at[:, None], at])
    if joints.given.any():
        shape = np.broadcast_shapes(K.shape[:-2], joints.given.shape[:-1])
        K = K if shape == K.shape[:-2] else np.array(np.broadcast_to(K, (*shape, *K.shape[-2:])))
        diagonal = np.einsum("...ii->...i", K)  # a view
        diagonal += joints.given
    return K


def _slopes(model: Model) -> Bound:
    """The kernel q -> torques at rest, and their derivatives by q."""

    def made(p: Argument, over: Over) -> Program:
        return program(model, ("static_torque",), PLAIN, p, over, ("q",))

    return fetch_own(model, ("static_torque by q",), PLAIN, made)
