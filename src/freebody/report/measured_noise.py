"""Of measured motions: what their noise does to the torques, with and without the filter."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.files.measured_motions import recognised, smoothed
from freebody.motion.motion import Motion
from freebody.motion.ranges import angular, ranges, with_drive
from freebody.report.results import percent
from freebody.report.series import torque_parts

Smooth = bool | float | None
"""False or None: as it is; True: at the cutoff that the noise asks for; a number: at that cutoff
(Hz)."""

_TELL = 0.01  # of the largest peak: a change by less is not told
_MOST = 3  # joints, those whose peaks change most


def filtered(model: Model, motion: Motion, smooth: Smooth) -> tuple[Motion, tuple[str, ...]]:
    """(the motion to study, sentences on its noise and on the torques with and without it)."""
    if smooth is not None and smooth is not False:
        clean = smoothed(model, motion, None if smooth is True else smooth)
        peaks = _compared(model, clean, motion, "as it was measured")
        return clean, (
            f"The motion was smoothed. {peaks or 'Peak torques are the same within 1 %.'}",
        )
    found = recognised(model, motion)
    if found is None:
        return motion, ()
    clean = smoothed(model, motion, found.cutoff)
    how = f"smoothed at {found.cutoff:.3g} Hz (--smooth auto, smooth=True)"
    peaks = _compared(model, motion, clean, how)
    return motion, (f"{found.text} {peaks}",) if peaks else ()


def _compared(model: Model, studied: Motion, other: Motion, how: str) -> str:
    """The peak torques of both motions where they differ, the most changed first; empty where none
    does."""
    mine, theirs = (
        np.abs(torque_parts(model, m)["tau"].values).max(axis=0) for m in (studied, other)
    )
    turns = angular(model)
    driven, largest = with_drive(model), np.maximum(mine, theirs)
    scale = np.array([largest[driven & (turns == kind)].max(initial=1e-300) for kind in turns])
    change = np.where(driven, np.abs(theirs - mine) / scale, 0.0)
    order = [int(k) for k in np.argsort(-change) if change[k] > _TELL]
    if not order:
        return ""
    told = [_peaks(model, k, mine, theirs) for k in order[:_MOST]]
    return f"Peak torques, and in brackets {how}: {'; '.join(told)}."


def _peaks(model: Model, k: int, mine: Array, theirs: Array) -> str:
    allowed = ranges(model)
    unit = "N m" if allowed.turns[k] else "N"
    limit = float(allowed.effort[k])

    def one(value: float) -> str:
        share = f", {percent(value / limit)} of its limit" if np.isfinite(limit) else ""
        return f"{value:.3g} {unit}{share}"

    return f"{model.velocity_names[k]} {one(float(mine[k]))} [{one(float(theirs[k]))}]"
