"""`dexterity`: how well a frame moves in all directions, at each posture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from freebody.algorithms.screws import arm_length
from freebody.algorithms.singular_values import singular_values
from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.problem.task import row_names, rows_of
from freebody.kernels.formulas import Option
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.program import Argument
from freebody.reach.jacobian_rows import OfRows
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.trees.public_calls import JointVector
from freebody.values import ByValue

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class Dexterity(Tabled, ByValue):
    """The singular values of a frame's Jacobian at each posture (...): the speeds, at joint rates
    of length 1, along the axes of the velocity ellipsoid; their inverses are the semi-axes of the
    force ellipsoid.

    singular_values: (..., k), the largest first, k the smaller of rows and joints. rows: names of
    the rows. length: m, by which linear rows are divided so that they compare with angular ones; 1
    where all rows are of one kind. frame: its name.
    """

    singular_values: Array
    rows: tuple[str, ...]
    length: float
    frame: str

    @property
    def manipulability(self) -> Array:
        """The product of the singular values (...), which is the ellipsoid's volume up to a
        constant (Yoshikawa 1985)."""
        return np.asarray(self.singular_values.prod(axis=-1))

    @property
    def condition(self) -> Array:
        """The ratio of the largest to the smallest singular value (...): 1 where all directions are
        alike, infinite where one is lost."""
        largest, smallest = self.singular_values[..., 0], self.singular_values[..., -1]
        lost = smallest <= 0.0
        return np.where(lost, np.inf, largest / np.where(lost, 1.0, smallest))

    @property
    def smallest(self) -> Array:
        """The smallest singular value (...): how far the Jacobian is from a singular one, in the
        norm of matrices."""
        return self.singular_values[..., -1]

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the postures: the singular values and the measures that follow
        from them."""
        dims = axes_of("posture", self.smallest.ndim)
        linear, k = self.rows[-1].startswith("v"), self.singular_values.shape[-1]
        one, product = ("m", f"m{k}") if linear else ("1", "1")
        what = f"of the Jacobian of {self.frame}"
        return labelled(
            {
                "singular_values": ((*dims, "value"), self.singular_values, one, f"those {what}"),
                "manipulability": (dims, self.manipulability, product, "product of them"),
                "condition": (dims, self.condition, "1", "largest over smallest"),
            },
            {},
            {"frame": self.frame, "rows": " ".join(self.rows), "length": self.length},
        )

    def _title(self) -> str:
        postures = counted(self.smallest.size, "posture")
        return f"Dexterity: {postures} of frame {self.frame!r}, rows {', '.join(self.rows)}"

    def _table(self) -> TextTable:
        if not self.smallest.size:
            return TextTable((), ())
        measures = {
            "manipulability": self.manipulability,
            "condition number": self.condition,
            "smallest singular value": self.smallest,
        }
        rows = [
            (name, *(f"{f(x):.4g}" for f in (np.min, np.median, np.max)))
            for name, x in measures.items()
        ]
        return TextTable(("measure", "least", "median", "largest"), rows)


def dexterity(
    model: Model,
    q: JointVector,
    frame: str | None = None,
    task: str | Sequence[str] = "pose",
    *,
    length: float | None = None,
) -> Dexterity:
    """How well a frame moves in all directions at each posture: the singular values of its
    Jacobian.

    q: (..., nq), such as `fb.random_state(model, seed, 10**6)[0]`. frame: name, default the tip.
    task: what counts of its motion, "pose", "position", "orientation", or rows as for
    `fb.inverse_kinematics`. length: m, what a radian is worth where linear and angular rows both
    count; default the arm's length, from joint to joint.

    Returns Dexterity, with manipulability, condition number and distance to singularity. Open
    chains. Raises FreebodyError, ShapeError, NotFiniteError, UnknownNameError.
    """
    function = "dexterity"
    model.require_values(function)
    model.require_tree(function)
    rows = rows_of(function, model, task)
    name = model.frame(frame).name
    both = any(r < model.dim for r in rows) and any(r >= model.dim for r in rows)
    if length is not None and not (np.isfinite(length) and length > 0):
        raise FreebodyError(f"{function}: length is {length}, expected a positive number (m).")
    if length is not None and not both:
        raise FreebodyError(
            f"{function}: length makes linear and angular rows compare; the task has rows of one "
            f"kind. Leave it out."
        )
    scale = (length or arm_length(model.tree, name)) if both else 1.0
    values = _VALUES.at(model, Option(name, rows=rows), q, scale)
    return Dexterity(values, tuple(row_names(model.dim)[r] for r in rows), scale, name)


def _outputs(r: int, n: int) -> tuple[Argument, ...]:
    return (Argument("singular_values", (min(r, n),)),)


def _decomposed(J: Array) -> Array:
    return np.asarray(np.linalg.svd(J, compute_uv=False), dtype=float)


_VALUES = OfRows("dexterity", _outputs, singular_values, _decomposed)
