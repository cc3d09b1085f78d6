"""The drawings of pages that can be tried, measured in a real browser: no label lies on another or
is cut off, the moving drawing is the figure above it, and equations are not far down."""

from __future__ import annotations

import shutil
from collections import Counter

import numpy as np
import pytest

import freebody as fb
from freebody.expressions.expression import Symbol, nodes
from freebody.expressions.printed_names import sym
from freebody.figures.drawing import Dimension
from freebody.figures.marked_text import canonical, label
from freebody_textbook.drawings.illustrate import illustrations
from freebody_textbook.living.panel import units_of_symbols
from support.page_labels import drawing_time, measured

pytestmark = [
    pytest.mark.browser,
    pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning"),
    pytest.mark.skipif(
        not (shutil.which("chromium") and shutil.which("chromedriver")),
        reason="needs chromium and chromedriver",
    ),
]

WINDOW = 1500, 1000
SAMPLE = ("3R", "RP", "four_bar", "elbow_arm")
FRAME = 16.0  # ms, between two pictures of a screen
FAR_DOWN = {"stewart"}  # tells its six loops one by one before the first equation


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "states"),
    [
        *((name, 20) for name in SAMPLE),
        *(pytest.param(name, 200, marks=pytest.mark.long) for name in fb.models()),
    ],
)
def test_no_label_lies_on_another_or_is_cut_off(driver, page_of, name, states):
    """Nor is one crossed by the leader of another; and a drawing is made in less than a frame."""
    driver.get(page_of(name).as_uri())
    found = measured(driver, states)
    assert found["labels"] > 5 * states
    assert (found["overlaps"], found["cut"]) == (0, 0), found["examples"]
    assert found["crossed"] == 0
    assert drawing_time(driver, 20) < FRAME
    assert not driver.get_log("browser")


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["statics", "lagrange", "recursive"])
def test_nor_under_a_load_or_in_other_letters(driver, page_of, method):
    driver.get(page_of("2R", method, notation="siciliano").as_uri())
    found = measured(driver, 20)
    assert (found["overlaps"], found["cut"]) == (0, 0), found["examples"]


PLACES = """return ['main > figure svg', '#arm'].map(svg => arguments[0].map(kind =>
  [...document.querySelectorAll(`${svg} .${kind}`)].map(e => e.cx
    ? [e.cx.baseVal.value, e.cy.baseVal.value]
    : (p => [p.x, p.y])(e.getPointAtLength(e.getTotalLength() / 2)))))"""
WRITTEN = """return ['main > figure svg', '#arm'].map(svg =>
  [...document.querySelectorAll(`${svg} text:not(.n)`)].map(e => e.textContent))"""


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", [*SAMPLE, "ur5e", "five_bar_rods", "furuta", "quadrotor"])
def test_the_moving_drawing_is_the_figure_above_it(driver, page_of, name):
    """At first: the same names, and centres of mass, the tip and what the angles are measured from
    at the same places."""
    driver.get(page_of(name).as_uri())
    above, moving = driver.execute_script(WRITTEN)
    assert Counter(above) == Counter(moving)
    kinds = ["com", "position-head", "guide", "axisline"]
    places = driver.execute_script(PLACES, kinds)
    still, drawn = (np.array([x for kind in found for x in kind]) for found in places)
    assert len(still) == len(drawn) > 0
    a, b = (x - x.mean(axis=0) for x in (still, drawn))
    scale = np.sqrt((b**2).sum() / max((a**2).sum(), 1e-9)) if len(a) > 1 else 1.0
    np.testing.assert_allclose(b, scale * a, atol=1.0)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name",
    [
        *SAMPLE,
        *(pytest.param(name, marks=pytest.mark.long) for name in fb.models() if name not in SAMPLE),
    ],
)
def test_every_length_in_the_equations_is_dimensioned(name):
    model = fb.load(name)
    derivation = fb.derive(model)
    units = units_of_symbols(derivation)
    lines = (line for step in derivation.steps for line in step.equations)
    spoken = {x.name for line in lines for x in nodes(line) if isinstance(x, Symbol)}
    lengths = {x for x in model.parameters if x in spoken and units.get(x) == "m"}
    elements = illustrations(derivation)["overview"].elements
    drawn = {canonical(x.label) for x in elements if isinstance(x, Dimension)}
    assert {canonical(label(sym(x))) for x in lengths} <= drawn


@pytest.mark.sample(2)
@pytest.mark.parametrize("size", [(1500, 900), (1280, 720)])
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(x, marks=[pytest.mark.long] * (x not in SAMPLE))
        for x in fb.models()
        if x not in FAR_DOWN
    ],
)
def test_the_first_equation_stands_within_a_screen_and_a_half(driver, page_of, name, size):
    width, height = size
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    driver.get(page_of(name).as_uri())
    first = driver.execute_script(
        "return [...document.querySelectorAll('.equations')].find(e => e.offsetHeight)"
        ".getBoundingClientRect().bottom"
    )
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert first < 1.5 * height
