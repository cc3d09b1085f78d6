"""Waypoints from CSV files, and motions into them."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from freebody.arrays import Array
from freebody.errors import FileError, UnknownNameError
from freebody.model.model import Model
from freebody.motion.files.csv_columns import quoted, read_columns
from freebody.motion.files.motion_columns import check_names
from freebody.motion.motion import Motion, require_motion
from freebody.motion.ranges import position_columns
from freebody.outputs.files import write
from freebody.outputs.text import csv_text

Rows = Literal["knots", "samples"]


def read_waypoints(model: Model, path: str | os.PathLike[str]) -> tuple[Array, Array | None]:
    """Waypoints from a CSV file: positions (k, nq), and times (k,) or None.

    A header with the model's position names (of a closed chain those of the driven joints suffice),
    perhaps with `t`, units as in `read_motion`; then a row for each waypoint. For `quintic`,
    `spline` and the like. Raises FileError with the line.
    """
    file = Path(path)
    read = read_columns(model, file, timed=False, what="a file of waypoints")

    def problem(text: str, row: int | None = None) -> FileError:
        return FileError(file, read.rows[0 if row is None else row + 1][0], text)

    rates = [name for name in read.header if name[:-2] in model.position_names]
    rates = [name for name in rates if name not in model.position_names]
    if rates:
        raise problem(f"column {rates[0]!r}: waypoints have positions alone; remove the column.")
    check_names(model, read.header, problem)
    table = read.values()
    columns = dict(zip(read.header, table.T, strict=True))
    names = _planned_names(model, set(columns))
    missing = [name for name in names if name not in columns]
    if missing:
        raise problem(f"there is no column for {quoted(missing)}.")
    return np.stack([columns[name] for name in names], axis=-1), columns.get("t")


def _planned_names(model: Model, given: set[str]) -> tuple[str, ...]:
    """Of a closed chain the driven joints, unless others are given too."""
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
    rows: Rows = "knots",
) -> Path:
    """Write a motion as a CSV file that `read_motion` and `freebody study` read; the path.

    rows: "knots", the samples and the times at which polynomials of a planned motion meet, twice
    where its accelerations jump, so that the motion is read as it was planned; or "samples" alone.
    Raises FileError where it cannot be written.
    """
    if rows not in get_args(Rows):
        raise UnknownNameError("choice", rows, "write_motion: rows=", get_args(Rows))
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
