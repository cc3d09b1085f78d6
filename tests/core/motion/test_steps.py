"""Step kernels of trees: orders of the methods, what is exact about them, stiff drives, printed
numbers of others."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, Model
from support import generate
from support.helpers import numbers, several
from support.robots import Joint, Link, Robot, loaded
from support.stepping import METHODS, State, apart, walk

# ---------------------------------------------------------------- orders
TREES = {
    "planar": (7, 2),
    "slides and planar joints": (3, 3),
    "spherical, mimic": (20, 3),
    "free base, mimic": (4, 3),
    "free base, springs": (14, 3),
}
"""Seeds and dimensions of random trees with friction, rotors, springs and payloads."""


@cache
def motion(seed: int, dim: int) -> tuple[State, np.ndarray, np.ndarray, State]:
    """(start, torque, load, state after 0.1 s by DOP853) of a motion in which no joint stops, where
    sign(q̇) jumps."""
    model = generate.model(seed, dim)
    q, qd, qdd = fb.random_state(model, seed)
    load = np.random.default_rng(seed).normal(size=6 if dim == 3 else 3)
    qd += np.copysign(0.5, qd)
    tau = fb.inverse_dynamics(model, q, qd, qdd, {"tool": load})
    rubs = any(joint.drive.coulomb for joint in generate.tree(seed, dim).joints)
    width = {"friction_width": 1e-5} if rubs else {}
    true = fb.simulate(model, q, qd, [0, 0.1], tau, {"tool": load}, tolerance=1e-13, **width)
    return (q, qd), tau, load, (true["q"].values[-1], true["qd"].values[-1])


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("seed", "dim"), TREES.values(), ids=list(TREES))
def test_order(seed: int, dim: int, method: str):
    model = generate.model(seed, dim)
    start, tau, load, end = motion(seed, dim)
    rough, fine = (
        apart(model, walk(model, method, start, tau, 0.1, n, load), end) for n in (16, 32)
    )
    assert np.log2(rough / fine) == pytest.approx(METHODS[method], abs=0.15)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("seed", "dim"), TREES.values(), ids=list(TREES))
def test_semi_implicit_euler_by_hand(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, tau = fb.random_state(model, seed, (7,))
    h = np.linspace(0.0, 0.03, 7)
    q1, qd1 = fb.kernel(model, "semi_implicit_step")(q, qd, tau, h)
    rates = qd + h[:, None] * fb.forward_dynamics(model, q, qd, tau)
    np.testing.assert_allclose(qd1, rates, rtol=0, atol=1e-13 * np.abs(rates).max())
    np.testing.assert_allclose(
        q1, fb.integrate(model, q, h[:, None] * rates), rtol=1e-13, atol=1e-14
    )


@pytest.mark.sample(5)
@pytest.mark.parametrize("seed", range(30))
def test_a_short_step_is_the_acceleration(seed: int):
    """Of every kind of joint, coordinates that move several among them; by the formulas on plain
    numbers."""
    model = generate.model(seed)
    q, qd, tau = fb.random_state(model, seed, (2,))
    qd, h = qd + np.copysign(0.5, qd), 1e-7  # all slide
    expected = numbers(model, "forward_dynamics", q, qd, tau)
    for method in METHODS:
        _, qd1 = several(model, method, q, qd, tau, np.full(2, h))
        np.testing.assert_allclose(
            (qd1 - qd) / h, expected, rtol=0, atol=2e-5 * np.abs(expected).max() + 1e-7
        )


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", [*METHODS, "implicit_feedback_step"])
def test_a_kernel_is_the_formula(method: str):
    model = generate.model(14)
    q, qd, tau = fb.random_state(model, 1, (5,))
    q_ref, qd_ref, gains = fb.random_state(model, 2, (5,))
    given = [q, qd, tau, np.linspace(0.001, 0.01, 5)]
    if "feedback" in method:
        given += [q_ref, qd_ref, np.abs(gains), 0.1 * np.abs(gains)]
    for found, expected in zip(
        fb.kernel(model, method)(*given), several(model, method, *given), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_inputs_in_order():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    step = fb.kernel(model, "implicit_feedback_step", wrench_frames=["tip"])
    names = [argument.name for argument in step.program.inputs]
    assert names == ["q", "qd", "tau", "h", "q_ref", "qd_ref", "kp", "kd", "wrench0"]
    assert [argument.name for argument in step.program.outputs] == ["q1", "qd1"]
    with pytest.raises(FreebodyError, match=r"h has the shape|h \(3,\)"):
        fb.kernel(model, "rk4_step")(np.zeros((2, 2)), np.zeros(2), np.zeros(2), np.zeros(3))


def test_other_samples_are_left_alone_by_nan():
    model = generate.model(4)
    q, qd, tau = fb.random_state(model, 0, (9,))
    whole = fb.kernel(model, "rk4_step")(q, qd, tau, 0.01)
    tau[4, 0] = np.nan
    spoilt = fb.kernel(model, "rk4_step")(q, qd, tau, 0.01)
    for one, other in zip(whole, spoilt, strict=True):
        assert np.isnan(other[4]).all()
        np.testing.assert_array_equal(np.delete(one, 4, axis=0), np.delete(other, 4, axis=0))


def test_a_step_takes_fewer_operations_than_the_acceleration_of_the_links_as_they_are():
    """By an eighth and more for arms whose joints stand at right angles; so does the acceleration's
    own kernel."""
    model = fb.load("ur5e").without("friction")
    acceleration = fb.formula(model, "forward_dynamics")
    plain = fb.compile(
        lambda q, qd, tau: acceleration(q, qd, tau), {"q": 6, "qd": 6, "tau": 6}, target="numpy"
    ).program
    for name in ("semi_implicit_step", "forward_dynamics"):
        found = fb.kernel(model, name).program.operations
        assert sum(found.values()) < 0.875 * sum(plain.operations.values())


# ---------------------------------------------------------------- what stays
def test_backward_in_time():
    """Of order 4 there and back: what is left falls with the fifth power of the step (the error's
    symmetric part)."""
    model = generate.model(5).without("friction")
    q, qd, tau = fb.random_state(model, 5)
    left = []
    for steps in (8, 16):
        there = walk(model, "rk4_step", (q, qd), tau, 0.2, steps)
        left.append(apart(model, walk(model, "rk4_step", there, tau, -0.2, steps), (q, qd)))
    assert np.log2(left[0] / left[1]) == pytest.approx(5, abs=0.4)


def test_energy_of_a_chain():
    model = fb.load("3R").without("friction")
    state = np.array([0.3, 0.2, -0.4]), np.zeros(3)
    lost = []
    for steps in (1000, 2000):
        q, qd = walk(model, "rk4_step", state, np.zeros(3), 1.0, steps)
        before, after = (
            fb.kinetic_energy(model, *s) + fb.potential_energy(model, s[0])
            for s in (state, (q, qd))
        )
        lost.append(abs(after - before))
    assert lost[1] < 1e-9 * fb.kinetic_energy(model, q, qd)
    assert lost[0] / lost[1] > 10


def test_a_free_body_keeps_its_momentum():
    model = one_body("free", 2.0, (0.1, -0.2, 0.05), (0.1, 0.2, 0.25), 0.0)
    state = np.array([0, 0, 0, 1.0, 0, 0, 0]), np.array([0.3, -0.2, 0.5, 2.0, -3.0, 1.0])
    before = fb.momentum(model, *state)
    after = fb.momentum(model, *walk(model, "rk4_step", state, np.zeros(6), 2.0, 400))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-8)


# ---------------------------------------------------------------- printed by others
def one_body(kind: str, mass: float, com: tuple, moments: tuple, g: float) -> Model:
    xx, yy, zz = moments
    link = Link("body", fb.Inertia(mass, com, (xx, 0.0, 0.0, yy, 0.0, zz)))
    joint = Joint("joint", kind, "world", "body")
    return loaded(Robot(kind, 3, (Link("world"), link), (joint,), g))


def test_heavy_top():
    # Exudyn, heavyTop.py
    top = one_body("spherical", 15.0, (0, 1.0, 0), (0.234375, 0.46875, 0.234375), 9.81)
    start = np.array([1.0, 0, 0, 0]), np.array([0, 150, -4.61538])
    q, qd = walk(top, "rk4_step", start, np.zeros(3), 0.2, 40_000)
    printed = np.array([-0.708279152975, 0.438781088126, 0.545728396145, 0.089399752823])
    np.testing.assert_allclose(q * np.sign(q @ printed), printed, rtol=0, atol=2e-11)
    np.testing.assert_allclose(qd, [-2.691590912, 150, 4.917260990], rtol=0, atol=1e-9)


@pytest.mark.parametrize(("kind", "still"), [("free", [0.0, 0.0, 0.0]), ("spherical", [])])
def test_a_free_axisymmetric_body(kind: str, still: list[float]):
    # Drake, multibody/benchmarks/free_body
    model = one_body(kind, 1.0, (0, 0, 0), (0.04, 0.04, 0.02), 0.0)
    start = np.array([*still, 1.0, 0, 0, 0]), np.array([*still, 2.0, 4, 6])
    q, qd = walk(model, "rk4_step", start, np.zeros(model.nv), 1.0, 4000)
    np.testing.assert_allclose(
        qd[-3:], [-1.4155049609614219, -4.242210002521516, 6], rtol=0, atol=1e-12
    )
    assert np.linalg.norm(q[-4:]) == pytest.approx(1.0, abs=1e-15)


def test_pendulum_of_the_iftomm_library():
    model = fb.planar("R", l=[1.0], lc=[1.0], m=[1.0], I=[0.0])
    q, _ = walk(model, "rk4_step", (np.array([np.pi]), np.zeros(1)), np.zeros(1), 10.0, 10_000)
    np.testing.assert_allclose(
        [*np.cos(q), *np.sin(q)], [-0.27508746258, -0.96141920510], rtol=0, atol=5e-11
    )


# ---------------------------------------------------------------- stiff drives
def slide(**drive: float) -> Model:
    """A mass of 2 kg on a level rail."""
    links = (Link("world"), Link("cart", fb.Inertia.point(2.0, (0.0, 0.0, 0.0))))
    joint = Joint(
        "rail", "prismatic", "world", "cart", axis=(1.0, 0.0, 0.0), drive=fb.Drive(**drive)
    )
    return loaded(Robot("cart", 3, links, (joint,), 9.81))


@pytest.mark.parametrize("damping", [0.0, 3.0, 1e3, 1e9])
def test_viscous_friction_is_the_rational_function(damping: float):
    """q̇₁/q̇ is 2/(1 - z/2)² - 1/(1 - z) at z = -h d/m: of order 2, and 0 for stiff friction."""
    h, v = 0.1, 1.3
    q1, qd1 = fb.kernel(slide(viscous=damping), "implicit_step")(
        np.zeros(1), np.array([v]), np.zeros(1), h
    )
    z = -h * damping / 2.0
    first = v / (1 - z / 2)
    second = first / (1 - z / 2)
    np.testing.assert_allclose(qd1, 2 * second - v / (1 - z), rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(
        q1, 2 * (h / 2) * (first + second) - h * v / (1 - z), rtol=1e-13, atol=1e-16
    )


@pytest.mark.parametrize("stiffness", [1e3, 1e6, 1e10])
def test_springs_are_never_unstable(stiffness: float):
    model = slide(stiffness=stiffness)
    q, qd = np.array([0.2]), np.array([0.0])
    energy, step = fb.potential_energy(model, q), fb.kernel(model, "implicit_step")
    for _ in range(400):
        q, qd = step(q, qd, np.zeros(1), 0.2)
        now = fb.potential_energy(model, q) + fb.kinetic_energy(model, q, qd)
        assert now <= energy * (1 + 1e-12)
        energy = now
    assert now < 1e-6 * fb.potential_energy(model, [0.2])


def test_coulomb_friction_stops_and_holds():
    """From 1 m/s against c/m = 5 m/s² it stops after 0.2 s and 0.1 m, and then creeps at what the
    push asks for."""
    model, h = slide(coulomb=10.0), 0.004
    step = fb.kernel(model, "implicit_step")
    q, qd = np.zeros(1), np.ones(1)
    rates = []
    for _ in range(100):
        q, qd = step(q, qd, np.zeros(1), h)
        rates.append(qd[0])
    assert q[0] == pytest.approx(0.1, rel=2e-3)
    falling = 1.0 - 5.0 * h * np.arange(1, 101)
    np.testing.assert_allclose(rates[:40], falling[:40], rtol=0, atol=2e-3)
    assert np.abs(rates[50:]).max() < 1e-3  # no chatter: explicit methods leave h c/m = 0.02
    for _ in range(200):
        q, qd = step(q, qd, np.array([6.0]), h)
    # c v / sqrt(v² + width²) = 6 N at v = width · 0.6/0.8
    assert qd[0] == pytest.approx(0.75e-3, rel=1e-6)


@pytest.mark.parametrize("kp", [1e4, 1e8, 1e12])
def test_stiff_feedback_reaches_its_reference(kp: float):
    model = fb.load("ur5e")
    rng = np.random.default_rng(0)
    q, qd, q_ref = rng.uniform(-1, 1, (3, 6))
    kd, still = 0.4 * kp**0.5 + 1e-4 * kp, np.zeros(6)
    step = fb.kernel(model, "implicit_feedback_step")
    for _ in range(1000):
        q, qd = step(q, qd, still, 0.01, q_ref, still, np.full(6, kp), np.full(6, kd))
    sag = -fb.gravity_torque(model, q) / kp  # what the feedback has to hold
    np.testing.assert_allclose(q - q_ref, sag, rtol=1e-6, atol=1e-6 * np.abs(sag).max())
    np.testing.assert_allclose(qd, 0.0, atol=1e-12)


def test_feedback_is_of_order_2_about_a_moving_reference():
    """Of free, spherical and plain joints, against the torque of the feedback put into many small
    explicit steps."""
    model = generate.model(5).without("friction")
    q, qd, tau = fb.random_state(model, 5)
    n = model.nv
    q_ref, qd_ref = fb.integrate(model, q, 0.1 * np.cos(np.arange(n))), 0.3 * np.sin(np.arange(n))
    kp, kd, time = np.linspace(2, 5, n), np.linspace(0.1, 0.3, n), 0.2

    def torque(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        aim = fb.integrate(model, q_ref, t * qd_ref)
        return tau - kp * fb.difference(model, aim, q) - kd * (qd - qd_ref)

    true = fb.simulate(model, q, qd, [0, time], torque, tolerance=1e-12)
    end = true["q"].values[-1], true["qd"].values[-1]
    step, errors = fb.kernel(model, "implicit_feedback_step"), []
    for steps in (16, 32):
        state, h = (q, qd), time / steps
        for k in range(steps):
            aim = fb.integrate(model, q_ref, k * h * qd_ref)
            state = step(*state, tau, h, aim, qd_ref, kp, kd)
        errors.append(apart(model, state, end))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.15)


def test_feedback_follows_a_moving_reference_without_lag():
    model, h = slide(viscous=0.0), 0.05
    step = fb.kernel(model, "implicit_feedback_step")
    q, qd, q_ref, speed = np.zeros(1), np.zeros(1), np.array([0.3]), np.array([0.7])
    for _ in range(400):
        q, qd = step(q, qd, np.zeros(1), h, q_ref, speed, np.array([50.0]), np.array([20.0]))
        q_ref = q_ref + h * speed
    np.testing.assert_allclose(q - q_ref, 0.0, atol=1e-12)
    np.testing.assert_allclose(qd, speed, rtol=1e-12)


def test_no_joints(tmp_path):
    path = tmp_path / "block.toml"
    path.write_text(
        'name = "block"\n[[link]]\nname = "block"\nmass = 2\ninertia = [0.1, 0, 0, 0.1, 0, 0.1]\n'
    )
    still = np.zeros((3, 0))
    for method in METHODS:
        q1, qd1 = fb.kernel(fb.load(path), method)(still, still, still, 0.1)
        assert q1.shape == qd1.shape == (3, 0)
