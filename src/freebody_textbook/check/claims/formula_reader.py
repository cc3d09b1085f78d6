"""Sides of equations into trees and values, with the model's quantities by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from freebody.expressions.evaluate import NoValue
from freebody.expressions.grammar.dotted_names import spellings
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.grammar.source import Span
from freebody.expressions.grammar.words import FRAMES, PRIME
from freebody.expressions.nodes import (
    Expression,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    nodes,
)
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.answer_tree import Named, Wave
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.quotients import Value, difference
from freebody_textbook.check.algebra.tables_in_formulas import TableShape, worked_out
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.loads import held, held_by_loops
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.numbers.states import WrittenNumbers
from freebody_textbook.check.reading import loaded_lines
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.circular_answers import uses
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reading.reading import AnswerParser
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerText
from freebody_textbook.check.states.state_values import functions_of

_TABLES = ("Matrix", "jacobian")
"""Functions that make a vector or matrix."""
_OF_ANGLES = (Wave, Number, Sum, Negative, Product, Power, Quotient)
"""What identities of sines and cosines are made of."""


class FormulaReader:
    """Reads sides."""

    def __init__(
        self,
        source: AnswerText,
        vocabulary: Vocabulary,
        targets: Targets,
        numbers: WrittenNumbers,
    ):
        self.source, self.vocabulary, self.targets = source, vocabulary, targets
        self.numbers = numbers
        self.setting = vocabulary.setting
        self.told: list[Span] = []
        """Where the answer says what the value of a parameter is, which is known."""
        self.replaced: dict[AskedQuantity, Trig] = {}
        """Values that quantities have for a while."""
        self.own_sides: dict[str, Sequence[Token]] = {}
        """By what lines give names of the user's own, in their order."""
        self.letters_of_vectors: frozenset[str] = frozenset()
        """Letters such as v that other lines give as vectors: v1 = 0 is one too."""
        self.load: frozenset[str] = frozenset()
        """The components of a force at the tip that the answer has."""
        self.is_loaded = False
        """Whether the line has some of them."""
        self.besides: frozenset[str] = frozenset()
        """Of the line's quantities."""
        self.common_axes = False
        """Whether vectors are in the world's axes, not each in those of its body."""
        self.of_bodies = False
        """Whether the line is about bodies, so that g is the gravitational acceleration and J that
        of the tip's position; else they are what stands in the equations of motion."""

    def parse(self, side: Sequence[Token], shape: TableShape | None = None) -> Expression:
        """A side as tree; shape: of the vector that it must be."""
        parser = AnswerParser(
            self.source, side, self.vocabulary, self._quantity, self.targets.single, self.table
        )
        node = parser.side()
        try:
            return worked_out(node, parser.others, shape)
        except NoValue as problem:
            self.source.fail(problem.problem, (problem.node or node).span)

    def define(self, name: str, node: Expression, given: tuple[AskedQuantity, ...]) -> None:
        """A name of the user's own for what a tree is; given: the quantities in it."""
        if isinstance(node, Matrix):
            self.vocabulary.define_matrix(name, node, given)
        elif functions_of(node):
            self.vocabulary.define_tree(name, node, given)
        else:
            self.vocabulary.define(name, self.quotient(node), given)

    def is_about_bodies(self, line: AnswerLine) -> bool:
        """Whether a line has a name of a body's quantity in it."""
        found = any(self._tells_of_bodies(token) for side in line for token in side)
        return found or self.setting.is_free_body

    def _tells_of_bodies(self, token: Token) -> bool:
        """Whether a name is that of a vector of a body or the tip, or of an energy."""
        if token.kind != "name" or token.text in self.vocabulary.symbols:
            return False
        single = self.targets.single.get(token.text)
        if single is not None:
            return single.kind.of == "bodies"
        if token.text in self.vocabulary.waves:
            return False
        table = self.targets.tables.get(token.text)
        return table is not None and table[0][0].kind.of == "bodies"

    def table(self, name: str, span: Span) -> Matrix | None:
        """The entries of a vector or matrix, each with its name."""
        if name in self.vocabulary.matrices:
            return replace(self.vocabulary.matrices[name], span=span)
        if name in self.vocabulary.uses and name in self.vocabulary.symbols:
            return None  # one number of the user's own
        if name[-1:] == PRIME and self._has_rows_of_load(name[:-1]):  # J' F of MATLAB
            J = self.table(name[:-1], span)
            return J and replace(J, rows=tuple(zip(*J.rows, strict=True)))
        has_moment = not self.load.issubset(self.setting.force_at_tip)
        by_rows = self._has_rows_of_load(name) and not has_moment
        meant = self.targets.of_bodies.get(name, name) if self.of_bodies or by_rows else name
        table = self.targets.tables.get(meant)
        if table is None:
            return None
        return Matrix(
            tuple(
                tuple(
                    Named(entry_label(meant, x), self._value_of(self.in_axes(x)), span=span)
                    for x in row
                )
                for row in table
            ),
            span=span,
        )

    def _has_rows_of_load(self, name: str) -> bool:
        """Whether a matrix has a row for each component of the load that the line has."""
        table = self.targets.tables.get(name)
        return self.is_loaded and table is not None and table[0][0].kind.has_rows_of_tip

    def in_axes(self, target: AskedQuantity) -> AskedQuantity:
        """A component in the axes that the line is read in."""
        if target.in_world is None or not self.common_axes:
            return target
        return replace(target, compute=target.in_world)

    def in_some_axes(self, side: Sequence[Token], stated: Callable[[], list[Claim]]) -> list[Claim]:
        """What a side states; where that is wrong of vectors in the axes of their bodies, and right
        of the vectors themselves, that: f12 - f23 + m2 g = m2 v̇c2 needs no axes."""
        found = stated()
        bodies = self._bodies_without_axes(side)
        if not bodies or all_right(found):
            return found
        self.common_axes = True
        try:
            again = stated()
        finally:
            self.common_axes = False
        return again if all_right(again) or len(bodies) > 1 else found

    def _bodies_without_axes(self, side: Sequence[Token]) -> frozenset[int]:
        """The bodies in whose axes vectors of a side would be, if it may be a relation between
        vectors of whatever axes: in space, none turned or in a frame, no components."""
        names = {token.text for token in side if token.kind == "name"}
        tables = [x for name in names if (x := self.targets.tables.get(name))]
        turned = any(x[-1] in FRAMES or (x[0] == "R" and x in self.targets.tables) for x in names)
        parts = any(self.targets.single[x].axis for x in names if x in self.targets.single)
        if turned or parts or any(token.kind == "begin" or token.text == "[" for token in side):
            return frozenset()
        return frozenset(x[0][0].index[0] for x in tables if x[0][0].in_world is not None)

    def is_own(self, name: str) -> bool:
        """Whether a name stands for something of the user's, by none of the quantities, though a
        quantity may be called so too."""
        formula = self.setting.given.get(name)
        by_formula = formula is not None and self.vocabulary.symbols.get(name) is formula
        return self.vocabulary.uses.get(name) == () and not by_formula

    def value(self, node: Expression) -> Trig:
        """A tree as polynomial."""
        return PolynomialReader(self.source, self.setting.ring).read(node)

    def quotient(self, node: Expression) -> Value:
        """A tree as polynomial, or as quotient of two."""
        return PolynomialReader(self.source, self.setting.ring).quotient(node)

    def _quantity(self, name: str) -> Value | None:
        if name not in self.targets.single:
            return None
        return self._value_of(self.targets.single[name])

    def _value_of(self, target: AskedQuantity) -> Value:
        if target in self.replaced:
            return self.replaced[target]
        return self.setting.zero if target.idle else self.with_load(target).compute()

    def with_load(self, target: AskedQuantity) -> AskedQuantity:
        """Of a torque in a line that has a force at the tip, the torque that holds it."""
        if not self.is_loaded or not target.kind.is_drive or target.idle:
            return target
        if self.setting.system is not None:
            return held_by_loops(self.setting, target, self.besides)
        return held(self.setting, self.targets.single, target, self.load, self.besides)

    def begin(self, line: AnswerLine) -> None:
        """Note what a line is about."""
        if self.load:
            self.is_loaded = bool(loaded_lines.loads([line], self.vocabulary, self.targets))
            self.besides = loaded_lines.told(line, self.vocabulary, self.targets)

    def claim(self, label: str, target: AskedQuantity, node: Expression) -> Claim:
        """What a tree says of a quantity."""
        used = tuple(uses(node, self.targets.single, self.vocabulary))
        if functions_of(node):  # compared in numbers
            return Claim(label, target, node, target.compute(), self.source, used)
        value = self.quotient(node)
        asked = next((x for x in self.along_legs(target) if x.compute() == value), None)
        return Claim(label, asked or self.with_load(target), node, value, self.source, used)

    def along_legs(self, target: AskedQuantity) -> list[AskedQuantity]:
        """A coordinate of a closed chain's tip along its other legs, where it is x + Φ or x - Φ."""
        if not target.kind.has_legs or self.setting.system is None:
            return []
        x, note = target.polynomial(), "Along the other leg: it holds where the loops are closed."
        loops = {
            t: t.polynomial()
            for t in self.targets.single.values()
            if t.kind.of_loops == "positions"
        }
        ways = [x + sign * Phi for Phi in loops.values() for sign in (1, -1)]
        return [replace(target, compute=lambda y=y: y, note=note) for y in ways]

    def says_that_the_base_moves(self, line: AnswerLine) -> bool:
        """Whether it is v̇0 = -g: gravity as an acceleration of the base."""
        first = line[0]
        if (
            len(first) != 1
            or first[0].text.removesuffix(FRAMES[0]) not in spellings("v", "0", 1)
            or len(line) != 2
        ):
            return False
        self.of_bodies = True
        gravity = self.table("gravity", first[0].span)
        node = self.parse(line[1], gravity and (len(gravity.rows), 1))
        if gravity is None or not isinstance(node, Matrix):
            return False
        pairs = zip(entries_of(gravity), entries_of(node), strict=False)
        return all((self.value(x) + self.value(y)).is_zero for x, y in pairs)

    def is_of_angles(self, line: AnswerLine) -> bool:
        """Whether a line is an identity of sines and cosines, s12 = s1 c2 + c1 s2: it holds, or is
        about nothing else. s12 = sin(θ1+θ2) only says what s12 is, and sin θ2 = 0 where."""
        tokens = [token for side in line for token in side]
        waves = any(x.kind == "function" or x.text in self.vocabulary.waves for x in tokens)
        if len(line) != 2 or not waves or any(map(self.is_matrix, line)):
            return False
        sides = list(map(self.parse, line))
        inside = [x for side in sides for x in nodes(side)]
        if not all(isinstance(x, _OF_ANGLES) for x in inside):
            return False
        if all(isinstance(x, Wave | Number) for x in sides):
            return False
        is_asked = len(line[0]) == 1 and line[0][0].text in self.targets.names
        may_be_wrong = not (is_asked or self.setting.system or _has_number(sides))
        return may_be_wrong or difference(*map(self.quotient, sides)).is_zero

    def is_matrix(self, side: Sequence[Token]) -> bool:
        """Whether a side begins with a vector or matrix of several entries; [m1] is a bracket."""
        depth = 0
        for token in side if side[0].text == "[" else ():
            depth += {"open": 1, "close": -1}.get(token.kind, 0)
            if depth == 0 or (depth == 1 and token.kind in ("comma", "line", "row")):
                return depth == 1
        return side[0].kind == "begin" or self._function(side[0]) in _TABLES

    def _function(self, token: Token) -> str:
        """What a token is called that is a function's name, else ""."""
        return self.vocabulary.functions[token.text] if token.kind == "function" else ""


def entry_label(label: str, target: AskedQuantity) -> str:
    """c of joint 2 is c2; the second entry of vc1 is vc1y."""
    return label + (target.axis or "".join(map(str, target.index)))


def _has_number(sides: Sequence[Expression]) -> bool:
    """Whether a side is a number, as of an equation that is solved for a pose."""
    return any(isinstance(x, Number) for x in sides)


def all_right(claims: Sequence[Claim]) -> bool:
    """Whether claims hold as they stand."""
    return all(difference(x.value, x.target.compute()).is_zero for x in claims)


def entries_of(node: Expression) -> list[Expression]:
    return [x for row in node.rows for x in row] if isinstance(node, Matrix) else [node]
