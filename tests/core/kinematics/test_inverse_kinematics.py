"""Inverse kinematics: forward undoes inverse, every branch is there, and what is out of reach is so
by that much."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support import generate
from support.arms import apart, arm, checked, direction, holds, puma_like, skew
from support.helpers import refused

pytestmark = pytest.mark.usefixtures("numpy_kernels")


def planar(word, l, **more):
    n = len(word)
    return fb.planar(word, l=l, lc=[0.3] * n, m=[1.0] * n, I=[0.1] * n, **more)


# ---------------------------------------------------------------- planar
def test_the_notes_equations():
    """(2.14) and (2.15) with atan2, once for each elbow."""
    l1, l2 = 1.1, 0.7
    model = planar("RR", [l1, l2])
    rng = np.random.default_rng(0)
    for q in rng.uniform(-np.pi, np.pi, size=(50, 2)):
        x, y = fb.forward_kinematics(model, q)[:2, 2]
        found = checked(model, [x, y])
        cosine = (x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)
        expected = []
        for sign in (-1, 1):
            theta2 = sign * np.arccos(cosine)
            s, c = l2 * np.sin(theta2), l1 + l2 * np.cos(theta2)
            expected.append([np.arctan2(-s * x + c * y, s * y + c * x), theta2])
        assert list(found.branches) == ["elbow up", "elbow down"]
        assert max(apart(model, a, b) for a, b in zip(found.q, expected, strict=True)) < 1e-6
        assert holds(model, found.q, q)


def test_elbow_up_is_up():
    model = planar("RR", [1.0, 1.0])
    found = fb.inverse_kinematics(model, [1.4, 0.2])
    heights = fb.forward_kinematics(model, found.q, frame="link2")[:, 1, 2]
    assert dict(zip(found.branches, heights > 0.1, strict=True)) == {
        "elbow up": True,
        "elbow down": False,
    }


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("RR", 2),
        ("RP", 1),
        ("PR", 2),
        ("PP", 1),
        ("RRR", 2),
        ("RRP", 2),
        ("RPR", 1),
        ("PRR", 2),
        ("PPR", 1),
        ("PRP", 1),
    ],
)
def test_planar_words(word, expected):
    """As many solutions as circles and lines meet, the one that made the target among them, in a
    batch and singly."""
    rng = np.random.default_rng(len(word))
    lengths = [
        float(x) if k == "R" else 0.0
        for x, k in zip(rng.uniform(0.5, 1.5, len(word)), word, strict=True)
    ]
    model = planar(word, lengths)
    q = rng.uniform(-np.pi, np.pi, size=(40, len(word)))
    slides = [k == "P" for k in word]
    q[:, slides] = rng.uniform(0.3, 1.5, size=(40, sum(slides)))
    poses = fb.forward_kinematics(model, q)
    targets = poses if len(word) == 3 else poses[:, :2, 2]
    batch = fb.inverse_kinematics(model, targets)
    assert batch.method.startswith(f"closed form: planar {word}")
    assert batch.residual[np.isfinite(batch.residual)].max() < 1e-10
    for k in range(40):
        assert holds(model, batch.q[k][np.isfinite(batch.residual[k])], q[k])
        single = checked(model, targets[k])
        assert len(single) == batch.count[k]
        assert len(single) == 2 * expected if word in ("RP", "RPR") else len(single) == expected


@pytest.mark.parametrize("turned", [-1.0, 1.0])
def test_offsets_and_senses(turned):
    """A planar arm on a base that stands askew, axes turning both ways, a tool to the side."""
    model = planar("RRR", [0.8, 0.7, 0.2], angles=[0.3, -0.5, 1.0]).with_tool(
        "gripper", [0.1, -0.2], _turn(0.7)
    )
    q = np.array([0.4, turned * 1.1, -0.6])
    found = checked(model, fb.forward_kinematics(model, q))
    assert len(found) == 2
    assert holds(model, found.q, q)


def _turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    return [[c, -s], [s, c]]


@pytest.mark.parametrize(
    ("point", "distance"),
    [((3.0, 0.0), 1.3), ((0.0, 0.1), 0.2), ((1.2, 1.6), 0.3), ((0.0, 0.0), 0.3)],
)
def test_out_of_reach(point, distance):
    """The 2R reaches the ring from l1 - l2 to l1 + l2."""
    model = planar("RR", [1.0, 0.7])
    found = fb.inverse_kinematics(model, point)
    assert len(found) == 0
    assert found.q.shape == (0, 2)
    assert abs(found.distance - distance) < 1e-9
    assert found.notes == (
        f"Out of reach: the target is {distance:.6g} m from the nearest point that frame 'tip' of "
        f"'RR' can reach.",
    )


def test_out_of_reach_of_others():
    """A batch, an offset of a slide, a pose, a wrist: the distance of the point that decides."""
    assert np.allclose(
        fb.inverse_kinematics(planar("RR", [1.0, 0.7]), [[2.0, 0], [1.0, 0], [0, 5.0]]).distance,
        [0.3, 0, 3.3],
    )
    three = planar("RRR", [1.0, 0.7, 0.5])
    far = np.array(
        [[0.0, -1, 0], [1, 0, 3.0], [0, 0, 1]]
    )  # the last link points up: joint 3 at (0, 2.5)
    found = fb.inverse_kinematics(three, far)
    assert abs(found.distance - 0.8) < 1e-9
    assert "0.8 m" in found.notes[0]
    assert "with this orientation" in found.notes[0]
    cart = planar("PR", [0.0, 1.0])
    assert abs(fb.inverse_kinematics(cart, [7.0, 1.5]).distance - 0.5) < 1e-9
    puma = _quiet("puma560")
    T = np.eye(4)
    T[:3, 3] = [
        2.0,
        0.0,
        0.67183,
    ]  # the wrist's centre is the frame's origin; it keeps d3 off the axis
    upper, fore, side = 0.4318, np.hypot(0.4318, 0.0203), 0.15005
    expected = np.hypot(2.0, 0.0) - np.hypot(upper + fore, side)
    assert abs(fb.inverse_kinematics(puma, T).distance - expected) < 1e-9
    ur = fb.load("ur5e")
    T[:3, 3] = [0.05, 0.0, 0.5]
    assert abs(fb.inverse_kinematics(ur, T).distance - (0.1333 - 0.05)) < 1e-4


def test_orientation_that_cannot_be_had():
    model = planar("RR", [1.0, 0.7])
    T = fb.forward_kinematics(model, [0.3, 0.9])
    assert len(checked(model, T)) == 1
    T[:2, :2] = _turn(2.0)
    found = fb.inverse_kinematics(model, T)
    assert len(found) == 0
    assert found.distance == 0.0
    assert found.notes == (
        "The position is within reach of frame 'tip' of 'RR', but not with this orientation; "
        'task="position" leaves the orientation free.',
    )
    assert len(fb.inverse_kinematics(model, T, task="position")) == 2


@pytest.mark.parametrize("l2", [1.0, 0.6])
@pytest.mark.parametrize("near", [0.0, 1e-15, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("elbow", [0.0, np.pi])
def test_straight_and_folded(l2, near, elbow):
    """Targets on the edge of the workspace, and at the base of an arm with equal links."""
    model = planar("RR", [1.0, l2])
    found = checked(model, fb.forward_kinematics(model, [0.4, elbow - near])[:2, 2])
    assert len(found) in (1, 2)
    if near == 0.0:
        assert list(found.branches) == ["elbow folded" if elbow else "elbow straight"]
    assert bool(found.notes) == (l2 == 1.0 and elbow > 0 and near < 1e-11)


def test_folded_onto_the_base():
    """x = y = 0 with l1 = l2, where (2.15) is undefined: any θ1."""
    model = planar("RR", [1.0, 1.0])
    found = checked(model, [0.0, 0.0], q0=[0.7, 0.0])
    assert np.allclose(found.q, [[0.7, np.pi]])
    assert found.notes[0].startswith(
        "Joint 'joint1' may take any angle at this target, the others compensate"
    )


# ---------------------------------------------------------------- in space
def _quiet(name):
    return fb.load(name, physical="ignore")


@pytest.mark.parametrize("name", ["puma560", "ur5e"])
def test_six_joint_robots(name):
    """All eight branches, whatever the target, each with a name of its own."""
    model = _quiet(name)
    q, _, _ = fb.random_state(model, 4, 60)
    batch = fb.inverse_kinematics(model, fb.forward_kinematics(model, q))
    for k in range(60):
        solutions = batch.q[k, : batch.count[k]]
        assert holds(model, solutions, q[k])
        names = list(batch.branches[k, : batch.count[k]])
        assert len(set(names)) == len(names)
    assert (batch.count == 8).sum() > 30
    assert set(batch.count) <= {2, 4, 6, 8}
    eight = set(batch.branches[np.argmax(batch.count == 8)])
    assert eight == {
        f"shoulder {a}, elbow {b}, wrist {c}"
        for a in ("left", "right")
        for b in ("up", "down")
        for c in ("flipped", "not flipped")
    }


def test_branches_look_like_their_names():
    """Puma: the elbow of "up" above the line from shoulder to wrist, "right" where joint 2 lifts
    the wrist."""
    model = _quiet("puma560")
    found = checked(model, fb.forward_kinematics(model, [0.3, 0.5, -0.4, 0.3, 0.7, 0.2]))
    for q, name in zip(found.q, found.branches, strict=True):
        shoulder, elbow, wrist = (
            fb.forward_kinematics(model, q, frame=f)[:3, 3] for f in ("frame1", "frame2", "frame4")
        )
        line = shoulder + np.dot(elbow - shoulder, wrist - shoulder) / np.dot(
            wrist - shoulder, wrist - shoulder
        ) * (wrist - shoulder)
        assert ("elbow up" in name) == (elbow[2] > line[2])
        lifts = fb.jacobian(model, q, frame="frame4")[2, 1]
        assert ("shoulder right" in name) == (lifts > 0)


def test_right_angled_geometry():
    """Axes at right angles and in pairs parallel, where the equations lose rank one by one."""
    rng = np.random.default_rng(5)
    closed = 0
    for seed in range(12):
        w = direction(rng)
        u = np.cross(w, direction(rng))
        u /= np.linalg.norm(u)
        axes = [
            (k, (w, u, np.cross(w, u))[rng.integers(3)], rng.normal(size=3))
            for k in rng.choice(list("RRP"), 3)
        ]
        model = arm(axes, seed)
        q, _, _ = fb.random_state(model, seed)
        found = checked(model, fb.forward_kinematics(model, q), task="position")
        if "redundant" not in " ".join(found.notes):
            closed += 1
            assert found.method.startswith("closed form")
            assert holds(model, found.q, q)
    assert closed > 4


def test_scara():
    """From the pose, from the rows that it can follow, and from the point alone."""
    model = fb.load("scara")
    q, _, _ = fb.random_state(model, 1)
    T = fb.forward_kinematics(model, q)
    for task in ("pose", ("vx", "vy", "vz", "wz"), "position"):
        found = checked(model, T, task=task)
        assert list(found.branches) == ["elbow left", "elbow right"]
        assert found.method.startswith("closed form")
        if task == "position":  # whose last joint stays at 0
            q[3] = 0.0
        assert holds(model, found.q, q)
    assert "Not changed, because they do not move the target point: 'joint4'." in found.notes
    elbows = fb.forward_kinematics(model, found.q, frame="forearm")[:, :2, 3]
    tip = T[:2, 3]
    assert _left_of(tip, elbows) == [True, False]


def _left_of(tip, points):
    return [bool(tip[0] * p[1] - tip[1] * p[0] > 0) for p in points]


def test_orientation_alone():
    """Three turning joints, wherever their axes are."""
    for seed in range(4):
        model = arm(skew("RRR", np.random.default_rng(seed)), seed)
        q, _, _ = fb.random_state(model, seed)
        T = fb.forward_kinematics(model, q)
        found = fb.inverse_kinematics(model, T[:3, :3], task="orientation")
        assert found.method.startswith("closed form: orientation")
        assert len(found) == 2
        assert holds(model, found.q, q)
        assert np.abs(fb.forward_kinematics(model, found.q)[:, :3, :3] - T[:3, :3]).max() < 1e-10


# ---------------------------------------------------------------- singular targets
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["puma560", "ur5e"])
@pytest.mark.parametrize("off", [0.0, 1e-14, 1e-11, 1e-8, 1e-5])
def test_singular_targets(name, off):
    """Straight arms, straight wrists, right angles everywhere, and next to them: still a valid
    answer."""
    model = _quiet(name)
    straight = np.arctan2(-0.4318, 0.0203) if name == "puma560" else 0.0
    for k in range(12):
        q, _, _ = fb.random_state(model, k)
        if k % 3 == 0:
            q[4] = off
        elif k % 3 == 1:
            q[2] = straight + off
        else:
            q = np.round(q / (np.pi / 2)) * np.pi / 2 + off * np.sin(np.arange(6.0))
        found = checked(model, fb.forward_kinematics(model, q), q0=q)
        assert len(found) > 0
        if off in (0.0, 1e-5):
            assert holds(model, found.q, q, 1e-4)


def test_a_straight_wrist_is_a_family():
    """Joints 4 and 6 of a Puma about one line: q4 as in q0, and it is said."""
    model = _quiet("puma560")
    q = np.array([0.2, 0.3, 0.4, 0.5, 0.0, 0.6])
    T = fb.forward_kinematics(model, q)
    for q4 in (0.0, 0.5, -1.0):
        q0 = q.copy()
        q0[3] = q4
        found = checked(model, T, q0=q0)
        (row,) = np.flatnonzero(found.branches == "shoulder right, elbow down, wrist straight")
        assert np.allclose(found.q[row, 3:], [q4, 0, 1.1 - q4], atol=1e-9)
        assert found.notes[0].startswith("Joint 'joint4' may take any angle at this target")


# ---------------------------------------------------------------- limits, wrapping
def test_limits():
    model = planar("RR", [1.0, 0.7], limits=[(-4.0, 0.5), (-0.1, 3.0)])
    low = checked(model, [0.9, -0.6])
    assert low.within_limits.tolist() == [False, True]
    assert "(outside the limits)" in str(low)
    assert len(checked(model, [0.9, -0.6], limits="drop")) == 1
    assert checked(model, [0.9, -0.6], limits="ignore").within_limits.all()
    none = checked(
        planar("RR", [1.0, 0.7], limits=[(2.0, 2.5), (0.0, 3.0)]), [0.9, -0.6], limits="drop"
    )
    assert len(none) == 0
    assert none.distance == 0.0
    assert none.notes == (
        "Within reach, but each of the 2 solutions leaves a joint's limits (joint1, joint2); "
        'limits="mark" returns them.',
    )


def test_whole_turns():
    """Angles are wrapped into their limits, and next to q0 where several turns fit."""
    model = planar("RR", [1.0, 0.7], limits=[(4.0, 9.0), (-20.0, 20.0)])
    found = checked(model, [0.9, -0.6])
    assert found.within_limits.all()
    assert np.abs(found.q[:, 1]).max() < np.pi
    near = checked(model, [0.9, -0.6], q0=[5.0, 13.0])
    assert near.within_limits.all()
    assert np.abs(near.q[:, 1] - 13.0).max() <= np.pi


# ---------------------------------------------------------------- from many starts
def test_seven_joints():
    """iiwa: solutions within the limits; near q0 when that is given."""
    model = fb.load("iiwa14")
    low, high = model.limits.lower, model.limits.upper
    for seed in range(5):
        q, _, _ = fb.random_state(model, seed)
        T = fb.forward_kinematics(model, q)
        found = checked(model, T)
        assert len(found) > 2
        assert found.within_limits.all()
        assert ((found.q >= low - 1e-9) & (found.q <= high + 1e-9)).all()
        q0 = q + 0.02 * np.sin(np.arange(7) + seed)
        q0 = np.clip(q0, low, high)
        near = checked(model, T, q0=q0)
        assert np.linalg.norm(near.q[0] - q0) <= np.linalg.norm(q - q0) + 1e-6


def test_seven_joints_out_of_reach():
    """The shoulder at 0.36 m, 0.82 m from there to the wrist, of which the tool stands 0.126 m
    off."""
    model = fb.load("iiwa14")
    T = np.eye(4)
    wrist = np.array([1.5, 0.0, 0.5])
    T[:3, 3] = wrist + fb.forward_kinematics(model, np.zeros(7))[:3, 3] - _origin(model, "link_6")
    found = fb.inverse_kinematics(model, T)
    expected = np.linalg.norm(wrist - _origin(model, "link_2")) - np.linalg.norm(
        _origin(model, "link_6") - _origin(model, "link_2")
    )
    assert len(found) == 0
    assert abs(found.distance - expected) < 1e-9
    assert found.notes[0].startswith(f"Out of reach: the target is {expected:.6g} m from")


def _origin(model, frame):
    return fb.forward_kinematics(model, np.zeros(7), frame=frame)[:3, 3]


def test_redundant_and_small_tasks():
    """A 3R for a point, a row alone, a branch of a tree with other joints left alone."""
    model = planar("RRR", [1.0, 0.7, 0.5])
    found = checked(model, [1.2, 0.8], q0=[0.1, 0.2, 0.3])
    assert "redundant" in found.notes[0]
    panda = fb.load("panda")
    q0 = fb.neutral(panda) + 0.02
    row = fb.inverse_kinematics(
        panda, [0.4, 0.1, 0.5], task=("vx", "vz"), q0=np.clip(q0, *_bounds(panda))
    )
    T = fb.forward_kinematics(panda, row.q)
    assert np.abs(T[:, [0, 2], 3] - [0.4, 0.5]).max() < 1e-10
    assert (row.q[:, -1] == row.q[0, -1]).all()  # the fingers


def _bounds(model):
    return model.limits.lower, model.limits.upper


def test_general_six_joints():
    """No closed form: what the search finds is right, and it says that it may not be all."""
    model = arm(skew("RRRRRR", np.random.default_rng(3)), 3)
    q, _, _ = fb.random_state(model, 0)
    found = checked(model, fb.forward_kinematics(model, q))
    assert holds(model, found.q, q)
    assert found.notes == (
        "No closed form is known for this arm and task: what 96 starts found, perhaps not all.",
    )


@pytest.mark.sample(5)
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_random_trees(seed, dim):
    """Free, spherical, planar and following joints, branches: what forward kinematics made is found
    again."""
    model = generate.model(seed, dim)
    q, _, _ = fb.random_state(model, seed)
    target = fb.forward_kinematics(model, q)
    assert len(checked(model, target, limits="ignore")) > 0


def test_no_targets():
    """An empty batch, and a frame that no joint moves."""
    for name in ("2R", "puma560", "iiwa14"):
        model = _quiet(name)
        d = model.dim + 1
        found = fb.inverse_kinematics(model, np.zeros((0, d, d)))
        assert found.q.shape == (0, 0, model.nq)
        assert found.distance.shape == (0,)
    held = fb.inverse_kinematics(planar("RR", [1.0, 0.7]), [1.0, 0.0], frame="base")
    assert len(held) == 0
    assert abs(held.distance - 1.0) < 1e-9


def test_shapes_of_batches():
    model = planar("RR", [1.0, 0.7])
    found = fb.inverse_kinematics(
        model, [[[1.0, 0.5], [9.0, 0.0]], [[1.7, 0.0], [0.3, 1.1]], [[0, 1.0], [1.0, 0]]]
    )
    assert found.q.shape == (3, 2, 2, 2)
    assert found.branches.shape == found.residual.shape == found.within_limits.shape == (3, 2, 2)
    assert found.count.tolist() == [[2, 0], [1, 2], [2, 2]]
    assert np.isnan(found.q[0, 1]).all()
    assert not found.within_limits[0, 1].any()
    assert found.distance.shape == (3, 2)


def test_a_free_joint():
    """A body that nothing holds goes anywhere."""
    quadrotor = fb.load("quadrotor", physical="ignore")
    T = np.eye(4)
    T[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    T[:3, 3] = [1.0, 2.0, 3.0]
    found = checked(quadrotor, T)
    assert len(found) >= 1
    assert np.allclose(found.q[0, :3], [1, 2, 3])


# ---------------------------------------------------------------- refusals
def test_refusals():
    model = planar("RR", [1.0, 0.7])
    ik = fb.inverse_kinematics
    refused(
        "inverse_kinematics: target has shape (4,), expected a point (..., 2) or a pose (..., 3, "
        "3).",
        lambda: ik(model, [1, 2, 3, 4]),
    )
    refused(
        "inverse_kinematics: the target is a point, but the task counts vx, vy, w; give a pose "
        "(..., 3, 3).",
        lambda: ik(model, [1, 2], task="pose"),
    )
    refused(
        "no task 'pos' in inverse_kinematics. Did you mean 'pose'? Tasks: position, orientation, "
        "pose, vx, vy, w.",
        lambda: ik(model, [1, 2], task="pos"),
    )
    refused(
        "inverse_kinematics: target is not a pose: its rotation must satisfy R Rᵀ = 1 within 1e-6 "
        "and "
        "det R = 1, "
        "its last row be (0, 0, 1).",
        lambda: ik(model, np.ones((3, 3))),
    )
    refused(
        "no choice 'clip' in inverse_kinematics: limits=. Choices: mark, drop, ignore.",
        lambda: ik(model, [1, 2], limits="clip"),
    )
    refused(
        "inverse_kinematics: target is nan at component (1,); every entry must be a finite number.",
        lambda: ik(model, [1, np.nan]),
    )
    refused(
        "inverse_kinematics: q0 has shape (3,), expected (..., 2): model 'RR' has nq = 2.",
        lambda: ik(model, [1, 0], q0=[1, 2, 3]),
    )
    with pytest.raises(fb.FreebodyError, match="need a value"):
        ik(fb.planar("RR"), [1, 0])


def test_prints_as_a_table():
    text = str(fb.inverse_kinematics(planar("RR", [1.0, 0.7]), [[1.0, 0.5], [9.0, 0.0]]))
    assert text.startswith(
        "2 targets, 0 to 2 solutions each; closed form: planar RR, notes (2.14), (2.15)"
    )
    assert (
        "Target 1: Out of reach: the target is 7.3 m from the nearest point that frame 'tip' of "
        "'RR' can reach." in text
    )


def test_a_pose_by_three_joints():
    """The position leaves a few candidates, of which the orientation takes one."""
    model = arm(puma_like(np.random.default_rng(2))[:3], 2)
    q, _, _ = fb.random_state(model, 0)
    T = fb.forward_kinematics(model, q)
    found = checked(model, T)
    assert len(found) == 1
    assert found.method.startswith("closed form: position by three joints")
    assert holds(model, found.q, q)
    assert len(checked(model, T[:3, 3])) > 1
    T[:3, :3] = np.eye(3)
    none = fb.inverse_kinematics(model, T)
    assert len(none) == 0
    assert "but not with this orientation" in none.notes[0]


def test_names_of_branches_are_completed_before_they_are_asked_for():
    ur5e = fb.load("ur5e")
    found = fb.inverse_kinematics(ur5e, fb.forward_kinematics(ur5e, [0.3, 1, -1, 0.2, 0.1, 0.3]))
    assert "branches" not in vars(found)
    assert "branches" in dir(found)


def test_limits_of_a_quick_answer_are_those_of_a_careful_one():
    """They are read from the kernel's flags when they are asked for."""
    puma = fb.load("puma560", physical="ignore")  # with limits narrower and wider than a turn
    low, high = puma.limits.lower, puma.limits.upper
    q, _, _ = fb.random_state(puma, 2, 30)
    T = fb.forward_kinematics(puma, q)
    fb.inverse_kinematics(puma, T[0])
    for given in (T[1], T):
        quick = fb.inverse_kinematics(puma, given)
        assert "within_limits" not in vars(quick)
        assert "within_limits" in dir(quick)
        fine = (quick.q >= low - 1e-9) & (quick.q <= high + 1e-9)
        assert (quick.within_limits == fine.all(axis=-1)).all()
        assert not quick.within_limits.all()
        assert (np.abs(quick.q - (low + high) / 2)[quick.valid] <= np.pi + 1e-9).all()
        assert not quick.within_limits.flags.writeable
        assert not quick.q.flags.writeable
    ignored = fb.inverse_kinematics(puma, T, limits="ignore")
    assert (fb.inverse_kinematics(puma, T, limits="ignore").within_limits == ignored.valid).all()
