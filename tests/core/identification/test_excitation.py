"""Motions for identification: their limits are kept, what they promise is the inverse of their
information, and random motions promise less."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import freebody as fb

ARM = fb.load("2R").replace(name="arm")
LIMITS: dict[str, Any] = {"velocity": 2.0, "acceleration": [5.0, 8.0]}
NOISE = np.array([0.5, 0.2])


@pytest.fixture(scope="module")
def found() -> fb.Excitation:
    return fb.excitation(ARM, 10.0, torque=[60.0, 20.0], noise=NOISE, **LIMITS)


@cache
def told(model: fb.Model) -> tuple[fb.Model, list[int], list[str]]:
    """The model with rotors alone, and the places and names of its base parameters among all."""
    bare = model.without("friction", "rotors", "springs")
    for joint in model.joint_names:
        bare = bare.with_drive(joint, rotor=1.0, gear=1.0)
    base = fb.base_parameters(bare)
    inertial = (
        *(f"{body.name}." for body in bare.bodies),
        *(f"{j}.rotor" for j in bare.joint_names),
    )
    kept = [k for k, x in enumerate(base.names) if x.startswith(inertial)]
    return bare, [base.columns[k] for k in kept], [base.names[k] for k in kept]


def columns(model: fb.Model, q: Any, qd: Any, qdd: Any) -> np.ndarray:
    """Columns (n, nv, parameters) of base parameters and of viscous, dry and constant friction of
    each joint, from the regressor of all parameters."""
    bare, places, _ = told(model)
    Y = fb.regressor(bare, q, qd, qdd)[..., places]
    of_laws = np.stack([qd, np.tanh(qd / 0.05), np.ones_like(qd)], axis=-1)
    of_joints = np.eye(model.nv)[:, :, None] * of_laws[..., None, :]
    return np.concatenate([Y, of_joints.reshape(*of_joints.shape[:-2], -1)], axis=-1)


def deviations(model: fb.Model, t: Any, q: Any, qd: Any, qdd: Any, noise: Any) -> np.ndarray:
    """Standard deviations of least squares, a second at both ends and rests left out."""
    settled = (t > t[0] + 1.0) & (t < t[-1] - 1.0)
    Y = columns(model, q, qd, qdd)
    X = (Y / np.asarray(noise)[:, None])[settled[:, None] & (np.abs(qd) > 0.02)]
    size = np.linalg.norm(X, axis=0)
    return np.sqrt(np.diag(np.linalg.inv((X / size).T @ (X / size)))) / size


def test_limits_are_kept(found: fb.Excitation) -> None:
    motion = found.motion
    tau = fb.inverse_dynamics(ARM, motion.q, motion.qd, motion.qdd)

    assert fb.exceeded_limits(ARM, motion, **LIMITS) == ()
    assert (np.abs(tau) <= [60.0, 20.0]).all()
    used = np.abs(motion.qd).max(axis=0) / 2.0, np.abs(motion.qdd).max(axis=0) / [5.0, 8.0]
    assert np.maximum(*used).max() > 0.9  # none is left unused
    assert motion.t[-1] == 10.0
    assert not motion.qd[[0, -1]].any()
    assert np.abs(motion.qdd[[0, -1]]).max() < 1e-9


def test_rates_and_accelerations_are_those_of_the_positions(found: fb.Excitation) -> None:
    motion = found.motion

    for x, slope in ((motion.q, motion.qd), (motion.qd, motion.qdd)):
        assert np.abs(np.gradient(x, motion.t, axis=0) - slope)[5:-5].max() < 2e-2


def test_what_is_promised_is_the_inverse_of_the_information(found: fb.Excitation) -> None:
    motion = found.motion
    laws = [f"{j}.{x}" for j in ARM.joint_names for x in ("viscous", "coulomb", "offset")]

    expected = deviations(ARM, motion.t, motion.q, motion.qd, motion.qdd, NOISE)

    assert list(found.names) == [*told(ARM)[2], *laws]
    assert np.abs(found.deviations / expected - 1.0).max() < 1e-6
    name, size = found.worst
    assert size == pytest.approx(max(expected[: found.base]))
    assert found.deviation(name) == size
    assert name in repr(found)


def test_logs_of_the_motion_tell_what_it_promises(found: fb.Excitation) -> None:
    """Errors of regressions of simulated logs are as large as the standard deviations promised."""
    motion, rng = found.motion, np.random.default_rng(4)
    tau = fb.inverse_dynamics(ARM, motion.q, motion.qd, motion.qdd)
    tau += 0.7 * motion.qd + 1.1 * np.tanh(motion.qd / 0.05)
    every = np.ones(len(motion.t), dtype=bool)
    values = []
    for _ in range(25):
        noisy = tau + NOISE * rng.normal(size=tau.shape)
        log = fb.Log(motion.t, motion.q, motion.qd, noisy, None, ARM.velocity_names, every)
        told = fb.identify(ARM, log, friction=("viscous", "coulomb", "offset"), smooth=0.05)
        values.append([told[name].value for name in found.names])

    ratio = np.std(values, axis=0, ddof=1) / found.deviations

    assert 0.85 < np.sqrt((ratio**2).mean()) < 1.2
    assert 0.6 < ratio.min() < ratio.max() < 1.5


def random_worst(
    model: fb.Model, excited: fb.Excitation, acceleration: Any, count: int, harmonics: int
) -> list[float]:
    """The largest standard deviations of base parameters of random Fourier motions of the same
    length, each as large as limits of speed and acceleration allow; that of torque is left out."""
    rng, t = np.random.default_rng(1), excited.motion.t
    w = 2.0 * np.pi / t[-1] * np.arange(1, harmonics + 1)
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    worst = []
    for _ in range(count):
        a, b = rng.normal(size=(2, harmonics, model.nv))
        q, qd, qdd = s / w @ a - c / w @ b, c @ a + s @ b, c * w @ b - s * w @ a
        scale = np.minimum(2.0 / np.abs(qd).max(axis=0), acceleration / np.abs(qdd).max(axis=0))
        q = q * scale + rng.uniform(-np.pi, np.pi, model.nv)
        sizes = deviations(model, t, q, qd * scale, qdd * scale, excited.noise)
        worst.append(sizes[: excited.base].max())
    return worst


def test_random_motions_promise_less(found: fb.Excitation) -> None:
    worst = random_worst(ARM, found, LIMITS["acceleration"], 40, 5)

    assert found.worst[1] < 0.5 * np.median(worst)
    assert found.worst[1] < min(worst)


@pytest.mark.long
def test_random_motions_of_six_joints_promise_half_as_much() -> None:
    arm = fb.load("ur5e")
    found = fb.excitation(arm, 20.0, velocity=2.0, acceleration=6.0, noise=1.0)

    assert fb.exceeded_limits(arm, found.motion, 2.0, 6.0) == ()
    assert found.base == 40
    for harmonics in (5, 10):
        assert found.worst[1] < 0.5 * np.median(random_worst(arm, found, 6.0, 200, harmonics))


def test_slow_motions_tell_gravity_and_friction() -> None:
    found = fb.excitation(ARM, 20.0, quasi_static=True, box=[[0.0, -0.6], [np.inf, 0.6]])
    motion = found.motion

    assert found.names[:4] == ("link1.hx", "link1.hy", "link2.hx", "link2.hy")
    assert found.base == 4
    assert np.abs(motion.qd).max() <= 0.2
    assert np.abs(motion.qdd).max() <= 0.2
    tip = fb.forward_kinematics(ARM, motion.q)[:, :2, 2]
    assert tip[:, 0].min() >= 0.0
    assert np.abs(tip[:, 1]).max() <= 0.6
    assert any("1% of the effort limit" in x for x in found.notices)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "too short": ({"duration": 2.0}, "duration is 2 s, expected more than 3 s: 1 s at both ends"),
    "one harmonic": ({"harmonics": 1}, "harmonics is 1, expected 2 or more"),
    "a flat box": ({"box": [0.0, 1.0]}, "box has shape (2,), expected (2, 2): its lowest and high"),
    "a box upside down": ({"box": [[0, 1], [1, 0]]}, "the box has no room"),
    "a box out of reach": ({"box": [[9, 9], [10, 10]]}, "none is within the limits at rest and in"),
    "frames without a box": ({"frames": ["link2"]}, "frames are given without a box"),
    "a frame that is none": ({"box": [[0, 0], [1, 1]], "frames": ["x"]}, "no frame 'x' in 'arm'"),
    "friction by load": ({"friction": ["load"]}, "load-dependent friction has no columns of its"),
    "no noise": ({"noise": 0.0}, "noise is 0.0, expected a number above 0"),
    "weak drives": ({"torque": 1e-3}, "look at the effort limits"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused(case: str) -> None:
    given, problem = REFUSED[case]

    with pytest.raises(fb.FreebodyError) as refused:
        fb.excitation(ARM, **{"duration": 10.0, **given})

    assert problem in str(refused.value)


def test_closed_chains_and_passive_joints_are_refused() -> None:
    with pytest.raises(fb.FreebodyError, match=r"^excitation: joint .* is passive"):
        fb.excitation(fb.load("pendubot"), 10.0)
    with pytest.raises(fb.FreebodyError):
        fb.excitation(fb.load("four_bar"), 10.0)
    with pytest.raises(fb.KindError):
        fb.excitation("2R", 10.0)  # type: ignore[arg-type]
