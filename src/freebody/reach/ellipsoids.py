"""`ellipsoids`: velocities and forces of a frame that joint rates and torques of length 1 give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.singular_values import left_singular_vectors, vectors_and_values
from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.problem.task import row_names, rows_of
from freebody.kernels.formulas import Option
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.program import Argument
from freebody.reach.jacobian_rows import OfRows
from freebody.trees.public_calls import JointVector
from freebody.values import ByValue


@dataclass(frozen=True, eq=False, repr=False)
class Ellipsoids(Tabled, ByValue):
    """The axes of the velocity and force ellipsoids of a frame at each posture (...).

    directions: (..., r, r), unit vectors at right angles, one a row, world axes, the longest axis
    of the velocity ellipsoid first; of the two senses of an axis that in which the first entry of
    more than half the largest one's size is positive. Axes of equal length are any that span the
    same. singular_values: (..., r), of the Jacobian, 0 along a direction that is lost. rows: names
    of the r rows. frame: its name.
    """

    directions: Array
    singular_values: Array
    rows: tuple[str, ...]
    frame: str

    @property
    def velocity(self) -> Array:
        """Semi-axes (..., r, r) of the velocity ellipsoid, one a row, in m/s (rad/s for angular
        rows), at joint rates of length 1 (rad/s and m/s alike)."""
        return self.directions * self.singular_values[..., None]

    @property
    def force(self) -> Array:
        """Semi-axes (..., r, r) of the force ellipsoid, one a row, in N (N m), which joint torques
        of length 1 (N m and N alike) hold at rest; infinite along a lost direction, in which the
        links bear any load."""
        size = self.singular_values[..., None]
        lost = size == 0.0
        along = np.where(self.directions == 0.0, 0.0, np.copysign(np.inf, self.directions))
        return np.where(lost, along, self.directions / np.where(lost, 1.0, size))

    def _title(self) -> str:
        postures = counted(self.singular_values[..., 0].size, "posture")
        return f"Ellipsoids: {postures} of frame {self.frame!r}, rows {', '.join(self.rows)}"

    def _table(self) -> TextTable:
        if self.singular_values.ndim > 1:
            return TextTable((), ())
        unit, held = ("m/s", "N") if self.rows[0].startswith("v") else ("rad/s", "N m")
        rows = [
            (*(f"{x:.4f}" for x in way), f"{s:.4g}", f"{1.0 / s:.4g}" if s else "∞")
            for way, s in zip(self.directions, self.singular_values, strict=True)
        ]
        return TextTable((*self.rows, f"velocity ({unit})", f"force ({held})"), rows)


def ellipsoids(
    model: Model, q: JointVector, frame: str | None = None, task: str | Sequence[str] = "position"
) -> Ellipsoids:
    """The axes of a frame's velocity ellipsoid, and of its force ellipsoid, at each posture.

    q: (..., nq). frame: name, default the tip. task: "position", "orientation", or rows of one kind
    as for `fb.inverse_kinematics`.

    The left singular vectors of the Jacobian are the directions of both; the lengths are its
    singular values and their inverses (Yoshikawa 1985). Returns Ellipsoids. Open chains. Raises
    FreebodyError, ShapeError, NotFiniteError, UnknownNameError.
    """
    function = "ellipsoids"
    model.require_values(function)
    model.require_tree(function)
    if model.family:
        raise FamilyError(function, model.name, model.family)
    rows = rows_of(function, model, task)
    if len({r < model.dim for r in rows}) > 1:
        raise FreebodyError(
            f"{function}: the task has linear and angular rows, whose lengths do not compare; take "
            f'"position" or "orientation".'
        )
    name = model.frame(frame).name
    directions, sizes = _AXES.at(model, Option(name, rows=rows), q)
    return Ellipsoids(directions, sizes, tuple(row_names(model.dim)[r] for r in rows), name)


def _outputs(r: int, _: int) -> tuple[Argument, ...]:
    return Argument("directions", (r, r)), Argument("singular_values", (r,))


def _decomposed(J: Array) -> tuple[Array, Array]:
    """Directions and singular values of matrices (..., r, nv)."""
    U, s, _ = np.linalg.svd(J)
    sizes = np.zeros(U.shape[:-1])
    sizes[..., : s.shape[-1]] = s
    vectors = (tuple(x) for x in np.moveaxis(U, (-1, -2), (0, 1)))
    ways, values = vectors_and_values(tuple(vectors), tuple(np.moveaxis(sizes, -1, 0)))
    return np.moveaxis(np.array(ways), (0, 1), (-2, -1)), np.stack(values, axis=-1)


_AXES = OfRows("ellipsoids", _outputs, left_singular_vectors, _decomposed)
