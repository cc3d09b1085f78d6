"""Claims, the statements of an answer's lines, and the quantities by which they are given, with
their correct values. A claim given by itself is empty."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from freebody.expressions.grammar.source import Source, Span
from freebody.expressions.nodes import Expression, nodes
from freebody_textbook.check.algebra.quotients import Named, Value
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerText


@dataclass(frozen=True)
class GivenQuantity:
    """A quantity named in a piece of an answer, and the place of the piece."""

    target: AskedQuantity
    span: Span


@dataclass(frozen=True)
class Claim:
    """The claim that a quantity equals an expression."""

    label: str
    target: AskedQuantity
    node: Expression
    value: Value
    source: AnswerText
    uses: tuple[GivenQuantity, ...] = ()
    """The quantities that it is given by."""
    whole: Expression | None = None
    """The difference of the sides, where it is an equation between two of them."""


def uses(
    node: Expression, quantities: Mapping[str, AskedQuantity], vocabulary: Vocabulary
) -> Iterator[GivenQuantity]:
    """The quantities in an expression tree, including those in the definitions of users' own
    names."""
    for part in nodes(node):
        if not isinstance(part, Named):
            continue
        if part.name in vocabulary.uses:
            yield from (GivenQuantity(target, part.span) for target in vocabulary.uses[part.name])
        elif part.name in quantities and part.name not in vocabulary.symbols:
            yield GivenQuantity(quantities[part.name], part.span)


def refuse_circles(
    source: Source, claims: Sequence[Claim], last: Sequence[Claim] | None = None
) -> None:
    """Raise an error if a quantity is defined by itself, directly or through other lines; last: the
    only claims that may close a circle, if known."""
    given: dict[AskedQuantity, list[AskedQuantity]] = {}
    label: dict[AskedQuantity, str] = {}
    for claim in claims:
        given.setdefault(claim.target, []).extend(use.target for use in claim.uses)
        label.setdefault(claim.target, claim.label)
    for claim in claims if last is None else last:
        for use in claim.uses:
            way = _way(use.target, claim.target, given)
            if way is None:
                continue
            through = [label[target] for target in way if target != claim.target]
            by = f" by way of {', '.join(through)}" if through else ""
            refuse_itself(source, claim.label, use.span, by)


def refuse_itself(source: Source, label: str, span: Span, by: str = "") -> NoReturn:
    """Raise the error that something is defined by itself."""
    source.fail(
        f"{label} is defined by itself{by}: the equation holds for any value, so there is nothing "
        f"to check",
        span,
        "Write it in the model's symbols.",
    )


def _way(
    start: AskedQuantity,
    goal: AskedQuantity,
    given: Mapping[AskedQuantity, Iterable[AskedQuantity]],
) -> list[AskedQuantity] | None:
    """The chain of definitions that leads from one quantity to another; None if there is none."""
    before: dict[AskedQuantity, AskedQuantity | None] = {start: None}
    waiting = [start]
    for target in waiting:
        if target == goal:
            way: list[AskedQuantity] = []
            step: AskedQuantity | None = target
            while step is not None:
                way.insert(0, step)
                step = before[step]
            return way
        for other in given.get(target, ()):
            if other not in before:
                before[other] = target
                waiting.append(other)
    return None
