"""Kinematics in closed form: a frame's position, velocity, Jacobian and acceleration (2.10-2.24),
and the Jacobian seen from where its determinant is short.

>>> import freebody as fb
>>> from freebody.expressions.closed_form_kinematics import kinematics
>>> arm = kinematics(fb.planar("RR"))
>>> print(arm.form(arm.position[0]))
l1 cos θ1 + l2 cos(θ1 + θ2)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from freebody.algorithms import kinematics as algorithms
from freebody.algorithms.kinematics import Column, Pose, ancestors, joint_poses
from freebody.errors import FreebodyError
from freebody.expressions.polynomials.arithmetic import PolynomialRows, determinant, inner
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols, symbols
from freebody.expressions.polynomials.textbook_form import InTextbookForm
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.scalars.trig import Trig
from freebody.spatial import Matrix, Vector, add, compose, identity, neg, sub, times, transposed


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
    def rotation(self) -> PolynomialRows:
        """The frame's rotation matrix, whose columns are its axes."""
        return [[self.symbols.element(x) for x in row] for row in self._pose[0]]

    @cached_property
    def J(self) -> PolynomialRows:
        """Jacobian, rows linear then angular (plane: ẋ, ẏ, ω); the notes' J (2.19) is its first
        rows."""
        s = self.symbols
        rows = algorithms.jacobian(s.tree, s.q, self.frame)
        return [s.of_angles([s.element(x) for x in row]) for row in rows]

    @cached_property
    def J_dot(self) -> PolynomialRows:
        """Time derivative of the Jacobian J, entry by entry (2.24)."""
        return [[x.along(self.symbols.rates) for x in row] for row in self.J]

    @cached_property
    def velocity(self) -> list[Trig]:
        """Velocity of the tip, J q̇ (2.18)."""
        return [inner(row, self.symbols.own(RATE), self.symbols) for row in self.J]

    @cached_property
    def acceleration(self) -> list[Trig]:
        """Acceleration of the tip, J q̈ + J̇ q̇ (2.24)."""
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
    bare = model.without("struts") if model.struts else model
    return Kinematics(symbols(bare, numbers), model.frame(frame).name)


# ---------------------------------------------------------------- Jacobians from nearby
def jacobian_from(s: Symbols, frame: str, body: int) -> list[list[Trig]]:
    """Linear and angular columns of all joints before `frame`, in the axes and at the origin of a
    body on the way.

    Against the Jacobian of the frame its rows are turned and its linear ones moved to another
    point: the determinant of all rows is the same, and much shorter (Waldron, Wang, Bolin 1985).
    """
    tree = s.tree
    poses = joint_poses(tree, s.q)
    full: list[Vector] = [(0.0,) * tree.space.six for _ in range(tree.nv)]
    for i in ancestors(tree, tree.frames[frame][0]):
        R, p = _seen_from(tree, poses, body, i)
        at = tree.bodies[i].coordinates
        for k, (w, v) in zip(at.v, tree.bodies[i].columns, strict=True):
            full[k] = add(full[k], _moved(tree, (w, v), R, p, at.ratio))
    return [[s.element(x) for x in row] for row in transposed(tuple(full))]


def _seen_from(tree: Tree, poses: list[Pose], body: int, i: int) -> Pose:
    """Pose of body i in the axes of `body`; one carries the other."""
    resting: Pose = (identity(tree.space.dim), tree.space.zero)
    inner, outer = (i, body) if i in ancestors(tree, body) else (body, i)
    pose = resting
    while outer != inner:
        pose = compose(poses[outer], pose)
        outer = tree.bodies[outer].parent
    if inner != i or i == body:
        return pose
    E = transposed(pose[0])
    return E, neg(times(E, pose[1]))


def _moved(tree: Tree, column: Column, R: Matrix, p: Vector, ratio: Any) -> Vector:
    """A motion column given at a body's origin, in the axes R and at the point relative to which
    that origin is at p, times the ratio."""
    space = tree.space
    w, v = space.turn(R, column[0]), times(R, column[1])
    linear = sub(v, space.cross(w, p))
    return tuple(ratio * x for x in linear + w)


def columns_of(s: Symbols, frame: str) -> list[int]:
    """The coordinates on the way to a frame, in order."""
    tree = s.tree
    return sorted(
        {k for i in ancestors(tree, tree.frames[frame][0]) for k in tree.bodies[i].coordinates.v}
    )


def shortest_determinant(s: Symbols, frame: str) -> Trig:
    """det of all rows of a frame's Jacobian, from the body on the way where its entries are
    fewest."""
    columns = columns_of(s, frame)
    choices = [jacobian_from(s, frame, body) for body in ancestors(s.tree, s.tree.frames[frame][0])]
    rows = min(choices, key=lambda J: sum(len(x) for row in J for x in row))
    return determinant([[row[k] for k in columns] for row in rows], s)
