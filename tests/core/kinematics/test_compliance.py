"""Robots whose joints yield: natural frequencies and modes, and deflections under loads."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import freebody as fb

SPRINGS = np.array([3e4, 3e4, 2e4, 8e3, 8e3, 8e3])
ROTORS = [1e-4, 1e-4, 1e-4, 3e-5, 3e-5, 3e-5]


@pytest.fixture(scope="module")
def arm() -> fb.Model:
    """A UR5e with rotors that are invented."""
    model = fb.load("ur5e")
    for name, rotor in zip(model.joint_names, ROTORS, strict=True):
        model = model.with_drive(name, rotor=rotor, gear=101.0, viscous=1.0)
    return model


@pytest.fixture(scope="module")
def shafts(arm) -> fb.Model:
    """The same with its shafts as joints."""
    model = arm
    for name, k in zip(arm.joint_names, SPRINGS, strict=True):
        model = model.with_flexible_joint(name, stiffness=k, damping=3.0)
    return model


def untwisted(model: fb.Model, q: np.ndarray) -> np.ndarray:
    """Positions of flexible joints that are not twisted."""
    return np.stack([q, np.zeros_like(q)], axis=-1).reshape(*q.shape[:-1], model.nq)


@pytest.mark.parametrize("kappa", [5.0, 1e4])
def test_two_masses_and_a_shaft(kappa):
    """ω = √(k/μ), with μ = J n² I / (J n² + I); together they turn freely."""
    rigid = fb.planar("R", l=[1.0], lc=[0.4], m=[2.0], I=[0.3], g=[0.0, 0.0])
    arm = rigid.with_drive("joint1", rotor=2e-5, gear=50.0)
    model = arm.with_flexible_joint("joint1", stiffness=kappa)
    motor, link = 2e-5 * 50.0**2, 0.3 + 2.0 * 0.4**2
    found = fb.natural_frequencies(model, [0.3, 0.0])
    by_hand = np.sqrt(kappa / (motor * link / (motor + link)))
    assert found.squares[0] == 0.0
    assert 2 * np.pi * found.frequencies[1] == pytest.approx(by_hand, rel=1e-12)
    theta, twist = found.modes[1]
    assert motor * theta + link * (theta + twist) == pytest.approx(0.0, abs=1e-12)
    held = fb.natural_frequencies(model, [0.3, 0.0], held=model.driven_names)
    for one in (held, fb.natural_frequencies(arm, [0.3], [kappa])):
        assert one.squares == pytest.approx([kappa / link], rel=1e-12)
    assert held.held == ("joint1",)
    assert "joint1_twist" in str(held.to_xarray()["coordinate"].values)


def test_a_pendulum_hangs_and_falls():
    arm = fb.planar("R", l=[1.0], lc=[0.4], m=[2.0], I=[0.3])
    square = 9.81 * 2.0 * 0.4 / (0.3 + 2.0 * 0.4**2)
    found = fb.natural_frequencies(arm, [[-np.pi / 2], [np.pi / 2]], held=())
    assert found.squares[:, 0] == pytest.approx([square, -square], rel=1e-12)
    assert found.stable.tolist() == [True, False]
    assert np.isnan(found.frequencies[1, 0])
    assert "falls away from 1 posture" in str(found._table().notes)


def test_modes_are_those_of_scipy(arm, shafts):
    """Six compliant coordinates by the kernel, twelve by LAPACK; each mode obeys K v = ω² M v."""
    q, _, _ = fb.random_state(arm, 4, 12)
    bare = arm.without("rotors", "friction")
    rest = np.zeros(6)
    cases = [
        (fb.natural_frequencies(arm, q, SPRINGS), bare, q, np.diag(SPRINGS)),
        (fb.natural_frequencies(shafts, untwisted(shafts, q)), shafts.without("friction"),
         untwisted(shafts, q), np.zeros((12, 12))),
    ]  # fmt: skip
    for found, model, at, springs in cases:
        rest = np.zeros(model.nv)
        for k in range(len(at)):
            M = fb.mass_matrix(model, at[k])
            K = springs + fb.inverse_dynamics_derivatives(model, at[k], rest, rest)[0]
            squares = np.asarray(eigh(K, M, eigvals_only=True))
            off = np.abs(found.squares[k] - squares)
            assert (off <= 1e-9 * np.maximum(np.abs(squares), 1e-4 * squares[-1])).all()
            assert (off[-6:] <= 1e-9 * squares[-6:]).all()
            V = found.modes[k]
            assert np.allclose(V @ M @ V.T, np.eye(model.nv), atol=1e-10)
            assert np.allclose(V @ K @ V.T, np.diag(squares), atol=1e-10 * squares[-1])


def test_a_given_stiffness_is_a_shaft_of_which_the_motor_stands(arm, shafts):
    q, _, _ = fb.random_state(arm, 5, 6)
    given = fb.natural_frequencies(arm, q, dict(zip(arm.joint_names, SPRINGS, strict=True)))
    own = fb.natural_frequencies(shafts, untwisted(shafts, q), held=shafts.driven_names)
    assert np.allclose(own.squares, given.squares, rtol=1e-9)
    assert np.allclose(own.modes[..., 1::2], given.modes, atol=1e-8)
    loads = {arm.tip: [30.0, -20.0, 10.0, 1.0, 2.0, 3.0]}
    bent = fb.deflection(arm, q, loads, stiffness=SPRINGS)
    twisted = fb.deflection(shafts, untwisted(shafts, q), loads)
    assert np.allclose(bent.displacement, twisted.displacement, rtol=1e-9, atol=1e-15)
    assert np.allclose(bent.joints, twisted.joints[..., 1::2], rtol=1e-9, atol=1e-15)
    rigid = fb.deflection(arm, q, loads, stiffness=[np.inf, *SPRINGS[1:]])
    assert (rigid.joints[:, 0] == 0.0).all()
    less = fb.natural_frequencies(arm, q, {arm.joint_names[1]: 1e4})
    assert less.squares.shape == (6, 1)
    assert len(less.held) == 5


def test_a_beam_by_hand():
    """An arm that lies level sinks by m g lc l / k, and by F l² / k more under a load."""
    arm = fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1])
    found = fb.deflection(arm, [0.0], [0.0, -10.0, 0.0], stiffness=[5e3])
    assert found.by_gravity == pytest.approx([0.0, -3.0 * 9.81 * 2.0 / 5e3, -3.0 * 9.81 / 5e3])
    assert found.by_wrenches == pytest.approx([0.0, -10.0 * 4.0 / 5e3, -20.0 / 5e3])
    assert found.distance == pytest.approx((3.0 * 9.81 * 2.0 + 40.0) / 5e3)
    soft = fb.deflection(arm, [[0.0], [1.5]], stiffness=[200.0])
    assert soft.far.tolist() == [True, False]
    assert "only a hint in 1 posture" in str(soft._table().notes)
    assert soft.to_xarray()["by_gravity"].dims == ("posture", "component")


def test_the_yielded_robot_is_in_equilibrium(arm):
    """Up to what is quadratic in the deflection, springs then balance weights and loads; and what a
    force here moves there, the same force there moves here (Maxwell)."""
    q, _, _ = fb.random_state(arm, 6, 5)
    stiff = 1e4 * SPRINGS
    elbow, tip = "forearm_link", arm.tip
    for load in np.eye(6)[:3] * 50.0:
        found = fb.deflection(arm, q, {tip: load}, stiffness=stiff)
        torque = fb.static_torque(arm, q + found.joints, {tip: load})
        assert np.allclose(torque, -stiff * found.joints, atol=1e-4)
        moved = fb.forward_kinematics(arm, q + found.joints) - fb.forward_kinematics(arm, q)
        assert np.allclose(moved[..., :3, 3], found.displacement[..., :3], atol=1e-10)
    for a, b in ((0, 1), (2, 4), (5, 3)):
        first, second = (
            fb.deflection(arm, q, {one: np.eye(6)[i]}, frame=other, stiffness=SPRINGS)
            for one, other, i in ((elbow, tip, a), (tip, elbow, b))
        )
        assert np.allclose(first.by_wrenches[..., b], second.by_wrenches[..., a], atol=1e-15)


def test_maps_are_drawn(arm):
    grid = np.stack(np.meshgrid([0.3, 0.5], [0.2, 0.4]), axis=-1)
    points = np.insert(grid, 1, 0.1, axis=-1)
    q = np.broadcast_to([0.0, -1.2, 1.5, 0.0, 1.0, 0.0], (2, 2, 6)) + 0.1 * grid[..., :1]
    hertz = fb.natural_frequencies(arm, q, SPRINGS).frequencies[..., 0]
    sinks = 1e3 * fb.deflection(arm, q, stiffness=SPRINGS).distance
    for values, title in ((hertz, "Hz"), (sinks, "mm")):
        assert title in fb.map_diagram(arm, points, values, title=title).svg


def test_refusals(arm):
    chain, q = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1]), [0.1, 0.2]
    for kind, words, call in (
        (fb.FreebodyError, "no joint of 'RR' yields", lambda: fb.natural_frequencies(chain, q)),
        (fb.FreebodyError, "Give stiffness=", lambda: fb.deflection(chain, q)),
        (fb.FreebodyError, "must be numbers above 0",
         lambda: fb.deflection(chain, q, stiffness=[1.0, -1.0])),
        (fb.FreebodyError, "must be numbers above 0",
         lambda: fb.deflection(chain, q, stiffness=[1.0, np.nan])),
        (fb.FreebodyError, "must be numbers above 0",
         lambda: fb.natural_frequencies(chain, q, [1.0, 0.0])),
        (fb.FreebodyError, "must be numbers above 0",
         lambda: fb.deflection(chain, q, stiffness={"joint1": 1.0, "joint2": 0.0})),
        (fb.FreebodyError, "infinite in some samples alone",
         lambda: fb.natural_frequencies(chain, q, [[1.0, np.inf], [1.0, 1.0]])),
        (fb.FreebodyError, "do not broadcast together",
         lambda: fb.natural_frequencies(chain, [q] * 3, np.ones((2, 2)))),
        (fb.ShapeError, "one for each of joint1 and joint2",
         lambda: fb.natural_frequencies(chain, q, [1.0])),
        (fb.FreebodyError, "held=", lambda: fb.natural_frequencies(chain, q, held=["elbow"])),
        (fb.SingularError, "nothing holds all of", lambda: fb.deflection(
            chain.replace(actuated=["joint1"]), q, stiffness={"joint1": 1.0})),
        (fb.LoopError, "is open by", lambda: fb.deflection(fb.load("five_bar"), np.zeros(4))),
    ):  # fmt: skip
        with pytest.raises(kind, match=words):
            call()
    point = fb.planar("RR", l=[1, 0], lc=[0.5, 0], m=[1, 0], I=[0.1, 0])
    with pytest.raises(fb.SingularError, match="moves no mass"):
        fb.natural_frequencies(point, q, [1.0, 1.0])
