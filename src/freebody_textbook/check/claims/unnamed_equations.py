"""Equations with no quantity alone on a side: torques within sums, loop equations, passive joints,
identities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from fractions import Fraction
from itertools import product

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.grammar.parser import around
from freebody.expressions.nodes import Expression, Matrix, Negative, Number, Sum, nodes
from freebody.expressions.quantities import kinds
from freebody.scalars.generators import generators_in
from freebody.scalars.trig import Trig
from freebody_textbook.check import accepted_variants
from freebody_textbook.check.algebra.quotients import (
    Named,
    Value,
    Wave,
    difference,
    inverted,
    negative,
    pair,
    plus,
    times,
)
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.claims.formula_reader import FormulaReader, all_right, entries_of
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.claim import Claim, uses
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.check.states.state_values import functions_of
from freebody_textbook.closed_chains.linear_equations import Ratio
from freebody_textbook.closed_chains.multiplier_equations import is_multiplier

_LONGEST_LABEL = 60
_MOST_COORDINATES = 2


class UnnamedEquations(FormulaReader):
    """Reads equations with no quantity alone on a side."""

    def unnamed(self, line: AnswerLine, before: Sequence[Claim]) -> list[Claim]:
        """The claims of an equation without a quantity alone on a side: it is solved for its only
        torque τ_i; without torques it is the equation of a passive joint, or a relation between
        other quantities."""
        if len(line) > 2:  # 0 = a = b
            pairs = (AnswerLine((line[0], side)) for side in line[1:])
            return [claim for pair in pairs for claim in self.unnamed(pair, before)]
        if any(functions_of(self.parse(side)) for side in line):
            return self._identities(line)
        if self._says_nothing(line):
            self.source.fail(
                "both sides are the same, whatever its quantities are: there is nothing to check",
                line.span,
            )
        if self.setting.is_free_body:
            return self._identities(line)
        return self._of_joints(line, before)

    def _of_joints(self, line: AnswerLine, before: Sequence[Claim]) -> list[Claim]:
        """The claims of a two-sided equation about a robot with joints."""
        asked = self._asked(line)
        torques = {target for target in asked.values() if target.kind.is_drive and not target.idle}
        told = frozenset(asked.values()) | self._behind_own_names(line)
        between = self._is_between(line, told, torques)
        if not torques and (found := self._by_loops(line, between, bool(asked))):
            return found
        if not torques and not between and self.targets.undriven:
            return self._of_bodies(line) or [self._unpowered(line, before)]
        if len(torques) != 1 and (self.of_bodies or between):
            return self._of_passive(line, before) or self._identities(line)
        return self._of_torque(line, {x: y for x, y in asked.items() if y in torques})

    def _asked(self, line: AnswerLine) -> dict[str, AskedQuantity]:
        """The quantities in a line, by name."""
        taken = {*self.vocabulary.symbols, *self.vocabulary.waves}
        names = sorted({x.text for x in line.names} - taken)
        return {x: self.targets.single[x] for x in names if x in self.targets.single}

    def _behind_own_names(self, line: AnswerLine) -> frozenset[AskedQuantity]:
        """The quantities in the definitions of users' own names in a line."""
        uses = self.vocabulary.uses
        return frozenset(x for name in line.names for x in uses.get(name.text, ()))

    def _is_between(
        self, line: AnswerLine, asked: Set[AskedQuantity], torques: Set[AskedQuantity]
    ) -> bool:
        """Whether a line is a relation between quantities or vectors, such as several torques, and
        no equation of motion."""
        if len(torques) > 1:
            return True
        named = [token.text for token in line.names if self._is_vector(token)]
        vectors = self.setting.system is None and bool(named)
        vectors = vectors and (
            not self.targets.alone.isdisjoint(named)  # q̇ᵀ (Ṁ - 2 C) q̇ = 0
            or all(isinstance(x, Matrix) for x in map(self.parse, line))
        )
        return bool(asked or vectors) and not torques and not self._tells_of_motion(line)

    def _by_loops(self, line: AnswerLine, between: bool, asked: bool) -> list[Claim]:
        """The claims of a torque-free line about a closed chain, if it is a loop equation or a
        relation between quantities."""
        if self.setting.system is None:
            return []
        if along := self._along_legs(line):
            return along
        waves = self.vocabulary.waves
        vectors = any(self._is_vector(t) and t.text not in waves for t in line.names)
        if between or vectors or (asked and self._is_reduced(line)):
            return self._identities(line)
        closing = self._closing(line)
        return [] if closing is None else [closing]

    def _of_torque(self, line: AnswerLine, torques: Mapping[str, AskedQuantity]) -> list[Claim]:
        """The claims of an equation with one torque, solved for it."""
        if len(set(torques.values())) != 1:
            self.source.fail(
                "neither side is one of the quantities that are checked",
                line.span,
                "These are tau1, H12 or M12, c1, g1 or G1, J11, T, V, x and y.",
            )
        name, target = next(iter(torques.items()))
        if any(isinstance(x, Matrix) for x in map(self.parse, line)):
            return self._identities(line)
        value = self._solved(line, target)
        if value is None:
            self.source.fail(f"this equation cannot be solved for {name}", line.span)
        node = self._others(line, name) or Named(name, value, span=line.span)
        sides = map(self.parse, line)
        used = [use for side in sides for use in uses(side, self.targets.single, self.vocabulary)]
        used = [use for use in used if use.target != target]
        return [Claim(name, self.with_load(target), node, value, self.source, tuple(used))]

    def _of_passive(self, line: AnswerLine, before: Sequence[Claim]) -> list[Claim]:
        """The claim of a relation that turns out to be the equation of a passive joint."""
        if any(isinstance(x, Matrix) for x in map(self.parse, line)):
            return []
        value = self._difference(line)[1]
        own = [x.polynomial() for x in self.targets.undriven]
        same = (
            accepted_variants.is_undriven_equation(self.setting, pair(value)[0], x) for x in own
        )
        return [self._unpowered(line, before)] if any(same) else []

    def _others(self, line: AnswerLine, name: str) -> Expression | None:
        """The other terms when an equation is solved for a torque by moving terms; None if the
        torque has a factor."""
        left, right = map(self.parse, line)
        terms = [*_terms(left), *_terms(Negative(right, span=right.span))]
        own = [x for x in terms if name in (getattr(y, "name", "") for y in nodes(x))]
        if len(own) != 1:
            return None
        (torque,), is_less = own, isinstance(own[0], Negative)
        if not isinstance(torque.operand if isinstance(torque, Negative) else torque, Named):
            return None
        others = [x if is_less else _turned(x) for x in terms if x is not torque]
        return Sum(tuple(others), span=around(left, right))

    def _is_reduced(self, line: AnswerLine) -> bool:
        """Whether an equation of motion contains quotients, as in independent coordinates."""
        try:
            return isinstance(self._difference(line)[1], Ratio)
        except AnswerError:  # too long to be multiplied out
            return True

    def _says_nothing(self, line: AnswerLine) -> bool:
        """Whether the sides are equal whatever the values of the quantities, as in T + V = V +
        T."""
        sides = list(map(self.parse, line))
        parts = [x for side in sides for x in nodes(side) if isinstance(x, Named)]
        if any(x.is_derivative for x in parts):
            return False
        inside = dict.fromkeys(
            use.target for x in sides for use in uses(x, self.targets.single, self.vocabulary)
        )
        kept = self.vocabulary
        try:
            self.replaced = {
                target: self.setting.zero + Fraction(1009 + 7 * k, 13 + k)
                for k, target in enumerate(inside)
            }
            self.vocabulary = kept.copy()
            for name, side in self.own_sides.items():
                if not inside.keys().isdisjoint(kept.uses[name]):
                    self.define(name, self.parse(side), kept.uses[name])
            left, right = map(entries_of, map(self.parse, line))
            if len(left) != len(right):  # a vector may be equal to 0
                left, right = sorted((left, right), key=len)
                left = [*left] * len(right)
            gaps = (
                difference(self.quotient(x), self.quotient(y))
                for x, y in zip(left, right, strict=True)
            )
            return all(gap.is_zero for gap in gaps)
        finally:
            self.replaced, self.vocabulary = {}, kept

    def _is_vector(self, token: Token) -> bool:
        """Whether a token is the name of a vector or matrix, such as C in C q̇."""
        table = self.targets.tables.get(token.text)
        if table is None or token.text in self.vocabulary.symbols:
            return False
        return not table[0][0].kind.is_coordinate

    def _tells_of_motion(self, line: AnswerLine) -> bool:
        """Whether a line contains accelerations of coordinates or multipliers, as equations of
        motion do."""
        values = [self.vocabulary.symbols.get(x.text) for x in line.names]
        names = generators_in(*(x for x in values if isinstance(x, Trig)))
        return any(atom(x).dots == 2 or is_multiplier(x) for x in names)

    def _closing(self, line: AnswerLine) -> Claim | None:
        """The claim of a loop equation without name, l1 c1 + l2 c12 - d - l3 c3 = 0, or of its
        first or second derivative, times any number; None if the equation contains forces."""
        node, value = self._difference(line)
        if isinstance(node, Wave):
            self.source.fail(
                "this tells a pose, such as a singular one, which is not read of closed chains",
                node.span,
            )
        above, below = pair(value)
        used = generators_in(above)
        if any(map(is_multiplier, used)) or self.setting.order.gravity in used:
            return None
        dots = max((atom(x).dots for x in used), default=0)
        loops = {
            x: x.polynomial()
            for x in self.targets.single.values()
            if x.kind.of_loops == "positions"
        }
        for _ in range(dots):
            rates = self.setting.symbols.rates
            loops = {x: Phi.along(rates) for x, Phi in loops.items()}
        near = {x: accepted_variants.alike(self.setting, above, Phi) for x, Phi in loops.items()}
        loop, right = min(near.items(), key=lambda row: len(difference(above, row[1])))
        of_loop = ("", "the rate of ", "the second derivative of ")[dots] + loop.words
        target = AskedQuantity(
            kinds.LOOP_EQUATION, (), lambda: times(right, inverted(below)), words=of_loop
        )
        return self.claim(f"The loop equation {self.source[node.span]}", target, node)

    def _along_legs(self, line: AnswerLine) -> list[Claim]:
        """The claim of a relation for the tip that holds along one leg, such as (x - l1 c1)² + (y -
        l1 s1)² = l3²; empty if it holds along none."""
        single = self.targets.single
        inside = {x.text for x in line.names if x.text in single}
        tip = sorted(name for name in inside if single[name].kind.has_legs)[:_MOST_COORDINATES]
        legs = [[single[name], *self.along_legs(single[name])] for name in tip]
        ways = [[x.polynomial() for x in way] for way in product(*legs)]
        anywhere = [x + k for k, x in enumerate(ways[0], 1)]
        try:
            if not tip or self._agrees(line, tip, anywhere):
                return []
            return next((self._identities(line) for w in ways if self._agrees(line, tip, w)), [])
        finally:
            self.replaced = {}

    def _agrees(self, line: AnswerLine, names: Sequence[str], values: Sequence[Trig]) -> bool:
        """Whether the sides are equal when the named quantities have the given values."""
        self.replaced = {
            self.targets.single[name]: x for name, x in zip(names, values, strict=True)
        }
        return self._difference(line)[1].is_zero

    def _difference(self, line: AnswerLine) -> tuple[Expression, Value]:
        """(expression, value) of the left side minus the right; if one side is 0, the other side
        with its own sign."""
        left, right = map(self.parse, line)
        values = self.quotient(left), self.quotient(right)
        node: Expression = Sum((left, Negative(right, span=right.span)), span=around(left, right))
        for side, value in ((right, values[0]), (left, values[1])):
            if value.is_zero:
                node = side
        return node, self.quotient(node)

    def _of_bodies(self, line: AnswerLine) -> list[Claim]:
        """The claims of a line about bodies, if it is a relation between vectors or holds in any
        motion."""
        stated = self._identities(line) if self.of_bodies else []
        return stated if all_right(stated) or len(stated) > 1 else []

    def _identities(self, line: AnswerLine) -> list[Claim]:
        """The claims of a vector equation between quantities of bodies, f01 - f12 + m1 g = m1 v̇c1,
        one per entry."""
        return self.in_some_axes(line.tokens, lambda: self._between(line))

    def _between(self, line: AnswerLine) -> list[Claim]:
        """The claims of an equation between quantities of bodies, with vector components in the
        given axes."""
        left, right = map(self.parse, line[:2])
        if isinstance(left, Matrix) != isinstance(right, Matrix):
            table, k = (left, 1) if isinstance(left, Matrix) else (right, 0)
            assert isinstance(table, Matrix)
            fitting = self.parse(line[k], (len(table.rows), len(table.rows[0])))
            left, right = (left, fitting) if k else (fitting, right)
        span = line.span
        if len(line) != 2 or self.source[left.span] == self.source[right.span]:
            self.source.fail("this must be an equation between two different sides", span)
        pairs = zip(entries_of(left), entries_of(right), strict=False)
        if len(entries_of(left)) != len(entries_of(right)):
            self.source.fail("the sides have different numbers of entries", span)
        label = self.source[span]
        label = label if len(label) <= _LONGEST_LABEL else f"{label[:_LONGEST_LABEL]}…"
        return [self._identity(label, x, y) for x, y in pairs]

    def of_angles(self, line: AnswerLine) -> Claim:
        """The claim of an identity of sines and cosines."""
        left, right = map(self.parse, line)
        value = self.quotient(left)
        target = AskedQuantity(
            kinds.IDENTITY, (), lambda: value, words="an identity of angles",
            note="It claims nothing of the robot.",
        )  # fmt: skip
        label = self.source[line.span]
        whole = Sum((left, Negative(right, span=right.span)), span=around(left, right))
        return Claim(label, target, right, self.quotient(right), self.source, whole=whole)

    def _identity(self, label: str, left: Expression, right: Expression) -> Claim:
        """The claim of one entry in an identity: the side with more terms is compared with the
        other."""
        is_result = isinstance(right, Number) and right.value and self.numbers.state_at(right.span)
        if isinstance(right, Number) and not is_result:
            left, right = right, left
        whole = Sum((left, Negative(right, span=right.span)), span=around(left, right))
        zero = self.setting.zero
        is_0 = AskedQuantity(kinds.LONG_EQUATION, (), lambda: zero)
        if functions_of(whole):
            return Claim(label, is_0, whole, zero, self.source)
        try:
            value, other = self.quotient(left), self.quotient(right)
        except AnswerError:  # too long to be multiplied out
            if self.setting.system is None:
                raise
            return Claim(label, is_0, whole, zero + 1, self.source)
        target = AskedQuantity(kinds.IDENTITY, (), lambda: value)
        used = uses(left, self.targets.single, self.vocabulary)
        known = any(isinstance(x, Named) for side in (left, right) for x in nodes(side))
        if not known and not list(used):
            self.source.fail("this says nothing about the robot", right.span)
        return Claim(label, target, right, other, self.source, whole=whole)

    def _unpowered(self, line: AnswerLine, before: Sequence[Claim]) -> Claim:
        """The claim of an equation without torque, as the equation of a joint without a drive."""
        node, value = self._difference(line)
        if self.setting.system is not None:  # one that is reduced by the loops is none of a joint
            value = self.value(node)
        above, below = pair(value)
        taken = [
            claim.target.index
            for claim in before
            if claim.target.kind.is_equation or claim.target.idle
        ]
        joint, right = accepted_variants.undriven_equation(self.targets, above, taken)
        target = AskedQuantity(kinds.UNDRIVEN, joint, lambda: times(right, inverted(below)))
        return self.claim(f"The equation of joint {joint[0]}", target, node)

    def _solved(self, line: AnswerLine, target: AskedQuantity) -> Value | None:
        """The value of τ from an equation a + k τ = 0; None if k is 0 or the equation is not linear
        in τ."""
        values: list[Value] = []
        for k in range(3):
            self.replaced = {target: self.setting.zero + k}
            left, right = (self.quotient(self.parse(side)) for side in line)
            values.append(plus(left, negative(right)))
        self.replaced = {}
        slope, second = (plus(values[k + 1], negative(values[k])) for k in range(2))
        if slope.is_zero or not difference(slope, second).is_zero:
            return None
        return times(negative(values[0]), inverted(slope))


def _terms(x: Expression) -> list[Expression]:
    """Terms of a sum, with subtracted ones negated."""
    if isinstance(x, Sum):
        return [y for term in x.terms for y in _terms(term)]
    if isinstance(x, Negative) and isinstance(x.operand, Sum | Negative):
        return [_turned(y) for y in _terms(x.operand)]
    return [] if isinstance(x, Number) and not x.value else [x]


def _turned(x: Expression) -> Expression:
    """A term with its sign reversed."""
    return x.operand if isinstance(x, Negative) else Negative(x, span=x.span)
