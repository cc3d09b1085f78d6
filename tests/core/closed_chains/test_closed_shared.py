"""What closed chains of one geometry share, families of them, and what no quick path lets
through."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import LoopError, PassiveJointError
from support.helpers import close, raises_own

pytestmark = pytest.mark.usefixtures("numpy_kernels")

MECHANISMS = ["five_bar", "stewart", "bricard"]


def _state(name: str, samples: int = 9):
    model = fb.load(name)
    motion = fb.default_motion(model, samples=samples)
    return model, motion.q, motion.qd, motion.qdd


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MECHANISMS)
def test_a_family_of_one_geometry_is_its_members(name: str):
    model, q, qd, qdd = _state(name)
    frame = model.bodies[-1].name
    family = model.with_payload(mass=np.array([0.0, 1.0, 7.0]), frame=frame).bind(
        {"gravity": np.array([9.81, 0.0, 1.6])}
    )
    wrench = np.full(6 if model.dim == 3 else 3, 0.5)
    calls = {
        "inverse": lambda m, *x: fb.inverse_dynamics(m, *x),
        "wrenched": lambda m, *x: fb.inverse_dynamics(m, *x, wrenches={frame: wrench}),
        "driven": lambda m, *x: fb.inverse_dynamics(m, *x, actuated=list(model.actuated)),
        "static": lambda m, q, *_: fb.static_torque(m, q),
        "forward": lambda m, q, qd, _: fb.forward_dynamics(m, q, qd, np.zeros(model.nv)),
        "pressed": lambda m, q, qd, qdd: _pressed(m, q, qd, qdd=qdd),
        "moved": lambda m, q, qd, _: _pressed(m, q, qd, tau=np.zeros(model.nv)),
    }
    for label, call in calls.items():
        found = call(family, *(x[:, None] for x in (q, qd, qdd)))
        assert found.shape[:2] == (len(q), 3), label
        for k in range(3):
            expected = call(family[k], q, qd, qdd)
            close(found[:, k], expected, 1e-12, np.abs(expected).max(), label)


@pytest.mark.sample(1)
@pytest.mark.parametrize("step", ["semi_implicit_step", "rk4_step", "implicit_step"])
def test_steps_of_a_family_are_those_of_its_members(step: str):
    model, q, qd, _ = _state("five_bar")
    family = model.with_payload(mass=np.array([0.0, 1.0, 7.0]), frame="P4")
    given = np.zeros(model.nv), 1e-2
    found = fb.kernel(family, step)(q[:, None], qd[:, None], *given)
    for k in range(3):
        for a, b in zip(found, fb.kernel(family[k], step)(q, qd, *given), strict=True):
            close(a[:, k], b, 1e-13, 1.0 + np.abs(b).max())


def _pressed(model, q, qd, **given):
    """All reactions of a motion, what of them is determined, and whether they balance."""
    found = fb.reactions(model, q, qd, **given)
    assert found.balance < 1e-9
    entries = found.wrenches.reshape(*found.wrenches.shape[:-2], -1)
    return np.concatenate([entries, found.multipliers, found.tau, found.qdd], axis=-1)


def test_members_near_a_singular_position_take_the_careful_way_each():
    """A parallelogram that is almost flat: no fixed choice of equations and coordinates holds."""
    flat = fb.load("four_bar").bind(l1=0.3, l3=0.3, l2=1.0, d=1.0)
    q = fb.assemble(flat, [1e-4, -1e-4, 1e-4], free=("coupler_pin", "rocker_pin"))
    assert np.isnan(fb.kernel(flat, "static_torque")(q)).any()
    family = flat.bind(m1=[1.0, 2.0, 5.0])
    still = np.zeros(3)
    torque, acceleration = fb.static_torque(family, q), fb.forward_dynamics(family, q, still, still)
    for k in range(3):
        expected = fb.static_torque(family[k], q)
        close(torque[k], expected, 1e-12, np.abs(expected).max())
        expected = fb.forward_dynamics(family[k], q, still, still)
        close(acceleration[k], expected, 1e-12, np.abs(expected).max())


def test_families_of_other_lengths_are_refused():
    model, q, qd, qdd = _state("four_bar")
    for call in (fb.inverse_dynamics, fb.forward_dynamics):
        with raises_own(TypeError, match="lengths or placements differ"):
            call(model.bind(l1=[0.2, 0.21]), q[0], qd[0], 0.0 * qdd[0])


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MECHANISMS)
def test_what_the_loops_do_not_allow_is_refused_in_any_batch(name: str):
    """Also where a batch is a product of two, so that there are more results than inputs."""
    model, q, qd, qdd = _state(name, 12)
    none = np.zeros(model.nv)
    forward = fb.forward_dynamics(model, q[:, None], qd[:, None] * 0.0, np.zeros((12, model.nv)))
    assert forward.shape == (12, 12, model.nv)
    fb.inverse_dynamics(model, q, qd, qdd), fb.static_torque(model, q)
    open_q, k = np.array(q), int(np.argmax(np.abs(qd[3])))
    open_q[7] = fb.integrate(model, q[7], 0.05 * np.eye(model.nv)[k])
    late = np.array(qd)
    late[5, k] += 0.1
    pushed = np.array(qdd)
    pushed[2, k] += 1.0
    for call, what in (
        (
            lambda: fb.forward_dynamics(model, open_q[:, None], qd * 0.0, none),
            r"is open by .* sample \(7, 0\)",
        ),
        (lambda: fb.forward_dynamics(model, open_q[7], none, none), "is open by"),
        (lambda: fb.static_torque(model, open_q), "is open by .* sample 7"),
        (lambda: fb.static_torque(model, open_q[7]), "is open by"),
        (lambda: fb.inverse_dynamics(model, open_q, qd, qdd), "is open by .* sample 7"),
        (lambda: fb.forward_dynamics(model, q, late, none), "would open at .* sample 5"),
        (lambda: fb.forward_dynamics(model, q[5], late[5], none), "would open at"),
        (lambda: fb.inverse_dynamics(model, q, late, qdd), "would open at .* sample 5"),
        (lambda: fb.inverse_dynamics(model, q[2], qd[2], pushed[2]), "under these accelerations"),
        (lambda: fb.inverse_dynamics(model, q, qd, pushed), "sample 2 under these accelerations"),
    ):
        with pytest.raises(LoopError, match=what):
            call()


def test_a_loop_closed_the_wrong_way_round_is_refused_quickly_too():
    """Its equations hold there, sines of half a turn being zero."""
    numbers = {"l": [1.0, 1.5, 1.2, 0.5], "lc": [0.5] * 4, "m": [1.0] * 4, "I": [0.1] * 4}
    chain = fb.planar("RRRR", **numbers).with_frame("mount", (1.2, 0.4), frame="base")
    model = chain.with_loop("weld", "fixed", ("mount", chain.tip))
    q, still = fb.assemble(model, [0.9, -1.0, -1.0, 0.5]), np.zeros(4)
    fb.forward_dynamics(model, q, still, still)
    back = chain.with_frame("back", rotation=[[-1, 0], [0, -1]])
    way = fb.assemble(back.with_loop("weld", "fixed", ("mount", "back")), q)
    assert np.abs(fb.kernel(model, "constraint")(way)).max() < 1e-9
    for call in (
        lambda: fb.forward_dynamics(model, way, still, still),
        lambda: fb.static_torque(model, way),
    ):
        with pytest.raises(LoopError, match="the wrong way round"):
            call()


def test_a_torque_at_a_passive_joint_is_refused_quickly_too():
    model, q, qd, _ = _state("five_bar")
    tau = np.zeros(model.nv)
    fb.forward_dynamics(model, q[0], qd[0], tau)
    tau[model.passive[0]] = 0.1
    for batch in (
        (q[0], qd[0], tau),
        (q, qd, np.broadcast_to(tau, qd.shape)),
        ([*q[0]], [*qd[0]], [*tau]),
    ):
        with pytest.raises(PassiveJointError):
            fb.forward_dynamics(model, *batch)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MECHANISMS)
def test_a_sample_does_not_depend_on_its_neighbours(name: str):
    model, q, qd, qdd = _state(name, 9)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    whole = fb.forward_dynamics(model, q, qd, tau)
    for k in range(9):
        np.testing.assert_array_equal(fb.forward_dynamics(model, q[k], qd[k], tau[k]), whole[k])
        np.testing.assert_array_equal(fb.inverse_dynamics(model, q[k], qd[k], qdd[k]), tau[k])
