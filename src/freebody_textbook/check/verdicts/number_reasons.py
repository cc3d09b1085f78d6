"""What may have gone wrong where a number is not right: what would make it right."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

from freebody.errors import listed
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities.units import si_text
from freebody.outputs.number_text import shortest
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.numbers.states import GivenValue
from freebody_textbook.check.reasons.bodies_at_point import BodiesAtPoint
from freebody_textbook.check.reasons.misconceptions import explaining
from freebody_textbook.check.reasons.thoughts import Subject
from freebody_textbook.check.verdicts.number_at_state import NumberAtState

_ROUNDED_ON_THE_WAY = 0.01
"""A share of the right number by which it may be off because numbers before it were rounded."""

Thought = tuple[str, Callable[[], float]]
"""A sentence, and what the right number would be."""


def reasons(number: NumberAtState, targets: Targets) -> list[str]:
    """What may have been thought: at most two sentences, each of which alone makes it right."""
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
    """Values for which the answer would be right."""
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
    """Numbers of the state that were put in as they are written."""
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
    """Angles in radians that were put into a calculator set to degrees."""
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
