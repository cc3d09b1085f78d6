"""The tip along paths by fewer joints than its motion has directions, and by closed chains: what
they can do is done, by formulas written here; what they cannot is said with direction and size."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from support.command import run
from support.few_joints import DELTA, delta, delta_points, five_axes, palletiser

SCARA = fb.load("scara")
Q0 = np.array([0.3, 1.3, 0.1, 0.2])
START = fb.forward_kinematics(SCARA, Q0)
FIVE = five_axes()
BENT = np.array([0.3, 0.8, -1.2, 0.6, 0.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robots")


@pytest.fixture(scope="module")
def parallel(folder: Path) -> fb.Model:
    return delta(folder)


def moved(start: np.ndarray, shift: list[float], turn: tuple[float, ...] = ()) -> np.ndarray:
    """A pose shifted, and turned about axes of the world."""
    target, d = start.copy(), len(start) - 1
    target[:d, d] += shift
    if turn:
        target[:3, :3] = Rotation.from_rotvec(turn).as_matrix() @ start[:3, :3]
    return target


def at_times(motion: fb.Motion) -> tuple[np.ndarray, np.ndarray]:
    """(share of the way, positions) at times between samples; from rest to rest by degree 5."""
    x = np.linspace(0.0, 1.0, 301)
    return x**3 * (10 - 15 * x + 6 * x**2), motion.at(x * motion.duration)[0]


def straight(model: fb.Model, motion: fb.Motion, start: np.ndarray, target: np.ndarray) -> None:
    """The tip is where it is asked to be, and limits are kept."""
    share, q = at_times(motion)
    d = model.dim
    seen = fb.forward_kinematics(model, q)
    between = start[:d, d] + share[:, None] * (target - start)[:d, d]
    np.testing.assert_allclose(seen[:, :d, d], between, rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen[-1], target, rtol=0, atol=1e-9)
    assert fb.exceeded_limits(model, motion) == ()


def test_scara_turns_its_hand_along_a_line():
    """Against the two-link triangle; the hand points down, so that a turn is that of the arm less
    that of the hand."""
    target = moved(START, [-0.1, 0.1, 0.03], (0.0, 0.0, 0.8))
    motion = fb.line(SCARA, Q0, target, acceleration=20.0)
    straight(SCARA, motion, START, target)
    share, q = at_times(motion)
    x, y, z = (START[:3, 3] + share[:, None] * [-0.1, 0.1, 0.03]).T
    a, b = 0.425, 0.375
    elbow = np.arccos((x**2 + y**2 - a**2 - b**2) / (2 * a * b))
    arm = np.arctan2(y, x) - np.arctan2(b * np.sin(elbow), a + b * np.cos(elbow))
    hand = arm + elbow - (Q0[0] + Q0[1] - Q0[3]) - 0.8 * share
    by_hand = np.stack([arm, elbow, 0.877 - 0.2 - z, hand], axis=-1)
    np.testing.assert_allclose(q, by_hand, rtol=0, atol=1e-9)


def test_scara_along_arcs_and_round_corners():
    place = START[:3, 3]
    via, end = place + [-0.1, 0.02, 0.0], moved(START, [-0.1, 0.1, 0.02], (0.0, 0.0, -0.4))
    q = at_times(fb.arc(SCARA, Q0, via, end, 1.0))[1]
    seen = fb.forward_kinematics(SCARA, q)
    a, b = via - place, end[:3, 3] - place
    rows = np.stack([a, b, np.cross(a, b)])
    centre = place + np.linalg.solve(rows, [a @ a / 2, b @ b / 2, 0.0])
    away = np.linalg.norm(seen[:, :3, 3] - centre, axis=1)
    np.testing.assert_allclose(away, np.linalg.norm(place - centre), rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen[-1], end, rtol=0, atol=1e-9)
    corners = [moved(START, [-0.1, 0.0, 0.0]), moved(START, [-0.1, 0.1, 0.0])]
    seen = fb.forward_kinematics(SCARA, at_times(fb.blend(SCARA, Q0, corners, 0.02, 1.0))[1])
    np.testing.assert_allclose(seen[:, :3, :3] - START[:3, :3], 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen[:, 2, 3], place[2], rtol=0, atol=1e-8)
    off = np.minimum(np.abs(seen[:, 0, 3] - place[0] + 0.1), np.abs(seen[:, 1, 3] - place[1]))
    assert off[np.linalg.norm(seen[:, :3, 3] - corners[0][:3, 3], axis=1) > 0.02].max() < 1e-8


def test_palletiser_keeps_its_hand_level(folder: Path):
    model, q0 = palletiser(folder), [0.3, -0.2, 0.3, 0.5]
    start = fb.forward_kinematics(model, q0)
    target = moved(start, [0.1, 0.1, 0.06], (0.0, 0.0, 0.4))
    motion = fb.line(model, q0, target, 1.0)
    straight(model, motion, start, target)
    share, q = at_times(motion)
    turn, swing, lift, spin = q.T
    reach = 0.1 + 0.7 * np.sin(swing) + 0.6 * np.cos(lift) + 0.15
    height = 0.4 + 0.7 * np.cos(swing) - 0.6 * np.sin(lift) - 0.2
    by_hand = np.stack([reach * np.cos(turn), reach * np.sin(turn), height], axis=-1)
    asked = start[:3, 3] + share[:, None] * [0.1, 0.1, 0.06]
    np.testing.assert_allclose(by_hand, asked, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turn + spin, 0.8 + 0.4 * share, rtol=0, atol=1e-9)


def test_five_axes_keep_an_orientation_that_they_can_keep():
    """Outwards in the arm's plane; and with the hand straight down anywhere, which the roll
    allows."""
    start = fb.forward_kinematics(FIVE, BENT)
    outwards = moved(start, [0.1 * np.cos(0.3), 0.1 * np.sin(0.3), 0.05])
    straight(FIVE, fb.line(FIVE, BENT, outwards, 1.0), start, outwards)
    down = np.array([0.3, 0.8, -1.2, 0.4, 0.5])  # the three that pitch add to 0
    start = fb.forward_kinematics(FIVE, down)
    np.testing.assert_allclose(start[:3, 2], [0.0, 0.0, -1.0], atol=1e-15)
    aside = moved(start, [0.1, -0.15, 0.05], (0.0, 0.0, 0.3))
    straight(FIVE, fb.line(FIVE, down, aside, 1.0), start, aside)


def test_five_axes_go_as_near_to_an_orientation_as_they_can():
    """From one pose that they reach to another: what is left of the orientation between is a turn
    out of the plane of the arm, across the hand."""
    start = fb.forward_kinematics(FIVE, BENT)
    target = fb.forward_kinematics(FIVE, BENT + [0.4, 0.2, -0.2, 0.1, 0.0])
    with pytest.raises(fb.FreebodyError, match=r"cannot turn about .* as asked: up to 0.402 °"):
        fb.line(FIVE, BENT, target, 1.0)
    motion = fb.line(FIVE, BENT, target, 1.0, task="reachable")
    straight(FIVE, motion, start, target)
    share, q = at_times(motion)
    seen = fb.forward_kinematics(FIVE, q)[:, :3, :3]
    turn = Rotation.from_matrix(start[:3, :3].T @ target[:3, :3]).as_rotvec()
    asked = start[:3, :3] @ Rotation.from_rotvec(share[:, None] * turn).as_matrix()
    left = Rotation.from_matrix(asked @ np.swapaxes(seen, 1, 2)).as_rotvec()
    across = np.stack([-np.sin(q[:, 0]), np.cos(q[:, 0]), 0.0 * share], axis=-1)
    hand = seen[:, :, 2]
    np.testing.assert_allclose(np.sum(left * hand, axis=1), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.sum(left * across, axis=1), 0.0, atol=1e-9)
    most = np.degrees(np.linalg.norm(left, axis=1).max())
    assert most == pytest.approx(0.402, abs=2e-3)
    assert [text for text in motion.notices if "up to 0.402 °, at s = 0.5" in text]


def test_what_no_joint_can_do_is_said_with_its_direction():
    tilted = moved(START, [-0.1, 0.1, 0.03], (np.radians(12.0), 0.0, 0.0))
    words = r"cannot turn about x \(world axes\) as asked: up to 12 °, at s = 1, are beyond the 4 j"
    with pytest.raises(fb.FreebodyError, match=words):
        fb.line(SCARA, Q0, tilted, 1.0)
    nearest = fb.line(SCARA, Q0, tilted, 1.0, task="reachable")
    straight(SCARA, nearest, START, moved(START, [-0.1, 0.1, 0.03]))
    assert nearest.notices[-1] == (
        "The tip does not turn about x (world axes) as asked: up to 12 °, at s = 1, are beyond the "
        "4 joints."
    )
    two = fb.dh([{"a": 0.4}, {"a": 0.3}], convention="standard")
    up = fb.forward_kinematics(two, [0.3, 1.0])[:3, 3] + [0.05, 0.0, 0.07]
    with pytest.raises(fb.FreebodyError, match=r"cannot move along z .* up to 0\.07 m, at s = 1"):
        fb.line(two, [0.3, 1.0], up, 1.0)


def test_a_coupler_leaves_a_line_at_once():
    """A four-bar's tip moves on a curve of its own; how far it stays from the line is known as far
    as it comes along."""
    model = fb.load("four_bar")
    q0 = fb.assemble(model)
    place = fb.forward_kinematics(model, q0)[:2, 2]
    words = r"cannot move along \(-0\.0386, 0\.999\) .* more than 0\.00349 m, .* the 1 drive"
    with pytest.raises(fb.FreebodyError, match=words):
        fb.line(model, q0, place + [0.05, 0.0], 1.0)
    with pytest.raises(fb.FreebodyError, match="pose, reachable, vx"):
        fb.line(model, q0, place + [0.05, 0.0], 1.0, task="poses")


def test_a_redundant_arm_is_as_exact_and_as_quick():
    """Seven joints: between two nodes they are led from both, so that more nodes change nothing
    but the error of the tip."""
    model, q0 = fb.load("panda"), [0.0, -0.4, 0.0, -2.0, 0.0, 1.7, 0.8, 0.02]
    start = fb.forward_kinematics(model, q0)
    target = moved(start, [0.1, 0.1, -0.1])
    motion = fb.line(model, q0, target, 2.0)
    straight(model, motion, start, target)
    assert motion.q[-1, 7] == 0.02  # the fingers stay where they are


def test_a_single_joint_follows_its_circle():
    arm = fb.dh([{"a": 0.4}], convention="standard")
    via, end = (0.4 * np.array([np.cos(x), np.sin(x), 0.0]) for x in (0.5, 1.1))
    motion = fb.arc(arm, [0.2], via, end, 1.0)
    share, q = at_times(motion)
    np.testing.assert_allclose(q[:, 0], 0.2 + 0.9 * share, rtol=0, atol=1e-9)


def test_what_is_singular_or_out_of_reach_stays_refused():
    """The elbow straight; a point too far; a wrist of six axes straight at the start."""
    with pytest.raises(fb.FreebodyError, match=r"at s = 0 of the way.*singular at the start"):
        fb.line(SCARA, [0.3, 0.0, 0.1, 0.2], START, 1.0)
    with pytest.raises(fb.FreebodyError, match=r"the path leaves the workspace, by up to 0.6"):
        fb.line(SCARA, Q0, moved(START, [0.9, 0.1, 0.0]), 1.0)
    with pytest.raises(fb.FreebodyError, match="joint3 reaches its lower limit 0; begin"):
        fb.line(SCARA, Q0, moved(START, [0.0, 0.0, 0.2]), 1.0)
    straight_wrist = [0.2, -1.2, 1.5, -1.8, 0.0, 0.3]
    arm = fb.load("ur5e")
    target = moved(fb.forward_kinematics(arm, straight_wrist), [0.1, 0.0, 0.0])
    with pytest.raises(fb.FreebodyError, match=r"singular at the start: .* = 0, whatever"):
        fb.line(arm, straight_wrist, target, 1.0)


def rods(model: fb.Model, q: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(N, 6) lengths of a delta's rods where its platform is at `place` (N, 3)."""
    found = []
    for k in range(3):
        points, R = delta_points(k)
        angle = q[:, model.position_names.index(f"drive{k}")]
        for point, y in zip(points, (DELTA["half"], -DELTA["half"]), strict=True):
            x = DELTA["base"] + DELTA["arm"] * np.cos(angle)
            elbow = np.stack([x, np.full(len(q), y), -DELTA["arm"] * np.sin(angle)], axis=-1)
            found.append(np.linalg.norm(place + point - elbow @ R.T, axis=-1))
    return np.stack(found, axis=-1)


def test_delta_moves_straight(parallel: fb.Model):
    q0 = fb.assemble(parallel)
    start = fb.forward_kinematics(parallel, q0)
    target = moved(start, [0.1, 0.05, 0.06])
    motion = fb.line(parallel, q0, target, acceleration=30.0)
    straight(parallel, motion, start, target)
    share, q = at_times(motion)
    place = start[:3, 3] + share[:, None] * [0.1, 0.05, 0.06]
    np.testing.assert_allclose(rods(parallel, q, place), DELTA["rod"], rtol=0, atol=1e-9)
    point = fb.line(parallel, [np.pi / 6] * 3, target[:3, 3], 1.0)
    np.testing.assert_allclose(fb.forward_kinematics(parallel, point.q[-1]), target, atol=1e-9)


@pytest.mark.long
def test_delta_along_an_arc_and_round_a_corner(parallel: fb.Model):
    q0 = fb.assemble(parallel)
    start = fb.forward_kinematics(parallel, q0)[:3, 3]
    motion = fb.arc(parallel, q0, start + [0.1, 0.1, 0.0], start + [0.2, 0.0, 0.0], 1.0)
    share, q = at_times(motion)
    way = np.pi * share
    sideways, forth = np.sin(way)[:, None] * [0, 0.1, 0], (1 - np.cos(way))[:, None] * [0.1, 0, 0]
    place = start + sideways + forth
    np.testing.assert_allclose(rods(parallel, q, place), DELTA["rod"], rtol=0, atol=1e-9)
    corners = start + [[0.1, 0.0, 0.0], [0.1, 0.1, 0.0]]
    q = at_times(fb.blend(parallel, q0, corners, 0.03, 1.0, task="pose"))[1]
    place = fb.forward_kinematics(parallel, q)[:, :3, 3]
    np.testing.assert_allclose(rods(parallel, q, place), DELTA["rod"], rtol=0, atol=1e-9)
    off = np.minimum(np.abs(place[:, 0] - start[0] - 0.1), np.abs(place[:, 1] - start[1]))
    assert off[np.linalg.norm(place - corners[0], axis=1) > 0.03].max() < 1e-7


def test_what_a_delta_cannot_do(folder: Path, parallel: fb.Model):
    q0 = fb.assemble(parallel)
    start = fb.forward_kinematics(parallel, q0)
    turned = moved(start, [0.1, 0.0, 0.0], (0.0, 0.0, 0.3))
    with pytest.raises(fb.FreebodyError, match=r"about z .* up to 17.2 °, at s = 1, .* 3 drives"):
        fb.line(parallel, q0, turned, 1.0)
    with pytest.raises(fb.FreebodyError, match="the drives no longer hold the tip"):
        fb.line(parallel, q0, start[:3, 3] + np.array([1.0, 0.0, 0.0]), 1.0)
    with pytest.raises(fb.FreebodyError, match=r"the path leaves the workspace, by up to 0.2"):
        fb.line(parallel, q0, start[:3, 3] + [0.0, 0.0, -0.5], 1.0)
    with pytest.raises(fb.LoopError, match="has 3 degrees of freedom and 2 driven joints, drive0"):
        fb.line(delta(folder, passive=[2]), q0, start[:3, 3] + [0.1, 0.0, 0.0], 1.0)


@pytest.mark.long
def test_stewart_platform_moves_and_turns():
    """Six distances."""
    model = fb.load("stewart")
    q0 = fb.assemble(model)
    start = fb.forward_kinematics(model, q0)
    target = moved(start, [0.05, 0.08, 0.06], (0.1, 0.2, 0.1))
    motion = fb.line(model, q0, target, 1.0)
    straight(model, motion, start, target)
    share, q = at_times(motion)
    R = Rotation.from_rotvec(share[:, None] * [0.1, 0.2, 0.1]).as_matrix() @ start[:3, :3]
    place = start[:3, 3] + share[:, None] * [0.05, 0.08, 0.06]
    for k in range(6):
        foot = fb.forward_kinematics(model, q0, f"cross{k + 1}")[:3, 3]
        ball = start[:3, :3].T @ (
            fb.forward_kinematics(model, q0, f"ball{k + 1}")[:3, 3] - start[:3, 3]
        )
        distance = np.linalg.norm(place + R @ ball - foot, axis=1)
        leg = q[:, model.position_names.index(f"leg{k + 1}")]
        np.testing.assert_allclose(leg, distance, rtol=0, atol=1e-9)


def test_platform_on_three_legs_in_the_plane():
    model = fb.load("3RRR")
    q0 = fb.assemble(model)
    start = fb.forward_kinematics(model, q0)
    target = moved(start, [0.04, 0.05])
    motion = fb.line(model, q0, target, 1.0)
    straight(model, motion, start, target)
    share, q = at_times(motion)
    place = start[:2, 2] + share[:, None] * [0.04, 0.05]
    for k in range(3):
        angle = -np.pi / 6 - 2 * np.pi / 3 + 2 * np.pi / 3 * k
        foot, corner = (r * np.array([np.cos(angle), np.sin(angle)]) for r in (0.5, 0.15))
        drive = q[:, model.position_names.index(f"drive{k + 1}")]
        elbow = foot + 0.3 * np.stack([np.cos(drive), np.sin(drive)], axis=-1)
        bar = np.linalg.norm(place + start[:2, :2] @ corner - elbow, axis=1)
        np.testing.assert_allclose(bar, 0.35, rtol=0, atol=1e-9)


def test_five_bar_moves_a_point_but_turns_nothing_by_itself():
    model = fb.load("five_bar")
    q0 = fb.assemble(model)
    start = fb.forward_kinematics(model, q0)
    point = start[:2, 2] + [0.05, -0.08]
    motion = fb.line(model, q0, point, acceleration=5.0)
    assert fb.exceeded_limits(model, motion, acceleration=5.0 + 1e-6) == ()
    share, q = at_times(motion)
    place = start[:2, 2] + share[:, None] * [0.05, -0.08]
    for name, pivot in (("theta1", -0.25), ("theta2", 0.25)):
        angle = q[:, model.position_names.index(name)]
        elbow = np.stack([pivot + 0.4 * np.cos(angle), 0.4 * np.sin(angle)], axis=-1)
        bar = np.linalg.norm(place - elbow, axis=1)
        np.testing.assert_allclose(bar, 0.6, rtol=0, atol=1e-9)
    with pytest.raises(fb.FreebodyError, match=r"cannot turn as asked: up to 9.32 °, at s = 1"):
        fb.line(model, q0, moved(start, [0.05, -0.08]), 1.0)


def planned(model: str, start: str, *options: str) -> fb.Motion:
    assert run(["plan", model, start, *options, "--out", "tip.csv"]) == 0
    return fb.read_motion(fb.load(model), "tip.csv")


def test_the_command_plans_paths_of_the_tip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What it writes is what the functions plan."""
    monkeypatch.chdir(tmp_path)
    start, target = "0.3, 1.3, 0.1, 0.2", START.copy()
    target[:3, 3] = [0.3, 0.6, 0.6]
    slowly = "--pose", "keep", "--tip-speed", "0.2"
    kept = planned("scara", start, "--line", "0.3, 0.6, 0.6", *slowly)
    np.testing.assert_allclose(fb.forward_kinematics(SCARA, kept.q[-1]), target, atol=1e-9)
    expected = fb.line(SCARA, Q0, target, speed=0.2)
    assert kept.duration == pytest.approx(expected.duration, rel=1e-9)
    x, y, z = Rotation.from_matrix(START[:3, :3]).as_euler("xyz", degrees=True)
    angles = f"{x} deg, {y} deg, {z + 20} deg"
    corner = ["--line", "0.3, 0.6, 0.6; 0.3, 0.5, 0.6", "--radius", "0.02", "--acceleration", "5"]
    turned = planned("scara", start, *corner, "--pose", angles)
    target[1, 3] -= 0.1
    target[:3, :3] = Rotation.from_rotvec([0, 0, np.radians(20)]).as_matrix() @ START[:3, :3]
    np.testing.assert_allclose(fb.forward_kinematics(SCARA, turned.q[-1]), target, atol=1e-9)
    Path("start.txt").write_text("theta1,theta2\n1.9,1.0\n")
    arc = ["--arc", "-0.05, 0.75; -0.05, 0.7", "--acceleration", "3", "--duration", "3"]
    motion, model = planned("five_bar", "start.txt", *arc), fb.load("five_bar")
    place = fb.forward_kinematics(model, motion.q)[:, :2, 2]
    np.testing.assert_allclose(place[-1], [-0.05, 0.7], atol=1e-9)
    assert np.linalg.norm(place - [-0.05, 0.75], axis=1).min() < 1e-3
    assert motion.duration == pytest.approx(3.0)
    tilted = ["--line", "0.3, 0.6, 0.6", "--pose", f"{x - 5} deg, {y} deg, {z} deg"]
    planned("scara", start, *tilted, "--task", "reachable", "--duration", "2")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--line", "0.3, 0.6, 0.6", "--arc", "0,0,0; 0,0,1"], "--line and --arc are two paths"),
        (["--tip-speed", "1"], "--tip-speed belongs to a path of the tip: --line or --arc"),
        (["--tip-speed", "1", "--speed", "1"], "--speed is the old spelling of --tip-speed"),
        (["--radius", "1", "--radius", "2"], "--radius is given 2 times; give it once."),
        (["--line", "0.3, 0.6"], "a point of 'scara' is x, y, z in metres"),
        (["--line", "0.3, 0.6, 30 deg"], "a point of 'scara' is x, y, z in metres"),
        (["--line", ";"], "--line is empty: give a target"),
        (["--line", "0.3, 0.6, 0.6; 0.3, 0.5, 0.6"], "--line has 2 targets; several need --radius"),
        (["--line", "0.3, 0.6, 0.6", "--radius", "0.1"], "--line has 1 target; several need --rad"),
        (["--arc", "0.3, 0.6, 0.6"], "--arc takes two points, the one to pass and the target"),
        (["--line", "0.3, 0.6, 0.6", "--pose", "0.3"], "is roll, pitch, yaw (as in URDF), rad or"),
        (["--line", "0.3, 0.6, 0.6", "--pose", "0,0,0; 0,0,1"], "has 2 orientations for 1 target"),
        (["--line", "0.3, 0.6, 0.6", "--by", "quintic"], "--by is for motions through waypoints"),
        (["--line", "0.3, 0.6, 0.6", "--jerk", "9"], "--jerk has no meaning for a path of the tip"),
        (["--line", "0.3, 0.6, 0.6", "--pose", "168 deg, 0, 0"], "cannot turn about"),
        (
            ["--line", "0.3, 0.6, 0.6", "--pose", "keep", "--task", "position"],
            "--pose gives an orientation, and --task position counts none",
        ),
    ],
)
def test_the_command_says_what_is_wrong(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
):
    start = "0.3, 1.3, 0.1, 0.2" if options[0] != "--tip-speed" else "0, 0, 0, 0; 1, 1, 0.1, 1"
    assert run(["plan", "scara", start, *options]) == 2
    assert words in " ".join(capsys.readouterr().err.split())


def test_a_path_begins_at_one_position(capsys: pytest.CaptureFixture[str]):
    assert run(["plan", "2R", "0, 1; 1, 1", "--line", "0.5, 1.0", "--velocity", "1"]) == 2
    assert "--line and --arc begin at one position" in capsys.readouterr().err
