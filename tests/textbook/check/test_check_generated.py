"""`check` at random, from a seeded generator over arms, methods and their lines: right answers
rewritten are accepted, planted errors caught and named, hostile ones harmless; in equations of
motion, in the lines on the way, and in whole documents."""

from __future__ import annotations

import contextlib
import random
import time
from collections import Counter
from pathlib import Path

import pytest

import freebody as fb
from freebody_textbook.check.asked.joints import polynomial
from freebody_textbook.check.asked.right_equations import setting
from support.answer_documents import CODE, LATEX, MARKDOWN, NOTEBOOK, TEXT
from support.answers import (
    KINDS,
    Mistake,
    Writer,
    lines,
    mistake,
    model,
    named,
    quantities,
    rewritten,
)
from support.answers import (
    WORDS as ALL_WORDS,
)

WORDS = ("R", "RR", "RP", "PR", "PP", "RRR", "RPR", "PRR")
SHORT, LONG = 15, 500
HOSTILE_SHORT, HOSTILE_LONG = 20, 300


def accepted(count: int) -> None:
    for k in range(count):
        rng = random.Random(f"right {k}")
        word = rng.choice(WORDS)
        name, right = rng.choice(lines(word))
        answer = Writer(rng, word).equation(name, rewritten(rng, right, 4))
        verdict = fb.check(model(word)[0], answer)
        assert verdict, f"{k}: {word}: {answer}\n{verdict.text}"


def planted(count: int) -> list[tuple[random.Random, str, str, Mistake]]:
    found = []
    k = 0
    while len(found) < count:
        rng = random.Random(f"planted {k}")
        k += 1
        word = rng.choice(WORDS)
        name, right = rng.choice(lines(word))
        made = mistake(rng, word, right, rng.choice(KINDS))
        where = setting(model(word)[1])
        if made and polynomial(where, made.answer) != polynomial(where, made.right):
            found.append((rng, word, name, made))
    return found


def share_explained(count: int) -> float:
    told = 0
    for rng, word, name, made in planted(count):
        answer = Writer(rng, word).equation(name, rewritten(rng, made.answer, 2, odd=False))
        verdict = fb.check(model(word)[0], answer)
        assert not verdict, f"{word}: {answer}: {made.kind}, {made.old} -> {made.new}"
        told += named(setting(model(word)[1]), verdict, made)
    return told / count


def hostile(count: int) -> None:
    """Documents cut, spliced, repeated and peppered: a verdict or an error of freebody, soon."""
    texts = {
        "markdown": MARKDOWN, "latex": LATEX, "text": TEXT, "python": CODE, "notebook": NOTEBOOK,
    }  # fmt: skip
    pepper = ["$", "$$", "\\[", "\\]", "\\begin{align}", "\\end{array}", "```", "`", "{", "}", "[[",
              "\\\\", "%", "&", "=", "\n", "∂", "ᵀ", "\u0307", "\u202e", "\x00", "\x1f", "🤖",
              "\\frac{", "^{", "_", "#", "|", '"', "'", "\\text{", "\\left", "9" * 400, "(" * 200,
              "\\underbrace{", "lambda: 0", "__import__('os')"]  # fmt: skip
    for k in range(count):
        rng = random.Random(f"hostile {k}")
        form = rng.choice(list(texts))
        text = texts[form]
        for _ in range(rng.choice((1, 2, 4, 9))):
            a = rng.randrange(len(text) + 1)
            b = min(len(text), a + rng.choice((0, 1, 5, 40)))
            piece = rng.choice((rng.choice(pepper), text[a:b] * rng.choice((0, 2, 30, 900))))
            text = (text[:a] + piece + text[rng.choice((a, b)) :])[:60_000]
        begun = time.process_time()
        with contextlib.suppress(fb.FreebodyError):
            assert fb.check(model("RR")[0], text, form=form).text
        assert time.process_time() - begun < 10.0, (k, form)


def test_rewritten_lines_are_accepted():
    accepted(SHORT)


def test_planted_errors_in_lines_are_caught_and_explained():
    assert share_explained(SHORT) >= 0.9


def test_a_thousand_underscores_are_harmless():
    assert fb.check(model("RR")[0], f"H22 = m2 lc{'_' * 5000}2^2 + I2")


def test_hostile_answers_are_harmless(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    hostile(HOSTILE_SHORT)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_five_hundred_rewritten_lines_are_accepted():
    accepted(LONG)


@pytest.mark.long
def test_five_hundred_planted_errors_are_caught_and_explained():
    assert share_explained(LONG) >= 0.9


@pytest.mark.long
def test_many_hostile_answers_are_harmless():
    hostile(HOSTILE_LONG)


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["newton-euler", "recursive", "lagrange", "lagrange-first-kind"])
def test_the_lines_of_a_derivation_are_an_answer(method: str):
    """All that a derivation prints is read and right; what it says of nothing is told."""
    arm = model("RR")[0]
    steps = [str(equation) for step in fb.derive(arm, method).steps for equation in step.equations]
    verdict = fb.check(arm, "\n\n".join(steps), form="markdown")
    assert verdict, verdict
    assert len(verdict.equations) >= 40
    assert len(verdict.unread) <= 3


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["newton-euler", "recursive", "lagrange"])
def test_a_sign_changed_in_a_line_of_a_derivation_is_found(method: str):
    arm = model("RR")[0]
    steps = [str(equation) for step in fb.derive(arm, method).steps for equation in step.equations]
    rng = random.Random(method)
    able = [k for k, line in enumerate(steps) if " + " in line.partition("=")[2]]
    for k in rng.sample(able, 4):
        left, equals, right = steps[k].partition("=")
        wrong = [*steps[:k], left + equals + right.replace(" + ", " − ", 1), *steps[k + 1 :]]
        verdict = fb.check(arm, "\n\n".join(wrong), form="markdown")
        assert not verdict, wrong[k]
        assert {x.where for x in verdict.equations if not x.equal} == {f"line {1 + 2 * k}"}


FEW_EQUATIONS, MANY_EQUATIONS = 20, 1000


def are_equal(count: int) -> None:
    for k in range(count):
        rng = random.Random(f"equal {k}")
        word = rng.choice(ALL_WORDS)
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
        word = rng.choice(ALL_WORDS)
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
    are_equal(FEW_EQUATIONS)


def test_mistakes_are_found_and_named():
    assert share_named(FEW_EQUATIONS, steps=0) >= 0.95


@pytest.mark.long
def test_many_rewritten_answers_are_equal():
    are_equal(MANY_EQUATIONS)


@pytest.mark.long
@pytest.mark.parametrize("steps", [0, 3])
def test_many_mistakes_are_found_and_named(steps: int):
    assert share_named(MANY_EQUATIONS, steps) >= 0.95
