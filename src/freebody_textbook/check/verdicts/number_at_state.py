"""A number of an answer and the correct one at the same state, with the allowed difference."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.lexer import numbers
from freebody.expressions.nodes import Number, nodes
from freebody.expressions.nodes import replaced as with_nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.outputs.number_text import shortest
from freebody.scalars.generators import SIGN, function_of, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.finite_field import RealPoint
from freebody_textbook.check.algebra.quotients import Value, pair
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.numbers.states import GivenState, WrittenNumber
from freebody_textbook.check.numbers.units_of_symbols import Unit, unit_of_quantity
from freebody_textbook.check.numbers.written_units import WrittenUnit, common_units
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.states.completed_state import completed
from freebody_textbook.check.verdicts.rounded_numbers import half_a_unit
from freebody_textbook.closed_chains.first_kind import is_multiplier

EXACT = 1e-9
"""The share by which numbers may be apart beyond their digits."""
_VAGUE = 0.05
"""The share by which a number may be off where a reason is sought: half a unit of two digits."""


@dataclass(frozen=True)
class NumberAtState:
    """A claim in numbers, with the correct number at its state."""

    setting: RightEquations
    claim: Claim
    written: WrittenNumber | None
    given: GivenState
    tolerance: float | None = None
    """The share of the right number by which the answer may be off, where not its digits say."""

    @cached_property
    def right_value(self) -> Value:
        """The correct answer in symbols."""
        return self.claim.target.compute()

    @cached_property
    def values(self) -> dict[str, float]:
        """Known values of names in SI units."""
        model = self.setting.symbols.model.parameters
        known = {name: float(value) for name, value in model.items() if value is not None}
        for name, given in self.given.items():
            if name in known and abs(known[name] - given.value) > EXACT * abs(known[name]):
                self.claim.source.fail(
                    f"{sym(name)} is {shortest(given.value)} here, and {shortest(known[name])} in "
                    f"{self.setting.symbols.model.name!r}",
                    self.written.said if self.written else self.claim.node.span,
                    f"Check against a robot that has your value, model.bind({name}=…).",
                )
        values = {**known, **{n: x.value for n, x in self.given.items()}}
        return _with_signs(self.setting, {**completed(self.setting, values), **values})

    @cached_property
    def right(self) -> float:
        """The correct number in SI units."""
        right = self.point.of(self.right_value)
        return 0.0 if abs(right) <= self._noise else right

    @property
    def unit(self) -> WrittenUnit | None:
        """The unit in which the answer is written."""
        return self.written.unit if self.written else None

    @cached_property
    def factor(self) -> float:
        """The factor to SI units of the unit in which the answer is written."""
        return self.unit.factor if self.unit else 1.0

    @property
    def _number(self) -> Trig:
        assert isinstance(self.claim.value, Trig)
        return self.claim.value

    @cached_property
    def yours(self) -> float:
        """The answer's number in SI units."""
        return float(self._number.fraction) * self.factor

    @cached_property
    def point(self) -> RealPoint:
        """The point of the state, with the allowed difference between numbers."""
        point = RealPoint.of_state(self.setting.ring, self.values)
        return replace(point, slack=self._slack(point) + self._noise)

    @cached_property
    def _noise(self) -> float:
        """Rounding error that remains where terms cancel, as in cos 90°."""
        return EXACT * (self._size + abs(self.yours))

    @cached_property
    def _size(self) -> float:
        """Sum of the absolute values of the correct number's terms."""
        point = RealPoint.of_state(self.setting.ring, self.values)
        above, below = pair(self.right_value)
        size = sum(abs(point.term(powers, c)) for powers, c in above.terms())
        return size / (abs(point.of(below)) or math.nan)

    @property
    def is_right(self) -> bool:
        """Whether the numbers agree to the digits given, or within the tolerance."""
        return self.point.agree(self.yours, self.right)

    @property
    def is_vague(self) -> bool:
        """Whether the digits or the tolerance allow more than the size of the correct number's
        terms, so that almost any number would pass."""
        exactly = replace(self.point, slack=self._noise).agree(self.yours, self.right)
        return not exactly and self.point.slack > self._size + self._noise

    @cached_property
    def thought(self) -> RealPoint:
        """The point of the state with a smaller tolerance, used when explaining a wrong number: to
        one digit too many explanations would fit."""
        largest = abs(self.yours) + abs(self.right)
        slack = min(self.point.slack, _VAGUE * abs(self.yours) + EXACT * largest)
        return replace(self.point, slack=slack)

    def _slack(self, point: RealPoint) -> float:
        """The allowed difference: half a unit of the last digit, or the given tolerance."""
        if self.written and self.written.within:
            return float(self.written.within) * self.factor
        if self.tolerance is not None:
            return self.tolerance * abs(point.of(self.right_value))
        return self.factor * self._of_digits()

    def _of_digits(self) -> float:
        """The change of the answer when each of its numbers changes by half a unit of its last
        digit."""
        root, source = self.claim.node, self.claim.source
        total = 0.0
        for node in nodes(root):
            if isinstance(node, Number):
                half = half_a_unit(source.plain(node.span), node.value, self.is_lone)
                new = with_nodes(root, {node: replace(node, value=node.value + half)})
                changed = PolynomialReader(source, self.setting.ring).read(new)
                total += abs(float((changed - self._number).fraction))
        return total

    @property
    def is_lone(self) -> bool:
        """Whether the answer is a single number, possibly with a sign."""
        return sum(1 for node in nodes(self.claim.node) if not node.parts) == 1

    @property
    def digits(self) -> int:
        """The number of significant digits in the answer; four if it is computed from several
        numbers."""
        written = numbers(Lexemes.of(self.claim.source.plain(self.claim.node.span)))
        return next((x.digits for _, x in written), 4) if self.is_lone else 4

    @property
    def fits(self) -> bool:
        """Whether the unit fits the quantity."""
        return self.unit is None or self.needed in (None, self.unit.dimension)

    @cached_property
    def needed(self) -> Unit | None:
        """The unit of the quantity, if it is known."""
        return unit_of_quantity(self.setting, self.claim.target, self.right_value)

    @cached_property
    def used(self) -> list[str]:
        """Names of symbols in the correct answer."""
        return self._symbols(lambda powers: True)

    @property
    def missing(self) -> list[str]:
        """The symbols without a value on which the correct number depends at this state; for a
        multiplier those of the driven joints, from which it follows."""
        point = RealPoint.of_state(self.setting.ring, self.values)
        counting = self._symbols(lambda powers: all(point.generator(x) != 0.0 for x in powers))
        left = [name for name in counting if name not in self.values]
        model, names = self.setting.symbols.model, self.setting.symbols.coordinates
        driven = [x for k, x in enumerate(names) if k not in model.passive]
        moving = (x + ending for ending in ("", RATE, SECOND) for x in driven)
        unknown = [x for x in moving if x not in self.values]
        by_motion = unknown and left and all(map(is_multiplier, left))
        return unknown if by_motion else left

    def _symbols(self, counts: Callable[[Mapping[str, int]], bool]) -> list[str]:
        """The symbols in the terms for which `counts` is true."""
        rows = (powers for part in pair(self.right_value) for powers, _ in part.terms())
        names = {symbol_of(name) for powers in rows if counts(powers) for name in powers}
        return [x for x in self.setting.ring.names if x in names]

    def better_unit(self) -> str:
        """The unit in which the number would be correct; "" if there is none."""
        for other in common_units(self.needed) if self.needed else []:
            scale = other.factor / self.factor
            point = replace(self.point, slack=self.point.slack * scale)
            same = scale == 1 and self.fits
            if not same and point.agree(self.yours * scale, self.right):
                return other.text
        return ""

    def with_values(self, changed: Mapping[str, float]) -> float:
        """The correct number with some values changed."""
        values = _with_signs(self.setting, {**self.values, **changed})
        return RealPoint.of_state(self.setting.ring, values).of(self.right_value)


def _with_signs(setting: RightEquations, values: dict[str, float]) -> dict[str, float]:
    """Values extended by the signs of rates, which friction terms contain."""
    signs = {
        name: float((values[rate] > 0) - (values[rate] < 0))
        for name in setting.ring.names
        if function_of(name) == SIGN and (rate := symbol_of(name)) in values
    }
    return {**values, **signs}
