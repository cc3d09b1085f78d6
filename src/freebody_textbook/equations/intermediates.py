"""Equations in named intermediate results: the Newton-Euler recursion with each component of ω, ω̇,
v̇, v̇_c, F, N, f and n on a line.

The recursion is traced once over a graph of interned nodes; then what its record holds is given
names, in the order of the notes (4.6-4.15, 6.16-6.29), and each line refers to what was named
before. Vectors are in body axes, v̇_0 = -g.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from freebody.algorithms.rnea import Recursion, rnea
from freebody.elementary import Scalar, cos, sin
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.naming import motors
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.expressions.printed_names import sym
from freebody.model.parameter_formulas import ParameterFormula
from freebody.model.parameters import Parameter, Quantity
from freebody.model.quantity_reader import QuantityReader, exact_sin_cos
from freebody.model.tree import lower
from freebody.scalars.expr import Expr, Graph
from freebody.scalars.rational import exactly


class GraphReader(QuantityReader):
    """Reads a model's parameters as inputs of an expression graph."""

    combines = False

    def __init__(self, graph: Graph, numbers: bool, own: Mapping[str, ParameterFormula]):
        """Read parameters as inputs of `graph`; own: the model's formulas for parameters."""
        self.graph, self.own = graph, own
        self.numbers = numbers
        self.inputs: dict[str, Expr] = {}

    def input(self, name: str) -> Expr:
        """The graph's node for the input with a name."""
        if name not in self.inputs:
            self.inputs[name] = self.graph.input(name)
        return self.inputs[name]

    def quantity(self, q: Quantity) -> Scalar:
        if not isinstance(q, Parameter) or self.numbers:
            return super().quantity(q)
        formula = self.own.get(q.name)
        return formula.value(self.quantity) if formula else self.input(q.name)

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        if isinstance(angle, Parameter) and not self.numbers:
            return sin(self.input(angle.name)), cos(self.input(angle.name))
        return exact_sin_cos(super().quantity(angle))


def intermediates(symbols: Symbols) -> list[Equation]:
    """Inverse dynamics line by line, each using earlier lines."""
    graph = Graph()
    reader = GraphReader(graph, symbols.reader.numbers, symbols.reader.own)
    q, qd, qdd = (
        tuple(reader.input(x + e) for x in symbols.coordinates) for e in ("", RATE, SECOND)
    )
    tree = lower(symbols.model, reader)
    lines = _Lines(graph, set(symbols.ring.names))
    record = rnea(tree, q, qd, qdd)
    parents = [body.parent + 1 for body in tree.bodies]
    _outward(lines, record, tree.space.axes)
    _inward(lines, record, parents, tree.space.axes)
    for motor, torque in zip(motors(symbols.model), record.tau, strict=True):
        lines.equations.append(ex.eq(motor, lines.expression(torque)))
    return lines.equations


def _outward(lines: _Lines, record: Recursion, axes: str) -> None:
    motion = record.motion
    for i, (R, _) in enumerate(motion.joints):
        n = str(i + 1)
        for row, a in zip(R, axes, strict=False):
            for entry_, b in zip(row, axes, strict=False):
                lines.name_sum("R", (n, a + b), entry_)
        lines.name("omega", (n,), axes, motion.w[i])
        lines.name("omega", (n,), axes, motion.wd[i], 1)
        lines.name("v", (n,), axes, motion.vd[i], 1)
        for k, vector in enumerate(record.vd_com[i]):
            part = (f"c{n}",) if len(record.vd_com[i]) == 1 else (f"c{n}", str(k + 1))
            lines.name("v", part, axes, vector, 1)
            lines.name("F", (n, *part[1:]), axes, record.F[i][k])
            lines.name("N", (n, *part[1:]), axes, record.N[i][k])


def _inward(lines: _Lines, record: Recursion, parents: list[int], axes: str) -> None:
    for i in reversed(range(len(record.f))):
        lines.name("f", (str(parents[i]), str(i + 1)), axes, record.f[i])
        lines.name("n" if len(axes) == 3 else "M", (str(i + 1),), axes, record.n[i])


@dataclass
class _Lines:
    """The equations so far, and the names of graph nodes that have one."""

    graph: Graph
    taken: set[str]
    equations: list[Equation] = field(default_factory=list)
    named: dict[int, Expression] = field(default_factory=dict)

    def name(
        self,
        letter: str,
        low: tuple[str, ...],
        axes: str,
        vector: tuple[Scalar, ...],
        dots: int = 0,
    ) -> None:
        """Name the components of a vector and write their equations; a planar angular vector has no
        axis letter."""
        for axis, x in zip(axes if len(vector) > 1 else ("",), vector, strict=True):
            self._define(letter, low, axis, x, dots)

    def name_sum(self, letter: str, low: tuple[str, ...], x: Scalar) -> None:
        """Name a matrix entry and write its equation, if the entry is a sum."""
        if isinstance(x, Expr) and self.graph.op[self._positive(x.index)] in ("add", "sub"):
            self._define(letter, low, "", x, 0)

    def _define(self, letter: str, low: tuple[str, ...], axis: str, x: Scalar, dots: int) -> None:
        if not isinstance(x, Expr):
            return
        index = self._positive(x.index)
        if index in self.named or self.graph.op[index] in ("const", "input"):
            return
        shown = sym(letter)
        assert isinstance(shown, Symbol)
        name = "_".join((letter, *low)) + axis + "_d" * bool(dots)
        while name in self.taken:
            name += "_"
        self.taken.add(name)
        low = (*low[:-1], low[-1] + axis) if len(low) == 1 else (*low, *([axis] if axis else []))
        symbol = Symbol(name, shown.letter, low, dots)
        self.equations.append(ex.eq(symbol, self.expression(x)))
        # a node that is the negative of a positive one is known by the latter
        self.named[index] = symbol if index == x.index else ex.neg(symbol)

    def _positive(self, index: int) -> int:
        return self.graph.a[index] if self.graph.op[index] == "neg" else index

    def expression(self, x: Scalar) -> Expression:
        """A scalar as an expression in the names given so far."""
        return self._node(x.index) if isinstance(x, Expr) else _number(x)

    def _node(self, i: int) -> Expression:
        graph = self.graph
        if i in self.named:
            return self.named[i]
        op, a, b = graph.op[i], graph.a[i], graph.b[i]
        if op == "const":
            return _number(graph.constant_of[i])
        if op == "input":
            return sym(graph.input_names[a])
        return _OPERATIONS[op](*(self._node(k) for k in (a, b)[: 2 if b >= 0 else 1]))


def _number(x: float) -> Expression:
    value = exactly(x)
    return ex.num(value, decimal=value.denominator != 1 and value != Fraction(1, 2))


def _terms(x: Expression) -> tuple[Expression, ...]:
    return x.terms if isinstance(x, ex.Sum) else (x,)


def _sum(*parts: Expression) -> Expression:
    """A sum ordered as: single terms, products, subtracted terms."""
    terms = [term for part in parts for term in _terms(part)]
    return ex.add(
        *sorted(terms, key=lambda t: (isinstance(t, ex.Negative), not isinstance(t, ex.Symbol)))
    )


def _negative(x: Expression) -> Expression:
    return _sum(*map(ex.neg, _terms(x)))


def _product(a: Expression, b: Expression) -> Expression:
    """A product ordered as numbers, parameters, named quantities, brackets, functions; x x is
    written x², and the sign of -x - y is moved to the front."""
    powers: dict[Expression, int] = {}
    numbers: list[Expression] = []
    for factor in _factors(ex.mul(a, b)):
        if isinstance(factor, ex.Sum) and isinstance(factor.terms[0], ex.Negative):
            numbers.append(ex.num(-1))
            factor = _negative(factor)
        base, exponent = (
            (factor.base, factor.exponent) if isinstance(factor, ex.Power) else (factor, 1)
        )
        if isinstance(factor, ex.Number) or factor == ex.num(-1):
            numbers.append(factor)
        else:
            powers[base] = powers.get(base, 0) + exponent
    return ex.mul(*numbers, *(ex.power(base, powers[base]) for base in sorted(powers, key=_rank)))


def _factors(x: Expression) -> tuple[Expression, ...]:
    if isinstance(x, ex.Negative):
        return (ex.num(-1), *_factors(x.operand))
    return x.factors if isinstance(x, ex.Product) else (x,)


def _rank(factor: Expression) -> tuple:
    """Sort key of factors: numbers, parameters, rates and earlier names, brackets, functions."""
    kinds: list[Any] = [ex.Number, ex.Symbol, ex.Sum, ex.Function]
    kind = next((k for k, kind in enumerate(kinds) if isinstance(factor, kind)), len(kinds))
    if not isinstance(factor, ex.Symbol):
        return (kind,)
    return (
        kind,
        factor.letter in "θωvFNfnM" and factor.name not in ("m", "M"),
        factor.dots,
        factor.low,
    )


_OPERATIONS = {
    "neg": _negative,
    "add": _sum,
    "sub": lambda a, b: _sum(a, _negative(b)),
    "mul": _product,
    "div": ex.div,
    "sin": ex.sin,
    "cos": ex.cos,
    "sign": ex.sgn,
}
