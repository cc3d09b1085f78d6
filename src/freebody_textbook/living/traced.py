"""A robot over the scalars of a program, for derivations whose quantities would be too long as
polynomials: the same names, the recursion body by body in their place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from freebody.elementary import Scalar, cos, sin
from freebody.expressions.polynomials.symbols import Formulas, Symbols
from freebody.model.parameter_formulas import ParameterFormula
from freebody.model.parameters import Parameter, Quantity
from freebody.model.quantity_reader import QuantityReader, exact_sin_cos
from freebody.scalars.expr import Expr
from freebody_textbook.methods.setting import Setting


class Inputs(dict[str, Expr]):
    """Inputs of a program by name, in the place of a ring."""

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return tuple(self)


class TracedReader(QuantityReader):
    """Reads parameters as inputs of the program, by name, or by their formulas of these, and
    numbers as they are."""

    combines = False

    def __init__(
        self,
        inputs: Mapping[str, Expr],
        numbers: bool,
        formulas: Formulas,
        own: Mapping[str, ParameterFormula],
    ):
        """formulas: of a notation; own: of the model."""
        self.inputs, self.numbers, self.formulas, self.own = inputs, numbers, dict(formulas), own

    def quantity(self, q: Quantity) -> Scalar:
        if not isinstance(q, Parameter) or self.numbers:
            return super().quantity(q)
        if q.name not in self.formulas:
            formula = self.own.get(q.name)
            return formula.value(self.quantity) if formula else self.inputs[q.name]
        total: Scalar = 0.0
        for powers, factor in self.formulas[q.name]:
            factors = (self.inputs[name] for name, power in powers for _ in range(power))
            total = total + math.prod(factors, start=float(factor))
        return total

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        read = self.quantity(angle)
        return (sin(read), cos(read)) if isinstance(read, Expr) else exact_sin_cos(read)


@dataclass(frozen=True, eq=False)
class TracedSymbols(Symbols):
    """Symbols whose ring is a program's inputs by name."""

    @classmethod
    def of(cls, given: Symbols, inputs: Mapping[str, Expr]) -> TracedSymbols:
        """Symbols of the same model and names, over the scalars of a program."""
        ring: Any = Inputs(inputs)
        reader: Any = TracedReader(ring, given.reader.numbers, given.formulas, given.reader.own)
        names = given.coordinates, reader, given.extra, given.inertial
        rewritten = given.formulas, given.turned, given.quarters
        return cls(given.model, ring, *names, given.given, given.euler, *rewritten)

    def zero(self) -> Any:
        return self.element(0.0)

    def element(self, x: Scalar) -> Any:
        one: Any = self.own("")[0]
        return x if isinstance(x, Expr) else one.graph.constant(x)


@dataclass(frozen=True)
class _Drives:
    drives: list[Scalar]


class TracedSetting(Setting):
    """A setting over such symbols, which has no closed forms."""

    @property
    def equations(self) -> Any:
        """Friction and springs alone, by coordinate."""
        s = self.symbols
        found: list[Scalar] = [0.0] * self.tree.nv
        for body in self.tree.bodies:
            if body.drive is not None:
                k, ratio = body.coordinates.v[0], body.coordinates.ratio
                found[k] = found[k] + ratio * body.drive.torque(s.q, s.qd)
        return _Drives(found)
