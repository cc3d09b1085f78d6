"""The lecture notes item by item: none missing, verdicts as audited, and no check that cannot
fail."""

import re
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from freebody_notes.checks import Answer, ByReading, Digits, Related
from freebody_notes.contents import item, items
from freebody_notes.item import Item, NotesError, Outcome, run
from freebody_textbook.relations.formula import FormulaError
from support.executed_notes import finding
from support.notes_verdicts import VERDICTS

BY_ID = {x.id: x for x in items()}
WORDS_ONLY = {"eq-1.5", "uf-6.29-inward-text"}
WRONG = [name for name, verdict in VERDICTS.items() if verdict != "holds"]
SWAPS = (
    ("sin(", "cos("),
    ("cos(", "sin("),
    (" + ", " - "),
    (" - ", " + "),
    ("= ", "= -"),
    ("= 0", "= 1"),
    ("*", "*2*"),
)


def test_every_item_of_the_audit_is_there_once():
    assert [x.id for x in items()].count("eq-2.15") == 1
    assert sorted(x.id for x in items()) == sorted(VERDICTS)
    assert {x.chapter for x in items()} == {1, 2, 3, 4, 5, 6}


@pytest.mark.sample(15)
@pytest.mark.parametrize("name", VERDICTS)
def test_verdict_is_the_audited_one(name: str):
    found = finding(name)
    assert found.verdict == VERDICTS[name]
    assert found.lines or found.item.is_text
    assert all(found.lines)


@pytest.mark.sample(8)
@pytest.mark.parametrize("name", WRONG)
def test_the_corrected_form_flips_the_verdict(name: str):
    found = finding(name)
    assert not found.printed.holds
    assert found.corrected is not None
    assert found.corrected.holds
    x = found.item
    assert run(Item(x.id, x.section, x.title, x.check, printed=x.corrected)).verdict == "holds"
    assert x.why


@pytest.mark.sample(20)
@pytest.mark.parametrize("name", [name for name in VERDICTS if name not in WORDS_ONLY])
def test_no_check_that_cannot_fail(name: str):
    """Some small change of the right form that can still be read and compared makes it fail."""
    x = BY_ID[name]
    right = x.corrected or x.printed
    slips = [x.printed] if x.corrected else []  # the notes' own slip is a small change too
    assert any(fails(x, form) for form in [*slips, *changed(right)]), right


def changed(form: str):
    """Forms that differ in one place."""
    for old, new in SWAPS:
        for match in re.finditer(re.escape(old), form):
            yield form[: match.start()] + new + form[match.end() :]
    for number in re.finditer(r"\d", form):
        yield form[: number.start()] + str((int(number[0]) + 1) % 10) + form[number.end() :]


UNREADABLE = (
    "used but not defined",
    "cannot be read",
    "never equal",
    "cannot be added",
    "closes no bracket",
    "(line 1",
    "have no",
    "printed ]",
)


def fails(x: Item, form: str) -> bool:
    """Whether a form is found wrong, and not merely unreadable."""
    try:
        outcome = x.check.run(form)
    except (fb.FreebodyError, ValueError, KeyError, IndexError, np.linalg.LinAlgError):
        return False
    return not outcome.holds and not any(
        words in line for line in outcome.lines for words in UNREADABLE
    )


def test_what_is_of_words_only_is_marked_and_little():
    assert {x.id for x in items() if x.is_text} == WORDS_ONLY
    assert {x.id for x in items() if isinstance(x.check, ByReading)} == WORDS_ONLY


def test_a_counterexample_stands_with_what_is_wrong_in_symbols():
    for name in ("eq-3.22", "eq-1.8", "eq-2.30", "eq-4.14", "eq-6.19"):
        assert finding(name).printed.example, name


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("eq-3.22", "‘I2’ should not be there"),
        ("eq-2.14", "of 2000 random poses"),
        ("eq-6.14", "−0.063869, −0.1548, −0.0011306"),
        ("ex-3.2-2dof", "−0.2577, 3.341"),
        ("eq-2.27", "A vector of 2 and a scalar are never equal"),
        ("eq-4.15", "Started with v̇₀ = −g instead of 0, the form without weights holds."),
        ("eq-2.52", "computed [−5.9730762, −7.191343]"),
        ("ex-6.1-gyro", "n₂: computed [0, 150, 0]"),
    ],
)
def test_evidence_says_what_was_found(name: str, words: str):
    assert words in " ".join(finding(name).lines)


def test_an_item_is_found_by_its_number():
    assert item("3.22") is item("(3.22)") is item("eq-3.22")
    with pytest.raises(fb.UnknownNameError, match=r"Did you mean 'eq-3\.22'"):
        item("eq-3.222")


def test_a_correction_that_is_wrong_itself_is_no_verdict():
    x = BY_ID["eq-3.23"]
    bad = replace(x, corrected="H22 = I2")
    with pytest.raises(NotesError, match=r"the correction 'H22 = I2' fails"):
        run(bad)
    bad = replace(x, flaw="", corrected="")
    with pytest.raises(NotesError, match="the printed form"):
        run(bad)


def test_digits_are_rounded_or_cut_off_at_the_last_one_printed():
    def values():
        return {"x": [1.23456, -0.99996]}

    assert Digits(values).run("x = [1.2345, -1.0000]").holds
    assert Digits(values).run("x = [1.2346, -0.9999]").holds
    assert not Digits(values).run("x = [1.2344, -1.0000]").holds
    assert not Digits(values).run("x = [1.2346]").holds


def test_nothing_printed_does_not_hold():
    assert Related(dict).run("") == Outcome(False, ("Nothing is printed here.",))


def test_calls_shown_are_calls_that_run():
    """What a relation shows as its call is run, word for word."""
    import freebody as fb

    for x in items():
        if isinstance(x.check, Related) and isinstance(x.check.values, str) and x.printed:
            exec(x.check.call(x.printed), {"fb": fb})
        if isinstance(x.check, Answer):
            assert bool(eval(x.check.call(x.corrected or x.printed), {"fb": fb})), x.id


@pytest.mark.parametrize(
    "form",
    [
        "a = [1, ]b",
        "a = __import__('os')",
        "a = b.c",
        "a = b[0]",
        "a = x^1.5",
        "a = f(x)",
        "a" * 5000,
    ],
)
def test_formulas_are_read_and_never_run(form: str):
    from freebody_textbook.relations.formula import parse

    with pytest.raises(FormulaError):
        parse(form)
