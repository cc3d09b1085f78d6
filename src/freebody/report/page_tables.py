"""The tables of the report: which variables of the data are shown in which column."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from markupsafe import Markup

from freebody.figures.body_loads import BodyLoads, Load
from freebody.figures.marked_text import html
from freebody.figures.skeleton import mass_and_centre
from freebody.model.description import Joint
from freebody.motion.ranges import ranges as allowed_ranges
from freebody.report.tables import (
    Cell,
    Head,
    PrintedNumber,
    ReportTable,
    WordsCell,
    alone,
    shortened,
    table,
    typeset,
)
from freebody.report.variables import VARIABLES, dataset

if TYPE_CHECKING:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study import Study


_EFFORTS = {"N m": "Peak torque", "N": "Peak force"}
_POSE = 8  # coordinates of a pose that a table has room for
EVERYDAY = {
    "rad": (180.0 / np.pi, "°"), "m": (1e3, "mm"),
    "rad/s": (30.0 / np.pi, "rpm"), "m/s": (1e3, "mm/s"),
}  # fmt: skip
"""Units in which people speak of positions and speeds, beside those of the SI."""

TableColumn = tuple[Head, Sequence[Cell]]


@dataclass(frozen=True)
class Printed:
    """A column of numbers in a table: a variable of the data along one dimension, with fixed labels
    `at` of its other dimension.

    A share is printed in percent, one of a limit with a bar.
    """

    title: str
    variable: str
    at: tuple[tuple[str, str], ...] = ()
    scale: float = 1.0
    unit: str | None = None
    """The unit, where it is not that of the variable."""
    tip: str | None = None
    everyday: bool = False
    """Whether the numbers are printed in degrees, rpm and mm: a column beside that of the SI."""

    def column(
        self, study: Study | CycleStudy, book: xr.Dataset, dim: str, names: Sequence[str]
    ) -> TableColumn:
        """The head and the cells of the column, for the rows `names`."""
        of = VARIABLES[self.variable]
        values = book[self.variable].sel(dict(self.at)).sel({dim: list(names)}).values
        limited, share = (self.variable.endswith(ending) for ending in ("_fraction", "_share"))
        units = _units(study, dim, names, of.unit)
        scales = [self.scale] * len(names)
        if limited or share:
            units, scales = ["%"] * len(names), [100.0] * len(names)
        elif self.everyday:
            scales, units = map(list, zip(*map(EVERYDAY.__getitem__, units), strict=True))
        elif self.unit is not None:
            units = [self.unit] * len(names)
        same = len(set(units)) == 1
        cells: list[Cell] = []
        for x, name, unit, scale in zip(map(float, values), names, units, scales, strict=True):
            if np.isinf(x):
                cells.append(WordsCell("" if self.everyday else "none", css="n none"))
                continue
            at, own = {dim: name, **dict(self.at)}, "" if same else unit
            bar = x if limited else None
            counted = f"{x:.0f}" if self.variable.endswith("_segment") else ""
            cells.append(PrintedNumber(x, self.variable, at, own, scale, counted, bar))
        repeated = of.meaning == self.title.lower()
        tip = self.tip if self.tip is not None else "" if repeated or self.everyday else of.meaning
        return Head(self.title, units[0] if same else "", tip), cells


def _units(study: Study | CycleStudy, dim: str, names: Sequence[str], unit: str) -> list[str]:
    """The units of a variable's rows."""
    turning, _, sliding = unit.removesuffix("|1").partition("|")
    if not sliding:
        return [unit if unit != "1" else ""] * len(names)
    own = {body.joint.name: "m" if body.kind.slides else "rad" for body in study.model.bodies}
    if dim == "coordinate":
        own = dict(zip(study.model.velocity_names, study.summary["unit"].values, strict=True))
    return [sliding if own.get(name) == "m" else turning for name in names]


def drives(study: Study) -> ReportTable:
    """The table by which motors and gears are chosen."""
    names = study.model.driven_names
    efforts = _units(study, "coordinate", names, VARIABLES["peak_torque"].unit)
    title = _EFFORTS.get(efforts[0], "") if len(set(efforts)) == 1 else "Peak torque, force"
    columns = {
        title: "peak_torque",
        "at": "peak_torque_time",
        "RMS": "rms_torque",
        "Peak / limit": "effort_fraction",
        "RMS / limit": "rms_fraction",
        "Peak speed": "peak_speed",
        "Speed / limit": "velocity_fraction",
        "Peak power": "peak_power",
    }
    return by_coordinate("Required torque, speed and power of each drive", study, names, columns)


def work(study: Study) -> ReportTable:
    """The table of the work that each drive delivers and absorbs."""
    columns = {
        "Work done": "work_done",
        "Work braked": "work_braked",
        "Net": "net_work",
        "Braked / done": "regenerated_share",
        "Peak power": "peak_power",
        "at": "peak_power_time",
        "Mean power": "mean_power",
        "Power / limits": "power_fraction",
    }
    names = study.model.driven_names
    return by_coordinate("Work of each drive over the motion", study, names, columns)


def measured(study: Study) -> ReportTable | None:
    """The table of how far the computed torques are from the measured ones; None where nothing was
    measured."""
    if "measured_rms_difference" not in study.summary:
        return None
    columns = {
        "RMS computed": "rms_torque",
        "RMS difference": "measured_rms_difference",
        "of measured": "measured_difference_share",
    }
    names = study.model.driven_names
    return by_coordinate("Computed less measured torque", study, names, columns)


def ranges(study: Study) -> ReportTable | None:
    """The table of the range that each coordinate with a position moves through, and of its limits;
    None where none has one."""
    if not np.isfinite(study.summary["lowest"].values).any():
        return None
    columns = {
        "Lowest": "lowest",
        "Highest": "highest",
        "Lower limit": "lower_limit",
        "Upper limit": "upper_limit",
        "Range used": "position_fraction",
        "Speed limit": "velocity_limit",
        "Effort limit": "effort_limit",
    }
    lowest = study.summary["lowest"]
    names = [x for x in study.model.velocity_names if np.isfinite(lowest.sel(coordinate=x))]
    return by_coordinate("Range of motion of each joint", study, names, columns, book=whole(study))


def bodies(study: Study) -> ReportTable:
    """The table of masses and centres of mass, and of what carries each body."""
    model, book = study.model, facts(study)
    names = [body.name for body in model.bodies]
    parents = ["ground" if body.parent < 0 else names[body.parent] for body in model.bodies]
    printed = [Printed("Mass, estimated" if model.is_estimated else "Mass", "body_mass", tip="")]
    printed += [
        Printed(f"c{axis}", "body_com_local", (("axis", axis),), 1e3, "mm")
        for axis in _axes(study, "axis")
    ]
    columns = [
        _words("Joint", [body.joint.name for body in model.bodies]),
        _words("Kind", [_kind(body.joint) for body in model.bodies]),
        _words("Parent body", parents),
        *(p.column(study, book, "body", names) for p in printed),
    ]
    numbers = range(1, len(names) + 1)
    return _listed("Bodies: links that move as one rigid body", "Body", names, columns, numbers)


def gravity(study: Study) -> ReportTable | None:
    """The table of the largest gravity loads along the motion and in any pose; None where gravity
    loads nothing."""
    names = [pose.coordinate for pose in study.static]
    if not names:
        return None
    columns = {
        "This motion": "gravity_torque_peak",
        "Any pose": "worst_gravity_torque",
        "Any / limit": "worst_gravity_fraction",
    }
    caption = "Torque needed to hold against gravity"
    return by_coordinate(caption, study, names, columns, book=whole(study))


def gravity_poses(study: Study) -> ReportTable | None:
    """The table of the poses in which gravity loads each coordinate most; None where there are none
    or they have too many coordinates to be read."""
    names, positions = [pose.coordinate for pose in study.static], study.model.position_names
    if (
        not names
        or len(positions) > _POSE
        or any(b.kind.nq != b.kind.nv for b in study.model.bodies)
    ):
        return None
    units = _units(study, "coordinate", study.model.velocity_names, "rad|m")
    poses = []
    for name, short, unit in zip(positions, shortened(positions), units, strict=True):
        scale, everyday = EVERYDAY[unit]
        at = (("position", name),)
        poses.append(Printed(short, "worst_gravity_pose", at, scale, everyday, f"{name} there"))
    caption = "Pose in which gravity loads it most"
    return by_coordinate(caption, study, names, {}, poses, whole(study))


def reactions(study: Study) -> ReportTable:
    """The table by which bearings are chosen."""
    names, book = study.model.reaction_names, study.summary
    loads = {
        "Force": "peak_force",
        "Axial": "peak_axial_force",
        "Radial": "peak_radial_force",
        "Tilting moment": "peak_tilting_moment",
        "Guide moment": "peak_guide_moment",
        "Drive": "peak_drive_load",
    }
    columns = [
        Printed(*of).column(study, book, "joint", names)
        for title, variable in loads.items()
        if np.isfinite(book[variable].values).any()
        for of in ((title, variable), ("at", f"{variable}_time"))
    ]
    bodies = len(study.model.bodies)  # behind their joints are the loops, which have no number
    numbers = [k if k <= bodies else "" for k in range(1, len(names) + 1)]
    return _listed("Peak loads on bearings and guides", "Joint", names, columns, numbers)


def checks(study: Study) -> ReportTable:
    """The table of checks, each with its value and bar."""
    names, book = [c.name for c in study.checks], facts(study)
    said = {True: WordsCell("passed", css="ok"), False: WordsCell("failed", css="bad")}
    results = [said[check.passed] for check in study.checks]
    columns: list[TableColumn] = [(Head("Result", number=False), results)]
    for title, variable in (("Value", "check_value"), ("Allowed", "check_bar")):
        head, cells = Printed(title, variable).column(study, book, "check", names)
        columns.append((head, [alone(x, 2) for x in cells if isinstance(x, PrintedNumber)]))
    columns.append(_words("What is compared", [typeset(c.text) for c in study.checks], "wide"))
    return _listed("The same quantity computed in two ways", "Check", names, columns, None)


_COMPONENTS = (
    ("force", "F", "N", "axis", ""),
    ("moment", "M", "N m", "moment_axis", "about the point where the force acts"),
)
"""Kinds of loads: name, letter and unit, the dimension of their components, and what is told of
them."""


def loads(study: Study, body: BodyLoads) -> ReportTable:
    """The table of the components of all loads on a body at the worst instant, in world axes."""
    symbols = [
        Markup(html(load.name) + (f", {html(load.moment_name)}" if load.moment_name else ""))
        for load in body.loads
    ]
    columns = [_words("exerted by", [load.other for load in body.loads])]
    for what, letter, unit, dim, tip in _COMPONENTS:
        for j, axis in enumerate(_axes(study, dim)):
            cells = [_component(study, body, load, what, {dim: axis}, j) for load in body.loads]
            columns.append((Head(f"{letter}{axis}", unit, tip), cells))
    return _listed("", "Load", symbols, columns, None)


def _component(
    study: Study, body: BodyLoads, load: Load, what: str, axis: dict[str, str], j: int
) -> Cell:
    """The cell of a load's component: for a reaction on the child as in the data, on the parent its
    opposite; for a weight, which has no moment, its force."""
    value = float(getattr(load, what)[j])
    if load.joint is not None:
        sign = -1.0 if load.role == "counter" else 1.0
        joint = study.model.reaction_names[load.joint]
        at: dict[str, str | int] = {"time": study.worst.index, "joint": joint, **axis}
        return PrintedNumber(sign * value, f"reaction_{what}", at, scale=sign)
    if what == "moment":
        return WordsCell("", css="n")
    return PrintedNumber(value, "body_weight", {"body": body.body.name, **axis})


def _kind(joint: Joint) -> str:
    return joint.kind if joint.mimic is None else f"{joint.kind}, follows {joint.mimic.joint}"


def _words(title: str, texts: Iterable[str], css: str = "") -> TableColumn:
    return Head(title, number=False), [WordsCell(text, css=css) for text in texts]


def by_coordinate(
    caption: str, study: Study | CycleStudy, names: Sequence[str], titles: Mapping[str, str],
    more: Iterable[Printed] = (), book: xr.Dataset | None = None,
) -> ReportTable:  # fmt: skip
    """A table whose rows are coordinates, numbered as their bodies are in the drawings; columns
    without a finite number are left out. titles: of the columns, with their variables; positions
    and speeds in everyday units too. book: of the numbers, by default the summary."""
    asked: list[Printed] = []
    for title, variable in titles.items():
        asked.append(Printed(title, variable))
        if VARIABLES[variable].unit.partition("|")[0] in EVERYDAY:
            asked.append(Printed("", variable, everyday=True))
    book = study.summary if book is None else book
    shown = [
        p.column(study, book, "coordinate", names)
        for p in (*asked, *more)
        if np.isfinite(book[p.variable].sel(coordinate=list(names)).values).any()
    ]
    return _listed(caption, "Coordinate", names, shown, _numbers(study, names))


def _numbers(study: Study | CycleStudy, names: Sequence[str]) -> Sequence[int] | None:
    """The numbers in the drawings of the bodies that coordinates move; None where these are no help
    to find a row: in loops, and where a joint has several coordinates."""
    model = study.model
    if model.loops or any(body.kind.nv > 1 for body in model.bodies):
        return None
    numbers = {body.joint.name: k for k, body in enumerate(model.bodies, 1)}
    return [numbers[name] for name in names]


def _listed(
    caption: str, title: str, names: Sequence[str], columns: Sequence[TableColumn],
    numbers: Sequence[int | str] | None,
) -> ReportTable:  # fmt: skip
    """A table of named rows, numbered where there are numbers."""
    first: list[Cell] = [WordsCell(name, strong=True) for name in names]
    heads = [Head(title, number=False), *(head for head, _ in columns)]
    listed = [first, *(cells for _, cells in columns)]
    if numbers is not None:
        heads.insert(0, Head(""))
        listed.insert(0, [WordsCell(str(n), css="count") for n in numbers])
    return table(caption, heads, listed)


def _axes(study: Study, name: str) -> list[str]:
    return [str(axis) for axis in study.data[name].values]


TABLES = (drives, measured, work, ranges, bodies, gravity, gravity_poses, reactions, checks)
"""Tables of the page, by the names of their functions."""


def whole(study: Study) -> xr.Dataset:
    """The summary and the page's other numbers."""
    return xr.merge([study.summary, facts(study)], compat="no_conflicts", combine_attrs="drop")


def facts(study: Study) -> xr.Dataset:
    """The page's numbers besides time series and summary: mass, centre and weight of bodies; limits
    (infinite without) and worst pose of coordinates, NaN where gravity loads nothing; value and bar
    of each check."""
    model = study.model
    bodies = [model.tree.bodies[at] for at in model.tree.body_of]
    masses, centres = zip(
        *(mass_and_centre(body.masses, model.dim) for body in bodies), strict=True
    )
    allowed = allowed_ranges(model)
    worst = {pose.coordinate: pose for pose in study.static}
    found = [worst.get(name) for name in model.velocity_names]
    values = {
        "body_mass": masses,
        "body_com_local": centres,
        "body_weight": np.outer(masses, model.gravity),
        "lower_limit": allowed.lower,
        "upper_limit": allowed.upper,
        "velocity_limit": allowed.velocity,
        "effort_limit": allowed.effort,
        "worst_gravity_torque": [p.torque if p else np.nan for p in found],
        "worst_gravity_fraction": [p.fraction if p else np.nan for p in found],
        "worst_gravity_pose": [p.q if p else np.full(model.nq, np.nan) for p in found],
        "check_value": [c.value for c in study.checks],
        "check_bar": [c.bar for c in study.checks],
        "check_passed": [c.passed for c in study.checks],
    }
    axes = ("body", "coordinate", "position", "axis")
    named = {name: list(study.data[name].values) for name in axes}
    named["check"] = [c.name for c in study.checks]
    return dataset(values, named, estimated=", estimated" if model.is_estimated else "")
