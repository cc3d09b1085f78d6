"""Flexible joints: a shaft that twists between rotor and link, against closed forms, a stiff
reference and Spong's equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import freebody as fb

J, M = 0.9, 2.0
"""Inertia of the rotor seen behind its gear, kg, and the mass behind the shaft, kg."""
ROTOR = {"rotor": 1e-3, "gear": 30.0}


def slide(stiffness, damping=0.0, **drive):
    """A mass that slides without weight behind a flexible shaft."""
    block = fb.planar("P", l=[0], lc=[0], m=[M], I=[0], drives=[fb.Drive(**ROTOR, **drive)])
    block = block.replace(gravity=0.0)
    return block.with_flexible_joint("joint1", stiffness=stiffness, damping=damping)


def arm(**drive):
    """A planar arm of two joints, whose first has a rotor."""
    return fb.planar(
        "RR", m=[1.0, 2.0], lc=[0.3, 0.2], l=[0.7, 0.6], I=[0.1, 0.2],
        drives=[fb.Drive(**ROTOR, **drive), None],
    )  # fmt: skip


def ratio(zeta, stiffness):
    """The damping of a shaft with this damping ratio."""
    return 2.0 * zeta * np.sqrt(stiffness * J * M / (J + M))


# ------------------------------------------------------------ closed forms
@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5])
@pytest.mark.parametrize("zeta", [0.0, 0.05])
def test_frequencies_of_two_masses(stiffness, zeta):
    model = slide(stiffness, ratio(zeta, stiffness))
    A, B = fb.linearize(model, [0, 0], [0, 0], [0, 0])
    found = np.linalg.eigvals(A)
    ringing = found[found.imag > 0]
    natural = np.sqrt(stiffness * (1 / J + 1 / M))
    expected = natural * complex(-zeta, np.sqrt(1 - zeta**2))
    assert ringing == pytest.approx([expected], rel=1e-12)
    assert B[2:, 0] == pytest.approx([1 / J, -1 / J])  # the motor turns the rotor


@pytest.mark.parametrize("stiffness", [1e4, 1e5])
def test_implicit_steps_of_a_millisecond(stiffness):
    """A rotor that a motor swings, its shaft ringing at first, in steps of up to half a radian of
    the ringing."""
    damping = ratio(0.05, stiffness)
    model = slide(stiffness, damping)
    torque = fb.compile(lambda t: [5.0 * fb.math.sin(3.0 * t), 0.0 * t], {"t": ()}, {"tau": 2})
    start = np.array([0.0, 10.0 / stiffness, 0.0, 0.0])
    given = {"method": "implicit", "step": 1e-3}
    found = fb.simulate(model, start[:2], start[2:], [0.0, 1.0], torque, **given).q.values[-1]

    def rates(t, x):
        _, twist, theta_d, twist_d = x
        sent = -stiffness * twist - damping * twist_d
        theta_dd = (5.0 * np.sin(3.0 * t) - sent) / J
        return [theta_d, twist_d, theta_dd, sent / M - theta_dd]

    exact = solve_ivp(rates, (0.0, 1.0), start, "DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
    assert abs(exact[0]) > 0.1
    assert abs(found[0] - exact[0]) < 1e-6


def test_free_ringing_wants_smaller_steps():
    """Implicit steps are stable at any size, and right in size and phase of a ringing where they
    are small beside it."""
    model, natural = slide(1e4), np.sqrt(1e4 * (1 / J + 1 / M))
    errors = []
    for step in (1e-3, 1e-4):
        given = {"method": "implicit", "step": step}
        run = fb.simulate(model, [0.0, 1.0], [0.0, 0.0], [0.0, 1.0], **given)
        errors.append(abs(run.q.values[-1, 1] - np.cos(natural)))
    assert errors[0] > 3e-2
    assert errors[1] < 5e-3


def test_energy_of_a_shaft():
    model = slide(1e4)
    run = fb.simulate(model, [0.0, 1e-2], [0.0, 0.0], np.linspace(0.0, 0.2, 9), tolerance=1e-11)
    energy = (run.kinetic_energy + run.potential_energy).values
    assert energy == pytest.approx(0.5, rel=1e-8)
    twist = run.q.values[:, 1]
    expected = 1e-2 * np.cos(np.sqrt(1e4 * (1 / J + 1 / M)) * run.time.values)
    np.testing.assert_allclose(twist, expected, atol=1e-9)


# ------------------------------------------------------------ other ways to say the same
def test_the_equations_of_spong():
    """M(q) q̈ + c + g = K (θ - q) + D (θ̇ - q̇), J θ̈ + K (θ - q) + D (θ̇ - q̇) = tau - friction, with
    the links' angles q and the rotor's θ."""
    K, D = 300.0, 4.0
    friction = {"viscous": 0.2, "coulomb": 0.3}
    model = arm(**friction).with_flexible_joint("joint1", stiffness=K, damping=D)
    assert model.joint_names == ("joint1", "joint1_twist", "joint2")
    rng = np.random.default_rng(2)
    (theta, twist, q2), (theta_d, twist_d, q2_d), (theta_dd, twist_dd, q2_dd) = rng.normal(
        size=(3, 3)
    )
    links = arm().without("rotors")
    q, qd, qdd = [theta + twist, q2], [theta_d + twist_d, q2_d], [theta_dd + twist_dd, q2_dd]
    needed = fb.inverse_dynamics(links, q, qd, qdd)
    sent = -K * twist - D * twist_d
    tau = fb.inverse_dynamics(
        model, [theta, twist, q2], [theta_d, twist_d, q2_d], [theta_dd, twist_dd, q2_dd]
    )
    rubbing = 0.2 * theta_d + 0.3 * np.sign(theta_d)
    assert tau[1] == pytest.approx(needed[0] - sent)  # nothing drives the shaft
    assert tau[0] == pytest.approx(J * theta_dd + needed[0] + rubbing)
    assert tau[2] == pytest.approx(needed[1])
    assert fb.forward_kinematics(model, [theta, twist, q2]) == pytest.approx(
        fb.forward_kinematics(links, q)
    )


def test_a_stiff_shaft_is_none():
    stiff = arm().with_flexible_joint("joint1", stiffness=1e7, damping=1e3)
    rigid = fb.simulate(arm(), [0.3, -0.2], [0.0, 0.0], [0.0, 0.5], [2.0, 0.5]).q.values[-1]
    found = fb.simulate(
        stiff,
        [0.3, 0.0, -0.2],
        [0.0] * 3,
        [0.0, 0.5],
        [2.0, 0.0, 0.5],
        method="implicit",
        step=1e-3,
    ).q.values[-1]
    assert found[[0, 2]] == pytest.approx(rigid, abs=1e-4)
    assert abs(found[1]) < 1e-5


def test_a_shaft_that_holds_a_weight():
    """At rest the shaft is twisted by what it carries over its stiffness."""
    model = arm().with_flexible_joint("joint1", stiffness=2e3, damping=20.0)
    weight = fb.gravity_torque(arm(), [0.4, 0.3])
    twist = -weight[0] / 2e3
    tau = fb.static_torque(model, [0.4 - twist, twist, 0.3])
    assert tau == pytest.approx([weight[0], 0.0, weight[1]], abs=1e-12)


def test_losses_of_a_flexible_joint_are_of_what_its_shaft_transmits():
    model = slide(1e4, load_friction=0.2)
    for twist, rate in ((1e-3, 0.1), (-1e-3, 0.1), (1e-3, -0.1)):
        tau = 3.0
        sent = -1e4 * twist
        expected = (tau - sent - 0.2 * abs(sent) * np.sign(rate)) / J
        found = fb.forward_dynamics(model, [0.0, twist], [rate, 0.0], [tau, 0.0])
        assert found[0] == pytest.approx(expected)
        assert found.sum() == pytest.approx(sent / M)


def test_flexible_joints_in_a_loop():
    chain = fb.load("four_bar").with_drive("crank_pin", **ROTOR)
    q = fb.assemble(chain, [1.0, -0.6, 1.6])
    flexible = chain.with_flexible_joint("crank_pin", stiffness=2e3)
    assert flexible.loops == chain.loops
    start = np.insert(q, 1, 0.0)
    assert fb.mobility(flexible, start).generic == fb.mobility(chain, q).generic + 1
    run = fb.simulate(flexible, start, [0.0] * 4, np.linspace(0.0, 0.2, 5))
    energy = (run.kinetic_energy + run.potential_energy).values
    assert energy == pytest.approx(energy[0], rel=1e-8)
    assert np.abs(run.q.values[:, 1]).max() > 1e-4


# ------------------------------------------------------------ files, families, what is refused
TEXT = """
[[link]]
name = "ground"
[[link]]
name = "slider"
mass = 2.0
[[joint]]
name = "joint1"
kind = "prismatic"
parent = "ground"
child = "slider"
axis = "x"
rotor = { inertia = 1e-3, gear = 30 }
flexible = { stiffness = 1e4, damping = 5 }
"""


def test_files_have_flexible_joints(tmp_path):
    model = fb.load(text=TEXT, format="toml")
    assert model.joint_names == ("joint1", "joint1_twist")
    assert model.bodies[1].joint.passive
    A = fb.linearize(model, [0, 0], [0, 0], [0, 0])[0]
    expected = fb.linearize(slide(1e4, 5.0), [0, 0], [0, 0], [0, 0])[0]
    np.testing.assert_allclose(A, expected, atol=1e-9)
    fb.save(model, tmp_path / "flexible.toml")
    again = fb.load(tmp_path / "flexible.toml")
    np.testing.assert_array_equal(fb.linearize(again, [0, 0], [0, 0], [0, 0])[0], A)


def test_families_of_shafts():
    several = slide(np.array([1e3, 1e4]), 2.0)
    found = fb.forward_dynamics(several, [0.0, 0.01], [0.0, 0.0], [0.0, 0.0])
    each = [
        fb.forward_dynamics(slide(k, 2.0), [0.0, 0.01], [0.0, 0.0], [0.0, 0.0]) for k in (1e3, 1e4)
    ]
    np.testing.assert_allclose(found, each)
    named = fb.parameters(slide(1e3))
    assert "joint1_twist.spring.stiffness" in {parameter.name for parameter in named}


def test_joints_that_cannot_be_flexible():
    for model, given, words in (
        (fb.planar("R"), {"stiffness": 1.0}, r"joint 'joint1': its rotor has no inertia"),
        (arm(), {"stiffness": 0.0}, r"the stiffness of its shaft is 0; give a number above 0"),
        (arm(), {"stiffness": np.array([1.0, -2.0])}, r"stiffness of its shaft is -2"),
        (arm(), {"stiffness": 1.0, "damping": -1.0}, r"the damping of its shaft is -1; give it as"),
        (arm(stiffness=3.0), {"stiffness": 1.0}, r"its spring acts on the link's angle"),
        (slide(1.0), {"stiffness": 1.0}, r"already has a joint 'joint1_twist'; is 'joint1' fl"),
    ):
        with pytest.raises(fb.ModelError, match=words):
            model.with_flexible_joint("joint1", **given)
    with pytest.raises(fb.UnknownNameError, match="joint3"):
        arm().with_flexible_joint("joint3", stiffness=1.0)
    with pytest.raises(fb.FileError, match=r"joint 'joint1', flexible: its rotor has no inertia"):
        fb.load(text=TEXT.replace("inertia = 1e-3", "inertia = 0"), format="toml")
    finger = """
[[link]]
name = "finger"
mass = 1.0
[[joint]]
name = "follower"
kind = "prismatic"
axis = "y"
parent = "slider"
child = "finger"
mimic = { joint = "joint1" }
"""
    with pytest.raises(
        fb.FileError, match=r"joint 'joint1' is flexible, and its rotor would be fol"
    ):
        fb.load(text=TEXT + finger, format="toml")
    followed = fb.load(text=TEXT.replace("flexible =", "# ") + finger, format="toml")
    with pytest.raises(
        fb.ModelError, match=r"joint 'follower' follows 'joint1', and would follow i"
    ):
        followed.with_flexible_joint("joint1", stiffness=1.0)
    with pytest.raises(
        fb.ModelError, match=r"joint 'follower': it follows 'joint1'; give a joint th"
    ):
        followed.with_flexible_joint("follower", stiffness=1.0)
