"""Lines that define users' own names, or give a coordinate, rate or acceleration by the robot's
quantities."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

from freebody.expressions.grammar.atoms import atom, numbered
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.nodes import Expression, Function, Matrix, Number, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities import kinds
from freebody.expressions.quantities.kinds import SHARED_LETTERS
from freebody.lazy import cached_property
from freebody.scalars.generators import generators_in
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import (
    Named,
    Value,
    Wave,
    difference,
    generator,
    pair,
)
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.claims.formula_reader import FormulaReader
from freebody_textbook.check.numbers.units_of_symbols import is_of_another_kind
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.claim import Claim, refuse_itself, uses
from freebody_textbook.check.reading.reading import INVERSE_FUNCTIONS
from freebody_textbook.check.reasons.free_body_beliefs import FreeBodyMotion
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.check.states.state_values import functions_of
from freebody_textbook.closed_chains.linear_equations import Ratio
from freebody_textbook.closed_chains.multiplier_equations import multiplier_names

_BY_FORMULA = (
    "Parameters that formulas give, as lc = l/2 of uniform bars, are told by parameters=, "
    "--parameter lc=l/2, or stand below [parameters] in the robot's file or a notation of your own."
)
_IN_NUMBERS = "by the forces on the body"


class SolvedQuantities(FormulaReader):
    """Reads lines that are solved for a coordinate, rate or acceleration."""

    def is_solved(self, line: AnswerLine) -> bool:
        """Whether a line gives a coordinate, rate, acceleration, or the sine or cosine of an angle
        by the robot's quantities: θ̈1 = (τ1 - …)/H11, cos θ2 = (x² + …)/(2 l1 l2)."""
        first = line[0][0]
        if len(line) != 2 or len(line[0]) != 1 or self.is_matrix(line[1]):
            return False
        if self._is_position(line):
            return True
        names = {token.text for token in line.written_with}
        if first.text in self.vocabulary.waves:
            tip = (x for x in names if x in self.targets.single)
            return any(self.targets.single[x].kind.has_legs for x in tip)
        return self._is_of_motion(line, names)

    def _is_of_motion(self, line: AnswerLine, names: Collection[str]) -> bool:
        """Whether a line with one name on its left gives a coordinate, rate or acceleration by the
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
        """Whether a line gives a coordinate, or its sine or cosine, by inverse functions."""
        first, functions = line[0][0].text, self.vocabulary.functions
        if not any(
            x.kind == "function" and functions[x.text] in INVERSE_FUNCTIONS for x in line[1]
        ):
            return False
        moving = self._moving(self.vocabulary.symbols.get(first))
        return first in self.vocabulary.waves or moving in self.setting.symbols.coordinates

    def _moving(self, value: Value | None) -> str:
        """The name of the coordinate, rate or acceleration that a value consists of; "" if it is
        anything else."""
        name = "" if value is None else generator(value) or ""
        known = {x + d for x in self.setting.symbols.coordinates for d in ("", RATE, SECOND)}
        if self.setting.system is not None:
            known |= set(multiplier_names(self.setting.system.loops))
        if self.setting.is_free_body:
            known |= set(self.setting.symbols.extra)
        return name if name in known else ""

    def _is_sum(self, value: Value | None) -> bool:
        """Whether a value is a sum of coordinates or of rates in a closed chain, such as a
        coupler's angle."""
        if self.setting.system is None or not isinstance(value, Trig) or value.is_zero:
            return False
        parts = (value.ring.polynomial([(x, Fraction(1))]) for x, _ in value.terms())
        return all(map(self._moving, parts))

    def solved_for(self, line: AnswerLine) -> Claim:
        """The claim of a line that is solved for a coordinate, its rate, acceleration, sine or
        cosine."""
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
        """The claim of a line that gives a coordinate by inverse functions."""
        label = self.source[line[0][0].span]
        for part in nodes(node):
            if isinstance(part, Wave) and any(x == name for x, _ in part.angle):
                self.source.fail(f"{label} stands on both sides: solve for it", part.span)
        target = AskedQuantity(
            kinds.POSTURE, (), lambda: value, words="given by the robot's position"
        )
        used = tuple(uses(node, self.targets.single, self.vocabulary))
        return Claim(label, target, node, value, self.source, used)


class OwnDefinitions(SolvedQuantities):
    """Distinguishes definitions from lines to be checked, and stores the defined values."""

    @cached_property
    def letters_of_vectors(self) -> frozenset[str]:
        """Letters such as v that lines define as vectors by their entries; a line v1 = 0 then means
        a zero vector."""
        return frozenset(
            line.subject[0]
            for line in self.lines
            if line.subject in {*self.targets.soft, *self.targets.alone}
            and any(self.is_matrix(side) for side in line[1:])
        )

    def _subjects(self, is_own: Callable[[AnswerLine], bool]) -> set[str]:
        """Left sides of the lines that satisfy `is_own`, anywhere in the answer."""
        found = set[str]()
        for line in self.lines:
            with suppress(AnswerError):  # told where the line is read
                if is_own(line):
                    found.add(line.subject)
        return found

    @property
    def own_scalars(self) -> set[str]:
        """Names of vectors that lines define as scalars."""
        return self._subjects(self._is_own_scalar)

    def own_coefficients(self, pending: Collection[str]) -> set[str]:
        """Names of velocity coefficients that lines define and others use, in any order; pending:
        names whose definition has not been read."""
        given = {x.subject: x for x in self.lines}
        return {
            name
            for name, line in given.items()
            if self._is_own_h(line) and not any(x.text in pending for x in line.written_with)
        }

    def definitions(self, line: AnswerLine) -> list[AnswerLine]:
        """The line, if it defines a user's own name or an h that other lines use; its value is
        stored. Otherwise an empty list."""
        name = line.subject
        self.of_bodies = self.is_about_bodies(line)
        self.begin(line)
        if self.is_solved(line) or name in self.vocabulary.told or self.is_of_angles(line):
            return []
        if name in self.vocabulary.waves and self._is_wave(name, line):
            return [line]
        if not name or (
            name in self.targets.names
            and not self._is_own_h(line)
            and not self._is_own_number(line)
            and not self._is_own_scalar(line)
        ):
            return []
        if self._repeats_a_formula(name, line):
            return [line]
        is_taken = not self._is_free(name) and name not in self.own_coordinates
        if name in self.vocabulary.waves or name in self.setting.zeros or is_taken:
            self._refuse_symbol(name, line)
            return []  # a loop's equation, solved for a length
        node = self.parse(line[1])
        given = tuple(use.target for use in uses(node, self.targets.single, self.vocabulary))
        if self.targets.single.get(name) in given:
            refuse_itself(self.source, self.source[line[0][0].span], node.span)
        self.define(name, node, given)
        self.own_sides[name] = line[1]
        return [line]

    def _refuse_symbol(self, name: str, line: AnswerLine) -> None:
        """Raise an error if a line redefines a symbol of the model, unless it is a loop equation
        solved for the symbol."""
        own, given = self.vocabulary.symbols.get(name), self._given(line[1])
        if own is not None and given is not None and difference(own, given).is_zero:
            self.source.fail("both sides are the same: there is nothing to check", line[1][0].span)
        if self.setting.system is not None and not self._is_still(given):
            return
        span = line[0][0].span
        self.source.fail(
            f"{self.source[span]} is a symbol of the model, not a result to be checked",
            span,
            _BY_FORMULA if name in self.setting.symbols.model.parameters else "",
        )

    def _repeats_a_formula(self, name: str, line: AnswerLine) -> bool:
        """Whether a line repeats the formula by which the model defines a parameter."""
        meant = self.vocabulary.symbols.get(name)
        if meant is None or meant not in self.setting.given.values():
            return False
        node = self.parse(line[1])
        return not isinstance(node, Matrix) and difference(self.quotient(node), meant).is_zero

    def _is_still(self, value: Value | None) -> bool:
        """Whether a value contains only parameters."""
        moving = self.setting.symbols.rates
        return value is not None and all(
            x.derivative(name).is_zero for x in pair(value) for name in moving
        )

    @property
    def own_coordinates(self) -> set[str]:
        """Names of coordinates that the answer defines as numbers, as θ_1 = m_1 l_c1² + I_1, when
        its coordinates have other names."""
        return self._subjects(self._is_own_coordinate)

    def _is_own_coordinate(self, line: AnswerLine) -> bool:
        """Whether a line defines a coordinate's name as a combination of parameters, when the
        coordinate has another name in the answer."""
        symbols = self.vocabulary.symbols
        value = symbols.get(line.subject)
        if len(line) != 2 or not isinstance(value, Trig) or not self._is_coordinate(value):
            return False
        written = {name.text for x in self.lines for name in x.names} - {line.subject}
        is_renamed = any(symbols[x] == value for x in written if x in symbols)
        return is_renamed and self._is_still(self._given(line[1]))

    def _is_coordinate(self, value: Trig) -> bool:
        return any(value == self.setting.ring[x] for x in self.setting.symbols.coordinates)

    def _is_wave(self, name: str, line: AnswerLine) -> bool:
        """Whether a line only defines s12 or c12 as the sine or cosine that it means anyway."""
        node = self.parse(line[1])
        if isinstance(node, Matrix):
            return False
        meant = Wave(*self.vocabulary.waves[name], span=line[0][0].span)
        return difference(self.quotient(node), self.value(meant)).is_zero

    def _is_free(self, name: str) -> bool:
        """Whether a name is unused in this model: it has no meaning, or one only in other
        models."""
        if name in self.setting.foreign:
            return True
        return self.vocabulary.symbols.get(name, self.setting.zero).is_zero

    def _is_own_number(self, line: AnswerLine) -> bool:
        """Whether a letter that some books use for a quantity is the user's own: a scalar in place
        of a matrix or vector, or a value with other units that other lines use."""
        name = line.subject
        letter, _ = numbered(name)
        target = self.targets.single.get(name)
        asked = self.asked(name)
        is_matrix = target is None and asked is not None and asked.kind.is_matrix
        soft = letter in SHARED_LETTERS or name in self.targets.soft or is_matrix
        soft = soft or self.setting.is_free_body or (target is not None and target.soft)
        may_be_ratio = asked is not None and letter in asked.kind.letters_of_ratios
        if not (soft or may_be_ratio) or self.is_matrix(line[1]):
            return False
        if target is not None and target.kind.is_given:
            return False
        if target is None:
            return name in SHARED_LETTERS or (
                self._is_used(line)
                and (is_matrix or self._is_still(self._given(line[1])))
                and not self._is_zero_vector(line)
                and not self.says_that_the_base_moves(line)
            )
        return self._is_other_number(line, target, soft)

    def _is_other_number(self, line: AnswerLine, target: AskedQuantity, soft: bool) -> bool:
        """Whether a line gives a quantity's name a value that the quantity cannot have; soft:
        whether the name is often used for something else."""
        given = self._given(line[1])
        if isinstance(given, Ratio):
            return not target.kind.is_quotient
        if target.soft and isinstance(given, Trig):
            return is_of_another_kind(self.setting, given, target.polynomial())
        if not soft or not self._is_used(line) or not isinstance(given, Trig):
            return False
        if self.setting.is_free_body:  # T of thrusts, where m, I and rates tell the energy
            return generators_in(given).isdisjoint(generators_in(target.polynomial()))
        return is_of_another_kind(self.setting, given, target.polynomial())

    def _given(self, side: Sequence[Token]) -> Value | None:
        """The value of a side that is a scalar without roots; None otherwise."""
        node = self.parse(side)
        by_number = isinstance(node, Matrix) or functions_of(node)
        return None if by_number else self.quotient(node)

    def _is_own_scalar(self, line: AnswerLine) -> bool:
        """Whether a line defines the name of a body's vector as a scalar, or a vector's letter that
        other lines use, such as a ratio n."""
        name = line.subject
        if name in self.targets.single:
            return False
        is_vector = len(self.targets.tables.get(name, ())) > 1
        is_letter = is_vector and len(name) == 1 and name not in self.vocabulary.symbols
        if name not in self.targets.soft and not (is_letter and self._is_used(line)):
            return False
        return not (self._is_zero_vector(line) or isinstance(self.parse(line[1]), Matrix))

    def _is_zero_vector(self, line: AnswerLine) -> bool:
        """Whether a line is v1 = 0, with a letter that other lines define as a vector."""
        node = self.parse(line[1])
        return (
            isinstance(node, Number) and not node.value and self.may_be_vector(line.subject, node)
        )

    def may_be_vector(self, name: str, node: Number) -> bool:
        """Whether a plain number may be a vector: any number for a letter that other lines define
        as a vector, and 0 for a vector that vanishes."""
        if name[0] in self.letters_of_vectors:
            return True
        table = self.targets.tables.get(name, [])
        of_bodies = node.value == 0 and table and all(len(row) == 1 for row in table)
        return bool(of_bodies) and all(
            x.kind.of == "bodies" and x.polynomial().is_zero for (x,) in table
        )

    def _is_own_h(self, line: AnswerLine) -> bool:
        """Whether a line defines a velocity coefficient that other lines use."""
        target = self.targets.single.get(line.subject)
        return target is not None and target.kind.is_coefficient and self._is_used(line)

    def _is_used(self, line: AnswerLine) -> bool:
        """Whether another line uses the name that a line defines, on its right side."""
        others = (x for x in self.lines if x != line)
        return any(token.text == line.subject for x in others for token in x.written_with)
