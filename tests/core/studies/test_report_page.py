"""The report as text: it fetches nothing, its numbers are the data file's, a failed check stands
out."""

import dataclasses
import re
from html.parser import HTMLParser

import pytest

import freebody as fb
from freebody.outputs.number_text import significant
from freebody.report.tables import PrintedNumber, WordsCell, aligned, typeset
from support.report_numbers import compare, data_file


class Cells(HTMLParser):
    """Number cells of a page, and every address that it names."""

    def __init__(self, page: str):
        super().__init__()
        self.cells, self.addresses, self.ids, self.tags = [], [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.tags.append(tag)
        self.addresses += [
            given[k] for k in ("href", "src", "srcset", "action", "data") if k in given
        ]
        self.ids += [given["id"]] if "id" in given else []
        if "data-var" in given:
            self.cells.append({"var": given["data-var"], "at": given["data-at"],
                               "value": given["data-value"],
                               "scale": given.get("data-scale", "1"), "text": ""})  # fmt: skip
        self.inside = tag == "span" and bool(self.cells)

    def handle_data(self, data):
        if getattr(self, "inside", False):
            self.cells[-1]["text"] += data

    def handle_endtag(self, tag):
        self.inside = False


def test_what_is_at_its_limit_is_not_marked_as_beyond():
    """As the verdict: a speed of 1.0000000000000002 of 1 rad/s is within."""
    at, beyond = (PrintedNumber(x, "speed", {}, bar=x) for x in (1.0 + 1e-15, 1.001))
    assert (at.over, beyond.over, PrintedNumber(2.0, "speed", {}).over) == (False, True, False)


@pytest.fixture(scope="module", params=["2R", "ur5e", "quadrotor", "RP"])
def study(request):
    return fb.study(fb.load(request.param))


def test_page_is_one_file_that_fetches_nothing(study, tmp_path):
    path = study.to_html(tmp_path / "deep" / "index.html")
    page = path.read_text(encoding="utf-8")
    parsed = Cells(page)
    assert path.stat().st_size < 600_000
    assert all(a.startswith("#") or a == "data:," for a in parsed.addresses), parsed.addresses
    assert not re.search(r"url\((?!#|data:)|@import|https?://(?!www\.w3\.org)", page)
    assert "script" not in parsed.tags
    assert {a[1:] for a in parsed.addresses if a.startswith("#")} <= set(parsed.ids)


def test_every_number_is_the_data_files(study, tmp_path):
    study.to_html(tmp_path / "index.html")
    cells = Cells((tmp_path / "index.html").read_text(encoding="utf-8")).cells
    assert len(cells) > 15
    with data_file(study, tmp_path) as data:
        assert compare(cells, data) == []


def test_failed_check_stands_out(study):
    bad = dataclasses.replace(study.checks[0], passed=False, value=1.0)
    page = dataclasses.replace(study, checks=(bad, *study.checks[1:]))
    from freebody.report.page import page as written

    text = written(page)
    assert f'class="badge bad" href="#checks">1 of {len(study.checks)} self-checks failed' in text
    assert '<td class="bad">failed</td>' in text
    assert "checks passed" not in text


def test_names_from_a_file_are_text_not_markup(tmp_path):
    source = tmp_path / "arm.urdf"
    source.write_text(
        '<robot name="a&lt;b&gt;"><link name="base"/><link name="l&lt;script&gt;"><inertial><mass '
        'value="1"/>'
        '<origin xyz="0.1 0 0"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link>'
        '<joint name="j&amp;&quot;" type="continuous"><parent link="base"/><child '
        'link="l&lt;script&gt;"/>'
        '<axis xyz="0 1 0"/></joint></robot>',
        encoding="utf-8",
    )
    study = fb.study(fb.load(source))
    path = study.to_html(tmp_path / "index.html")
    parsed = Cells(path.read_text(encoding="utf-8"))
    assert "script" not in parsed.tags
    with data_file(study, tmp_path) as data:
        assert compare(parsed.cells, data) == []


# ---------------------------------------------------------------- how numbers are printed
def numbers(*values: float) -> list[str]:
    return [cell.text for cell in aligned([PrintedNumber(v, "x", {}) for v in values])]


def test_column_has_one_number_of_decimals():
    assert numbers(-67.27, 2.72, 1.82, 5.62) == ["−67.27", "2.72", "1.82", "5.62"]
    assert numbers(1234.5, 12.25, 0.5) == ["1234.5", "12.2", "0.5"]


def test_small_and_missing_numbers_are_not_printed_as_zero():
    assert numbers(67.0, 5.0, 0.000946) == ["67.00", "5.00", "9.5·10⁻⁴"]
    assert numbers(67.0, 5.0, 1e-15) == ["67.00", "5.00", "0"]
    assert numbers(float("nan"), float("inf"), 2.0) == ["–", "∞", "2.00"]
    assert aligned([WordsCell("word")]) == [WordsCell("word")]


@pytest.mark.parametrize(
    ("value", "text"), [(0, "0"), (3.14159, "3.14"), (-2e-7, "−2.00·10⁻⁷"), (123456, "1.23·10⁵")]
)
def test_significant_digits(value, text):
    assert significant(value) == text


def test_sentences_are_typeset_and_escaped():
    assert typeset("needs -67.27 N m <at> 1.96e+04, 10^3.2-fold") == (
        "needs −67.27 N m &lt;at&gt; 1.96·10⁴, 10<sup>3.2</sup>-fold"
    )
