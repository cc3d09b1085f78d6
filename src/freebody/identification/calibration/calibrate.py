"""`fb.calibrate`: from measured poses of a robot's tip to its geometry, with intervals and a
verdict."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, KindError, ShapeError, listed
from freebody.identification.calibration.calibration import (
    CalibratedParameter,
    Calibration,
    CalibrationOutcome,
    Combination,
    PoseErrors,
    combinations_of,
    source_of,
)
from freebody.identification.calibration.chain import MeasuredChain, chain_to
from freebody.identification.calibration.fit import (
    CalibrationFit,
    fit,
    marker_doubt,
    require_enough,
)
from freebody.identification.calibration.instrument import FittedPose, guess
from freebody.identification.calibration.misfit import misfits_of
from freebody.identification.calibration.poses import Poses, poses_of, rotations
from freebody.identification.calibration.read_poses import read_poses
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.outputs.display import counted
from freebody.trees.positions import random_state

_CONFIDENCE = 0.975
"""Probability up to the upper end of an interval of 95 %."""
_NO_BETTER = 0.9
"""Part of the errors before that is left where a calibration is of no use."""
_WORSE = 1.5
"""Factor by which held-out poses, or noise, may be worse than they should be."""
_SURPRISING = 4.0
"""Standard deviations of the prior by which the robot may differ from its model."""
_WILD = 0.1
"""Part of the poses that may be wild."""
_PLACED = 0.02
"""Standard deviation of the marker's place (m) from which on it is not told."""
_CANDIDATES, _NEXT = 256, 5

MeasuredPoses = Poses | str | os.PathLike[str] | tuple[ArrayLike, ArrayLike]


def calibrate(
    model: Model,
    q: Any,
    poses: ArrayLike | None = None,
    *,
    frame: str | None = None,
    validate: MeasuredPoses | None = None,
    instrument: ArrayLike | None = None,
    marker: ArrayLike | None = None,
    shift: float = 1e-3,
    turn: float = 1e-3,
    offset: float = 1e-3,
    gears: float | None = None,
    noise: float | Sequence[float] | None = None,
) -> Calibration:
    """A robot's geometry as measured poses of its tip tell it: how far each joint's frame and zero
    are off, with intervals, and which of that comes from the prior alone.

    The frame of each joint is displaced by a small shift and turn behind its placement in the
    model. Not all of these show at the tip, nor do they show apart from where instrument and marker
    are; what the poses cannot tell stays near the model, within the standard deviations given, and
    is said to. Methods: Hollerbach, Wampler 1996 (calibration as one problem); Mooring, Roth,
    Driels 1991 (what poses do not tell); Okamura, Park 1996 (product of exponentials); Shah 2013
    (instrument and marker); Huber 1964 (wild poses).

    Parameters
    ----------
    model
        The robot as it was designed, on a fixed base.
    q
        Readings (n, nq) of the joints, rad and m, in the model's order; or both readings and poses,
        as `fb.Poses` or a file of `fb.read_poses`.
    poses
        What the instrument saw of the marker, in its own axes: positions (n, 3) in m, or poses
        (n, 4, 4). Row by row those of q.
    frame
        The frame that carries the marker, the tip if None.
    validate
        Poses that are predicted, and used for nothing else: as a file, or (q, poses).
    instrument
        Its pose (4, 4) in the world, found if None.
    marker
        Its place (3,), m, or with rotations its pose (4, 4), in `frame`; found if None.
    shift, turn, offset
        By how much the robot may differ from its model, beforehand: standard deviations of shifts
        (m) and turns (rad) of the joints' frames, and of the joints' zeros (rad or m).
    gears
        Standard deviation of factors of the readings, such as 1e-3; None: they are exact.
    noise
        Standard deviation of each measured coordinate: m, or (m, rad); estimated if None.

    Returns
    -------
    Calibration
        Its `model` is saved by `fb.save`; `str` of it is a report.

    Raises
    ------
    FreebodyError
        Poses that are not those of the robot, in other units or axes, or in another order, or that
        are too few.
    ShapeError, NotFiniteError, FileError, UnknownNameError
    """
    require_model("calibrate", model)
    chain = chain_to(model, frame, gears is not None)
    seen = _poses("q", model, q if poses is None else (q, poses))
    unseen = None if validate is None else _poses("validate", model, validate)
    if unseen is not None and (unseen.rotation is None) != (seen.rotation is None):
        raise FreebodyError(
            "calibrate: of q and validate, one has rotations and the other positions alone; "
            "measure both alike."
        )
    spread = _spread(chain, shift, turn, offset, gears)
    stated = _noise(noise, seen)
    held = _instrument(instrument), _marker(marker, seen)
    unknown = held[0] is None, held[1] is None
    require_enough(chain, seen, held, spread)
    start = guess(chain, seen, *held)
    first = fit(chain, seen, start, unknown, None, None)
    found = fit(chain, seen, start, unknown, spread, stated)
    return _calibration(first, found, unseen)


def _poses(argument: str, model: Model, given: Any) -> Poses:
    """Poses as they are given, from a file, or from arrays."""
    if isinstance(given, Poses):
        seen: Array = given.position
        if given.rotation is not None:
            seen = np.tile(np.eye(4), (len(given), 1, 1))
            seen[:, :3, :3], seen[:, :3, 3] = given.rotation, given.position
        found = poses_of("calibrate", model, given.q, seen)
        return replace(found, source=given.source, notices=given.notices)
    if isinstance(given, str | os.PathLike):
        return read_poses(given, model)
    if isinstance(given, tuple) and len(given) == 2:
        return poses_of("calibrate", model, *given)
    raise KindError(
        "calibrate", argument, given, "poses of fb.read_poses, their file, or q with poses"
    )


def _spread(
    chain: MeasuredChain, shift: float, turn: float, offset: float, gears: float | None
) -> Array:
    """Standard deviations of the geometry beforehand."""
    a, b = (
        above_zero("calibrate", "shift", shift, "m"),
        above_zero("calibrate", "turn", turn, "rad"),
    )
    own = [a, a, a, b, b, b, above_zero("calibrate", "offset", offset, "rad or m")]
    if gears is not None:
        own.append(above_zero("calibrate", "gears", gears))
    return np.tile(own, len(chain.bodies))


def _noise(given: Any, seen: Poses) -> Array | None:
    """Stated noise of positions and rotations."""
    if given is None:
        return None
    found = np.atleast_1d(as_floats("calibrate", "noise", given))
    if found.shape != ((1,) if seen.rotation is None else (2,)) or not np.all(
        (found > 0.0) & np.isfinite(found)
    ):
        expected = "m" if seen.rotation is None else "(m, rad)"
        raise FreebodyError(
            f"calibrate: noise is {given!r}, expected {expected} above 0, the standard deviation "
            f"of each coordinate."
        )
    return found


def _instrument(given: ArrayLike | None) -> FittedPose | None:
    """The pose of the world in the instrument's axes, from that of the instrument in the world."""
    if given is None:
        return None
    T = _pose("instrument", given)
    return FittedPose(T.R.T, -T.R.T @ T.p)


def _marker(given: ArrayLike | None, seen: Poses) -> FittedPose | None:
    if given is None:
        return None
    place = as_floats("calibrate", "marker", given)
    if place.shape == (3,) and seen.rotation is None:
        refuse_not_finite("calibrate", "marker", place, 1, "xyz")
        return FittedPose(np.eye(3), place)
    return _pose("marker", given)


def _pose(argument: str, given: ArrayLike) -> FittedPose:
    T = as_floats("calibrate", argument, given)
    if T.shape != (4, 4):
        raise ShapeError("calibrate", argument, T.shape, "a pose (4, 4)")
    refuse_not_finite("calibrate", argument, T, 2)
    return FittedPose(rotations("calibrate", argument, T[None, :3, :3])[0], T[:3, 3])


def _calibration(first: CalibrationFit, found: CalibrationFit, unseen: Poses | None) -> Calibration:
    """The result of a fit; first: that of instrument and marker alone."""
    chain, k, kept = found.chain, found.geometry, found.kept
    names, spread = chain.names, found.spread[:k]
    root = found.root[:k]
    unsure, more = marker_doubt(found)
    covariance = root @ root.T + more
    parameters = _parameters(found, covariance)
    combinations = combinations_of(names, covariance, found.x / spread)
    errors = {
        "before": _errors(first.residuals(found.poses.of(kept)).kinds),
        "after": _errors(found.residuals(found.poses.of(kept)).kinds),
        "apart": _errors([x[kept] for x in found.without_each()]),
        "validation": None if unseen is None else _errors(found.residuals(unseen).kinds),
        "validation_before": None if unseen is None else _errors(first.residuals(unseen).kinds),
    }
    left_out = tuple(np.flatnonzero(~kept).tolist())
    misfits = misfits_of(found)
    loud = found.given and _loud(found)
    outcome = _outcome(found, errors, bool(misfits) or loud)
    factors = np.ones(chain.model.nq)
    if chain.gears:
        factors[list(chain.columns)] += chain.rows(found.x)[:, 7]
    R, p = found.instrument
    return Calibration(
        chain.calibrated(found.x),
        chain.frame,
        parameters,
        tuple(combinations),
        covariance * np.outer(spread, spread),
        factors,
        _matrix(FittedPose(R.T, -R.T @ p)),
        _matrix(found.marker),
        PoseErrors(float(found.noise[0]), float(found.noise[1]) if len(found.noise) > 1 else None),
        left_out=left_out,
        misfits=misfits,
        next_poses=_next_poses(found),
        outcome=outcome,
        verdict=_verdict(outcome, errors, combinations, misfits, loud),
        notices=_notices(found, left_out, combinations, unsure),
        **errors,  # type: ignore[arg-type]  # those that are None may be
    )


def _matrix(pose: FittedPose) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = pose
    return T


def _errors(residuals: Sequence[Array]) -> PoseErrors:
    """Root mean squares of the lengths of residuals (n, 3) of each kind."""
    found = [float(np.sqrt(np.mean(np.sum(x**2, axis=1)))) for x in residuals]
    return PoseErrors(found[0], found[1] if len(found) > 1 else None)


def _parameters(found: CalibrationFit, covariance: Array) -> tuple[CalibratedParameter, ...]:
    from scipy.stats import norm, t

    wide = norm.ppf(_CONFIDENCE) if found.given else t.ppf(_CONFIDENCE, min(found.freedom))
    made = []
    shares = np.clip(np.diag(covariance), 0.0, 1.0)
    for name, unit, value, prior, share in zip(
        found.chain.names, found.chain.units, found.x, found.spread, shares, strict=False
    ):
        half = float(wide * prior * np.sqrt(share))
        value, prior, share = float(value), float(prior), float(share)
        made.append(
            CalibratedParameter(
                name, unit, value, value - half, value + half, prior, share, source_of(share)
            )
        )
    return tuple(made)


def _loud(found: CalibrationFit) -> bool:
    """Whether more is left than the stated noise explains."""
    _, rest = found.whitened(found.residuals(found.poses.of(found.kept)))
    return float(np.sum(rest**2) / np.sum(found.freedom)) > _WORSE**2


def _ratio(a: PoseErrors, b: PoseErrors) -> float:
    """The larger of the ratios of two errors' positions and rotations."""
    pairs = [(a.position, b.position)]
    if a.rotation is not None and b.rotation is not None:
        pairs.append((a.rotation, b.rotation))
    return max(x / max(y, 1e-300) for x, y in pairs)


def _outcome(found: CalibrationFit, errors: Any, misfit: bool) -> CalibrationOutcome:
    before, apart = errors["before"], errors["apart"]
    unseen, unseen_before = errors["validation"], errors["validation_before"]
    wild = np.mean(~found.kept) > _WILD
    if misfit or wild or (unseen and _ratio(unseen, apart) > _WORSE):
        return "does not fit"
    checked = (apart, before) if unseen is None else (unseen, unseen_before)
    better = min(_ratio(PoseErrors(x.position, None), y) for x, y in [checked]) < _NO_BETTER
    turns = checked[0].rotation
    if turns is not None and turns < _NO_BETTER * checked[1].rotation:
        better = True
    return "calibrated" if better else "no better"


def _verdict(
    outcome: CalibrationOutcome,
    errors: Any,
    combinations: Sequence[Combination],
    misfits: Sequence[str],
    loud: bool,
) -> str:
    """The verdict in two sentences."""
    unseen = errors["validation"]
    shown, before, how = (
        (errors["apart"], errors["before"], "each pose predicted from the others")
        if unseen is None
        else (unseen, errors["validation_before"], "poses that were used for nothing else")
    )
    measured = sum(x.source == "measured" for x in combinations)
    prior = sum(x.source == "prior" for x in combinations)
    told = (
        f"{counted(measured, 'combination')} of {len(combinations)} numbers are measured, {prior} "
        f"are the prior's alone."
    )
    if outcome == "calibrated":
        return f"Calibrated: {shown} are left of {before} (RMS, {how}). {told}"
    if outcome == "no better":
        return (
            f"No better than the model as it was: {shown} are left of {before} (RMS, {how}). {told}"
        )
    if misfits:
        why = f"what is left depends on {misfits[0]}"
    elif loud:
        why = "more is left than the stated noise"
    elif unseen is not None and _ratio(unseen, errors["apart"]) > _WORSE:
        why = "held-out poses are predicted worse than those that were used"
    else:
        why = "many poses are wild"
    return (
        f"Does not fit: {shown} are left of {before} (RMS, {how}), but {why}; so intervals are too "
        f"narrow. {told}"
    )


def _notices(
    found: CalibrationFit,
    left_out: Sequence[int],
    combinations: Sequence[Combination],
    unsure: float,
) -> tuple[str, ...]:
    """Sentences on what was left out, what surprises, and what the result does not hold."""
    said = list(found.poses.notices)
    if left_out:
        one = len(left_out) == 1
        said.append(
            f"Pose{'' if one else 's'} {listed(map(str, left_out), 12)} (counted from 0) "
            f"{'is' if one else 'are'} left out: noise explains {'it' if one else 'them'} by no "
            f"accident."
        )
    far = max((abs(x.value) for x in combinations if x.source == "measured"), default=0.0)
    if far > _SURPRISING:
        said.append(
            f"The robot differs from its model by {far:.1f} standard deviations of what was held "
            f"possible: what the poses do not tell may be off as much. Give a larger shift=, turn= "
            f"or offset=."
        )
    if unsure > _PLACED:
        said.append(
            f"The poses do not tell where the marker sits in {found.chain.frame}: another place of "
            f"the instrument makes up for it; so tilts and shifts of joints are told apart less "
            f"well. Give its place, marker=."
        )
    if any(x.source == "prior" for x in combinations):
        said.append(
            "What the prior alone tells is as it was in the model: poses at the marker do not "
            "depend on it, those of other frames may."
        )
    if found.chain.gears:
        said.append(
            "Gear factors are not in the model: it takes readings times `gears`, which "
            "`positions(readings)` of the result gives."
        )
    return tuple(said)


def _next_poses(found: CalibrationFit) -> Array:
    """Positions (m, nq) of random ones that would tell the most beside the poses that there are:
    those by which the determinant of the information grows most, one after the other."""
    chain, model = found.chain, found.chain.model
    q = np.tile(found.poses.q[0], (_CANDIDATES, 1))
    columns = list(chain.columns)
    q[:, columns] = random_state(model, 0, _CANDIDATES)[0][:, columns]
    R = None if found.poses.rotation is None else np.tile(np.eye(3), (_CANDIDATES, 1, 1))
    candidates = Poses(q, np.zeros((_CANDIDATES, 3)), R)
    at = chain.marker_poses(q, found.x, found.instrument, found.marker)
    left = found.residuals(Poses(q, at.position, None if R is None else at.rotation))
    own = found.whitened(left)[0] @ found.root
    chosen = []
    for _ in range(_NEXT):
        gain = np.linalg.slogdet(np.eye(own.shape[1]) + own @ np.swapaxes(own, 1, 2))[1]
        best = int(np.argmax(gain))
        chosen.append(best)
        size, axes = np.linalg.eigh(own[best].T @ own[best])
        own = own @ (axes / np.sqrt(1.0 + np.maximum(size, 0.0)))
    return candidates.q[chosen]
