"""What textbooks print, in their own letters: each line of a result is accepted, and none with a
mistake.

tests/textbooks has a file for each book. A result has its place in the book, the robot that it is
about (of a bundled one the name), and the book's lines; `names` are what --name takes, `parameters`
formulas, `letters` those of a notation; `mistake` is a line with its number.
"""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import freebody as fb
from support.notations import own_notation
from support.printed_lines import are_equal
from support.robots import loaded

FOLDER = Path(__file__).parents[2] / "textbooks"


def results() -> list[dict[str, Any]]:
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        own = tomllib.loads(path.read_text(encoding="utf-8"))["result"]
        by_title = {result["title"]: result for result in own}
        for result in own:
            base = by_title[result["same"]] if "same" in result else result
            names = base.get("names", {}) | result.get("names", {})
            found.append({**result, "robot": base["robot"], "names": names, "book": path.stem})
    return found


RESULTS = results()


def named(result: dict[str, Any]) -> str:
    return f"{result['book']}: {result['title']}"


def model(result: dict[str, Any]) -> fb.Model:
    if "\n" not in result["robot"]:
        return fb.load(result["robot"])
    return loaded(result["robot"], physical="ignore")


def answered(result: dict[str, Any], lines: list[str], folder: Path) -> Any:
    text, absolute = "\n".join(lines), result.get("absolute", False)
    own = {key: result[key] for key in ("parameters", "letters") if key in result}
    notation = own_notation(folder, "book", **own)
    return fb.check(
        model(result), text, names=result["names"] or None, absolute=absolute, notation=notation
    )


@pytest.mark.sample(3)
@pytest.mark.parametrize("result", RESULTS, ids=named)
def test_a_books_lines_are_right(result: dict[str, Any], tmp_path: Path):
    verdict = answered(result, result["lines"], tmp_path)
    assert verdict, verdict
    assert verdict.unchecked in ((), tuple(result.get("unchecked", ())))


def wrong(right: str) -> str:
    """With the first sign between two terms changed, else that of the first term or entry that has
    a letter."""
    changed = re.sub(r" ([+-]) ", lambda m: f" {'-+'[m[1] == '-']} ", right, count=1)
    if changed == right:
        changed = re.sub(r"(?<= )-(?=[\\w])", "", right, count=1)
    if changed == right:
        changed = re.sub(r" (?=[\d ]*(?!\\begin|\\end)[a-zA-Z\\])", " -", right, count=1)
    return changed if changed != right else f"{right} + 1"


def planted(result: dict[str, Any]) -> Iterator[tuple[int, str]]:
    """Mistakes: the one that is given, or in each line one, see `wrong`."""
    if "mistake" in result:
        yield tuple(result["mistake"])
        return
    for k, line in enumerate(result["lines"]):
        left, equals, right = line.rpartition("=")
        if left.strip() in result.get("unchecked", ()):
            continue
        if right.strip().startswith("0") or len(right) < len(left) - 8:  # an equation of motion
            left, equals, right = "", "", line
        yield k, left + equals + wrong(right)


WITH_MISTAKES = [
    pytest.param(x, id=named(x), marks=[pytest.mark.long] * ("mistake" in x)) for x in RESULTS
]


@pytest.mark.sample(1)
@pytest.mark.parametrize("result", WITH_MISTAKES)
def test_a_books_lines_with_a_mistake_are_not(result: dict[str, Any], tmp_path: Path):
    for k, line in planted(result):
        lines = [*result["lines"][:k], line, *result["lines"][k + 1 :]]
        assert not answered(result, lines, tmp_path), lines[k]


def test_there_are_enough_published_results():
    assert len(RESULTS) >= 100
    assert sum(len(result["lines"]) for result in RESULTS) >= 360


ROBOTS = {result["robot"]: result for result in RESULTS if "mistake" not in result}


@pytest.mark.sample(1)
@pytest.mark.parametrize("result", ROBOTS.values(), ids=named)
def test_the_books_robots_are_derived_equal(result: dict[str, Any]):
    made = model(result)
    first = fb.derive(made, "lagrange")
    assert are_equal(first, fb.derive(made, "recursive"))
    assert are_equal(first, fb.derive(made, "newton-euler"))


def test_absolute_angles_are_those_of_planar_trees():
    with pytest.raises(fb.FreebodyError, match="belong to robots in the plane"):
        fb.check(fb.load("furuta"), "T = 0", absolute=True)
    arm = fb.planar("RPR", l=["l1", "l2", "l3"])
    names = {"theta3": "theta1 + theta3"}  # the slide between does not turn
    for absolute, own in ((False, names), (True, None)):
        x = fb.check(arm, "y = (l1 + d2 + l2) sin(theta1) + l3 sin(theta3)", own, absolute=absolute)
        assert x, (absolute, x)
    assert not fb.check(arm, "y = (l1 + d2 + l2) sin(theta1) + l3 sin(theta3)")
