"""Loop equations in closed form: Φ(q) = 0, Φ_q and c as exact polynomials (2.33, 2.34, 5.21, 5.22,
5.28).

The text is that of `algorithms.loop_constraints`. There the equation of a distance d is (|r|² - d²)
/ 2d, whose gradient is a unit vector; here it is the notes' |r|² - d², a polynomial, 2d times as
large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from freebody.algorithms import loop_constraints
from freebody.algorithms.kinematics import Pose, frame_pose, joint_poses, world_poses
from freebody.errors import FreebodyError
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.arithmetic import PolynomialRows
from freebody.expressions.polynomials.symbols import Symbols, symbols
from freebody.expressions.polynomials.textbook_form import InTextbookForm
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.tree import Tree, TreeLoop
from freebody.outputs.display import InWords
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, dot, sub
from freebody.values import ByValue

_HALF = 0.5
"""The distance d for which (|r|² - d²) / 2d and |r|² - d² are one."""


@dataclass(frozen=True, eq=False, repr=False)
class LoopEquations(InWords, InTextbookForm, ByValue):
    """The loop equations of a model as exact polynomials in normal form: equal means identical."""

    symbols: Symbols

    def _title(self) -> str:
        return f"Loop equations of {self.model.name!r}: {', '.join(self.names)}"

    @property
    def model(self) -> Model:
        """Model of the closed chain."""
        return self.symbols.model

    @cached_property
    def tree(self) -> Tree:
        """The model's tree, with distances arranged to give equations in the notes' form."""
        tree = self.symbols.tree
        loops = tuple(
            replace(loop, distance=_HALF) if loop.closure.distance else loop for loop in tree.loops
        )
        return replace(tree, loops=loops)

    @cached_property
    def world(self) -> list[Pose]:
        """Pose of every body in the world."""
        return world_poses(self.tree, joint_poses(self.tree, self.symbols.q))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the equations: the loop, and the component of its reaction."""
        space = self.tree.space
        return tuple(
            f"{loop.name}.{part}"
            for loop in self.tree.loops
            for part in loop.closure.row_names(space)
        )

    def rows(self, loop: TreeLoop) -> range:
        """Indices of a loop's equations among all."""
        sizes = [x.closure.size(self.tree.space) for x in self.tree.loops]
        k = [x.name for x in self.tree.loops].index(loop.name)
        return range(sum(sizes[:k]), sum(sizes[: k + 1]))

    def gap(self, loop: TreeLoop) -> Vector:
        """Vector in world axes from the origin of a loop's first frame to that of the second."""
        a, b = (frame_pose(self.tree, self.world, frame)[1] for frame in loop.frames)
        return tuple(self.symbols.element(x) for x in sub(b, a))

    @cached_property
    def Phi(self) -> list[Trig]:
        """The loop equations Φ(q) (5.21); for a rod |r|² - d² as in (2.33)."""
        values = []
        for own, loop in zip(self.tree.loops, self.symbols.tree.loops, strict=True):
            if loop.closure.distance:
                r = self.gap(own)
                values.append(dot(r, r) - loop.distance * loop.distance)
            else:
                ends = (frame_pose(self.tree, self.world, frame) for frame in own.frames)
                values += [
                    e.value for e in loop_constraints.loop_equations(self.tree.space, own, *ends)
                ]
        return [self.symbols.element(x) for x in values]

    @cached_property
    def Phi_q(self) -> PolynomialRows:
        """Jacobian of the loop equations, ∂Φ/∂q (5.22)."""
        return self._entries(loop_constraints.constraint_jacobian(self.tree, self.symbols.q))

    @cached_property
    def c(self) -> list[Trig]:
        """The right side c = -Φ̇_q q̇ (5.28) of Φ_q q̈ = c."""
        s = self.symbols
        return [s.element(x) for x in loop_constraints.constraint_bias(self.tree, s.q, s.qd)]

    @cached_property
    def scale(self) -> list[Trig]:
        """The factor of each equation relative to the one used by the numeric functions: 2d for a
        rod, otherwise 1."""
        factors: list[Any] = []
        for loop in self.symbols.tree.loops:
            factors += [2 * loop.distance if loop.closure.distance else 1.0] * loop.closure.size(
                self.tree.space
            )
        return [self.symbols.element(x) for x in factors]

    # ------------------------------------------------------------ counting
    @property
    def gruebler(self) -> int:
        """Coordinates less equations: the degrees of freedom, all equations taken as
        independent."""
        return len(self.symbols.coordinates) - len(self.names)

    @cached_property
    def driven(self) -> tuple[int, ...]:
        """Coordinates of the joints that are not passive."""
        named = self.model.actuated
        return tuple(
            k
            for body, at in zip(self.model.bodies, self.model.coordinates, strict=True)
            if body.joint.name in named
            for k in at.v
        )

    # ------------------------------------------------------------ how the tip moves with the drives
    def J_a(self, frame: str | None = None, rows: Sequence[str] | None = None) -> PolynomialRows:
        """J_a of J_a ẋ + J_b θ̇ = 0 (2.35), (2.37); see `input_output`."""
        return self.input_output(frame, rows).J_a

    def J_b(self, frame: str | None = None, rows: Sequence[str] | None = None) -> PolynomialRows:
        """J_b of J_a ẋ + J_b θ̇ = 0 (2.35), (2.38); see `input_output`."""
        return self.input_output(frame, rows).J_b

    def input_output(self, frame: str | None = None, rows: Sequence[str] | None = None) -> Any:
        """The velocity relation between a frame (by default the tip) and the driven joints, in
        closed form.

        rows: of its motion, among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w");
        default the first ones, as many as joints are driven. Returns a `ClosedInputOutput`. Raises
        FreebodyError where the numbers of rows, drives and freedoms do not match.
        """
        from freebody_textbook.closed_chains.input_output import input_output

        return input_output(self, frame, rows)

    # ------------------------------------------------------------ for the reader
    def expressions(self) -> list[Expression]:
        """The loop equations Φ as printed, squared distances as squares of components (2.33)."""
        shown: list[Expression] = []
        for own, loop in zip(self.tree.loops, self.symbols.tree.loops, strict=True):
            if loop.closure.distance:
                squares = [ex.power(self.form(x), 2) for x in self.gap(own)]
                length = self.form(self.symbols.element(loop.distance))
                shown.append(ex.sub(ex.add(*squares), ex.power(length, 2)))
            else:
                shown += [self.form(self.Phi[k]) for k in self.rows(own)]
        return shown

    def __str__(self) -> str:
        return "\n".join(
            f"{name}: {x} = 0" for name, x in zip(self.names, self.expressions(), strict=True)
        )

    def _entries(self, rows: Any) -> PolynomialRows:
        return [[self.symbols.element(x) for x in row] for row in rows]


def loop_equations(model: Model, numbers: bool = False) -> LoopEquations:
    """Φ(q) = 0 of a closed chain, its Jacobian Φ_q, c, and J_a, J_b, as exact polynomials.

    numbers: put in the values of the model's parameters. Raises FreebodyError for a model without
    loops and for joints whose coordinates are quaternions.
    """
    if not model.loops:
        raise FreebodyError(
            f"loop_equations: {model.name!r} has no loops; add one with model.with_loop(...)."
        )
    if numbers:
        model.require_values("loop equations in numbers")
    bare = model.without("struts") if model.struts else model
    return LoopEquations(symbols(bare, numbers))
