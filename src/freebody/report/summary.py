"""Peaks, means and use of limits: the numbers by which motors, gears and bearings are chosen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array
from freebody.design.joint_loads import JOINT_LOADS
from freebody.design.loads import heaviest_postures
from freebody.model.doubt_rules.aspects import EFFORTS, MASSES
from freebody.model.doubts import attribute, doubts_on
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import Ranges, angular, position_columns, ranges, with_drive
from freebody.outputs.display import TextTable
from freebody.outputs.number_text import compared, percent
from freebody.report.results import LimitUse, StaticPose, Worst
from freebody.report.series import coordinates
from freebody.report.variables import dataset
from freebody.trees import dynamics

if TYPE_CHECKING:
    import xarray as xr

_ROUNDING = 1e-13
"""Relative to the largest of all drives: rounding leaves that much of zero."""
_CANCELLED = 1e-6  # of the work done: a difference that samples do not resolve


def summary(model: Model, motion: Motion, data: xr.Dataset) -> xr.Dataset:
    """The dataset that `Study.summary` describes."""
    t = motion.t
    found = _drives(motion, data) | works(data, t) | _use(model, motion, data) | _reactions(data, t)
    wanted = ("coordinate", "joint", "unit", "effort_unit")
    named = {name: x for name, x in coordinates(model).items() if name in wanted}
    about = {"robot": model.name, "motion": motion.source, **attribute(model.doubts)}
    return dataset(found, named, about)


def mean(t: Array, x: Array) -> Array:
    """The time average of samples x (T, n), by the trapezoidal rule."""
    return np.trapezoid(x, t, axis=0) / (t[-1] - t[0])


def _drives(motion: Motion, data: xr.Dataset) -> dict[str, Any]:
    t, tau, power = motion.t, data["tau"].values, data["power"].values
    peak, peak_time = _peak(t, tau)
    most, most_time = _peak(t, power)
    return {
        "peak_torque": peak,
        "peak_torque_time": peak_time,
        "rms_torque": np.sqrt(mean(t, tau**2)),
        "peak_speed": motion.peaks.velocity.size,
        "peak_speed_time": motion.peaks.velocity.size_at,
        "peak_power": most,
        "peak_power_time": most_time,
        "mean_power": mean(t, power),
        "gravity_torque_peak": _peak(t, data["tau_gravity"].values)[0],
    }


def _peak(t: Array, x: Array) -> tuple[Array, Array]:
    """The entry of largest magnitude of each column of x (T, n), and its time."""
    k = np.argmax(np.abs(x), axis=0)
    return np.take_along_axis(x, k[None], axis=0)[0], t[k]


def works(data: xr.Dataset, t: Array) -> dict[str, Any]:
    """The work done and absorbed (J) by each coordinate and in total; on one supply, braking drives
    feed the others."""
    power = data["power"].values
    done, braked = parted(t, power)
    together = power.sum(axis=1, keepdims=True)
    shared_done, shared_braked = parted(t, together)
    return {
        "work_done": done,
        "work_braked": braked,
        "net_work": done - braked,
        "regenerated_share": share(braked, done),
        "total_work_done": done.sum(),
        "total_work_braked": braked.sum(),
        "total_net_work": (done - braked).sum(),
        "shared_work_done": shared_done[0],
        "shared_work_braked": shared_braked[0],
        "total_regenerated_share": share(braked.sum(), done.sum()),
        "total_peak_power": _peak(t, together)[0][0],
    }


def parted(t: Array, power: Array) -> tuple[Array, Array]:
    """The integrals (n,) of the positive part, and of the negative part with its sign changed, of
    samples (T, n) with straight lines between."""
    h = np.diff(t)[:, None]
    p0, p1 = power[:-1], power[1:]
    size = np.abs(p0) + np.abs(p1)
    up = np.maximum(p0, 0.0) + np.maximum(p1, 0.0)
    # where the sign changes a triangle is left of each: up²/size of it is positive
    with np.errstate(invalid="ignore", divide="ignore"):
        positive = np.where(size > 0, 0.5 * h * up**2 / size, 0.0)
        negative = np.where(size > 0, 0.5 * h * (size - up) ** 2 / size, 0.0)
    return positive.sum(axis=0), negative.sum(axis=0)


def energy_text(found: xr.Dataset, duration: float) -> str:
    """A sentence on work, braking and peak power of all drives together, from `Study.summary`."""
    done, braked, net = (
        float(found[f"total_{x}"]) for x in ("work_done", "work_braked", "net_work")
    )
    shared, peak = float(found["shared_work_done"]), float(found["total_peak_power"])
    if done == 0:
        return "The drives do no work."
    kept = 0.0 if abs(net) < _CANCELLED * done else net
    return (
        f"In {duration:.3g} s the drives do {done:.4g} J of work and absorb {braked:.4g} J in "
        f"braking ({100 * braked / done:.0f} %): net {kept:.4g} J. A supply shared by all drives "
        f"delivers {shared:.4g} J. Peak power of all drives together: {peak:.4g} W."
    )


def share(part: Array, whole: Array) -> Array:
    """The share that a part has of the whole, entry by entry; NaN where the whole is not above
    0."""
    return np.divide(part, whole, out=np.full(np.shape(whole), np.nan), where=np.asarray(whole) > 0)


def _use(model: Model, motion: Motion, data: xr.Dataset) -> dict[str, Any]:
    allowed = ranges(model)
    lowest, highest, position = _excursion(model, motion, allowed)
    tau = np.abs(data["tau"].values)
    rms = np.sqrt(mean(motion.t, tau**2))
    power = np.abs(data["power"].values).max(axis=0)
    return {
        "lowest": lowest,
        "highest": highest,
        "position_fraction": position,
        "velocity_fraction": _fraction(motion.peaks.velocity.size, allowed.velocity),
        "effort_fraction": _fraction(tau.max(axis=0), allowed.effort),
        "rms_fraction": _fraction(rms, allowed.effort),
        "power_fraction": _fraction(power, allowed.effort * allowed.velocity),
    }


def _fraction(value: Array, limit: Array) -> Array:
    return np.where(np.isfinite(limit), value / limit, np.nan)


def _excursion(model: Model, motion: Motion, allowed: Ranges) -> tuple[Array, Array, Array]:
    """The least and greatest position and the used fraction of the range (nv,); NaN where a
    coordinate has no position of its own."""
    lowest, highest = np.full(model.nv, np.nan), np.full(model.nv, np.nan)
    iq, iv = position_columns(model)
    lowest[iv], highest[iv] = motion.peaks.position.low[iq], motion.peaks.position.high[iq]
    half = 0.5 * (allowed.upper - allowed.lower)
    bounded = np.isfinite(half)
    farthest = np.maximum(highest - allowed.middle, allowed.middle - lowest)
    return lowest, highest, np.where(bounded, farthest / np.where(bounded, half, 1.0), np.nan)


def _reactions(data: xr.Dataset, t: Array) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in JOINT_LOADS:
        values = data[name].values
        absent = np.isnan(values).all(axis=0)
        peak = (np.where(absent, np.nan, x) for x in _peak(t, np.nan_to_num(values)))
        found[f"peak_{name}"], found[f"peak_{name}_time"] = peak
    for name in ("force", "moment"):
        sizes = np.linalg.norm(data[f"reaction_{name}"].values, axis=-1)
        found[f"peak_{name}"], found[f"peak_{name}_time"] = _peak(t, sizes)
    return found


def worst(model: Model, data: xr.Dataset) -> Worst:
    """The instant of the largest torque relative to effort limits, or without limits of the largest
    torque."""
    allowed = ranges(model)
    tau, t = data["tau"].values, data["time"].values
    units = np.asarray(data["effort_unit"].values)
    driven = with_drive(model)
    masses, efforts = (
        [doubt for doubt in doubts_on(model, aspect) if doubt.of.mend]
        for aspect in (MASSES, EFFORTS)
    )
    doubted = {name for doubt in efforts for name in doubt.joints or model.velocity_names}
    given = np.isfinite(allowed.effort) & driven
    limited = given & ~np.isin(model.velocity_names, list(doubted))
    if limited.any():
        load = np.where(limited, np.abs(tau) / allowed.effort, 0.0)
    else:
        alike = driven & (units == ("N m" if (units == "N m")[driven].any() else "N"))
        load = np.where(alike, np.abs(tau), 0.0)
    k, j = (int(i) for i in np.unravel_index(np.argmax(load), load.shape))
    name, value, unit = model.velocity_names[j], float(tau[k, j]) + 0.0, str(units[j])
    share = abs(value) / float(allowed.effort[j]) if limited[j] else float("nan")
    why = "the largest of the motion"
    if not given.any():
        why += "; the model gives no effort limits"
    if limited[j]:
        of_whom = (
            "any drive" if (limited == given).all() else "the drives whose limit is not in doubt"
        )
        why = f"{percent(share)} of its effort limit, the largest share of {of_whom}"
        why += " during the motion"
    text = f"At t = {t[k]:.3g} s {name} needs {value:.4g} {unit}: {why}."
    if value == 0.0:
        text = "No drive needs a torque or force during the motion."
    if masses:
        start = text[:1].lower() + text[1:]
        text = f"With the masses of the file, which are in doubt: {start}"
    return Worst(k, float(t[k]), name, value, share, unit, text)


def drive_table(model: Model, found: xr.Dataset) -> TextTable:
    """A table of what each drive must give, from `Study.summary`."""
    rows = []
    quantities = ("peak_torque", "rms_torque", "peak_speed", "peak_power")
    floors = {x: _ROUNDING * float(np.abs(found[x].values).max(initial=0.0)) for x in quantities}
    for name in model.driven_names:
        of = found.sel(coordinate=name)
        unit, effort, share = str(of.unit.values), str(of.effort_unit.values), of.effort_fraction
        torque, rms, speed, power = (
            f"{float(of[quantity]) if abs(of[quantity]) > floor else 0.0:.4g}"
            for quantity, floor in floors.items()
        )
        numbers = (
            f"{torque} {effort}", f"{of.peak_torque_time:.3g} s", f"{rms} {effort}",
            f"{speed} {unit}/s", f"{power} W", "" if np.isnan(share) else percent(float(share)),
        )  # fmt: skip
        rows.append((name, *numbers))
    peaks = ("peak torque", "at", "RMS torque", "peak speed", "peak power")
    return TextTable(("joint", *peaks, "of effort limit"), rows)


def limit_notices(model: Model, found: xr.Dataset, uses: Iterable[LimitUse]) -> list[str]:
    """Sentences on the limits of positions, speeds and torques that the motion exceeds, one for
    each."""
    allowed, names = ranges(model), list(model.velocity_names)
    sentences = []
    for use in uses:
        if not use.exceeded or use.quantity not in ("position", "speed", "torque", "force"):
            continue
        if use.quantity != "position":
            sentences.append(f"{use.text}.")
            continue
        k = names.index(use.coordinate)
        ends = (float(found[key].values[k]) for key in ("lowest", "highest"))
        low, high, lower, upper = compared(*ends, allowed.lower[k], allowed.upper[k])
        sentences.append(
            f"{use.coordinate} leaves its range: the motion spans {low} to {high} {use.unit}, the "
            f"limits are {lower} and {upper}."
        )
    return sentences


def worst_poses(model: Model) -> tuple[StaticPose, ...]:
    """For each coordinate the pose, within the limits, of the largest gravity torque found, see
    `heaviest_postures`; coordinates that gravity never loads are left out."""
    best = heaviest_postures(model)
    torques = np.diagonal(dynamics.gravity_torque(model, best))
    allowed, turns = ranges(model), angular(model)
    floor = 1e-9 * max(float(np.abs(torques).max(initial=0.0)), 1e-12)
    shares = np.where(np.isfinite(allowed.effort), np.abs(torques) / allowed.effort, np.nan)
    return tuple(
        StaticPose(name, best[k], float(torque), "N m" if turns[k] else "N", float(shares[k]))
        for k, (name, torque) in enumerate(zip(model.velocity_names, torques, strict=True))
        if abs(torque) > floor
    )
