"""Equations in the report: there for small arms, by base parameters where that is what is short,
else absent."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest

import freebody as fb
from freebody_textbook.in_studies import shown
from support.symbolic import spatial_arm, with_values


@pytest.mark.parametrize("name", ["2R", "3R", "RP", "gyro", "scara"])
def test_equations_of_small_arms_are_in_the_report(name):
    found = shown(fb.load(name))
    assert found is not None
    assert ET.fromstring(found.mathml).tag == "{http://www.w3.org/1998/Math/MathML}math"


def test_equations_that_are_short_by_base_parameters_only():
    model = with_values(spatial_arm(11, 4))
    found = shown(model)
    assert not fb.equations(model).is_short
    assert found is None or found.base


@pytest.mark.parametrize("name", ["ur5e", "panda", "quadrotor"])
def test_long_equations_are_left_out(name):
    assert shown(fb.load(name)) is None


def test_section_and_its_entry_in_the_contents(tmp_path):
    page = fb.study(fb.load("2R")).to_html(tmp_path / "index.html").read_text(encoding="utf-8")
    assert '<a href="#equations">Equations</a>' in page
    section = re.search(r'<section id="equations">.*?</section>', page, re.S)
    assert section is not None
    assert section[0].count("<mtr>") == 8  # (3.20)-(3.27)
    long = fb.study(fb.load("ur5e")).to_html(tmp_path / "long.html").read_text(encoding="utf-8")
    assert "#equations" not in long
