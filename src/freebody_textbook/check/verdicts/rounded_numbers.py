"""Answers in numbers: compared term by term, each number read to half a unit of its last digit.

A term may be written in numbers where the model has values. With what moves in it, a term is either
in symbols or in numbers: in m2 0.2 g cos θ2 no one can tell whether 0.2 is meant for lc2. Only g
may stay.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from freebody.errors import FreebodyError
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.lexer import numbers
from freebody.expressions.grammar.source import Source
from freebody.expressions.nodes import Expression, Number, nodes, replaced
from freebody.expressions.polynomials.angle_sums import SymbolPowers
from freebody.lazy import cached_property
from freebody.scalars.rational import exactly, rational_sin_cos
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reasons.polynomial_differences import (
    Difference,
    Parts,
    ProductKey,
    differences,
    is_too_long,
    parts,
    terms,
    whole,
)

MEASURED = Fraction(1, 1000)
"""The share by which a term may be off where the model's numbers are measured ones."""
MOST_NUMBERS = 60

_EXACT = Fraction(1, 10**9)


@dataclass(frozen=True)
class Rounded:
    """An answer that may be in numbers, and the right one with the values of the model's
    parameters."""

    setting: RightEquations
    source: Source
    node: Expression
    yours: Trig
    right: Trig
    values: Mapping[str, float]

    @cached_property
    def _parts(self) -> Parts:
        return parts(self.setting, self.yours)

    @cached_property
    def _right_parts(self) -> Parts:
        return parts(self.setting, self.right)

    @cached_property
    def _kept(self) -> frozenset[str]:
        """Symbols that stay symbols: g, where the answer has it."""
        g = self.setting.order.gravity
        return frozenset([g] if any(g in powers for powers, _ in self.yours.terms()) else [])

    @cached_property
    def _in_numbers(self) -> frozenset[SymbolPowers]:
        """The products of the answer with which no parameter stands that has a value, g apart."""
        symbols = set(self._constants) - {self.setting.order.gravity}
        return frozenset(
            key
            for key, part in self._parts.items()
            if not any(symbols & set(p) for p, _ in part.terms())
        )

    @cached_property
    def applies(self) -> bool:
        """Whether a term is in numbers where the right one has symbols with values, or left out as
        these make it 0."""
        for key, part in self._right_parts.items():
            put = self._put(part, self._kept)
            if put != part and (
                key in self._in_numbers or (key not in self._parts and put.is_zero)
            ):
                return True
        return False

    @cached_property
    def target(self) -> Trig:
        """The right answer, in numbers wherever the user's is."""
        if not self.applies:
            return self.right
        return whole(
            self.setting,
            {
                key: part
                if key in self._parts.keys() - self._in_numbers
                else self._put(part, self._kept)
                for key, part in self._right_parts.items()
            },
        )

    @cached_property
    def is_in_numbers(self) -> bool:
        """Whether the answer holds no parameter at all, g apart."""
        g = self.setting.order.gravity
        return all(
            not set(powers) - {g} for part in self._parts.values() for powers, _ in part.terms()
        )

    @property
    def is_mixed(self) -> bool:
        """Whether symbols and numbers in one term give the right number."""
        return (self._put(self.yours) - self._put(self.right)).is_zero

    def wrong(self, relative: Fraction = _EXACT) -> list[Difference] | None:
        """The terms that differ by more than the digits given, or a share of the right one; None:
        too long."""
        if (
            is_too_long(self.yours)
            or is_too_long(self.target)
            or len(self._decimals) > MOST_NUMBERS
        ):
            return None
        slack = self._slack()

        def within(row: Difference) -> Fraction:
            """The change that the digits leave open; none where that is more than the right number,
            so that nearly any would do."""
            half = slack.get(row.key, Fraction(0))
            return half if half <= abs(row.right) else Fraction(0)

        return [
            row
            for row in differences(self.setting, self.yours, self.target)
            if row.instead is not None
            or abs(row.yours - row.right) > within(row) + relative * abs(row.right)
        ]

    # ------------------------------------------------------------ digits
    @cached_property
    def _decimals(self) -> dict[Number, Fraction]:
        """Numbers with digits behind the point, and half a unit of the last one."""
        found = {}
        for node in nodes(self.node):
            if isinstance(node, Number):
                half = half_a_unit(self.source[node.span], node.value)
                if half:
                    found[node] = half
        return found

    def _slack(self) -> dict[ProductKey, Fraction]:
        """Change of each term in numbers when every number is half a unit off."""
        total: dict[ProductKey, Fraction] = {}
        for node, half in self._decimals.items():
            moved = replaced(self.node, {node: replace(node, value=node.value + half)})
            try:
                change = PolynomialReader(self.source, self.setting.ring).read(moved) - self.yours
            except FreebodyError:  # the number stands in an angle
                continue
            rows = {
                key: x for key, x in parts(self.setting, change).items() if key in self._in_numbers
            }
            for key, value in terms(self.setting, whole(self.setting, rows)).items():
                total[key] = total.get(key, Fraction(0)) + abs(value)
        return total

    # ------------------------------------------------------------ values
    @cached_property
    def _constants(self) -> dict[str, Fraction]:
        """Parameters by name; of those that are angles the sines and cosines.

        A factor 1 leaves no trace: among symbols it may have been forgotten.
        """
        found: dict[str, Fraction] = {}
        for name, value in self.values.items():
            if abs(value) == 1 and not self.is_in_numbers:
                continue
            if name in self.setting.ring.angles:
                s, c = rational_sin_cos(value)
                found |= {f"sin_{name}": Fraction(s), f"cos_{name}": Fraction(c)}
            found[name] = exactly(value)
        return found

    def _put(self, x: Trig, kept: Collection[str] = ()) -> Trig:
        """A polynomial with the parameters' values, but for those kept."""
        known = {name: value for name, value in self._constants.items() if name not in kept}
        rows = []
        for powers, coefficient in x.terms():
            for name in powers.keys() & known.keys():
                coefficient *= known[name] ** powers[name]
            rows.append(({name: k for name, k in powers.items() if name not in known}, coefficient))
        return self.setting.ring.polynomial(rows)


def half_a_unit(text: str, value: Fraction, whole: bool = False) -> Fraction:
    """Half a unit of the last digit of a number; of a quotient of numbers, what that makes of it.
    whole: also of a whole number, but for 0."""
    if whole and value and text.isdigit():
        return Fraction(1, 2)
    relative = Fraction(0)
    for match, figures in numbers(Lexemes.of(text)):
        size = Fraction(match.text) if figures.decimals else 0
        relative += figures.last / 2 / size if size else 0  # 0.0 has no digit to be rounded
    return abs(value) * relative
