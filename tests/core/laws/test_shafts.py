"""Shafts of flexible joints are no joints of the arm: what asks where an arm can be, and how it
moves there, asks its links, and what takes a feature away leaves shafts whole."""

from pathlib import Path

import numpy as np
import pytest

import freebody as fb

ROTOR = {"rotor": 1e-3, "gear": 30.0, "viscous": 0.3, "coulomb": 0.4}
LIMITS = [fb.Limits(-2.0, 2.0, 3.0, 60.0), fb.Limits(-2.5, 2.5, 4.0, 40.0)]


def rigid() -> fb.Model:
    """A planar arm of two joints with rotors."""
    drive = fb.Drive(**ROTOR)
    return fb.planar(
        "RR", m=[1.0, 2.0], lc=[0.3, 0.2], l=[0.7, 0.6], I=[0.1, 0.2], drives=[drive, drive],
        limits=LIMITS,
    )  # fmt: skip


def flexible(**more: float) -> fb.Model:
    """The same arm with a shaft that twists behind its first rotor."""
    return rigid().with_flexible_joint("joint1", **{"stiffness": 800.0, "damping": 4.0, **more})


def shaft_of(model: fb.Model) -> fb.Drive:
    return next(b.joint.drive for b in model.bodies if b.joint.name == "joint1_twist")


# ------------------------------------------------------------ what is taken away
@pytest.mark.parametrize("feature", ["springs", "friction", "rotors", "struts", "loops"])
def test_a_shaft_stays_whole_where_a_feature_is_taken_away(feature):
    model = flexible()
    assert shaft_of(model.without(feature)) == shaft_of(model)


def test_the_features_of_other_joints_go():
    bare = flexible().with_drive("joint2", stiffness=3.0).without("springs", "friction")
    assert {b.joint.name: b.joint.drive.viscous for b in bare.bodies} == {
        "joint1": 0.0,
        "joint1_twist": 4.0,
        "joint2": 0.0,
    }
    assert bare.bodies[2].joint.drive.stiffness == 0.0


@pytest.mark.parametrize("more", [{}, {"stiffness": np.array([500.0, 900.0])}, {"damping": 0.0}])
def test_without_its_shafts_a_robot_is_the_rigid_one(more):
    assert flexible(**more).without("shafts") == rigid()


def test_shafts_of_a_file_go_too(tmp_path: Path):
    fb.save(flexible(), tmp_path / "arm.toml")
    read = fb.load(tmp_path / "arm.toml").without("shafts")
    assert read.joint_names == ("joint1", "joint2")
    q, qd, qdd = fb.random_state(rigid(), 0)
    expected = fb.inverse_dynamics(rigid(), q, qd, qdd)
    assert fb.inverse_dynamics(read, q, qd, qdd) == pytest.approx(expected)


def test_a_passive_joint_beside_another_axis_is_no_shaft():
    cart = fb.planar("PR", passive=["joint2"], drives=[None, fb.Drive(stiffness=5.0)])
    assert cart.without("shafts") == cart
    assert cart.without("springs").bodies[1].joint.drive.stiffness == 0.0


# ------------------------------------------------------------ where the arm is and can be
def test_inverse_kinematics_leaves_shafts_untwisted():
    target = fb.forward_kinematics(rigid(), [0.4, 0.9])[:2, 2]
    found, expected = (fb.inverse_kinematics(x, target) for x in (flexible(), rigid()))
    assert found.method == expected.method
    assert list(found.branches) == list(expected.branches)
    assert found.q[:, [0, 2]] == pytest.approx(expected.q)
    assert (found.q[:, 1] == 0.0).all()
    far = fb.inverse_kinematics(flexible(), [5.0, 0.0])
    assert far.q.shape == (0, 3)
    assert far.distance == pytest.approx(3.7)


def test_solutions_next_to_a_twisted_state_are_next_to_its_links():
    model = fb.planar("RR", l=[0.7, 0.6], drives=[fb.Drive(**ROTOR), None])
    model = model.bind(I1=0.1, I2=0.2, lc1=0.3, lc2=0.2, m1=1.0, m2=2.0)
    target = fb.forward_kinematics(model, [0.4, 0.9])[:2, 2]
    model = model.with_flexible_joint("joint1", stiffness=800.0)
    found = fb.inverse_kinematics(model, target, q0=[6.0, 0.7, 0.5])
    assert found.nearest([6.7, 0.0, 0.9]) == pytest.approx([0.4 + 2 * np.pi, 0.0, 0.9])


def test_kinematic_measures_are_those_of_the_links():
    model, q = flexible(), np.array([0.5, 0.1, 0.8])
    links = [0.6, 0.8]
    at, there = (
        fb.dexterity(model, q, task="position"),
        fb.dexterity(rigid(), links, task="position"),
    )
    assert at.singular_values == pytest.approx(there.singular_values)
    axes = fb.ellipsoids(model, q).velocity
    assert axes == pytest.approx(fb.ellipsoids(rigid(), links).velocity)
    wanted, (a, b) = [0.1, -0.2], fb.inverse_velocity(rigid(), links, [0.1, -0.2])
    assert fb.inverse_velocity(model, q, wanted) == pytest.approx([a, 0.0, b])
    a, b = fb.inverse_acceleration(rigid(), links, [0.3, 0.5], wanted)
    found = fb.inverse_acceleration(model, q, [0.2, 0.1, 0.5], wanted)
    assert found == pytest.approx([a, 0.0, b])
    found = fb.singularities(model)
    assert str(found.determinant) == str(fb.singularities(rigid()).determinant)
    assert found.measure(q) == pytest.approx(fb.singularities(rigid()).measure(links))
    poses = found.search(starts=6)
    assert (poses[:, 1] == 0.0).all()
    assert np.sin(poses[:, 2]) == pytest.approx(0.0, abs=1e-6)


def test_shafts_transmit_what_motors_exert_to_the_tip():
    q, tau = [[0.2, 0.1, 0.5], [0.4, -0.1, 0.9]], [5.0, 0.0, -3.0]
    found = fb.tip_wrench(flexible(), q, tau)
    assert found == pytest.approx(fb.tip_wrench(rigid(), [[0.3, 0.5], [0.3, 0.9]], [5.0, -3.0]))
    with pytest.raises(fb.FreebodyError, match="joint1_twist"):
        fb.tip_wrench(flexible(), q, [5.0, 1.0, -3.0])


def test_ways_to_a_point_are_counted_once():
    points = [[0.9, 0.3], [5.0, 0.0]]
    found, expected = (fb.workspace(x, points) for x in (flexible(), rigid()))
    assert not found.redundant
    assert found.ways.tolist() == expected.ways.tolist()


# ------------------------------------------------------------ motions
def test_the_default_motion_twists_shafts_by_what_they_carry():
    """Nothing but the motors is needed, and the links move as the rigid robot's could."""
    model = flexible()
    motion = fb.default_motion(model)
    tau = fb.inverse_dynamics(model, motion.q, motion.qd, motion.qdd)
    assert np.abs(tau[:, 1]).max() < 1e-6 * np.abs(tau[:, 0]).max()
    assert np.abs(motion.q[:, 1]).max() > 5e-3
    links = motion.q[:, 0] + motion.q[:, 1]
    held = fb.gravity_torque(rigid(), [links[0], motion.q[0, 2]])[0]
    assert motion.q[0, 1] == pytest.approx(-held / 800.0)
    assert (motion.qd[[0, -1]] == 0.0).all()
    for x, rate in ((motion.q, motion.qd), (motion.qd, motion.qdd)):
        slope = np.gradient(x, motion.t, axis=0)[2:-2]
        assert slope == pytest.approx(rate[2:-2], abs=2e-2)


def test_a_table_of_the_links_alone_leaves_shafts_untwisted():
    t = np.linspace(0.0, 2.0, 41)
    table = {"t": t, "joint1": 0.3 * np.sin(t) ** 2, "joint2": 0.5 * np.cos(t)}
    motion = fb.Motion.of(flexible(), table)
    assert (motion.q[:, 1] == 0.0).all()
    assert "joint1_twist untwisted since no column tells of it" in motion.source
    rates = {"joint1.v": 0.3 * np.sin(2.0 * t), "joint2.v": -0.5 * np.sin(t)}
    given = fb.Motion.of(flexible(), table | rates)
    assert given.qd[:, [0, 2]] == pytest.approx(np.stack(list(rates.values()), axis=-1))
    assert (given.qd[:, 1] == 0.0).all()


def pendulum() -> fb.Model:
    """A rod on a flexible joint."""
    drive = fb.Drive(rotor=1e-3, gear=20.0, coulomb=0.2)
    rod = fb.planar("R", m=[2.0], lc=[0.3], l=[0.6], I=[0.1], drives=[drive], limits=LIMITS[:1])
    return rod.with_flexible_joint("joint1", stiffness=400.0, damping=3.0)


def test_a_study_of_the_links_motion_twists_shafts_by_what_they_carry():
    """The motor carries what it does with a rigid joint and the rotor's inertia beside, and the
    links move as told."""
    t = np.linspace(0.0, 1.0, 61)
    told = 0.4 * np.sin(2.0 * t) + 0.3
    study = fb.study(pendulum(), {"t": t, "joint1": told})
    assert study.verdict.outcome == "feasible"
    assert any("Twists of the shafts (joint1_twist): by what they" in x for x in study.warnings)
    given = np.isin(study.motion.t, t)
    rotor, twist = study.motion.q[given].T
    assert rotor + twist == pytest.approx(told, abs=1e-12)
    rod = pendulum().without("shafts", "rotors", "friction")
    qdd = -1.6 * np.sin(2.0 * t)
    carried = fb.inverse_dynamics(rod, told[:, None], told[:, None], qdd[:, None])[:, 0]
    felt = 400.0 * twist + 3.0 * study.motion.qd[given, 1]
    assert felt == pytest.approx(-carried, abs=1e-3)


@pytest.mark.parametrize(("stiffness", "damping"), [(5.0, 0.1), (800.0, 40.0)])
def test_soft_and_damped_shafts_twist_as_their_equation_says(stiffness, damping):
    """Also where damping is more than the spring at the rates that samples can show."""
    motion = fb.default_motion(flexible(stiffness=stiffness, damping=damping))
    twist, rate = motion.q[:, 1], motion.qd[:, 1]
    links = [x[:, [0, 2]] + x[:, [1]] * [1, 0] for x in (motion.q, motion.qd, motion.qdd)]
    carried = fb.inverse_dynamics(rigid().without("friction", "rotors"), *links)[:, 0]
    assert stiffness * twist + damping * rate == pytest.approx(-carried, abs=1e-4)


def test_a_flexible_crank_of_a_closed_chain_stays_untwisted():
    four = fb.load("four_bar").with_drive("crank_pin", rotor=1e-3, gear=20.0)
    model = four.with_flexible_joint("crank_pin", stiffness=500.0, damping=1.0)
    assert model.without("shafts") == four
    motion = fb.default_motion(model)
    assert (motion.q[:, 1] == 0.0).all()
    assert np.ptp(motion.q[:, 0]) > 0.1
    with pytest.raises(fb.SingularError, match=r"flexible joints \(crank_pin_twist\) are not twi"):
        fb.inverse_dynamics(model, motion.q[200], motion.qd[200], motion.qdd[200])
    tip = fb.forward_kinematics(four, fb.assemble(four))[:2, 2]
    found = fb.inverse_kinematics(model, tip)
    assert len(found) == len(fb.inverse_kinematics(four, tip))
    assert (found.q[:, 1] == 0.0).all()


def test_each_member_of_a_family_has_the_solutions_of_its_links():
    model = flexible(stiffness=np.array([500.0, 900.0]))
    target = np.array([[0.9, 0.3], [0.5, 0.4], [5.0, 0.0]])[:, None]
    found, expected = (fb.inverse_kinematics(x, target) for x in (model, rigid()))
    assert found.q.shape == (3, 2, 2, 3)
    for k in range(2):
        np.testing.assert_allclose(found.q[:, k][..., [0, 2]], expected.q[:, 0], atol=1e-12)
    assert found.within_limits.shape == (3, 2, 2)
    assert fb.workspace(model, target[:, 0]).ways.shape == (3, 2)


def test_plans_hold_the_twist_of_their_start():
    model, q0 = flexible(), [0.3, -0.02, 0.9]
    line = fb.line(model, q0, fb.forward_kinematics(model, q0)[:2, 2] + [0.05, 0.1], duration=1.0)
    assert np.abs(line.q[:, 1] + 0.02).max() < 1e-15
    moved = fb.quintic(model, [q0, [0.6, -0.02, 0.5]], [0.0, 1.0])
    assert (moved.q[:, 1] == -0.02).all()
    with pytest.raises(fb.FreebodyError, match=r"^quintic: from waypoint 0 to 1 joint1_twist "):
        fb.quintic(model, [q0, [0.6, 0.1, 0.5]], [0.0, 1.0])
    with pytest.raises(fb.FreebodyError, match=r"such as model\.without\('shafts'\) has"):
        fb.time_optimal(model, [q0, [0.6, -0.02, 0.5]])
