"""Base parameters in numbers: the combinations of masses and inertias on which a robot's motion
depends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.algorithms.crba import Composite
from freebody.algorithms.regressor import drives, regressor
from freebody.algorithms.regrouped_parameters import kept, regroup
from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.kernels.formula_variants import refuse_struts
from freebody.model.inertial_parameters import body_parameters
from freebody.model.losses import require_lossless
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.outputs.display import InWords, counted
from freebody.outputs.number_text import weighted_sum
from freebody.trees.positions import generic_state
from freebody.trees.regressors import inertial_parameters

TOLERANCE = 1e-8
"""Relative rest below which a column of the regressor counts as a combination of those before
it."""


@dataclass(frozen=True, eq=False, repr=False)
class BaseParameters(InWords, ByValue):
    """The combinations of inertial parameters on which inverse dynamics depends: tau = Y[...,
    columns] values.

    names: of the inertial parameter that leads each combination. columns: its place in
    `fb.regressor`'s last axis. matrix: (b, p), the combinations: values = matrix π, π =
    `fb.inertial_parameters(model)`. values: (b,).
    """

    names: tuple[str, ...]
    columns: tuple[int, ...]
    matrix: Array
    values: Array
    parameters: tuple[str, ...]

    def _title(self) -> str:
        return f"{counted(len(self), 'base parameter')}: {', '.join(self.names)}"

    def __len__(self) -> int:
        return len(self.names)

    def combination(self, name: str) -> dict[str, float]:
        """The inertial parameters that make up a base parameter, with their weights."""
        row = self.matrix[self.names.index(name)]
        return {other: float(w) for other, w in zip(self.parameters, row, strict=True) if w}

    def __str__(self) -> str:
        lines = []
        for name, value in zip(self.names, self.values, strict=True):
            terms = weighted_sum(self.combination(name).items(), 6)
            lines.append(f"{name}: {value:.6g} = {terms}")
        return "\n".join(lines)


def base_parameters(model: Model) -> BaseParameters:
    """The minimal set of combinations of inertial parameters on which tau depends: regrouped along
    the tree, then reduced by rank.

    In symbols: `fb.equations(model).text("base")`. Raises MissingValueError where a parameter has
    no value.
    """
    model.require_tree("base_parameters")
    refuse_struts("base_parameters", model)
    require_lossless("base_parameters", model)
    values = inertial_parameters(model)
    tree = model.tree
    names = tuple(values)
    candidates, matrix = _regrouped(tree, len(names))
    samples = _samples(model, candidates)
    chosen, weights = independent(samples)
    columns = tuple(candidates[k] for k in chosen)
    combined = weights @ matrix
    combined[np.abs(combined) < TOLERANCE * max(1.0, np.abs(combined).max(initial=0.0))] = 0.0
    found = tuple(names[column] for column in columns)
    return BaseParameters(
        found, columns, combined, combined @ np.array(list(values.values())), names
    )


def _regrouped(tree: Tree, count: int) -> tuple[list[int], Array]:
    """The regressor's columns that stay after regrouping, and the combinations (columns, p) of
    parameters that they multiply."""
    space, size = tree.space, len(body_parameters(tree.space))
    bodies = len(tree.body_of)
    staying = [
        n * size + k
        for n, i in enumerate(tree.body_of)
        for k, name in enumerate(body_parameters(space))
        if name in kept(tree, i)
    ]
    full = np.eye(count)
    for column in range(bodies * size):
        unit = [
            _composite(tree, [float(n * size + k == column) for k in range(size)])
            for n in range(bodies)
        ]
        of_tree: list[Composite] = [_composite(tree, [0.0] * size)] * len(tree.bodies)
        for n, i in enumerate(tree.body_of):
            of_tree[i] = unit[n]
        moved = regroup(tree, of_tree, named=True)
        full[: bodies * size, column] = [x for i in tree.body_of for x in _entries(tree, moved[i])]
    of_drives = sum(len(drive.parameters()) for drive in drives(tree))
    candidates = staying + list(range(bodies * size, bodies * size + of_drives))
    return candidates, full[candidates]


def _composite(tree: Tree, entries: list[float]) -> Composite:
    """The composite (m, h, I) of parameters in the regressor's order."""
    dim = tree.space.dim
    m, h, rest = entries[0], tuple(entries[1 : 1 + dim]), entries[1 + dim :]
    if dim == 2:
        return m, h, rest[0]
    xx, xy, xz, yy, yz, zz = rest
    return m, h, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def _entries(tree: Tree, composite: Composite) -> list[float]:
    """The parameters of a composite (m, h, I) in the regressor's order."""
    m, h, inertia = composite
    I = tree.space.inertia_matrix(inertia)
    return [m, *h, *(I[a][b] for a in range(len(I)) for b in range(a, len(I)))]


def _samples(model: Model, columns: list[int]) -> Array:
    """The regressor's chosen columns at random states, stacked."""
    batch = 4 + 3 * len(columns) // max(1, model.nv)
    q, qd, qdd = (np.moveaxis(x, -1, 0) for x in generic_state(model, seed=0, batch=batch))
    rows = regressor(model.tree, tuple(q), tuple(qd), tuple(qdd))
    return np.concatenate(
        [
            np.stack([np.broadcast_to(row[column], batch) for column in columns], axis=-1)
            for row in rows
        ]
    )


def independent(samples: Array) -> tuple[list[int], Array]:
    """The columns that are no combination of earlier ones, and the weights (chosen, all) by which
    they make up all columns."""
    size = np.linalg.norm(samples, axis=0)
    chosen: list[int] = []
    weights = np.zeros((0, samples.shape[1]))
    for k in range(samples.shape[1]):
        if size[k] <= TOLERANCE * size.max(initial=0.0):
            continue
        if chosen:
            found = np.linalg.lstsq(samples[:, chosen], samples[:, k], rcond=None)[0]
            if np.linalg.norm(samples[:, chosen] @ found - samples[:, k]) <= TOLERANCE * size[k]:
                weights[:, k] = found
                continue
        chosen.append(k)
        weights = np.vstack([weights, np.eye(samples.shape[1])[k]])
    return chosen, weights
