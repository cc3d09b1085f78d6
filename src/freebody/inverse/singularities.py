"""`singularities`: where a frame loses a direction; in closed form where the Jacobian is square,
measured always."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.kinematics import ancestors
from freebody.algorithms.screws import arm_length
from freebody.algorithms.singular_thresholds import FOUND
from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.expressions.closed_form_kinematics import Kinematics, columns_of, kinematics
from freebody.expressions.exact_singularities import Condition, Determinant, jacobian_determinant
from freebody.expressions.expression import Expression
from freebody.inverse.problem.task import row_names, rows_of
from freebody.model.model import Model
from freebody.model.shafts import shaft_entries, untwisted
from freebody.outputs.display import Titled
from freebody.trees.kinematics import jacobian, jacobian_derivatives
from freebody.trees.positions import generic_state, integrate
from freebody.trees.public_calls import JointVector, finite_vector

SHORT = 20_000
"""Terms of the Jacobian's entries, all together, above which its determinant is not written out."""


@dataclass(frozen=True, eq=False, repr=False)
class Singularities(Titled):
    """The poses at which the counted rows of a frame's Jacobian lose rank.

    rows: their names. notes: which rows and why, and what could not be done in closed form.
    """

    model: Model
    frame: str
    rows: tuple[str, ...]
    closed: Determinant | None
    notes: tuple[str, ...]

    def _title(self) -> str:
        return f"Singularities of {self.frame!r} of {self.model.name!r}: {self._where()}"

    def _where(self) -> str:
        if self.closed is None:
            return "no closed form"
        everywhere = "everywhere" if self.closed.polynomial.is_zero else "nowhere"
        return "; ".join(map(str, self.conditions)) or everywhere

    @property
    def determinant(self) -> Expression | None:
        """det J as a product of factors; None without a closed form."""
        return None if self.closed is None else self.closed.expression

    @property
    def factors(self) -> tuple[tuple[Expression, int], ...]:
        """The factors of the determinant with their exponents."""
        if self.closed is None:
            return ()
        return tuple((self.closed.kinematics.form(f), e) for f, e in self.closed.factors)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The conditions, one for each factor that depends on the joints; the arm is singular where
        any of them holds."""
        return () if self.closed is None else self.closed.conditions

    def latex(self) -> str:
        """det J = … = 0 and its solutions as an amsmath environment."""
        if self.determinant is None:
            return r"\text{no closed form}"
        lines = [f"\\det J = {self.determinant.latex()}", *(c.latex() for c in self.conditions)]
        return "\\begin{gathered} " + r" \\ ".join(lines) + " \\end{gathered}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __str__(self) -> str:
        lines = []
        if self.closed is not None:
            lines.append(f"det J = {self.determinant}")
            lines.append(f"singular {'where ' if self.conditions else ''}{self._where()}")
        return "\n".join([*lines, *self.notes])

    # ------------------------------------------------------------ numbers
    def measure(self, q: JointVector) -> Array:
        """Smallest singular value (...) of the counted rows of J at q (..., nq), lengths over the
        arm's length.

        0 where the arm is singular; how far from it, in rad per rad.
        """
        return np.linalg.svd(self._scaled(q), compute_uv=False)[..., -1].astype(float, copy=False)

    def _scaled(self, q: JointVector) -> Array:
        names = row_names(self.model.dim)
        rows = [names.index(row) for row in self.rows]
        at = finite_vector("singularities", self.model, "q", q)
        J = jacobian(self.model, at, self.frame)
        return self._scale(rows)[:, None] * J[..., rows, :][..., _moving(self.model, self.frame)]

    def _scale(self, rows: list[int]) -> Array:
        length = arm_length(self.model.tree, self.frame)
        return np.array([1.0 / length if r < self.model.dim else 1.0 for r in rows])

    def search(self, starts: int = 32, seed: int = 0) -> Array:
        """Singular positions (k, nq), one for each random start that led to one: Newton steps on
        the measure.

        Nothing is said about singularities that were not found. Positions are not kept within the
        joints' limits.
        """
        model = self.model
        rigid = untwisted(model)
        q, _, _ = generic_state(model, seed, starts)
        if rigid is not None:
            q = rigid.at(rigid.links(q))
        names = row_names(model.dim)
        rows = [names.index(row) for row in self.rows]
        columns = _moving(model, self.frame)
        for _ in range(40):
            U, sigma, Vt = np.linalg.svd(self._scaled(q), full_matrices=False)
            slopes = (
                self._scale(rows)[:, None, None]
                * jacobian_derivatives(model, q, self.frame)[..., rows, :, :]
            )
            slope = np.einsum("ni,nijk,nj->nk", U[:, :, -1], slopes[:, :, columns], Vt[:, -1])
            slope[:, shaft_entries(model)] = 0.0
            square = np.sum(slope**2, axis=-1)
            gain = np.where(square > 1e-20, sigma[:, -1] / np.where(square > 0, square, 1.0), 0.0)
            step = -gain[:, None] * slope
            size = np.linalg.norm(step, axis=-1, keepdims=True)
            q = integrate(model, q, step / np.maximum(1.0, size))
        return q[self.measure(q) < FOUND]


def singularities(
    model: Model, frame: str | None = None, task: str | Sequence[str] | None = None
) -> Singularities:
    """Positions at which a frame cannot move in some direction: det J = 0 (2.20-2.23), factored
    and solved where that is short.

    frame: default the tip. task: the rows that count, "position", "orientation", "pose" or names
    among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w"); default those that make J
    square: for a planar arm of two joints the position, for one of three the pose, in space for six
    the pose, for three the position. Parameters stay symbols; for `measure` and `search` they need
    values.

    Shafts of flexible joints do not twist: the positions in conditions are the links'. With another
    number of joints than rows there is no determinant, only the measure and the search. Raises
    FreebodyError where fewer joints than rows are asked for by name.
    """
    model.require_tree("singularities", "fb.input_output(model, q).kind")
    name = model.frame(frame).name
    rigid = untwisted(model)
    closed = _symbolic(model if rigid is None else rigid.model, name)
    if isinstance(closed, str):
        rows = rows_of("singularities", model, task or "pose")
        return Singularities(model, name, _names(model, rows), None, (closed,))
    n = len(columns_of(closed.symbols, name))
    rows = _chosen_rows(closed, n) if task is None else rows_of("singularities", model, task)
    if task is not None and n < len(rows):
        raise FreebodyError(
            f"singularities: {n} joint coordinates of {model.name!r} cannot move frame {name!r} "
            f"along {len(rows)} rows "
            f"({', '.join(_names(model, rows))}) at any pose; count {n} at most with task=."
        )
    notes = [f"Rows counted: {', '.join(_names(model, rows))}."]
    if n != len(rows):
        square = (
            f"{n} joint{'s' * (n != 1)} and {len(rows)} rows: J is not square, "
            "so there is no determinant"
        )
        notes.append(f"{square}; search() finds singular poses.")
    elif _length(closed) > SHORT:
        notes.append(
            "The determinant is too long to be written out; search() finds singular poses."
        )
    else:
        found = jacobian_determinant(closed, rows)
        return Singularities(model, name, _names(model, rows), found, tuple(notes))
    return Singularities(model, name, _names(model, rows), None, tuple(notes))


def _symbolic(model: Model, frame: str) -> Kinematics | str:
    """The closed forms of a frame's kinematics, or a sentence on why there are none."""
    try:
        return kinematics(model, frame)
    except FreebodyError as refusal:
        return f"No closed form: {refusal} search() finds singular poses."


def _names(model: Model, rows: Sequence[int]) -> tuple[str, ...]:
    return tuple(row_names(model.dim)[r] for r in rows)


def _moving(model: Model, frame: str) -> list[int]:
    """The coordinates, as columns of the Jacobian, of the joints between base and frame."""
    tree = model.tree
    path = ancestors(tree, tree.frames[frame][0])
    twists = shaft_entries(model)
    return sorted({k for i in path for k in tree.bodies[i].coordinates.v if k not in twists})


def _length(arm: Kinematics) -> int:
    return sum(len(x) for row in arm.J for x in row)


def _chosen_rows(arm: Kinematics, n: int) -> tuple[int, ...]:
    """The rows that make the Jacobian square; where no choice does, all rows that some joint
    moves."""
    model = arm.symbols.model
    dim, six = model.dim, len(arm.J)
    if n >= six:
        return tuple(range(six))
    alive = tuple(i for i, row in enumerate(arm.J) if any(not x.is_zero for x in row))
    if n == dim:
        place = tuple(range(dim))
        if set(place) <= set(alive) and not arm.determinant(place).is_zero:
            return place
        turn = tuple(range(dim, six))
        if len(turn) == n and not arm.determinant(turn).is_zero:
            return turn
        return place
    return alive
