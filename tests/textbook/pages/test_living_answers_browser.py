"""Lines typed into the pages of derivations, in a real browser: the page says what `fb.check` says,
right, wrong or unreadable, and of a wrong one the same sentences and no others."""

from __future__ import annotations

import functools
import random
import shutil
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import islice

import pytest

import freebody as fb
from check_lines.lines import Line, mutants, of_robot
from support.browser import ANSWER, FRESH, SAID
from support.page_data import page_data

pytestmark = [
    pytest.mark.browser,
    pytest.mark.filterwarnings("ignore::UserWarning"),
    pytest.mark.skipif(
        not (shutil.which("chromium") and shutil.which("chromedriver")),
        reason="needs chromium and chromedriver",
    ),
]

WINDOW = 1500, 900
ALL = {
    "2R": "lagrange",
    "RP": "lagrange",
    "four_bar": "newton-euler",
    "furuta": "newton-euler",
    "3R": "lagrange",
    "acrobot": "lagrange",
    "slider_crank": "newton-euler",
    "gantry_crane": "newton-euler",
    "elbow_arm": "newton-euler",
    "cart_pole": "lagrange",
}
QUICK, LONG = {"RP": 15, "four_bar": 10}, 50
MOST_UNDECIDED = 0.4
"""Derivatives, states, quantities that have no value on the page."""
LOOK = "look at it again"
LARGER = 60_000  # bytes, all tables, names, states and sentences together

SPOILT = ("({}", "{} +", "{}^", "{} zeta9", "{} \\foo", "{} = ", "{} 2 3", "{})", "{} @")


@functools.cache
def checked(model: fb.Model, text: str) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """What `fb.check` says, of what, and the causes that it tells."""
    try:
        verdict = fb.check(model, text)
    except fb.FreebodyError:
        return "unread", (), ()
    titles = tuple(one.title for one in verdict.equations)
    wrong = any(not one.equal for one in verdict.equations)
    how = "wrong" if wrong else "right" if verdict else "unread"
    return how, titles, verdict.causes


def boxes(driver, model: fb.Model) -> dict[tuple[str, ...], int]:
    """Which box asks for what `fb.check` calls so; k1 of a closed chain's page is a factor of its
    own steps, and no kinetic energy."""
    found: dict[tuple[str, ...], int] = {}
    for k, (name, entries) in enumerate(driver.execute_script(FRESH)):
        zeros = "[" + ", ".join("7" for _ in entries.split(",")) + "]" if entries else "7"
        _, titles, _ = checked(model, f"{name} = {zeros}")
        if titles and name[0] != "k":
            found.setdefault(titles, k)
    return found


def typed(driver, model: fb.Model, robot: str, count: int) -> list[tuple[int, str]]:
    """Lines that a box of the page asks for, right and with a mistake, on one line and without
    options; every fifth is spoilt."""
    rng, at = random.Random(f"{robot} 28"), boxes(driver, model)

    def asked(lines: Iterable[Line]) -> Iterator[Line]:
        typable = (x for x in lines if isinstance(x.text, str) and not x.options)
        on_one_line = (x for x in typable if "\n" not in x.text.strip())
        return (x for x in on_one_line if checked(model, x.text)[1] in at)

    drawn = of_robot(robot, 5 * count, rng)
    rng.shuffle(drawn)
    right = list(islice(asked(drawn), count))
    wrong = mutants(right, 2 * count, rng.randrange(99)) if any(x.source for x in right) else ()
    found = [*right, *islice(asked(wrong), count)]
    rng.shuffle(found)
    return [
        (at[checked(model, x.text)[1]], rng.choice(SPOILT).format(x.text) if not i % 5 else x.text)
        for i, x in enumerate(found[:count])
    ]


@pytest.mark.parametrize(
    ("robot", "count"),
    [
        *QUICK.items(),
        *(pytest.param(robot, LONG, marks=pytest.mark.long) for robot in ALL),
    ],
)
def test_the_page_says_what_check_says(driver, page_of, robot, count):
    """Or that it leaves the line to `fb.check`; no number of the line at the first try. Where not
    every state is admissible `fb.check` may tell the place instead of the thought."""
    model = fb.load(robot)
    is_conditional = bool(model.loops or model.passive)
    page = page_of(robot, ALL[robot])
    driver.get(page.as_uri())
    told, unlike = Counter(), []
    sentences = page_data(page.read_text(encoding="utf-8"))["sentences"]
    rows = typed(driver, model, robot, count)
    for k, text in rows:
        right, _, causes = checked(model, text)
        driver.execute_script(FRESH)
        said = driver.execute_script(ANSWER, k, text)
        how = SAID[said[:5]]
        told[how] += 1
        known = [x for x in causes if x in sentences]
        if how not in (right, "undecided") or "Not right: here it is" in said:
            unlike.append((text, right, said))
        elif how == "wrong" and not all(x in said for x in known):
            unlike.append((text, known, said))
        elif how == "wrong" and not is_conditional:
            more = [x for x in sentences if x in said and x not in causes]
            if more or (not causes and LOOK not in said):
                unlike.append((text, causes, said))
    assert not unlike
    assert len(rows) >= count * 0.8
    assert told["undecided"] <= MOST_UNDECIDED * len(rows)
    assert not driver.get_log("browser")


@pytest.mark.long
def test_pages_have_not_become_much_larger(page_of):
    """Than they were before they read by the tables; kept as numbers."""
    before = {
        "five_bar": 425_268,
        "3R": 484_677,
        "2R": 273_498,
        "slider_crank": 306_631,
        "four_bar": 283_345,
    }
    for robot, size in before.items():
        assert page_of(robot).stat().st_size < size + LARGER


def test_a_vector_may_stand_in_round_brackets(driver, page_of):
    driver.get(page_of("2R", "lagrange").as_uri())
    names = [name for name, _ in driver.execute_script(FRESH)]
    for text, said in (
        ("(-lc1 s1 θ̇1, lc1 c1 θ̇1)", "Right"),
        (r"(-lc1 s1 θ̇1, lc1 c1 θ̇1)^\top", "Right"),
        ("(lc1 c1 θ̇1, -lc1 s1 θ̇1)", "Not right"),
    ):
        assert driver.execute_script(ANSWER, names.index("vc1"), text).startswith(said)


LEVELS_NUMBERS_AND_SIGNS = [
    ("V1", "m1 g lc1 s1 + m1 g l1 + 5", "Right"),
    ("V1", "m1 g lc1 s1 + l1", "Not right"),
    ("V1", "m1 g lc1 s1 + m1 g sqrt(l1)", "Not right"),
    ("V1", "m1 g lc1 s1 + m1 g l1 sqrt(s1²)/s1", "Not right"),
    ("V1", "m1 g lc1 s1 + l1/(l1 - l1)", "Cannot be read: this divides by zero."),
    ("G2", "m2 g lc2 c12 + 0.001 + 10^12 l1 - 10^12 l1", "Not decided here"),
    ("G2", "m2 g lc2 c12 + 100 l1 - 100 l1", "Right"),
    ("G2", "11.77 c12", "Not decided here: An answer in numbers"),
    ("H22", "0.6", "Not decided here: An answer in numbers"),
    ("H22", "0.64 kg m²", "Not decided here: A unit"),
    ("T1", "θ̇1²", "Not decided here: An answer in numbers"),
    ("H22", "I2", "Not right"),
    ("H22", "0", "Not right"),
    ("vc1", "[-lc1 s1 θ̇1, lc1 c1 θ̇1, 0]", "Right"),
    ("vc1", "[-lc1 s1 θ̇1, lc1 c1 θ̇1, 3]", "Not right"),
    ("G2", "m2 😀", "Cannot be read: 😀 has no meaning here"),
    ("G2", "m2 ≠ 3", "Cannot be read: a dot, stroke or accent"),
]
FUNCTIONS = [  # only a posture may have a root's other sign; what is equal to itself says nothing
    ("H22", "√((I2 + m2 lc2²)²)", "Right: equal at 8 random states."),
    ("T1", "√((1/2 (I1 + m1 lc1²) θ̇1²)²)", "Right: equal at 8 random states."),
    ("G2", "m2 g lc2 c12 √(g²)/g", "Right: equal at 8 random states."),
    ("G2", "m2 g lc2 cos arccos(c12)", "Right: equal at 8 random states."),
    ("H12", "√4 m2 lc2²/2 + m2 l1 lc2 c2 + I2", "Right: equal at 8 random states."),
    ("H12", "√m2 √m2 (lc2² + l1 lc2 c2) + I2", "Right: equal at 8 random states."),
    ("G2", "√((m2 g lc2 c12)²)", "Not right"),
    ("G2", "-√((m2 g lc2 c12)²)", "Not right"),
    ("G2", "m2 g lc2 √(1 - s12²)", "Not right"),
    ("G2", "m2 g lc2 sin arcsin √(c12²)", "Not right"),
    ("vc1", "[-lc1 √(s1²) θ̇1, lc1 c1 θ̇1]", "Not right"),
    ("vc1", "[-lc1 √(s1²) θ̇1, lc1 s1 θ̇1]", "Not right"),
    ("H12", "√9 m2 lc2²/2 + m2 l1 lc2 c2 + I2", "Not right"),
    ("G2", "m2 g lc2 sin(arccos(c12))", "Not right: look at it again"),
    ("V1", "m1 g lc1 √(s1²) + m1 g l1", "Not right"),
    ("L", "T1 + T2 - V1 - √(V2²)", "Not right"),
    ("tau2", "√(G2²)", "Not right"),
    ("G2", "√√√√√√(G1)", "Cannot be read: at most 5 inverse functions"),
    ("G2", "m2 g lc2 cos arccos c12", "Cannot be read: there is c12 where a bracket"),
    ("G2", "G2", "Cannot be read: there is no G2 that this line may use"),
    ("G2", "√(G2²)", "Cannot be read: there is no G2 that this line may use"),
    ("G2", "m2 g lc2 c12 + G2 - G2", "Cannot be read: there is no G2 that this line may use"),
    ("H12", "H12", "Cannot be read: there is no H12 that this line may use"),
    ("H12", "H21", "Not decided here: What says it by H21, which stands on this line too,"),
    ("G2", "abs(G2)", "Cannot be read: there is no G2 that this line may use"),
    ("G2", "|m2 g lc2 c12|", "Not right: look at it again"),
]


@pytest.mark.sample(1)
@pytest.mark.parametrize("lines", [LEVELS_NUMBERS_AND_SIGNS, FUNCTIONS])
def test_lines_are_judged_as_check_judges_them(driver, page_of, lines):
    """Or what is right in numbers is left to it."""
    model = fb.load("2R")
    driver.get(page_of("2R", "lagrange").as_uri())
    names = [x for x, _ in driver.execute_script(FRESH)]
    for name, text, expected in lines:
        driver.execute_script(FRESH)
        said = driver.execute_script(ANSWER, names.index(name), text)
        assert said.startswith(expected), (name, text, said)
        how = SAID[said[:5]]
        assert how in ("undecided", checked(model, f"{name} = {text}")[0]), (name, text)
