"""What a line of an answer states."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.expressions.nodes import Expression
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.reading.circular_answers import GivenQuantity
from freebody_textbook.check.spelling.answer_text import AnswerText


@dataclass(frozen=True)
class Claim:
    """label = what the user says it is."""

    label: str
    target: AskedQuantity
    node: Expression
    value: Value
    source: AnswerText
    uses: tuple[GivenQuantity, ...] = ()
    """Quantities that it is given by."""
    whole: Expression | None = None
    """Of an equation between two sides their difference."""
