"""Reading sides of equations as expression trees and values, with the model's quantities by
name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from freebody.expressions.evaluate import NoValue
from freebody.expressions.grammar.atoms import atom, spellings
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
from freebody.lazy import cached_property
from freebody.scalars.generators import generators_in
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.quotients import Named, Value, Wave, difference
from freebody_textbook.check.algebra.tables_in_formulas import TableShape, worked_out
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.loads import held, held_by_loops
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.numbers.given_states import WrittenNumbers
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.claim import Claim, uses
from freebody_textbook.check.reading.reading import AnswerParser, opens_table
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerText
from freebody_textbook.check.states.state_values import functions_of

_TABLES = ("Matrix", "jacobian")
"""Functions that make a vector or matrix."""
_OF_ANGLES = (Wave, Number, Sum, Negative, Product, Power, Quotient)
"""The nodes of which identities of sines and cosines are made."""


class FormulaReader:
    """Reads sides of equations as expression trees and values."""

    def __init__(
        self,
        source: AnswerText,
        vocabulary: Vocabulary,
        targets: Targets,
        numbers: WrittenNumbers,
        lines: Sequence[AnswerLine],
    ):
        self.source, self.vocabulary, self.targets = source, vocabulary, targets
        self.numbers, self.lines = numbers, lines
        self.setting = vocabulary.setting
        self.told: list[Span] = []
        """The places at which the answer tells the known value of a parameter."""
        self.replaced: dict[AskedQuantity, Trig] = {}
        """Values that quantities have for a while."""
        self.own_sides: dict[str, Sequence[Token]] = {}
        """The sides by which lines give names of the user's own, in their order."""
        self.is_loaded = False
        """Whether the line has components of a force at the tip."""
        self.besides: frozenset[str] = frozenset()
        """The motion and weights that the line's quantities tell of besides the force at the
        tip."""
        self.common_axes = False
        """Whether vectors are in the world's axes, not each in those of its body."""
        self.of_bodies = False
        """Whether the line is about bodies, so that g is the gravitational acceleration and J that
        of the tip's position; else they are what stands in the equations of motion."""

    def parse(self, side: Sequence[Token], shape: TableShape | None = None) -> Expression:
        """The expression tree of a side; shape: of the vector that it must be."""
        parser = AnswerParser(
            self.source, side, self.vocabulary, self._quantity, self.targets.single, self.table
        )
        node = parser.side()
        try:
            return worked_out(node, parser.others, shape)
        except NoValue as problem:
            self.source.fail(problem.problem, (problem.node or node).span)

    def define(self, name: str, node: Expression, given: tuple[AskedQuantity, ...]) -> None:
        """Define a user's own name as the value of an expression tree; given: the quantities in
        it."""
        stays = isinstance(node, Matrix) or functions_of(node)
        self.vocabulary.define(name, node if stays else self.quotient(node), given)

    def is_about_bodies(self, line: AnswerLine) -> bool:
        """Whether a line contains the name of a body's quantity."""
        return any(map(self._tells_of_bodies, line.names)) or self.setting.is_free_body

    def _tells_of_bodies(self, token: Token) -> bool:
        """Whether a name is a vector of a body or of the tip, or an energy."""
        name, vocabulary = token.text, self.vocabulary
        is_wave = name in vocabulary.waves and name not in self.targets.single
        if is_wave or name in vocabulary.symbols:
            return False
        asked = self.asked(name)
        return asked is not None and asked.kind.of == "bodies"

    def asked(self, name: str) -> AskedQuantity | None:
        """The quantity of a name, or the first entry of its vector or matrix; None if there is
        none."""
        table = self.targets.tables.get(name, [[None]])
        return self.targets.single.get(name, table[0][0])

    def table(self, name: str, span: Span) -> Matrix | None:
        """The vector or matrix of a name, with a named node for each entry; None if it is
        neither."""
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
        """Whether a matrix has one row per component of the load in the line."""
        table = self.targets.tables.get(name)
        return self.is_loaded and table is not None and table[0][0].kind.has_rows_of_tip

    def in_axes(self, target: AskedQuantity) -> AskedQuantity:
        """A vector component in the axes that the line uses."""
        if target.in_world is None or not self.common_axes:
            return target
        return replace(target, compute=target.in_world)

    def in_some_axes(self, side: Sequence[Token], stated: Callable[[], list[Claim]]) -> list[Claim]:
        """The claims of a side; if they are wrong with vectors in their bodies' axes and correct
        with all vectors in common axes, the latter: f12 - f23 + m2 g = m2 v̇c2 needs no axes."""
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
        """The bodies whose vectors may be meant in common axes: the side may be a relation between
        vectors in arbitrary axes, in space, without rotation matrices, frame marks or
        components."""
        names = {token.text for token in side if token.kind == "name"}
        tables = [x for name in names if (x := self.targets.tables.get(name))]
        turned = any(x[-1] in FRAMES or (x[0] == "R" and x in self.targets.tables) for x in names)
        parts = any(self.targets.single[x].axis for x in names if x in self.targets.single)
        if turned or parts or any(token.kind == "begin" or token.text == "[" for token in side):
            return frozenset()
        return frozenset(x[0][0].index[0] for x in tables if x[0][0].in_world is not None)

    def is_own(self, name: str) -> bool:
        """Whether the user defined a name by none of the model's quantities, though a quantity may
        have that name too."""
        formula = self.setting.given.get(name)
        by_formula = formula is not None and self.vocabulary.symbols.get(name) is formula
        return self.vocabulary.uses.get(name) == () and not by_formula

    def value(self, node: Expression) -> Trig:
        """The polynomial value of an expression tree."""
        return PolynomialReader(self.source, self.setting.ring).read(node)

    def quotient(self, node: Expression) -> Value:
        """The value of an expression tree: a polynomial, or a quotient of two."""
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
        """A quantity; if it is a torque and the line has a load at the tip, the torque in
        equilibrium with it."""
        if not self.is_loaded or not target.kind.is_drive or target.idle:
            return target
        if self.setting.system is not None:
            return held_by_loops(self.setting, target, self.besides)
        return held(self.setting, self.targets.single, target, self.load, self.besides)

    def begin(self, line: AnswerLine) -> None:
        """Record the load, the effects and the axes that a line uses."""
        if self.load:
            self.is_loaded = bool(self._load_of(line))
            self.besides = self._told_of(line)

    @cached_property
    def load(self) -> frozenset[str]:
        """The components of a force or moment at the tip that occur in the answer."""
        return frozenset[str]().union(*map(self._load_of, self.lines))

    def _load_of(self, line: AnswerLine) -> frozenset[str]:
        """The components of a force or moment at the tip that occur in a line."""
        return frozenset(x for name in line.names for x in self._in_name(name.text)[1])

    def _told_of(self, line: AnswerLine) -> frozenset[str]:
        """The effects besides a load that a line's quantities include: "rate", "motion",
        "weight"."""
        variations = self.vocabulary.variations
        varied = (x.text for x in line.names if x.start in variations)
        others = {x.text for x in line.names if x.start not in variations}
        weighs = {"weight"} if any(map(self._has_weight, varied)) else set[str]()
        return frozenset(weighs.union(*(self._in_name(name)[0] for name in others)))

    def _has_weight(self, name: str) -> bool:
        """Whether a virtual displacement implies work of the weights, as δV does."""
        asked, gravity = self.targets.single.get(name), self.setting.order.gravity
        return asked is not None and any(gravity in x for x, _ in asked.polynomial().terms())

    def _in_name(self, name: str) -> tuple[set[str], set[str]]:
        """The effects that a name implies, and the load components that it contains."""
        setting, value = self.setting, self.vocabulary.symbols.get(name)
        if name in self.vocabulary.waves:
            return set(), set()
        if isinstance(value, Trig):
            used = generators_in(value)
            dots = {atom(x).dots for x in used}
            found = {what for what, dot in (("rate", 1), ("motion", 2)) if dot in dots}
            found |= {"weight"} if setting.order.gravity in used else set()
            return found, used & set(setting.loads)
        asked = self.asked(name)
        if asked is None:
            return set(), set()
        rows = len(self.targets.tables.get(name, ())) if asked.kind.is_load else 0
        return {asked.kind.tells}, set(setting.loads[:rows])

    def claim(self, label: str, target: AskedQuantity, node: Expression) -> Claim:
        """The claim that a quantity equals an expression."""
        used = tuple(uses(node, self.targets.single, self.vocabulary))
        if functions_of(node):  # compared in numbers
            target = self.with_load(target)
            return Claim(label, target, node, target.compute(), self.source, used)
        value = self.quotient(node)
        asked = next((x for x in self.along_legs(target) if x.compute() == value), None)
        return Claim(label, asked or self.with_load(target), node, value, self.source, used)

    def along_legs(self, target: AskedQuantity) -> list[AskedQuantity]:
        """Alternative values of a tip coordinate in a closed chain, along its other legs: x + Φ or
        x - Φ with a loop equation Φ."""
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
        """Whether a line is v̇0 = -g, that is gravity as an acceleration of the base."""
        if len(line) != 2 or line.subject.removesuffix(FRAMES[0]) not in spellings("v", "0", 1):
            return False
        self.of_bodies = True
        gravity = self.table("gravity", line[0][0].span)
        node = self.parse(line[1], gravity and (len(gravity.rows), 1))
        if gravity is None or not isinstance(node, Matrix):
            return False
        pairs = zip(entries_of(gravity), entries_of(node), strict=False)
        return all((self.value(x) + self.value(y)).is_zero for x, y in pairs)

    def is_of_angles(self, line: AnswerLine) -> bool:
        """Whether a line is an identity of sines and cosines, such as s12 = s1 c2 + c1 s2. s12 =
        sin(θ1+θ2) only defines s12, and sin θ2 = 0 gives a pose."""
        waves = any(x.kind == "function" or x.text in self.vocabulary.waves for x in line.tokens)
        if len(line) != 2 or not waves or any(map(self.is_matrix, line)):
            return False
        sides = list(map(self.parse, line))
        inside = [x for side in sides for x in nodes(side)]
        if not all(isinstance(x, _OF_ANGLES) for x in inside):
            return False
        if all(isinstance(x, Wave | Number) for x in sides):
            return False
        is_asked = line.subject in self.targets.names
        may_be_wrong = not (is_asked or self.setting.system or _has_number(sides))
        return may_be_wrong or difference(*map(self.quotient, sides)).is_zero

    def is_matrix(self, side: Sequence[Token]) -> bool:
        """Whether a side begins with a vector or a matrix."""
        return opens_table(side) or self._function(side[0]) in _TABLES

    def _function(self, token: Token) -> str:
        """The name of a function, if a token is one; otherwise ""."""
        return self.vocabulary.functions[token.text] if token.kind == "function" else ""


def entry_label(label: str, target: AskedQuantity) -> str:
    """The label of an entry in a message: c of joint 2 is c2, the second entry of vc1 is vc1y."""
    return label + (target.axis or "".join(map(str, target.index)))


def _has_number(sides: Sequence[Expression]) -> bool:
    """Whether a side is a plain number, as in an equation to be solved for a pose."""
    return any(isinstance(x, Number) for x in sides)


def all_right(claims: Sequence[Claim]) -> bool:
    """Whether all claims are correct as they stand."""
    return all(difference(x.value, x.target.compute()).is_zero for x in claims)


def entries_of(node: Expression) -> list[Expression]:
    return [x for row in node.rows for x in row] if isinstance(node, Matrix) else [node]
