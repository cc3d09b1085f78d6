"""`Poses`: where the joints of a robot stood, and where an instrument saw its marker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, ShapeError
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted

_SQUARE = 1e-3
"""Departure of R Rᵀ from 1 up to which a matrix is a rotation, written with few digits."""


@dataclass(frozen=True, eq=False, repr=False)
class Poses(Tabled, ByValue):
    """Measured poses of a marker on a robot, with the positions of the joints, row by row.

    q: (n, nq) rad, m, in the model's order. position: (n, 3) m, of the marker in the instrument's
    axes. rotation: (n, 3, 3) of the marker in these axes, or None where points were measured.
    """

    q: Array
    position: Array
    rotation: Array | None = None
    source: str = ""
    notices: tuple[str, ...] = ()
    _aside = ("source", "notices")
    _copies = True

    def __len__(self) -> int:
        return len(self.q)

    def of(self, rows: Any) -> Poses:
        """Some of the poses, chosen as NumPy chooses rows."""
        rotation = None if self.rotation is None else self.rotation[rows]
        return Poses(self.q[rows], self.position[rows], rotation, self.source, self.notices)

    def _title(self) -> str:
        what = "points" if self.rotation is None else "poses"
        return f"{len(self)} measured {what} {self.source}".rstrip()

    def _table(self) -> TextTable:
        rows = [
            (axis, f"{self.position[:, k].min():.4g}", f"{self.position[:, k].max():.4g}")
            for k, axis in enumerate("xyz")
        ]
        return TextTable(("", "from (m)", "to (m)"), rows, self.notices)


def poses_of(function: str, model: Model, q: ArrayLike, poses: ArrayLike) -> Poses:
    """Poses from arrays: q (n, nq), and positions (n, 3) or poses (n, 4, 4). Refuses what is no
    number, no rotation, or does not fit."""
    joints = as_floats(function, "q", q)
    seen = as_floats(function, "poses", poses)
    if joints.ndim != 2 or joints.shape[1] != model.nq:
        raise ShapeError(
            function, "q", joints.shape, f"(n, {model.nq})", f"model {model.name!r} has "
            f"nq = {model.nq}, a row for each pose",
        )  # fmt: skip
    if seen.shape[1:] not in ((3,), (4, 4)):
        raise ShapeError(function, "poses", seen.shape, "(n, 3) positions, or (n, 4, 4) poses")
    if len(seen) != len(joints):
        raise FreebodyError(
            f"{function}: q has {len(joints)} rows and poses {len(seen)}; give a row of q for each "
            f"pose, in one order."
        )
    refuse_not_finite(function, "q", joints, 1, model.position_names)
    if seen.ndim == 2:
        refuse_not_finite(function, "poses", seen, 1, "xyz")
        return Poses(joints, seen)
    refuse_not_finite(function, "poses", seen, 2)
    return Poses(joints, seen[:, :3, 3], rotations(function, "pose", seen[:, :3, :3]))


def rotations(function: str, what: str, given: Array) -> Array:
    """The rotation matrices (n, 3, 3) nearest to given ones; refuses what is far from any, naming
    the first by its index and `what` it is of."""
    off = np.abs(given @ np.swapaxes(given, 1, 2) - np.eye(3)).max(axis=(1, 2))
    mirrored = np.linalg.det(given) < 0.0
    wrong = np.flatnonzero(mirrored | ~(off <= _SQUARE))
    if len(wrong):
        k = int(wrong[0])
        others = f" ({counted(len(wrong), 'pose')} in all)" if len(wrong) > 1 else ""
        if mirrored[k]:
            why = (
                "is left-handed (its determinant is negative): turn over one axis of the "
                "instrument or of the marker, or swap two"
            )
        else:
            why = f"is none: R Rᵀ differs from 1 by {off[k]:.2g}; give unit axes in its columns"
        raise FreebodyError(f"{function}: the rotation of {what} {k} {why}{others}.")
    u, _, vt = np.linalg.svd(given)
    return u @ vt
