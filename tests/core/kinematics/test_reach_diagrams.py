"""Ellipsoids and maps, as numbers and as drawings."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import freebody as fb
from freebody.figures.drawing import Arrow, Cells, Line, places
from freebody.figures.ellipsoid_diagram import outline
from freebody.figures.map_diagram import coloured
from freebody.figures.view import axonometric

ARM = fb.planar("RR", l=[1.0, 0.7], lc=[0.5, 0.3], m=[1.0, 1.0], I=[0.1, 0.1])
X, Y = np.meshgrid(np.linspace(-2.0, 2.0, 21), np.linspace(-2.0, 2.0, 17))
GRID = np.stack([X, Y], axis=-1)


# ---------------------------------------------------------------- ellipsoids
@pytest.mark.parametrize("task", ["position", "orientation"])
def test_velocities_and_forces_lie_on_the_ellipsoids(task):
    """J q̇ of rates of length 1 is on or in the one: vᵀ (J Jᵀ)⁻¹ v <= 1; of forces on the other,
    fᵀ J Jᵀ f = 1."""
    model = fb.load("ur5e")
    q, rates, _ = fb.random_state(model, 1, 30)
    found = fb.ellipsoids(model, q, task=task)
    J = fb.jacobian(model, q)[:, :3] if task == "position" else fb.jacobian(model, q)[:, 3:]
    A = J @ np.swapaxes(J, -1, -2)
    assert np.allclose(found.directions @ np.swapaxes(found.directions, -1, -2), np.eye(3))
    assert np.allclose(np.einsum("nij,nik->njk", found.velocity, found.velocity), A, atol=1e-12)
    assert np.allclose(np.einsum("nki,nij,nkj->nk", found.force, A, found.force), 1.0)
    v = np.einsum("nij,nj->ni", J, rates / np.linalg.norm(rates, axis=-1, keepdims=True))
    assert (np.einsum("ni,nij,nj->n", v, np.linalg.inv(A), v) <= 1.0 + 1e-9).all()
    assert np.allclose(found.singular_values, fb.dexterity(model, q, task=task).singular_values)
    one = fb.ellipsoids(model, q[3], task=task)
    assert (one.directions == found.directions[3]).all()
    assert ("m/s" in one._repr_html_()) is (task == "position")


def test_a_straight_arm_bears_any_force_along_itself():
    found = fb.ellipsoids(ARM, [0.0, 0.0])
    assert np.allclose(found.velocity, [[0.0, np.hypot(1.7, 0.7)], [0.0, 0.0]])
    assert np.abs(found.force[1, 0]) == np.inf
    assert "∞" in found._repr_html_()


def test_ellipsoids_are_drawn_at_the_tip():
    q = np.array([0.6, 1.0])
    drawing = fb.ellipsoid_diagram(ARM, q).drawing
    found = fb.ellipsoids(ARM, q)
    tip = fb.forward_kinematics(ARM, q)[:2, 2]
    for name, axes in (("velocity", found.velocity), ("force", found.force)):
        rim, scale = drawing.named(name), None
        assert isinstance(rim, Line)
        for k in (1, 2):
            axis = drawing.named(f"{name} axis {k}")
            assert isinstance(axis, Arrow)
            assert np.allclose(axis.value, axes[k - 1])
            assert np.allclose(axis.start, tip)
            length = np.linalg.norm(np.subtract(axis.end, tip)) / np.linalg.norm(axis.value)
            scale = scale or length
            assert length == pytest.approx(scale)
        around = (np.asarray(rim.points) - tip) / scale
        A = axes.T @ axes
        assert np.allclose(np.einsum("ni,ij,nj->n", around, np.linalg.inv(A), around), 1.0)
    straight = fb.ellipsoid_diagram(ARM, [0.3, 0.0]).drawing
    assert any("singular" in note for note in straight.notes)
    with pytest.raises(fb.FreebodyError, match="no element 'force'"):
        straight.named("force")


def test_the_rim_of_an_ellipsoid_is_where_it_ends_for_the_eye():
    rng = np.random.default_rng(0)
    axes, view = rng.normal(size=(3, 3)), axonometric(30.0)
    on = rng.normal(size=(20000, 3))
    seen = view.project(on / np.linalg.norm(on, axis=-1, keepdims=True) @ axes)
    rim = view.project(outline(axes, view))
    for angle in np.linspace(0.0, np.pi, 7):
        way = np.array([np.cos(angle), np.sin(angle)])
        assert (seen @ way).max() == pytest.approx((rim @ way).max(), rel=0.01)


# ---------------------------------------------------------------- maps
def test_a_map_shows_each_value_at_its_place():
    found = fb.workspace(ARM, GRID)
    shown = np.where(found.reached, found.ways, np.nan)
    figure = fb.map_diagram(ARM, GRID, shown, [0.3, 0.8], title="ways <1 & 2>")
    cells = figure.drawing.named("map")
    assert isinstance(cells, Cells)
    step = np.asarray(cells.across), np.asarray(cells.up)
    seen = set()
    for i, row in enumerate(cells.colours):
        for j, colour in enumerate(row):
            middle = np.asarray(cells.corner) + (j + 0.5) * step[0] + (i + 0.5) * step[1]
            at = np.unravel_index(np.argmin(np.linalg.norm(GRID - middle, axis=-1)), X.shape)
            assert np.allclose(GRID[at], middle)
            assert (colour >= 0) == found.reached[at]
            seen.add(at)
    assert {tuple(x) for x in np.argwhere(found.reached)} <= seen
    low, high = np.min(places(cells), axis=0), np.max(places(cells), axis=0)
    assert np.allclose(low, -high)
    root = ET.fromstring(figure.svg)
    assert not re.search(r'(?:href|src)="(?!#)|url\(|<script', figure.svg)
    texts = ["".join(e.itertext()) for e in root.iter("{http://www.w3.org/2000/svg}text")]
    assert "ways <1 & 2>" in texts
    assert "2" in texts


def test_colours_fill_the_cells_of_their_values():
    """A strip of six by one cells, off the middle: as drawn six steps across wide, one up tall,
    next to the arm's own places."""
    shown = np.full(X.shape, np.nan)
    shown[12, 3:9] = 5.0
    figure = fb.map_diagram(ARM, GRID, shown, [0.3, 0.8])
    corners = np.array(places(figure.drawing.named("map")))
    assert np.allclose(corners.min(axis=0), GRID[12, 3] - [0.1, 0.125])
    assert np.allclose(corners.max(axis=0), GRID[12, 8] + [0.1, 0.125])
    (d,) = re.findall(r'<path class="m0" d="([^"]*)"/>', figure.svg)[:1]
    wide, tall = np.ptp(np.array(re.findall(r"([\d.]+) ([\d.]+)", d), dtype=float), axis=0)
    assert wide / tall == pytest.approx(6 * 0.2 / 0.25, rel=0.02)


@pytest.mark.parametrize("values", [[1.0, 2.0, 5.0], [0.013, 0.4, 0.1, 0.33], [-7.5, 1e4]])
def test_the_key_tells_what_a_colour_means(values):
    numbers, key = coloured(np.array([[*values, np.nan]]), "")
    assert numbers[0, -1] == -1
    assert len(key.texts) == len(key.colours) + key.between
    edges = [float(x.replace("−", "-")) for x in key.texts]
    for value, colour in zip(values, numbers[0, :-1], strict=True):
        k = key.colours.index(colour)
        if key.between:
            assert edges[k] <= value <= edges[k + 1]
        else:
            assert edges[k] == value
    assert len(set(key.colours)) == len(key.colours) <= 8


def test_slices_of_space_stand_where_they_are():
    model = fb.load("ur5e")
    up = np.stack([X, np.full_like(X, 0.2), Y], axis=-1)
    for grid in (up, up[..., [0, 2, 1]], up.transpose(1, 0, 2)):
        drawing = fb.map_diagram(model, grid, grid[..., 0]).drawing
        cells = drawing.named("map")
        assert np.allclose(np.mean(places(cells), axis=0), grid.mean(axis=(0, 1)))
        normal = np.cross(cells.across, cells.up)
        assert abs(normal @ drawing.view.towards) > 0.5 * np.linalg.norm(normal)
    empty = fb.map_diagram(model, up, np.full_like(X, np.nan))
    assert "<svg" in empty.svg


def test_refusals():
    uneven = GRID.copy()
    uneven[3, 4, 0] += 0.01
    line = np.stack([X, X], axis=-1)
    for words, call in (
        ("points has shape", lambda: fb.map_diagram(ARM, [[0.0, 0.0]], [[0.0]])),
        ("values has shape", lambda: fb.map_diagram(ARM, GRID, X[0])),
        ("no even grid", lambda: fb.map_diagram(ARM, uneven, X)),
        ("no even grid", lambda: fb.map_diagram(ARM, line, X)),
        ("infinity", lambda: fb.map_diagram(ARM, GRID, np.full_like(X, np.inf))),
        ("do not compare", lambda: fb.ellipsoids(ARM, [0.1, 0.2], task="pose")),
        ("closed chain", lambda: fb.ellipsoids(fb.load("five_bar"), np.zeros(5))),
        ("closed chain", lambda: fb.ellipsoid_diagram(fb.load("five_bar"))),
        ("family", lambda: fb.ellipsoids(ARM.bind({"link1.mass": [1.0, 2.0]}), [0.1, 0.2])),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            call()
