"""Motions for identification: their limits are kept, what they promise is the inverse of their
information, and random motions promise less."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.stats import chi2

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


def any_friction(qd: Any) -> np.ndarray:
    """Columns (n, nv, parameters) that add up to a torque in each joint that is any odd function of
    its rate but for its slope, piecewise linear between five rates."""
    size, sign = np.abs(qd), np.tanh(qd / 0.05)
    moving = np.where(size > 0.02, size, np.nan)
    knots = np.nanquantile(moving, [0.08, 0.2, 0.4, 0.7, 1.0], axis=0)
    of_joints = np.stack([size, *(sign * np.minimum(size, k) for k in knots)], axis=-1)
    columns = np.eye(qd.shape[1])[:, :, None] * of_joints[..., None, :]
    return columns.reshape(*columns.shape[:-2], -1)


def deviations(model: fb.Model, t: Any, q: Any, qd: Any, qdd: Any, noise: Any) -> np.ndarray:
    """Standard deviations of least squares, a second at both ends and rests left out: of friction
    by its laws, of base parameters whatever the friction."""
    used = ((t > t[0] + 1.0) & (t < t[-1] - 1.0))[:, None] & (np.abs(qd) > 0.02)
    Y, sigma = columns(model, q, qd, qdd), np.asarray(noise)[:, None]
    found = []
    for Z in (Y, np.concatenate([Y, any_friction(np.where(used, qd, 0.0))], axis=-1)):
        X = (Z / sigma)[used]
        size = np.linalg.norm(X, axis=0)
        inverse = np.linalg.pinv((X / size).T @ (X / size), rcond=1e-12, hermitian=True)
        found.append(np.sqrt(np.diag(inverse)) / size)
    by_laws, whatever = found
    base = len(told(model)[1])
    return np.concatenate([whatever[:base], by_laws[base:]])


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


def tracked(model: fb.Model, motion: fb.Motion, end: float, hold: float = 0.005) -> Any:
    """Simulation of a motion up to a time, by computed torque that is held for `hold` seconds."""
    place = CubicHermiteSpline(motion.t, motion.q, motion.qd)
    rate, acceleration = place.derivative(), CubicSpline(motion.t, motion.qdd)
    law = fb.kernel(model, "computed_torque")
    kp, kd = np.full(model.nv, 400.0), np.full(model.nv, 40.0)

    def control(t: float, q: Any, qd: Any) -> Any:
        return law(q, qd, place(t), rate(t), acceleration(t + hold / 2), kp, kd)

    return fb.simulate(
        model, motion.q[0], motion.qd[0], motion.t[motion.t <= end], control,
        sample_time=hold, tolerance=1e-6, record=("q", "qd", "tau"),
    )  # fmt: skip


def kept(run: Any, model: fb.Model, velocity: Any, torque: Any) -> bool:
    """Whether a simulation is within limits, rates and torques to half a percent, since a held
    torque lags behind."""
    q, allowed = run.q.values, model.limits
    return bool(
        (q > allowed.lower).all()
        and (q < allowed.upper).all()
        and (np.abs(run.qd.values) < 1.005 * np.asarray(velocity)).all()
        and (np.abs(run.tau.values) < 1.005 * np.asarray(torque)).all()
    )


def test_limits_are_kept_by_a_controller_that_tracks_the_motion(found: fb.Excitation) -> None:
    run = tracked(ARM, found.motion, 2.0)

    assert np.abs(run.q.values - found.motion.q[: len(run.time)]).max() < 2e-3
    assert kept(run, ARM, 2.0, [60.0, 20.0])
    used = np.abs(run.qd.values).max(axis=0)
    assert not kept(run, ARM, 0.9 * used, [60.0, 20.0])


@pytest.mark.long
@pytest.mark.parametrize("robot", ["2R", "ur5e"])
def test_limits_are_kept_all_along_the_motion(robot: str, found: fb.Excitation) -> None:
    model, motion, torque = ARM, found.motion, np.array([60.0, 20.0])
    if robot == "ur5e":
        model = fb.load("ur5e")
        torque = np.minimum(model.limits.effort, 100.0)
        motion = fb.excitation(
            model, 20.0, velocity=2.0, acceleration=6.0, noise=1.0, torque=torque
        ).motion

    run = tracked(model, motion, motion.t[-1])

    assert kept(run, model, 2.0, torque)


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


def errors(found: fb.Excitation, motion: fb.Motion, friction: dict[str, float], seeds: range):
    """Errors (logs, parameters) of what is identified from logs of a motion with noise, over the
    standard deviations that were promised."""
    truth = fb.inertial_parameters(ARM)
    tau = fb.inverse_dynamics(ARM, motion.q, motion.qd, motion.qdd)
    tau += friction["viscous"] * motion.qd + friction["coulomb"] * np.tanh(motion.qd / 0.05)
    every, made = np.ones(len(motion.t), dtype=bool), []
    for seed in seeds:
        noisy = tau + NOISE * np.random.default_rng(seed).normal(size=tau.shape)
        log = fb.Log(motion.t, motion.q, motion.qd, noisy, None, ARM.velocity_names, every)
        told = fb.identify(ARM, log, friction=tuple(friction), smooth=0.05)
        pi = [truth.get(name, 0.0) for name in told.inertial_names]
        true = dict(zip(found.names, told.combinations @ pi, strict=False))
        true |= {f"{j}.{law}": x for j in ARM.joint_names for law, x in friction.items()}
        made.append([told[name].value - true[name] for name in found.names])
    return np.array(made) / found.deviations


def hold(ratio: np.ndarray) -> bool:
    """Whether the RMS of errors, over what was promised of each parameter, is within the band of
    normal errors that one set of parameters in a hundred leaves."""
    count, parameters = ratio.shape
    low, high = chi2.ppf(np.array([0.5, -0.5]) * 0.01 / parameters % 1.0, count) / count
    squares = (ratio**2).mean(axis=0)
    return bool((squares > low).all() and (squares < high).all())


LAWS = {"viscous": 0.7, "coulomb": 1.1, "offset": 0.0}


def test_logs_of_the_motion_tell_what_it_promises(found: fb.Excitation) -> None:
    assert hold(errors(found, found.motion, LAWS, range(5)))


@pytest.mark.long
def test_a_hundred_logs_of_the_motion_tell_what_it_promises(found: fb.Excitation) -> None:
    ratio = errors(found, found.motion, LAWS, range(100))

    assert hold(ratio)
    assert not hold(0.7 * ratio)  # the law sees a third
    assert not hold(1.4 * ratio)


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
