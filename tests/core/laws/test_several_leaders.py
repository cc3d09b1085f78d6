"""Joints that follow several: beside the free joints at what they follow, a differential in closed
form, files."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.helpers import close

RATIOS = {"shoulder": -1.0, "elbow": -0.8}
OFFSET = 0.3


def text(mimic: str, more: str = "") -> str:
    """A palletiser whose hand turns with shoulder and elbow, and a finger that slides as the hand
    turns."""
    links = ("base", "upper", "fore", "hand", "finger")
    parts = ['name = "palletiser"']
    parts += [
        f'[[link]]\nname = "{name}"\nmass = {3 - 0.5 * k}\ncom = [0.05, 0.02, 0.3]\n'
        f"inertia = [0.03, 0.002, -0.003, 0.04, 0.004, 0.05]"
        for k, name in enumerate(links)
    ]
    for name, parent, child, own in (
        ("shoulder", "base", "upper", 'kind = "revolute"\naxis = "y"'),
        ("elbow", "upper", "fore", 'kind = "revolute"\naxis = "y"\norigin = [0.1, 0, 0.8]'),
        ("wrist", "fore", "hand", f'kind = "revolute"\naxis = "x"\norigin = [0, 0, 0.7]\n{mimic}'),
        ("grip", "hand", "finger",
         f'kind = "prismatic"\naxis = "z"\nmimic = {{ joint = "wrist", ratio = 0.1 }}\n{more}'),
    ):  # fmt: skip
        parts.append(f'[[joint]]\nname = "{name}"\nparent = "{parent}"\nchild = "{child}"\n{own}')
    return "\n".join(parts)


MIMIC = f"mimic = {{ joints = {{ shoulder = -1, elbow = -0.8 }}, offset = {OFFSET} }}"


def test_beside_free_joints_that_move_so(tmp_path):
    model = fb.load(text=text(MIMIC), format="toml")
    free = fb.load(text=text(MIMIC), format="toml", mimic="free")
    assert model.velocity_names == ("shoulder", "elbow")
    assert free.joint_names == ("shoulder", "elbow", "wrist", "grip")
    wrist = np.array([-1.0, -0.8])
    G = np.array([[1, 0], [0, 1], wrist, 0.1 * wrist])
    zero = np.array([0, 0, OFFSET, 0.1 * OFFSET])
    motion = np.stack([fb.random_state(model, seed) for seed in range(3)], axis=1)
    q, qd, qdd = motion
    theirs = (q @ G.T + zero, qd @ G.T, qdd @ G.T)
    at = fb.forward_kinematics(free, theirs[0], "finger")
    close(fb.forward_kinematics(model, q, "finger"), at, 1e-12)
    each = fb.inverse_dynamics(free, *theirs)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    close(tau, each @ G, 1e-12)
    close(fb.mass_matrix(model, q), G.T @ fb.mass_matrix(free, theirs[0]) @ G, 1e-12)
    close(fb.forward_dynamics(model, q, qd, tau), qdd, 1e-9)
    by_q, by_qd, _ = fb.inverse_dynamics_derivatives(model, q, qd, qdd)
    free_by_q, free_by_qd, _ = fb.inverse_dynamics_derivatives(free, *theirs)
    close(by_q, G.T @ free_by_q @ G, 1e-12)
    close(by_qd, G.T @ free_by_qd @ G, 1e-12)
    # the torque that the follower's transmission carries
    wrench = fb.joint_wrenches(model, q, qd, qdd, reference="child", joint="wrist")
    close(wrench[:, 3], each[:, 2], 1e-12)
    saved = tmp_path / "saved.toml"
    fb.save(model, saved)
    assert fb.load(saved) == model


def test_a_differential():
    """Two motors turn the two axes of a wrist by half their sum and half their difference: of equal
    inertias J each motor feels J/2, and none of the other."""
    parts = ['name = "wrist"\ngravity = 0']
    links = {"base": 0.0, "left": 0.0, "right": 0.0, "pitch": 0.0, "roll": 0.2}
    for name, inertia in links.items():
        tensor = f"[{inertia}, 0, 0, {inertia}, 0, {inertia}]" if inertia else ""
        mass = f"mass = 1\ncom = [0, 0, 0]\ninertia = {tensor}" if tensor else ""
        parts.append(f'[[link]]\nname = "{name}"\n{mass}')
    for name, parent, axis, mimic in (
        ("left", "base", "y", ""),
        ("right", "base", "y", ""),
        ("pitch", "base", "y", "mimic = { joints = { left_motor = 0.5, right_motor = 0.5 } }"),
        ("roll", "pitch", "x", "mimic = { joints = { left_motor = 0.5, right_motor = -0.5 } }"),
    ):
        joint = name if mimic else f"{name}_motor"
        parts.append(
            f'[[joint]]\nname = "{joint}"\nkind = "continuous"\nparent = "{parent}"\n'
            f'child = "{name}"\naxis = "{axis}"\n{mimic}'
        )
    model = fb.load(text="\n".join(parts), format="toml")
    assert model.velocity_names == ("left_motor", "right_motor")
    q = [0.7, -0.4]
    close(fb.mass_matrix(model, q), 0.1 * np.eye(2), 1e-12)
    angles = np.array([0.15, 0.55])  # of pitch and roll
    (cy, cx), (sy, sx) = np.cos(angles), np.sin(angles)
    turned = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ [
        [1, 0, 0],
        [0, cx, -sx],
        [0, sx, cx],
    ]
    close(fb.forward_kinematics(model, q, "roll")[:3, :3], turned, 1e-12)


def test_a_follower_of_a_follower_and_its_leader():
    # wrist = grip - 2 shoulder and grip = 2 shoulder + elbow + 0.1: of the shoulder nothing is left
    mimic = "mimic = { joints = { grip = 1, shoulder = -2 } }"
    follows = "mimic = { joints = { shoulder = 2, elbow = 1 }, offset = 0.1 }"
    given = text(mimic).replace('mimic = { joint = "wrist", ratio = 0.1 }', follows)
    model = fb.load(text=given, format="toml")
    assert model.joint_names == ("shoulder", "elbow", "wrist", "grip_shoulder", "grip")
    wrist = model.bodies[2].joint.mimic
    assert (wrist.joint, wrist.ratio, wrist.offset, wrist.more) == ("elbow", 1.0, 0.1, ())


@pytest.mark.parametrize(
    ("mimic", "more", "told"),
    [
        ("mimic = { joints = { shoulder = -1, elbw = -1 } }", "",
         "no joint 'elbw' in the mimic of 'wrist'. Did you mean 'elbow'?"),
        ("mimic = { joints = { shoulder = -1, grip = -1 } }", "",
         "its mimic relations form a cycle; remove one."),
        ("mimic = { joints = { } }", "", "mimic: joints is empty; give each leader its ratio."),
        ("mimic = { joints = { shoulder = -1 }, ratio = 2 }", "", "no key 'ratio'"),
        (f"{MIMIC}\nfriction = {{ viscous = 1 }}", "",
         "joint 'wrist' follows shoulder and elbow, and has viscous friction of its own: these "
         "act on the sum of the motions that it follows, and a model holds them for the motion of "
         "one joint. Remove them from the joint, or load with mimic='free' (--mimic free): each "
         "joint then moves by itself."),
    ],
)  # fmt: skip
def test_refused(mimic, more, told):
    with pytest.raises(fb.FileError) as error:
        fb.load(text=text(mimic, more), format="toml")
    assert told in str(error.value)


def test_limits_that_are_left_out_are_told():
    model = fb.load(text=text(f"{MIMIC}\nlimits = {{ lower = -1, upper = 1 }}"), format="toml")
    assert any(
        "joint 'wrist' follows shoulder and elbow: its own limits are left out" in str(notice)
        for notice in model.notices
    )
