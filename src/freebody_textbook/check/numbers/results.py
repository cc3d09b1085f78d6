"""What a document says of its results in numbers: units, tolerances and states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from freebody.expressions.grammar.source import Span
from freebody_textbook.check.numbers.states import GivenState, GivenValue, in_words
from freebody_textbook.check.numbers.written_units import WrittenUnit
from freebody_textbook.check.spelling.answer_text import AnswerError


@dataclass(frozen=True)
class WrittenNumber:
    """What is said behind a number of a document, or behind a vector."""

    span: Span
    """Where it stands."""
    begun: int
    """Where its equation begins, of which the sides before have no unit and the same state."""
    said: Span
    """Where it is said."""
    unit: WrittenUnit | None = None
    within: str = ""
    """A tolerance in the same unit, as it is written; "" where the digits tell it."""
    state: GivenState = field(default_factory=dict[str, GivenValue])


@dataclass(frozen=True)
class StandingState:
    """A state in front of what it holds for."""

    start: int
    """From where it holds."""
    state: GivenState
    is_condition: bool = False
    """Whether it is said of what follows, in symbols too."""
    end: int = 0
    """Where the paragraph ends, behind which it is no condition of equations in symbols; of a robot
    that is held still the whole document."""


@dataclass(frozen=True)
class WrittenNumbers:
    """All of a document, in order."""

    numbers: Sequence[WrittenNumber] = ()
    standing: Sequence[StandingState] = ()
    """States in front of numbers and equations."""
    at: GivenState = field(default_factory=dict[str, GivenValue])
    """The state that is given besides."""

    def refuse_two_states(self) -> None:
        """Refuse a document that says another state than is given besides."""
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
        """The unit, tolerance and state that are said of a number or expression."""
        for x in self.numbers:
            if x.span[0] <= span[0] and span[1] <= x.span[1]:
                return x
        return None

    def state_at(self, span: Span, in_symbols: bool = False) -> GivenState:
        """The state of a number or expression that stands there: what is given besides, what was
        said last, of an expression in symbols in its own paragraph, and what stands behind it or
        behind a later side of its equation."""
        last = self._last_before(span)
        holds = last is not None and not (in_symbols and last.end <= span[0])
        found = {**self.at, **(last.state if last and holds else {})}
        for x in self.numbers:
            if x.begun <= span[0] and span[1] <= x.span[1]:
                found |= x.state
        return found

    def is_condition_at(self, span: Span) -> bool:
        """Whether the state that was said last is a condition of what followed."""
        last = self._last_before(span)
        return last is not None and last.is_condition

    def _last_before(self, span: Span) -> StandingState | None:
        """The state that was said last in front of a place."""
        return next((x for x in reversed(self.standing) if x.start <= span[0]), None)
