"""A model with locked joints moves, weighs and pushes as the whole one whose joints stand still."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support import generate
from support.extras import extra
from support.helpers import refused
from support.real_files import ROBOTS

pytestmark = pytest.mark.usefixtures("numpy_kernels")


def held(model: fb.Model, rng: np.random.Generator) -> dict[str, float]:
    """Positions of some of the joints of one coordinate that follow none, within their ranges."""
    single = [b for b in model.bodies if b.kind.nv == 1 and b.joint.mimic is None]
    q = fb.random_state(model, seed=int(rng.integers(1000)))[0]
    names = [b.joint.name for b in single if rng.random() < 0.5] or [single[0].joint.name]
    return {name: float(q[model.position_names.index(name)]) for name in names}


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", [0, 3])
def test_motion_torques_and_frames_are_those_of_the_whole_robot_at_rest_there(dim: int, seed: int):
    rng = np.random.default_rng(seed)
    model = generate.model(10 * seed + 1, dim)
    positions = held(model, rng)
    locked = model.with_locked(positions)
    entries = [model.position_names.index(x) for x in locked.position_names]
    rates = [model.velocity_names.index(x) for x in locked.velocity_names]
    q, qd, qdd = fb.random_state(locked, seed=seed)
    whole = np.zeros(model.nq)
    for name, x in positions.items():
        whole[model.position_names.index(name)] = x
    whole[entries] = q
    velocity, acceleration = np.zeros(model.nv), np.zeros(model.nv)
    velocity[rates], acceleration[rates] = qd, qdd
    for frame in model.frame_names:
        here, there = (fb.forward_kinematics(m, x, frame) for m, x in ((locked, q), (model, whole)))
        assert np.abs(here - there).max() < 1e-12
    wanted = fb.inverse_dynamics(model, whole, velocity, acceleration)[rates]
    assert np.allclose(fb.inverse_dynamics(locked, q, qd, qdd), wanted, rtol=1e-10, atol=1e-10)
    wanted = fb.mass_matrix(model, whole)[np.ix_(rates, rates)]
    assert np.allclose(fb.mass_matrix(locked, q), wanted, rtol=1e-10, atol=1e-10)
    wanted = fb.joint_wrenches(model, whole, velocity, acceleration)
    for k, name in enumerate(model.joint_names):
        wrench = fb.joint_wrenches(locked, q, qd, qdd, joint=name)
        assert np.allclose(wrench, wanted[k], rtol=1e-9, atol=1e-9)


def test_the_reduced_panda_of_pinocchio():
    pin = extra("pinocchio", "Pinocchio")
    path = str(ROBOTS / "panda_description/urdf/panda.urdf")
    whole = pin.buildModelFromUrdf(path)
    fingers = [whole.getJointId(f"panda_finger_joint{k}") for k in (1, 2)]
    at = pin.neutral(whole)
    for k in fingers:
        at[whole.joints[k].idx_q] = 0.02
    theirs = pin.buildReducedModel(whole, fingers, at)
    ours = fb.load(path, snap_angles=0, physical="ignore").without("friction")
    ours = ours.with_locked({"panda_finger_joint1": 0.02})
    q, qd, qdd = fb.random_state(ours, seed=3)
    tau = pin.rnea(theirs, theirs.createData(), q, qd, qdd)
    assert np.allclose(fb.inverse_dynamics(ours, q, qd, qdd), tau, rtol=1e-11)


def test_symbols_stay_and_the_outermost_slide_of_an_arm_becomes_a_rod():
    locked = fb.planar("RP").with_locked({"joint2": 0.25})
    assert fb.check(locked, "tau1 = (m1*lc1^2 + I1 + m2*(l1 + lc2 + 1/4)^2 + I2)*ddtheta1 + G1")


def test_names_of_what_was_locked_stay_and_written_files_have_them(tmp_path):
    arm = fb.load("panda").with_locked({"panda_finger_joint1": 0.02})
    assert (arm.nv, arm.tip) == (7, "panda_hand_tcp")
    assert {"panda_finger_joint1", "panda_finger_joint2"} <= set(arm.fixed_joint_names)
    assert arm.with_locked({}) is arm
    for suffix in ("urdf", "toml"):
        fb.save(arm, tmp_path / f"arm.{suffix}")
        assert fb.same_robot(fb.load(tmp_path / f"arm.{suffix}"), arm)


@pytest.fixture(scope="module")
def two_armed() -> fb.Model:
    return fb.load(ROBOTS / "baxter_description/urdf/baxter.urdf", physical="ignore")


def test_a_pattern_stands_for_all_joints_that_it_matches(two_armed: fb.Model):
    left = two_armed.with_locked(
        {"right_*": 0.0, "right_e1": 1.2, "head_pan": 0.0, "?_gripper_*": 0.0}
    )
    rest = [name for name in two_armed.position_names if name.startswith(("head", "right", "r_"))]
    by_name = dict.fromkeys([*rest, "l_gripper_l_finger_joint"], 0.0) | {"right_e1": 1.2}
    assert left == two_armed.with_locked(by_name)
    assert {name[:6] for name in left.position_names} == {"left_s", "left_e", "left_w"}


@pytest.mark.parametrize(
    ("positions", "tip"),
    [
        ({"head_pan": 0.0}, None),
        ({"right_*": 0.0}, "left_gripper"),
        ({"right_*": 0.0, "?_gripper_*": 0.0}, "left_gripper"),
        ({"right_*": 0.0, "?_gripper_*": 0.0, "left_w[12]": 0.0}, "left_gripper"),
        ({"left_w2": 0.0}, "right_gripper"),
        ({"*": 0.0}, None),
    ],
)
def test_a_robot_without_a_single_tip_has_one_where_one_chain_is_left(
    two_armed: fb.Model, positions: dict[str, float], tip: str | None
):
    assert two_armed.tip is None
    left = two_armed.with_locked(positions)
    assert left.tip == tip
    assert ("No tip is chosen: " in left.tip_reason) == (tip is None)


REFUSED = [
    ("panda", {"panda_finger_joint1": 0.2}, "with_locked: joint 'panda_finger_joint1' cannot be "
     "held at 0.2 m: its range is 0 … 0.04."),
    ("panda", {"panda_finger_joint2": 0.02}, "with_locked: joint 'panda_finger_joint2' follows "
     "'panda_finger_joint1'; lock that one, and both are."),
    ("panda", {"panda_joint1": "half"}, "with_locked: joint 'panda_joint1': 'half' is not a "
     "number."),
    ("2R", {"elbow": 0.02}, "no one-coordinate joint 'elbow' in '2R'. One-coordinate joints: "
     "joint1, joint2."),
    ("2R", {"elbow*": 0.0}, "no one-coordinate joint 'elbow*' in '2R'. One-coordinate joints: "
     "joint1, joint2."),
    ("2R", {"joint*": 0.0, "*2": 1.0}, "with_locked: 'joint*' and '*2' hold joint 'joint2' at two "
     "positions; give it one by its name."),
    ("panda", {"panda_finger_joint[2]": 0.02}, "with_locked: joint 'panda_finger_joint2' follows "
     "'panda_finger_joint1'; lock that one, and both are."),
]  # fmt: skip


@pytest.mark.parametrize(("robot", "positions", "words"), REFUSED)
def test_what_cannot_be_locked_is_refused(robot: str, positions: dict, words: str):
    refused(words, lambda: fb.load(robot).with_locked(positions))


def test_a_loop_within_one_body_is_refused():
    bar = fb.load("four_bar")
    with pytest.raises(fb.ModelError, match="are then on one body"):
        bar.with_locked(dict.fromkeys(bar.joint_names, 0.0))
