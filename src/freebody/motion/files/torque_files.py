"""Torques over time from CSV files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from freebody.arrays import Array
from freebody.errors import FileError, UnknownNameError
from freebody.model.model import Model
from freebody.motion.files.csv_columns import quoted, read_columns
from freebody.motion.ranges import angular
from freebody.outputs.number_text import compared


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

    def problem(text: str, row: int | None = None) -> FileError:
        return FileError(file, read.rows[0 if row is None else row + 1][0], text)

    for name in read.header:
        if name != "t" and name not in model.driven_names:
            known = ("t", *model.driven_names)
            raise problem(
                str(UnknownNameError("column", name, f"torques of {model.name!r}", known))
            )
    missing = [name for name in model.driven_names if name not in read.header]
    if missing:
        raise problem(
            f"there is no column for {quoted(missing)}; write 0 for a drive that exerts no torque."
        )
    if len(read.rows) < 3:
        raise problem(
            "there are fewer than two rows of numbers; torques over time need at least two."
        )
    columns = dict(zip(read.header, read.values().T, strict=True))
    t = columns.pop("t")
    late = np.flatnonzero(np.diff(t) <= 0.0)
    if len(late):
        k = int(late[0]) + 1
        now, before = compared(t[k], t[k - 1], digits=6)
        raise problem(f"t = {now} does not come after {before}; times must increase.", k)
    tau = np.zeros((len(t), model.nv))
    for name, column in columns.items():
        tau[:, names.index(name)] = column
    return t, tau
