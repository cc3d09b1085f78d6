"""The grammar of answers: meanings of names and functions, with the correct values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType

from freebody.errors import FreebodyError
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.grammar.parser import PI, around, product_of
from freebody.expressions.grammar.source import Source
from freebody.expressions.grammar.tables.characters import PRIME, RECIPROCALS
from freebody.expressions.nodes import (
    Arguments,
    Cross,
    Dot,
    Expression,
    Function,
    Matrix,
    Number,
    Power,
    Product,
    Quotient,
    Span,
    nodes,
)
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import LARGEST_EXPONENT, PolynomialReader
from freebody_textbook.check.algebra.quotients import Named, Value, Wave
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.reading.written_derivatives import DerivativeParser

_TURNING = ("omega", "w", "alpha", "theta", "q")
"""Letters of angular velocities and accelerations, and of rates."""
INVERSE_FUNCTIONS = ("arccos", "arcsin", "arctan", "atan2", "sqrt")
"""The functions by which coordinates are told."""


class AnswerParser(DerivativeParser):
    """Parses one side of an equation. quantity(name): the correct value of τ1, H12, …; quantities:
    the quantities with these names; tables: vectors and matrices."""

    largest_exponent = LARGEST_EXPONENT

    def __init__(
        self,
        source: Source,
        tokens: Sequence[Token],
        vocabulary: Vocabulary,
        quantity: Callable[[str], Value | None],
        quantities: Mapping[str, AskedQuantity] = MappingProxyType({}),
        tables: Callable[[str, Span], Matrix | None] = lambda name, span: None,
    ):
        super().__init__(source, tokens)
        self.tables = tables
        self.others: dict[Expression, Matrix] = {}
        self.vocabulary, self.quantity = vocabulary, quantity
        self.quantities = quantities
        self.reader = PolynomialReader(source, vocabulary.setting.ring)

    def primary(self) -> Expression:
        """Parse a number, name, function, fraction, bracket or derivative, ∂L/∂θ̇1 or d/dt in front
        of a bracket, name or derivative."""
        if self.token.kind != "partial":
            return super().primary()
        first = self.take()
        self._deeper(first)
        node = self.differentiated(first)
        self.depth -= 1
        return node

    def opens_table(self) -> bool:
        """Whether a vector or matrix follows; [m1] is only a bracket."""
        return self.at < len(self.tokens) and opens_table(self.tokens, self.at)

    def transposed(self, node: Expression) -> Expression:
        """The transpose of a vector or matrix; MATLAB's transpose mark on a scalar is an error, as
        it means a derivative elsewhere."""
        if self.token.text == PRIME and not self._may_be_table(node):
            self.source.fail("a prime stands behind what is no vector or matrix", self.token.span)
        return super().transposed(node)

    def quotient(self, above: Expression, below: Expression) -> Expression:
        """The quotient of two expressions; for two numbers, one number."""
        if isinstance(above, Number) and isinstance(below, Number) and below.value:
            return Number(above.value / below.value, span=around(above, below))
        return super().quotient(above, below)

    def name(self) -> Expression:
        """A name as symbol, abbreviation such as c12, or quantity with its correct value; theta1(t)
        is theta1."""
        token = self.take()
        name = token.text
        if self.token.text == "(" and [self.ahead(k).text for k in (1, 2)] == ["t", ")"]:
            self.at += 3
        vocabulary = self.vocabulary
        behind = power_behind(self.tokens[self.at : self.at + 5], -1)
        inverse = self.tables(name + INVERSE, token.span) if behind else None
        if inverse is not None:
            self.at += behind
            return replace(inverse, span=self.since(token.start))
        turn, behind = turn_behind(name, self.tokens[self.at : self.at + 4])
        turned = self.tables(turn, token.span) if name not in vocabulary.symbols else None
        if turned is not None:
            self.at += behind
            return replace(turned, span=self.since(token.start))
        span = self.since(token.start)
        if name in vocabulary.trees:
            return replace(vocabulary.trees[name], span=span)
        table = self.tables(name, span)
        if name in vocabulary.symbols:
            return self._also(Named(name, vocabulary.symbols[name], span=span), table)
        if name in vocabulary.waves:
            return self._also(Wave(*vocabulary.waves[name], span=span), table)
        if name == "pi":
            return Number(PI, span=span)
        if name == "t":
            self.source.fail("the time t does not occur in these equations", token.span)
        value = self.quantity(name)
        if table is not None and self._is_squared_speed(name):
            return table
        if value is not None:
            return self._also(Named(name, value, span=span), table)
        if table is None:
            self.source.fail(f"{self.source[token.span]} has no value here", token.span)
        return table

    def _is_squared_speed(self, name: str) -> bool:
        """Whether an ambiguous name, a velocity term or a velocity, is squared; then it is the
        velocity."""
        asked = self.quantities.get(name)
        squared = power_behind(self.tokens[self.at : self.at + 4], 2)
        return bool(squared) and asked is not None and asked.kind.is_velocity_term

    def _also(self, node: Expression, table: Matrix | None) -> Expression:
        """A node whose name may also mean a vector or matrix, which is recorded."""
        if table is not None:
            self.others[node] = table
        return node

    def multiplied(
        self, factors: list[Expression], sign: Token, factor: Expression
    ) -> list[Expression]:
        """Factors extended by one more; × between vectors, or between an angular velocity and a
        planar vector, is the cross product; between a scalar and a vector it may be either."""
        left = product_of(factors)
        if sign.written == "@" and not (self._may_be_table(left) and self._may_be_table(factor)):
            self.source.fail(
                "'@' has no meaning here: it stands between vectors and matrices", sign.span
            )
        sides = [self._is_table(y) for y in (left, factor)]
        if self._is_dot(sign, left, factor):
            return [Dot(left, factor, span=around(left, factor))]
        if sign.written not in ("×", "\\times") or not any(sides):
            return [*factors, factor]
        turns = isinstance(left, Named) and atom(left.name).letter.startswith(_TURNING)
        may = all(
            yes or self._may_be_table(y) for yes, y in zip(sides, (left, factor), strict=True)
        )
        if not may and not turns:
            self.source.fail(
                "this × may be a product or the cross product", sign.span, "Write * or cross(a, b)."
            )
        return [Cross(left, factor, span=around(left, factor))]

    def following(self, factors: list[Expression], sign: Token) -> Expression:
        """The factor after a sign; after the × of a cross product, everything that it applies
        to."""
        first, left = super().following(factors, sign), product_of(factors)
        if sign.written in ("×", "\\times"):
            turns = self._may_be_table(left)
        else:  # ω · I ω
            tables = [first] if isinstance(first, Matrix) else [self.others.get(first)]
            turns = self._is_vector(left) and any(x and len(x.rows[0]) > 1 for x in tables)
        if not turns:
            return first
        behind = [first]
        while self.token.kind in ("name", "open") and not self._is_vector(behind[-1]):
            behind.append(self.factor())
        return product_of(behind)

    def _is_dot(self, sign: Token, left: Expression, right: Expression) -> bool:
        """Whether a raised dot is a dot product: it stands between a possible vector, such as m1 g,
        and a vector."""
        dotted = sign.written in ("·", "⋅", "∙", "•", "\\cdot")
        factors = left.factors if isinstance(left, Product) else (left,)
        before = any(x in self.others for x in factors) and self._is_table(right)
        may = right in self.others and len(self.others[right].rows[0]) == 1
        return dotted and (before or (self._is_vector(left) and may))

    def _is_table(self, node: Expression) -> bool:
        return any(isinstance(x, Matrix | Cross) for x in nodes(node))

    def _is_vector(self, node: Expression) -> bool:
        """Whether a factor is a vector, and not a matrix in front of one."""
        tables = [x for x in nodes(node) if isinstance(x, Matrix | Cross)]
        return any(isinstance(x, Cross) or len(x.rows[0]) == 1 for x in tables)

    def _may_be_table(self, node: Expression) -> bool:
        return self._is_table(node) or any(x in self.others for x in nodes(node))

    def _function(self, token: Token) -> str:
        return self.vocabulary.functions[token.text]

    def call(self) -> Expression:
        """A function with its argument; cos²(x) is the square of the function."""
        token = self.take()
        function = self._function(token)
        if function == "Derivative":
            return self.derivative(token)
        if function == "jacobian":
            return self.jacobian(token)
        if function == "Matrix":
            self.at -= 1
            return self.table()
        if function == "cross":
            return self._cross(token)
        if function in INVERSE_FUNCTIONS:
            return self._inverse_function(token, function)
        if function == "abs":
            self._must_open(token)
            return Function(function, self.bracket(), span=self.since(token.start))
        exponent = self.exponent() if self.token.kind == "power" or self.is_operator("^") else 1
        if exponent == -1 and function in ("sin", "cos", "tan"):
            return self._inverse_function(token, f"arc{function}")
        if exponent == -1 and function in RECIPROCALS:
            self.source.fail(
                f"the inverse function of {function} is not read: write it by arctan, arccos or "
                "arcsin",
                token.span,
            )
        argument = self._argument(token)
        span = self.since(token.start)
        if function == "sgn":
            node: Expression = Named(self.source[span], self._sign(argument), span=span)
        else:
            node = self._wave(function, argument, span)
        return node if exponent == 1 else Power(node, exponent, span=span)

    def _inverse_function(self, token: Token, function: str) -> Expression:
        """An inverse function or a root: arccos(x), atan2(y, x), √x."""
        bare = ("fraction", "function", *["number", "name"] * (function == "sqrt"))
        if self.token.kind in bare and function != "atan2":  # \arctan\sqrt{x}, √2
            return Function(function, self.primary(), span=self.since(token.start))
        self._must_open(token)
        if function != "atan2":
            return Function(function, self.bracket(), span=self.since(token.start))
        first = self.take()
        y = self.expression()
        self.expect("comma", "the comma of atan2(y, x)")
        x = self.expression()
        self.expect("close", "')'")
        arguments = Arguments((y, x), span=self.since(first.start))
        return Function(function, arguments, span=self.since(token.start))

    def _must_open(self, function: Token) -> None:
        """Raise an error if a function has no bracket."""
        if self.token.kind != "open":
            self.fail_here(f"a bracket after {function.text}")

    def _wave(self, function: str, argument: Expression, span: Span) -> Expression:
        """The sine, cosine, tangent or reciprocal of one for a sum of angles; a function node for
        arguments such as half an angle or arccos x."""
        if function in RECIPROCALS:
            below = self._wave(RECIPROCALS[function], argument, span)
            return Quotient(Number(Fraction(1), span=span), below, span=span)
        if any(isinstance(x, Function) for x in nodes(argument)):
            return Function(function, argument, span=span)
        angle = self.reader.angle(argument)
        if angle is None:
            return Function(function, argument, span=span)
        if function != "tan":
            return Wave(function, *angle, span=span)
        return Quotient(Wave("sin", *angle, span=span), Wave("cos", *angle, span=span), span=span)

    def _argument(self, function: Token) -> Expression:
        """The argument of a function: a bracket, or numbers and one angle, cos 2θ1."""
        if self.token.kind == "open":
            return self.bracket()
        if self.token.kind == "function" and self._function(self.token) in INVERSE_FUNCTIONS:
            return self.primary()  # \sin\arccos x
        factors: list[Expression] = []
        while self.token.kind in ("number", "fraction") or self.is_operator("-", "*"):
            if self.is_operator("-", "*"):
                token = self.take()
                if token.text == "*" and not factors:
                    self.source.fail(f"{function.text} needs an angle after it", token.span)
                if token.text == "-":
                    factors.append(Number(Fraction(-1), span=token.span))
            else:
                factors.append(self.degrees(self.primary()))
        if self.token.kind == "name":
            factors.append(self.name())
        if not factors:
            self.fail_here(f"the angle of {function.text}")
        if len(factors) == 1 and self._is_index(function, factors[0]):
            number = self.source[factors[0].span]
            self.source.fail(
                f"{function.text}{number} may be that of a sum of angles or of a number",
                (function.start, factors[0].span[1]),
                f"Write {function.text[0]}{number} for the first, {function.text}({number}) for "
                "the second.",
            )
        if self.token.kind == "power" or self.is_operator("^"):
            angle = self.source[around(factors[0], factors[-1])]
            self.source.fail(
                f"this power may belong to the angle or to {function.text}: write "
                f"{function.text}^2({angle})",
                self.token.span,
            )
        return product_of(factors)

    def _is_index(self, function: Token, argument: Expression) -> bool:
        """Whether digits after a function's name look like joint numbers."""
        return (
            isinstance(argument, Number)
            and argument.span[0] == function.end
            and not argument.decimal
            and argument.value.denominator == 1
            and self.token.kind not in ("degree", "name")
        )

    def _cross(self, token: Token) -> Expression:
        """The cross product written as cross(a, b)."""
        self.expect("open", "'('")
        left = self.expression()
        self.expect("comma", "','")
        right = self.expression()
        return Cross(left, right, span=(token.start, self.expect("close", "')'").end))

    def _sign(self, argument: Expression) -> Trig:
        try:
            return self.reader.read(argument).sign()
        except FreebodyError:
            self.source.fail("sgn needs a single rate here", argument.span)


def opens_table(tokens: Sequence[Token], at: int = 0) -> bool:
    """Whether a matrix begins at a token, or a bracket with entries, [a, b] or [[a, b], [c, d]]."""
    first, *second = tokens[at : at + 2]
    if first.text != "[":
        return first.kind == "begin"
    depth, rows = 0, 1 + any(x.text == "[" for x in second)
    for token in tokens[at:]:
        depth += token.deepens
        if depth == 0:
            return False
        if depth <= rows and (token.kind in ("comma", "row") or token.text == ";"):
            return True
    return False


def power_behind(tokens: Sequence[Token], power: int) -> int:
    """The number of tokens in a power that follows, ⁻¹, ^-1 or ^{-1}; 0 if another power, or none,
    follows."""
    if tokens and tokens[0].kind == "power":
        return int(tokens[0].value == power)
    texts, figures = [token.text for token in tokens], [*"-" * (power < 0), str(abs(power))]
    for written in (["^", *figures], ["^", "{", *figures, "}"], ["^", "(", *figures, ")"]):
        if texts[: len(written)] == written:
            return len(written)
    return 0


def turn_behind(name: str, tokens: Sequence[Token]) -> tuple[str, int]:
    """The name of the rotation matrix R_1^2 (components of body 1 to those of body 2), from R_1 and
    the ² or ^2 after it, and the number of tokens of that power; ("", 0) for anything else."""
    if atom(name).letter != "R" or not atom(name).is_numbered or not tokens:
        return "", 0
    if tokens[0].kind == "power":
        return f"R{tokens[0].value}{name[1:]}", 1
    braced = [token.text for token in tokens[1:2]] == ["{"]
    end = 2 + 2 * braced
    if tokens[0].text != "^" or len(tokens) < end or tokens[1 + braced].kind != "number":
        return "", 0
    return f"R{tokens[1 + braced].text}{name[1:]}", end
