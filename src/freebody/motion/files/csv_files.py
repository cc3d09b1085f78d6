"""Motions, waypoints and torques read from CSV files, and motions written to them.

A header names the columns: `t` or `time` and the coordinates of the positions as the model names
them; `name.v` and `name.a` give rates and accelerations of a coordinate, which are otherwise
differentiated (see `motion_of`). Units are the SI's and radians unless the header says `joint1
(deg)`.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from freebody.arrays import Array
from freebody.errors import UnknownNameError
from freebody.formats import read_file
from freebody.model.model import Model
from freebody.model.shafts import shaft_names
from freebody.motion.files.csv_columns import CsvColumns, quoted, read_columns
from freebody.motion.files.motion_columns import (
    check_names,
    doubted,
    motion_from_columns,
    with_untold_twists,
    without_jumps,
)
from freebody.motion.motion import FEWEST, Motion, require_motion
from freebody.motion.ranges import angular, position_columns
from freebody.outputs.files import write
from freebody.outputs.harmless_text import csv_text
from freebody.outputs.number_text import compared

MotionRows = Literal["knots", "samples"]


def read_motion(model: Model, path: str | os.PathLike[str]) -> Motion:
    """The motion in a CSV file: a header with `t` and the model's position names, then one row per
    time.

    SI units and radians, or the unit written after a name: `joint1 (deg)`, `t [ms]`. Separated by
    commas, or by semicolons or tabs with decimal points or commas; what follows # is a comment.
    Noisy positions given with rates are adjusted to the rates; a rate below a millionth of the
    fastest of its kind is rest. Raises FileError with the line.
    """
    file = Path(read_file.path_of("read_motion", "path", path, "a CSV file"))
    read = read_columns(model, file)

    check_names(model, read.header, read.refusal)
    count = len(read.rows) - 1
    if count < FEWEST:
        raise read.refusal(f"{_count(count)} of numbers; a motion needs at least {FEWEST}.")
    table = read.values()
    columns = {name: table[:, k] for k, name in enumerate(read.header)}
    columns, untwisted = with_untold_twists(model, columns, count)
    t, columns, before = without_jumps(model, columns.pop("t"), columns)
    _require_increasing(read, t)
    source = f"read from {file.name}, {count} rows{untwisted}"
    motion = motion_from_columns(model, t, columns, source, read.refusal, before)
    return doubted(model, motion, columns, read.stated, "'{} ({})' in the header")


def _count(n: int) -> str:
    return f"{n} row" if n == 1 else f"{n} rows"


def read_waypoints(model: Model, path: str | os.PathLike[str]) -> tuple[Array, Array | None]:
    """Waypoints from a CSV file: positions (k, nq), and times (k,) or None.

    A header with the model's position names (of a closed chain those of the driven joints suffice),
    perhaps with `t`, units as in `read_motion`; then a row for each waypoint. For `quintic`,
    `spline` and the like. Raises FileError with the line.
    """
    file = Path(read_file.path_of("read_waypoints", "path", path, "a CSV file"))
    read = read_columns(model, file, timed=False, what="a file of waypoints")

    rates = [name for name in read.header if name[:-2] in model.position_names]
    rates = [name for name in rates if name not in model.position_names]
    if rates:
        raise read.refusal(
            f"column {rates[0]!r}: waypoints have positions alone; remove the column."
        )
    check_names(model, read.header, read.refusal)
    table = read.values()
    columns = dict(zip(read.header, table.T, strict=True))
    names = _planned_names(model, set(columns))
    columns = dict.fromkeys(shaft_names(model), np.zeros(len(table))) | columns
    missing = [name for name in names if name not in columns]
    if missing:
        raise read.refusal(f"there is no column for {quoted(missing)}.")
    return np.stack([columns[name] for name in names], axis=-1), columns.get("t")


def _planned_names(model: Model, given: set[str]) -> tuple[str, ...]:
    """Names of the positions that waypoints give: for a closed chain those of the driven joints,
    unless further ones are given."""
    driven = model.driven_names
    return driven if model.loops and not given - {"t", *driven} else model.position_names


def motion_table(model: Model, motion: Motion) -> tuple[list[str], Array]:
    """(header, rows) of a motion's samples; see `state_table`."""
    return state_table(model, motion.t, motion.q, motion.qd, motion.qdd)


def state_table(model: Model, t: Array, q: Array, qd: Array, qdd: Array) -> tuple[list[str], Array]:
    """(header, rows) of times (T,) and states (T, …) as `read_motion` reads them: positions, and
    rates and accelerations where they have a column."""
    iq, iv = position_columns(model)
    names = [model.position_names[k] for k in iq]
    header = ["t", *model.position_names, *(f"{n}.v" for n in names), *(f"{n}.a" for n in names)]
    return header, np.column_stack([t, q, qd[:, iv], qdd[:, iv]])


def write_motion(
    model: Model,
    motion: Motion,
    path: str | os.PathLike[str],
    rows: MotionRows = "knots",
) -> Path:
    """The path of the CSV file to which a motion is written, which `read_motion` and `freebody
    study` read.

    rows: "knots", the samples and the times at which polynomials of a planned motion meet, twice
    where its accelerations jump, so that the motion is read as it was planned; or "samples" alone.
    Raises FileError where it cannot be written.
    """
    if rows not in get_args(MotionRows):
        raise UnknownNameError("choice", rows, "write_motion: rows=", get_args(MotionRows))
    whole = require_motion("write_motion", model, motion)
    header, table = motion_table(model, whole if rows == "samples" else at_knots(whole))
    rated = whole.layout.flat or bool(model.loops)
    if rows == "knots" and whole.pieces is not None and rated:
        jumps = np.isin(table[:, 0], whole.jumps)
        twice, iq = table[jumps], position_columns(model)[0]
        twice[:, -len(iq) :] = whole.pieces.derivative(2).before(twice[:, 0])[:, iq]
        table = np.insert(table, np.flatnonzero(jumps), twice, axis=0)
    return write(path, csv_text([header, *table]))


def at_knots(motion: Motion) -> Motion:
    """The motion with samples also where its polynomials meet."""
    t = motion.knots
    if len(t) == len(motion.t):
        return motion
    states = motion.at(t)
    own = np.isin(t, motion.t)
    for found, given in zip(states, (motion.q, motion.qd, motion.qdd), strict=True):
        found[own] = given
    q, qd, qdd = states
    return replace(motion, t=t, q=q, qd=qd, qdd=qdd)


def read_torques(model: Model, path: str | os.PathLike[str]) -> tuple[Array, Array]:
    """Times (T,) and the torques of the drives (T, nv), N m and N, from a CSV file; 0 at joints
    that nothing drives.

    A header with `t` and the names of the driven coordinates, units and marks as in `read_motion`
    (`joint1 (N m)`, `slide (kN)`); then a row for each time. Raises FileError with the line.
    """
    file, names = Path(path), model.velocity_names
    kinds = {
        n: "torque" if turns else "force" for n, turns in zip(names, angular(model), strict=True)
    }
    read = read_columns(model, file, what="a file of torques", quantities=kinds)

    for name in read.header:
        if name != "t" and name not in model.driven_names:
            known = ("t", *model.driven_names)
            raise read.refusal(
                str(UnknownNameError("column", name, f"torques of {model.name!r}", known))
            )
    missing = [name for name in model.driven_names if name not in read.header]
    if missing:
        raise read.refusal(
            f"there is no column for {quoted(missing)}; write 0 for a drive that exerts no torque."
        )
    if len(read.rows) < 3:
        raise read.refusal(
            "there are fewer than two rows of numbers; torques over time need at least two."
        )
    columns = dict(zip(read.header, read.values().T, strict=True))
    t = columns.pop("t")
    _require_increasing(read, t)
    tau = np.zeros((len(t), model.nv))
    for name, column in columns.items():
        tau[:, names.index(name)] = column
    return t, tau


def _require_increasing(read: CsvColumns, t: Array) -> None:
    """Refuse a table with a row whose time is not later than the one before."""
    late = np.flatnonzero(np.diff(t) <= 0.0)
    if len(late):
        k = int(late[0]) + 1
        now, before = compared(t[k], t[k - 1], digits=6)
        raise read.refusal(f"t = {now} does not come after {before}; times must increase.", k)
