"""Reachable sets: the annulus of two links, the disc of three, and the arm's own postures."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb

POINTS = np.stack(np.meshgrid(np.linspace(-2, 2, 30), np.linspace(-2, 2, 28)), axis=-1)
RADIUS = np.hypot(POINTS[..., 0], POINTS[..., 1])


def test_two_links_reach_an_annulus_in_two_ways():
    arm = fb.planar("RR", l=[1.0, 0.6], lc=[0.5, 0.3], m=[1.0, 1.0], I=[0.1, 0.1])
    found = fb.workspace(arm, POINTS)
    inside = (RADIUS > 0.4) & (RADIUS < 1.6)
    assert (found.ways == np.where(inside, 2, 0)).all()
    assert (found.reached == inside).all()
    assert not found.redundant
    away = np.maximum(np.maximum(RADIUS - 1.6, 0.4 - RADIUS), 0.0)
    assert np.abs(found.distance - away).max() < 1e-12
    assert repr(found).startswith(
        f"<Workspace: frame 'tip' reaches {inside.sum()} of {inside.size} points"
    )


def test_a_direction_of_the_last_link_moves_the_annulus():
    """With the last link turned by φ, its joint, at p - l3 (cos φ, sin φ), is in the annulus of the
    first two."""
    arm = fb.planar("RRR", l=[1.0, 0.6, 0.3], lc=[0.5, 0.3, 0.1], m=[1.0] * 3, I=[0.1] * 3)
    angles = np.array([0.3, 2.0, -1.2])
    R = np.array([[[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in angles])
    found = fb.workspace(arm, POINTS, orientation=R)
    wrist = POINTS[..., None, :] - 0.3 * R[:, :, 0]
    r = np.hypot(wrist[..., 0], wrist[..., 1])
    assert (found.ways == np.where((r > 0.4) & (r < 1.6), 2, 0)).all()
    assert (found.reached == (found.ways > 0).any(axis=-1)).all()
    assert np.allclose(found.share, (found.ways > 0).mean(axis=-1))
    one = fb.workspace(arm, POINTS, orientation=R[1])
    assert (one.ways == found.ways[..., 1]).all()
    assert "3 orientations" in repr(found)
    free = fb.workspace(arm, [[0.05, 0.0], [0.9, 1.2], [1.6, 1.2]])
    assert free.redundant
    assert free.ways.tolist() == [0, 1, 0]
    assert "any number" in free._repr_html_()


def test_limits_count():
    arm = fb.planar("RR", l=[1.0, 0.6], lc=[0.5, 0.3], m=[1.0, 1.0], I=[0.1, 0.1])
    upper = {f"joint2.limits.{end}": x for end, x in (("lower", 0.0), ("upper", 3.0))}
    assert set(np.unique(fb.workspace(arm.bind(upper), POINTS).ways)) == {0, 1}


def test_an_arm_reaches_its_own_postures():
    arm = fb.load("ur5e")
    q, _, _ = fb.random_state(arm, 3, 20)
    T = fb.forward_kinematics(arm, q)
    for k in range(5):
        found = fb.workspace(arm, T[:, :3, 3], orientation=T[k, :3, :3])
        assert found.ways[k] > 0
    poses = fb.inverse_kinematics(arm, T[4])
    assert found.ways[4] == (poses.valid & poses.within_limits).sum()


def test_a_family_is_its_members():
    """An annulus for each length, with and without orientations; and as a dataset."""
    arm = fb.planar("RR", l=[1.0, 0.6], lc=[0.5, 0.3], m=[1.0, 1.0], I=[0.1, 0.1])
    lengths = np.array([0.9, 1.0, 1.2])
    points = POINTS[::7, ::8]
    r = RADIUS[::7, ::8, None]
    found = fb.workspace(arm.bind(l1=lengths), points)
    inside = (r > np.abs(lengths - 0.6)) & (r < lengths + 0.6)
    assert (found.ways == np.where(inside, 2, 0)).all()
    assert (found.reached == inside).all()
    assert "of 3 members" in repr(found)
    table = found.to_xarray()
    assert table["ways"].dims == ("point0", "point1", "member")
    assert (table["x"].values == points[..., 0]).all()
    assert table["distance"].attrs["units"] == "m"
    three = fb.planar("RRR", l=[1.0, 0.6, 0.3], lc=[0.5, 0.3, 0.1], m=[1.0] * 3, I=[0.1] * 3)
    turns = np.array([[[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in (0.3, 2.0)])
    family = three.bind(l1=[0.9, 1.2])
    found = fb.workspace(family, points, orientation=turns)
    assert found.ways.shape == (*points.shape[:2], 2, 2)
    for k in range(2):
        one = fb.workspace(family[k], points, orientation=turns)
        assert (found.ways[..., k] == one.ways).all()
        assert (found.share[..., k] == one.share).all()
        assert np.allclose(found.distance[..., k], one.distance, atol=1e-12)
    assert found.to_xarray()["ways"].dims == ("point0", "point1", "orientation", "member")


def test_a_five_bar_reaches_where_both_arms_do():
    """Two ways for each of two arms whose tips are pinned together: where two annuli overlap."""
    model = fb.load("five_bar")
    q = fb.assemble(model, {"theta1": 2.0, "theta2": 0.9})
    feet, elbows, tip = [], [], fb.forward_kinematics(model, q)[:2, 2]
    for body in model.bodies:
        at = fb.forward_kinematics(model, q, frame=body.name)[:2, 2]
        (feet if body.parent < 0 else elbows).append(at)
    assert len(feet) == len(elbows) == 2
    points = np.stack(np.meshgrid(np.linspace(-1, 2, 7), np.linspace(-0.9, 1.2, 6)), axis=-1)
    points = np.concatenate([points.reshape(-1, 2), tip[None]])
    found = fb.workspace(model, points)
    ways = np.ones(len(points), dtype=int)
    for foot, elbow in zip(feet, elbows, strict=True):
        upper, fore = np.linalg.norm(elbow - foot), np.linalg.norm(tip - elbow)
        r = np.linalg.norm(points - foot, axis=-1)
        ways *= np.where((r > abs(upper - fore)) & (r < upper + fore), 2, 0)
    assert (found.ways == ways).all()
    assert found.ways[-1] == 4
    assert not found.redundant
    assert (np.isnan(found.distance) == (ways == 0)).all()


def test_refusals():
    arm = fb.load("2R")
    for words, call in (
        ("points has shape", lambda: fb.workspace(arm, [1.0, 2.0, 3.0])),
        ("points", lambda: fb.workspace(arm, [np.nan, 0.0])),
        ("orientation has shape", lambda: fb.workspace(arm, [1.0, 0.0], orientation=[1.0])),
        ("not a pose", lambda: fb.workspace(arm, [1.0, 0.0], orientation=2 * np.eye(2))),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            call()
