"""`check` at random: right answers rewritten are equal, wrong ones never, and what was done to them
is named."""

from __future__ import annotations

import random
from collections import Counter

import pytest

import freebody as fb
from freebody_textbook.check.asked.joints import polynomial
from freebody_textbook.check.asked.right_equations import setting
from support.answers import (
    KINDS,
    WORDS,
    Mistake,
    Writer,
    mistake,
    model,
    named,
    quantities,
    rewritten,
)

SHORT, LONG = 40, 1000


def are_equal(count: int) -> None:
    for k in range(count):
        rng = random.Random(f"equal {k}")
        word = rng.choice(WORDS)
        name, right = rng.choice(quantities(word))
        answer = Writer(rng, word).equation(name, rewritten(rng, right))
        verdict = fb.check(model(word)[0], answer)
        assert verdict, f"{k}: {word}: {answer}\n{verdict.text}"


def mistakes(count: int) -> list[tuple[random.Random, str, str, Mistake]]:
    """That many wrong answers; those that a mistake left equal are passed over."""
    found = []
    k = 0
    while len(found) < count:
        rng = random.Random(f"wrong {k}")
        word = rng.choice(WORDS)
        name, right = rng.choice(quantities(word))
        made = mistake(rng, word, right, rng.choice(KINDS))
        k += 1
        if made is None:
            continue
        where = setting(model(word)[1])
        change = polynomial(where, made.answer) - polynomial(where, made.right)
        constant = name == "V" and all(
            change.derivative(x).is_zero for x in where.symbols.coordinates
        )
        if not change.is_zero and not constant:
            found.append((rng, word, name, made))
    return found


def share_named(count: int, steps: int) -> float:
    """Of answers with one mistake, rewritten as students do: the share in which it is named."""
    lost: Counter[str] = Counter()
    for rng, word, name, made in mistakes(count):
        answer = Writer(rng, word).equation(name, rewritten(rng, made.answer, steps, odd=False))
        verdict = fb.check(model(word)[0], answer)
        assert not verdict, f"{word}: {answer}: {made.kind}, {made.old} -> {made.new}"
        lost[made.kind] += not named(setting(model(word)[1]), verdict, made)
    print(f"not named: {dict(lost)} of {count}")
    return 1 - lost.total() / count


def test_rewritten_answers_are_equal():
    are_equal(SHORT)


def test_mistakes_are_found_and_named():
    assert share_named(SHORT, steps=0) >= 0.95


@pytest.mark.long
def test_many_rewritten_answers_are_equal():
    are_equal(LONG)


@pytest.mark.long
@pytest.mark.parametrize("steps", [0, 3])
def test_many_mistakes_are_found_and_named(steps: int):
    assert share_named(LONG, steps) >= 0.95
