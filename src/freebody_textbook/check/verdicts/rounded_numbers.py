"""Answers in numbers compared term by term, each number within half a unit of its last digit.

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
from freebody_textbook.check.reasons.differences import (
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
    """An answer that may contain numbers, and the correct one with the model's parameter values."""

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
        """Symbols that are not replaced by values: g, if the answer contains it."""
        g = self.setting.order.gravity
        return frozenset([g] if any(g in powers for powers, _ in self.yours.terms()) else [])

    @cached_property
    def _in_numbers(self) -> frozenset[SymbolPowers]:
        """Products of moving factors whose coefficient in the answer contains no parameter with a
        value, except g."""
        symbols = set(self._constants) - {self.setting.order.gravity}
        return frozenset(
            key
            for key, part in self._parts.items()
            if not any(symbols & set(p) for p, _ in part.terms())
        )

    @cached_property
    def applies(self) -> bool:
        """Whether the answer has a term in numbers where the correct one has parameters with
        values, or omits one that these make 0."""
        for key, part in self._right_parts.items():
            put = self._put(part, self._kept)
            if put != part and (
                key in self._in_numbers or (key not in self._parts and put.is_zero)
            ):
                return True
        return False

    @cached_property
    def target(self) -> Trig:
        """The correct answer, with parameter values substituted in the terms that the answer gives
        in numbers."""
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
        """Whether the answer contains no parameter except g."""
        g = self.setting.order.gravity
        return all(
            not set(powers) - {g} for part in self._parts.values() for powers, _ in part.terms()
        )

    @property
    def is_mixed(self) -> bool:
        """Whether a term mixes symbols and numbers, though its value is correct."""
        return (self._put(self.yours) - self._put(self.right)).is_zero

    def wrong(self, relative: Fraction = _EXACT) -> list[Difference] | None:
        """The terms that differ by more than the digits allow, or by more than a fraction of the
        correct one; None if there are too many terms."""
        if (
            is_too_long(self.yours)
            or is_too_long(self.target)
            or len(self._decimals) > MOST_NUMBERS
        ):
            return None
        slack = self._slack()

        def within(row: Difference) -> Fraction:
            """The difference that the digits of a term allow; 0 if it exceeds the correct number,
            as then almost any number would pass."""
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
        """The decimal numbers in the answer, with half a unit of their last digit."""
        found = {}
        for node in nodes(self.node):
            if isinstance(node, Number):
                half = half_a_unit(self.source[node.span], node.value)
                if half:
                    found[node] = half
        return found

    def _slack(self) -> dict[ProductKey, Fraction]:
        """The change of each numeric term when every number changes by half a unit."""
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
        """Values of parameters by name; for angles those of their sines and cosines.

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
        """A polynomial with parameter values substituted, except for the names kept."""
        known = {name: value for name, value in self._constants.items() if name not in kept}
        rows = []
        for powers, coefficient in x.terms():
            for name in powers.keys() & known.keys():
                coefficient *= known[name] ** powers[name]
            rows.append(({name: k for name, k in powers.items() if name not in known}, coefficient))
        return self.setting.ring.polynomial(rows)


def half_a_unit(text: str, value: Fraction, whole: bool = False) -> Fraction:
    """Half a unit of a number's last digit; for a quotient of numbers the resulting change. whole:
    also for integers other than 0."""
    if whole and value and text.isdigit():
        return Fraction(1, 2)
    relative = Fraction(0)
    for match, figures in numbers(Lexemes.of(text)):
        size = Fraction(match.text) if figures.decimals else 0
        relative += figures.last / 2 / size if size else 0  # 0.0 has no digit to be rounded
    return abs(value) * relative
