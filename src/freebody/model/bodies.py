"""The bodies and frames that a `Model` is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.lazy import Keeps
from freebody.model.description import Joint
from freebody.model.joints import KINDS, JointKind
from freebody.model.placement import Placement
from freebody.model.tree import Attached
from freebody.outputs.display import Tabled, TextTable
from freebody.values import ByValue


@dataclass(frozen=True)
class Frame:
    """A named frame fixed to a body (index; -1 is the base), placed in the body's frame.

    `parent` is the frame it is fixed to, empty for the frame of a body's first link or of the base.
    It belongs to a link unless it is `mounted`; `joint` is the name of the fixed joint above that
    link.
    """

    name: str
    body: int
    placement: Placement = Placement()
    parent: str = ""
    mounted: bool = False
    joint: str = ""


@dataclass(frozen=True)
class Body(Keeps):
    """A movable rigid body: the joint that carries it, the body it hangs on (-1: the base), and its
    mass.

    The body's frame is its joint's: the link frame of the joint's child at the joint.
    `joint.placement` is given in the parent body's frame. `inertias` keeps every link that is
    lumped here under its own name.
    """

    name: str
    joint: Joint
    parent: int
    inertias: tuple[Attached, ...] = ()

    @property
    def kind(self) -> JointKind:
        """The record of the kind of the body's joint."""
        return KINDS[self.joint.kind]


@dataclass(frozen=True, eq=False)
class JointLimits(Tabled, ByValue):
    """Joint limits for each entry of q̇, infinite for joints of several axes: arrays (nv,); rad or
    m, rad/s or m/s, N m or N."""

    lower: Array
    upper: Array
    velocity: Array
    effort: Array

    def _title(self) -> str:
        return "Joint limits"

    def _table(self) -> TextTable:
        angle, rate, effort = "(rad, m)", "(rad/s, m/s)", "(N m, N)"
        head = ("", f"lower {angle}", f"upper {angle}", f"velocity {rate}", f"effort {effort}")
        columns = (
            np.moveaxis(x, -1, 0) for x in (self.lower, self.upper, self.velocity, self.effort)
        )
        rows = [
            (f"[{k}]", *(_spread(x) for x in row))
            for k, row in enumerate(zip(*columns, strict=True))
        ]
        return TextTable(head, rows)


def _spread(x: Array) -> str:
    """A number as text, or the range of the numbers of a family."""
    return f"{x:.4g}" if not x.ndim else f"{x.min():.4g} … {x.max():.4g}"
