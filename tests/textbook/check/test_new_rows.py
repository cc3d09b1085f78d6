"""A quantity, a spelling and a thought are a row each, which `fb.check` and the script of a page
read: three are added to the tables, as if they stood in the files.

The tables are internal; they are changed in a process of its own, before any reader imports them.
That nothing outside them asks for a row is read off the sources.
"""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import freebody as fb
from support.browser import ANSWER, FRESH, SAID, browser
from support.sources import SOURCES, SRC

ROWS = """
from freebody.expressions.grammar.tables import spellings
spellings.SPELLINGS += (("⨯", "×"),)

from freebody_textbook.methods import body_quantities
from freebody.expressions.quantities import units
body_quantities.BODY_QUANTITIES += (
    body_quantities.BodyQuantity(
        "hc{n}", "the angular momentum of body {n} about its centre of mass",
        lambda b: b.angular(b.s.tree.space.inertia_times(b.s.inertia(b.i), b.motion.w[b.i])),
        units.SPIN, (("hG{n}", 0),), angular=True, of_centre=True, of_motion=True, shown=True,
    ),
)

from freebody_textbook.check.reasons import misconceptions
misconceptions.THOUGHTS["It is counted seven times."] = lambda x: iter([({}, x.value * 7)])
"""
PROGRAM = """
import json, sys
import freebody as fb
folder, lines = sys.argv[1], json.loads(sys.argv[2])
found = {}
for robot, texts in lines.items():
    model = fb.load(robot)
    found[robot] = [[bool(x), list(x.causes)] for x in (fb.check(model, y) for y in texts)]
    with open(f"{folder}/{robot}.html", "w", encoding="utf-8") as file:
        file.write(fb.derive(model, "newton-euler").html())
print(json.dumps(found))
"""
SEVEN = "It is counted seven times."
LINES = {
    "2R": (
        ("omega1", "omega1 = hc1/I1", "right"),
        ("omega2", "ω2 = h_{G2}/I_2", "right"),
        ("omega2", "ω2 = hc1/I1", "wrong"),
        ("vc1", "vc1 = ω1 ⨯ sc1", "right"),
        ("vc1", "vc1 = 2 ω1 ⨯ sc1", "wrong"),
        ("omega1", "ω1 = 7 θ̇1", SEVEN),
        ("omega2", "ω2 = 7 hc2/I2", SEVEN),
    ),
    "slider_crank": (("omega1", "ω1 = hc1/I1", "right"), ("omega1", "ω1 = 2 hc1/I1", "wrong")),
}
"""Lines, in which box they are typed, and what is said of them."""
Rows = tuple[dict[str, list[tuple[bool, list[str]]]], Path]


@pytest.fixture(scope="module")
def with_rows(tmp_path_factory: pytest.TempPathFactory) -> Rows:
    """What `fb.check` says of each robot's lines where the tables have the rows, and a folder with
    the robots' pages."""
    folder = tmp_path_factory.mktemp("pages")
    lines = json.dumps({robot: [text for _, text, _ in rows] for robot, rows in LINES.items()})
    command = [sys.executable, "-c", ROWS + PROGRAM, str(folder), lines]
    said = subprocess.run(command, capture_output=True, check=True, text=True).stdout
    return json.loads(said), folder


def test_check_reads_new_rows(with_rows: Rows):
    for robot, found in with_rows[0].items():
        for (right, causes), (_, text, said) in zip(found, LINES[robot], strict=True):
            assert right == (said == "right"), text
            assert (SEVEN in causes) == (said == SEVEN), text


def test_without_the_rows_none_of_this_is_known():
    for _, text, said in LINES["2R"]:
        if said == SEVEN and "hc" not in text:
            assert SEVEN not in fb.check(fb.load("2R"), text).causes
        else:
            with pytest.raises(fb.FreebodyError):
                fb.check(fb.load("2R"), text)


@pytest.mark.browser
@pytest.mark.skipif(
    not (shutil.which("chromium") and shutil.which("chromedriver")),
    reason="needs chromium and chromedriver",
)
def test_the_pages_read_new_rows(with_rows: Rows, tmp_path: Path):
    _, folder = with_rows
    with browser(tmp_path / "profile") as driver:
        for robot, rows in LINES.items():
            driver.get((folder / f"{robot}.html").as_uri())
            for name, text, expected in rows:
                boxes = [x for x, _ in driver.execute_script(FRESH)]
                said = driver.execute_script(ANSWER, boxes.index(name), text)
                assert SAID[said[:5]] == ("right" if expected == "right" else "wrong"), (text, said)
                assert (SEVEN in said) == (expected == SEVEN), (text, said)


KINDS_FILE = SRC / "freebody/expressions/quantities/kinds.py"
KINDS = set(re.findall(r"^(\w+) = Kind\(", KINDS_FILE.read_text(encoding="utf-8"), re.MULTILINE))


def compared(node: ast.AST) -> set[str]:
    """Names in a comparison, or in the cases of a match."""
    if isinstance(node, ast.Compare | ast.match_case):
        parts = ast.walk(node if isinstance(node, ast.Compare) else node.pattern)
        return {x.attr if isinstance(x, ast.Attribute) else getattr(x, "id", "") for x in parts}
    return set()


def test_nothing_asks_which_kind_a_quantity_is_of():
    """What differs between kinds is a field of their rows."""
    assert len(KINDS) > 40
    asked, readers = [], 0
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text if "expressions.quantities" in text else "")
        imports = [x for x in ast.walk(tree) if isinstance(x, ast.ImportFrom)]
        if any("quantities" in (x.module or "") for x in imports):
            known = {a.name for x in imports for a in x.names}
            own = KINDS if "kinds" in known else KINDS & known
            readers += bool(own)
            asked += [(path.name, x) for node in ast.walk(tree) for x in compared(node) & own]
    assert not asked
    assert readers > 10
