"""Plots and maps of a page: names stand beside their own curves and on nothing else, a second axis
says the same in another unit, contours are where the values are."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from freebody.figures.curve_names import named_curves
from freebody.figures.marked_text import width
from freebody.figures.plane_map import PlaneMap, contour, plane_map
from freebody.figures.plots import Plot, plot

BOX = (50.0, 40.0, 330.0, 170.0)
PALER = 6.0  # pixels that letters reach above and below the middle of their line


def curves(seed: int, count: int) -> dict[str, np.ndarray]:
    """Smooth curves in a plot's box, with names of some length."""
    rng = np.random.default_rng(seed)
    x = np.linspace(BOX[0], BOX[2], 60)
    waves = rng.uniform(0.2, 3.0, count), rng.uniform(0.0, 6.0, count), rng.uniform(0.1, 1.0, count)
    found = {}
    for k, (pace, phase, size) in enumerate(zip(*waves, strict=True)):
        y = 105.0 + 60.0 * size * np.sin(pace * (x - 50.0) / 45.0 + phase)
        found["joint" * (1 + k % 3) + str(k)] = np.stack([x, y], axis=-1)
    return found


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 8))
def test_names_stand_beside_their_curves_and_on_nothing_else(seed: int, count: int):
    drawn = curves(seed, count)
    taken = [(180.0, 40.0, 230.0, 60.0)]
    placed = named_curves(drawn, BOX, taken)
    boxes = [*taken]
    for label in placed:
        half = width(label.name, 12.0) / 2
        left, right = label.at.real - half, label.at.real + half
        top, bottom = label.at.imag - 4 - PALER, label.at.imag - 4 + PALER
        assert BOX[0] <= left < right <= BOX[2]
        assert BOX[1] <= top < bottom <= BOX[3]
        for a, b, c, d in boxes:
            assert right <= a or left >= c or bottom <= b or top >= d
        boxes.append((left, top, right, bottom))
        x, y = drawn[label.name].T
        beside = np.hypot(np.clip(x, left, right) - x, np.clip(y, top, bottom) - y)
        assert beside.min() < 30.0
        for points in drawn.values():
            inside = (points > (left, top)) & (points < (right, bottom))
            assert inside.all(axis=1).sum() <= 3


def test_most_names_find_a_place():
    """A legend is the exception: of three waves at least two are named beside themselves."""
    named = [len(named_curves(curves(seed, 3), BOX)) for seed in range(20)]
    assert np.mean(named) > 2.0


def test_a_second_axis_says_the_same_in_another_unit():
    t = np.linspace(0.0, 1.0, 20)
    what = Plot("Speed", t, {"a": 3.0 * t}, "rad/s", also=(30.0 / np.pi, "rpm"), peaks=False)
    texts = list(ET.fromstring(f"<g>{plot(what).body}</g>").iter("text"))
    ticks = [(x.get("text-anchor"), float(x.get("y", 0)), x.text or "") for x in texts
             if x.get("class") == "tick" and x.get("text-anchor") != "middle"]  # fmt: skip
    heights = [
        np.array(
            [(y, float(text.replace("−", "-"))) for anchor, y, text in ticks if anchor == side]
        )
        for side in ("end", None)
    ]
    (first, second) = (np.polyfit(side[:, 1], side[:, 0], 1) for side in heights)
    assert second[1] == pytest.approx(first[1], abs=0.2)  # zero is at one height
    assert first[0] / second[0] == pytest.approx(30.0 / np.pi, rel=0.01)


def test_contours_are_circles_of_a_cone():
    x = y = np.linspace(-1.0, 1.0, 41)
    cone = np.hypot(x[None, :], y[:, None])
    cone[:, :8] = np.nan
    ends = np.array(list(contour(x, y, cone, 0.5))).reshape(-1, 2)
    assert np.hypot(*ends.T) == pytest.approx(0.5, abs=2e-3)
    assert ends[:, 0].min() > x[8] - 1e-12
    turned = np.arctan2(ends[:, 1], ends[:, 0])
    seen = np.sort(turned[np.abs(turned) < 2.2])
    assert np.diff(seen).max() < 0.15  # without gaps: a cell is 0.1 wide seen from the middle
    assert list(contour(x, y, cone, 9.0)) == []


def test_a_saddle_is_two_lines():
    grid = np.array([0.0, 1.0])
    two = list(contour(grid, grid, np.array([[1.0, -1.0], [-1.0, 1.0]]), 0.0))
    assert len(two) == 2
    corner = np.array([[0.0, 1.0], [1.0, 0.0]])  # of the high middle the low corners are cut off
    cut = list(contour(grid, grid, np.array([[3.0, -1.0], [-1.0, 3.0]]), 0.0))
    for a, b in cut:
        assert min(np.abs(a - c).max() + np.abs(b - c).max() for c in corner) < 1.0


def test_a_map_is_read_where_most_values_are():
    """A few huge values near a singular pose leave the contours where the others are."""
    x = np.linspace(0.1, 1.0, 30)
    values = np.broadcast_to(5.0 / x, (20, 30)).copy()
    values[3, 4] = 1e6
    what = PlaneMap("Payload", "kg", x, np.linspace(0.0, 0.6, 20), values, "m out", "m up")
    assert what.levels[0] >= 5.0
    assert what.levels[-1] < 50.0
    assert len(what.levels) > 3
    text = plane_map(what).text()
    root = ET.fromstring(text)
    said = [x.text for x in root.iter("{http://www.w3.org/2000/svg}text")]
    assert sum(str(x).endswith(" kg") for x in said) >= 3
    assert {"m out", "m up", "Payload"} <= set(said)
