"""The tip along lines, arcs and rounded corners: by forward kinematics, on one branch, or why
not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

import freebody as fb

ARM = fb.load("ur5e")
Q0 = np.array([0.2, -1.2, 1.5, -1.8, -1.5, 0.3])
START = fb.forward_kinematics(ARM, Q0)
HERE = START[:3, 3]
PLANAR = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])


def moved(shift: list[float], turn: list[float] | None = None) -> np.ndarray:
    target = START.copy()
    target[:3, 3] += shift
    target[:3, :3] = START[:3, :3] @ Rotation.from_rotvec(turn or [0, 0, 0]).as_matrix()
    return target


def tip(motion: fb.Motion, model: fb.Model = ARM, count: int = 3001) -> np.ndarray:
    """Poses between samples."""
    return fb.forward_kinematics(model, motion.at(np.linspace(0, motion.duration, count))[0])


def test_the_tip_moves_straight_and_turns_about_one_axis():
    target = moved([0.1, 0.3, -0.2], [0.5, 0.2, -0.6])
    motion = fb.line(ARM, Q0, target, acceleration=3.0)
    seen, direction = tip(motion), target[:3, 3] - HERE
    share = (seen[:, :3, 3] - HERE) @ direction / (direction @ direction)
    assert (np.diff(share) > -1e-12).all()
    np.testing.assert_allclose(seen[:, :3, 3], HERE + share[:, None] * direction, atol=1e-6)
    both = Rotation.from_matrix(np.stack([START[:3, :3], target[:3, :3]]))
    between = Slerp([0.0, 1.0], both)(np.clip(share, 0.0, 1.0)).as_matrix()
    np.testing.assert_allclose(seen[:, :3, :3], between, atol=5e-6)
    np.testing.assert_allclose(seen[-1], target, atol=1e-9)
    assert np.abs(motion.qd[[0, -1]]).max() == 0.0
    assert np.abs(motion.qdd[[0, -1]]).max() < 1e-9
    used = motion.peaks.acceleration.size.max() / 3.0
    fastest = (motion.peaks.velocity.size / ARM.limits.velocity).max()
    assert max(used, fastest) == pytest.approx(1.0, rel=1e-6)


def test_joints_that_a_line_leaves_alone_are_at_rest():
    """Coulomb friction would feel a rate of 1e-12."""
    q0 = Q0 * [1, 1, 1, 1, 0, 1] + [0, 0, 0, 0, -np.pi / 2, 0]
    up = fb.forward_kinematics(ARM, q0)
    up[2, 3] += 0.1
    motion = fb.line(ARM, q0, up)
    at_rest = motion.peaks.velocity.size == 0.0
    assert at_rest.tolist() == [True, False, False, False, True, True]
    np.testing.assert_allclose(motion.q[-1, at_rest], q0[at_rest], rtol=1e-14)


def test_the_branch_of_the_start_is_kept():
    target = moved([0.1, 0.3, -0.2])
    branches = fb.inverse_kinematics(ARM, START)
    ends = fb.inverse_kinematics(ARM, target)
    kept = 0
    for q0, name in zip(branches.q, branches.branches, strict=True):
        motion = fb.line(ARM, q0, target, 3.0, velocity=None)
        miss = np.abs(np.angle(np.exp(1j * (ends.q - motion.q[-1])))).max(axis=1)
        assert miss.min() < 1e-8
        assert ends.branches[np.argmin(miss)] == name
        kept += 1
    assert kept == 8


def test_a_point_leaves_the_orientation_free_or_keeps_it():
    point = HERE + [0.1, 0.2, -0.1]
    free = tip(fb.line(ARM, Q0, point, 2.0))
    np.testing.assert_allclose(free[-1, :3, 3], point, atol=1e-9)
    assert np.abs(free[-1, :3, :3] - START[:3, :3]).max() > 0.01
    kept = tip(fb.line(ARM, Q0, point, 2.0, task="pose"))
    assert np.abs(kept[:, :3, :3] - START[:3, :3]).max() < 1e-6


def test_a_turn_alone():
    target = moved([0.3, 0.1, 0.0], [0.5, 0.0, 0.0])
    motion = fb.line(ARM, Q0, target, 1.0, task="orientation")
    assert motion.source == "the tip along a turn of 28.65 °"
    np.testing.assert_allclose(tip(motion)[-1, :3, :3], target[:3, :3], atol=1e-9)


def test_an_arc_keeps_its_radius_and_passes_its_points():
    via, end = HERE + [0.1, 0.1, 0.0], HERE + [0.1, -0.05, 0.12]
    motion = fb.arc(ARM, Q0, via, end, task="pose", acceleration=2.0)
    p = tip(motion)[:, :3, 3]
    # the circle of three points, by the perpendicular bisectors
    a, b = via - HERE, end - HERE
    rows = np.stack([a, b, np.cross(a, b)])
    centre = HERE + np.linalg.solve(rows, [a @ a / 2, b @ b / 2, 0.0])
    radius = np.linalg.norm(HERE - centre)
    np.testing.assert_allclose(np.linalg.norm(p - centre, axis=1), radius, atol=2e-6)
    gaps = [np.linalg.norm(p - point, axis=1) for point in (via, end)]
    assert gaps[0].min() < 1e-3
    assert gaps[1][-1] < 1e-9
    assert np.argmin(gaps[0]) < len(p) - 1


def test_corners_are_rounded_as_stated():
    corner = np.array([1.2, 0.4])
    q0 = fb.inverse_kinematics(PLANAR, [0.6, 0.4]).q[0]
    motion = fb.blend(PLANAR, q0, [corner, [1.2, 1.0]], 0.2, acceleration=4.0)
    p = tip(motion, PLANAR, 20001)[:, :2, 2]
    nearest = np.linalg.norm(p - corner, axis=1).min()
    assert nearest == pytest.approx(np.sqrt(2.0) * 3.0 / 16.0 * 0.2, rel=1e-5)
    away = np.linalg.norm(p - corner, axis=1) > 0.2
    off = np.minimum(np.abs(p[:, 0] - 1.2), np.abs(p[:, 1] - 0.4))
    assert off[away].max() < 1e-6
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1)
    assert speed[len(speed) // 4 : -len(speed) // 4].min() > 0.2 * speed.max()  # no stop


def test_the_speed_of_the_tip_is_limited():
    motion = fb.line(ARM, Q0, moved([0.1, 0.3, -0.2]), speed=0.25)
    V = fb.velocity(ARM, *motion.at(np.linspace(0, motion.duration, 2001))[:2])
    assert np.linalg.norm(V[:, :3], axis=1).max() == pytest.approx(0.25, rel=1e-6)
    sampled = fb.line(ARM, Q0, moved([0.1, 0.3, -0.2]), speed=0.25, step=0.004)
    assert sampled.duration == pytest.approx(motion.duration)
    assert sampled.t[1] == pytest.approx(0.004)


def test_what_passes_near_a_singular_position_says_so():
    near = Q0.copy()
    near[4] = -0.05
    motion = fb.line(ARM, near, fb.forward_kinematics(ARM, near * [1, 1, 1, 1, 3, 1]))
    assert any("nearly singular" in text for text in motion.notices)


def test_a_branch_ends_where_the_arm_is_singular():
    """A wrist whose first and last axes meet in one line on the way, by its middle joint alone."""
    rows = [{"alpha": -np.pi / 2}, {"alpha": np.pi / 2}, {"d": 0.1}]
    wrist = fb.dh(rows, convention="standard")
    target = fb.forward_kinematics(wrist, [0.3, 0.5, 0.2])
    with pytest.raises(fb.FreebodyError, match=r"at s = 0\.444 of the way.*becomes singular"):
        fb.line(wrist, [0.3, -0.4, 0.2], target, 1.0, task="orientation")


def of_planar(q0: list[float], point: list[float], **given: float) -> Callable[[], object]:
    return lambda: fb.line(PLANAR, q0, point, 1.0, **given)


LIMITED = fb.planar(
    "RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1], limits=[(-1, 1), (-2.5, 2.5)]
)
REFUSED: list[tuple[Callable[[], object], str]] = [
    (of_planar([0.3, 1.0], [3.0, 0.0]), "the path leaves the workspace, by up to 1 m, at s = 1"),
    (of_planar([0.0, 2.0], [-1.0 - np.cos(2.0), -np.sin(2.0)]), "line: at s = 0.5 of the way"),
    (lambda: fb.line(ARM, Q0, moved([1.5, 0, 0])), "the path leaves the workspace, by up to"),
    (of_planar([0.3, 0.0], [1.0, 0.0]), "at s = 0 of the way, the tip at (1.911, 0.591) m: the "
     "arm is singular at the start"),
    (lambda: fb.line(LIMITED, [0.8, 1.0], [-1.0, 1.0], 1.0), "reaches its upper limit 1; begin"),
    (lambda: fb.line(LIMITED, [1.8, 1.0], [-1.0, 1.0], 1.0), "line: q0 has joint1 at 1.8, outside"),
    (lambda: fb.line(ARM, Q0, moved([0.1, 0.3, -0.2]), 0.1), "its limit 3.1416 rad/s"),
    (lambda: fb.line(ARM, Q0, START), "target 0 is the pose before it"),
    (lambda: fb.line(ARM, Q0, moved([0, 0, 0], [np.pi, 0, 0])), "is half a turn from the one"),
    (lambda: fb.line(ARM, Q0, [[0.1, 0.2, 0.3]]), "line: target has shape (1, 3), expected (3)"),
    (lambda: fb.line(PLANAR, [0.3, 1.0], [1.0, 0.5]), "is not known; give duration=, speed=, vel"),
    (lambda: fb.line(ARM, Q0, moved([0, 0, 0.1]), -1.0), "duration is -1, expected a number"),
    (lambda: fb.line(ARM, Q0, moved([0, 0, 0.1]), 1.0, speed=0.1), "is faster than 0.1 m/s; give"),
    (lambda: fb.arc(ARM, Q0, HERE + [0, 0, 0.1], HERE + [0, 0, 0.2]), "lie on a line"),
    (lambda: fb.arc(ARM, Q0, HERE, START), "lie on a line, or are not three points"),
    (lambda: fb.arc(ARM, Q0, [0.1, 0.2], START), "via has shape (2,), expected (3,)"),
    (lambda: fb.blend(ARM, Q0, [moved([0, 0, 0.1]), moved([0, 0.1, 0.1])], 0.2), "too short for"),
    (lambda: fb.blend(ARM, Q0, START, 0.1), "targets has shape (4, 4), expected (k, 3) or"),
    (lambda: fb.blend(ARM, Q0, [START], 0.0), "radius is 0, expected a number of m above 0"),
    (lambda: fb.line(ARM, [Q0, Q0], START), "line: q0 has shape (2, 6), expected (6,)"),
    (lambda: fb.line(ARM, Q0, moved([0, 0, 0.1]), task="orientation"), "target 0 is the pose bef"),
    (lambda: fb.line(fb.load("four_bar"), np.zeros(3), [0.1, 0.2]), "is open by 0.5 m; close"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_what_cannot_be_says_where_and_why(case: int):
    function, words = REFUSED[case]
    with pytest.raises(fb.FreebodyError) as problem:
        function()
    assert words in str(problem.value)
