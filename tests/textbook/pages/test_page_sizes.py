"""Pages of derivations are small enough to be sent and opened anywhere, and bring every letter of
their formulas; those of the notes are weighed in test_notes_page.py."""

from __future__ import annotations

import pytest

import freebody as fb
from support.formula_font import lacking

LARGEST = 600_000  # bytes
LONG = {"3RRR", "bricard", "double_four_bar", "five_bar", "five_bar_rods", "four_bar", "stewart"}


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in fb.models()],
)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_the_page_of_every_bundled_robot_is_small_and_brings_its_letters(page_of, name):
    page = page_of(name)
    assert 50_000 < page.stat().st_size < LARGEST
    assert not lacking(page.read_text(encoding="utf-8"))
