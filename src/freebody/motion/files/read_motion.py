"""Motions from CSV files.

A header names the columns: `t` or `time` and the coordinates of the positions as the model names
them; `name.v` and `name.a` give rates and accelerations of a coordinate, which are otherwise
differentiated (see `motion_of`). Units are the SI's and radians unless the header says `joint1
(deg)`.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from freebody.errors import FileError
from freebody.model.model import Model
from freebody.motion.files.csv_columns import read_columns
from freebody.motion.files.motion_columns import (
    check_names,
    doubted,
    motion_from_columns,
    without_jumps,
)
from freebody.motion.motion import FEWEST, Motion
from freebody.outputs.number_text import compared


def read_motion(model: Model, path: str | os.PathLike[str]) -> Motion:
    """The motion in a CSV file: a header with `t` and the model's position names, then one row per
    time.

    SI units and radians, or the unit written after a name: `joint1 (deg)`, `t [ms]`. Separated by
    commas, or by semicolons or tabs with decimal points or commas; what follows # is a comment.
    Noisy positions given with rates are adjusted to the rates; a rate below a millionth of the
    fastest of its kind is rest. Raises FileError with the line.
    """
    file = Path(path)
    read = read_columns(model, file)

    def problem(text: str, row: int | None = None) -> FileError:
        return FileError(file, read.rows[0 if row is None else row + 1][0], text)

    check_names(model, read.header, problem)
    count = len(read.rows) - 1
    if count < FEWEST:
        raise problem(f"{_count(count)} of numbers; a motion needs at least {FEWEST}.")
    table = read.values()
    columns = {name: table[:, k] for k, name in enumerate(read.header)}
    t, columns, before = without_jumps(model, columns.pop("t"), columns)
    late = np.flatnonzero(np.diff(t) <= 0)
    if len(late):
        k = int(late[0]) + 1
        now, before = compared(t[k], t[k - 1], digits=6)
        raise problem(f"t = {now} does not come after {before}; times must increase.", k)
    source = f"read from {file.name}, {count} rows"
    motion = motion_from_columns(model, t, columns, source, problem, before)
    return doubted(model, motion, columns, read.told, "'{} ({})' in the header")


def _count(n: int) -> str:
    return f"{n} row" if n == 1 else f"{n} rows"
