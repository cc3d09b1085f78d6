"""Curves of singular positions: on them geometry says what it must, and drawings hold them as
data."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


@pytest.fixture(scope="module")
def five_bar() -> fb.Model:
    return fb.load("five_bar")


def columns(model: fb.Model, q: np.ndarray) -> dict[str, np.ndarray]:
    return {name: q[..., k] for k, name in enumerate(model.velocity_names)}


def test_second_type_has_both_distal_links_on_one_line(five_bar: fb.Model):
    loci = fb.singularity_loci(five_bar, "second")
    assert len(loci) >= 2
    for locus in loci:
        assert locus.closed
        at = columns(five_bar, locus.q)
        between = at["theta1"] + at["B"] - at["theta2"] - at["D"]
        np.testing.assert_allclose(np.sin(between), 0.0, atol=1e-7)
        assert {fb.input_output(five_bar, q).kind for q in locus.q[::20]} <= {"second", "third"}


def test_first_type_has_a_crank_and_its_distal_link_on_one_line(five_bar: fb.Model):
    loci = fb.singularity_loci(five_bar, "first")
    assert len(loci) >= 4  # either side stretched or folded, as far as the other reaches
    for locus in loci:
        at = columns(five_bar, locus.q)
        np.testing.assert_allclose(np.sin(at["B"]) * np.sin(at["D"]), 0.0, atol=1e-7)
        assert {fb.input_output(five_bar, q).kind for q in locus.q[::20]} <= {"first", "third"}


def test_every_position_of_a_locus_is_closed(five_bar: fb.Model):
    (locus, *_) = fb.singularity_loci(five_bar, "second")
    np.testing.assert_allclose(fb.assemble(five_bar, locus.q), locus.q, atol=1e-9)


def test_a_slider_crank_has_dead_centres():
    model = fb.load("slider_crank")
    loci = fb.singularity_loci(model, "first", rows=["vx"])
    l1, l2 = model.parameters["l1"], model.parameters["l2"]
    assert l1 is not None
    assert l2 is not None
    guide = sorted({round(float(columns(model, locus.q)["guide"][0]), 9) for locus in loci})
    np.testing.assert_allclose(guide, [-(l1 + l2), l1 - l2, l2 - l1, l1 + l2], atol=1e-9)
    assert all(len(locus.q) == 1 for locus in loci)
    assert (
        fb.singularity_loci(model, "second", rows=["vx"]) == ()
    )  # the rod is longer than the crank


def test_three_degrees_of_freedom_need_one_held():
    model = fb.load("3RRR")
    with pytest.raises(
        fb.FreebodyError, match=r"has 3 degrees of freedom; hold 1 coordinate with hold="
    ):
        fb.singularity_loci(model, "second")
    locus = fb.singularity_loci(model, "second", hold={"pose.theta": 0.2})[0]
    np.testing.assert_allclose(columns(model, locus.q)["pose.theta"], 0.2, atol=1e-9)


def test_refused(five_bar: fb.Model):
    with pytest.raises(fb.FreebodyError, match="no kind 'third' in singularity_loci"):
        fb.singularity_loci(five_bar, "third")
    with pytest.raises(
        fb.FreebodyError, match="has 2 degrees of freedom and 1 driven joints; name as many"
    ):
        fb.singularity_loci(five_bar.replace(actuated=["theta1"]), "first")
    with pytest.raises(fb.FreebodyError, match="has no loops"):
        fb.singularity_loci(fb.load("2R"), "first")
    with pytest.raises(fb.FreebodyError, match="is in space; loci are drawn in the plane only"):
        fb.singularity_diagram(fb.load("stewart"))


def test_the_diagram_holds_the_curves_of_the_tip(five_bar: fb.Model):
    drawn = fb.singularity_diagram(five_bar)
    curve = np.array(drawn.named("type 1, curve 1").points)
    b, l1, l3 = (five_bar.parameters[name] or 0.0 for name in ("b", "l1", "l3"))
    # one side stretched or folded: the tip is on a circle about A or C, both sides alike
    reach = [np.hypot(curve[:, 0] - x, curve[:, 1]) for x in (-b, b)]
    assert min(np.abs(r - radius).max() for r in reach for radius in (l1 + l3, abs(l1 - l3))) < 1e-7
    assert "type 2" in drawn.svg
