"""Measured motions: noise is recognised, said, and filtered without delay; rest is rest."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, Motion, read_motion
from freebody.motion.files.measured_motions import noise, recognised, smooth
from freebody.report.studied_motion import filtered, with_peaks
from support.command import error, run

ARM = fb.planar(
    "RR",
    l=[0.5, 0.4],
    lc=[0.25, 0.2],
    m=[8.0, 4.0],
    I=[0.2, 0.06],
    limits=[fb.Limits(-3, 3, 3.0, 150.0), fb.Limits(-3, 3, 3.0, 50.0)],
)
SIGMA, RATE = 5e-5, 1.5e-3  # of an industrial robot's log at 100 Hz


def truth(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    w = 2 * np.pi * np.array([0.4, 0.7])
    a, p = np.array([0.8, 0.5]), np.array([0.3, 1.1])
    return (
        a * np.sin(w * t[:, None] + p),
        a * w * np.cos(w * t[:, None] + p),
        -a * w**2 * np.sin(w * t[:, None] + p),
    )


def log(path: Path, rates: bool = False, sigma: float = SIGMA, seconds: float = 12.0) -> Path:
    """A log at about 100 Hz with jitter; positions with noise, perhaps rates with theirs."""
    rng = np.random.default_rng(5)
    t = np.cumsum(rng.uniform(0.008, 0.012, int(100 * seconds)))
    q, qd, _ = truth(t)
    columns = [t[:, None], q + sigma * rng.normal(size=q.shape)]
    header = "t,joint1,joint2"
    if rates:
        columns.append(qd + RATE * rng.normal(size=q.shape))
        header += ",joint1.v,joint2.v"
    np.savetxt(path, np.hstack(columns), delimiter=",", header=header, comments="", fmt="%.9g")
    return path


def exact(motion: Motion) -> np.ndarray:
    return fb.inverse_dynamics(ARM, *truth(motion.t))


# ---------------------------------------------------------------- the estimator and the filter
@pytest.mark.parametrize("sigma", [1e-6, 1e-4, 3e-3])
def test_the_size_of_white_noise_is_found(sigma: float):
    rng = np.random.default_rng(0)
    t = np.cumsum(rng.uniform(0.008, 0.012, 2000))
    found = noise(t, truth(t)[0] + sigma * rng.normal(size=(2000, 2)))
    np.testing.assert_allclose(found, sigma, rtol=0.15)


def test_smooth_sampled_or_coarse_curves_have_no_noise():
    t = np.linspace(0, 5, 401)
    for name in ("2R", "ur5e", "scara"):
        assert not noise(t, fb.default_motion(fb.load(name)).q).any()
    ramps = np.cumsum(np.where(t < 1, 2.0, np.where((t > 2) & (t < 3), -2.0, 0.0))) / 80.0
    assert (
        not noise(t, np.cumsum(ramps)[:, None] / 80.0).any()
        or noise(t, ramps[:, None]).max() < 1e-12
    )
    assert not noise(
        np.arange(40) * 0.5, np.random.default_rng(1).normal(size=(40, 2))
    ).any()  # waypoints
    assert not noise(t[:20], t[:20, None]).any()
    assert not noise(t, 0.7 * t[:, None]).any()  # nothing but rounding


@pytest.mark.parametrize("ratio", [0.25, 1.0, 2.0])
def test_the_filter_passes_what_it_says_without_delay(ratio: float):
    rng = np.random.default_rng(2)
    t = np.sort(rng.uniform(0, 40, 6000))
    t[0], t[-1] = 0.0, 40.0
    wave = np.stack([np.cos(2 * np.pi * 3 * ratio * t), np.sin(2 * np.pi * 3 * ratio * t)], axis=-1)
    passed = smooth(t, wave, 3.0)(np.linspace(10, 30, 4001))
    s = 2 * np.pi * 3 * ratio * np.linspace(10, 30, 4001)
    gain, delay = 2 * (passed[:, 0] * np.cos(s)).mean(), 2 * (passed[:, 0] * np.sin(s)).mean()
    assert gain == pytest.approx(1 / (1 + ratio**6), abs=0.02)
    assert abs(delay) < 0.02
    parabola = np.stack([t**2, 1.0 + t], axis=-1)
    np.testing.assert_allclose(smooth(t, parabola, 0.5)(t), parabola, atol=1e-6)


# ---------------------------------------------------------------- torques
def test_noise_differentiated_twice_is_said_and_filtered(tmp_path: Path):
    motion = read_motion(ARM, log(tmp_path / "log.csv"))
    found, true = recognised(ARM, motion), exact(motion)
    assert found is not None
    assert found.of == "positions"
    assert found.sigma == pytest.approx(SIGMA, rel=0.15)
    assert 1.0 < found.cutoff < 10.0
    size = np.abs(true).max(axis=0)
    raw = fb.inverse_dynamics(ARM, motion.q, motion.qd, motion.qdd)
    clean = fb.smoothed(ARM, motion)
    found_torque = fb.inverse_dynamics(ARM, clean.q, clean.qd, clean.qdd)
    inside = slice(20, -20)
    assert (np.abs(raw - true)[inside].max(axis=0) > 0.1 * size).all()
    assert (np.abs(found_torque - true)[inside].max(axis=0) < 0.02 * size).all()
    assert (np.abs(found_torque - true).max(axis=0) < 0.1 * size).all()  # the ends


def test_a_study_gives_the_torque_with_and_without(tmp_path: Path):
    motion = read_motion(ARM, log(tmp_path / "log.csv", sigma=3e-4, seconds=4.0))
    true = np.abs(exact(motion)).max(axis=0)
    same, (said,) = filtered(ARM, motion, False)
    assert same is motion
    assert re.search(r"positions carry noise \(about \S+ rad\), ", said)
    assert "smoothed at" in said
    clean, (told,) = filtered(ARM, motion, True)
    assert "as it was measured" in told
    spoilt, peak = (  # between samples too, where the verdict finds them
        np.abs(fb.inverse_dynamics(ARM, m.q, m.qd, m.qdd)).max(axis=0)
        for m in (with_peaks(ARM, motion), with_peaks(ARM, clean))
    )
    assert (spoilt > 1.2 * true).all()
    np.testing.assert_allclose(peak, true, rtol=0.05)
    for value in (f"{peak[0]:.3g} N m, {peak[0] / 1.5:.0f} % of its limit", f"{spoilt[0]:.3g} N m"):
        assert value in said
        assert value in told
    found = fb.study(ARM, tmp_path / "log.csv", smooth=4.0)
    assert found.motion.source.endswith("smoothed: 4 Hz, without delay")
    assert "as it was measured" in found.warnings[0]
    assert found.checked


def test_noise_that_counts_as_torque_is_told_wherever_torques_decide(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    path = log(tmp_path / "log.csv", sigma=1e-4, seconds=4.0)
    motion = read_motion(ARM, path)
    clean = fb.smoothed(ARM, motion)
    loud = fb.payload(ARM, read_motion(ARM, log(tmp_path / "loud.csv", sigma=1e-3, seconds=4.0)))
    assert loud.card.startswith("carries nothing on this path · ")
    assert loud.card.endswith(" · the noise of the motion counts")
    found, right = fb.payload(ARM, motion), fb.payload(ARM, clean)
    assert found.mass < 0.9 * right.mass
    said = "It counts as torque here; --smooth auto (fb.smoothed) takes it out"
    assert said in found.noise
    assert found.card.endswith(" · the noise of the motion counts")
    both = right.card[: right.card.rindex(" · ")]  # how much faster without it is not compared
    assert found.noise.endswith(f"Then: {both}.")
    assert right.noise == ""
    assert said in fb.payload(ARM, [clean, motion]).noise
    for noisy, known in ((motion, True), (clean, False)):
        cycle = fb.DutyCycle([fb.Segment(noisy)])
        assert (said in " ".join(fb.floor_loads(ARM, cycle).notices)) is known
    fb.save(ARM, tmp_path / "arm.toml")
    command = ["payload", str(tmp_path / "arm.toml"), "--motion", str(path)]
    assert run([*command, "--smooth", "auto"]) == 0
    told = capsys.readouterr()
    assert right.card in told.out
    assert said not in told.err
    assert run(command) == 0
    assert said in " ".join(capsys.readouterr().err.split())
    assert "there is no motion to smooth" in error(capsys, "payload", "2R", "--smooth", "8")


def test_an_honest_log_with_rates_is_followed_to_its_end(tmp_path: Path):
    motion = read_motion(ARM, log(tmp_path / "log.csv", rates=True, seconds=4.0))
    assert "adjusted to the given rates" in motion.notices[0]
    q, qd, _ = truth(motion.t)
    assert np.abs(motion.q - q).max() < 5 * SIGMA
    assert np.abs(motion.qd - qd).max() < 5 * RATE
    found = fb.study(ARM, motion)
    assert found.checked, [check for check in found.checks if not check.passed]


def test_exact_rates_are_left_as_they_are(tmp_path: Path):
    t = np.linspace(0, 4, 401)
    rows = np.hstack([t[:, None], *truth(t)[:2]])
    np.savetxt(
        tmp_path / "m.csv",
        rows,
        delimiter=",",
        header="t,joint1,joint2,joint1.v,joint2.v",
        comments="",
    )
    motion = read_motion(ARM, tmp_path / "m.csv")
    np.testing.assert_array_equal(motion.q, truth(t)[0])
    np.testing.assert_array_equal(motion.qd, truth(t)[1])
    assert recognised(ARM, motion) is None
    assert motion.notices == ()


def test_what_cannot_be_smoothed_is_refused():
    motion = fb.default_motion(ARM)
    with pytest.raises(FreebodyError, match=r"no noise was found .* give one \(Hz\)"):
        fb.study(ARM, motion, smooth=True)
    for cutoff in (0.0, 50.0, float("nan")):
        with pytest.raises(
            FreebodyError, match=r"expected more than 0 and less than half the sampling rate, 40 Hz"
        ):
            fb.smoothed(ARM, motion, cutoff)


def test_the_positions_of_a_closed_chains_drives_are_smoothed(tmp_path: Path):
    model = fb.load("four_bar")
    start = fb.assemble(model)[0]
    rng = np.random.default_rng(3)
    t = np.linspace(0, 3, 301)
    crank = start + 0.3 * np.sin(2 * np.pi * 0.5 * t)
    noisy = crank + 1e-4 * rng.normal(size=301)
    name = model.driven_names[0]
    np.savetxt(
        tmp_path / "m.csv", np.stack([t, noisy], -1), delimiter=",", header=f"t,{name}", comments=""
    )
    clean = fb.smoothed(model, read_motion(model, tmp_path / "m.csv"))
    assert np.abs(clean.qdd[20:-20, 0] + 0.3 * np.pi**2 * np.sin(np.pi * t[20:-20])).max() < 0.15
    np.testing.assert_allclose(fb.assemble(model, clean.q[150]), clean.q[150], atol=1e-10)


# ---------------------------------------------------------------- rest
def test_a_joint_at_rest_feels_no_coulomb_friction(tmp_path: Path):
    model = fb.planar(
        "RR",
        l=[1, 1],
        lc=[0.5, 0.5],
        m=[1, 1],
        I=[0.1, 0.1],
        g=0,
        drives=[fb.Drive(coulomb=7.0)] * 2,
    )
    t = np.linspace(0, 2, 41)
    rows = np.stack([t, np.sin(t), np.full(41, 0.1) + 1e-15 * np.sin(9 * t)], axis=-1)
    np.savetxt(
        tmp_path / "m.csv", rows, delimiter=",", header="t,joint1,joint2", comments="", fmt="%.17g"
    )
    motion = read_motion(model, tmp_path / "m.csv")
    assert not motion.qd[:, 1].any()
    state = motion.q, motion.qd, motion.qdd
    friction = fb.inverse_dynamics(model, *state) - fb.inverse_dynamics(
        model.without("friction"), *state
    )
    np.testing.assert_allclose(
        friction, np.stack([7.0 * np.sign(np.cos(t)), 0 * t], axis=-1), atol=1e-12
    )
    # the functions themselves keep the sign
    assert fb.bias(model, [0, 0], [0, 1e-14])[1] == pytest.approx(7.0)


# ---------------------------------------------------------------- logs of robots that stand,
# vibrate, follow ramps
def steps(seconds: float = 4.0) -> np.ndarray:
    return np.arange(0.0, seconds, 0.01)


def as_motion(tmp_path: Path, t: np.ndarray, q: np.ndarray, fmt: str = "%.17g") -> Motion:
    file = tmp_path / "log.csv"
    np.savetxt(
        file, np.column_stack([t, q]), delimiter=",", header="t,joint1,joint2", comments="", fmt=fmt
    )
    return read_motion(ARM, file)


def test_a_robot_that_stands_still_is_at_rest(tmp_path: Path):
    t = steps()
    motion = as_motion(tmp_path, t, np.tile([0.3, 1.1], (len(t), 1)))
    assert not motion.qd.any()
    assert not motion.qdd.any()
    found = fb.study(ARM, motion)
    assert found.passed, found.verdict
    assert "times as fast" not in str(found.verdict)


def test_noise_of_a_robot_that_stands_still_is_said(tmp_path: Path):
    t, pose = steps(), np.array([0.3, 1.1])
    q = pose + 1e-4 * np.random.default_rng(1).normal(size=(len(t), 2))
    motion = as_motion(tmp_path, t, q)
    found = recognised(ARM, motion)
    assert found is not None
    assert found.sigma == pytest.approx(1e-4, rel=0.2)
    hold = fb.static_torque(ARM, pose)
    clean = fb.smoothed(ARM, motion)
    tau = fb.inverse_dynamics(ARM, clean.q, clean.qd, clean.qdd)
    np.testing.assert_allclose(
        tau[20:-20], np.tile(hold, (len(t) - 40, 1)), atol=0.02 * np.abs(hold).max()
    )
    whisper = as_motion(
        tmp_path, t, pose + 1e-9 * np.random.default_rng(1).normal(size=(len(t), 2))
    )
    assert recognised(ARM, whisper) is None  # 5e-5 rad/s² move nothing


def test_a_vibration_is_no_noise(tmp_path: Path):
    t = steps()
    q = truth(t)[0]
    q[:, 0] += 2e-3 * np.sin(2 * np.pi * 12 * t)
    assert recognised(ARM, as_motion(tmp_path, t, q, "%.7f")) is None
    loud = as_motion(tmp_path, t, q + 2e-5 * np.random.default_rng(2).normal(size=q.shape))
    found = recognised(ARM, loud)
    assert found is not None
    assert found.sigma > 0.0
    assert found.acceleration < 3e-5 / 0.01**2 * 8  # of the noise, not of the vibration: 8 rad/s²


def test_corners_of_a_path_are_no_noise(tmp_path: Path):
    t = steps()
    corners = np.arange(0.0, 4.5, 0.5)
    q = np.stack([np.interp(t, corners, truth(corners)[0][:, k]) for k in range(2)], axis=1)
    for fmt in ("%.17g", "%.6f"):
        assert recognised(ARM, as_motion(tmp_path, t, q, fmt)) is None
