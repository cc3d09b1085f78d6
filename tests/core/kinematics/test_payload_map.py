"""The largest mass that an arm holds at rest: by the torques of the arm that carries it."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


@pytest.mark.parametrize(("name", "point"), [("ur5e", [0.1, -0.05, 0.2]), ("2R", [0.2, 0.1])])
def test_that_mass_and_no_more(name, point):
    """With the payload, some joint is at its effort limit, and none is beyond; that joint is the
    one named."""
    model = fb.load(name)
    effort = np.linspace(60.0, 30.0, model.nv)
    q, _, _ = fb.random_state(model, 2, 20)
    found = fb.payload_map(model, q, effort=effort, point=point)
    assert (found.mass > 0).any()
    for k in range(20):
        mass = found.mass[k]
        carrying = model.with_payload(mass=max(mass, 1e-12), com=point)
        share = np.abs(fb.static_torque(carrying, q[k])) / effort
        if found.overloaded[k]:
            assert mass == 0.0
            assert share[found.joint[k]] > 1.0
        else:
            assert share.max() == pytest.approx(1.0, abs=1e-12)
            assert int(np.argmax(share)) == found.joint[k]
    assert fb.payload_map(model, q[3], effort=effort, point=point).mass == found.mass[3]


def test_a_pendulum_by_hand():
    """m g l cos q and M g L cos q together at the motor's torque; hanging, nothing limits it."""
    arm = fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1])
    found = fb.payload_map(arm, [[0.0], [np.pi / 3], [-np.pi / 2]], effort=[100.0])
    by_hand = [(100.0 / (9.81 * c) - 3.0 * 1.0) / 2.0 for c in (1.0, 0.5)]
    assert np.allclose(found.mass[:2], by_hand, rtol=1e-13)
    assert found.mass[2] > 1e10 or np.isinf(found.mass[2])
    table = found.to_xarray()
    assert table["mass"].dims == ("posture",)
    assert table["mass"].attrs["units"] == "kg"
    assert table["joint"].values[0] == "joint1"
    weak = fb.payload_map(arm, [0.0], effort={"joint1": 10.0})
    assert weak.mass == 0.0
    assert weak.overloaded
    assert weak.joint == 0
    assert "A joint is overloaded without payload in 1 posture." in weak._table().notes


def test_limits_of_the_model_are_taken():
    model = fb.load("ur5e")
    q, _, _ = fb.random_state(model, 0, 50)
    efforts = model.limits.effort
    assert fb.payload_map(model, q) == fb.payload_map(model, q, effort=efforts)
    assert repr(fb.payload_map(model, q)).startswith("<Payload map: 50 postures, ")
    limits = [fb.Limits(effort=50.0), fb.Limits(effort=0.0)]  # 0 in files is "not given"
    arm = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1], limits=limits)
    found = fb.payload_map(arm, [0.0, 0.0])
    assert (found.joint, found.overloaded) == (0, False)
    assert found.mass == fb.payload_map(arm, [0.0, 0.0], effort=[50.0, 1e9]).mass


def test_refusals():
    arm = fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1])
    flexible = arm.with_drive("joint1", rotor=0.1).with_flexible_joint("joint1", stiffness=9.0)
    for words, call in (
        (
            "'joint1_twist' of 'R' is passive: a spring holds it and gives way to the mass",
            lambda: fb.payload_map(flexible, [0.0, 0.0], effort=[1.0] * 2),
        ),
        ("no joint of 'R' has an effort limit", lambda: fb.payload_map(arm, [0.0])),
        ("without gravity", lambda: fb.payload_map(arm.replace(gravity=0), [0.0], effort=[1.0])),
        ("one positive number", lambda: fb.payload_map(arm, [0.0], effort=[-1.0])),
        ("no joint of 'five_bar' has", lambda: fb.payload_map(fb.load("five_bar"), np.zeros(4))),
        (
            "loop 'tip_pin' of 'five_bar' is open",
            lambda: fb.payload_map(fb.load("five_bar"), np.zeros(4), effort=[1.0] * 4),
        ),
        (
            "'joint1' of 'acrobot' is passive",
            lambda: fb.payload_map(fb.load("acrobot"), [0.0, 0.0], effort=[1.0] * 2),
        ),
        ("point has shape", lambda: fb.payload_map(arm, [0.0], effort=[1.0], point=[1.0])),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            call()


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["2R", "polar_arm"])
def test_families_are_their_members(name):
    """Of other masses and efforts; the batch ends in the family's shape."""
    arm = fb.load(name)
    masses = [n for n in fb.parameters(arm).names if n.endswith(".mass") or n in ("m1", "m2")]
    family = arm.bind({n: fb.parameters(arm)[n].value * np.array([0.5, 1.0, 2.0]) for n in masses})
    assert family.family == (3,)
    q, _, _ = fb.random_state(arm, 3, 5)
    effort = np.outer([3.0, 2.0, 1.5], np.linspace(60.0, 30.0, arm.nv))
    for point in (None, [0.2, 0.1, -0.3][: arm.dim]):
        found = fb.payload_map(family, q[:, None], effort=effort, point=point)
        assert found.mass.shape == (5, 3)
        for k in range(3):
            one = fb.payload_map(family[k], q, effort=effort[k], point=point)
            assert np.allclose(found.mass[:, k], one.mass, rtol=1e-11)
            assert (found.joint[:, k] == one.joint).all()
    assert (found.mass > 0).any()


def test_a_closed_chain_and_no_more():
    """A five-bar with the mass is at one motor's torque, and no other is beyond it."""
    model = fb.load("five_bar")
    closed = fb.assemble(model, {"theta1": 2.0, "theta2": 0.9})
    effort = {"theta1": 40.0, "theta2": 25.0}
    found = fb.payload_map(model, closed, effort=effort, point=[0.05, 0.1])
    assert np.isfinite(found.mass)
    carrying = model.with_payload(mass=float(found.mass), com=[0.05, 0.1])
    share = np.abs(fb.static_torque(carrying, closed)) / [40.0, 25.0, 1.0, 1.0]
    assert share.max() == pytest.approx(1.0, abs=1e-12)
    assert int(np.argmax(share)) == found.joint
    several = fb.payload_map(model, np.stack([closed] * 3), effort=effort, point=[0.05, 0.1])
    assert (several.mass == found.mass).all()
