"""Places of the tip in files of duty cycles, and the positions of the joints that reach them."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from freebody.arrays import Array
from freebody.errors import listed
from freebody.formats.toml_table import TomlTable
from freebody.inverse.inverse_kinematics import inverse_kinematics
from freebody.model.model import Model
from freebody.motion.closed_chain_motion import home
from freebody.motion.ranges import position_columns, ranges
from freebody.trees.positions import home_guess


class TipPlaces:
    """The positions at which the tip of a robot is at places of a file, one after another.

    at: the position (nq,) where the robot is; None before it has been anywhere: at the model's
    home. headed_for: the place that was asked for last.
    """

    def __init__(self, model: Model):
        self.model = model
        self.at: Array | None = None
        self.headed_for: tuple[float, ...] | None = None
        self._known: dict[tuple[float, ...], Array] = {}

    def reached(self, table: TomlTable) -> Array:
        """Positions (k, nq), of a closed chain closed ones, at which the tip is at the places of a
        table: those of a place that was reached before, else the nearest to the one before."""
        model, found = self.model, []
        at = self.at
        if at is None:
            at = home(model) if model.loops else home_guess(model)
        for k, target in enumerate(_places(model, table)):
            place = tuple(target.ravel().tolist())
            if place not in self._known:
                solutions = inverse_kinematics(model, target, q0=at, limits="drop")
                if not solutions.valid.any():
                    table.refuse(
                        f"no position brings the tip to place {k + 1}"
                        f"{_why(model, target, at)}.",
                        "tip", k,
                    )  # fmt: skip
                self._known[place] = solutions.nearest(at)
            at, self.headed_for = self._known[place], place
            found.append(at)
        return np.array(found)

    def arrived(self, q: Array) -> None:
        """The robot is at q (nq,) now: at the place that it was headed for, if at any, with the
        whole turns that loops may have led joints through."""
        self.at = q
        if self.headed_for is not None:
            self._known[self.headed_for], self.headed_for = q, None


def _why(model: Model, target: Array, at: Array) -> str:
    """Why no position reaches a target: how far it is away, or which joints' limits the nearest one
    exceeds."""
    anywhere = inverse_kinematics(model, target, q0=at, limits="ignore")
    if not anywhere.valid.any():
        return f": it is {float(anywhere.distance):.4g} m out of reach"
    (iq, iv), allowed = position_columns(model), ranges(model)
    q, names = anywhere.nearest(at)[iq], np.array(model.velocity_names)[iv]
    beyond = (q < allowed.lower[iv]) | (q > allowed.upper[iv])
    joints = [f"{name} at {x:.4g}" for name, x in zip(names[beyond], q[beyond], strict=True)]
    return f" within the joints' limits: {listed(joints, 8)} is beyond its own" if joints else ""


_PLACE = {
    2: "x, y and the angle, or x, y alone",
    3: "x, y, z, roll, pitch, yaw, or x, y, z alone",
}
"""The entries of a place of the tip, in the plane and in space."""


def _places(model: Model, table: TomlTable) -> list[Array]:
    """Points (dim,), or poses (dim + 1, dim + 1) where an orientation is given."""
    dim, turns = model.dim, 3 if model.dim == 3 else 1
    found = []
    for i, row in enumerate(table.listed(table.data["tip"], "tip", None)):
        kinds = ("number",) * dim + ("angle",) * turns
        size = dim if isinstance(row, list) and len(row) == dim else len(kinds)
        row = table.listed(row, "tip", size, i, each=_PLACE[dim])
        numbers = [
            table.read_number(x, kind, ("tip", i, j))
            for j, (x, kind) in enumerate(zip(row, kinds, strict=False))
        ]
        place = np.array(numbers[:dim])
        if size > dim:
            angles = numbers[dim:] if dim == 3 else [0.0, 0.0, *numbers[dim:]]
            pose = np.eye(dim + 1)
            pose[:dim, :dim] = Rotation.from_euler("xyz", angles).as_matrix()[:dim, :dim]
            pose[:dim, dim] = place
            place = pose
        found.append(place)
    return found
