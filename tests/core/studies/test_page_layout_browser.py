"""The page of a study as it is laid out: the width of a window is used, texts of pictures do not
overlap, on paper no table is split from its head and no sheet is left half empty."""

from __future__ import annotations

import base64
import re

import numpy as np
import pytest

import freebody as fb
from support.browser import browser

pytestmark = pytest.mark.browser

USED = """const main = document.querySelector('main').getBoundingClientRect(), rows = {};
for (const section of document.querySelectorAll('header,section')) {
  const boxes = [...section.children].filter(e => e.matches('.scroll,figure,ul,p,div,dl'))
    .map(e => e.getBoundingClientRect());
  for (const b of boxes) if (b.height > 60) {
    const row = rows[Math.round(b.top)] ||= [0, 0, 0];
    row[0] += b.width; row[1] = Math.max(row[1], b.height);
  }
}
const all = Object.values(rows), inner = main.width - 64;
const total = area => all.reduce((sum, row) => sum + area(row), 0);
return total(row => row[0] * row[1]) / total(row => inner * row[1])"""
"""The share that contents take of the area of all rows of them."""
OVERLAPS = """const found = [];
for (const svg of document.querySelectorAll('figure svg')) {
  const texts = [...svg.querySelectorAll('text')], frame = svg.getBoundingClientRect();
  const boxes = texts.map(t => t.getBoundingClientRect());
  boxes.forEach((a, i) => {
    if (a.left < frame.left - 1 || a.right > frame.right + 1)
      found.push(svg.getAttribute('aria-label') + ': cut ' + texts[i].textContent);
    boxes.slice(0, i).forEach((b, j) => {
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 1 && high > 4) found.push(svg.getAttribute('aria-label') + ': '
        + texts[i].textContent + ' on ' + texts[j].textContent);
    });
  });
}
return found"""
TABLES = """return [...document.querySelectorAll('section .scroll')]
  .filter(e => !e.closest('details') && e.querySelector('caption')).map(e => [
    e.matches('.whole'), e.querySelector('thead').innerText,
    [...e.querySelectorAll('tbody tr')].map(r => r.innerText)])"""
HEADS = "return [...document.querySelectorAll('section h2,section h3')].map(e => e.textContent)"
RANGES = """return [...document.querySelectorAll('#motion .scroll')].map(e => [
  `${e.closest('details') !== null}`,
  [...e.querySelectorAll('tbody th')].map(x => x.textContent)])"""
"""Whether a table of what moves is folded, and the names of its rows."""
ROOM = "return [document.documentElement.scrollWidth, document.documentElement.clientWidth]"


@pytest.fixture(scope="module", params=[pytest.param("ur5e", marks=pytest.mark.long), "five_bar"])
def path(request, tmp_path_factory):
    study = fb.study(fb.load(request.param))
    return study.to_html(tmp_path_factory.mktemp("page") / "index.html")


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


def resize(driver, width: int) -> None:
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def test_the_width_of_a_window_is_used(path, chromium):
    chromium.get(path.as_uri())
    for width, least in ((1400, 0.72), (1100, 0.72), (500, 0.9)):
        resize(chromium, width)
        needed, room = chromium.execute_script(ROOM)
        assert needed <= room, width
        assert chromium.execute_script(USED) > least, width


def test_texts_of_pictures_stand_on_no_other(path, chromium):
    resize(chromium, 1400)
    chromium.get(path.as_uri())
    assert chromium.execute_script(OVERLAPS) == []


def squeezed(text: str) -> str:
    """A text without what is white in it, and without the hyphens at the ends of its lines."""
    return re.sub(r"\s|\ufffe|\u00ad", "", text)


@pytest.fixture(scope="module")
def sheets(path, chromium):
    """(text, share of its height that is used) of each sheet of the printed page."""
    pdfium = pytest.importorskip("pypdfium2", reason="needs pypdfium2, which reads PDF")
    chromium.get(path.as_uri())
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    options = {"preferCSSPageSize": True, "printBackground": True}
    size = {"paperWidth": 8.27, "paperHeight": 11.69}
    printed = chromium.execute_cdp_cmd("Page.printToPDF", {**options, **size})["data"]
    found = []
    for sheet in pdfium.PdfDocument(base64.b64decode(printed)):
        text = squeezed(sheet.get_textpage().get_text_range())
        dark = np.asarray(sheet.render(scale=0.5).to_numpy()).min(axis=(1, 2)) < 200
        dark = dark[: int(len(dark) * (1 - 17 / 297))]  # above the number of the sheet
        found.append((text, np.flatnonzero(dark).max(initial=0) / len(dark)))
    return found


def test_no_table_is_split_from_its_head_on_paper(sheets, path, chromium):
    """One that fits on a sheet is whole; a longer one has its head on each of its sheets."""
    tables = chromium.execute_script(TABLES)
    assert len(tables) > 4
    for whole, head, rows in tables:
        places = [k for k, (text, _) in enumerate(sheets) if squeezed(head) in text]
        assert places, head
        if whole:
            text = sheets[places[0]][0]
            after = text[text.index(squeezed(head)) :]
            assert squeezed("".join(rows)) in after, head
        else:
            for row in rows:
                assert any(squeezed(row) in sheets[k][0] for k in places), (head, row)


def test_no_heading_ends_a_sheet(sheets, path, chromium):
    heads = chromium.execute_script(HEADS)
    assert len(heads) > 8
    for text, _ in sheets:
        above = text.rstrip("0123456789")  # the number of the sheet
        assert not any(above.endswith(squeezed(head)) for head in heads), above[-60:]


def test_of_a_closed_chain_the_drives_stand_in_front(path, chromium):
    """The rows of what moves are those of the drives, the others folded; all loads have a value."""
    chromium.get(path.as_uri())
    rows = dict(chromium.execute_script(RANGES))
    model = fb.load(chromium.execute_script("return document.querySelector('h1').textContent"))
    folded = {"true": sorted({*model.velocity_names} - {*model.driven_names})}
    assert rows == {"false": list(model.driven_names)} | (folded if model.loops else {})
    loads = chromium.execute_script("return document.getElementById('reactions').innerText")
    assert "–" not in loads.partition("Peak loads on")[2]
    for name in model.reaction_names:
        assert name in loads


def test_no_sheet_is_left_half_empty(sheets):
    assert len(sheets) > 3
    assert min(used for _, used in sheets[:-1]) > 0.6


def test_a_study_prints_itself(tmp_path, monkeypatch):
    """The PDF of the program is a PDF of several sheets; without a browser the error says what to
    install, before anything is computed."""
    study = fb.study(fb.load("2R"))
    printed = study.to_pdf(tmp_path / "deep" / "report.pdf").read_bytes()
    assert printed.startswith(b"%PDF-")
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) > 2
    monkeypatch.setenv("FREEBODY_BROWSER", str(tmp_path / "none"))
    with pytest.raises(fb.FreebodyError, match="is no program that can be run"):
        study.to_pdf(tmp_path / "none.pdf")
    failing = tmp_path / "failing"
    failing.write_text("#!/bin/sh\necho no display >&2\nexit 3\n")
    failing.chmod(0o755)
    monkeypatch.setenv("FREEBODY_BROWSER", str(failing))
    with pytest.raises(fb.FreebodyError, match=r"printed nothing \(exit status 3\): no display"):
        study.to_pdf(tmp_path / "none.pdf")
    monkeypatch.delenv("FREEBODY_BROWSER")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(fb.FreebodyError, match="Install one"):
        study.to_pdf(tmp_path / "none.pdf")
