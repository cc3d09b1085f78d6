"""The tables of the report: which variables of the data stand in which column."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from markupsafe import Markup

from freebody.figures.body_loads import BodyLoads, Load
from freebody.figures.text import html
from freebody.model.description import Joint
from freebody.report.results_dataset import facts
from freebody.report.tables import (
    Cell,
    Head,
    PrintedNumber,
    ReportTable,
    WordsCell,
    alone,
    table,
    typeset,
)

if TYPE_CHECKING:
    from freebody.report.study import Study

_EFFORTS = {"N m": "Peak torque", "N": "Peak force"}
_USE = "share of the limit that is used; above 100 % the limit is exceeded"
_POSE = 8  # coordinates of a pose that a table has room for

Column = tuple[Head, Sequence[Cell]]


@dataclass(frozen=True)
class Printed:
    """A column of numbers: a variable of the data along one dimension, `at` fixed labels of its
    others.

    unit: of all, or one a row. A share is printed in percent with a bar.
    """

    title: str
    variable: str
    unit: str | Sequence[str] = ""
    tip: str = ""
    scale: float = 1.0
    share: bool = False
    at: tuple[tuple[str, str], ...] = ()

    def column(self, book: xr.Dataset, dim: str, names: Sequence[str]) -> Column:
        """Head and cells for the rows `names`."""
        values = book[self.variable].sel(dict(self.at)).sel({dim: list(names)}).values
        units = [self.unit] * len(names) if isinstance(self.unit, str) else list(self.unit)
        same = len(set(units)) == 1
        cells = [
            PrintedNumber(
                float(x),
                self.variable,
                {dim: name, **dict(self.at)},
                "" if same else unit,
                100.0 if self.share else self.scale,
                bar=float(x) if self.share else None,
            )
            for x, name, unit in zip(values, names, units, strict=True)
        ]
        return Head(self.title, "%" if self.share else units[0] if same else "", self.tip), cells


def drives(study: Study) -> ReportTable:
    """What motors and gears are chosen by."""
    names = study.model.driven_names
    at = [study.model.velocity_names.index(name) for name in names]
    efforts, rates = (
        [units[k] for k in at] for units in (_units(study, "effort_unit"), _rates(study))
    )
    title = _EFFORTS.get(efforts[0], "") if len(set(efforts)) == 1 else "Peak torque, force"
    columns = [
        Printed(title, "peak_torque", efforts, "largest in magnitude, with its sign"),
        Printed("at", "peak_torque_time", "s", "when it occurs"),
        Printed(
            "RMS",
            "rms_torque",
            efforts,
            "root mean square over the motion: the measure of motor heating",
        ),
        Printed("Peak / limit", "effort_fraction", "", _USE, share=True),
        Printed("RMS / limit", "rms_fraction", "", _USE, share=True),
        Printed("Peak speed", "peak_speed", rates, "largest in magnitude"),
        Printed("Speed / limit", "velocity_fraction", "", _USE, share=True),
        Printed(
            "Peak power", "peak_power", "W", "torque times speed; negative where the drive brakes"
        ),
    ]
    return _by_coordinate("Required torque, speed and power of each drive", study, names, columns)


def work(study: Study) -> ReportTable:
    """What each drive puts in and takes up."""
    columns = [
        Printed("Work done", "work_done", "J", "where torque and speed have the same sign"),
        Printed("Work braked", "work_braked", "J", "where the drive holds the motion back"),
        Printed(
            "Net",
            "net_work",
            "J",
            "work done less work braked: over a full cycle, the energy lost to friction",
        ),
        Printed("Braked / done", "regenerated_share", "%", "what could be fed back", scale=100.0),
        Printed("Peak power", "peak_power", "W", "negative where the drive brakes"),
        Printed("at", "peak_power_time", "s"),
        Printed("Mean power", "mean_power", "W", "braking counted as negative"),
        Printed(
            "Power / limits", "power_fraction", "", "of effort limit times speed limit", share=True
        ),
    ]
    return _by_coordinate(
        "Work of each drive over the motion", study, study.model.driven_names, columns
    )


def ranges(study: Study) -> ReportTable | None:
    """How far each coordinate goes, and its limits; None where no coordinate has a range."""
    units = _units(study, "unit")
    if not np.isfinite(study.summary["lowest"].values).any():
        return None
    columns = [
        Printed("Lowest", "lowest", units),
        Printed("Highest", "highest", units),
        Printed("Lower limit", "lower_limit", units),
        Printed("Upper limit", "upper_limit", units),
        Printed(
            "Range used",
            "position_fraction",
            "",
            "distance from the middle; 100 % at a limit",
            share=True,
        ),
        Printed("Speed limit", "velocity_limit", _rates(study)),
        Printed("Effort limit", "effort_limit", _units(study, "effort_unit")),
    ]
    return _by_coordinate(
        "Range of motion of each joint", study, study.model.velocity_names, columns
    )


def bodies(study: Study) -> ReportTable:
    """Masses and centres of mass, and what carries each body."""
    model = study.model
    names = [body.name for body in model.bodies]
    parents = ["ground" if body.parent < 0 else names[body.parent] for body in model.bodies]
    tip = "centre of mass from the joint's origin, in the body's axes at its joint"
    columns: list[Column] = [
        (Head("Joint", number=False), [WordsCell(body.joint.name) for body in model.bodies]),
        (Head("Kind", number=False), [WordsCell(_kind(body.joint)) for body in model.bodies]),
        (Head("Hangs on", number=False), [WordsCell(parent) for parent in parents]),
    ]
    book = facts(study)
    printed = [Printed("Mass, estimated" if model.is_estimated else "Mass", "body_mass", "kg")] + [
        Printed(f"c{axis}", "body_com_local", "mm", tip, scale=1e3, at=(("axis", axis),))
        for axis in _axes(study, "axis")
    ]
    columns += [p.column(book, "body", names) for p in printed]
    return _listed("Bodies: links that move as one rigid body", "Body", names, columns)


def gravity(study: Study) -> ReportTable | None:
    """The worst poses at rest, and the largest gravity load along the motion; None where gravity
    loads nothing."""
    names = [pose.coordinate for pose in study.static]
    if not names:
        return None
    units = [pose.unit for pose in study.static]
    columns = [
        Printed(
            "During the motion", "gravity_torque_peak", units, "largest gravity part of the torque"
        ),
        Printed(
            "Worst pose",
            "worst_gravity_torque",
            units,
            "largest found in any pose within the limits",
        ),
        Printed("Worst / limit", "worst_gravity_fraction", "", _USE, share=True),
    ]
    positions = study.model.position_names
    if len(positions) <= _POSE:
        columns += [
            Printed(
                f"q{k + 1}",
                "worst_gravity_pose",
                "",
                f"{name} in the worst pose, rad or m",
                at=(("position", name),),
            )
            for k, name in enumerate(positions)
        ]
    return _by_coordinate("Torque needed against gravity alone", study, names, columns)


def reactions(study: Study) -> ReportTable:
    """What bearings are chosen by."""
    names = study.model.reaction_names
    loads = [
        ("Force", "peak_force", "N", "magnitude of the total reaction of the parent on the child"),
        ("Axial", "peak_axial_force", "N", "along the axis of a turning joint, with its sign"),
        ("Radial", "peak_radial_force", "N", "across the axis"),
        ("Tilting moment", "peak_tilting_moment", "N m",
         "across the axis, about the joint's origin"),
        ("Guide moment", "peak_guide_moment", "N m", "about the axis of a sliding joint"),
        ("Drive", "peak_drive_load", _drive_units(study), "about (along) the axis: the drive's"),
    ]  # fmt: skip
    columns: list[Column] = []
    for title, variable, unit, tip in loads:
        if np.isfinite(study.summary[variable].values).any():
            for printed in (
                Printed(title, variable, unit, tip),
                Printed("at", f"{variable}_time", "s"),
            ):
                columns.append(printed.column(study.summary, "joint", names))
    return _listed("Peak loads on bearings and guides", "Joint", names, columns)


def _drive_units(study: Study) -> list[str]:
    """Of each reaction's drive; loops have none."""
    sliding = {body.joint.name for body in study.model.bodies if body.kind.slides}
    return ["N" if name in sliding else "N m" for name in study.model.reaction_names]


def checks(study: Study) -> ReportTable:
    """Each check with its value and bar."""
    names, book = [c.name for c in study.checks], facts(study)
    results = [
        WordsCell("passed" if c.passed else "failed", css="ok" if c.passed else "bad")
        for c in study.checks
    ]
    columns: list[Column] = [(Head("Result", number=False), results)]
    for printed in (
        Printed("Value", "check_value"),
        Printed("Bar", "check_bar", tip="the largest value that passes"),
    ):
        head, cells = printed.column(book, "check", names)
        columns.append(
            (head, [alone(cell, 2) for cell in cells if isinstance(cell, PrintedNumber)])
        )
    columns.append(
        (
            Head("What is compared", number=False),
            [WordsCell(typeset(c.text), css="wide") for c in study.checks],
        )
    )
    return _listed("The same quantity computed in two ways", "Check", names, columns)


def loads(study: Study, body: BodyLoads) -> ReportTable:
    """Components of all that acts on a body at the worst instant, world axes."""
    forces, moments = _axes(study, "axis"), _axes(study, "moment_axis")
    symbols = [
        Markup(html(load.name) + (f", {html(load.moment_name)}" if load.moment_name else ""))
        for load in body.loads
    ]
    columns: list[Column] = [
        (Head("exerted by", number=False), [WordsCell(load.other) for load in body.loads])
    ]
    for j, axis in enumerate(forces):
        columns.append(
            (Head(f"F{axis}", "N"), [_force(study, body, load, axis, j) for load in body.loads])
        )
    for j, axis in enumerate(moments):
        head = Head(f"M{axis}", "N m", "about the place where the force acts")
        columns.append((head, [_moment(study, load, axis, j) for load in body.loads]))
    return _listed("", "Load", symbols, columns)


def _force(study: Study, body: BodyLoads, load: Load, axis: str, j: int) -> Cell:
    """A component of a reaction or a weight."""
    if load.joint is None:
        return PrintedNumber(
            float(load.force[j]), "body_weight", {"body": body.body.name, "axis": axis}
        )
    return _reaction(study, "reaction_force", load, {"axis": axis}, float(load.force[j]))


def _moment(study: Study, load: Load, axis: str, j: int) -> Cell:
    if load.joint is None:
        return WordsCell("", css="n")
    return _reaction(study, "reaction_moment", load, {"moment_axis": axis}, float(load.moment[j]))


def _reaction(
    study: Study, variable: str, load: Load, axis: dict[str, str | int], value: float
) -> PrintedNumber:
    """On the child as in the data; on the parent its opposite."""
    sign = -1.0 if load.role == "counter" else 1.0
    assert load.joint is not None
    at: dict[str, str | int] = {
        "time": study.worst.index,
        "joint": study.model.reaction_names[load.joint],
        **axis,
    }
    return PrintedNumber(sign * value, variable, at, scale=sign)


def _kind(joint: Joint) -> str:
    return joint.kind if joint.mimic is None else f"{joint.kind}, follows {joint.mimic.joint}"


def _by_coordinate(
    caption: str, study: Study, names: Sequence[str], columns: Sequence[Printed]
) -> ReportTable:
    """Rows are coordinates, numbered as in the drawings; columns without any finite number are left
    out."""
    book = xr.merge([study.summary, facts(study)], compat="no_conflicts", combine_attrs="drop")
    shown = [
        p for p in columns if np.isfinite(book[p.variable].sel(coordinate=list(names)).values).any()
    ]
    numbers = [study.model.velocity_names.index(name) + 1 for name in names]
    return _listed(
        caption, "Coordinate", names, [p.column(book, "coordinate", names) for p in shown], numbers
    )


def _listed(
    caption: str,
    title: str,
    names: Iterable[str],
    columns: Sequence[Column],
    numbers: Iterable[int] | None = None,
) -> ReportTable:
    """Named rows with numbers, by default from 1."""
    first: list[Cell] = [WordsCell(name, strong=True) for name in names]
    counted = range(1, len(first) + 1) if numbers is None else numbers
    before: list[Cell] = [WordsCell(str(n), css="count") for n in counted]
    heads = [Head(""), Head(title, number=False), *(head for head, _ in columns)]
    return table(caption, heads, [before, first, *(cells for _, cells in columns)])


def _units(study: Study, name: str) -> list[str]:
    return [str(unit) for unit in study.summary[name].values]


def _rates(study: Study) -> list[str]:
    return [f"{unit}/s" for unit in _units(study, "unit")]


def _axes(study: Study, name: str) -> list[str]:
    return [str(axis) for axis in study.data[name].values]
