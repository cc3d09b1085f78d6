"""Names of the recursion in exported text: a value that is called w3_y is what is said of it, found
another way."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import freebody as fb

LINE = re.compile(r"    const double (\w+) = (.*);")


def values(model: fb.Model, quantity: str, *state: np.ndarray) -> dict[str, float]:
    """What the text's own words hold, evaluated line by line."""
    text = fb.source(model, quantity, "c")
    names = dict(
        zip(("q", "qd", "qdd" if quantity == "inverse_dynamics" else "tau"), state, strict=False)
    )
    known: dict[str, float] = {
        "sin": math.sin,
        "cos": math.cos,
        **{k: x.tolist() for k, x in names.items()},
    }
    for word, expression in LINE.findall(text):
        known[word] = eval(expression, {"__builtins__": {}}, known)  # text that freebody just wrote
    return {word: x for word, x in known.items() if isinstance(x, float)}


def expected(
    model: fb.Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
) -> dict[str, np.ndarray]:
    """Of each joint's body its motion, by Jacobians of its frame; the mass matrix and the bias."""
    gravity = np.asarray(model.gravity, dtype=float)
    found: dict[str, np.ndarray] = {"M": fb.mass_matrix(model, q), "c": fb.bias(model, q, qd)}
    for k, body in enumerate(model.bodies):
        T = fb.forward_kinematics(model, q, frame=body.name)
        J = fb.jacobian(model, q, frame=body.name)
        Jd = fb.jacobian_dot(model, q, qd, frame=body.name)
        E = T[:3, :3].T
        V, A = J @ qd, J @ qdd + Jd @ qd
        found |= {
            f"R{k + 1}": T[:3, :3],
            f"r{k + 1}": T[:3, 3],
            f"w{k + 1}": E @ V[3:],
            f"wd{k + 1}": E @ A[3:],
            f"v{k + 1}": E @ V[:3],
            f"a{k + 1}": E @ (A[:3] - gravity),
        }
    return found


def looked_up(found: dict[str, np.ndarray], word: str) -> float | None:
    """The value that a word should have; None: it is not looked at here."""
    plain = word.removeprefix("minus_").rstrip("_")
    letter, _, axes = plain.partition("_")
    if letter not in found:
        return None
    index = (
        tuple(int(x) for x in axes.split("_"))
        if letter in "Mc"
        else tuple("xyz".index(x) for x in axes)
    )
    return float(found[letter][index]) * (-1.0 if word.startswith("minus_") else 1.0)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("robot", "quantity", "least"),
    [
        ("ur5e", "inverse_dynamics", 35),
        ("ur5e", "forward_dynamics", 25),
        ("ur5e", "forward_kinematics", 10),
        ("panda", "mass_matrix", 5),
        ("iiwa14", "inverse_dynamics", 30),
        ("quadrotor", "inverse_dynamics", 1),
    ],
)
def test_what_is_called_by_a_name_of_the_recursion_is_that(robot, quantity, least):
    model = fb.load(robot).without("friction", "rotors", "springs")
    q, qd, qdd = fb.random_state(model, 4)
    given = {"inverse_dynamics": (q, qd, qdd), "forward_dynamics": (q, qd, qdd)}.get(quantity, (q,))
    # forward dynamics names the motion at zero accelerations
    zero = np.zeros_like(qd)
    motion = {"inverse_dynamics": (qd, qdd), "forward_dynamics": (qd, zero)}.get(
        quantity, (zero, zero)
    )
    wanted = expected(model, q, *motion)
    looked_at = 0
    for word, value in values(model, quantity, *given).items():
        should = looked_up(wanted, word)
        if should is not None:
            looked_at += 1
            assert value == pytest.approx(should, rel=1e-9, abs=1e-9), word
    assert looked_at >= least


def test_forces_are_those_of_the_robot_where_nothing_is_regrouped():
    model = fb.load("ur5e").without("friction", "rotors", "springs")
    q, *_ = fb.random_state(model, 4)
    rest = np.zeros(6)
    found = {
        f"{letter}{k + 1}": wrench[3 * i : 3 * i + 3]
        for k, wrench in enumerate(fb.joint_wrenches(model, q, rest, rest, reference="child"))
        for i, letter in enumerate("fn")
    }
    looked_at = 0
    for word, value in values(model, "static_torque", q).items():
        should = looked_up(found, word)
        if should is not None:
            looked_at += 1
            assert value == pytest.approx(should, rel=1e-9, abs=1e-9), word
    assert looked_at >= 10


def test_a_robot_without_a_joint_goes_out_too(tmp_path):
    """It has no recursion to take names from."""
    block = tmp_path / "block.urdf"
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    block.write_text(
        '<robot name="block"><link name="base"><inertial><mass '
        f'value="1"/>{inertia}</inertial></link></robot>'
    )
    assert "0 operations" in fb.source(fb.load(block), "forward_dynamics", "c")
    assert "M_5_5" not in fb.source(
        fb.load(block, base="free"), "mass_matrix", "c"
    )  # a number, not an operation
