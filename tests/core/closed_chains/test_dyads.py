"""Positions of closed chains: assembly modes and working modes, in closed form and by search."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import freebody as fb
from support.loop_scales import residual


def distinct(q):
    """Positions up to whole turns."""
    return {tuple(np.round(np.concatenate([np.cos(x), np.sin(x)]), 6) + 0.0) for x in q}


def test_five_bar_has_four_working_and_two_assembly_modes():
    model = fb.load("five_bar")
    target = np.array([0.05, 0.6])
    found = fb.inverse_kinematics(model, target)
    assert found.method == "dyads, in closed form"
    assert set(found.branches) == {f"B {a}, D {b}" for a, b in product(("left", "right"), repeat=2)}
    assert found.residual.max() < 1e-12
    np.testing.assert_allclose(
        fb.forward_kinematics(model, found.q)[:, :2, 2], np.tile(target, (4, 1)), atol=1e-12
    )
    np.testing.assert_allclose(residual(model, found.q), 0, atol=1e-12)
    # the names say where the elbows are
    for q, name in zip(found.q, found.branches, strict=True):
        for pivot, elbow, frame in ((-0.25, "B", "distal1"), (0.25, "D", "distal2")):
            at = fb.forward_kinematics(model, q, frame)[:2, 2] - [pivot, 0]
            way = target - [pivot, 0]
            assert (f"{elbow} left" in name) == (way[0] * at[1] - way[1] * at[0] > 0)
        # and each working mode has two assembly modes, one of them itself
        modes = fb.assembly_modes(model, q, free=["B", "D"])
        assert len(modes) == 2
        np.testing.assert_allclose(modes[0], q, atol=1e-9)
    # both models of the robot agree
    rods = fb.inverse_kinematics(fb.load("five_bar_rods"), target)
    assert set(rods.branches) == set(found.branches)
    for name in found.branches:
        one, two = (x.q[list(x.branches).index(name), :2] for x in (found, rods))
        np.testing.assert_allclose(np.exp(1j * one), np.exp(1j * two), atol=1e-12)


def test_three_legs_have_eight_working_modes():
    model = fb.load("3RRR")
    c, s = np.cos(0.2), np.sin(0.2)
    target = np.array([[c, -s, 0.05], [s, c, 0.03], [0, 0, 1]])
    found = fb.inverse_kinematics(model, target)
    assert len(found) == 8
    assert len(set(found.branches)) == 8
    np.testing.assert_allclose(
        fb.forward_kinematics(model, found.q), np.tile(target, (8, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(residual(model, found.q), 0, atol=1e-12)


def test_batches_and_limits():
    model = fb.load("five_bar")
    targets = np.array([[0.05, 0.6], [0.0, 3.0], [-0.1, 0.5]])
    found = fb.inverse_kinematics(model, targets)
    assert found.q.shape == (3, 4, 4)
    assert found.count.tolist() == [4, 0, 4]
    assert np.isnan(found.q[1]).all()
    assert found.distance[1] > 2.0
    assert fb.inverse_kinematics(model, np.zeros((0, 2))).q.shape[0] == 0


def test_out_of_reach_says_how_far_and_why():
    model = fb.load("five_bar_rods")
    found = fb.inverse_kinematics(model, [1.4, 0.3])
    assert len(found) == 0
    # P reaches 1 m from A, and no farther: the nearest point is on the circle about A where C
    # allows it
    away = np.hypot(1.65, 0.3) - 1.0
    assert found.distance == pytest.approx(away, rel=1e-6)
    (note,) = found.notes
    assert f"about {away:.6g} m" in note
    assert "theta1 and P would be 1.67705 m apart; the links between them span 0.2 to 1 m" in note
    assert "0.188 m too short" in note
    slider = fb.inverse_kinematics(fb.load("slider_crank"), [0.55, 0.1])
    assert len(slider) == 0
    assert slider.distance == pytest.approx(0.1, rel=1e-6)
    # crank 0.2 m, rod 0.6 m: the slider reaches from 0.4 to 0.8 m, on one side and on the other
    for side in (-1.0, 1.0):
        slider = fb.inverse_kinematics(fb.load("slider_crank"), [0.2 * side, 0.0])
        assert slider.distance == pytest.approx(0.2, rel=1e-6)
    # half a turn stretches all three legs in the middle, and nowhere else is possible
    half = np.diag([-1.0, -1.0, 1.0])
    straight = fb.inverse_kinematics(fb.load("3RRR"), half)
    assert straight.branches.tolist() == ["elbow1 straight, elbow2 straight, elbow3 straight"]
    half[0, 2] = 0.1
    assert len(fb.inverse_kinematics(fb.load("3RRR"), half)) == 0


def test_without_closed_form_by_search():
    found = fb.inverse_kinematics(fb.load("slider_crank"), [0.55, 0.0])
    assert found.method.startswith("Levenberg")
    p = fb.load("slider_crank").parameters
    crank = np.arccos((0.55**2 + p["l1"] ** 2 - p["l2"] ** 2) / (2 * 0.55 * p["l1"]))
    assert sorted(found.q[:, 0]) == pytest.approx([-crank, crank])
    four_bar = fb.load("four_bar")
    q = fb.assemble(four_bar, [1.0, -0.5, 1.5])
    there = fb.forward_kinematics(four_bar, q)[:2, 2]
    assert distinct([q]) <= distinct(fb.inverse_kinematics(four_bar, there).q)
    loose = fb.inverse_kinematics(fb.load("five_bar"), [0.05, 0.6], task=["vy"])
    assert "can still move with its tip fixed" in loose.notes[0]
    np.testing.assert_allclose(
        fb.forward_kinematics(fb.load("five_bar"), loose.q)[:, 1, 2], 0.6, atol=1e-9
    )


def test_stewart_platform_is_held_at_a_pose():
    model = fb.load("stewart")
    target = np.eye(4)
    target[:3, 3] = [0.02, 0.03, 0.5]
    found = fb.inverse_kinematics(model, target, starts=12)
    assert len(found)
    np.testing.assert_allclose(residual(model, found.q), 0, atol=1e-10)
    np.testing.assert_allclose(
        fb.forward_kinematics(model, found.q), np.tile(target, (len(found), 1, 1)), atol=1e-9
    )


def test_rhombs_have_three_modes():
    """Of the four combinations two coincide: crank 2 folded back puts its pin as far from the third
    as links reach."""
    model = fb.load("double_four_bar")
    found = fb.assembly_modes(model, [1.0, -1.0, 1.0, -1.0, 1.0], free=["A1", "O2", "A2", "O3"])
    assert len(found) == 3
    np.testing.assert_allclose(residual(model, found), 0, atol=1e-12)


def test_pins_on_one_another_are_left_to_the_search():
    model = fb.load("double_four_bar")
    with pytest.raises(fb.FreebodyError, match="still moves with the other coordinates held"):
        fb.assembly_modes(model, np.zeros(5), free=["A1", "O2", "A2", "O3"])


@pytest.mark.parametrize("distal", [0.4, 0.6])
def test_a_target_on_a_pivot_leaves_the_others_in_closed_form(distal: float):
    """The tip at a crank's own pivot: with links of equal length the crank may stand anywhere, and
    that target is searched; with others the triangle cannot close, and nothing is."""
    model = fb.load("five_bar").bind(l3=distal, l4=distal)
    clear = np.array([0.0, 0.45]) + np.linspace(-0.04, 0.04, 14).reshape(7, 2)
    alone = fb.inverse_kinematics(model, clear)
    mixed = fb.inverse_kinematics(model, np.insert(clear, 3, [-0.25, 0.0], axis=0))
    others = np.delete(np.arange(8), 3)
    np.testing.assert_array_equal(mixed.q[others][:, :4], alone.q)
    np.testing.assert_array_equal(mixed.branches[others][:, :4], alone.branches)
    assert mixed.count[others].tolist() == [4] * 7
    pivot = fb.inverse_kinematics(model, [-0.25, 0.0])
    assert mixed.count[3] == len(pivot)
    if distal == 0.4:
        assert pivot.method.startswith("Levenberg")
        np.testing.assert_array_equal(mixed.q[3, : len(pivot)], pivot.q)
        assert len(np.unique(np.round(pivot.q[:, 0], 6))) == len(pivot) > 4  # the crank, anywhere
        np.testing.assert_allclose(residual(model, pivot.q), 0, atol=1e-11)
        assert mixed.notes[0].startswith("Where pins of a dyad lie on one another (targets 3): ")
    else:
        assert pivot.method == "dyads, in closed form"
        assert pivot.distance == pytest.approx(distal - 0.4, rel=1e-6)
        assert "theta1 and P would be 0 m apart" in pivot.notes[0]
