"""Measured torques beside those that a study computes, with how far apart they are."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, KindError, ShapeError
from freebody.model.model import Model
from freebody.motion.files.csv_files import read_torques
from freebody.motion.motion import vector_of_times
from freebody.motion.ranges import with_drive
from freebody.outputs.number_text import percent
from freebody.report.summary import mean
from freebody.report.variables import dataset

if TYPE_CHECKING:
    from freebody.report.study import Study

Measured = tuple[ArrayLike, ArrayLike] | str | os.PathLike[str]
"""Times (k,) and torques (k, nv), or a CSV file with them, see `read_torques`."""

_FEWEST = 3  # samples that a difference can be told from


def measured_torques(model: Model, measured: Measured, speed: float = 1.0) -> tuple[Array, Array]:
    """Times (k,), increasing, and torques (k, nv) as they were measured, N m and N; refused beside
    a motion that is run at another speed."""
    if speed != 1.0:
        raise FreebodyError(
            f"study: the torques were measured at the pace of the motion, not {speed:g} times as "
            f"fast; leave out speed or measured."
        )
    if isinstance(measured, str | os.PathLike):
        return read_torques(model, measured)
    if not isinstance(measured, tuple) or len(measured) != 2:
        raise KindError(
            "study",
            "measured",
            measured,
            "times and torques, (t, tau), or a CSV file",
            "t has shape (k,), tau (k, nv), N m and N.",
        )
    t = vector_of_times(measured[0])
    tau = as_floats("study", "measured torques", measured[1])
    if tau.shape != (len(t), model.nv):
        raise ShapeError(
            "study", "measured torques", tau.shape, f"({len(t)}, {model.nv})", "a row for each time"
        )
    refuse_not_finite("study", "measured torques", tau, 1, model.velocity_names)
    return t, tau


def beside_measured(study: Study, t: Array, tau: Array) -> Study:
    """The study with torques (k, nv) measured at times (k,) at its samples, straight between those
    that were measured, NaN before and after and where nothing drives; and how far the computed ones
    are from them.

    Raises FreebodyError where the two have too little time in common.
    """
    model, motion, data = study.model, study.motion, study.data
    inside = (motion.t >= t[0]) & (motion.t <= t[-1])
    if inside.sum() < _FEWEST:
        raise FreebodyError(
            f"study: the torques were measured from t = {t[0]:.6g} s to {t[-1]:.6g} s, the motion "
            f"lasts from {motion.t[0]:.6g} s to {motion.t[-1]:.6g} s; they have fewer than "
            f"{_FEWEST} samples in common. Count both from the same instant."
        )
    found = np.full((len(motion.t), model.nv), np.nan)
    for k in np.flatnonzero(with_drive(model)):
        found[inside, k] = np.interp(motion.t[inside], t, tau[:, k])
    own, at = found[inside], motion.t[inside]
    off = np.sqrt(mean(at, (data["tau"].values[inside] - own) ** 2))
    size = np.sqrt(mean(at, own**2))
    share = np.divide(off, size, out=np.full(len(off), np.nan), where=size > 0)
    summed = {"measured_rms_difference": off, "measured_difference_share": share}
    coordinate = {"coordinate": data["coordinate"]}
    return replace(
        study,
        data=data.assign(dataset({"tau_measured": found}, {"time": data["time"], **coordinate})),
        summary=study.summary.assign(dataset(summed, coordinate)),
    )


def measured_text(study: Study) -> str:
    """A sentence on how far the computed torques are from the measured ones; empty where nothing
    was measured."""
    if "measured_rms_difference" not in study.summary:
        return ""
    of = study.summary.sel(coordinate=list(study.model.driven_names))
    each = [
        f"{name} {float(off):.3g} {unit}"
        + ("" if np.isnan(share) else f" ({percent(float(share))})")
        for name, off, unit, share in zip(
            study.model.driven_names,
            of.measured_rms_difference.values,
            of.effort_unit.values,
            of.measured_difference_share.values,
            strict=True,
        )
    ]
    return f"RMS of computed less measured (of the measured): {', '.join(each)}."
