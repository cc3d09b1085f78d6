"""Control laws and observers: what they promise of the closed loop, and the same loop in C."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

import freebody as fb
from support.generate import model as mechanism

R3 = np.zeros(3)
"""At rest, or at the origin."""


@cache
def arm() -> fb.Model:
    """A planar arm with friction and springs."""
    plain = fb.planar(
        "RRR", l=[0.5, 0.4, 0.3], lc=[0.2, 0.2, 0.1], m=[3, 2, 1], I=[0.1, 0.05, 0.01]
    )
    for joint in plain.joint_names:
        plain = plain.with_drive(joint, viscous=0.3, stiffness=2.0, rest=0.1)
    return plain


@cache
def in_space() -> tuple[fb.Model, tuple[np.ndarray, ...]]:
    """A robot with states of it, computed with by NumPy, so that nothing is compiled."""
    model = fb.load("iiwa14")
    return model, fb.random_state(model, seed=3, batch=(5,))


def numpy_kernel(model: fb.Model, name: str, **options: Any) -> Any:
    return fb.kernel(model, name, target="numpy", **options)


def pose_error(model: fb.Model, q: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """By SciPy: what the origin lacks, and the rotation vector of what is left to turn."""
    T = numpy_kernel(model, "forward_kinematics", frame=model.tip)(q)
    turn = Rotation.from_matrix(pose[..., :3, :3] @ np.swapaxes(T[..., :3, :3], -1, -2))
    return np.concatenate([pose[..., :3, 3] - T[..., :3, 3], turn.as_rotvec()], axis=-1)


# ---------------------------------------------------------------- in the space of the joints
def test_pd_with_gravity_rests_at_its_target_alone_and_loses_energy():
    model, kp, kd = arm(), np.array([60.0, 40.0, 20.0]), np.array([6.0, 4.0, 1.0])
    goal = np.array([0.4, -0.7, 1.1])
    at_goal = fb.pd_gravity(model, goal, R3, goal, kp, kd)
    np.testing.assert_allclose(at_goal, fb.static_torque(model, goal), rtol=1e-14)
    t = np.linspace(0.0, 4.0, 81)
    law = fb.kernel(model, "pd_gravity")
    run = fb.simulate(
        model, R3, R3, t, law, torque_inputs={"q_ref": goal, "kp": kp, "kd": kd}, step=2e-3
    )
    apart = goal - run.q.values
    stored = run.kinetic_energy.values + 0.5 * np.sum(kp * apart**2, axis=-1)
    assert all(b < a + 1e-9 for a, b in pairwise(stored))
    assert stored[-1] < 1e-3 * stored[0]


def test_computed_torque_makes_the_error_linear():
    model, goal, kp = arm(), np.array([0.5, -0.4, 0.3]), 25.0
    t = np.linspace(0.0, 1.0, 21)
    given = {
        "q_ref": goal,
        "qd_ref": R3,
        "qdd_ref": R3,
        "kp": np.full(3, kp),
        "kd": np.full(3, 10.0),
    }
    law = fb.kernel(model, "computed_torque")
    run = fb.simulate(model, R3, R3, t, law, torque_inputs=given)
    expected = goal * ((1.0 + 5.0 * t) * np.exp(-5.0 * t))[:, None]  # critically damped
    np.testing.assert_allclose(goal - run.q.values, expected, rtol=0.0, atol=1e-10)
    many = fb.simulate(
        model, np.zeros((4, 3)), R3, t, law, torque_inputs=given, step=1e-2, record="q"
    )
    np.testing.assert_allclose(goal - many.q.values[2], expected, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("seed", [24, 3])
def test_computed_torque_gives_the_wanted_accelerations_of_any_joints(seed):
    model = mechanism(seed)
    q, qd, qdd = fb.random_state(model, seed=1)
    q_ref = fb.integrate(model, q, 0.1 * qdd)
    tau = numpy_kernel(model, "computed_torque")(
        q, qd, q_ref, 0.5 * qd, qdd, np.full(model.nv, 3.0), np.full(model.nv, 2.0)
    )
    wanted = qdd + 3.0 * 0.1 * qdd - 2.0 * 0.5 * qd
    needed = numpy_kernel(model, "inverse_dynamics")(q, qd, wanted)
    np.testing.assert_allclose(tau, needed, rtol=1e-9, atol=1e-9)


# ---------------------------------------------------------------- in operational space
@pytest.mark.parametrize("rows", [None, ("vx", "vz", "wy")])
def test_operational_space_control_gives_the_frame_the_wanted_acceleration(rows):
    model, (q, qd, qdd) = in_space()
    rng = np.random.default_rng(0)
    chosen = [("vx", "vy", "vz", "wx", "wy", "wz").index(r) for r in rows] if rows else range(6)
    pose = numpy_kernel(model, "forward_kinematics")(q + 0.3 * qdd)
    V, A = rng.normal(size=(2, 5, len(chosen)))
    kp, kd = rng.uniform(1.0, 9.0, size=(2, len(chosen)))
    null = rng.normal(size=(5, 7))
    law = numpy_kernel(model, "operational_space_control", rows=rows)
    free = numpy_kernel(model, "forward_dynamics")(q, qd, law(q, qd, pose, V, A, kp, kd, null))
    J = numpy_kernel(model, "jacobian")(q)[..., chosen, :]
    drift = numpy_kernel(model, "acceleration")(q, qd, np.zeros(7))[..., chosen]
    found = (J @ free[..., None])[..., 0] + drift
    error = pose_error(model, q, pose)[..., chosen]
    wanted = A + kd * (V - (J @ qd[..., None])[..., 0]) + kp * error
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-7)
    still = numpy_kernel(model, "forward_dynamics")(q, qd, law(q, qd, pose, V, A, kp, kd, 0 * null))
    assert np.abs(free - still).max() > 0.1, "tau_null moves the joints"


def test_at_its_reference_a_frame_is_asked_for_nothing():
    """There the axis of the error's rotation is any."""
    model = fb.load("ur5e")
    q, still = np.array([0.3, -0.4, 0.5, 0.6, 0.7, 0.8]), np.zeros(6)
    for at in (q, np.zeros(6)):
        pose = fb.forward_kinematics(model, at)
        weight = fb.gravity_torque(model, at)
        found = fb.impedance(model, at, still, pose, still, 100.0, 10.0)
        np.testing.assert_allclose(found, weight, atol=1e-9)


def test_impedance_balances_a_wrench_by_its_stiffness():
    model, (q, qd, qdd) = in_space()
    stiffness = np.array([500.0, 400.0, 300.0, 30.0, 20.0, 10.0])
    pose = numpy_kernel(model, "forward_kinematics")(q + 0.1 * qdd)
    law = numpy_kernel(model, "impedance")
    tau = law(q, 0.0 * qd, pose, np.zeros(6), stiffness, np.ones(6))
    wrench = -stiffness * pose_error(model, q, pose)
    held = numpy_kernel(model, "static_torque", wrench_frames=[model.tip])(q, wrench)
    np.testing.assert_allclose(tau, held, rtol=1e-9, atol=1e-9)


def test_a_tip_pushed_gives_way_as_its_stiffness_says():
    model, rows, start = arm(), ("vx", "vy", "w"), np.array([0.3, 0.9, -0.5])
    pose, stiffness = fb.forward_kinematics(model, start), np.array([900.0, 600.0, 50.0])
    push = np.array([9.0, -12.0, 1.0])
    given = {"pose_ref": pose, "V_ref": R3, "stiffness": stiffness, "damping": stiffness / 5.0}
    run = fb.simulate(
        model, start, R3, [0.0, 6.0], fb.kernel(model, "impedance", rows=rows),
        wrenches=push, torque_inputs=given, tolerance=1e-8, record="q",
    )  # fmt: skip
    T = fb.forward_kinematics(model, run.q.values[-1])
    moved = [*(T - pose)[:2, 2], run.q.values[-1].sum() - start.sum()]
    np.testing.assert_allclose(moved, push / stiffness, rtol=1e-6)


def test_admittance_is_a_mass_with_damper_and_spring():
    model, (m, d, k, w) = arm(), (2.0, 3.0, 40.0, 8.0)
    given = np.array([m, m, m]), np.array([k, k, k]), np.array([d, d, d])

    def after(h: float) -> float:
        x, v = R3, R3
        for _ in range(round(1.0 / h)):
            x, v = fb.admittance(model, h, x, v, np.full(3, w), *given)
        return float(x[0])

    decay, ring = d / (2 * m), np.sqrt(k / m - (d / (2 * m)) ** 2)
    exact = w / k * (1 - np.exp(-decay) * (np.cos(ring) + decay / ring * np.sin(ring)))
    coarse, fine = after(0.02) - exact, after(0.01) - exact
    assert coarse / fine == pytest.approx(4.0, rel=0.05)  # of order 2
    x, v = R3, R3
    for _ in range(60):
        x, v = fb.admittance(model, 5.0, x, v, np.full(3, w), *given)  # however long the step
    assert np.abs(x).max() < 2.0 * w / k


# ---------------------------------------------------------------- the observer
def test_the_observer_follows_a_constant_torque_with_its_time_constant():
    model, h, ko = arm(), 1e-3, np.array([20.0, 30.0, 50.0])
    unknown = np.array([1.0, -0.5, 0.2])
    q, held = np.array([0.3, 0.4, -0.2]), 40
    tau, integral, r = fb.static_torque(model, q) - unknown, R3, R3
    for _ in range(held):  # at rest under it: nothing but the filter's own step is left
        r, integral = fb.momentum_observer(model, q, R3, tau, h, integral, ko)
    np.testing.assert_allclose(r, unknown * (1.0 - (1.0 + h * ko) ** -held), rtol=1e-11)


def test_the_observer_does_so_while_the_arm_moves():
    model, h = arm(), 1e-3
    unknown, ko = np.array([1.0, -0.5, 0.2]), np.full(3, 20.0)
    step, observe = fb.kernel(model, "rk4_step"), fb.kernel(model, "momentum_observer")
    q, qd, integral = R3, R3, R3
    for n in range(400):
        tau = np.array([30.0, 12.0, 2.0]) * np.cos(5.0 * n * h)
        q, qd = step(q, qd, tau + unknown, h)
        r, integral = observe(q, qd, tau, h, integral, ko)
        expected = unknown * (1.0 - np.exp(-ko * (n + 1) * h))
        assert np.abs(r - expected).max() < 0.02  # of order h
    assert np.abs(qd).max() > 1.0


# ---------------------------------------------------------------- what is refused
def test_gains_poses_steps_and_robots_without_drives_are_refused():
    model = fb.load("2R")
    z, pose = np.zeros(2), np.eye(3)
    with pytest.raises(fb.FreebodyError, match=r"kd is -1 for 'joint2'.*negative gain"):
        fb.pd_gravity(model, z, z, z, 5.0, [1.0, -1.0])
    with pytest.raises(fb.FreebodyError, match=r"stiffness is -2 for 'vy'"):
        fb.impedance(model, z, z, pose, z, [1.0, -2.0], 1.0, rows=("vx", "vy"))
    with pytest.raises(fb.FreebodyError, match="inertia must be above 0"):
        fb.admittance(model, 0.1, z, z, z, 0.0, 1.0, 1.0, rows=("vx", "vy"))
    with pytest.raises(fb.FreebodyError, match="h is 0, expected seconds above 0"):
        fb.momentum_observer(model, z, z, z, 0, z, 10.0)
    for wrong, words in ((2.0, "pose_ref is no pose"), (np.nan, "pose_ref is nan")):
        with pytest.raises(fb.FreebodyError, match=words):
            fb.impedance(model, z, z, wrong * pose, np.zeros(3), 1.0, 1.0)
    with pytest.raises(fb.FreebodyError, match="kp"):
        fb.pd_gravity(model, z, z, z, np.ones(3), 1.0)
    with pytest.raises(fb.PassiveJointError, match="nothing drives"):
        fb.computed_torque(fb.load("acrobot"), z, z, z, z, z, 1.0, 1.0)
    with pytest.raises(fb.FreebodyError, match="singular"):
        fb.operational_space_control(model, z, z, pose, z, z, 1.0, 1.0, rows=("vx", "vy"))


# ---------------------------------------------------------------- in C
GOAL, LOAD = np.array([0.5, -0.4, 0.3]), np.array([1.0, -0.5, 0.2])
ROWS = ("vx", "vy")
NEAR = np.array([[0.0, -1.0, 0.6], [1.0, 0.0, 0.7], [0.0, 0.0, 1.0]])
"""A pose within reach."""
THREE, TWO = np.full(3, 1.0), np.full(2, 1.0)
LAWS: dict[str, tuple[np.ndarray, ...]] = {
    "pd_gravity": (GOAL, 60.0 * THREE, 8.0 * THREE),
    "computed_torque": (GOAL, R3, R3, 400.0 * THREE, 40.0 * THREE),
    "operational_space_control": (NEAR, 0 * TWO, 0 * TWO, 90.0 * TWO, 18.0 * TWO, -0.3 * THREE),
    "impedance": (NEAR, 0 * TWO, 300.0 * TWO, 60.0 * TWO),
}
"""What each is given besides the state, always the same."""
LOOP = """
static int run_LAW(void)
{
    double q[3] = {0.1, 0.8, -0.4}, qd[3] = {0}, integral[3] = {0}, tau[3], acts[3], r[3];
    const double load[3] = {1.0, -0.5, 0.2}, ko[3] = {20, 20, 20};
CONSTANTS
    for (int k = 0; k < 500; k++) {
        if (LAW(q, qd, GIVEN, tau) != 0) return 1;
        for (int i = 0; i < 3; i++) acts[i] = tau[i] + load[i];
        rk4_step(q, qd, acts, 0.001, q, qd);
        momentum_observer(q, qd, tau, 0.001, integral, ko, r, integral);
    }
    for (int i = 0; i < 3; i++) printf("%.17g %.17g %.17g\\n", q[i], qd[i], r[i]);
    return 0;
}
"""


def options(name: str) -> dict[str, Any]:
    return {"rows": ROWS} if name in ("operational_space_control", "impedance") else {}


def loop_in_c(name: str, given: tuple[np.ndarray, ...]) -> str:
    lines = [
        f"    const double a{k}[] = {{{', '.join(map(repr, x.ravel().tolist()))}}};"
        for k, x in enumerate(given)
    ]
    names = ", ".join(f"a{k}" for k in range(len(given)))
    text = LOOP.replace("LAW", name).replace("GIVEN", names)
    return text.replace("CONSTANTS", "\n".join(lines))


def test_the_same_closed_loops_in_c(tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: the loops are written, not run")
    model, h, names = arm(), 1e-3, [*LAWS, "momentum_observer", "rk4_step"]
    for name in names:
        fb.export(model, name, tmp_path, **options(name))
    text = ["#include <stdio.h>", *(f'#include "{name}.h"' for name in names)]
    text += [loop_in_c(name, given) for name, given in LAWS.items()]
    calls = " || ".join(f"run_{name}()" for name in LAWS)
    (tmp_path / "loop.c").write_text("\n".join([*text, f"int main(void) {{ return {calls}; }}\n"]))
    command = ["cc", "-std=c99", "-Wall", "-Werror", "-O1", "loop.c", *(f"{n}.c" for n in names)]
    subprocess.run([*command, "-lm", "-o", "loop"], cwd=tmp_path, check=True, timeout=120)
    done = subprocess.run(["./loop"], cwd=tmp_path, capture_output=True, text=True, check=True)
    in_c = np.array([list(map(float, line.split())) for line in done.stdout.splitlines()])

    observe, step = fb.kernel(model, "momentum_observer"), fb.kernel(model, "rk4_step")
    for (name, given), ends in zip(LAWS.items(), in_c.reshape(len(LAWS), 3, 3), strict=True):
        law = fb.kernel(model, name, **options(name))
        q, qd, integral, r = np.array([0.1, 0.8, -0.4]), R3, R3, R3
        for _ in range(500):
            tau = law(q, qd, *given)
            q, qd = step(q, qd, tau + LOAD, h)
            r, integral = observe(q, qd, tau, h, integral, 20.0 * THREE)
        there = np.stack([q, qd, r], axis=-1)
        np.testing.assert_allclose(ends, there, rtol=0.0, atol=1e-10, err_msg=name)
        assert np.abs(r - LOAD).max() < 0.02, name


def test_a_simulation_refuses_the_gains_that_a_law_refuses_and_no_input_of_a_users_own():
    model = fb.load("2R")
    z, given = np.zeros(2), {"q_ref": np.zeros(2), "kp": np.ones(2)}
    law = fb.kernel(model, "pd_gravity")
    with pytest.raises(
        fb.FreebodyError, match=r"simulate: torque_inputs\['kd'\] is -1 for 'joint2'"
    ):
        fb.simulate(model, z, z, [0, 1], law, torque_inputs=given | {"kd": np.array([1.0, -1.0])})
    many = np.array([[1.0, 1.0], [-2.0, 1.0]])
    with pytest.raises(fb.FreebodyError, match=r"is -2 for 'joint1' at sample 1"):
        fb.simulate(model, z, z, [0, 1], law, torque_inputs=given | {"kd": many})
    own = fb.compile(lambda qd, kd: [kd * v for v in qd], {"qd": 2, "kd": ()}, {"tau": 2})
    fb.simulate(model, z, z, [0, 0.01], own, torque_inputs={"kd": -1.0})


@pytest.mark.parametrize(
    ("name", "rows"), [("3R", "vx vy w"), ("ur5e", "vx vy vz wx wy wz")], ids=["plane", "space"]
)
def test_vectors_of_the_tip_are_taken_by_the_names_of_their_rows(name: str, rows: str):
    arm, names = fb.load(name), rows.split()
    q, qd = np.full(arm.nq, 0.4), np.full(arm.nv, 0.1)
    pose, rates = fb.forward_kinematics(arm, q), 0.1 * np.arange(1.0, len(names) + 1)
    back = xr.DataArray(rates[::-1], dims="component", coords={"component": names[::-1]})
    found = (fb.impedance(arm, q, qd, pose, V, 1.0, 2.0) for V in (rates, back))
    np.testing.assert_array_equal(*found)
