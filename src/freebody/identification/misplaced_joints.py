"""Joints that are not where the model has them: wrong lengths, zeros and directions of axes, as
they show in torques.

A joint that is displaced by a little changes the torques by a column that is the difference of two
robots' torques. Displacements that other bodies would explain as well, such as a height of the
base, are no matter: they change neither base parameters nor torques.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.identification.any_friction import BaseEstimate
from freebody.identification.calibration.chain import turned
from freebody.identification.further_columns import middles, standing_out
from freebody.identification.log_equations import LogEquations, Prepared
from freebody.identification.regression import Regressed
from freebody.identification.structure import Displacement, Misplaced
from freebody.model.model import Model
from freebody.model.piece_paths import put
from freebody.model.placement import rotate, shift
from freebody.ways_out.kernel import formula

_STEP = 1e-5
"""Displacement (m, rad) by whose torques the change with it is taken."""
_SAME_AXIS = 1.0 - 1e-9
"""Cosine of the angle between a direction and a joint's axis from which on they are one."""


def misplaced_joint(
    model: Model,
    found: LogEquations,
    first: Regressed,
    base: BaseEstimate,
    scale: float,
    cutoff: float,
) -> Misplaced | None:
    """The displacement of a joint that stands out of what the regression leaves, or None.

    model: with bodies near the identified ones. scale: of its torques over the equations'.
    cutoff: up to which these have frequencies, Hz.
    """
    bare = model.without("friction", "rotors", "springs")
    looked_at, residuals = middles(found, first)
    ways = list(_ways(bare))
    torques = _changes(bare, looked_at, ways, cutoff) / scale
    columns = [torques[rows.places, j] for j, rows in enumerate(looked_at.rows)]
    told = standing_out(looked_at, residuals, base, columns)
    if told is None:
        return None
    displacements = [way for way, _ in ways]
    others = tuple(displacements[k].text(size) for k, size in told.others)
    return Misplaced(displacements[told.place], told.value, told.half, others, told.moved)


def _ways(model: Model) -> Iterator[tuple[Displacement, Model]]:
    """The ways in which joints may be misplaced, each with the model that has a small one."""
    dim = model.dim
    turns = range(3) if dim == 3 else (2,)
    for i, body in enumerate(model.bodies):
        joint, axis = body.joint, np.zeros(3)
        if dim == 2 and body.kind.turns:
            axis[2] = 1.0
        else:
            axis[:dim] = joint.axis
        steps = [(k, False, shift(*(_STEP * np.eye(dim)[k]))) for k in range(dim)]
        steps += [(k, True, rotate(turned(_STEP * np.eye(3)[k])[:dim, :dim])) for k in turns]
        for k, is_turn, step in steps:
            of_zero = is_turn == body.kind.turns and abs(axis[k]) > _SAME_AXIS
            moved = replace(joint, placement=joint.placement.then(step))
            way = Displacement(joint.name, "xyz"[k], is_turn, bool(of_zero))
            yield way, put(model, ("bodies", i, "joint"), moved)


def _changes(
    model: Model, found: LogEquations, ways: list[tuple[Displacement, Model]], cutoff: float
) -> Array:
    """Changes (samples, n, ways) of torques with each displacement, at the samples kept."""
    states = [_slow(p, cutoff) for p in found.prepared]
    q, qd, qdd = (np.concatenate(x).T for x in zip(*states, strict=True))

    def torques(robot: Model) -> Array:
        each = formula(robot, "inverse_dynamics")(q, qd, qdd)
        return np.stack([np.broadcast_to(x, q.shape[1]) for x in each], axis=1)

    own = torques(model)
    return np.stack([(torques(robot) - own) / _STEP for _, robot in ways], axis=2)


def _slow(p: Prepared, cutoff: float) -> tuple[Array, Array, Array]:
    """Positions, rates and accelerations at a log's kept samples, as slow as its torques are."""
    q, qd, qdd = p.log.states(cutoff)
    return q[p.places], qd[p.places], qdd[p.places]
