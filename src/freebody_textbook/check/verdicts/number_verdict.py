"""Answers that are numbers at a state: correct to the digits given, or a reason why not, such as
degrees used as radians."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from freebody.errors import listed
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.source import Span
from freebody.expressions.nodes import nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities.units import si_text
from freebody.outputs.number_text import shortest
from freebody.scalars.generators import symbol_of, symbols_in, waves_of
from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import RealPoint
from freebody_textbook.check.algebra.quotients import Named, Value, pair, put
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.numbers.given_states import (
    GivenState,
    GivenValue,
    WrittenNumber,
    WrittenNumbers,
    in_words,
)
from freebody_textbook.check.numbers.units_of_symbols import unit_of_quantity
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reasons.bodies_at_point import BodiesAtPoint
from freebody_textbook.check.reasons.misconceptions import explaining
from freebody_textbook.check.reasons.thoughts import Subject
from freebody_textbook.check.verdict import EquationVerdict, Example, Mistake
from freebody_textbook.check.verdicts.number_at_state import EXACT, NumberAtState
from freebody_textbook.check.verdicts.verdict_sentences import right_verdict

_ROUNDED_ON_THE_WAY = 0.01
"""A share of the right number by which it may be off because numbers before it were rounded."""

Thought = tuple[str, Callable[[], float]]
"""A sentence, and what the right number would be."""


def reasons(number: NumberAtState, targets: Targets) -> list[str]:
    """Sentences, at most two, on mistakes each of which explains a wrong number."""
    found = _right_for(number, _plain_reasons(number))
    target, right = number.claim.target, number.right_value
    if not found and number.yours and number.setting.turned is None and isinstance(right, Trig):
        bodies = BodiesAtPoint(number.setting, number.thought)
        subject = Subject(bodies, targets, target, right)
        found = [f"A possible reason: {text}" for text in explaining(subject, number.yours)]
    found = found or _right_for(number, _other_values(number))
    if not found and abs(number.yours - number.right) <= _ROUNDED_ON_THE_WAY * abs(number.right):
        share = shortest(abs(number.yours / number.right - 1) * 100, 2)
        found = [f"It is off by {share} %: numbers may have been rounded on the way."]
    return list(dict.fromkeys(found))[:2]


def _right_for(number: NumberAtState, tried: Iterator[Thought]) -> list[str]:
    return [text for text, value in tried if number.thought.agree(value(), number.yours)]


def _plain_reasons(number: NumberAtState) -> Iterator[Thought]:
    if unit := number.better_unit():
        yield f"The number would be right in {unit}.", lambda: number.yours
    yield from _conversions(number)
    yield "Only the sign is wrong.", lambda: -number.right


def _other_values(number: NumberAtState) -> Iterator[Thought]:
    """Mistaken values with which the answer would be correct."""
    yield from _of_gravity(number)
    for name, given in number.given.items():
        if given.value and name in number.used:
            yield f"It is right for {sym(name)} = 0.", lambda x=name: number.with_values({x: 0.0})
            yield (
                f"It is right for {sym(name)} with the opposite sign.",
                lambda x=name, v=given.value: number.with_values({x: -v}),
            )
    yield "It is twice the right number.", lambda: 2 * number.right
    yield "It is half the right number.", lambda: number.right / 2


def _conversions(number: NumberAtState) -> Iterator[Thought]:
    """Mistakes of unit conversion: values used in the unit in which they are written."""
    used = {name: x for name, x in number.given.items() if name in number.used}
    units = dict.fromkeys(x.unit.text for x in used.values() if x.unit and x.is_converted)
    for unit in units:
        raw = {n: x.written for n, x in used.items() if x.unit and x.unit.text == unit}
        names = listed(str(sym(name)) for name in raw)
        dimension = next(x.unit.dimension for x in used.values() if x.unit and x.unit.text == unit)
        needed = si_text(dimension, number.setting.turns(next(iter(raw))))
        text = f"{names} must be put in as {needed}, not as {unit}."
        if unit == "°":
            text = f"Degrees were taken for radians: {names} must be put in as radians."
        yield text, lambda raw=raw: number.with_values(raw)
    yield from _radians(number, used)


def _radians(number: NumberAtState, used: Mapping[str, GivenValue]) -> Iterator[Thought]:
    """The mistake of entering angles in radians into a calculator set to degrees."""
    angles = {n: x.value for n, x in used.items() if n in number.setting.ring.angles}
    if angles and not any(used[name].is_converted for name in angles):
        names = listed(str(sym(name)) for name in angles)
        yield (
            f"Radians were taken for degrees: {names} {'are' if len(angles) > 1 else 'is'} in "
            f"radians, so the calculator must be set to radians.",
            lambda: number.with_values({n: math.radians(x) for n, x in angles.items()}),
        )


def _of_gravity(number: NumberAtState) -> Iterator[Thought]:
    g = number.setting.order.gravity
    for value in (9.8, 9.81, 9.82, 10.0):
        if g and g in number.used and number.values[g] != value:
            here = f"here it is {shortest(number.values[g])} m/s²"
            text = f"It is right for g = {value:g} m/s²; {here}."
            yield text, lambda x=value: number.with_values({g: x})


_VAGUE = "the tolerance, or what the digits leave open, is larger than the right number"


@dataclass(frozen=True)
class NumberJudge:
    """Judges claims in numbers by comparing them with the correct values at their states."""

    setting: RightEquations
    targets: Targets
    numbers: WrittenNumbers
    tolerance: float | None = None
    """The share of the right number by which an answer may be off, where not its digits tell it."""

    def verdict(self, claim: Claim, explain: bool) -> EquationVerdict | None:
        """The verdict on a claim that is a number at a state or has a unit; None for other
        claims."""
        written = self.numbers.of(claim.node.span)
        given = self.numbers.state_at(claim.node.span)
        if not (isinstance(claim.value, Trig) and claim.value.is_constant):
            given = self.numbers.state_at(claim.node.span, in_symbols=True)
            return self._in_symbols(claim, written, given)
        no_result = claim.target.kind.is_equation and claim.value.is_zero and written is None
        if no_result or claim.target.idle:
            return None
        number = NumberAtState(self.setting, claim, written, given, self.tolerance)
        if not (written or given or self._lacks_state(number)):
            return None
        if written is None and claim.value.is_zero:
            self._refuse_zero_elsewhere(claim, given)
        return _NumberVerdict(number).verdict(self.targets if explain else None)

    def _refuse_zero_elsewhere(self, claim: Claim, given: GivenState) -> None:
        """Raise an error for a bare 0 after the paragraph of a condition, as it may hold at that
        condition or always."""
        span, right = claim.node.span, claim.target.compute()
        if not self.numbers.is_condition_at(span) or not isinstance(right, Trig):
            return
        here = self.numbers.state_at(span, in_symbols=True)
        others = {x: y for x, y in given.items() if x not in here and x in symbols_in(right)}
        if others:
            claim.source.fail(
                f"{in_words(others)} was said of the paragraph before",
                span,
                "Say it again if 0 is meant there, or give 0 its unit.",
            )

    def is_still(self, span: Span) -> bool:
        """Whether a place in the text refers to a robot in equilibrium."""
        given = self.numbers.state_at(span)
        return all(x in given and given[x].value == 0.0 for x in self._motion)

    def _lacks_state(self, number: NumberAtState) -> bool:
        """Whether a number without unit is a result with its state missing: it is a decimal number,
        or the answer gives states elsewhere."""
        claim, kind = number.claim, number.claim.target.kind
        if kind.is_equation or kind.of_loops == "positions" or claim.value.is_zero:
            return False
        text = claim.source.plain(claim.node.span)
        stated = bool(self.numbers.numbers or self.numbers.standing)
        return number.is_lone and ("." in text or stated) and bool(number.missing)

    def _in_symbols(
        self, claim: Claim, written: WrittenNumber | None, given: GivenState
    ) -> EquationVerdict | None:
        """The verdict on an answer in symbols that is correct only at its state, m₂ g lc₂ cos 75°;
        None if it is correct in general, or wrong."""
        right = claim.target.compute()
        if written is not None:
            needed, unit = unit_of_quantity(self.setting, claim.target, right), written.unit
            other = unit and (unit.factor != 1 or needed not in (None, unit.dimension))
            if other or written.within:
                claim.source.fail(
                    "a tolerance, or a unit other than the quantity's, follows what is not a "
                    "number",
                    written.said,
                    "Give the result in numbers, or the equation in symbols without them.",
                )
        if not given or not isinstance(right, Trig) or not isinstance(claim.value, Trig):
            return None
        same = self._is_same(claim.value, right, given)
        own = symbols_in(claim.value) & set(given)
        by_others = claim.target.kind.is_equation or bool(claim.uses)  # whose motion is in it
        if own and (not by_others or self.has_motion(claim)):
            return None
        if not same or (claim.value - right).is_zero:
            return None
        used = in_words({x: y for x, y in given.items() if x in symbols_in(right) or x in own})
        return right_verdict(claim, f"At {used}.")

    def at_condition(self, claim: Claim, right: Trig) -> tuple[Trig, str]:
        """(correct answer, condition in words) for a line whose condition gives coordinates that
        the line does not contain; for other lines the unchanged answer and ""."""
        used = symbols_in(right)
        given = {
            name: x
            for name, x in self.numbers.state_at(claim.node.span, in_symbols=True).items()
            if name in used
        }
        if not given or symbols_in(*pair(claim.value)) & set(given):
            return right, ""
        ring, zero = self.setting.ring, self.setting.zero
        images: dict[str, Value] = {}
        for name, x in given.items():
            images[name] = zero + Fraction(x.value)
            if name in ring.angles:
                waves = zip(waves_of(name), rational_sin_cos(x.value), strict=True)
                images |= {wave: zero + _simple(value) for wave, value in waves}
        there = put(right, images)
        assert isinstance(there, Trig)
        return there, in_words(given)

    def _is_same(self, yours: Trig, right: Trig, given: GivenState) -> bool:
        """Whether two polynomials are equal at a state."""
        own, put = (self._rows(x, given) for x in (yours, right))
        largest = max(map(abs, put.values()), default=0.0)
        return all(
            abs(own.get(key, 0.0) - put.get(key, 0.0)) <= EXACT * largest for key in own | put
        )

    def is_right_in_equilibrium(self, yours: Trig, right: Trig) -> bool:
        """Whether an answer is correct in equilibrium, when nothing moves."""
        return self._is_same(yours, right, self._in_equilibrium)

    def has_motion(self, claim: Claim) -> bool:
        """Whether an answer contains quantities that vanish only in equilibrium, such as
        accelerations, so that equilibrium cannot decide about their coefficients."""
        return self.has_what_vanishes(claim, self._in_equilibrium)

    def has_what_vanishes(self, claim: Claim, given: GivenState) -> bool:
        """Whether an answer contains quantities that vanish only at its state."""
        single = self.targets.single
        values = (
            x.value
            for x in nodes(claim.node)
            if isinstance(x, Named) and not (x.name in single and single[x.name].kind.is_reaction)
        )
        return any(
            isinstance(x, Trig) and not x.is_zero and self._is_same(self.setting.zero, x, given)
            for x in values
        )

    @property
    def _in_equilibrium(self) -> GivenState:
        return dict.fromkeys(self._motion, GivenValue(0.0, 0.0))

    @property
    def _motion(self) -> list[str]:
        """Names of the rates and accelerations."""
        return [x + dot for x in self.setting.symbols.coordinates for dot in (RATE, SECOND)]

    def _rows(self, x: Trig, given: GivenState) -> dict[frozenset[tuple[str, int]], float]:
        """The terms of a polynomial with the values of a state substituted."""
        values = {name: value.value for name, value in given.items()}
        point = RealPoint.of_state(self.setting.ring, values)
        found: dict[frozenset[tuple[str, int]], float] = {}
        for powers, coefficient in x.terms():
            known = {n: k for n, k in powers.items() if symbol_of(n) in given}
            key = frozenset((n, k) for n, k in powers.items() if n not in known)
            found[key] = found.get(key, 0.0) + point.term(known, coefficient)
        return found

    def unused(self, claims: Sequence[Claim], told: Sequence[Span]) -> Iterator[Span]:
        """Places of written units and states that belong to no result; told: places of parameter
        values."""
        spans = [*(claim.node.span for claim in claims), *told]
        for x in self.numbers.numbers:
            if not any(x.begun <= start and end <= x.span[1] for start, end in spans):
                yield x.said


@dataclass(frozen=True)
class _NumberVerdict:
    """Makes the verdict on one number in words."""

    number: NumberAtState

    def verdict(self, targets: Targets | None) -> EquationVerdict:
        """The verdict on the number in words; with reasons for a wrong number if targets are
        given."""
        number, claim = self.number, self.number.claim
        if number.fits:
            self._refuse_missing()
        if number.fits and math.isnan(number.right):
            claim.source.fail(
                f"{claim.label} has no value {self._where()}: a division by 0", claim.node.span
            )
        if number.fits and number.is_right:
            if number.is_vague:
                claim.source.fail(_VAGUE, claim.node.span)
            return right_verdict(claim, self._note())
        causes = [] if number.fits else [self._other_kind()]
        example = None
        if number.fits:
            causes = reasons(number, targets) if targets else []
            values = {x: number.values[x] for x in number.used if x in number.values}
            example = Example(values, number.yours, number.right)
        if not causes and claim.target.kind.up_to_a_constant:
            causes = ["Here V is 0 at the height of the base's origin; yours may be 0 elsewhere."]
        return EquationVerdict(
            claim.label, claim.target.title, False, (self._mistake(),), tuple(causes), example
        )

    def _refuse_missing(self) -> None:
        """Raise an error for a number whose state is not given."""
        number, claim = self.number, self.number.claim
        if missing := number.missing:
            names = ", ".join(str(sym(x)) for x in missing[:6]) + ", …" * (len(missing) > 6)
            held = " (of an arm that is held still all are 0: at q̇ = 0, q̈ = 0)"
            claim.source.fail(
                f"{claim.label} is a number here, but depends on {names}, which "
                f"{'are' if len(missing) > 1 else 'is'} not given"
                f"{held * all(atom(x).dots for x in missing)}",
                claim.node.span,
                f"State them after the number, at {sym(missing[0])} = …, or by --at "
                f"'{missing[0]} = …', at={{'{missing[0]}': …}}.",
            )

    # ------------------------------------------------------------ words
    def _where(self) -> str:
        """Phrase for the state and the robot whose values determine the correct number."""
        given, used = self.number.given, self.number.used
        here = in_words({name: x for name, x in given.items() if name in used})
        model = self.number.setting.symbols.model
        own = any(x in used and x not in given for x in model.parameters)
        values = f"with the values of {model.name!r}" if own else ""
        return ", ".join(part for part in (here and f"at {here}", values) if part)

    def _right(self) -> str:
        """The correct number in the answer's unit, with one digit more than the answer."""
        number = self.number
        unit = number.unit if number.fits and not self._is_of_another_kind() else None
        value = shortest(number.right / (unit.factor if unit else 1.0), max(4, number.digits + 1))
        text = unit.text if unit else "" if number.needed in (None, (0, 0, 0)) else self._unit()
        return value + " " * (text not in ("", "°")) + text

    def _is_of_another_kind(self) -> bool:
        """Whether a moment is given in joules, or an energy in newton metres: the dimension fits,
        the meaning does not."""
        unit = self.number.unit
        if unit is None or unit.dimension != _ENERGY:
            return False
        return ("J" in unit.text) != (self._unit() == "J")

    def _unit(self) -> str:
        """The unit of the quantity."""
        claim, needed = self.number.claim, self.number.needed
        if needed is None:
            return "a unit that is not known here"
        if claim.target.kind.is_energy:
            return "J"
        return si_text(needed, claim.target.is_angular)

    def _note(self) -> str:
        where = self._where()
        text = f"{where[:1].upper()}{where[1:]}: " if where else ""
        unchecked = self.number.unit is not None and self.number.needed is None
        return f"{text}{self._right()}.{' The unit was not checked.' * unchecked}"

    def _mistake(self) -> Mistake:
        source, span = self.number.claim.source, self.number.claim.node.span
        line, column = source.place(span[0])
        right, where = self._right(), self._where()
        if math.isnan(self.number.right):
            right, where = f"in {self._unit()}", ""
        text = f"‘{source[span]}’ must be {right}{' ' * bool(where)}{where}."
        kind = "number" if self.number.fits else "unit"
        return Mistake(kind, text, source[span], right, line, column, source.caret(span))

    def _other_kind(self) -> str:
        """A sentence on a unit that belongs to another kind of quantity."""
        unit = self.number.unit.text if self.number.unit else ""
        text = f"The units do not fit: {unit}, where {self._unit()} is needed."
        other = self.number.better_unit()
        return f"{text} In {other} the number is right." if other else text


_ENERGY = (1, 2, -2)
"""Powers of kg, m and s in the unit of an energy, and of a moment."""


def _simple(value: Fraction) -> Fraction:
    """A sine or cosine as a fraction; exactly ½ if it is that to floating-point accuracy."""
    simple = value.limit_denominator(2)
    return simple if abs(simple - value) <= EXACT else value
