"""Lines that tell a coordinate, a rate or an acceleration by the robot's quantities."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from fractions import Fraction

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.nodes import Expression, Function, Matrix, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities import kinds
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.answer_tree import Named, Wave
from freebody_textbook.check.algebra.quotients import Value, generator, pair
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.claims.formula_reader import FormulaReader
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.circular_answers import uses
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reading.reading import INVERSE_FUNCTIONS
from freebody_textbook.check.reasons.free_bodies import FreeBodyMotion
from freebody_textbook.closed_chains.first_kind import multiplier_names

_IN_NUMBERS = "by the forces on the body"


class SolvedQuantities(FormulaReader):
    """Reads lines solved for what moves."""

    def is_solved(self, line: AnswerLine) -> bool:
        """Whether a line tells a coordinate, a rate, an acceleration, or the sine or cosine of an
        angle by the robot's quantities: θ̈1 = (τ1 - …)/H11, cos θ2 = (x² + …)/(2 l1 l2)."""
        first = line[0][0]
        if len(line) != 2 or len(line[0]) != 1 or self.is_matrix(line[1]):
            return False
        if self._is_position(line):
            return True
        names = {token.text for token in line[1] if token.kind == "name"}
        if first.text in self.vocabulary.waves:
            tip = (x for x in names if x in self.targets.single)
            return any(self.targets.single[x].kind.has_legs for x in tip)
        return self._is_of_motion(line, names)

    def _is_of_motion(self, line: AnswerLine, names: Collection[str]) -> bool:
        """Whether a line with one name on its left tells a coordinate, rate or acceleration by the
        names on its right."""
        first = line[0][0]
        value = self.vocabulary.symbols.get(first.text)
        moving = self._moving(value)
        is_asked = first.text in self.targets.single and not self.is_own(first.text)
        if is_asked or not (moving or self._is_sum(value)):
            return False
        if first.text in self.targets.tables and isinstance(self.parse(line[1]), Matrix):
            return False
        if self.setting.system is not None and self.numbers.state_at(
            (line[1][0].start, line[1][-1].end)
        ):
            return True  # d3 = 0.74 m at θ1 = 40°
        if self.setting.is_free_body or self.setting.system is not None:
            return bool(names) or (self.setting.is_free_body and atom(moving).dots > 0)
        by_quantities = any(
            x in self.targets.names and x not in self.vocabulary.symbols for x in names
        )
        return by_quantities or (atom(moving).dots == 2 and bool(names))

    def _is_position(self, line: AnswerLine) -> bool:
        """Whether a line tells a coordinate, or the sine or cosine of one, by inverse functions."""
        first, functions = line[0][0].text, self.vocabulary.functions
        if not any(
            x.kind == "function" and functions[x.text] in INVERSE_FUNCTIONS for x in line[1]
        ):
            return False
        moving = self._moving(self.vocabulary.symbols.get(first))
        return first in self.vocabulary.waves or moving in self.setting.symbols.coordinates

    def _moving(self, value: Value | None) -> str:
        """The coordinate, rate or acceleration that a value is, or nothing."""
        name = "" if value is None else generator(value) or ""
        known = {x + d for x in self.setting.symbols.coordinates for d in ("", RATE, SECOND)}
        if self.setting.system is not None:
            known |= set(multiplier_names(self.setting.system.loops))
        if self.setting.is_free_body:
            known |= set(self.setting.symbols.extra)
        return name if name in known else ""

    def _is_sum(self, value: Value | None) -> bool:
        """Whether a name stands for a sum of coordinates or rates of a closed chain, such as the
        angle of a coupler."""
        if self.setting.system is None or not isinstance(value, Trig) or value.is_zero:
            return False
        parts = (value.ring.polynomial([(x, Fraction(1))]) for x, _ in value.terms())
        return all(map(self._moving, parts))

    def solved_for(self, line: AnswerLine) -> Claim:
        """What a line says of a coordinate or of what belongs to it, by the robot's quantities."""
        first, node = line[0][0], self.parse(line[1])
        value = self.quotient(self.parse(line[0]))
        name = self._moving(value)
        for part in nodes(node):
            if not isinstance(part, Named) or part.name in self.targets.single:
                continue
            if name and any(name in p for x in pair(part.value) for p, _ in x.terms()):
                self.source.fail(
                    f"{self.source[first.span]} stands on both sides: solve for it", part.span
                )
        if any(isinstance(x, Function) for x in nodes(node)):
            return self._position(line, name, value, node)
        words = "solved for it by the robot's quantities"
        is_angular = self.setting.turns(name)
        target = AskedQuantity(kinds.SOLVED, (), lambda: value, words=words, is_angular=is_angular)
        if self.setting.is_free_body and not any(isinstance(x, Named) for x in nodes(node)):
            motion = FreeBodyMotion(self.setting).motion((value,))
            target = replace(target, compute=lambda: motion.of(value), words=_IN_NUMBERS)
        return self.claim(self.source[first.span], target, node)

    def _position(self, line: AnswerLine, name: str, value: Value, node: Expression) -> Claim:
        """What a line tells of a coordinate by inverse functions."""
        label = self.source[line[0][0].span]
        for part in nodes(node):
            if isinstance(part, Wave) and any(x == name for x, _ in part.angle):
                self.source.fail(f"{label} stands on both sides: solve for it", part.span)
        target = AskedQuantity(
            kinds.POSTURE, (), lambda: value, words="given by the robot's position"
        )
        used = tuple(uses(node, self.targets.single, self.vocabulary))
        return Claim(label, target, node, value, self.source, used)
