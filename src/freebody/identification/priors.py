"""Masses that are held of a robot before its logs are read: those of its model, those of a data
sheet, or none but the shape of the arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.consistency import pseudo_inertia_basis
from freebody.labels import aligned
from freebody.model.inertial_parameters import body_parameters
from freebody.model.model import Model
from freebody.spatial import of_dimension
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.regressors import inertial_parameters

_THICK = 0.5
"""Radius of an estimated link, over its length."""
_LEAST = 0.3
"""Length of an estimated link whose joints lie on one another, over the mean length."""
_ROUND = 0.002
"""Part of a given inertia that is added as that of a ball, so that rods and plates, which have no
extent in some direction, do not forbid one."""

_THINNEST = 1e-8
"""Ratio of the eigenvalues of a pseudo-inertia below which no body has it: some published masses
are right, and their inertias impossible; such bodies get the estimated shape."""

PriorSource = Literal["model", "masses", "geometry", "nothing"]


@dataclass(frozen=True)
class Prior:
    """Inertial parameters (bodies, k) held beforehand, and where their masses are from: the model,
    given masses, the shape of the arm alone, whose scale then means nothing, or nothing that
    counts."""

    bodies: Array
    source: PriorSource


def prior_of(model: Model, given: Model | Mapping[str, float] | Sequence[float] | None) -> Prior:
    """The prior from a model with masses, from masses (kg) of the bodies, or from the model that is
    identified, which may lack them. Raises FreebodyError for a mass that is not positive."""
    if isinstance(given, Model):
        if [body.name for body in given.bodies] != [body.name for body in model.bodies]:
            names = ", ".join(body.name for body in model.bodies)
            raise FreebodyError(
                f"identify: prior= is a model with other bodies; it needs those of {model.name!r}: "
                f"{names}."
            )
        return _of_model(given)
    if given is None:
        return _of_model(model)
    names = [body.name for body in model.bodies]
    masses = np.asarray(aligned("identify", "prior", given, names), dtype=float)
    if masses.shape != (len(names),) or not np.all(masses > 0.0):
        raise FreebodyError(
            f"identify: prior= gives masses {masses.tolist()}; expected one above 0 kg for each of "
            f"the bodies {', '.join(names)}."
        )
    return Prior(_rods(model, masses), "masses")


def _of_model(model: Model) -> Prior:
    """The model's own masses; those of estimated shape where bodies have none."""
    k = len(body_parameters(of_dimension(model.dim)))
    values: list[Any] = list(inertial_parameters(model).values())
    own = np.array(values[: len(model.bodies) * k], dtype=float).reshape(-1, k)
    if np.all(own[:, 0] <= 0.0):
        return Prior(_rods(model, _lengths(model)), "geometry")
    masses = np.where(own[:, 0] > 0.0, own[:, 0], 0.01 * own[:, 0].max())
    rods = _rods(model, masses)
    about = np.where(own[:, :1] > 0.0, own, rods) + _ROUND * _spread(model, masses)
    basis = pseudo_inertia_basis(model.dim)
    eigenvalues = np.linalg.eigvalsh(np.einsum("bk,kij->bij", about, basis))
    exists = eigenvalues[:, 0] > _THINNEST * eigenvalues[:, -1]
    return Prior(np.where(exists[:, None], about, rods), "model")


def _rods(model: Model, masses: Array) -> Array:
    """Parameters (bodies, k) of rods of these masses from each body's joint to the next."""
    to_next, radius = _vectors(model), _THICK * _lengths(model)
    rows = []
    for m, v, r in zip(masses, to_next, radius, strict=True):
        second = m * (np.outer(v, v) / 3.0 + r**2 / 4.0 * np.eye(len(v)))
        rows.append(of_moments(m, 0.5 * m * v, second))
    return np.array(rows)


def _spread(model: Model, masses: Array) -> Array:
    """Parameters (bodies, k) of the inertia, without mass, of balls as large as the links."""
    zero = np.zeros(model.dim)
    radius = _THICK * _lengths(model)
    return np.array(
        [
            of_moments(0.0, zero, m * r**2 * np.eye(model.dim))
            for m, r in zip(masses, radius, strict=True)
        ]
    )


def of_moments(m: float, h: Array, second: Array) -> Array:
    """A body's parameters from mass, first moment and second moments about its origin."""
    if len(h) == 2:
        return np.array([m, *h, np.trace(second)])
    inertia = np.trace(second) * np.eye(3) - second
    return np.array([m, *h, *(inertia[i, j] for i in range(3) for j in range(i, 3))])


def _vectors(model: Model) -> Array:
    """Vectors (bodies, dim) from each body's joint to the mean of the next joints, in its axes; of
    the last bodies to the tip or, without one, nowhere."""
    q, dim = np.zeros(model.nq), model.dim
    poses = [forward_kinematics(model, q, frame=body.name) for body in model.bodies]
    ends: list[list[Array]] = [[] for _ in model.bodies]
    for k, body in enumerate(model.bodies):
        if body.parent >= 0:
            ends[body.parent].append(poses[k][:dim, dim])
    return np.array(
        [
            pose[:dim, :dim].T @ (np.mean(end, axis=0) - pose[:dim, dim]) if end else np.zeros(dim)
            for pose, end in zip(poses, ends, strict=True)
        ]
    )


def _lengths(model: Model) -> Array:
    """Lengths (bodies,) of the links, none of them far below the mean."""
    found = np.linalg.norm(_vectors(model), axis=1)
    mean = found.mean() if found.any() else 1.0
    return np.maximum(found, _LEAST * mean)
