"""`freebody notes`: the table, one item, the errata, the page; and the solutions of the
exercises."""

from __future__ import annotations

import importlib
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from urllib.parse import quote

import pytest
from markupsafe import escape

import freebody as fb
import freebody_notes
from freebody_notes.contents import _item, chapters, data, item, items
from freebody_notes.derivation_places import place_of
from freebody_notes.errata import errata
from freebody_notes.exercises import SOLUTIONS, exercises, solution
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import run
from freebody_notes.page import pages
from freebody_notes.text import item_text, shown
from freebody_textbook.relations.formula import as_printed
from support import executed_notes
from support.command import run as program
from support.formula_font import lacking
from support.notes_verdicts import VERDICTS


@pytest.fixture(scope="module")
def findings():
    return executed_notes.findings()


@pytest.fixture(autouse=True)
def _each_item_is_executed_once(monkeypatch):
    executed_notes.executing_once(monkeypatch)


@pytest.fixture(scope="module")
def site(findings):
    """The pages by their files' names."""
    return {name: page() for name, page in pages(findings, "the notes.html").items()}


@pytest.fixture(scope="module")
def html(site):
    """All of them."""
    return "".join(site.values())


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert program(["notes", *arguments]) == 0
    out = capsys.readouterr()
    assert out.err == ""
    return out.out


def test_the_table_lists_every_item_with_its_verdict(capsys):
    text = said(capsys)
    for name, verdict in VERDICTS.items():
        assert re.search(rf"^{re.escape(name)} +{verdict} ", text, re.MULTILINE), name
    assert "254 items executed: 196 hold, 20 misprints, 22 inconsistent, 16 incomplete." in text
    assert "2 of them are text without an equation." in text


def test_the_table_of_a_chapter_and_of_a_verdict(capsys):
    text = said(capsys, "--chapter", "4", "--verdict", "incomplete")
    shown = re.findall(r"^((?:eq|uf|ex|alg|fig|def)-\S+) ", text, re.MULTILINE)
    assert shown == ["eq-4.14", "eq-4.15", "uf-4.15-boundary"]


def test_one_item_says_all_about_it(capsys):
    text = said(capsys, "3.22")
    for words in (
        "H₁₁, inertia at the base joint — equation (3.22)",
        "printed     H₁₁ = m₁ lc₁² + I₁ + I₂ + m₂ (l₁² + lc₂² + 2 l₁ lc₂ cos θ₂) + I₂",
        "corrected   H₁₁ = m₁ lc₁² + I₁ + m₂ (l₁² + lc₂² + 2 l₁ lc₂ cos θ₂) + I₂",
        "‘I2’ should not be there",
        "the printed form gives 1.031",
        'fb.check(fb.planar("RR")',
        "“The closed form”",
    ):
        assert words in text or words in " ".join(text.split())
    assert text.rstrip().endswith("misprint")


def test_words_show_the_items_about_them(capsys):
    text = said(capsys, "Coriolis")
    shown = re.findall(r"^((?:eq|uf|ex|alg|fig|def)-\S+) ", text, re.MULTILINE)
    assert shown
    for name in shown:
        assert "coriolis" in f"{item(name).title} {item(name).says}".lower()


def test_one_item_writes_its_figure(capsys, tmp_path: Path):
    assert "written" in said(capsys, "fig-2.2", "--out", str(tmp_path / "five.svg"))
    ET.fromstring((tmp_path / "five.svg").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nonsense",), "no item 'nonsense' in the notes."),
        (("eq-3.21x",), "Did you mean 'eq-3.21'?"),
        (("eq-2.44", "--out", "a.txt"), "name one, such as"),
        (("eq-1.4", "--out", "a.svg"), "eq-1.4 has no figure; leave out --out."),
        (("--chapter", "7"), "less than or equal to 6"),
    ],
)
def test_what_is_wrong_is_one_line_and_exit_code_2(capsys, arguments, words):
    assert program(["notes", *arguments]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert words in err


def test_errata_name_every_place_that_needs_one(findings, capsys, tmp_path: Path):
    text = errata(findings)
    wrong = [name for name, verdict in VERDICTS.items() if verdict != "holds"]
    joined = [name for name in wrong if item(name).same_as]
    assert text.count("\n- The same in ") == len(joined) == 7
    assert text.count("\n### ") == len(wrong) - len(joined) == 51
    for name in wrong:
        assert f"`{name}`" in text
    assert "$H_{11}" in text
    assert said(capsys, "--errata", "--out", str(tmp_path / "errata.md")).startswith("written: ")
    assert (tmp_path / "errata.md").read_text(encoding="utf-8") == text


def test_the_pages_hold_every_item_and_figure_and_fetch_nothing(html, site):
    for name in VERDICTS:
        assert html.count(f'id="{name}"') == 1, name
    assert html.count("<figure>") >= 21
    asks = r"<script src|<link (?!rel=\"icon\" href=\"data:,\")|@import|url\((?!data:)| src="
    assert not re.search(asks, html)
    addresses = set(re.findall(r"https?://[^\"'<> ]+", html))
    assert addresses <= {"http://www.w3.org/1998/Math/MathML", "http://www.w3.org/2000/svg"}
    assert html.count("<summary>How this was found") == len(VERDICTS)
    assert html.count("<summary>Solution") == len(exercises())
    for text in site.values():
        assert len(text.encode()) < 660_000
    assert not lacking(html)


def test_links_lead_from_page_to_page(site):
    assert list(site) == ["the notes.html", *(f"the notes-{number}.html" for number in chapters())]
    places = {
        (quote(name), place)
        for name, text in site.items()
        for place in ["", *re.findall(r' id="([^"]+)"', text)]
    }
    for name, text in site.items():
        links = re.findall(r' href="([^":]+)"', text)
        assert len(links) > 10
        for link in links:
            page, _, place = link.partition("#")
            assert (page or quote(name), place) in places, (name, link)
        for number in chapters():
            assert f'<li><a href="the%20notes-{number}.html"' in text


COMMANDS = [task["command"] for chapter in chapters().values() for task in chapter.tasks]


@pytest.mark.sample(2)
@pytest.mark.parametrize("command", COMMANDS)
def test_what_a_chapter_tells_to_try_runs(html, command, tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    name, *arguments = shlex.split(command)
    assert name == "freebody"
    assert program(arguments) == (1 if arguments[0] == "check" else 0)  # the check has a slip
    assert capsys.readouterr().out
    assert f"<code>{escape(command)}</code>" in html


def sides(one):
    """Each side of each equation of an item, as printed."""
    nodes = shown(one, one.printed)
    return {str(side) for node in nodes for side in getattr(node, "sides", (node,))}


def test_what_states_the_same_as_others_is_joined_with_them(html):
    """Every side of what is not shown again stands in the items that the page refers to."""
    joined = [one for one in items() if one.same_as]
    assert len(joined) > 20
    for one in joined:
        others = [item(name) for name in one.same_as]
        assert sides(one) <= set().union(*map(sides, others)), one.id
        card = re.search(rf'<article id="{one.id}".*?</article>', html, re.DOTALL)
        assert card, one.id
        above, _ = card[0].split("<details>")
        assert "<math" not in above, one.id
        assert all(f'#{name}"' in above for name in one.same_as)
        flaws = {VERDICTS[name] for name in one.same_as} - {"holds"}
        assert bool(flaws) == (VERDICTS[one.id] != "holds"), one.id


def test_the_moment_of_figure_6_2_is_told_beside_the_one_of_6_7():
    drawn = notes_figure("6.2").drawings[0].notes[0]
    assert "moment on the rotor 150 N m" in drawn
    for name, other in (("eq-6.7", "figure 6.2"), ("fig-6.2", "(6.7)")):
        assert other in item(name).says
        assert "150 N m" in item(name).says
        assert "75 N m" in item(name).says


def test_every_chapter_says_what_it_is_for_and_what_to_try(html):
    for chapter in chapters().values():
        assert 12 < len(chapter.used.split()) < 50
        assert " ".join(chapter.used.split()[:4]) in html
        assert len(chapter.tasks) in (2, 3)
        assert " ".join(chapter.about.split()[:5]) in html
        assert 30 < len(chapter.about.split()) < 100, chapter.title


def test_formulas_of_the_page_are_sound(html):
    for formula in re.findall(r"<math.*?</math>", html, re.DOTALL):
        ET.fromstring(formula)


def test_sections_and_chapters_have_titles():
    assert {x.section for x in items()} == {s for c in chapters().values() for s in c.sections}
    assert {x.chapter for x in items()} == set(chapters())


def test_every_data_file_is_in_the_contents_and_every_check_is_used():
    folder = Path(freebody_notes.__file__).parent / "chapters"
    parts = {part for chapter in chapters().values() for part in chapter.parts}
    assert {path.stem for path in folder.glob("*.toml")} == parts
    assert {path.stem for path in folder.glob("*.py")} - {"__init__"} == parts
    for part in parts:
        checks = importlib.import_module(f"freebody_notes.chapters.{part}").CHECKS
        entries = [
            e for section in data(f"chapters/{part}.toml").values() for e in section.values()
        ]
        assert set(checks) <= {entry["check"] for entry in entries}, part
        for entry in entries:
            assert entry["title"], part
            assert entry["says"], part
    assert list(SOLUTIONS) == [exercise.id for exercise in exercises()]


def test_a_check_that_no_file_has_is_named():
    entry = {"title": "", "check": "pendulun"}
    with pytest.raises(fb.UnknownNameError, match=r"no check 'pendulun' in eq-1\.1\. Did you mean"):
        _item("eq-1.1", "1.1", entry, {"pendulum": None})


def test_white_space_in_a_text_of_the_data_does_no_more_than_wrap():
    texts = [
        text for part in chapters()[1].parts for text in texts_in(data(f"chapters/{part}.toml"))
    ]
    assert len(texts) > 300
    assert not [text for text in texts if text != " ".join(text.split())]


def texts_in(x):
    if isinstance(x, str):
        return [x]
    return [text for y in (x.values() if isinstance(x, dict) else x) for text in texts_in(y)]


@pytest.mark.sample(4)
@pytest.mark.parametrize("exercise", exercises(), ids=lambda e: e.id)
def test_exercises_are_solved(exercise):
    found = solution(exercise)
    assert "<math" in found
    assert exercise.hint not in found


def test_solutions_prove_themselves():
    text = {e.id: solution(e) for e in exercises()}
    assert text["five-bar"].count("<li>") == 4
    assert "Both are identical as polynomials" in text["ex-4.5-verify"]
    assert "identical" in text["lagrange-2r"]
    assert "the same acceleration and the same force" in text["first-kind"]
    assert "finds 2 positions" in text["five-bar"]


def test_derivations_are_found_for_equations_of_every_chapter_but_the_first():
    there = {x.chapter for x in items() if place_of(x) is not None}
    assert there == {2, 3, 4, 5, 6}


def test_terminal_text_of_all_items_has_no_broken_signs(findings):
    for finding in findings:
        text = item_text(finding)
        assert finding.item.title in text
        assert "None" not in text


def test_superscripts_and_general_links_print_as_such():
    node = as_printed("Ri_h*omega_h + ph_i", ["omega_h", "ph_i"])
    assert str(node) == "R_{i−1}^i ω_{i−1} + p_i^i−1"
    assert "{R}_{i-1}^i" in node.latex()
    assert as_printed("transpose(J)^-1*f").latex() == "J^{-\\mathsf{T}} f"
    assert str(as_printed("theta1 = atan2(y, x)")) == "θ₁ = atan2(y, x)"
    assert str(as_printed("qdd")) == "q̈"


def test_an_item_runs_alone():
    assert run(item("eq-6.14")).verdict == "inconsistent"


def test_the_errata_in_the_docs_are_those_that_come_out(findings):
    """To update: freebody notes --errata --out docs/errata.md."""
    written = Path(__file__).parents[2] / "docs" / "errata.md"
    assert written.read_text(encoding="utf-8") == errata(findings)


# ---------------------------------------------------------------- a package of its own
WITHOUT = """
import sys
from importlib.abc import MetaPathFinder

class Absent(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "freebody_notes":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
import freebody as fb
from freebody.cli.app import run
try:
    fb.notes_figure
except ImportError as problem:
    assert isinstance(problem, fb.FreebodyError)
    print(problem)
print(run(["notes", "eq-3.22", "--errata"]), run(["models"]), run(["--help"]))
"""


def test_without_the_course_freebody_does_the_rest_and_says_what_is_missing():
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True)
    missing = (
        "freebody_notes is not installed; it comes with freebody: "
        "pip install --force-reinstall freebody."
    )
    said = done.stdout.splitlines()
    assert done.stderr == f"error: freebody notes: {missing}\n"
    assert said[0] == f"fb.notes_figure: {missing}"
    assert said[-1] == "2 0 0"
    assert "freebody notes: freebody_notes is not installed" in " ".join(done.stdout.split())


def test_a_fault_of_the_course_itself_is_not_taken_for_its_absence(monkeypatch):
    import freebody
    from freebody.cli.app import _add

    monkeypatch.setitem(sys.modules, "freebody_notes.figures.catalogue", None)
    monkeypatch.delitem(vars(freebody), "notes_figure", raising=False)
    with pytest.raises(ModuleNotFoundError, match=r"freebody_notes\.figures\.catalogue"):
        freebody.notes_figure
    monkeypatch.setitem(sys.modules, "freebody_notes.command", None)
    with pytest.raises(ModuleNotFoundError, match=r"freebody_notes\.command"):
        _add("notes", "freebody_notes.command")
