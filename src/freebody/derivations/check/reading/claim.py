"""What a line of an answer states."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.derivations.check.algebra.quotients import Value
from freebody.derivations.check.asked.quantity import AskedQuantity
from freebody.derivations.check.reading.circular_answers import GivenQuantity
from freebody.derivations.check.spelling.answer_text import AnswerText
from freebody.derivations.expressions.nodes import Expression


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
