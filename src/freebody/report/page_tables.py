"""The tables of the report: which variables of the data are shown in which column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from markupsafe import Markup

from freebody.figures.body_loads import NOISE, BodyLoads, Load
from freebody.figures.marked_text import html
from freebody.figures.skeleton import mass_and_centre
from freebody.model.description import Joint
from freebody.motion.ranges import ranges as allowed_ranges
from freebody.report.printed_columns import (
    EVERYDAY,
    Printed,
    TableColumn,
    by_coordinate,
    effort_title,
    named_rows,
    units_of,
    words_column,
)
from freebody.report.tables import (
    Cell,
    Head,
    PrintedNumber,
    ReportTable,
    WordsCell,
    alone,
    shortened,
    typeset,
)
from freebody.report.variables import dataset

if TYPE_CHECKING:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study import Study


_POSE = 8  # coordinates of a pose that a table has room for


def drives(study: Study | CycleStudy) -> ReportTable:
    """The table by which motors and gears are chosen, of a duty cycle with the segment of each
    peak."""
    names = study.model.driven_names
    segment = {"segment": "peak_torque_segment"}
    columns = {
        effort_title(study, names): "peak_torque",
        **(segment if "peak_torque_segment" in study.summary else {}),
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


def following(study: Study) -> tuple[str, ...]:
    """The names of the joints of a closed chain that no drive moves; none of an open chain."""
    model = study.model
    driven = set(model.driven_names)
    return tuple(
        body.joint.name
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if model.loops and driven.isdisjoint(model.velocity_names[k] for k in at.v)
    )


def ranges(study: Study) -> ReportTable | None:
    """The table of the range that each coordinate with a position moves through, in a closed chain
    each that is driven, and of its limits; None where none has one."""
    there = following(study)
    names = [x for x in study.model.velocity_names if x not in there]
    return _ranged(study, "Range of motion of each joint", names)


def follower_ranges(study: Study) -> ReportTable | None:
    """The table of the range of those joints of a closed chain that no drive moves; None where
    there are none."""
    return _ranged(study, "Range of motion of the other joints", following(study))


def _ranged(study: Study, caption: str, candidates: Sequence[str]) -> ReportTable | None:
    lowest = study.summary["lowest"]
    known = set(map(str, lowest["coordinate"].values))
    names = [x for x in candidates if x in known and np.isfinite(lowest.sel(coordinate=x))]
    if not names:
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
    return by_coordinate(caption, study, names, columns, book=whole(study))


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
        words_column("Joint", [body.joint.name for body in model.bodies]),
        words_column("Kind", [_kind(body.joint) for body in model.bodies]),
        words_column("Parent body", parents),
        *(p.column(study, book, "body", names) for p in printed),
    ]
    numbers = range(1, len(names) + 1)
    return named_rows("Bodies: links that move as one rigid body", "Body", names, columns, numbers)


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
    units = units_of(study, "coordinate", study.model.velocity_names, "rad|m")
    poses = []
    for name, short, unit in zip(positions, shortened(positions), units, strict=True):
        scale, everyday = EVERYDAY[unit] if unit == "rad" else (1.0, unit)
        at = (("position", name),)
        poses.append(Printed(short, "worst_gravity_pose", at, scale, everyday, f"{name} there"))
    caption = "Pose in which gravity loads it most"
    return by_coordinate(caption, study, names, {}, poses, whole(study))


def carrying(study: Study) -> tuple[str, ...]:
    """The names of the joints and loops that transmit loads: of all but those that leave a body all
    its motion."""
    model = study.model
    nothing = {body.joint.name for body in model.bodies if body.kind.frees(model.dim)}
    return tuple(name for name in model.reaction_names if name not in nothing)


def reactions(study: Study) -> list[ReportTable]:
    """The tables by which bearings and guides are chosen, one for all joints that carry the same
    kinds of loads."""
    book = study.summary
    carried: dict[tuple[str, ...], list[str]] = {}
    for name in carrying(study):
        peaks = {title: abs(float(book[x].sel(joint=name))) for title, x in _LOADS.items()}
        finite = [title for title, peak in peaks.items() if np.isfinite(peak)]
        if peaks["Drive"] <= NOISE * max(peaks[title] for title in finite):
            finite.remove("Drive")  # nothing drives it
        carried.setdefault(tuple(finite), []).append(name)
    return [_carried(study, loads, names) for loads, names in carried.items()]


_LOADS = {
    "Force": "peak_force",
    "Axial": "peak_axial_force",
    "Radial": "peak_radial_force",
    "Tilting moment": "peak_tilting_moment",
    "Guide moment": "peak_guide_moment",
    "Drive": "peak_drive_load",
}
"""Titles of the columns of loads on joints, with their variables."""


def _carried(study: Study, loads: Sequence[str], names: Sequence[str]) -> ReportTable:
    """The table of some kinds of loads on some joints."""
    model, book = study.model, study.summary
    what = "guides" if "Guide moment" in loads else "bearings"
    if len(loads) == 1:
        what = "joints and loops that carry forces alone"
    elif "Drive" not in loads:
        what += " without a drive"
    columns: list[TableColumn] = []
    for title in loads:
        variable = _LOADS[title]
        head, cells = Printed(title, variable).column(study, book, "joint", names)
        least = NOISE * float(abs(book[variable]).max())
        columns.append((head, [_unless_noise(cell, least) for cell in cells]))
        columns.append(Printed("at", f"{variable}_time").column(study, book, "joint", names))
    bodies = {body.joint.name: k for k, body in enumerate(model.bodies, 1)}
    numbers = [bodies.get(name, "") for name in names]  # loops have none
    return named_rows(f"Peak loads on {what}", "Joint", names, columns, numbers)


def _unless_noise(cell: Cell, least: float) -> Cell:
    """The cell, as 0 where it is lost in the rounding of other joints' loads."""
    lost = isinstance(cell, PrintedNumber) and abs(cell.value) <= least
    return replace(cell, text="0") if lost else cell


def checks(study: Study) -> ReportTable:
    """The table of checks, each with its value and bar."""
    names, book = [c.name for c in study.checks], facts(study)
    said = {True: WordsCell("passed", css="ok"), False: WordsCell("failed", css="bad")}
    results = [said[check.passed] for check in study.checks]
    columns: list[TableColumn] = [(Head("Result", number=False), results)]
    for title, variable in (("Value", "check_value"), ("Allowed", "check_bar")):
        head, cells = Printed(title, variable).column(study, book, "check", names)
        columns.append((head, [alone(x, 2) for x in cells if isinstance(x, PrintedNumber)]))
    columns.append(
        words_column("What is compared", [typeset(c.text) for c in study.checks], "wide")
    )
    return named_rows("The same quantity computed in two ways", "Check", names, columns, None)


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
    columns = [words_column("exerted by", [load.other for load in body.loads])]
    for what, letter, unit, dim, tip in _COMPONENTS:
        for j, axis in enumerate(_axes(study, dim)):
            cells = [_component(study, body, load, what, {dim: axis}, j) for load in body.loads]
            columns.append((Head(f"{letter}{axis}", unit, tip), cells))
    return named_rows("", "Load", symbols, columns, None)


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


def _axes(study: Study, name: str) -> list[str]:
    return [str(axis) for axis in study.data[name].values]


TABLES = (
    drives, measured, work, ranges, follower_ranges, bodies, gravity, gravity_poses, reactions,
    checks,
)  # fmt: skip
"""Tables of the page, by the names of their functions."""


def whole(study: Study) -> xr.Dataset:
    """The summary of a study and the facts that its page shows beside it, in one dataset."""
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
