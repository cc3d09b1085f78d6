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
from freebody.motion.motion import Motion
from freebody.motion.ranges import position_columns, ranges
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.positions import home_guess

_THERE = 1e-6
"""m: how far from its last place the tip of a planned motion may end."""


class TipPlaces:
    """The positions at which the tip of a robot is at places of a file, one after another.

    at: the position (nq,) where the robot is; None before it has been anywhere: at the model's
    home.
    """

    def __init__(self, model: Model):
        self.model = model
        self.at: Array | None = None
        self._known: dict[tuple[float, ...], Array] = {}

    def reached(self, table: TomlTable) -> Array:
        """Positions of the joints (k, nq), of a closed chain of the driven ones, at which the tip
        is at the places of a table: those of a place that was reached before, else the nearest to
        the one before."""
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
            at = self._known[place]
            found.append(at)
        names = model.driven_names if model.loops else model.position_names
        return np.array(found)[:, [model.position_names.index(name) for name in names]]

    def require_there(self, table: TomlTable, motion: Motion) -> None:
        """Refuse a motion of a closed chain whose loops close in another way than at the last
        place."""
        place = _places(self.model, table)[-1]
        point = place if place.ndim == 1 else place[:-1, -1]
        off = forward_kinematics(self.model, motion.q[-1])[:-1, -1] - point
        if np.abs(off).max() > _THERE:
            table.refuse(
                "the loops close in another way on the way to the last place; give places nearer "
                "to each other, or points of the driven joints.",
                "tip",
            )


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
