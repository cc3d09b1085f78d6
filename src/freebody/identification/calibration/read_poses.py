"""`read_poses`: joints and measured poses from a table, a row each."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, listed
from freebody.identification.calibration.poses import Poses, rotations
from freebody.identification.logs.table import LogTable, table_of_log
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.model.parameters import LARGEST
from freebody.motion.files.csv_columns import UNITS, kinds, named_unit

_UNIT_LENGTH = 1e-3
"""Departure of a quaternion's length from 1 that the digits of a file explain."""


@dataclass(frozen=True)
class _RotationColumns:
    """A way to write rotations: names of its columns, the kind of their units, and the matrices
    (n, 3, 3) of their values (n, columns)."""

    names: tuple[str, ...]
    kind: str
    matrices: Callable[[Array], Array]


def _of_quaternions(x: Array) -> Array:
    from scipy.spatial.transform import Rotation

    length = np.linalg.norm(x, axis=1)
    wrong = np.flatnonzero(np.abs(length - 1.0) > _UNIT_LENGTH)
    if len(wrong):
        k = int(wrong[0])
        raise FreebodyError(
            f"read_poses: the quaternion of pose {k} has length {length[k]:.4g}, expected 1; give "
            f"unit quaternions qw, qx, qy, qz."
        )
    return Rotation.from_quat(x, scalar_first=True).as_matrix()


def _of_vectors(x: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(x).as_matrix()


def _of_angles(x: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xyz", x).as_matrix()


def _of_entries(x: Array) -> Array:
    return rotations("read_poses", "pose", x.reshape(-1, 3, 3))


_WAYS = (
    _RotationColumns(("qw", "qx", "qy", "qz"), "number", _of_quaternions),
    _RotationColumns(("rx", "ry", "rz"), "angle", _of_vectors),
    _RotationColumns(("roll", "pitch", "yaw"), "angle", _of_angles),
    _RotationColumns(
        tuple(f"r{i}{j}" for i in "123" for j in "123"), "number", _of_entries
    ),
)  # fmt: skip


def read_poses(path: Any, model: Model) -> Poses:
    """Measured poses of a robot's marker from a table: a row holds the positions of the joints and
    what the instrument saw. The order of rows does not matter.

    Parameters
    ----------
    path
        A CSV or Parquet file, or a dict or DataFrame of columns. A header names the columns: each
        joint by its name, or q1, q2 … in the model's order; `x, y, z` of the marker; where
        rotations were measured `qw, qx, qy, qz`, or a rotation vector `rx, ry, rz`, or `roll,
        pitch, yaw` (fixed axes), or the entries r11 … r33. Units stand behind the names, as in
        `elbow (deg)`, `x (mm)`; else they are rad and m. Other columns are not read.
    model
        Whose joints they are.

    Returns
    -------
    Poses
        In SI units, in the model's order of joints.

    Raises
    ------
    FileError
        A file that cannot be read, a cell without a number, or a column that is missing, with the
        line and the remedy.
    """
    require_model("read_poses", model)
    table = table_of_log(path, "read_poses")
    if table.names is None:
        raise table.refusal(
            "the table has no header; name its columns: the joints "
            f"({listed(model.position_names, 8)}), x, y, z, and of rotations qw, qx, qy, qz."
        )
    columns = _PoseColumns(table)
    of_joints = columns.joints(model)
    of_points = [("x", "length"), ("y", "length"), ("z", "length")]
    way = next((x for x in _WAYS if columns.has(x.names)), None)
    turned = [] if way is None else [(name, way.kind) for name in way.names]
    values = columns.values([*of_joints, *of_points, *turned])
    name = Path(path).name if isinstance(path, str | os.PathLike) else "a table"
    n = model.nq
    return Poses(
        values[:, :n],
        values[:, n : n + 3],
        None if way is None else way.matrices(values[:, n + 3 :]),
        f"read from {name}",
        columns.unread(),
    )


class _PoseColumns:
    """The columns of a table by the names in its header."""

    def __init__(self, table: LogTable):
        self.table = table
        self.found: dict[str, tuple[int, str | None]] = {}
        self.read: set[str] = set()
        for k, cell in enumerate(table.names or ()):
            name, unit = named_unit(cell, {})
            if name in self.found:
                raise table.refusal(f"column {name!r} occurs twice in the header; remove one.")
            self.found[name] = k, unit

    def has(self, names: Sequence[str]) -> bool:
        """Whether any of some columns is there; some without the others are refused in time."""
        return any(name in self.found for name in names)

    def joints(self, model: Model) -> list[tuple[str, str]]:
        """Columns of the joints with the kinds of their units, in the model's order. A joint that
        is called like a coordinate of the marker has to be counted."""
        names, of_model = list(model.position_names), kinds(model)
        counted = [f"q{k + 1}" for k in range(len(names))]
        taken = {"x", "y", "z"}.union(*(way.names for way in _WAYS)) & set(names)
        used = counted if taken or (not self.has(names) and self.has(counted)) else names
        return [(name, of_model[joint]) for name, joint in zip(used, names, strict=True)]

    def values(self, wanted: Sequence[tuple[str, str]]) -> Array:
        """Numbers (n, wanted) of columns with the kinds of their units, in SI units."""
        missing = [name for name, _ in wanted if name not in self.found]
        if missing:
            raise self.table.refusal(
                f"the header has no column {listed(map(repr, missing), 8)}; it has "
                f"{listed(map(repr, self.found), 12)}."
            )
        self.read = {name for name, _ in wanted}
        rows = self.table.rows([self.found[name][0] for name, _ in wanted])
        if rows.broken:
            line, why = rows.broken[0]
            raise self.table.refusal(f"{why}; mend the row or remove it.", line)
        bad = np.argwhere(~(np.abs(rows.values) <= LARGEST))
        if len(bad):
            row, k = bad[0]
            raise self.table.refusal(
                f"column {wanted[k][0]!r} has no finite number; mend the row or remove it.",
                int(rows.lines[row]),
            )
        return rows.values * [self.factor(name, kind) for name, kind in wanted]

    def factor(self, name: str, kind: str) -> float:
        """The factor from a column's unit to SI units."""
        unit = self.found[name][1]
        if unit is None:
            return 1.0
        if unit not in UNITS[kind]:
            raise self.table.refusal(
                f"column {name!r}: {unit!r} is not a unit of its {kind}; units: "
                f"{', '.join(UNITS[kind])}."
            )
        return UNITS[kind][unit]

    def unread(self) -> tuple[str, ...]:
        """A sentence on the columns that were not read."""
        rest = [name for name in self.found if name not in self.read]
        return (f"Columns not read: {listed(rest, 8)}.",) if rest else ()
