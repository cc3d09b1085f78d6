"""Lines that introduce names of the user's own."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress

from freebody.expressions.grammar.atoms import numbered
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.nodes import Matrix, Number
from freebody.expressions.quantities.kinds import SHARED_LETTERS
from freebody.scalars.generators import generators_in
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.answer_tree import Wave
from freebody_textbook.check.algebra.quotients import Value, difference, pair
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.claims.solved_quantities import SolvedQuantities
from freebody_textbook.check.numbers.units import is_of_another_kind
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.circular_answers import refuse_itself, uses
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.check.states.state_values import functions_of
from freebody_textbook.closed_chains.linear import Ratio

_BY_FORMULA = (
    "Parameters that formulas give, as lc = l/2 of uniform bars, are told by parameters=, "
    "--parameter lc=l/2, or stand below [parameters] in the robot's file or a notation of your own."
)
"""Families whose letter alone is one's own where it is one number, as an inertia J."""
_NO_QUOTIENTS = ("K", "gamma")
"""Letters of quantities that are no quotients, which name ratios in other lines."""


class OwnDefinitions(SolvedQuantities):
    """Tells definitions from what is to be checked, and notes their values."""

    def letters_given_as_vectors(self, lines: Sequence[AnswerLine]) -> frozenset[str]:
        """First letters of names of vectors that a line gives by its entries."""
        return frozenset(
            line[0][0].text[0]
            for line in lines
            if len(line[0]) == 1
            and line[0][0].text in {*self.targets.soft, *self.targets.alone}
            and any(self.is_matrix(side) for side in line[1:])
        )

    def own_scalars(self, lines: Sequence[AnswerLine]) -> set[str]:
        """Names of vectors that lines give as one number, wherever these stand."""
        found = set[str]()
        for line in lines:
            name = line[0][0].text if len(line[0]) == 1 and len(line) > 1 else ""
            with suppress(AnswerError):  # told where the line is read
                if self._is_own_scalar(name, line, lines):
                    found.add(name)
        return found

    def own_coefficients(self, lines: Sequence[AnswerLine], pending: Collection[str]) -> set[str]:
        """Names of velocity coefficients that lines give and others use, wherever these stand;
        pending: names that wait for their own lines."""
        given = {x[0][0].text: x for x in lines if len(x[0]) == 1 and len(x) > 1}
        return {
            name
            for name, line in given.items()
            if self._is_own_h(name, line, lines)
            and not any(x.text in pending for side in line[1:] for x in side)
        }

    def definitions(self, line: AnswerLine, lines: Sequence[AnswerLine]) -> list[AnswerLine]:
        """The line, if it introduces a name of the user's own, or an h that other lines use: its
        value is noted."""
        first = line[0]
        name = first[0].text if len(first) == 1 and first[0].kind == "name" else ""
        self.of_bodies = self.is_about_bodies(line)
        self.begin(line)
        if self.is_solved(line) or name in self.vocabulary.told:
            return []
        if self.is_of_angles(line):
            return []
        if name in self.vocabulary.waves and self._is_wave(name, line):
            return [line]
        if not name or (
            name in self.targets.names
            and not self._is_own_h(name, line, lines)
            and not self._is_own_number(name, line, lines)
            and not self._is_own_scalar(name, line, lines)
        ):
            return []
        if self._repeats_a_formula(name, line):
            return [line]
        is_taken = not self._is_free(name) and name not in self.own_coordinates(lines)
        if name in self.vocabulary.waves or name in self.setting.zeros or is_taken:
            self._refuse_symbol(name, line)
            return []  # a loop's equation, solved for a length
        node = self.parse(line[1])
        given = tuple(use.target for use in uses(node, self.targets.single, self.vocabulary))
        if self.targets.single.get(name) in given:
            refuse_itself(self.source, self.source[first[0].span], node.span)
        self.define(name, node, given)
        self.own_sides[name] = line[1]
        return [line]

    def _refuse_symbol(self, name: str, line: AnswerLine) -> None:
        """Refuse to define a symbol of the model, but where a loop's equation is solved for it."""
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
        """Whether a line says of a parameter that a formula gives only what that formula says."""
        meant = self.vocabulary.symbols.get(name)
        if meant is None or meant not in self.setting.given.values():
            return False
        node = self.parse(line[1])
        return not isinstance(node, Matrix) and difference(self.quotient(node), meant).is_zero

    def _is_still(self, value: Value | None) -> bool:
        """Whether a value is made of parameters alone."""
        moving = self.setting.symbols.rates
        return value is not None and all(
            x.derivative(name).is_zero for x in pair(value) for name in moving
        )

    def own_coordinates(self, lines: Sequence[AnswerLine]) -> set[str]:
        """Names of coordinates that lines give to numbers of their own, as θ_1 = m_1 l_c1² + I_1,
        where the coordinates go by other names."""
        symbols, found = self.vocabulary.symbols, set[str]()
        written = {token.text for line in lines for side in line for token in side}
        for line in lines:
            name = line[0][0].text if len(line[0]) == 1 and len(line) == 2 else ""
            value = symbols.get(name)
            if not isinstance(value, Trig) or not self._is_coordinate(value):
                continue
            others = (x for x in written - {name} if x in symbols)
            with suppress(AnswerError):  # told where the line is read
                if any(symbols[x] == value for x in others) and self._is_still(
                    self._given(line[1])
                ):
                    found.add(name)
        return found

    def _is_coordinate(self, value: Trig) -> bool:
        return any(value == self.setting.ring[x] for x in self.setting.symbols.coordinates)

    def _is_wave(self, name: str, line: AnswerLine) -> bool:
        """Whether a line says of s12 or c12 only what it stands for anyway."""
        node = self.parse(line[1])
        if isinstance(node, Matrix):
            return False
        meant = Wave(*self.vocabulary.waves[name], span=line[0][0].span)
        return difference(self.quotient(node), self.value(meant)).is_zero

    def _is_free(self, name: str) -> bool:
        """Whether a name stands for nothing of the model: for nothing, or for what only other
        models have."""
        if name in self.setting.foreign:
            return True
        return self.vocabulary.symbols.get(name, self.setting.zero).is_zero

    def _is_own_number(self, name: str, line: AnswerLine, lines: Sequence[AnswerLine]) -> bool:
        """Whether a letter that some books have for one of the quantities stands for something of
        the user's own: one number for a matrix or vector, or what other lines use and has other
        units."""
        letter, _ = numbered(name)
        table = self.targets.tables.get(name)
        is_matrix = name not in self.targets.single and table and table[0][0].kind.is_matrix
        soft = letter in SHARED_LETTERS or name in self.targets.soft or bool(is_matrix)
        soft = soft or self.setting.is_free_body
        target = self.targets.single.get(name)
        soft = soft or (target is not None and target.soft)
        if not (soft or letter in _NO_QUOTIENTS) or self.is_matrix(line[1]):
            return False
        if target is not None and target.kind.is_given:
            return False
        if target is None:
            return name in SHARED_LETTERS or (
                self._is_used(name, line, lines)
                and (bool(is_matrix) or self._is_still(self._given(line[1])))
                and not self._is_zero_vector(name, line)
                and not self.says_that_the_base_moves(line)
            )
        return self._is_other_number(name, line, lines, target, soft)

    def _is_other_number(
        self,
        name: str,
        line: AnswerLine,
        lines: Sequence[AnswerLine],
        target: AskedQuantity,
        soft: bool,
    ) -> bool:
        """Whether a line gives a quantity's name to a number that the quantity cannot be; soft:
        whether the name is often another's."""
        given = self._given(line[1])
        if isinstance(given, Ratio):
            return not target.kind.is_quotient
        if target.soft and isinstance(given, Trig):
            return is_of_another_kind(self.setting, given, target.polynomial())
        if not soft:
            return False
        if not self._is_used(name, line, lines):
            return False
        if not isinstance(given, Trig):
            return False
        if self.setting.is_free_body:  # T of thrusts, where m, I and rates tell the energy
            return generators_in(given).isdisjoint(generators_in(target.polynomial()))
        return is_of_another_kind(self.setting, given, target.polynomial())

    def _given(self, side: Sequence[Token]) -> Value | None:
        """The value of a side that is no vector or matrix, and holds no root."""
        node = self.parse(side)
        by_number = isinstance(node, Matrix) or functions_of(node)
        return None if by_number else self.quotient(node)

    def _is_own_scalar(self, name: str, line: AnswerLine, lines: Sequence[AnswerLine]) -> bool:
        """Whether a name of a body's vector is given to one number, or the letter of another vector
        with which other lines are written, as a ratio n."""
        if name in self.targets.single:
            return False
        is_vector = len(self.targets.tables.get(name, ())) > 1
        is_letter = is_vector and len(name) == 1 and name not in self.vocabulary.symbols
        if name not in self.targets.soft and not (is_letter and self._is_used(name, line, lines)):
            return False
        return not (self._is_zero_vector(name, line) or isinstance(self.parse(line[1]), Matrix))

    def _is_zero_vector(self, name: str, line: AnswerLine) -> bool:
        """Whether a line says v1 = 0 of a letter that other lines give as a vector."""
        node = self.parse(line[1])
        return isinstance(node, Number) and not node.value and self.may_be_vector(name, node)

    def may_be_vector(self, name: str, node: Number) -> bool:
        """Whether one number may be a vector: 0 of one that vanishes, or where other lines give the
        letter as vectors."""
        if name[0] in self.letters_of_vectors:
            return True
        table = self.targets.tables.get(name, [])
        of_bodies = node.value == 0 and table and all(len(row) == 1 for row in table)
        return bool(of_bodies) and all(
            x.kind.of == "bodies" and x.polynomial().is_zero for (x,) in table
        )

    def _is_own_h(self, name: str, line: AnswerLine, lines: Sequence[AnswerLine]) -> bool:
        """Whether a line defines a velocity coefficient that other lines are written with."""
        if (
            self.targets.single.get(name) is None
            or not self.targets.single[name].kind.is_coefficient
        ):
            return False
        return self._is_used(name, line, lines)

    def _is_used(self, name: str, line: AnswerLine, lines: Sequence[AnswerLine]) -> bool:
        """Whether another line is written with a name, not merely about it."""
        return any(
            t.kind == "name" and t.text == name
            for other in lines
            if other != line
            for side in (other if len(other[0]) > 1 else other[1:])
            for t in side
        )
