"""`bearing_loads`: what the bearings of joints carry over duty cycles, and how long given ones
live."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.design.data_sheets import mean_load
from freebody.design.drive_loads import cycle_notices, doubt_notices
from freebody.design.duty_cycle import Cycles, DutyCycle, Segment, duty_cycles
from freebody.design.joint_loads import joint_loads, known_wrenches, undetermined
from freebody.design.notices import noise_notices
from freebody.design.parts import Bearing
from freebody.errors import FreebodyError, KindError, UnknownNameError
from freebody.model.model import Model
from freebody.model.placement import Placement
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import lifetime

if TYPE_CHECKING:
    import xarray as xr

_OF_BEARINGS = ("equivalent_load", "bearing_life", "static_safety", "moment_share")
_CARRIED = ("radial_force", "axial_force", "tilting_moment")


@dataclass(frozen=True, eq=False, repr=False)
class BearingLoads(Tabled, ByValue):
    """Loads of the bearings of joints that turn, over duty cycles.

    Dimensions: `cycle`, `joint`, `sample` (of all cycles, one after another; where a robot rests,
    one for the whole rest).
    """

    model: Model
    bearings: Mapping[str, Bearing]
    data: xr.Dataset
    """Along (sample, joint): radial force, axial force (with its sign) and tilting moment about the
    joint's origin, the rate of the joint, and of a given bearing its equivalent load; `seconds`
    that each sample stands for."""
    summary: xr.Dataset
    """Along (cycle, joint): peaks; and of given bearings the equivalent load, by which they wear as
    by all that they carry, their life (h), and C₀ over the largest static equivalent load."""
    notices: tuple[str, ...] = ()

    def _title(self) -> str:
        joints = counted(self.data.sizes["joint"], "joint")
        lives = self.summary["bearing_life"]
        shortest = (
            "" if lives.isnull().all() else f"; the shortest life {lifetime(float(lives.min()))}"
        )
        return f"Bearings of {self.model.name!r}: {joints}{shortest}"

    def _table(self) -> TextTable:
        rows, worst = [], self.summary.max("cycle", skipna=False)
        for name in map(str, worst.joint.values):
            of, lives = worst.sel(joint=name), self.summary["bearing_life"].sel(joint=name)
            given = name in self.bearings
            rows.append(
                (
                    name,
                    f"{of.peak_radial_force:.4g} N",
                    f"{of.peak_axial_force:.4g} N",
                    f"{of.peak_tilting_moment:.4g} N m",
                    self.bearings[name].name if given else "",
                    f"{of.equivalent_load:.4g} N" if given else "",
                    lifetime(float(lives.min())) if given else "",
                )
            )
        head = ("joint", "radial", "axial", "tilting", "bearing", "equivalent", "life")
        return TextTable(head, rows, self.notices)


def bearing_loads(
    model: Model, cycles: Cycles, bearings: Mapping[str, Bearing] | None = None
) -> BearingLoads:
    """The loads of the bearings of a robot's joints over duty cycles, and how long given ones live.

    Parameters
    ----------
    model
        The robot with its drives, such as `drive_loads(...).model`.
    cycles
        A DutyCycle or a Motion, or a list of those.
    bearings : {joint: Bearing}, optional
        Of joints that turn; each carries all of its joint, its centre at the joint's origin.

    Returns
    -------
    BearingLoads
        Of every joint that turns about one axis. Equivalent loads are taken at each sample, with
        the factors of that moment, and averaged as bearings wear (Palmgren and Miner; ISO 281).
        NaN at a joint of a closed chain whose load rigid bodies do not determine.

    Raises
    ------
    FreebodyError, KindError, UnknownNameError
    """
    done = duty_cycles("bearing_loads", model, cycles)
    given, turning = checked_bearings("bearing_loads", model, bearings), turning_joints(model)
    if not turning:
        raise FreebodyError(f"bearing_loads: no joint of {model.name!r} turns about one axis.")
    return _assembled(model, done, list(turning.values()), list(turning), given)


def turning_joints(model: Model) -> dict[str, int]:
    """The joints that turn about one axis, each with a bearing, and the numbers of their bodies."""
    kinds = [body.kind.motion for body in model.bodies]
    inner = {k for last in range(len(kinds)) for k in _on_one_axis(model, last)[:-1]}
    return {
        model.bodies[k].joint.name: k
        for k, motion in enumerate(kinds)
        if motion is not None and motion.turns and k not in inner
    }


def checked_bearings(
    function: str, model: Model, bearings: Mapping[str, Bearing] | None
) -> dict[str, Bearing]:
    """The bearings of a model's joints that a function was given, each of a joint that turns about
    one axis."""
    given, turning = dict(bearings or {}), turning_joints(model)
    for name, bearing in given.items():
        if not isinstance(bearing, Bearing):
            raise KindError(function, f"bearings[{name!r}]", bearing, "an fb.Bearing")
        if name not in turning:
            raise UnknownNameError("joint that turns about one axis", name, model.name, turning)
    return given


def _on_one_axis(model: Model, k: int) -> list[int]:
    """Numbers of the bodies whose joints together are the bearing of body k, itself the last: where
    a joint follows several, those that share its axis, with nothing between."""
    found, body = [k], model.bodies[k]
    while body.joint.mimic and body.parent >= 0:
        before = model.bodies[body.parent]
        apart = before.inertias or body.joint.placement != Placement()
        if apart or not before.joint.mimic or before.joint.axis != body.joint.axis:
            break
        found.insert(0, body.parent)
        body = before
    return found


def _assembled(
    model: Model,
    cycles: Sequence[DutyCycle],
    turning: list[int],
    names: list[str],
    given: dict[str, Bearing],
) -> BearingLoads:
    import xarray

    series: dict[str, list[Array]] = {}
    found: dict[str, list[list[float]]] = {}
    for cycle in cycles:
        parts = [_carried(model, segment, turning) for segment in cycle.segments]
        whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        whole["equivalent_load"] = np.full(whole["rate"].shape, np.nan)
        worn = [_wear(whole, j, given.get(x), cycle.duration) for j, x in enumerate(names)]
        for name in worn[0]:
            found.setdefault(name, []).append([one[name] for one in worn])
        for name, value in whole.items():
            series.setdefault(name, []).append(value)
    seconds = np.concatenate(series.pop("seconds"))
    data = xarray.Dataset(
        {
            name: (("sample", "joint"), np.concatenate(x), {"units": _UNITS[name]})
            for name, x in series.items()
        },
        {"joint": names, "seconds": ("sample", seconds, {"units": "s"})},
    )
    summary = xarray.Dataset(
        {
            name: (("cycle", "joint"), np.array(x), {"units": _UNITS[name]})
            for name, x in found.items()
        },
        {"joint": names},
    )
    open_ones = [x for x, r in zip(names, data["radial_force"].values.T, strict=True)
                 if np.isnan(r).any()]  # fmt: skip
    notices = (
        *doubt_notices(model),
        *noise_notices(model, cycles),
        *cycle_notices(cycles),
        *undetermined(open_ones),
    )
    return BearingLoads(model, given, data, summary, notices)


_UNITS = {
    "radial_force": "N", "axial_force": "N", "tilting_moment": "N m", "rate": "rad/s",
    "equivalent_load": "N", "bearing_life": "h", "static_safety": "1", "peak_radial_force": "N",
    "peak_axial_force": "N", "peak_tilting_moment": "N m", "moment_share": "1",
}  # fmt: skip


def _carried(model: Model, segment: Segment, turning: list[int]) -> dict[str, Array]:
    """Loads and rates (T, joints) of the joints, and seconds (T,)."""
    q, qd, qdd, wrenches, seconds = segment.states()
    loaded, d = segment.carried_by(model), model.dim
    held = known_wrenches(loaded, q, qd, qdd, wrenches, "child")
    held = held[:, : len(model.bodies)]  # those of loops stand behind
    loads = joint_loads(loaded, held[..., :d], held[..., d:])
    found = {name: loads[name][:, turning] for name in _CARRIED}
    if d == 2:
        found |= dict.fromkeys(("axial_force", "tilting_moment"), 0.0 * found["radial_force"])
    each = [np.asarray(at.rates(tuple(q.T), tuple(qd.T))[0]) for at in model.coordinates]
    rates = [np.sum([each[part] for part in _on_one_axis(model, k)], axis=0) for k in turning]
    return {**found, "rate": np.stack(rates, axis=-1), "seconds": seconds}


def _wear(
    loads: dict[str, Array], j: int, bearing: Bearing | None, period: float
) -> dict[str, float]:
    """Peaks of one joint in one cycle, and how its bearing wears; writes its equivalent load."""
    radial, axial, moment = (loads[name][:, j] for name in _CARRIED)
    found = {f"peak_{name}": float(np.abs(loads[name][:, j]).max()) for name in _CARRIED}
    if bearing is None:
        return {**found, **dict.fromkeys(_OF_BEARINGS, np.nan)}
    rate, seconds = np.abs(loads["rate"][:, j]), loads["seconds"]
    equivalent = bearing.equivalent_load(radial, axial, moment)
    loads["equivalent_load"][:, j] = equivalent
    mean = mean_load(equivalent, rate, seconds, bearing.life_exponent or 3.0)
    life = bearing.life(mean, float(rate @ seconds) / period)
    static = bearing.static_load
    safety = np.nan
    if static is not None and bearing.kind == "crossed roller":
        most = bearing.static_equivalent_load(radial, axial, moment).max()
        safety = static / max(float(most), 1e-300)
    limit = bearing.moment_limit
    share = np.nan if limit is None else found["peak_tilting_moment"] / limit
    return {
        **found, "equivalent_load": mean, "bearing_life": life, "static_safety": safety,
        "moment_share": share,
    }  # fmt: skip
