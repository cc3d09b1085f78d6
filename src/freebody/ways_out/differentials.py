"""Derivatives of programs to any order, for libraries with automatic differentiation, and which
program computes which derivative.

They are the ordinary partial derivatives by every entry of an input, of positions by all nq
coordinates; the four of a quaternion included, of which kernels use the direction alone. (`by=` of
fb.kernel is on the tangent space instead.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from freebody.algorithms.kinematics import position_rates
from freebody.errors import FreebodyError
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.lookup import LARGEST
from freebody.kernels.tracing import program as formula_program
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.program import Program, trace
from freebody.program.derivative import (
    applied,
    applied_back,
    directional,
    jacobian,
    slope_arguments,
)
from freebody.program.program import evaluated
from freebody.spatial import dot, identity, transposed
from freebody.ways_out.kernel import QuantityRequest

LONGEST = 20_000
"""Operations up to which a whole Jacobian is one program; it compiles in about two seconds."""


@dataclass(frozen=True)
class Jacobian:
    """The derivatives of each output of a program by some of its inputs.

    If `whole`, `function` has the program's inputs and of each output in turn, by each of the
    inputs, (*output, *input). Else its last inputs are rates of these inputs, and its outputs, of
    the program's shapes, their effect: the Jacobian's columns are what it gives for unit vectors.
    """

    function: Differentiable
    whole: bool


class Differentiable:
    """A program that can be differentiated, to any order, into programs of its derivatives.

    shorter: from positions of inputs to programs that have the outputs of `jacobian` in other,
    maybe shorter ways.
    """

    def __init__(
        self, program: Program, shorter: Callable[[tuple[int, ...]], list[Program]] | None = None
    ):
        self.program = program
        self._shorter = shorter
        self._found: dict[tuple[int, ...], Jacobian] = {}

    def jacobian(self, by: Sequence[int]) -> Jacobian:
        """The derivatives by the inputs with these indices, which are rising and distinct."""
        by = tuple(by)
        if by not in self._found:
            self._found[by] = self._jacobian(by)
        return self._found[by]

    def along(self, by: Sequence[int]) -> Differentiable:
        """The program of the outputs' rates, when the inputs `by` change at rates that are given as
        the last inputs."""
        return Differentiable(directional(self.program, tuple(by)))

    def applied(
        self, by: Sequence[int], of: Sequence[int], count: int, back: bool = False
    ) -> Differentiable | None:
        """The program of Jacobian-vector products for `count` vectors: rates of the outputs `of`
        from rates of the inputs `by`; back: products with the transpose.

        See `program.derivative`. None where the products would be more than half, of the transpose
        two thirds: there few vectors have many entries, and a library's matrices are several times
        slower.
        """
        found, made = self.jacobian(by), applied_back if back else applied
        entries = sum(self.program.inputs[k].size for k in by) * sum(
            self.program.outputs[k].size for k in of
        )
        products, own = 2 * count * entries, length(found.function.program)
        if not found.whole or products > (min(2 * own, max(own, LONGEST - own)) if back else own):
            return None
        return Differentiable(made(found.function.program, self.program, by, of, count))

    def ways(self, by: tuple[int, ...]) -> list[Program]:
        """Programs of the whole Jacobian by the inputs `by`, without those that would be far too
        long."""
        found = self._shorter(by) if self._shorter else []
        directions = sum(self.program.inputs[k].size for k in by)
        if length(self.program) * directions <= 20 * LONGEST:
            found.append(jacobian(self.program, by))
        return found

    def _jacobian(self, by: tuple[int, ...]) -> Jacobian:
        columns = directional(self.program, by)
        best = min(self.ways(by), key=length, default=columns)
        if best is not columns and length(best) <= max(LONGEST, length(columns)):
            return Jacobian(Differentiable(best), True)
        return Jacobian(Differentiable(columns), False)


def length(program: Program) -> int:
    """Number of operations in a program."""
    return sum(program.operations.values())


def of_quantities(request: QuantityRequest) -> Differentiable:
    """The program of some quantities of a model, differentiable; its parameters p are the same for
    all samples."""
    model, names, option, given, by = request
    p, over = request.p(uniform=True), given.tree if given else None
    for name in names:
        if FORMULAS[name].by_columns and model.nv > LARGEST:
            raise FreebodyError(
                f"{name} of {model.nv} coordinates is too long for one program (up to {LARGEST} "
                f"coordinates it is not). Matrices of so large a robot are derivatives: that of "
                f"inverse_dynamics by qdd is M."
            )
    traced = formula_program(model, names, option, p, over, by)
    formulas = FORMULAS[names[0]].derivatives
    lossy = bool(lossy_joints(model.bodies))  # then ∂tau/∂q̈ is not M
    if not formulas or lossy or len(names) > 1 or by or model.loops or option.wrench_frames:
        return Differentiable(traced)

    @cache
    def tangent(formula: str) -> Program:
        return formula_program(model, (formula,), Option(), p, over)

    def shorter(by: tuple[int, ...]) -> list[Program]:
        labels = [traced.inputs[k].name for k in by]
        return [
            _chosen(model, traced, by, tangent(formula), known)
            for formula, known in formulas.items()
            if set(labels) <= set(known) and model.nv <= LARGEST
        ]

    return Differentiable(traced, shorter)


def _chosen(
    model: Model, program: Program, by: tuple[int, ...], tangent: Program, known: Sequence[str]
) -> Program:
    """The program of some derivatives, with the inputs of the original program instead of those of
    `tangent`.

    known: the inputs by which the outputs of `tangent` are.
    """
    labels = [argument.name for argument in program.inputs]

    def evaluate(*given: Any) -> tuple[Any, ...]:
        values = dict(zip(labels, given, strict=True))
        outputs = evaluated(tangent, [values[argument.name] for argument in tangent.inputs])
        tables = dict(zip(known, outputs, strict=True))
        if model.nq > model.nv and "q" in tables:
            tables["q"] = by_coordinates(model.tree, values["q"], tables["q"])
        return tuple(tables[labels[k]] for k in by)

    return trace(f"{program.name}_jacobian", evaluate, program.inputs, slope_arguments(program, by))


def by_coordinates(tree: Tree, q: Any, slopes: Any) -> Any:
    """Rows of derivatives by the nq coordinates, computed from derivatives along the nv directions
    of the tangent space.

    Of what depends on quaternions by their direction alone. The rates q̇ = Q v have columns that
    are orthogonal to each other and to the quaternions, so v = (QᵀQ)⁻¹ Qᵀ q̇ with a diagonal matrix
    in the middle.
    """
    along = [position_rates(tree, q, unit) for unit in identity(tree.nv)]
    inverse = [tuple(x / dot(rates, rates) for x in rates) for rates in along]
    columns = transposed(tuple(inverse))
    return tuple(tuple(dot(row, column) for column in columns) for row in slopes)
