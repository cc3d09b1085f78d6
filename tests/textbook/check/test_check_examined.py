"""`fb.check` examined from outside: thousands of right lines, mistakes, and results from books.

Lines, spellings and the proof of what is right or wrong come from `check_lines`, `book_results` and
`exam_results`, which know nothing of how `check` reads or judges.
"""

import functools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import exam_results
import freebody as fb
from book_results import RESULTS, TOML, WORDS, Result
from check_lines.claims import Claim, gap
from check_lines.lines import Line, mutants, of_these, right_lines
from check_lines.trees import tree, two_valued

QUICK = ("pendulum", "2R", "RP", "cart_pole", "slider_crank", "four_bar")
READ, READ_RESULTS, PLACED = 0.97, 0.92, 0.85
pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

load = functools.cache(fb.load)


def judged(model: fb.Model, text: str, options: dict[str, Any]) -> tuple[str, str]:
    """What `check` says: "right", "unread", "wrong", or "placed" where it also says what is wrong
    or why it may have been thought; and its words."""
    try:
        verdict = fb.check(model, text, **options)
    except fb.FreebodyError as error:
        return "unread", str(error)
    wrong = [one for one in verdict.equations if not one.equal]
    if not wrong:
        return ("right" if verdict else "unread"), verdict.text
    found = [x.message for one in wrong for x in one.findings]
    place = any(not x.startswith("The whole answer") for x in found)
    return ("placed" if place or verdict.causes else "wrong"), verdict.text


def told(lines: Sequence[tuple[Any, str]]) -> str:
    return "\n".join(f"{line}\n    {said.splitlines()[0]}" for line, said in lines[:20])


def assert_right(lines: Sequence[Line]) -> None:
    found = [(line, *judged(load(line.robot), line.text, line.options)) for line in lines]
    wrong = [(line, said) for line, how, said in found if how in ("wrong", "placed")]
    unread = [(line, said) for line, how, said in found if how == "unread"]
    assert not wrong, f"{len(wrong)} right lines called wrong:\n{told(wrong)}"
    assert len(unread) <= (1 - READ) * len(lines), f"{len(unread)} not read:\n{told(unread)}"


def assert_caught(lines: Sequence[Line]) -> None:
    found = [(line, judged(load(line.robot), line.text, line.options)[0]) for line in lines]
    accepted = [(line, line.kind) for line, how in found if how == "right"]
    assert not accepted, f"{len(accepted)} mistakes accepted:\n{told(accepted)}"
    without = [(line, line.kind) for line, how in found if how != "placed"]
    assert len(without) <= (1 - PLACED) * len(lines), f"{len(without)} without:\n{told(without)}"


@functools.cache
def sample() -> tuple[Line, ...]:
    return tuple(of_these(QUICK, 30))


def test_right_lines_are_right() -> None:
    assert_right(sample())


def test_mistakes_are_caught() -> None:
    assert_caught(list(mutants(sample(), 20)))


@functools.cache
def all_lines() -> tuple[Line, ...]:
    return tuple(right_lines(2000))


@pytest.mark.long
def test_all_right_lines_are_right() -> None:
    assert_right(all_lines())


@pytest.mark.long
def test_all_mistakes_are_caught() -> None:
    assert_caught(list(mutants(all_lines(), 4000)))


@functools.cache
def proven(robot: str) -> tuple[bool, dict[str, np.ndarray]]:
    own = exam_results.own_mechanism(robot)
    return bool(own.loops), own.states(8)


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], fb.Model]:
    folder: Path = tmp_path_factory.mktemp("robots")
    words, files = WORDS | exam_results.WORDS, TOML | exam_results.TOML

    @functools.cache
    def robot(name: str) -> fb.Model:
        if name in words:
            return fb.planar(words[name])
        if name in files:
            path = folder / f"{name}.toml"
            path.write_text(files[name], encoding="utf-8")
            return fb.load(path)
        return fb.load(exam_results.LOADED.get(name, name))

    return robot


@pytest.mark.sample(7)
@pytest.mark.parametrize("one", [*RESULTS, *exam_results.RESULTS], ids=lambda x: x.title)
def test_results_are_right_in_numbers(one: Result) -> None:
    closed, env = proven(one.robot)
    for formula in one.formula.split("; "):
        left, _, right = formula.partition(" = ")
        claim = Claim(one.robot, "result", tree(left), tree(right))
        count = two_valued(claim.left) + two_valued(claim.right)
        with np.errstate(all="ignore"):
            gaps = [
                gap(claim, env, tuple(choice >> i & 1 for i in range(count)))
                for choice in range(1 if closed else 2**count)
            ]
        assert (np.min(gaps, axis=0) < 1e-8).all(), formula


@pytest.mark.parametrize("results", [RESULTS, exam_results.RESULTS], ids=["books", "exams"])
def test_a_third_of_the_results_is_of_closed_chains(results: Sequence[Result]) -> None:
    assert len(results) >= 60
    closed = [x for x in results if exam_results.own_mechanism(x.robot).loops]
    assert len(closed) >= len(results) / 3


@pytest.mark.sample(1)
@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("whole", [RESULTS, exam_results.RESULTS], ids=["books", "exams"])
def test_results_from_books(
    whole: Sequence[Result], first: int, robots: Callable[[str], fb.Model]
) -> None:
    results = whole[first::2]
    found = [(x.title, *judged(robots(x.robot), x.answer, x.options)) for x in results]
    wrong = [(title, said) for title, how, said in found if how in ("wrong", "placed")]
    unread = [(title, said) for title, how, said in found if how == "unread"]
    assert not wrong, told(wrong)
    assert len(unread) <= (1 - READ_RESULTS) * len(results), told(unread)
