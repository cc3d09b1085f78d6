"""`fb.identify`: from logs of a robot to a model of it, with intervals and a verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.advice import what_next
from freebody.identification.agreement import disagreement
from freebody.identification.any_friction import BaseEstimate, with_any_friction
from freebody.identification.columns import (
    Columns,
    friction_laws,
    regression_columns,
)
from freebody.identification.delays import delay_of, earlier
from freebody.identification.drift import drift_notices, friction_drift, of_friction
from freebody.identification.evidence import LogFit, log_fits
from freebody.identification.filters import EVERYTHING
from freebody.identification.given_logs import (
    Logs,
    has_springs,
    read_logs,
    require_suited,
    torques_of,
)
from freebody.identification.identification import (
    Identification,
    JointFit,
    is_known,
)
from freebody.identification.log_equations import LogEquations, equations
from freebody.identification.logs.log import Log
from freebody.identification.misplaced_joints import misplaced_joint
from freebody.identification.physical_robot import PhysicalFit, fit_physical, near_edge, robot
from freebody.identification.priors import Prior, prior_of
from freebody.identification.regression import Regressed, regressed, suited
from freebody.identification.stated_parameters import stated_parameters, undetermined
from freebody.identification.structure import Delay, JudgedStructure
from freebody.identification.torque_scale import TorqueScale, scale_by_load
from freebody.identification.verdict import (
    QUANTILE,
    ToldScale,
    definiteness,
    mass_doubts,
    notices_of,
    outcome_of,
    verdict_of,
)
from freebody.lazy import kept
from freebody.model.model import Model
from freebody.model.model_argument import require_model

_UNLIKELY = 1e-4
"""Probability below which a residual that depends on the rate is no accident."""
_PUT_RIGHT = 3
"""How often, at most, the times of logs are put right, each time by what the last regression told
of them."""


def identify(
    model: Model,
    logs: Logs,
    *,
    validate: Logs = (),
    loaded: Logs = (),
    load: float | None = None,
    friction: Sequence[str] | Mapping[str, Any] | None = None,
    rotors: bool = True,
    prior: Model | Mapping[str, float] | Sequence[float] | None = None,
    cutoff: float = EVERYTHING,
    smooth: float | None = None,
    lmi: bool = False,
) -> Identification:
    """A robot's masses, rotors and friction as its logs tell them, with intervals, and the physical
    model that predicts them.

    Torques are linear in base parameters, combinations of masses and inertias, and in friction:
    these are found by weighted least squares of columns and torques that are filtered alike. Then
    masses are sought that some robot can have, near those held beforehand, which fit the logs as
    well within their noise. Methods: Gautier, Khalil 1990 (base parameters); Hao, Pagani, Beschi,
    Legnani 2021 (friction by load); Lee, Wensing, Park 2020 (prior).

    Parameters
    ----------
    model
        The robot's geometry and gravity; an arm on a fixed base whose joints turn or slide. Its
        masses, where it has some, are held beforehand; its springs are taken as known, its friction
        and rotors are not used.
    logs
        `fb.Log` or files of `fb.read_log`, of torques, or of currents, whose gains (N m/A, N/A)
        are then estimated.
    validate
        Logs that are predicted, and not used for anything else.
    loaded, load
        Logs of currents with a load at the tip, and its mass (kg), which tells the scale of gains;
        they are not used for anything else, and its centre and inertia need not be known.
    friction
        Names of laws, or {name: {number: value}} with the numbers that a law needs besides its
        strength: {"coulomb": {}, "stribeck": {"stribeck_speed": 0.1}}. Default: viscous, coulomb,
        offset, cube_root, quadratic and load, the last only where no joint follows another.
    rotors
        Whether the drives' rotors have unknown inertias.
    prior
        Masses held beforehand: kg of each body, in order or by name, or a model that has them.
    cutoff
        Frequency (Hz) up to which columns and torques are compared.
    smooth
        Rate (rad/s, m/s) within which the sign of dry friction changes, 0 for at once; None: that
        of 0.01, 0.003 and 0.001 which fits best.
    lmi
        Whether the model is to be the physical robot nearest to the base values, by linear matrix
        inequalities (Clarabel, of the extra `lmi`), instead of one near what was held beforehand:
        single masses then mean nothing.

    Returns
    -------
    Identification
        Its `model` is saved by `fb.save`; `str` of it is a report. Where logs speak against the
        geometry, or against one another, intervals are withdrawn or wider, and it is not `trusted`;
        torques that are late are put in time (`structure`).

    Raises
    ------
    FreebodyError
        Logs without torques and currents, too short, or in which a joint does not move; logs with a
        load that do not show it.
    PassiveJointError, UnknownNameError, MissingPackageError
    """
    require_model("identify", model)
    used = read_logs("identify", "logs", logs, model)
    unseen = read_logs("identify", "validate", validate, model)
    carrying = read_logs("identify", "loaded", loaded, model)
    _require_load(carrying, load)
    if not used:
        raise FreebodyError("identify: logs= is empty; give at least one log, or its file.")
    laws = friction_laws("identify", model, friction)
    key = f"_regression_columns {laws} {rotors}"
    columns = kept(model, key, regression_columns, "identify", model, laws, rotors)
    held = prior_of(model, prior)
    for log in (*used, *unseen, *carrying):
        require_suited("identify", log, columns.joints)
    found, first, base, delay = _in_time(model, columns, used, held, cutoff, smooth)
    late = delay.seconds if delay is not None and delay.corrected else 0.0
    drift = friction_drift(found, first)
    columns, by_current = found.columns, found.currents
    both = (earlier(used, late), earlier(carrying, late))
    known = _scale(model, found, first, both, load, held, cutoff)
    fit = fit_physical(model, found, first, held, known, lmi)
    told = ToldScale(fit.scale.interval(QUANTILE), load)
    if lmi:
        held = replace(held, source="nothing")
    if columns.by_load and not found.transmit_alike(fit.values, first.values):
        found.put_loads(fit.values)
    gains = _gains(found, fit) if by_current else None
    checked, fits = _validated(columns, model, earlier(unseen, late), gains, fit, cutoff)
    own = np.ones(model.nv) if gains is None else gains
    joints = _joint_fits(found, first, fit, gains, checked, base.accident)
    made = robot(model, columns, fit, mass_doubts(held, told))
    misplaced = misplaced_joint(made, found, first, base, fit.scale.factor)
    structure = JudgedStructure(delay, misplaced, disagreement(found, first, base))
    parameters = stated_parameters(model, columns, first, base, fit, joints, structure)
    outcome = outcome_of(joints)
    untold = tuple(x.name for x in parameters if x.kind == "inertial" and not x.told)
    notices = [
        f"{log.source or 'log'}: {text}"
        for log in (*used, *unseen, *carrying)
        for text in log.notices
    ]
    notices += notices_of(held, told, joints, untold, structure)
    notices.append(definiteness(near_edge(model, fit)))
    notices += drift_notices(drift)
    return Identification(
        made,
        parameters,
        joints,
        columns.matrix,
        columns.inertial_names,
        undetermined(columns),
        untold,
        gains,
        told.factors,
        fit.weight,
        outcome,
        verdict_of(outcome, joints, told, held, structure),
        tuple(notices),
        drift,
        what_next(parameters, joints, drift, outcome, is_known(told.factors), structure),
        (*log_fits(found, fit.values, own, False), *fits),
        structure,
    )


def _in_time(
    model: Model,
    columns: Columns,
    logs: Sequence[Log],
    held: Prior,
    cutoff: float,
    smooth: float | None,
) -> tuple[LogEquations, Regressed, BaseEstimate, Delay | None]:
    """The regression of logs and their base parameters whatever the friction, torques and positions
    being of the same time; and by how much they were not."""
    late: Delay | None = None
    for more in reversed(range(_PUT_RIGHT + 1)):
        before = 0.0 if late is None else late.seconds
        found, first, base = _estimated(model, columns, earlier(logs, before), held, cutoff, smooth)
        told = delay_of(found, first, base, before) if more else None
        late = told or late
        if told is None:
            break
        if not told.corrected:
            if before:  # what was put right so far was not all: the logs stay as they are
                found, first, base = _estimated(model, columns, logs, held, cutoff, smooth)
            break
    return found, first, base, late


def _estimated(
    model: Model,
    columns: Columns,
    logs: Sequence[Log],
    held: Prior,
    cutoff: float,
    smooth: float | None,
) -> tuple[LogEquations, Regressed, BaseEstimate]:
    """The regression of logs and their base parameters whatever the friction."""
    found, first = _solved(model, columns, logs, held, cutoff, smooth)
    return found, first, with_any_friction(found, first)


def _solved(
    model: Model,
    columns: Columns,
    logs: Sequence[Log],
    held: Prior,
    cutoff: float,
    smooth: float | None,
) -> tuple[LogEquations, Regressed]:
    """The equations of logs, of torques or of currents, and their regression."""
    torques = [torques_of(model, log) for log in logs]
    by_current = any(x is None for x in torques)
    _require_alike(model, logs, by_current)
    given = None if by_current else [x for x in torques if x is not None]
    of_prior = columns.matrix[:, : held.bodies.size] @ held.bodies.ravel() if by_current else None
    start = None
    if smooth is None:
        columns, start = suited("identify", columns, logs, given, cutoff, of_prior)
    else:
        columns = replace(columns, smooth=smooth)
    start = None if by_current else start
    found = equations("identify", columns, logs, given, cutoff, start)
    return found, regressed(found, of_prior, start)


def _require_load(loaded: Sequence[Log], load: float | None) -> None:
    if bool(loaded) != (load is not None):
        raise FreebodyError(
            "identify: loaded= and load= (--loaded and --load) go together: logs with a load at "
            "the tip, and its mass in kg."
        )
    if load is not None and not (np.isfinite(load) and load > 0.0):
        raise FreebodyError(f"identify: load= is {load!r}; expected its mass, above 0 kg.")


def _scale(
    model: Model,
    found: LogEquations,
    first: Regressed,
    logs: tuple[Sequence[Log], Sequence[Log]],
    load: float | None,
    held: Prior,
    cutoff: float,
) -> TorqueScale | None:
    """The scale of the torques, or None where masses held beforehand are to tell it. logs: without
    and with a load, of that mass."""
    if load is None:
        if not found.currents:
            return TorqueScale(1.0, 0.0)
        return TorqueScale(1.0, np.inf) if held.source == "geometry" else None
    if not found.currents:
        raise FreebodyError(
            "identify: logs= tell torques, so that no load needs to tell their scale; leave out "
            "loaded= and load=, or use fb.identify_payload, which finds the load."
        )
    return scale_by_load(model, found.columns, *logs, load, first, cutoff)


def _require_alike(model: Model, logs: Sequence[Log], by_current: bool) -> None:
    if not by_current:
        return
    for log in logs:
        if log.torque is not None or log.current is None:
            raise FreebodyError(
                "identify: some logs have torques and others currents alone; give torque constants "
                "for these, in the TOML file beside the log, or logs of one kind."
            )
    if has_springs(model):
        raise FreebodyError(
            f"identify: {model.name!r} has springs, whose torques are known, and the logs have "
            f"currents with unknown gains; give torque constants in the TOML file beside the log."
        )


def _gains(found: LogEquations, fit: PhysicalFit) -> Array:
    """The gains with which a physical robot explains the currents best."""
    pairs = zip(found.rows, found.sums(fit.values), strict=True)
    return np.array([(total @ total) / (total @ rows.y) for rows, total in pairs])


def _validated(
    columns: Columns,
    model: Model,
    logs: Sequence[Log],
    gains: Array | None,
    fit: PhysicalFit,
    cutoff: float,
) -> tuple[list[float | None], tuple[LogFit, ...]]:
    """RMS of what the model leaves of unseen logs, over that of the torque, joint by joint; and
    these logs beside its predictions."""
    if not logs:
        return [None] * len(columns.joints), ()
    torques = [_predicted_torques(model, log, gains) for log in logs]
    found = equations("identify", columns, logs, torques, cutoff)
    if columns.by_load:
        found.put_loads(fit.values)
    pairs = zip(found.rows, found.sums(fit.values), strict=True)
    left: list[float | None] = [_rms(rows.y - total) / _rms(rows.y) for rows, total in pairs]
    return left, log_fits(found, fit.values, np.ones(len(left)), True)


def _predicted_torques(model: Model, log: Log, gains: Array | None) -> Array:
    torques = torques_of(model, log)
    if torques is not None:
        return torques
    if log.current is None or gains is None:
        raise FreebodyError(
            f"identify: the log {log.source!r} to validate with has currents alone, and the others "
            f"torques; give its torque constants in the TOML file beside it."
        )
    return log.current * gains


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _joint_fits(
    found: LogEquations,
    first: Regressed,
    fit: PhysicalFit,
    gains: Array | None,
    checked: Sequence[float | None],
    accident: Array,
) -> tuple[JointFit, ...]:
    fits = []
    totals = found.sums(fit.values)
    known = first.gains if gains is None else gains
    for j, rows in enumerate(found.rows):
        y, residual = first.gains[j] * rows.y, first.residuals[j]
        fits.append(
            JointFit(
                found.columns.joints[j],
                fit.scale.factor * _rms(y),
                _rms(residual) / _rms(y),
                _rms(known[j] * rows.y - totals[j]) / (known[j] * _rms(rows.y)),
                checked[j],
                float(first.inflation[j] / found.inflation),
                bool(accident[j] > _UNLIKELY),
                _friction_part(found, first, j),
            )
        )
    return tuple(fits)


def _friction_part(found: LogEquations, first: Regressed, j: int) -> float:
    """The part of a joint's torque that the regression takes for friction, without constant
    torques, as far as it goes with the rate; negative where it pushes."""
    rows = found.rows[j]
    own = of_friction(found.columns, rows)
    friction = rows.x[:, own] @ first.values[rows.unknowns[own]]
    size = np.linalg.norm(rows.rate) * np.linalg.norm(first.gains[j] * rows.y)
    return float(friction @ rows.rate / size)
