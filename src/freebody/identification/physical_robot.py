"""The physical robot nearest to a regression: which unknowns it has, what is held of them
beforehand, and the model that they make."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from freebody.arrays import Array
from freebody.identification.columns import Columns
from freebody.identification.consistency import (
    Fitted,
    Physical,
    closest,
    nearest_physical,
    pseudo_inertia_basis,
)
from freebody.identification.log_equations import LogEquations
from freebody.identification.nearest_by_lmi import nearest_by_lmi
from freebody.identification.priors import Prior
from freebody.identification.regression import Regressed
from freebody.identification.torque_scale import TorqueScale
from freebody.model.changes import with_drive
from freebody.model.doubts import ESTIMATED, Doubt
from freebody.model.drives import LAWS
from freebody.model.inertial_parameters import body_parameters
from freebody.model.model import Model
from freebody.spatial import of_dimension

_PART_OF_NOISE = 0.05
"""Part of the number of base parameters by which chi2 may grow for the prior: where it was as great
as the number itself, the data's own errors would have moved the estimate as far."""
_OF_MASSES = {"model": 10.0, "masses": 10.0, "geometry": 0.0, "nothing": 0.0}
"""Weight of what is held of masses alone: a data sheet or a drawing tells them far better than an
estimated shape tells where they are."""
_LEAST_FRICTION, _LEAST_LOSS = 0.01, 0.005
"""Friction that is looked for near 0: as part of a joint's torque, and of what it transmits."""
_EDGE = 1e-9
"""Ratio of the eigenvalues of a pseudo-inertia below which a body is nearly none."""
_SCALES, _SCALE_TOLD, _STEP = 3.0, 3e-3, 0.2
"""Logarithms of the common factor of gains: the farthest from what suits the prior's torques, and
the distance to which it is found."""


@dataclass(frozen=True)
class PhysicalFit:
    """The physical robot of a regression. values: of the unknowns. inertial: (p,) its parameters π,
    of bodies and then reflected inertias of rotors. friction: (n, laws). weight: of the prior.
    scale: by which gains and all that they multiply grew."""

    values: Array
    inertial: Array
    friction: Array
    weight: float
    scale: TorqueScale


def fit_physical(
    model: Model,
    found: LogEquations,
    regressed: Regressed,
    prior: Prior,
    known: TorqueScale | None,
    lmi: bool = False,
) -> PhysicalFit:
    """The physical robot nearest to a regression. known: the scale of the torques, or None where it
    is to be found from the prior's masses. lmi: whether the prior's weight is 0 beside the data."""
    columns, information = found.columns, regressed.information
    size, n = len(columns.inertial_names), len(columns.joints)
    first = base_scale(columns, regressed, prior)
    if prior.source == "geometry" and known is not None:
        prior = Prior(prior.bodies * known.factor / first, prior.source)
    at = _first_products(columns, regressed.values)

    def problem(scale: float) -> tuple[Array, Array, Array, Physical]:
        factors = _scaled(columns, np.ones(found.size), scale)
        values = factors * regressed.values
        combine, constant = _combine(columns, at * [1.0, scale])
        own = information / np.outer(factors, factors)
        return values - constant, own, combine, _physical(model, found, values, scale, prior)

    def solved(near: Fitted | None) -> Fitted:
        if lmi:
            return nearest_by_lmi(*problem(scale))
        return nearest_physical(*problem(scale), _PART_OF_NOISE * columns.base, near)

    shaped = prior.source == "masses"
    if known is None:
        known = _found_scale(lambda x: closest(*problem(first * np.exp(x)), shaped)[0], first)
    scale = known.factor
    fitted = solved(None)
    if columns.by_load:
        at = _products(columns, fitted.x) / [1.0, scale]
        fitted = solved(fitted)
    combine, _ = _combine(columns, _products(columns, fitted.x))
    values = combine @ fitted.x
    for (loss, rotor), row in zip(_products(columns, fitted.x), columns.rows, strict=True):
        if row.lost_rotor is not None:
            values[row.lost_rotor] = loss * rotor
    friction = fitted.x[size:].reshape(n, len(columns.friction))
    return PhysicalFit(values, fitted.x[:size], friction, fitted.weight, known)


def _found_scale(misfit: Callable[[float], float], first: float) -> TorqueScale:
    """The scale with the least misfit, which is of the logarithm of its ratio to the first."""
    options = {"xatol": _SCALE_TOLD}
    found: Any = minimize_scalar(
        misfit, bounds=(-_SCALES, _SCALES), method="bounded", options=options
    )
    best = float(found.x)
    around = [misfit(best + x) for x in (-_STEP, 0.0, _STEP)]
    curvature = (around[0] - 2.0 * around[1] + around[2]) / (_STEP) ** 2
    return TorqueScale(first * float(np.exp(best)), float(1.0 / np.sqrt(max(curvature, 1.0))))


def _combine(columns: Columns, at: Array) -> tuple[Array, Array]:
    """(combine, constant): of which physical unknowns x those of the regression are made, combine x
    + constant; products of loss and rotor as they change about those given, (n, 2)."""
    size, base = len(columns.inertial_names), columns.base
    combine = np.zeros((len(columns.names), size + columns.friction_size))
    constant = np.zeros(len(combine))
    combine[:base, :size] = columns.matrix
    combine[base : base + columns.friction_size, size:] = np.eye(columns.friction_size)
    for joint, row, (loss, rotor) in zip(columns.joints, columns.rows, at, strict=True):
        if row.load is not None and row.lost_rotor is not None:
            combine[row.lost_rotor, columns.inertial_names.index(f"{joint}.rotor")] = loss
            combine[row.lost_rotor, size + row.load - base] = rotor
            constant[row.lost_rotor] = -loss * rotor
    return combine, constant


def _products(columns: Columns, x: Array) -> Array:
    """(loss, reflected rotor inertia) of each joint (n, 2), from physical unknowns."""
    size, names = len(columns.inertial_names), columns.inertial_names
    found = np.zeros((len(columns.joints), 2))
    for j, (joint, row) in enumerate(zip(columns.joints, columns.rows, strict=True)):
        if row.load is not None and row.lost_rotor is not None:
            found[j] = x[size + row.load - columns.base], x[names.index(f"{joint}.rotor")]
    return found


def _first_products(columns: Columns, values: Array) -> Array:
    """(loss, reflected rotor inertia) of each joint (n, 2), from the regression."""
    _, rotors = columns.of_bodies(values)
    losses = [0.0 if row.load is None else max(values[row.load], 0.0) for row in columns.rows]
    return np.column_stack([losses, rotors])


def base_scale(columns: Columns, regressed: Regressed, prior: Prior) -> float:
    """The factor by which the torques of estimated base parameters are as large as the prior's: of
    what these have in common a factor would be endless where bodies lie on the other side."""
    b, bodies = columns.base, prior.bodies.ravel()
    held = columns.matrix[:, : len(bodies)] @ bodies
    weight, found = regressed.information[:b, :b], regressed.values[:b]
    return float(np.sqrt((held @ weight @ held) / max(found @ weight @ found, 1e-300)))


def _scaled(columns: Columns, values: Array, scale: float) -> Array:
    """Unknowns of torques that are `scale` times as large; losses are parts of torques."""
    factors = np.full(len(values), scale)
    for row in columns.rows:
        if row.load is not None:
            factors[row.load] = 1.0
    return factors * values


def _physical(
    model: Model, found: LogEquations, values: Array, scale: float, prior: Prior
) -> Physical:
    """The conditions on bodies, rotors and friction, with what is held of each."""
    columns, laws = found.columns, found.columns.friction
    end = columns.base + columns.friction_size
    friction = values[columns.base : end].reshape(len(columns.joints), len(laws)).copy()
    below = np.full(friction.shape, np.inf)
    for k, x in enumerate(laws):
        number = x.law.numbers[0]
        below[:, k] = number.below
        if number.refused is None:
            friction[:, k] = np.nan
        elif x.by_load:
            friction[:, k] = np.clip(friction[:, k], _LEAST_LOSS, 0.9)
        else:
            for j, rows in enumerate(found.rows):
                column = rows.x[:, rows.unknowns == columns.base + j * len(laws) + k]
                part = np.std(rows.y) * scale / max(float(np.sqrt(np.mean(column**2))), 1e-300)
                friction[j, k] = max(friction[j, k], _LEAST_FRICTION * part)
    rotors = _rotors(columns, values)
    return Physical(
        pseudo_inertia_basis(model.dim),
        prior.bodies,
        np.concatenate([rotors, friction.ravel()]),
        np.concatenate([np.full(len(rotors), np.inf), below.ravel()]),
        _OF_MASSES[prior.source],
    )


def _rotors(columns: Columns, values: Array) -> Array:
    """Reflected inertias that are held of rotors: the estimates, where there are such, else the
    largest of the others, since those first in the chain carry most."""
    names = [name for name in columns.inertial_names if name.endswith(".rotor")]
    at = {name: k for k, name in enumerate(columns.base_names)}
    known = np.array([values[at[name]] if name in at else -1.0 for name in names])
    largest = known.max(initial=0.0)
    if largest <= 0.0:
        largest = 1e-2 * float(np.abs(values[: columns.base]).max())
    return np.where(known > 1e-3 * largest, known, np.where(known > -1.0, 1e-3, 1.0) * largest)


def near_edge(model: Model, fit: PhysicalFit) -> list[str]:
    """Names of the bodies that are at the edge of what exists; the pseudo-inertias of the others
    are positive definite by a margin."""
    basis = pseudo_inertia_basis(model.dim)
    bodies = fit.inertial[: len(basis) * len(model.bodies)].reshape(-1, len(basis))
    eigenvalues = np.linalg.eigvalsh(np.einsum("bk,kij->bij", bodies, basis))
    thin = eigenvalues[:, 0] <= _EDGE * eigenvalues[:, -1]
    return [body.name for body, is_thin in zip(model.bodies, thin, strict=True) if is_thin]


def robot(model: Model, columns: Columns, fit: PhysicalFit, doubts: Sequence[str]) -> Model:
    """The model with the masses, rotors and friction of a fit; gears and springs stay. doubts: on
    its masses, which go where it goes."""
    k = len(body_parameters(of_dimension(model.dim)))
    bare = model.without("friction", "rotors", "springs")
    made = bare.with_inertial_parameters(fit.inertial[: k * len(model.bodies)])
    names = list(columns.inertial_names)
    joints = {body.joint.name: body.joint.drive for body in model.bodies}
    for joint, friction in zip(columns.joints, fit.friction, strict=True):
        drive: Any = joints[joint]
        springs = [law for law in LAWS.values() if law.feature == "springs"]
        numbers: dict[str, Any] = {
            number.name: getattr(drive, number.name) for law in springs for number in law.numbers
        }
        numbers["gear"] = drive.gear
        if f"{joint}.rotor" in names:
            reflected = float(fit.inertial[names.index(f"{joint}.rotor")])
            numbers["rotor"] = reflected / float(drive.gear) ** 2
        for x, strength in zip(columns.friction, friction, strict=True):
            numbers[x.law.strength] = float(strength)
            numbers |= x.numbers
        made = with_drive(made, joint, numbers)
    notices = (*made.notices, *(Doubt(ESTIMATED, text) for text in doubts))
    return replace(made, notices=notices)
