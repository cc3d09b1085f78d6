"""Derivations and equations in a real browser: formulas are drawn, and no line is wider than the
page."""

from __future__ import annotations

import base64
import re
import shutil
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import freebody as fb
from support.formula_font import lacking
from support.methods import METHODS
from support.symbolic import spatial_arm

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(
        not (shutil.which("chromium") and shutil.which("chromedriver")),
        reason="needs chromium and chromedriver",
    ),
]

WINDOW = 1100, 900
MODELS = [
    *map(fb.planar, ("R", "RR", "RP", "RRR")),
    spatial_arm(5, 3),
    fb.planar("RR").replace(gravity=0),
]
SIZES = """return [...document.querySelectorAll('.equations:not(.short)')].map(e => {
  const room = e.getBoundingClientRect(), rows = e.querySelectorAll('mtr').length;
  const tables = [...e.querySelectorAll(':scope > math > mtable')];
  const sizes = tables.map(table => table.getBoundingClientRect());
  return {room: room.width, width: Math.max(...sizes.map(size => size.width)),
    height: sizes.reduce((total, size) => total + size.height, 0), rows: rows}})"""
DOTS = """const find = x => [...document.querySelectorAll(x)].map(e => e.getBoundingClientRect());
  return [find('mover > mi'), find('mover > mo')]"""


def robots_of(methods: Iterable[str]) -> list[Any]:
    """Every method with every robot: of each method two soon, so that all robots come, the others
    where there is time."""
    found, parts = [], range(3)
    for i, method in enumerate(methods):
        for part in parts:
            marks = () if (i + part) % len(parts) == 0 else pytest.mark.long
            robots = MODELS[part :: len(parts)]
            found.append(pytest.param(method, robots, marks=marks, id=f"{method}-{part}"))
    return found


@pytest.mark.parametrize(("method", "robots"), robots_of(METHODS))
def test_derivations_are_drawn_and_fit(driver, tmp_path: Path, method, robots):
    for k, model in enumerate(robots):
        derivation = fb.derive(model, method)
        page = tmp_path / f"derivation{k}.html"  # under one name the page before may still be there
        page.write_text(text := derivation.html())
        assert not lacking(text)
        assert "<mtd><mo>=" not in text  # it would have no space beside it
        driver.get(page.as_uri())
        sizes = driver.execute_script(SIZES)
        assert len(sizes) == sum(bool(step.equations) for step in derivation.steps)
        for size in sizes:
            assert size["width"] <= size["room"], (model.name, size)
            assert size["height"] >= 15 * size["rows"] > 0
        assert not [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]


def test_the_font_of_formulas_comes_with_the_page(driver, page_of):
    """Under the page's own policy."""
    driver.get(page_of("2R").as_uri())
    state = "return [...document.fonts].map(font => [font.family, font.status])"
    assert driver.execute_script(state) == [["Freebody Formulas", "loaded"]]


@pytest.mark.parametrize("letter", ["\u03a2", "½", "₁", "⊗"])
def test_a_letter_that_the_font_lacks_is_found(letter):
    assert lacking(f"<math><mi>α</mi><mo>{letter}</mo></math>") == {letter}


def test_a_wide_left_side_leaves_the_others_their_room(page_of):
    """The equations with every ∂Φ_k/∂θ λ_k on the left had broken the next into one term a line."""
    text = page_of("double_four_bar").read_text(encoding="utf-8")
    step = re.search(r"The equation of θ₃.*?</section>", text, re.DOTALL)
    assert step
    shown = step[0].partition('<div class="equations">')[2]
    tables = re.findall(r"<math [^>]*block.*?</math>", shown, re.DOTALL)
    assert [table.count("<mtr>") for table in tables] == [1, 3]


def test_rows_are_aligned_by_the_page_and_equations_that_stand_alone_by_themselves(page_of):
    """The style that every row repeated was a tenth of a page of many equations."""
    text = page_of("2R").read_text(encoding="utf-8")
    assert text.count("text-align:-webkit-right") == 1
    assert ".aligned>mtr>mtd:first-child{" in text
    assert 'class="aligned"' in text
    alone = fb.equations(fb.load("2R")).mathml()
    assert "class=" not in alone
    assert alone.count("text-align:-webkit-right") == alone.count("<mtr>")


@pytest.mark.sample(1)
@pytest.mark.parametrize(("name", "method"), [("3R", "lagrange"), ("four_bar", None)])
def test_pages_fit_a_phone_and_a_sheet_of_paper(driver, page_of, name, method):
    """On a phone lines are shorter, and what a finger touches is no smaller than it; on A4, with
    the page's margins, no equation is cut off."""
    page = page_of(name, method)
    sizes = """const all = [...document.querySelectorAll(".equations")];
    const rows = [...document.querySelectorAll(".equations .aligned > mtr")];
    return [document.documentElement.scrollWidth - innerWidth,
      all.filter(e => e.scrollWidth > e.clientWidth).length, rows.filter(row =>
      row.lastChild.getBoundingClientRect().right > innerWidth + 0.5).length,
      [...document.querySelectorAll('.short')].filter(e => e.offsetHeight).length,
      Math.min(...[...document.querySelectorAll('button, summary, .slider input')].filter(e =>
        e.offsetHeight).map(e => e.offsetHeight))]"""
    found = []
    for width, media in ((400, ""), (688, "print")):
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})
        driver.get(page.as_uri())
        found.append(driver.execute_script(sizes))
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    phone, paper = found
    assert phone[0] <= 0
    assert phone[1] <= 2  # left sides with multipliers are not broken
    assert phone[3] > 5
    assert phone[4] >= 24
    assert paper[0] <= 0
    assert paper[1:4] == [0, 0, 0]


def test_mathml_stacks_dots_above_letters_and_indices_below(driver, tmp_path: Path):
    page = tmp_path / "equations.html"
    page.write_text(
        f"<!doctype html><meta charset='utf-8'>{fb.equations(fb.planar('RR')).mathml()}"
    )
    driver.get(page.as_uri())
    letters, dots = driver.execute_script(DOTS)
    assert len(letters) == len(dots) >= 8
    for letter, dot in zip(letters, dots, strict=True):
        assert letter["height"] > 0
        assert dot["top"] <= letter["top"] + 2
    index = (
        "const m = document.querySelector('msub'); return [...m.children].map(e => "
        "e.getBoundingClientRect())"
    )
    base, low = driver.execute_script(index)
    assert low["bottom"] > base["bottom"]
    assert low["left"] >= base["right"] - 2


def _sheets(driver) -> list[str]:
    """The words on each sheet of the page, printed; the sheet's number is the first."""
    pdfium = pytest.importorskip("pypdfium2", reason="needs pypdfium2, which reads PDF")
    printed = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", {})["data"])
    with closing(pdfium.PdfDocument(printed)) as paper:
        return [" ".join(sheet.get_textpage().get_text_range().split()) for sheet in paper]


def test_a_figure_is_printed_on_the_sheet_of_its_step(driver, page_of):
    """Where a step is short: the student reads both together."""
    driver.get(page_of("2R", "newton-euler").as_uri())
    sheets = _sheets(driver)
    for step, caption in (
        ("5 The vectors", "The vectors, drawn beside"),
        ("7 Velocities of the centres of mass", "Joint rates and velocities of the centres"),
        ("8 Accelerations of the centres of mass", "Joint accelerations and accelerations of"),
    ):
        (sheet,) = (sheet for sheet in sheets if step in sheet)
        assert caption in sheet


def test_a_printed_derivation_reads_like_a_handout(driver, tmp_path: Path):
    """No legend begins a sheet, as it had gone there with the next step; sheets end between rows of
    equations and have numbers; the state to which the values belong is told once."""
    page = tmp_path / "derivation.html"
    page.write_text(fb.derive(fb.planar("RRR"), "lagrange").html())
    driver.get(page.as_uri())
    driver.execute_script("document.getElementById('fold').click()")
    sheets = _sheets(driver)
    assert sum(sheet.count("Terms from") for sheet in sheets) == 7
    assert not [sheet for sheet in sheets if sheet.split()[1:3] == ["Terms", "from"]]
    assert 6 <= len(sheets) <= 9
    assert [sheet.split()[0] for sheet in sheets] == [str(k + 1) for k in range(len(sheets))]
    whole = " ".join(sheets)
    assert whole.count("The values below equations are in SI units, at: Positions: ") == 1
    assert whole.index("SI units, at") < whole.index("1 Choose independent coordinates")
    assert "▾" not in whole
    assert "Try it" not in whole
