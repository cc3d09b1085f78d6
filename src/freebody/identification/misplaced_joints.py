"""Joints that are not where the model has them: wrong lengths, zeros and directions of axes, as
they show in torques.

A joint that is displaced by a little changes the torques by a column, their derivative by its
place. Displacements that other bodies would explain as well, such as a height of the
base, are no matter: they change neither base parameters nor torques.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from freebody.algorithms.displaced_joints import by_displacements
from freebody.arrays import Array
from freebody.identification.any_friction import BaseEstimate
from freebody.identification.further_columns import middles, standing_out
from freebody.identification.log_equations import LogEquations, Prepared
from freebody.identification.logs.log import LogStates
from freebody.identification.regression import Regressed
from freebody.identification.structure import Displacement, Misplaced
from freebody.model.model import Model

_SAME_AXIS = 1.0 - 1e-9
"""Cosine of the angle between a direction and a joint's axis from which on they are one."""


def misplaced_joint(
    model: Model,
    found: LogEquations,
    first: Regressed,
    base: BaseEstimate,
    scale: float,
) -> Misplaced | None:
    """The displacement of a joint that stands out of what the regression leaves, or None.

    model: with bodies near the identified ones. scale: of its torques over the equations'.
    """
    bare = model.without("friction", "rotors", "springs")
    looked_at, residuals, own = middles(found, first, base)
    torques = _changes(bare, looked_at) / scale
    columns = [torques[rows.places, j] for j, rows in enumerate(looked_at.rows)]
    told = standing_out(looked_at, residuals, own, columns)
    if told is None:
        return None
    displacements = list(_displacements(bare))
    others = tuple(displacements[k].text(size) for k, size in told.others)
    return Misplaced(displacements[told.place], told.value, told.half, others, told.moved)


def _displacements(model: Model) -> Iterator[Displacement]:
    """The ways in which joints may be misplaced: shifts of each along its axes, and turns."""
    dim = model.dim
    ways = [(k, False) for k in range(dim)] + [(k, True) for k in (range(3) if dim == 3 else (2,))]
    for body in model.bodies:
        axis = np.zeros(3)
        if dim == 2 and body.kind.turns:
            axis[2] = 1.0
        else:
            axis[:dim] = body.joint.axis
        for k, is_turn in ways:
            of_zero = is_turn == body.kind.turns and abs(axis[k]) > _SAME_AXIS
            yield Displacement(body.joint.name, "xyz"[k], is_turn, bool(of_zero))


def _changes(model: Model, found: LogEquations) -> Array:
    """Changes (samples, n, displacements) of torques with each displacement, at the samples kept,
    whose states are as slow as the torques are."""
    states = np.concatenate([_slow(p) for p in found.prepared], axis=1)
    tree, size = model.tree, states.shape[1]
    changes = by_displacements(tree, *(tuple(x) for x in np.split(states, 3)))
    return np.stack(
        [
            np.stack([np.broadcast_to(x, size) for x in row], axis=1)
            for i in tree.body_of
            for row in changes[i]
        ],
        axis=2,
    )


def _slow(p: Prepared) -> Array:
    """Positions, rates and accelerations (3 n, samples) at a log's kept samples."""
    found = [x for _, x in p.filter.filtered(p.places, lambda part: _joined(p.states, part))]
    return np.concatenate(found).T


def _joined(states: LogStates, part: slice) -> Array:
    return np.concatenate([x[part] for x in states], axis=1)
