"""What the study says an arm can lift where: by hand for two links, and nothing where no limit says
anything."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.report import page, page_figures


def test_two_links_by_hand(monkeypatch):
    """With motor 1 far stronger, motor 2 alone limits: (τ - m₂ g c₂ |cos φ|) / (g l₂ |cos φ|), φ
    being the last link's angle; of both elbows the better."""
    arm = fb.planar("RR", l=[0.5, 0.4], lc=[0.25, 0.2], m=[2.0, 1.5], I=[0.1, 0.1])
    arm = arm.bind({"joint1.limits.effort": 600.0, "joint2.limits.effort": 40.0})
    study = fb.study(arm)
    q = study.motion.q
    phi = q.sum(axis=1)
    by_hand = (40.0 - 1.5 * 9.81 * 0.2 * np.abs(np.cos(phi))) / (9.81 * 0.4 * np.abs(np.cos(phi)))
    mass = page_figures.lifting_along(study)
    assert mass is not None
    assert np.allclose(mass, by_hand, rtol=1e-9)
    seen: dict[str, np.ndarray] = {}

    def drawn(model, points, best, *more, **named):
        seen.update(points=points, best=best)
        return fb.map_diagram(model, points, best, *more, **named)

    monkeypatch.setattr(page_figures, "map_diagram", drawn)
    found = page_figures.lifting_over_plane(study)
    assert found is not None
    assert found[1] == "in any orientation"
    radius = np.linalg.norm(seen["points"], axis=-1)
    assert (np.isfinite(seen["best"]) == ((radius > 0.1) & (radius < 0.9))).all()
    i, j = np.argwhere(np.isfinite(seen["best"]))[7]
    ways = fb.inverse_kinematics(arm, seen["points"][i, j]).q.sum(axis=1)
    masses = (40.0 / np.abs(np.cos(ways)) - 1.5 * 9.81 * 0.2) / (9.81 * 0.4)
    assert np.isclose(seen["best"][i, j], masses.max(), rtol=1e-9)
    text = page.page(study)
    assert "Payload at rest" in text
    assert f"At least {by_hand.min():.3g} kg" in text
    assert "Blank points" in text
    # no closed form: no map
    monkeypatch.setattr(page_figures, "lifting_over_plane", lambda study: None)
    assert "Blank points" not in page.page(study)


def test_nothing_without_limits():
    study = fb.study(fb.load("2R"))
    assert page_figures.lifting_along(study) is None
    assert "Payload at rest" not in page.page(study)
