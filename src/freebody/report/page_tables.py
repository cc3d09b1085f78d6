"""The tables of the report."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from freebody.figures.loads import BodyLoads
from freebody.figures.text import html
from freebody.motion.ranges import ranges as allowed
from freebody.report.study import Study
from freebody.report.tables import Cell, Head, Number, Table, Text, alone, table, typeset

if TYPE_CHECKING:
    import xarray as xr

_EFFORTS = {"N m": "Peak torque", "N": "Peak force"}
_USE = "share of the limit that is used; above 100 % the limit is exceeded"


def drives(study: Study) -> Table:
    """What motors and gears are chosen by."""
    efforts, rates = _units(study, "effort_unit"), [f"{u}/s" for u in _units(study, "unit")]
    limited = [bool(np.isfinite(study.summary[k].values).any()) for k in ("effort_fraction", "velocity_fraction")]
    columns = [
        (Head(_EFFORTS.get(_one(efforts), "Peak torque, force"), _one(efforts), "largest in magnitude, with its sign"), _cells(study, "peak_torque", efforts)),
        (Head("at", "s", "when it occurs"), _cells(study, "peak_torque_time")),
        (Head("RMS", _one(efforts), "root mean square over the motion: what heats a motor"), _cells(study, "rms_torque", efforts)),
    ]
    if limited[0]:
        columns += [(Head("Peak / limit", "%", _USE), _shares(study, "effort_fraction")),
                    (Head("RMS / limit", "%", _USE), _shares(study, "rms_fraction"))]  # fmt: skip
    columns.append((Head("Peak speed", _one(rates), "largest in magnitude"), _cells(study, "peak_speed", rates)))
    if limited[1]:
        columns.append((Head("Speed / limit", "%", _USE), _shares(study, "velocity_fraction")))
    columns += [
        (Head("Peak power", "W", "torque times speed; negative where the drive brakes"), _cells(study, "peak_power")),
        (Head("Mean power", "W", "over the motion"), _cells(study, "mean_power")),
    ]
    return _named_table("What each drive must give", "Coordinate", study.model.velocity_names, columns)


def ranges(study: Study) -> Table | None:
    """How far each coordinate goes, and its limits; None where no coordinate has a range."""
    units = _units(study, "unit")
    limits = allowed(study.model)
    columns = [
        (Head("Lowest", _one(units)), _cells(study, "lowest", units)),
        (Head("Highest", _one(units)), _cells(study, "highest", units)),
        (Head("Lower limit", _one(units)), _facts(limits.lower, "limits.lower", units)),
        (Head("Upper limit", _one(units)), _facts(limits.upper, "limits.upper", units)),
        (Head("Range used", "%", "distance from the middle of the range; 100 % at a limit"), _shares(study, "position_fraction")),
        (Head("Speed limit", _one([f"{u}/s" for u in units])), _facts(limits.velocity, "limits.velocity", [f"{u}/s" for u in units])),
        (Head("Effort limit", _one(_units(study, "effort_unit"))), _facts(limits.effort, "limits.effort", _units(study, "effort_unit"))),
    ]  # fmt: skip
    shown = [
        (head, cells)
        for head, cells in columns
        if any(isinstance(cell, Number) and math.isfinite(cell.value) for cell in cells)
    ]
    if not shown:
        return None
    return _named_table("How far the motion goes", "Coordinate", study.model.velocity_names, shown)


def bodies(study: Study) -> Table:
    """Masses and centres of mass, and what carries each body."""
    model = study.model
    parts = [inertia(study, k) for k in range(len(model.bodies))]
    axes = "xyz"[: model.dim]
    columns: list[tuple[Head, Sequence[Cell]]] = [
        (Head("Joint", number=False), [Text(b.joint.name) for b in model.bodies]),
        (Head("Kind", number=False), [Text(_kind(b.joint)) for b in model.bodies]),
        (Head("Hangs on", number=False), [Text(model.bodies[b.parent].name if b.parent >= 0 else "ground") for b in model.bodies]),
        (Head("Mass", "kg"), [Number(p[0], fact=f"body_mass[{k}]") for k, p in enumerate(parts)]),
    ]  # fmt: skip
    for j, axis in enumerate(axes):
        tip = "centre of mass from the joint's origin, in the body's axes at its joint"
        columns.append((Head(f"c{axis}", "mm", tip), [Number(p[1][j], fact=f"body_com[{k}][{j}]", scale=1e3) for k, p in enumerate(parts)]))
    return _named_table("Bodies: what moves as one piece", "Body", [b.name for b in model.bodies], columns)


def inertia(study: Study, k: int) -> tuple[float, tuple[float, ...]]:
    """Mass and centre of mass of body k, in its axes."""
    tree = study.model.tree
    masses = tree.bodies[tree.body_of[k]].masses
    total = float(sum(m.m for m in masses))
    if not total:
        return 0.0, (0.0,) * study.model.dim
    return total, tuple(float(sum(m.m * m.c[j] for m in masses)) / total for j in range(study.model.dim))


def gravity(study: Study) -> Table | None:
    """The worst poses at rest, and the largest gravity load along the motion."""
    if not study.static:
        return None
    names = [pose.coordinate for pose in study.static]
    units = [pose.unit for pose in study.static]
    along = [
        Number(float(study.summary["gravity_torque_peak"].sel(coordinate=n)), "gravity_torque_peak", {"coordinate": n}, unit=u)
        for n, u in zip(names, _suffixes(units), strict=True)
    ]
    worst = [Number(p.torque, fact=f"static[{k}].torque", unit=u) for k, (p, u) in enumerate(zip(study.static, _suffixes(units), strict=True))]
    columns: list[tuple[Head, Sequence[Cell]]] = [
        (Head("During the motion", _one(units), "largest gravity part of the torque along the motion"), along),
        (Head("Worst pose", _one(units), "largest found in any pose within the limits"), worst),
    ]
    if any(np.isfinite(p.fraction) for p in study.static):
        columns.append((Head("Worst / limit", "%", _USE), [Number(p.fraction, fact=f"static[{k}].fraction", scale=100.0, bar=p.fraction) for k, p in enumerate(study.static)]))
    poses = [Text(", ".join(f"{x:z.2f}".replace("-", "−") for x in p.q), css="pose") for p in study.static]
    if study.model.nq <= 8:
        columns.append((Head(f"q of the worst pose: {', '.join(study.model.position_names)}" if study.model.nq < 4 else "q of the worst pose, rad and m", number=False), poses))
    return _named_table("What gravity alone asks", "Coordinate", names, columns)


def reactions(study: Study) -> Table:
    """What bearings are chosen by."""
    columns = [
        (Head("Peak force", "N", "magnitude of all that the parent exerts on the child"), _cells(study, "peak_force", dim="joint")),
        (Head("at", "s"), _cells(study, "peak_force_time", dim="joint")),
        (Head("Peak moment", "N m", "about the joint's origin, the drive's torque included"), _cells(study, "peak_moment", dim="joint")),
        (Head("at", "s"), _cells(study, "peak_moment_time", dim="joint")),
    ]
    return _named_table("What each joint transmits", "Joint", study.model.joint_names, columns)


def checks(study: Study) -> Table:
    """Each check with its value and bar."""
    rows = study.checks
    columns: list[tuple[Head, Sequence[Cell]]] = [
        (Head("Result", number=False), [Text("passed" if c.passed else "failed", css="ok" if c.passed else "bad") for c in rows]),
        (Head("Value"), [alone(Number(c.value, fact=f"checks[{k}].value"), 2) for k, c in enumerate(rows)]),
        (Head("Bar", tip="the largest value that passes"), [alone(Number(c.bar, fact=f"checks[{k}].bar"), 2) for k, c in enumerate(rows)]),
        (Head("What is compared", number=False), [Text(typeset(c.text), css="wide") for c in rows]),
    ]
    return _named_table("Two ways to the same quantity", "Check", [c.name for c in rows], columns)


def loads(study: Study, body: BodyLoads) -> Table:
    """Components of all that acts on a body at the worst instant, world axes."""
    axes, moments = [str(a) for a in study.data["axis"].values], [str(a) for a in study.data["moment_axis"].values]
    names, by, rows = [], [], []
    for k, load in enumerate(body.loads):
        joint, sign = _joint_of(study, body, load.role, load.name)
        names.append(Markup(html(load.name) + (f", {html(load.moment_name)}" if load.moment_name else "")))
        by.append(Text(load.other))
        rows.append(
            _components(study, ("reaction_force", "axis", axes), joint, sign, load.force, f"loads[{body.body.index}][{k}].force")
            + _components(study, ("reaction_moment", "moment_axis", moments), joint, sign, load.moment, f"loads[{body.body.index}][{k}].moment")
        )
    heads = [*(Head(f"F{a}", "N") for a in axes), *(Head(f"M{a}", "N m", "about the place where the force acts") for a in moments)]
    columns = [(head, [row[k] for row in rows]) for k, head in enumerate(heads)]
    return _named_table("", "Load", names, [(Head("exerted by", number=False), by), *columns])


def _components(
    study: Study, source: tuple[str, str, list[str]], joint: str, sign: float, values: np.ndarray, fact: str
) -> list[Cell]:
    """Numbers of a reaction, which stands in the data file, or of a load that does not."""
    variable, dim, axes = source
    if not joint:
        return [Number(float(x), fact=f"{fact}[{j}]", text="" if x else "0") for j, x in enumerate(values)]
    picked: list[dict[str, str | int]] = [{"time": study.worst.index, "joint": joint, dim: a} for a in axes]
    return [Number(sign * float(x), variable, at, scale=sign) for x, at in zip(values, picked, strict=True)]


def _joint_of(study: Study, body: BodyLoads, role: str, name: str) -> tuple[str, float]:
    """The joint whose reaction a load is, and its sign; empty for weights."""
    if role == "reaction":
        return study.model.joint_names[body.body.index], 1.0
    if role == "counter":
        return study.model.joint_names[int(name.rstrip("}").split(",")[-1]) - 1], -1.0
    return "", 1.0


def _kind(joint: object) -> str:
    mimic = getattr(joint, "mimic", None)
    kind = str(getattr(joint, "kind", ""))
    return kind if mimic is None else f"{kind}, follows {mimic.joint}"


def _named_table(caption: str, title: str, names: Iterable[str], columns: Sequence[tuple[Head, Sequence[Cell]]]) -> Table:
    listed = list(names)
    numbers: list[Cell] = [Text(str(k + 1), css="count") for k in range(len(listed))]
    first: list[Cell] = [Text(n, strong=True) for n in listed]
    heads = [Head("", number=True), Head(title, number=False), *(head for head, _ in columns)]
    return table(caption, heads, [numbers, first, *(cells for _, cells in columns)])


def _cells(study: Study, variable: str, units: Sequence[str] = (), dim: str = "coordinate") -> list[Cell]:
    array: xr.DataArray = study.summary[variable]
    suffixes = _suffixes(units) if units else [""] * array.size
    names = [str(n) for n in array[dim].values]
    return [Number(float(x), variable, {dim: n}, unit=u) for x, n, u in zip(array.values, names, suffixes, strict=True)]


def _shares(study: Study, variable: str) -> list[Cell]:
    array = study.summary[variable]
    names = [str(n) for n in array["coordinate"].values]
    return [Number(float(x), variable, {"coordinate": n}, scale=100.0, bar=float(x)) for x, n in zip(array.values, names, strict=True)]


def _facts(values: Sequence[float] | np.ndarray, fact: str, units: Sequence[str]) -> list[Cell]:
    return [Number(float(x), fact=f"{fact}[{k}]", unit=u) for k, (x, u) in enumerate(zip(values, _suffixes(units), strict=True))]


def _units(study: Study, name: str) -> list[str]:
    return [str(u) for u in study.summary[name].values]


def _one(units: Sequence[str]) -> str:
    """The unit of all, or nothing where they differ."""
    return units[0] if len(set(units)) == 1 else ""


def _suffixes(units: Sequence[str]) -> list[str]:
    return [""] * len(units) if len(set(units)) == 1 else list(units)
