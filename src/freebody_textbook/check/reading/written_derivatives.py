"""Derivatives in answers: ∂L/∂θ̇1, ∂v_c2/∂q̇, d/dt, Derivative(theta1(t), t)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from freebody.expressions.grammar.lexer import Token
from freebody.expressions.grammar.parser import Parser
from freebody.expressions.grammar.tables.characters import TOTAL
from freebody.expressions.nodes import Expression, Matrix, Span
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.quotients import (
    Named,
    Value,
    generator,
    inverted,
    slope,
    times,
)
from freebody_textbook.check.algebra.tables_in_formulas import worked_out
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.reading.claim import uses
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerError

_HIGHEST = 2
"""The order up to which derivatives are read."""


class DerivativeParser(Parser):
    """Parses expressions that contain derivatives."""

    vocabulary: Vocabulary
    reader: PolynomialReader
    quantities: Mapping[str, AskedQuantity]
    tables: Callable[[str, Span], Matrix | None]
    others: dict[Expression, Matrix]
    """The vectors and matrices that names of scalars also stand for."""

    def differentiated(self, first: Token) -> Expression:
        """The derivative whose ∂ (or d, for a derivative by a coordinate) has just been read."""
        of = None if self.is_operator("/") else self._operand()
        if not self.is_operator("/"):
            self.fail_here("the bar of a derivative, as in ∂L/∂θ̇1,")
        self.take()
        self.expect("partial", "∂")
        by = self.expect("name", "what is differentiated by")
        of = self._operand() if of is None else of
        span = self.since(first.start)
        self.vocabulary.uses[self.source[span]] = tuple(
            use.target for use in uses(of, self.quantities, self.vocabulary)
        )
        of = worked_out(of, self.others)
        names = self._variables(by)
        if not isinstance(of, Matrix) and len(names) == 1:
            total = first.text == TOTAL and names[0] in self.vocabulary.setting.symbols.rates
            differentiated = self._along_motion if total else self._slope
            return differentiated(of, names[0], span)
        slopes = self._slopes(of, names, span)
        return (
            slopes
            if isinstance(of, Matrix)
            else Matrix(tuple(zip(*slopes.rows, strict=True)), span=span)
        )

    def _slopes(self, of: Expression, names: Sequence[str], span: Span) -> Matrix:
        """The derivatives of a vector or scalar expression by several names, one row per entry."""
        rows = [x for row in of.rows for x in row] if isinstance(of, Matrix) else [of]
        if isinstance(of, Matrix) and 1 not in (len(of.rows), len(of.rows[0])):
            self.source.fail("a vector or one expression is differentiated", of.span)
        table = (tuple(self._slope(x, name, span) for name in names) for x in rows)
        return Matrix(tuple(table), span=span)

    def _slope(self, of: Expression, by: str, span: Span) -> Expression:
        """The derivative of a scalar expression by one name."""
        found = self._changed(self.reader.quotient(of), by, span)
        return Named(self.source[span], found, is_derivative=True, span=span)

    def _changed(self, x: Value, by: str, span: Span) -> Value:
        """The derivative of a value by a variable; t is the time."""
        if by == "t":
            try:
                return self.vocabulary.setting.rate(x)
            except AnswerError as problem:
                self.source.fail(problem.bare, span)
        return slope(x, lambda p: p.derivative(by))

    def _along_motion(self, of: Expression, by: str, span: Span) -> Expression:
        """The derivative by a coordinate with the others moving as the loops demand, as for an
        inertia J(θ1): the ratio of the rates."""
        setting = self.vocabulary.setting
        if setting.system is None:
            return self._slope(of, by, span)
        if len(setting.symbols.coordinates) - len(setting.system.loops.names) != 1:
            self.source.fail("several coordinates move freely: write ∂ or the rates", span)
        rates = setting.symbols.rates
        change = slope(self.reader.quotient(of), lambda p: p.along(rates))
        found = times(change, inverted(rates[by]))
        return Named(self.source[span], found, is_derivative=True, span=span)

    def _operand(self) -> Expression:
        """The expression to be differentiated: a bracket, another derivative or a name."""
        if self.token.kind not in ("open", "partial", "name"):
            self.fail_here("what is differentiated")
        return self.primary()

    def _variables(self, token: Token) -> list[str]:
        """The coordinates, rates or parameters of a name, several for a vector; t for the time."""
        value = self.vocabulary.symbols.get(token.text)
        if token.text == "t":
            return ["t"]
        table = self.tables(token.text, token.span) if value is None else None
        values = [value]
        if table is not None and len(table.rows[0]) == 1:
            values = [x.value for row in table.rows for x in row if isinstance(x, Named)]
        names = [name for x in values if x is not None and (name := generator(x))]
        if not names or len(names) < len(values):
            self.source.fail(
                f"{self.source[token.span]} is not a coordinate to differentiate by", token.span
            )
        return names

    def derivative(self, token: Token) -> Expression:
        """The value of Derivative(theta1(t), t), Derivative(theta1(t), (t, 2)) or diff(L,
        dtheta1)."""
        self.expect("open", "'('")
        start = self.token.start
        value = self.reader.quotient(self.expression())
        order, by_time = 0, True
        while self.token.kind == "comma":
            self.take()
            by, times = self._differentiated_by()
            by_time = by_time and by == "t"
            order += times
            for _ in range(times if order <= _HIGHEST else 0):
                value = self._changed(value, by, self.since(start))
        span = (token.start, self.expect("close", "')'").end)
        if not 1 <= order <= _HIGHEST:
            self.source.fail("a derivative must be the first or second one", span)
        own = by_time and generator(value) is not None
        return Named(self.source[span], value, is_derivative=not own, span=span)

    def jacobian(self, token: Token) -> Expression:
        """The matrix written as jacobian([x; y], [q1; q2])."""
        self.expect("open", "'('")
        of = self._vector(self.expression())
        self.expect("comma", "the comma of jacobian(what, by what)")
        by = self._vector(self.expression())
        span = (token.start, self.expect("close", "')'").end)
        entries = [x for row in by.rows for x in row] if isinstance(by, Matrix) else [by]
        names = [generator(self.reader.read(x)) or "" for x in entries]
        if not all(names):
            self.source.fail("this is no vector of coordinates to differentiate by", by.span)
        return self._slopes(of, names, span)

    def _vector(self, node: Expression) -> Expression:
        """A node's vector or matrix, if it may be one; otherwise the node."""
        return self.others.get(node) or worked_out(node, self.others)

    def _differentiated_by(self) -> tuple[str, int]:
        """The variable of a derivative (t for the time) and its order: t, (t, 2), t, 2 or another
        expression."""
        pair = self.token.kind == "open" and self.ahead(2).kind == "comma"
        if pair:
            self.take()
        first = self.token
        if first.text == "t":
            self.take()
            by = "t"
        else:
            by = generator(self.reader.read(self.expression())) or ""
        if not by:
            self.source.fail(
                "only derivatives by the time t, a coordinate, a rate or a parameter are read",
                first.span,
            )
        times = 1
        if pair or (self.token.kind == "comma" and self.ahead(1).kind == "number"):
            self.expect("comma", "','")
            times = int(self.expect("number", "the order").value)
        if pair:
            self.expect("close", "')'")
        return by, times
