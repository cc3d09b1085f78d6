"""The report as text: it fetches nothing, its numbers are the data file's, a failed check stands
out, equations are there where they are short."""

import dataclasses
import re

import pytest

import freebody as fb
from support.report_numbers import Cells, compare, data_file


@pytest.fixture(scope="module", params=["2R", "ur5e", "quadrotor", "RP"])
def study(request):
    return fb.study(fb.load(request.param))


@pytest.mark.sample(1)
def test_page_is_one_file_that_fetches_nothing(study, tmp_path):
    path = study.to_html(tmp_path / "deep" / "index.html")
    page = path.read_text(encoding="utf-8")
    parsed = Cells(page)
    assert path.stat().st_size < 800_000
    assert all(a.startswith("#") or a == "data:," for a in parsed.addresses), parsed.addresses
    assert not re.search(r"url\((?!#|data:)|@import|https?://(?!www\.w3\.org)", page)
    assert parsed.tags.count("script") == 1  # its own, which the policy names by its hash
    assert {a[1:] for a in parsed.addresses if a.startswith("#")} <= set(parsed.ids)


@pytest.mark.sample(1)
def test_every_number_is_the_data_files(study, tmp_path):
    study.to_html(tmp_path / "index.html")
    cells = Cells((tmp_path / "index.html").read_text(encoding="utf-8")).cells
    assert len(cells) > 15
    with data_file(study, tmp_path) as data:
        assert compare(cells, data) == []


@pytest.mark.sample(1)
def test_failed_check_stands_out(study, tmp_path):
    bad = dataclasses.replace(study.checks[0], passed=False, value=1.0)
    failed = dataclasses.replace(study, checks=(bad, *study.checks[1:]))
    text = failed.to_html(tmp_path / "failed.html").read_text(encoding="utf-8")
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
    assert parsed.tags.count("script") == 1  # the page's own
    with data_file(study, tmp_path) as data:
        assert compare(parsed.cells, data) == []


def test_section_and_its_entry_in_the_contents(tmp_path):
    page = fb.study(fb.load("2R")).to_html(tmp_path / "index.html").read_text(encoding="utf-8")
    assert '<a href="#equations">Equations</a>' in page
    section = re.search(r'<section id="equations">.*?</section>', page, re.S)
    assert section is not None
    assert section[0].count("<mtr>") == 8  # (3.20)-(3.27)
    long = fb.study(fb.load("ur5e")).to_html(tmp_path / "long.html").read_text(encoding="utf-8")
    assert "#equations" not in long
