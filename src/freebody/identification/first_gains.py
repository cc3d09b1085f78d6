"""Gains of drives to begin with, from currents alone: K i = Y β + F φ is linear in all of its
unknowns and fixes them up to one factor, so that the gains are an eigenvector and need no guess.

Newton's method on the gains, which weighs the joints by their noise, goes to the wrong end from
afar: where bodies lie unlike those held beforehand, gains from these are wrong by factors of 100.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array

if TYPE_CHECKING:
    from freebody.identification.log_equations import JointEquations

_SURE = 10.0
"""Standard deviations above which a gain is taken from a joint's own current."""
_SAME = 1e-10
"""Part of the largest eigenvalue below which columns are the same combination."""


def first_gains(rows: Sequence[JointEquations], held: Array) -> Array:
    """Gains (n,) with which currents agree best with any bodies and friction; scaled as base
    parameters (b,) that are held beforehand suggest. Of a joint whose current bodies hardly show in
    the mean of the others'."""
    b, n = len(held), len(rows)
    bodies, across, size = np.zeros((b, b)), np.zeros((b, n)), np.zeros(n)
    left = np.zeros(n)
    for j, x in enumerate(rows):
        size[j] = np.sqrt(x.y @ x.y)
        base = np.flatnonzero(x.unknowns < b)
        columns = np.column_stack([x.x[:, base], x.y / size[j]])
        local = x.x[:, len(base) : -1]
        mixed = local.T @ columns
        products = columns.T @ columns - mixed.T @ inverse_products(local.T @ local) @ mixed
        places = x.unknowns[base]
        bodies[np.ix_(places, places)] += products[:-1, :-1]
        across[places, j], left[j] = products[:-1, -1], products[-1, -1]
    inverse = inverse_products(bodies)
    values, vectors = np.linalg.eigh(np.diag(left) - across.T @ inverse @ across)
    torque = vectors[:, 0] * np.sign(vectors[:, 0].sum() or 1.0)
    gaps = np.maximum(values[1:] - values[0], 1e-300)
    noise = max(values[0], 0.0) / sum(len(x.y) for x in rows)
    unsure = np.sqrt(noise * (vectors[:, 1:] ** 2 / gaps).sum(axis=1))
    sure = torque > _SURE * np.maximum(unsure, 1e-9)
    gains = np.ones(n)
    gains[sure] = torque[sure] / size[sure]
    gains[~sure] = np.exp(np.log(gains[sure]).mean()) if sure.any() else 1.0
    found = inverse @ (across @ (gains * size))
    along, whole = held @ bodies @ found, held @ bodies @ held
    return gains * (whole / along if along > 0.0 else 1.0)


def inverse_products(products: Array) -> Array:
    """The inverses of products (..., c, c) of columns with each other, without combinations that
    are 0."""
    size = np.sqrt(np.maximum(np.diagonal(products, axis1=-2, axis2=-1), 0.0))
    size = np.where(size == 0.0, 1.0, size)
    scale = size[..., :, None] * size[..., None, :]
    values, vectors = np.linalg.eigh(products / scale)
    told = np.abs(values) > _SAME * np.abs(values).max(axis=-1, initial=0.0)[..., None]
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=told)
    return np.asarray((vectors * inverse[..., None, :]) @ np.swapaxes(vectors, -1, -2) / scale)
