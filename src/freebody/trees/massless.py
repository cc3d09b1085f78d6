"""Joints that move no inertia make the mass matrix singular; found once a model, and named."""

from __future__ import annotations

import numpy as np

from freebody.algorithms.crba import crba, supports
from freebody.arrays import Array
from freebody.errors import SingularError, listed
from freebody.model.facts import fact
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.trees.states import generic_state

_NOTHING = 1e-13  # a pivot this small, relative to what it was subtracted from, is rounding
_SAMPLES = 4  # configurations that are looked at


def refuse_massless(model: Model, function: str) -> None:
    """Raise SingularError if some joint moves no inertia at any of a few random configurations."""
    known = massless(model)
    if known:
        joints = listed(map(repr, known))
        several = len(known) > 1
        raise SingularError(
            f"{function}: the mass matrix of {model.name!r} is singular: "
            f"joint{'s' if several else ''} {joints} move{'' if several else 's'} no inertia. "
            f"Give what {'each' if several else 'it'} carries a mass and inertia, or the joint a rotor inertia, or fix "
            "it."
        )


@fact
def massless(model: Model) -> tuple[str, ...]:
    """Coordinates that move no inertia, the loops of a closed chain being cut; found once a model."""
    tree = model.tree
    q, _, _ = generic_state(model, seed=1, batch=_SAMPLES)
    samples = tuple(np.moveaxis(q, -1, 0))
    M = [[x + np.zeros(_SAMPLES) for x in row] for row in crba(tree, samples)]
    idle = [k for k in range(model.nv) if not np.any(M[k][k])]
    if idle:
        return tuple(model.velocity_names[k] for k in idle)
    with np.errstate(all="ignore"):
        pivots = _pivots(tree, M)
        largest = max((np.abs(M[k][k]).max() for k in range(model.nv)), default=0.0)
    bad = []
    for k, pivot in pivots.items():
        floor = np.maximum(_NOTHING * np.abs(M[k][k]), 1e-16 * largest)
        if not np.all(pivot > floor):
            bad.append(k)
            break  # pivots of the joints before it are of no use
    return tuple(model.velocity_names[k] for k in bad)


def _pivots(tree: Tree, M: list[list[Array]]) -> dict[int, Array]:
    """Sizes of D in M = Lᵀ D L, the leaves' first; by whole rows, since a long chain has cubically many products."""
    order = list(supports(tree))
    left = np.array([[M[i][j] for j in order] for i in order]).reshape(len(order), len(order), _SAMPLES)
    pivots = {}
    for i in reversed(range(len(order))):
        row = left[i, :i]
        left[:i, :i] -= (row / left[i, i])[:, None] * row
        pivots[order[i]] = np.abs(left[i, i])
    return pivots
