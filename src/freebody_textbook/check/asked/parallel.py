"""Quantities of parallel robots: J_a ẋ + J_b θ̇ = 0 between tip and drives, also written J_x ẋ =
J_q q̇ or A ẋ = B q̇."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from freebody.errors import FreebodyError
from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.arithmetic import PolynomialRows, inner
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import negative
from freebody_textbook.check.asked.group import (
    MOST_ROWS,
    NamedTarget,
    QuantityGroup,
    entries,
    inverse,
)
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity, QuantityTable
from freebody_textbook.closed_chains.input_output import ROWS, ClosedInputOutput

_PAIRS = {
    ("Ja", "Jb"): tuple(f"J _? {{? < \\mathrm {{ >? {x} !~%no_end }}{{0,2}}" for x in "ab"),
    ("Jx", "Jq"): (
        "J _? {? < \\mathrm { >? x !~%no_end }{0,2}",
        "J _? {? < \\mathrm { >? < q | θ > !~%no_end }{0,2}",
    ),
    ("A", "B"): tuple(f"!-%latin {x} !~%no_end }}?" for x in "AB"),
}
"""Names of both matrices, and how they are written."""
_OF_OTHER = "This is the entry of the other matrix: {} stands with the rates of {}."
_TRANSPOSED = "This is the entry of the transpose."


class ParallelQuantities(QuantityGroup):
    """The Jacobians J_a, J_b of a parallel robot, their determinants, and J = -J_a⁻¹ J_b."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer contains J_a and J_b by these names, or A ẋ = B θ̇."""
        *pairs, (A, B) = _PAIRS.values()
        told = any(LexemePattern(x).found_in(formulas) for pair in pairs for x in pair)
        both = f"{A} %not_equals{{1,40}} = %not_equals{{0,6}} {B}"
        return told or LexemePattern(both).found_in(formulas)

    @cached_property
    def _names(self) -> tuple[str, str]:
        told = (
            x for x, own in _PAIRS.items() for y in own if LexemePattern(y).found_in(self.formulas)
        )
        return next(told)

    @cached_property
    def _sign(self) -> int:
        """Sign convention in the answer: 1 for J_a ẋ + J_b θ̇ = 0, -1 for J_a ẋ = J_b θ̇, 0 if it
        does not show."""
        a, b = _PAIRS[self._names]
        ways = f"{a} %not_equals{{0,30}} = &? {b} | = &? {a} @inverse {b}"
        if LexemePattern(ways).found_in(self.formulas):
            return -1
        sum_of_both = f"{a} %any{{0,40}} < %joins {b} | %apart {b} >"
        return int(LexemePattern(sum_of_both).found_in(self.formulas))

    @cached_property
    def _found(self) -> ClosedInputOutput | None:
        if self.setting.system is None:
            return None
        try:
            return self.setting.system.loops.input_output()
        except FreebodyError:  # drives and freedoms do not match
            return None

    @cached_property
    def _tables(self) -> dict[str, QuantityTable]:
        """The entries of J_a, J_b and J as quantities, by the matrix's name."""
        if self._found is None:
            return {}
        a, b = self._names
        sign = self._sign or 1
        rows = self._found.J_a, [[x * sign for x in row] for row in self._found.J_b]
        texts = {a: "the tip", b: "the drives"}
        found = {
            name: self._entries(own, name, (_OF_OTHER.format(_shown(name), texts[name]), other))
            for name, own, other in ((a, *rows), (b, *rows[::-1]))
        }
        found["J"] = [
            [self._of_tip(i, k) for k in range(len(row))] for i, row in enumerate(self._found.J)
        ]
        return found

    def _entries(
        self, rows: PolynomialRows, name: str, mistaken: tuple[str, PolynomialRows]
    ) -> QuantityTable:
        def value(rows: PolynomialRows, i: int, k: int) -> Callable[[], Trig]:
            return self.element(lambda: rows[i][k])

        thought, other = mistaken
        is_b = name == self._names[1]
        n = range(len(rows))
        return [
            [
                AskedQuantity(
                    kinds.INPUT_OUTPUT,
                    (i + 1, k + 1),
                    value(rows, i, k),
                    words=f"entry {i + 1}, {k + 1} of {_shown(name)}",
                    thoughts=((thought, value(other, i, k)), (_TRANSPOSED, value(rows, k, i))),
                    also=(("", lambda i=i, k=k: -value(rows, i, k)()),) * (is_b and not self._sign),
                )
                for k in n
            ]
            for i in n
        ]

    def _of_tip(self, i: int, k: int) -> AskedQuantity:
        """The quantity that is an entry of the Jacobian J between drives and tip."""
        assert self._found is not None
        x = self._found.J[i][k]
        value = self.quotient(lambda: (x.above, x.below))
        words = f"entry {i + 1}, {k + 1} of J, ẋ = J θ̇"
        law = "It has the wrong sign: J_a ẋ + J_b θ̇ = 0 gives J = −J_a⁻¹ J_b."
        thoughts = ((law, lambda: negative(value())),)
        return AskedQuantity(kinds.SOLVED, (i + 1, k + 1), value, words=words, thoughts=thoughts)

    def single(self) -> Iterator[NamedTarget]:
        yield from entries(self._tables)
        if self._found is not None:
            a, b = self._names
            for name, found in ((a, self._found.second), (b, self._found.first)):
                value = self.element(lambda found=found: found.polynomial)
                words = f"the determinant of {_shown(name)}"
                yield (f"det{name}",), AskedQuantity(kinds.DETERMINANT, (), value, words=words)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        if self._found is None:
            return {}
        found = dict(self._tables)
        for name in self._names:
            rows = [[x.polynomial for x in row] for row in found[name]]
            if len(rows) <= MOST_ROWS:
                found[name + INVERSE] = inverse(self.setting, rows, _shown(name))
        tip = [[self._rate_of_tip(k, row)] for k, row in enumerate(self._found.rows, 1)]
        driven = [[self.coordinate(x + RATE, k)] for k, x in enumerate(self._found.driven, 1)]
        of_all = not {"Φ", "\\Phi"}.isdisjoint(self.formulas.places)  # q̇ of Φ_q q̇
        letters = {"x": tip, "X": tip, "p": tip, "t": tip, "theta": driven, "Theta": driven}
        for letter, column in (letters if of_all else {**letters, "q": driven}).items():
            found |= dict.fromkeys(spellings(letter, "", 1), column)
        return {**found, "v": tip}

    def _rate_of_tip(self, k: int, row: str) -> AskedQuantity:
        """The quantity that is a component of the tip's velocity."""
        assert self._found is not None
        symbols = self.setting.equations.symbols
        J = Kinematics(symbols, self._found.frame).J[ROWS[symbols.model.dim].index(row)]
        value = self.element(lambda: inner(J, symbols.own(RATE), symbols))
        return AskedQuantity(kinds.TIP_TWIST, (k,), value)


def _shown(name: str) -> str:
    """Printed name of a matrix, such as J_a."""
    return f"J_{name[1:]}" if len(name) > 1 else name
