"""States for answers in numbers: θ₁ = 30°, θ̇₁ = 2 rad/s, m₁ = 1.5 kg, as written in a document or
given as at=; and the units, tolerances and states of a document's results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeVar

from freebody.errors import FreebodyError
from freebody.expressions.grammar import words
from freebody.expressions.grammar.lexer import tokens
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.source import Source, Span
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities.units import si_text
from freebody.identifiers import word_set
from freebody.model.parameter_formulas import inertial_names
from freebody.outputs.display import counted
from freebody.outputs.number_text import shortest
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.quotients import generator
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.numbers.units_of_symbols import unit_of
from freebody_textbook.check.numbers.written_units import WrittenUnit, unit_at
from freebody_textbook.check.reading.reading import AnswerParser
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerError, AnswerText

_VALUE = LexemePattern("@value")
_BETWEEN = LexemePattern("< & | %line >*")
_EQUALS = LexemePattern("< & | %line >* = < & | %line >*")
_OPENING = LexemePattern("( | [ | %begin")
_CLOSING = LexemePattern("< ) | ] | %end > ᵀ?")
_SEPARATOR = LexemePattern("< %line | & | , | ; | %row >*")
_GOES_ON = LexemePattern("~%name_or_power | ~( | ~_ | %joining | %minus ~")
AT_REST = LexemePattern("@at_rest < ,? < at | with > &%apart >?")
_COMMA = LexemePattern("~, ~%digit")
_NEXT = LexemePattern("%line* < , | ; | and >? %line* and?")


@dataclass(frozen=True)
class GivenValue:
    """The value of a symbol, in SI units and in the units written."""

    value: float
    written: float
    unit: WrittenUnit | None = None

    @property
    def is_converted(self) -> bool:
        """Whether the value is written in another unit than the SI unit."""
        return self.unit is not None and self.unit.factor != 1.0


GivenState = Mapping[str, GivenValue]
"""Values of a state by names of generators."""
NO_STATE = word_set(
    "not except unless never near minus plus twice half delta δ cot sec csc exp log ln"
)
"""Words after which a value is not that of the coordinate that follows."""
_GivenItem = TypeVar("_GivenItem")


def in_words(state: GivenState) -> str:
    """Text of a state, such as θ₁ = 30°, θ̇₁ = 2 rad/s."""
    return ", ".join(f"{sym(name)} = {_with_unit(x)}" for name, x in state.items())


def _with_unit(given: GivenValue) -> str:
    unit = given.unit.text if given.unit else ""
    return shortest(given.written) + (" " * (unit != "°") + unit if unit else "")


@dataclass(frozen=True)
class StateReader:
    """Reads assignments of values to the model's symbols."""

    vocabulary: Vocabulary
    targets: Targets

    # ------------------------------------------------------------ at=
    def given(self, at: Mapping[str, Any] | str | None) -> GivenState:
        """The state given as at=, a text, or numbers and texts by name; raises AnswerError."""
        if at is None:
            return {}
        if isinstance(at, str):
            return self._of_text(at)
        if not isinstance(at, Mapping):
            raise AnswerError(f"at: {at!r} is neither text nor a dict such as {{'theta1': 0.5}}")
        found: dict[str, GivenValue] = {}
        for name, value in at.items():
            try:
                text = value if isinstance(value, str) else repr(float(value))
            except (TypeError, ValueError, OverflowError):
                raise AnswerError(
                    f"at: {name!r} is neither a number nor a text such as '30 deg'"
                ) from None
            _join(found, self._of_text(f"{name} = {text}"))
        return found

    def _of_text(self, text: str) -> GivenState:
        source = AnswerText.of(text)
        found, end = self.list_at(source, 0)
        rest = [
            x for x in source.lexemes[end:] if x.kind != "line" and x.text not in (".", ",", ";")
        ]
        if not found or rest:
            begun = source.text[rest[0].start :] if found else text
            name = begun.partition("=")[0].strip(" ,;\n") or text
            raise AnswerError(
                f"at: {name[:40]!r} gives no symbol of {self._model.name!r} a value",
                f"Write, for example, theta1 = 30 deg, theta1_d = 2 rad/s. Symbols: "
                f"{', '.join(self.vocabulary.listed[:24])}.",
            )
        for name, given in found.items():
            own = self._model.parameters.get(name)
            if own is not None and abs(own - given.value) > 1e-9 * abs(own):
                raise AnswerError(
                    f"at: {name} = {shortest(given.value)}, and in {self._model.name!r} it is "
                    f"{shortest(own)}"
                )
        return found

    @property
    def _model(self) -> Any:
        return self.vocabulary.setting.symbols.model

    # ------------------------------------------------------------ text
    def list_at(self, source: Source, at: int) -> tuple[dict[str, GivenValue], int]:
        """The assignments that begin at a lexeme, and the index of the lexeme after the last; ({},
        `at`) if there are none."""
        found: dict[str, GivenValue] = {}
        end = at
        while (one := self._one(source, at)) is not None:
            values, end = one
            _join(found, values)
            at = _NEXT.end(source.lexemes, end)
        return found, end

    def _one(self, source: Source, at: int) -> tuple[dict[str, GivenValue], int] | None:
        """One assignment, θ1 = θ2 = 30°, or "at rest", or "in equilibrium" where accelerations are
        0 too; None if there is none."""
        lexemes = source.lexemes
        rest = AT_REST.at(lexemes, _BETWEEN.end(lexemes, at))
        if rest:
            zero = (RATE, SECOND) if "still" in rest else (RATE,)
            coordinates = self.vocabulary.setting.symbols.coordinates
            moving = (x + dot for x in coordinates for dot in zero)
            return dict.fromkeys(moving, GivenValue(0.0, 0.0)), rest.stop
        names: list[list[str]] = []
        while (named := self._named(source, _BETWEEN.end(lexemes, at))) is not None:
            own, end = named
            equals = _EQUALS.at(lexemes, end)
            if equals is None:
                break
            names, at = [*names, own], equals.stop
        found = self._values(source, at, max(map(len, names))) if names else None
        if found is None:
            return None
        values, end = found
        behind = self._names(source, _BETWEEN.end(lexemes, end))
        if _GOES_ON.at(lexemes, end) or (behind and not _EQUALS.at(lexemes, behind[1])):
            return None  # θ1 = 2 θ2
        state = {x: given for own in names for x, given in zip(own, values, strict=False)}
        span = _span(source, at, end)
        for name, given in state.items():
            self._refuse_unit(source, name, given, span)
            if given.value < 0 and (what := inertial_names(self._model).get(name)):
                source.fail(f"{sym(name)} is negative; a {what} is never negative", span)
        return state, end

    def _named(self, source: Source, at: int) -> tuple[list[str], int] | None:
        """The symbols that a name or a list of names means, and the lexeme after it; None if there
        is none."""
        several = _listed(source, at, lambda k: self._names(source, k))
        if several is None:
            return self._names(source, at)
        return [name for own in several[0] for name in own], several[1]

    def _values(self, source: Source, at: int, count: int) -> tuple[list[GivenValue], int] | None:
        """The values of several symbols, or one value for all, and the lexeme after them: 30°, [30,
        45]°."""
        several = _listed(source, at, lambda k: self._value(source, k))
        if several is None:
            number = _VALUE.at(source.lexemes, at)
            if number and _COMMA.at(source.lexemes, number.stop):
                source.fail("a decimal comma: write a point", _span(source, at, number.stop + 2))
            one = self._value(source, at)
            return one and ([one[0]] * count, one[1])
        values, end = several
        if len(values) != count:
            given = counted(len(values), "value")
            source.fail(f"{given} for {counted(count, 'symbol')}", _span(source, at, end))
        unit = unit_at(source.lexemes, end)
        if unit is None or any(x.unit for x in values):
            return values, end
        return [GivenValue(x.written * unit[0].factor, x.written, unit[0]) for x in values], unit[1]

    def _value(self, source: Source, at: int) -> tuple[GivenValue, int] | None:
        """The number at a lexeme with its unit, and the index of the lexeme after them; None if
        there is no number."""
        value = _VALUE.at(source.lexemes, at)
        number = self._number(source, value.span) if value else None
        if value is None or number is None:
            return None
        unit = unit_at(source.lexemes, value.stop)
        given = GivenValue(number * (unit[0].factor if unit else 1.0), number, unit and unit[0])
        return given, unit[1] if unit else value.stop

    def _names(self, source: Source, at: int) -> tuple[list[str], int] | None:
        """The symbols of one name (q̇ means all rates), and the lexeme after it."""
        lexemes = source.lexemes
        if at >= len(lexemes) or not words.begins(x := lexemes[at]):
            return None
        if {x.command, x.command.lower()} & {*self.vocabulary.functions, *NO_STATE}:
            return None  # \cos θ₂
        try:
            word = words.spell(source, at)
        except FreebodyError:
            return None
        value = self.vocabulary.symbols.get(word.plain)
        table = self.targets.tables.get(word.plain)
        values = [value] if value is not None else []
        if value is None and table is not None and table[0][0].kind.is_coordinate:
            values = [row[0].compute() for row in table]
        names = [generator(value) for value in values]
        own = [name for name in names if name]
        return (own, word.at) if own and len(own) == len(names) else None

    def _number(self, source: Source, span: tuple[int, int]) -> float | None:
        try:
            parser = AnswerParser(
                source, tokens(source, self.vocabulary, span)[:-1], self.vocabulary, lambda n: None
            )
            ring = self.vocabulary.setting.ring
            return float(Fraction(PolynomialReader(source, ring).read(parser.side()).fraction))
        except FreebodyError:
            return None

    def _refuse_unit(
        self, source: Source, name: str, given: GivenValue, span: tuple[int, int]
    ) -> None:
        """Raise an error for a value in a unit that its symbol cannot have."""
        needed = unit_of(self.vocabulary.setting, {name: 1})
        if given.unit is not None and needed is not None and given.unit.dimension != needed:
            unit = si_text(needed, self.vocabulary.setting.turns(name))
            source.fail(f"{sym(name)} is given in {given.unit.text}, and has the unit {unit}", span)


def _listed(
    source: Source, at: int, read: Callable[[int], tuple[_GivenItem, int] | None]
) -> tuple[list[_GivenItem], int] | None:
    """Values of a list in brackets, and the lexeme after it."""
    lexemes = source.lexemes
    opened = _OPENING.at(lexemes, at)
    if opened is None:
        return None
    found, at = list[_GivenItem](), opened.stop
    while (one := read(_SEPARATOR.end(lexemes, at))) is not None:
        found.append(one[0])
        at = one[1]
    closed = _CLOSING.at(lexemes, at)
    return (found, closed.stop) if closed and found else None


def _span(source: Source, start: int, stop: int) -> Span:
    """Text span of a range of lexemes."""
    lexemes = source.lexemes
    return lexemes[start].start, lexemes[min(stop, len(lexemes)) - 1].end


def _join(found: dict[str, GivenValue], values: GivenState) -> None:
    for name, given in values.items():
        if name in found and found[name].value != given.value:
            raise AnswerError(
                f"{sym(name)} is given twice, {_with_unit(found[name])} and {_with_unit(given)}"
            )
        found[name] = given


@dataclass(frozen=True)
class WrittenNumber:
    """A number or numeric vector in a document, with the unit, tolerance and state written after
    it."""

    span: Span
    """Place of the number in the text."""
    begun: int
    """The begin of its equation, of which the sides before have no unit and the same state."""
    said: Span
    """The place where unit and state are said."""
    unit: WrittenUnit | None = None
    within: str = ""
    """A tolerance in the same unit, as it is written; "" where the digits tell it."""
    state: GivenState = field(default_factory=dict[str, GivenValue])


@dataclass(frozen=True)
class StandingState:
    """A state that is written before the results for which it holds."""

    start: int
    """The place from which it holds."""
    state: GivenState
    is_condition: bool = False
    """Whether it is said of what follows, in symbols too."""
    end: int = 0
    """The end of the paragraph, behind which it is no condition of equations in symbols; the end of
    the document for a robot that is held still."""


@dataclass(frozen=True)
class WrittenNumbers:
    """The numbers of a document and the states written in it, in order."""

    numbers: Sequence[WrittenNumber] = ()
    standing: Sequence[StandingState] = ()
    """States in front of numbers and equations."""
    at: GivenState = field(default_factory=dict[str, GivenValue])
    """The state that is given besides."""

    def refuse_two_states(self) -> None:
        """Raise an error if a document contains a state that differs from the one given by at=."""
        said = [x.state for x in self.standing] + [x.state for x in self.numbers]
        for name, given in self.at.items():
            other = next(
                (x[name] for x in said if name in x and x[name].value != given.value), None
            )
            if other is not None:
                raise AnswerError(
                    f"at: {in_words({name: given})}, but the answer says {in_words({name: other})}"
                )

    def of(self, span: Span) -> WrittenNumber | None:
        """The written number that contains a span, with unit, tolerance and state; None if there is
        none."""
        for x in self.numbers:
            if x.span[0] <= span[0] and span[1] <= x.span[1]:
                return x
        return None

    def state_at(self, span: Span, in_symbols: bool = False) -> GivenState:
        """The state for a number or expression at a place: the state given by at=, the last one
        written before it (for expressions in symbols within the same paragraph), and the one
        written after it or after a later side of its equation."""
        last = self._last_before(span)
        holds = last is not None and not (in_symbols and last.end <= span[0])
        found = {**self.at, **(last.state if last and holds else {})}
        for x in self.numbers:
            if x.begun <= span[0] and span[1] <= x.span[1]:
                found |= x.state
        return found

    def is_condition_at(self, span: Span) -> bool:
        """Whether the last state written before a place is a condition for what follows."""
        last = self._last_before(span)
        return last is not None and last.is_condition

    def _last_before(self, span: Span) -> StandingState | None:
        """The last state written before a place."""
        return next((x for x in reversed(self.standing) if x.start <= span[0]), None)
