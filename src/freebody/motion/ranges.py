"""The ranges of coordinates that a motion can use."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import listed
from freebody.lazy import kept
from freebody.model.model import Model
from freebody.model.usable_limits import usable_limits
from freebody.trees.position_rates import Index

Flags = NDArray[np.bool_]
"""Array of truth values."""

CLOSE = 1e-9
"""Share of a limit: what is beyond it by less is on it, and so within."""


@dataclass(frozen=True)
class Ranges:
    """The usable range of each velocity coordinate as arrays (nv,), infinite where there is no
    limit.

    A speed or effort limit of 0 and a position range of no width count as absent (`Limits.meant`),
    and `notices` say so. The range of a joint that others follow is narrowed to theirs, where they
    meet.
    """

    lower: Array
    upper: Array
    velocity: Array
    effort: Array
    turns: Flags
    """Whether the coordinate is an angle."""
    notices: tuple[str, ...]
    apart: tuple[str, ...] = ()
    """Joints that follow another and whose range has nothing in common with that one's, in
    words."""

    @property
    def middle(self) -> Array:
        """The middle (nv,) of each range, 0 where it is infinite."""
        bounded = np.isfinite(self.upper) & np.isfinite(self.lower)
        return 0.5 * (np.where(bounded, self.lower, 0.0) + np.where(bounded, self.upper, 0.0))

    @property
    def width(self) -> Array:
        """The width (nv,) of each range as a length scale: upper - lower, or where that is infinite
        2π rad, 1 m."""
        width = self.upper - self.lower
        return np.where(np.isfinite(width), width, np.where(self.turns, 2 * np.pi, 1.0))


def ranges(model: Model) -> Ranges:
    """The usable ranges of a model's coordinates; their arrays cannot be written to."""
    return kept(model, "_ranges", _ranges, model)


def _ranges(model: Model) -> Ranges:
    found = usable_limits(model)
    turns = angular(model)
    for array in (*found[:4], turns):
        array.flags.writeable = False
    names, given = model.velocity_names, found.given
    notices = [
        f"{what} of {listed(compress(names, bad), 6)} is zero in the model and is taken as not "
        f"given."
        for what, bad in (
            ("the position range", given[0] == given[1]),
            ("the speed limit", given[2] == 0),
            ("the effort limit", given[3] == 0),
        )
        if bad.any()
    ]
    return Ranges(*found[:4], turns, tuple(notices), found.apart)


def angular(model: Model) -> Flags:
    """Flags (nv,): whether a coordinate is an angle (rad, N m) rather than a length (m, N)."""
    flags: list[bool] = []
    for body in model.bodies:
        if body.joint.mimic is None:
            flags += body.kind.angular
    return np.array(flags, dtype=bool)


def with_drive(model: Model) -> Flags:
    """Flags (nv,): whether something drives a coordinate."""
    return ~np.isin(np.arange(model.nv), model.passive)


def position_columns(model: Model) -> tuple[Index, Index]:
    """The indices (iq, iv) of entries of q and q̇ that belong together, for coordinates outside
    quaternions; read-only."""
    return kept(model, "_position_columns", _position_columns, model)


def _position_columns(model: Model) -> tuple[Index, Index]:
    iq: list[int] = []
    iv: list[int] = []
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None and body.kind.nq == body.kind.nv:
            iq += at.q
            iv += at.v
    columns = np.array([iq, iv], dtype=int)
    columns.flags.writeable = False
    return columns[0], columns[1]
