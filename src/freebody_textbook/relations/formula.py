"""Formulas with vectors as text, `tau1 - cross(s1, f12) = I1*omega1_d`: parsing, printing and
evaluation.

The grammar is that of answers (`grammar`), with a sign in every product, [a, b] for vectors and
[[a, b], [c, d]] for matrices. It is parsed, never run. Names are those that print as in the notes:
theta1_d is θ̇₁, sc1 is s_c1, R2_1 is R with subscript 1 and superscript 2; omega_i, omega_h, omega_k
are those of link i, i-1 and i+1.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any
from unicodedata import normalize

from freebody.expressions import expression as ex
from freebody.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.grammar.atoms import atom, between, unprimed
from freebody.expressions.grammar.lexemes import Lexeme
from freebody.expressions.grammar.lexer import Token, sides, tokens
from freebody.expressions.grammar.parser import Parser
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.source import Source, UnreadableError
from freebody.expressions.grammar.words import Cut
from freebody.expressions.nodes import NOWHERE
from freebody.expressions.printed_names import GREEK, sym

FUNCTIONS = (
    "sin", "cos", "tan", "sqrt", "exp", "log", "arcsin", "arccos", "arctan", "norm", "det", "sum",
    "diag", "skew",
)  # fmt: skip
"""Functions of one argument; `sum` adds up what is given for each of several bodies."""

_RULES: dict[str, tuple[int, Callable[..., Expression]]] = {
    **{name: (1, lambda x, name=name: ex.Function(name, x)) for name in FUNCTIONS},
    "sum": (1, lambda x: ex.Function("∑", x)),
    "cross": (2, ex.cross),
    "dot": (2, ex.dot),
    "partial": (2, ex.partial),
    "atan2": (2, lambda y, x: ex.Function("atan2", ex.arguments(y, x))),
    "transpose": (1, ex.transposed),
    "d_dt": (1, ex.d_dt),
}
"""The number of arguments of each function, and what it makes of them."""

_NAME = LexemePattern("< %letter | _ > < ~%letter | ~%digit | ~%mark | ~_ >{0,400}")

SPECIAL: dict[str, tuple] = {
    "gravity": ("g",), "qd": ("q", (), 1), "qdd": ("q", (), 2), "qdd_back": ("q", ("back",), 2),
}  # fmt: skip
"""Vectors whose names are words: letter, subscripts, dots."""

GENERAL = {"i": "i", "h": "i−1", "k": "i+1"}
"""Endings of names that stand for a link's number."""


class FormulaError(UnreadableError):
    """Error for a formula that cannot be parsed or evaluated."""


class _FormulaText(Source):
    what, longest, error = "formula", 4000, FormulaError


def parse(text: str, bold: Collection[str] = (), primed: Collection[str] = ()) -> Expression:
    """Parse a formula: an equation if it contains =, otherwise an expression.

    Names in `bold` are vectors, those in `primed` have components in the axes of their own body.
    """
    source = _FormulaText.of(text)
    written = [x for x in tokens(source, _FormulaLanguage())[:-1] if x.text != "\n"]
    read = [
        evaluate(_FormulaParser(source, side, bold, primed).side(), _PRINTED)
        for side in sides(written)
    ]
    return read[0] if len(read) == 1 else Equation(tuple(read))


def symbol(name: str, bold: bool = False, primed: bool = False) -> Any:
    """The symbol of a name, including link letters in place of numbers; omega_prime is ω with a
    prime."""
    if primed or unprimed(name) != name:
        plain = symbol(unprimed(name), bold)
        return replace(plain, name=name, high="′") if isinstance(plain, Symbol) else plain
    if parts := between(name):
        high, low = (GENERAL.get(place, place) for place in parts[1:])
        return Symbol(name, parts[0], (low,), bold=True, high=high)
    own = atom(name)
    places = own.index[0] if len(own.index) == 1 else ""
    if own.letter == "w" and len(places) == 1 and not own.dots:  # ω with components in the world
        return replace(symbol(f"omega_{places}", bold), name=name)
    if not 1 <= len(places) <= 2 or not set(places) <= GENERAL.keys():
        return Symbol(name, *SPECIAL[name], bold=True) if name in SPECIAL else sym(name, bold)
    letters, centre = own.letter, ""
    if letters not in GREEK and len(letters) > 1 and letters[-1] == "c":
        letters, centre = letters[:-1], "c"
    first, *others = (GENERAL[place] for place in places)
    return Symbol(name, GREEK.get(letters, letters), (centre + first, *others), own.dots, bold)


class _FormulaLanguage:
    """The grammar of formulas: names are taken as written."""

    functions = _RULES

    def begins(self, x: Lexeme) -> bool:
        return x.kind == "letter" or x.text == "_"

    def word(self, source: Source, at: int) -> Cut:
        match = _NAME.at(source.lexemes, at)
        assert match is not None
        return Cut([(normalize("NFC", match.text), *match.span)], None, match.stop)


class _FormulaParser(Parser):
    """Parser for one side of a formula."""

    implied_products = False
    largest_exponent = 9999

    def __init__(
        self,
        source: Source,
        tokens: Sequence[Token],
        bold: Collection[str],
        primed: Collection[str],
    ):
        super().__init__(source, tokens)
        self.bold, self.primed = bold, primed

    def name(self) -> Expression:
        token = self.take()
        if self.token.text == "(":
            known = ", ".join(sorted(_RULES))
            self.source.fail(f"no function {token.text!r}; there are {known}", token.span)
        return symbol(token.text, token.text in self.bold, token.text in self.primed)

    def call(self) -> Expression:
        token = self.take()
        self.expect("open", "'('")
        arguments = [self.expression()]
        while self.token.kind == "comma":
            self.take()
            arguments.append(self.expression())
        self.expect("close", "')'")
        count, made = _RULES[token.text]
        if len(arguments) != count:
            self.source.fail(f"{token.text} is given {len(arguments)} arguments", token.span)
        return made(*arguments)

    def table(self) -> ex.Vector | ex.Matrix:
        """The vector [a, b] or matrix [[a, b], [c, d]]."""
        matrix = super().table()
        return ex.Vector(matrix.rows[0]) if len(matrix.rows) == 1 else matrix


def _inside(node: Expression, at: Callable[[Expression], Expression]) -> Expression:
    return replace(node.mapped(at), span=NOWHERE)


_PRINTED: Rules = {
    **arithmetic(
        ex.num,
        total=lambda terms: ex.add(*terms),
        product=lambda factors: ex.mul(*factors),
        negative=ex.neg,
        quotient=ex.div,
        power=ex.power,
    ),
    ex.Number: lambda node, at: ex.num(node.value, node.decimal),
    **dict.fromkeys(
        (ex.Symbol, ex.Function, ex.Arguments, ex.Vector, ex.Matrix, ex.Cross, ex.Dot,
         ex.Transposed, ex.Derivative),
        _inside,
    ),
}  # fmt: skip
"""Rules for a formula as it is printed: flat sums and products, a sign in front, a number first."""


def as_printed(text: str, bold: Collection[str] = (), primed: Collection[str] = ()) -> Expression:
    """A formula as expression, or the text in upright words if it is no formula."""
    try:
        return parse(text, bold, primed)
    except FormulaError:
        return ex.words(text)


def names_in(node: Expression) -> list[str]:
    """Names of symbols in a formula, each once."""
    return list(dict.fromkeys(part.name for part in ex.nodes(node) if isinstance(part, Symbol)))
