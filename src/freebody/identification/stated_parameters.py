"""The parameters of an identification with the intervals that are stated of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.identification.any_friction import BaseEstimate
from freebody.identification.columns import LOST_ROTOR, Columns
from freebody.identification.identification import IdentifiedParameter, JointFit
from freebody.identification.physical_robot import PhysicalFit
from freebody.identification.regression import Regressed
from freebody.identification.structure import JudgedStructure
from freebody.identification.torque_scale import TorqueScale
from freebody.identification.verdict import QUANTILE
from freebody.model.model import Model

_SMALL = 0.05
"""Part of the largest parameter of its kind below which a parameter counts as small."""
_DETERMINED = 1e-6
"""Part of an inertial parameter that no motion shows, below which it is determined."""


def stated_parameters(
    model: Model,
    columns: Columns,
    first: Regressed,
    base: BaseEstimate,
    fit: PhysicalFit,
    joints: Sequence[JointFit],
    structure: JudgedStructure,
) -> tuple[IdentifiedParameter, ...]:
    """All unknowns with their intervals, those of bodies whatever the friction; wider, or
    withdrawn, where the structure is not what it is taken for."""
    scale = np.full(len(first.values), fit.scale.factor)
    for row in columns.rows:
        if row.load is not None:
            scale[row.load] = 1.0
    value = scale * np.concatenate([base.values, first.values[columns.base :]])
    variance = np.diag(first.covariance).copy()
    variance[: columns.base] = np.diag(base.covariance)
    half = structure.widened * QUANTILE * scale * np.sqrt(np.maximum(variance, 0.0))
    half[np.concatenate([base.untold, first.untold[columns.base :]])] = np.nan
    lower, upper = _with_scale(value, half, fit.scale, [x.load for x in columns.rows])
    kinds = _kinds(model, columns)
    largest = {
        kind: max(abs(v) for v, k in zip(value, kinds, strict=True) if k == kind)
        for kind in set(kinds)
    }
    fits = {x.joint: x.law_fits for x in joints}
    made = []
    for k, name in enumerate(columns.names):
        is_base, joint = k < columns.base, name.rsplit(".", 1)[0]
        told = bool(half[k] <= max(abs(value[k]), _SMALL * largest[kinds[k]]))
        why = structure.withdrawn
        if not is_base and not fits[joint]:
            why = "withdrawn: the law of friction does not fit"
        if why:
            lower[k] = upper[k] = np.nan
        made.append(
            IdentifiedParameter(
                name,
                "inertial" if is_base else "friction",
                kinds[k][1],
                float(value[k]),
                float(lower[k]),
                float(upper[k]),
                float(fit.values[k]),
                told,
                why,
            )
        )
    return tuple(made)


def _with_scale(
    value: Array, half: Array, scale: TorqueScale, losses: Sequence[int | None]
) -> tuple[Array, Array]:
    """Ends of intervals about values, wider by what is not known of the scale, if it is told at
    all; losses, which are parts of torques, have none."""
    least, most = scale.interval(QUANTILE) if np.isfinite(scale.unsure) else (1.0, 1.0)
    ends = np.array([least * value, most * value])
    of_losses = [k for k in losses if k is not None]
    ends[:, of_losses] = value[of_losses]
    below, above = value - ends.min(axis=0), ends.max(axis=0) - value
    return value - np.hypot(half, below), value + np.hypot(half, above)


def _kinds(model: Model, columns: Columns) -> list[tuple[str, str]]:
    """(kind, unit) of each unknown."""
    turns = {body.joint.name: body.kind.turns for body in model.bodies}
    kinds = []
    for name in columns.base_names:
        owner, symbol = name.rsplit(".", 1)
        if symbol == "rotor":
            kinds.append(("rotor", "kg m²" if turns[owner] else "kg"))
        else:
            unit = {"m": "kg", "h": "kg m", "I": "kg m²"}[symbol[0]]
            kinds.append((symbol[0], unit))
    for joint in columns.joints:
        kinds += [(x.law.name, x.law.numbers[0].unit_of(turns[joint])) for x in columns.friction]
    lost = columns.names[columns.base + columns.friction_size :]
    kinds += [(LOST_ROTOR, "kg m²" if turns[name.rsplit(".", 1)[0]] else "kg") for name in lost]
    return kinds


def undetermined(columns: Columns) -> tuple[str, ...]:
    """Inertial parameters that no motion determines, since only combinations of them count."""
    _, size, rows = np.linalg.svd(columns.matrix, full_matrices=False)
    rows = rows[size > 1e-10 * size[0]]
    hidden = 1.0 - (rows**2).sum(axis=0)
    return tuple(
        name for name, x in zip(columns.inertial_names, hidden, strict=True) if x > _DETERMINED
    )
