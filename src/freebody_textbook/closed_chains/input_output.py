"""The velocity relation J_a ẋ + J_b θ̇ = 0 between tip and drives of a parallel robot, in closed
form (2.35-2.40).

The loop equations hold the tip's rates ẋ, the driven rates θ̇ and those of the passive joints. The
latter leave when equations are combined so that their columns cancel, as one multiplies with the
direction of a bar to be rid of its turning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from freebody.algorithms.kinematics import jacobian
from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.arithmetic import PolynomialRows, determinant, times
from freebody.expressions.singularities import Determinant
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.closed_chains.linear import (
    Ratio,
    left_null,
    ratio,
    solved,
    without_common,
)

if TYPE_CHECKING:
    from freebody_textbook.closed_chains.loops import LoopEquations

ROWS = {2: ("vx", "vy", "w"), 3: ("vx", "vy", "vz", "wx", "wy", "wz")}


@dataclass(frozen=True)
class ClosedInputOutput:
    """J_a ẋ + J_b θ̇ = 0, exact polynomials; x the chosen rows of the frame's motion, θ the driven
    coordinates."""

    loops: LoopEquations
    frame: str
    rows: tuple[str, ...]
    driven: tuple[str, ...]
    J_a: PolynomialRows
    J_b: PolynomialRows

    @cached_property
    def J(self) -> list[list[Ratio]]:
        """Jacobian J = -J_a⁻¹ J_b (2.36) of ẋ = J θ̇."""
        above, below = solved(self.J_a, self.J_b, self.loops.symbols)
        return [[ratio(-x, below) for x in row] for row in above]

    @cached_property
    def first(self) -> Determinant:
        """The determinant det J_b; where it vanishes, the tip loses a direction of motion:
        singularity of the first type."""
        return self._determinant(self.J_b)

    @cached_property
    def second(self) -> Determinant:
        """The determinant det J_a; where it vanishes, the tip can move while the drives are locked:
        singularity of the second type."""
        return self._determinant(self.J_a)

    def _determinant(self, rows: PolynomialRows) -> Determinant:
        s = self.loops.symbols
        return Determinant(Kinematics(s, self.frame), determinant(rows, s))

    def evaluate(self, quantity: Any, q: Any) -> Array:
        """Numeric values of J_a or J_b at q (..., n), with the model's parameter values."""
        return self.loops.evaluate(quantity, q)


@dataclass(frozen=True)
class _MotionEquations:
    """Velocity equations a ẋ + b θ̇ + c ṗ = 0; p: coordinates to be eliminated."""

    a: PolynomialRows
    b: PolynomialRows
    c: PolynomialRows


def input_output(
    loops: LoopEquations, frame: str | None, rows: Sequence[str] | None
) -> ClosedInputOutput:
    """The velocity relation between drives and tip in closed form; see
    `LoopEquations.input_output`."""
    model = loops.model
    name = model.frame(frame).name
    chosen = _rows(model.dim, len(loops.driven), rows)
    system = _system(loops, name, [ROWS[model.dim].index(row) for row in chosen])
    J_a, J_b = _eliminated(loops, system)
    driven = tuple(loops.symbols.coordinates[k] for k in loops.driven)
    if not len(J_a) == len(chosen) == len(driven):
        raise FreebodyError(
            f"input_output: {len(driven)} joints of {model.name!r} are driven, {len(chosen)} rows "
            f"of the tip's motion chosen, and {len(J_a)} equations hold between them; these must "
            f"be equal. Choose rows=[...], or other drives with model.replace(actuated=[...])."
        )
    return ClosedInputOutput(loops, name, chosen, driven, J_a, J_b)


def _rows(dim: int, driven: int, rows: Sequence[str] | None) -> tuple[str, ...]:
    if rows is None:
        return ROWS[dim][:driven]
    for row in rows:
        if row not in ROWS[dim]:
            raise UnknownNameError("row", row, "input_output", ROWS[dim])
    return tuple(rows)


def _system(loops: LoopEquations, frame: str, rows: list[int]) -> _MotionEquations:
    """The loop equations for velocities, with equations for the tip's motion unless its components
    are coordinates."""
    s = loops.symbols
    J = jacobian(s.tree, s.q, frame)
    motion = [[s.element(x) for x in J[r]] for r in rows]
    outputs = [k for row in motion if (k := _coordinate(row)) is not None]
    driven = list(loops.driven)
    if len(set(outputs)) == len(motion) and not set(outputs) & set(driven):
        inner = [k for k in range(len(s.coordinates)) if k not in (*outputs, *driven)]
        return _MotionEquations(
            *([[row[k] for k in part] for row in loops.Phi_q] for part in (outputs, driven, inner))
        )
    inner = [k for k in range(len(s.coordinates)) if k not in driven]
    a, q = _with_tip(loops, frame, rows, motion)
    return _MotionEquations(a, *([[row[k] for k in part] for row in q] for part in (driven, inner)))


def _coordinate(row: Sequence[Trig]) -> int | None:
    """The coordinate whose rate equals a row of the Jacobian; None if there is none."""
    used = [k for k, x in enumerate(row) if not x.is_zero]
    return used[0] if len(used) == 1 and row[used[0]] == 1 else None


def _with_tip(
    loops: LoopEquations, frame: str, rows: list[int], motion: PolynomialRows
) -> tuple[PolynomialRows, PolynomialRows]:
    """(columns of ẋ, columns of q̇) of the equations motion q̇ - ẋ = 0 and of the loops; a pin at
    the tip holds its other frame at x."""
    s, dim = loops.symbols, loops.model.dim
    zero, one = s.zero(), s.element(1.0)
    a = [[-one if k == j else zero for k in range(len(rows))] for j in range(len(rows))]
    q = [list(row) for row in motion]
    for loop in loops.tree.loops:
        at_tip = [_same_place(loops, frame, end) for end in loop.frames]
        pinned = loop.closure.point and any(at_tip) and rows[:dim] == list(range(dim))
        for j, k in enumerate(loops.rows(loop)):
            row, x = loops.Phi_q[k], [zero] * len(rows)
            if pinned and j < dim:
                # p_B - p_A = 0 with the tip at A: p_B - x = 0; at B: x - p_A = 0
                row = [u + v if at_tip[0] else u - v for u, v in zip(row, motion[j], strict=True)]
                x[j] = -one if at_tip[0] else one
            a.append(x)
            q.append(row)
    return a, q


def _same_place(loops: LoopEquations, one: str, other: str) -> bool:
    """Whether two frames are on the same body with the same origin."""
    (i, _, p), (k, _, r) = (loops.tree.frames[name] for name in (one, other))
    return i == k and all(
        loops.symbols.element(x) == loops.symbols.element(y) for x, y in zip(p, r, strict=True)
    )


def _eliminated(
    loops: LoopEquations, system: _MotionEquations
) -> tuple[PolynomialRows, PolynomialRows]:
    """The matrices J_a and J_b: the passive coordinates are eliminated, group by group of coupled
    equations."""
    s = loops.symbols
    J_a: PolynomialRows = []
    J_b: PolynomialRows = []
    for rows, columns in _groups(system.c):
        a, b = [system.a[r] for r in rows], [system.b[r] for r in rows]
        if columns:
            weights = left_null([[system.c[r][k] for k in columns] for r in rows], s)
            if weights is None:
                raise FreebodyError(
                    f"input_output: passive joints of {loops.model.name!r} move though tip and "
                    f"drives stand still; drive another joint with model.replace(actuated=[...])."
                )
            combined = zip(times(weights, a, s), times(weights, b, s), strict=True)
            short = [without_common([*x, *y]) for x, y in combined]
            a, b = [row[: len(a[0])] for row in short], [row[len(a[0]) :] for row in short]
        J_a += a
        J_b += b
    return J_a, J_b


def _groups(c: PolynomialRows) -> list[tuple[list[int], list[int]]]:
    """Groups (rows, columns) of coupled equations; a row of zeros is a group by itself."""
    groups: list[tuple[set[int], set[int]]] = []
    for r, row in enumerate(c):
        rows, columns = {r}, {k for k, x in enumerate(row) if not x.is_zero}
        for other in [g for g in groups if g[1] & columns]:
            groups.remove(other)
            rows, columns = rows | other[0], columns | other[1]
        groups.append((rows, columns))
    return sorted((sorted(rows), sorted(columns)) for rows, columns in groups)
