"""Simulation: printed numbers of others, conserved energy, friction stiff and mild, and what is
refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, NotFiniteError, ShapeError, SingularError, UnknownNameError
from support.robots import Joint, Link, Robot, loaded


def pendulum(**friction: float) -> fb.Model:
    return fb.planar("R", l=[1.0], lc=[1.0], m=[1.0], I=[0.0], drives=[fb.Drive(**friction)])


def body(
    kind: str,
    mass: float,
    com: tuple[float, float, float],
    moments: tuple[float, float, float],
    g: float,
):
    xx, yy, zz = moments
    link = Link("body", fb.Inertia(mass, com, (xx, 0.0, 0.0, yy, 0.0, zz)))
    joint = Joint("joint", kind, "world", "body")
    return loaded(Robot(kind, 3, (Link("world"), link), (joint,), g))


def test_pendulum_of_the_iftomm_library():
    # released at rest from x = -1; printed to 11 digits
    found = fb.simulate(pendulum(), [np.pi], [0.0], [0, 1, 10], tolerance=1e-12)
    q = found["q"].values[:, 0]
    printed = [[0.98629175113, -0.16501085313], [-0.27508746258, -0.96141920510]]
    np.testing.assert_allclose(
        np.stack([np.cos(q), np.sin(q)], axis=-1)[1:], printed, rtol=0, atol=5e-11
    )


def test_heavy_top():
    top = body("spherical", 15.0, (0, 1.0, 0), (0.234375, 0.46875, 0.234375), 9.81)
    found = fb.simulate(top, [1, 0, 0, 0], [0, 150, -4.61538], [0, 0.2], tolerance=1e-12)
    q = found["q"].values[-1]
    printed = np.array([-0.708279152975, 0.438781088126, 0.545728396145, 0.089399752823])
    np.testing.assert_allclose(q * np.sign(q @ printed), printed, rtol=0, atol=1e-11)
    np.testing.assert_allclose(
        found["qd"].values[-1], [-2.691590912, 150, 4.917260990], rtol=0, atol=5e-10
    )


@pytest.mark.parametrize(("kind", "still"), [("free", [0.0, 0.0, 0.0]), ("spherical", [])])
def test_a_free_axisymmetric_body(kind: str, still: list[float]):
    model = body(kind, 1.0, (0, 0, 0), (0.04, 0.04, 0.02), 0.0)
    found = fb.simulate(model, [*still, 1, 0, 0, 0], [*still, 2, 4, 6], [0, 1], tolerance=1e-12)
    printed = [-1.4155049609614219, -4.242210002521516, 6]
    np.testing.assert_allclose(found["qd"].values[-1][-3:], printed, rtol=0, atol=1e-12)
    assert np.linalg.norm(found["q"].values[-1][-4:]) == pytest.approx(1.0, abs=1e-15)


def test_energy_stays_without_friction_and_torque():
    model = fb.load("3R").without("friction")
    found = fb.simulate(model, [0.3, 0.2, -0.4], [0, 0, 0], np.linspace(0, 3, 31), tolerance=1e-12)
    energy = found["kinetic_energy"] + found["potential_energy"]
    assert float(np.ptp(energy.values)) < 1e-9 * float(found["kinetic_energy"].max())
    assert found.attrs["method"] == "DOP853"
    assert found.attrs["dry_friction"] == "none"
    assert all("units" in found[name].attrs for name in found.data_vars)
    assert found.sizes == {"time": 31, "position": 3, "coordinate": 3}


def test_energy_that_friction_takes():
    model = pendulum(viscous=0.3, coulomb=0.5)
    t = np.linspace(0, 2, 4001)
    found = fb.simulate(model, [0.0], [0.0], t, friction_width=1e-2)
    qd = found["qd"].values[:, 0]
    lost = np.trapezoid(0.3 * qd**2 + 0.5 * np.tanh(qd / 1e-2) * qd, t)
    energy = (found["kinetic_energy"] + found["potential_energy"]).values
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=1e-5)


def test_torque_as_constant_table_and_function():
    model, t = fb.load("2R"), np.linspace(0, 1, 11)
    torque = np.array([20.0, 5.0])
    given = (torque, np.tile(torque, (11, 1)), lambda t, q, qd: torque)
    runs = [fb.simulate(model, [0, 0], [0, 0], t, torque=g)["q"].values for g in given]
    np.testing.assert_allclose(runs[1], runs[0], atol=1e-9)
    np.testing.assert_allclose(runs[2], runs[0], atol=1e-9)
    ramp = fb.simulate(pendulum(), [0], [0], [0, 1], torque=[[0.0], [2.0]])
    function = fb.simulate(pendulum(), [0], [0], [0, 1], torque=lambda t, q, qd: [2 * t])
    np.testing.assert_allclose(ramp["q"], function["q"], atol=1e-9)
    np.testing.assert_array_equal(ramp["tau"], [[0.0], [2.0]])


def test_torques_of_a_motion_lead_along_it():
    model = fb.load("ur5e")
    motion = fb.default_motion(model)
    t = motion.t[:81]
    found = fb.simulate(
        model,
        motion.q[0],
        motion.qd[0],
        t,
        lambda t, q, qd: fb.inverse_dynamics(model, *motion.at(t)),
    )
    np.testing.assert_allclose(found["q"], motion.q[:81], atol=1e-7)
    np.testing.assert_allclose(found["qdd"], motion.qdd[:81], atol=1e-5)


def test_a_constant_wrench_pushes():
    model = fb.planar("P", lc=[0.0], m=[2.0], I=[0.0], g=0.0)
    found = fb.simulate(model, [0], [0], [0, 3], wrenches={"tip": [4.0, 1.0, 0.5]})
    np.testing.assert_allclose(found["q"][-1], [0.5 * 2.0 * 9.0], rtol=1e-9)
    np.testing.assert_allclose(
        fb.simulate(model, [0], [0], [0, 3], wrenches=[4.0, 1.0, 0.5])["q"], found["q"]
    )


def test_stiff_friction_is_integrated_implicitly_and_sticks():
    model = pendulum(coulomb=20.0)  # more than gravity can move
    found = fb.simulate(model, [0.0], [0.0], [0, 1.0])
    assert found.attrs["method"] == "Radau"
    assert found.attrs["dry_friction"] == "c tanh(q̇ / 0.001)"
    creep = float(found["q"][-1, 0])
    assert -1e-3 < creep < 0  # below the stated width
    with pytest.warns(fb.FreebodyWarning, match="the motion is stiff"):
        explicit = fb.simulate(model, [0.0], [0.0], [0, 0.05], method="DOP853")
    implicit = fb.simulate(model, [0.0], [0.0], [0, 0.05], method="Radau")
    np.testing.assert_allclose(explicit["q"], implicit["q"], atol=1e-10)


@pytest.mark.parametrize("method", ["RK45", "BDF", "LSODA", "Radau"])
def test_methods_agree(method: str):
    args = (fb.load("2R"), [0.1, 0.2], [0, 0], [0, 0.5])
    found, expected = fb.simulate(*args, method=method, tolerance=1e-9), fb.simulate(*args)
    np.testing.assert_allclose(found["q"], expected["q"], atol=1e-6)


def test_what_is_refused():
    model = fb.load("2R")
    with pytest.raises(
        ShapeError,
        match=r"^simulate: q has shape \(3,\), expected \(\.\.\., 2\): model '2R' has nq = 2\.",
    ):
        fb.simulate(model, [0, 0, 0], [0, 0], [0, 1])
    with pytest.raises(NotFiniteError, match=r"simulate: q is nan"):
        fb.simulate(model, [0, np.nan], [0, 0], [0, 1])
    with pytest.raises(FreebodyError, match=r"simulate: the times t must increase\."):
        fb.simulate(model, [0, 0], [0, 0], [0, 1, 1])
    with pytest.raises(
        UnknownNameError, match=r"no method 'Euler' in simulate\. Methods: auto, DOP853"
    ):
        fb.simulate(model, [0, 0], [0, 0], [0, 1], method="Euler")
    with pytest.raises(
        FreebodyError, match=r"torque has shape \(5, 2\), expected \(2,\), \(2, 2\) or a function\."
    ):
        fb.simulate(model, [0, 0], [0, 0], [0, 1], torque=np.zeros((5, 2)))
    with pytest.raises(ShapeError, match=r"what torque\(t, q, qd\) returns has shape \(3,\)"):
        fb.simulate(model, [0, 0], [0, 0], [0, 1], torque=lambda t, q, qd: np.zeros(3))
    with pytest.raises(SingularError, match=r"joint 'joint2' moves no inertia"):
        fb.simulate(
            fb.planar("RR", l=[1, 1], lc=[1, 0], m=[1, 0], I=[0, 0]), [0, 0], [0, 0], [0, 1]
        )


def test_a_run_that_cannot_go_on_says_when():
    def torque(t: float, q, qd):
        return [np.nan] if t > 0.5 else [0.0]

    with pytest.raises(
        FreebodyError,
        match=r"simulate: DOP853 stopped after t = .* s \(.*\)\. The motion may diverge",
    ):
        fb.simulate(pendulum(), [0], [0], np.linspace(0, 1, 11), torque=torque)


def test_a_run_of_very_many_steps_says_so_while_it_can_be_stopped():
    class Enough(Exception):
        pass

    def stop(text: str, done: float) -> None:
        if len(told) or done > 0.02:
            raise Enough

    wrist = fb.planar("R", l=[0.1], lc=[0.01], m=[0.1], I=[1e-4])
    wrist = wrist.with_drive("joint1", coulomb=1.0)
    said = r"1000 steps led from .* more follow.* method='implicit' with step="
    with pytest.warns(fb.FreebodyWarning, match=said) as told, pytest.raises(Enough):
        fb.simulate(
            wrist, [0.0], [0.0], [0, 10], lambda t, q, qd: [2 * np.sin(300 * t)],
            sample_time=1e-3, progress=stop,
        )  # fmt: skip


def test_stiff_feedback_is_found_and_integrated_implicitly():
    """A rate gain of 20 N m s on a wrist of 2e-4 kg m²: what an explicit method would take 16,000
    steps a second for."""
    arm = fb.load("ur5e")
    q = [0.3, -1.2, 1.0, 0.2, 0.5, 0.1]
    calls = []

    def hold(t, q, qd):
        calls.append(t)
        return -100 * q - 20 * qd

    run = lambda **options: fb.simulate(arm, q, np.zeros(6), [0, 0.5], hold, **options)
    found, exact = run(), run(method="Radau", tolerance=1e-11)
    assert found.attrs["method"] == "LSODA"
    assert len(calls) < 40_000
    calls.clear()
    rough = run(method="Radau", tolerance=1e-6)
    assert len(calls) < 4_000  # 2,000,000 without the slopes of the feedback
    for other, tolerance in ((found, 1e-9), (rough, 1e-5)):
        np.testing.assert_allclose(other["q"], exact["q"], atol=tolerance)


def stiffer(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Feedback that is mild at first."""
    return -(10.0 + 3e4 / (1.0 + np.exp(-200.0 * (t - 0.3)))) * qd - 5.0 * q


def test_stiffness_on_the_way_changes_the_method_or_is_told():
    rod = pendulum()
    found = fb.simulate(rod, [0.3], [0.0], [0, 0.2, 1.0], stiffer)
    assert re.fullmatch(r"DOP853, LSODA from 0\.[23]\d* s", found.attrs["method"])
    implicit = fb.simulate(rod, [0.3], [0.0], [0, 0.2, 1.0], stiffer, method="Radau")
    np.testing.assert_allclose(found["q"], implicit["q"], atol=1e-9)
    with pytest.warns(
        fb.FreebodyWarning, match=r"simulate: the motion is stiff: at t = 0\."
    ) as told:
        fb.simulate(rod, [0.3], [0.0], [0, 0.4], stiffer, method="RK45", tolerance=1e-6)
    assert len(told) == 1
    assert told[0].filename == __file__
    words = r"within (\S+) s\..* as short as (\S+) s, about (\S+) in all"
    decay, step, steps = map(float, re.search(words, str(told[0].message)).groups())
    assert decay == pytest.approx(1 / 3e4, rel=0.5)  # where the gain is nearly all there
    assert 1.0 < step / decay < 5.0
    assert steps == pytest.approx(0.4 / step, rel=0.15)
