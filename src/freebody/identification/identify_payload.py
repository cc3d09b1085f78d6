"""`fb.identify_payload`: what an arm carries, from its logs with the load and without."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import chi2

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.columns import (
    Columns,
    friction_laws,
    regression_columns,
)
from freebody.identification.consistency import Physical, nearest_physical, pseudo_inertia_basis
from freebody.identification.drift import FrictionChange, friction_change
from freebody.identification.filters import EVERYTHING
from freebody.identification.given_logs import (
    Logs,
    read_logs,
    require_suited,
    with_torques,
)
from freebody.identification.identified_payload import (
    DENSITY,
    IdentifiedPayload,
    PayloadNumber,
    PayloadOutcome,
    payload_notices,
    payload_verdict,
)
from freebody.identification.load_estimates import (
    LoadEstimate,
    between,
    evidence_of,
    load_estimate,
    load_regression,
    on_frame,
)
from freebody.identification.logs.log import Log
from freebody.identification.priors import of_moments
from freebody.identification.verdict import QUANTILE
from freebody.lazy import kept
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.regressors import inertial_parameters

_UNLIKELY = 1e-4
"""Probability below which logs that differ by more than a load on this frame do so by no
accident."""
_PART_OF_NOISE = 0.05
"""Part of the number of the load's parameters by which chi2 may grow for the prior."""


def identify_payload(
    model: Model,
    loaded: Logs,
    empty: Logs | None = None,
    *,
    frame: str | None = None,
    friction: Sequence[str] | Mapping[str, Any] | None = None,
    gains: Any = None,
    cutoff: float = EVERYTHING,
    name: str = "payload",
) -> IdentifiedPayload:
    """The mass, centre and inertia of what an arm carries, with intervals, from logs with it and
    without it, whose motions need not be the same.

    Friction is estimated anew in the logs of each kind, so that drives may warm up in between.
    Without logs of the empty arm the model's masses and rotors count as known; their errors are
    then in the load, and the verdict says where they show. Method: Khalil, Gautier, Lemoine 2007;
    a load that a body can have: Lee, Wensing, Park 2020.

    Parameters
    ----------
    model
        The robot, an arm on a fixed base; with logs of the empty arm its geometry alone counts.
    loaded, empty
        `fb.Log` or files of `fb.read_log`, one or several: with the load, and without it.
    frame
        That the load is fixed to, in whose axes its numbers are; default: the tip.
    friction
        Laws of friction, as of `fb.identify`.
    gains
        Of the drives (n,), N m/A (N/A), for logs of currents, such as `fb.identify` found.
    cutoff
        Frequency (Hz) up to which columns and torques are compared.
    name
        The load's in the model, which its numbers begin with.

    Returns
    -------
    IdentifiedPayload
        Its `model` carries the load.

    Raises
    ------
    FreebodyError
        Logs too short, or in which a joint rests; a frame that no joint moves; a model without
        masses, and no logs of the empty arm.
    """
    function = "identify_payload"
    require_model(function, model)
    laws = friction_laws(function, model, friction)
    key = f"_regression_columns {laws} True"
    columns = kept(model, key, regression_columns, function, model, laws, True)
    given = None if gains is None else np.broadcast_to(np.asarray(gains, float), (model.nv,))

    def logs_of(argument: str, logs: Logs) -> list[Log]:
        found = read_logs(function, argument, logs, model)
        for log in found:
            require_suited(function, log, columns.joints)
        return [with_torques(function, log, given) for log in found]

    carried = logs_of("loaded", loaded)
    bare = [] if empty is None else logs_of("empty", empty)
    if not carried or (empty is not None and not bare):
        raise FreebodyError(f"{function}: loaded= and empty= need at least one log each.")
    combine = columns.matrix @ on_frame(function, model, frame, columns)
    with_load = load_regression(function, model, columns, carried, cutoff)
    evidence = evidence_of(*with_load)
    changes: tuple[FrictionChange, ...] = ()
    if bare:
        without = load_regression(function, model, columns, bare, cutoff)
        changes = friction_change(*without, *with_load)
        load = load_estimate(combine, *between(evidence_of(*without), evidence))
    else:
        load = load_estimate(combine, evidence.base - _known(model, columns), evidence.information)
    return _result(model, frame, name, load, changes, [*carried, *bare], not bare)


def _known(model: Model, columns: Columns) -> Array:
    """Base parameters (b,) of the model as it is."""
    own: dict[str, Any] = dict(inertial_parameters(model))
    known = [float(own.get(name, 0.0)) for name in columns.inertial_names]
    if not any(known):
        raise FreebodyError(
            f"identify_payload: {model.name!r} has no masses; give empty=, logs without the load, "
            f"or a model that fb.identify has found."
        )
    return columns.matrix @ known


def _numbers(pi: Array) -> Array:
    """Mass, centre, and inertia about it, of a load's parameters π (k,), which may be complex."""
    m, dim = pi[0], 2 if len(pi) == 4 else 3
    h = pi[1 : 1 + dim]
    if dim == 2:
        return np.array([m, *(h / m), pi[3] - (h @ h) / m])
    square = (h @ h) / m
    steiner = [(square if i == j else 0.0) - h[i] * h[j] / m for i in range(3) for j in range(i, 3)]
    return np.array([m, *(h / m), *(pi[4:] - steiner)])


def _slopes(pi: Array) -> Array:
    """(k, k): derivatives of `_numbers`, by complex steps, which are exact."""
    tiny = 1e-30
    steps = pi + 1j * tiny * np.eye(len(pi))
    return np.array([_numbers(x).imag / tiny for x in steps]).T


def _ball(mass: float, centre: Array) -> Array:
    """Parameters of an even ball (a disc in the plane)."""
    dim = len(centre)
    radius = (3.0 * mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0)
    spread = radius**2 / (5.0 if dim == 3 else 4.0) * np.eye(dim)
    return of_moments(mass, mass * centre, mass * (np.outer(centre, centre) + spread))


def _physical(load: LoadEstimate, told: bool, unsure: float) -> Array:
    """The parameters π (k,) of the body nearest to an estimate."""
    dim = 2 if len(load.estimate) == 4 else 3
    mass = float(load.estimate[0]) if told else max(unsure, 1e-3)
    centre = load.estimate[1 : 1 + dim] / mass if told else np.zeros(dim)
    physical = Physical(
        pseudo_inertia_basis(dim), _ball(mass, centre)[None], np.empty(0), np.empty(0)
    )
    k = len(load.estimate)
    return nearest_physical(
        load.estimate, load.information, np.eye(k), physical, _PART_OF_NOISE * k
    ).x


def _result(
    model: Model,
    frame: str | None,
    name: str,
    load: LoadEstimate,
    changes: tuple[FrictionChange, ...],
    logs: Sequence[Log],
    known: bool,
) -> IdentifiedPayload:
    at, dim = model.frame(frame), model.dim
    strange = chi2.sf(load.chi2, load.freedom) < _UNLIKELY
    factor = np.sqrt(load.chi2 / load.freedom)
    wider = QUANTILE * (factor if strange else 1.0)
    unsure = wider * float(np.sqrt(load.covariance[0, 0]))
    told = not load.untold[0] and load.estimate[0] > unsure
    pi = _physical(load, bool(told), unsure)
    made = model.with_payload(
        float(pi[0]), com=_numbers(pi)[1 : 1 + dim], inertia=_tensor(pi), frame=at.name, name=name
    )
    numbers = _listed(load, pi, wider, bool(told), dim)
    outcome: PayloadOutcome = "no payload alone" if strange else "told"
    if not told:
        outcome = "not told"
    notices = [f"{log.source or 'log'}: {text}" for log in logs for text in log.notices]
    notices += payload_notices(numbers, changes, known, factor if strange else 0.0, at.name)
    verdict = payload_verdict(outcome, bool(strange), numbers, at.name, dim)
    return IdentifiedPayload(
        made, at.name, numbers, changes, float(factor), outcome, verdict, tuple(notices)
    )


def _tensor(pi: Array) -> Any:
    own = _numbers(pi)
    return float(own[3]) if len(pi) == 4 else own[4:]


def _listed(
    load: LoadEstimate, pi: Array, wider: float, told: bool, dim: int
) -> tuple[PayloadNumber, ...]:
    """The load's numbers; without a mass that is told neither a centre nor an inertia is."""
    axes = "xyz"[:dim]
    tensor = ["inertia"]
    if dim == 3:
        tensor = [f"inertia.{axes[i]}{axes[j]}" for i in range(3) for j in range(i, 3)]
    names = ["mass", *(f"com.{x}" for x in axes), *tensor]
    units = ["kg", *("m" for _ in axes), *("kg m²" for _ in tensor)]
    with np.errstate(divide="ignore", invalid="ignore"):
        value = _numbers(load.estimate)
        slopes = _slopes(load.estimate)
    half = wider * np.sqrt(np.einsum("ij,jk,ik->i", slopes, load.covariance, slopes))
    hidden = (np.abs(slopes) > 0.0) @ load.untold
    value[hidden] = half[hidden] = np.nan
    if not told:
        value[1:] = half[1:] = np.nan
    in_model = _numbers(pi)
    sizes = np.zeros(len(names))
    sizes[1 : 1 + dim] = max(np.linalg.norm(in_model[1 : 1 + dim]), 0.02)
    sizes[1 + dim :] = np.linalg.norm(in_model[1 + dim :])
    sizes[0] = abs(value[0])
    told_numbers = [bool(x) for x in half <= sizes]
    columns = (names, units, value, value - half, value + half, in_model, told_numbers)
    return tuple(
        PayloadNumber(name, unit, float(v), float(low), float(high), float(m), known)
        for name, unit, v, low, high, m, known in zip(*columns, strict=True)
    )
