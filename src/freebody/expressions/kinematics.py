"""Kinematics in closed form: a frame's position, velocity, Jacobian and acceleration (2.10-2.24).

>>> import freebody as fb
>>> from freebody.expressions.kinematics import kinematics
>>> arm = kinematics(fb.planar("RR"))
>>> print(arm.form(arm.position[0]))
l1 cos θ1 + l2 cos(θ1 + θ2)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from freebody.algorithms import kinematics as algorithms
from freebody.errors import FreebodyError
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.polynomials.determinant import columns_of, determinant
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols, symbols
from freebody.expressions.polynomials.textbook_form import InTextbookForm
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.scalars.trig import Trig

Entries = list[list[Trig]]


@dataclass(frozen=True)
class Kinematics(InTextbookForm):
    """Closed forms of one frame, exact polynomials in normal form: equal means identical. World
    axes."""

    symbols: Symbols
    frame: str

    @cached_property
    def _pose(self) -> tuple[Any, Any]:
        s = self.symbols
        world = algorithms.world_poses(s.tree, algorithms.joint_poses(s.tree, s.q))
        return algorithms.frame_pose(s.tree, world, self.frame)

    @cached_property
    def position(self) -> list[Trig]:
        """x, y (z) of the frame's origin (2.12, 2.13)."""
        return [self.symbols.element(x) for x in self._pose[1]]

    @cached_property
    def rotation(self) -> Entries:
        """Axes of the frame, as columns."""
        return [[self.symbols.element(x) for x in row] for row in self._pose[0]]

    @cached_property
    def J(self) -> Entries:
        """Jacobian, rows linear then angular (plane: ẋ, ẏ, ω); the notes' J (2.19) is its first
        rows."""
        s = self.symbols
        rows = algorithms.jacobian(s.tree, s.q, self.frame)
        return [s.of_angles([s.element(x) for x in row]) for row in rows]

    @cached_property
    def J_dot(self) -> Entries:
        """Time derivative of J, by its entries' (2.24)."""
        return [[x.along(self.symbols.rates) for x in row] for row in self.J]

    @cached_property
    def velocity(self) -> list[Trig]:
        """J q̇ (2.18)."""
        return [inner(row, self.symbols.own(RATE), self.symbols) for row in self.J]

    @cached_property
    def acceleration(self) -> list[Trig]:
        """J q̈ + J̇ q̇ (2.24)."""
        s, rows = self.symbols, zip(self.J, self.J_dot, strict=True)
        qd, qdd = s.own(RATE), s.own(SECOND)
        return [inner(row, qdd, s) + inner(change, qd, s) for row, change in rows]

    def determinant(self, rows: Sequence[int] | None = None) -> Trig:
        """det of chosen rows of J (default all) and of the columns that move the frame (2.20).

        Raises FreebodyError if they make no square.
        """
        chosen = range(len(self.J)) if rows is None else rows
        columns = columns_of(self.symbols, self.frame)
        if len(chosen) != len(columns):
            raise FreebodyError(
                f"determinant: {len(chosen)} rows of the Jacobian of frame {self.frame!r} and "
                f"{len(columns)} joint coordinates make no square; choose {len(columns)} rows."
            )
        return determinant([[self.J[r][k] for k in columns] for r in chosen], self.symbols)


def kinematics(model: Model, frame: str | None = None, numbers: bool = False) -> Kinematics:
    """The closed forms of a frame (default: the tip); `numbers` puts in the values of the model's
    parameters."""
    model.require_tree("kinematics")
    if numbers:
        model.require_values("kinematics in numbers")
    return Kinematics(symbols(model, numbers), model.frame(frame).name)
