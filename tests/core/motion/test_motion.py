"""Motions: smooth, within the limits, and read from files with errors that say where."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

import freebody as fb
from freebody import FileError, FreebodyError, read_motion
from support.helpers import OPEN_CHAINS
from support.robots import Joint, Link, Robot, loaded

pytestmark = pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")


def limited(
    lower: float, upper: float, velocity: float = np.inf, effort: float = np.inf
) -> fb.Model:
    limits = fb.Limits(lower, upper, velocity, effort)
    return fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=[limits])


@pytest.mark.parametrize("name", OPEN_CHAINS)
def test_the_default_motion_is_smooth_within_limits_and_moves_everything(name: str):
    model = fb.load(name)
    motion, allowed = fb.default_motion(model), model.limits
    assert motion.q.shape == (401, model.nq)
    assert motion.duration == 5.0
    ranged = [k for k, name in enumerate(model.velocity_names) if name in model.position_names]
    q = motion.q[:, [model.position_names.index(model.velocity_names[k]) for k in ranged]]
    assert len(ranged) == model.nv or model.nq > model.nv
    assert (q > allowed.lower[ranged]).all()
    assert (q < allowed.upper[ranged]).all()
    assert (np.abs(motion.qd) < allowed.velocity).all()
    assert (np.ptp(motion.qd, axis=0) > 1e-3).all()
    assert np.abs(motion.qd[[0, -1]]).max() < 1e-12
    assert np.abs(motion.qdd[[0, -1]]).max() < 1e-10
    again = fb.default_motion(model)
    assert (again.q == motion.q).all()


@pytest.mark.parametrize("name", ["3R", "panda", "quadrotor"])
def test_rates_are_those_of_the_curve(name: str):
    model = fb.load(name)
    motion = fb.default_motion(model)
    for mine, curve in zip((motion.q, motion.qd, motion.qdd), motion.at(motion.t), strict=True):
        np.testing.assert_allclose(curve, mine, atol=1e-12)
    t, h = np.linspace(0.2, 4.8, 301), 1e-4
    _, qd, qdd = motion.at(t)
    before, after = motion.at(t - h), motion.at(t + h)
    np.testing.assert_allclose(fb.difference(model, before[0], after[0]) / (2 * h), qd, atol=1e-6)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), qdd, atol=1e-6)


def test_tight_limits_are_kept():
    motion = fb.default_motion(limited(1.0, 1.1, velocity=0.05))
    assert 1.0 < motion.q.min() < motion.q.max() < 1.1
    assert np.abs(motion.qd).max() <= 0.6 * 0.05 * 1.01
    one_sided = fb.default_motion(limited(3.0, np.inf))
    assert one_sided.q.min() > 3.0


def test_limits_of_zero_count_as_not_given():
    motion = fb.default_motion(limited(0.0, 0.0, velocity=0.0, effort=0.0))
    assert np.ptp(motion.q) > 0.5
    assert motion.notices == (
        "the position range of joint1 is zero in the model and is taken as not given.",
        "the speed limit of joint1 is zero in the model and is taken as not given.",
        "the effort limit of joint1 is zero in the model and is taken as not given.",
    )


def test_a_quintic_is_differentiated_exactly():
    model = fb.load("2R")
    t = np.sort(np.random.default_rng(0).uniform(0, 2, 12))
    q = np.stack([t**5 - t, 3 * t**2], axis=-1)
    motion = fb.Motion.of(model, t, q)
    np.testing.assert_allclose(motion.qd, np.stack([5 * t**4 - 1, 6 * t], axis=-1), atol=1e-8)
    np.testing.assert_allclose(motion.qdd, np.stack([20 * t**3, 6 + 0 * t], axis=-1), atol=1e-6)
    np.testing.assert_allclose(motion.at(1.0)[0], [0.0, 3.0], atol=1e-9)


def test_quaternions_are_differentiated_whatever_their_sign():
    links = Link("base"), Link("ball", fb.Inertia(2.0, (0.1, 0, 0.2), (0.02, 0, 0, 0.03, 0, 0.04)))
    joints = (Joint("socket", "spherical", "base", "ball"),)
    model = loaded(Robot("ball", 3, links, joints, 9.81))
    t = np.linspace(0, 1, 101)
    w = np.array([0.3, -0.2, 2.0])  # constant, in body axes
    quaternion = Rotation.from_rotvec(t[:, None] * w).as_quat(scalar_first=True)
    flipped = quaternion * np.where(np.arange(101) % 3 == 0, -1.0, 1.0)[:, None]
    motion = fb.Motion.of(model, t, flipped)
    np.testing.assert_allclose(motion.qd, np.broadcast_to(w, (101, 3)), atol=1e-8)
    np.testing.assert_allclose(motion.qdd, 0, atol=1e-5)


def csv(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_a_file_with_rates_is_taken_as_it_is(tmp_path: Path):
    model = fb.load("2R")
    t = np.linspace(0, 1, 9)
    rows = np.column_stack([t, np.sin(t), np.cos(t), -np.sin(t), t**2])
    text = "# a comment\nt, joint1, joint1.v, joint1.a, joint2\n" + "\n".join(
        ", ".join(map(repr, map(float, r))) for r in rows
    )
    motion = read_motion(model, csv(tmp_path / "m.csv", text))
    np.testing.assert_array_equal(motion.qd[:, 0], np.cos(t))
    np.testing.assert_array_equal(motion.qdd[:, 0], -np.sin(t))
    np.testing.assert_allclose(motion.qd[:, 1], 2 * t, atol=1e-9)
    assert motion.notices == ()
    assert motion.source == (
        "read from m.csv, 9 rows; rates of 'joint1' as given; differentiated by a spline through "
        "the positions"
    )


def test_rates_that_contradict_the_positions_are_mentioned(tmp_path: Path):
    rows = "\n".join(f"{k},{k},{k},5" for k in range(6))
    motion = read_motion(
        fb.load("2R"), csv(tmp_path / "m.csv", f"t,joint1,joint2,joint2.v\n{rows}\n")
    )
    assert motion.notices == (
        "The rates given for 'joint2' are not the slope of the positions: between t = 0 and 1 s "
        "the slope is 1 rad/s, but 5 and 5 rad/s are given.",
    )


T = np.linspace(0.0, 2.0, 21)
SINES = np.stack([np.sin(3 * T), 0.2 * np.cos(5 * T)], axis=-1)
RATES = np.stack([3 * np.cos(3 * T), -np.sin(5 * T)], axis=-1)
SECONDS = np.stack([-9 * np.sin(3 * T), -5 * np.cos(5 * T)], axis=-1)
CONTRADICTIONS = {
    "the rates of the other": (RATES[:, ::-1], SECONDS[:, ::-1], ("rates",)),
    "in degrees": (np.degrees(RATES), None, ("rates",)),
    "a fifth too fast": (1.2 * RATES, None, ("rates",)),
    "two samples late": (np.roll(RATES, 2, axis=0), None, ("rates",)),
    "accelerations of another": (RATES, SECONDS[:, ::-1], ("accelerations",)),
    "a wrong sign": (RATES, -SECONDS, ("accelerations",)),
}


@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_what_contradicts_itself_is_told(case: str):
    rates, seconds, told = CONTRADICTIONS[case]
    model = fb.load("2R")
    of_arrays = fb.Motion.of(model, T, SINES, rates, seconds)
    columns = {f"joint{k + 1}": SINES[:, k] for k in range(2)}
    columns |= {f"joint{k + 1}.v": rates[:, k] for k in range(2)}
    if seconds is not None:
        columns |= {f"joint{k + 1}.a": seconds[:, k] for k in range(2)}
    of_table = fb.Motion.of(model, {"t": T, **columns})
    assert of_arrays.notices == of_table.notices
    assert len(told) == len(of_arrays.notices)
    for what, notice in zip(told, of_arrays.notices, strict=True):
        assert re.match(rf"The {what} given for 'joint\d', and those of 1 more, are not", notice)
    np.testing.assert_array_equal(of_arrays.qd, rates)  # used as given


@pytest.mark.parametrize("every", [1, 2, 3])
def test_what_agrees_is_not_doubted_though_coarsely_sampled(every: int):
    model, some = fb.load("2R"), slice(None, None, every)
    motion = fb.Motion.of(model, T[some], SINES[some], RATES[some], SECONDS[some])
    assert motion.notices == ()
    way = [[0.0, 0.0], [1.0, -0.5], [0.4, 1.0]]
    limits = {"velocity": 2.0, "acceleration": 5.0}
    for planned in (
        fb.trapezoid(model, way, **limits, step=0.02 * every),
        fb.s_curve(model, way, **limits, jerk=50.0, step=0.02 * every),
        fb.time_optimal(model, way, **limits, points=401),
    ):
        read = fb.Motion.of(model, planned.t, planned.q, planned.qd, planned.qdd)
        assert read.notices == ()


def test_rates_of_a_free_body_are_held_against_its_quaternions():
    model = fb.load("quadrotor")
    q, qd = fb.random_state(model, seed=3)[:2]
    t = np.linspace(0.0, 0.5, 26)
    turned = fb.integrate(model, q, t[:, None] * qd)
    rates = np.broadcast_to(qd, (26, 6)).copy()
    still = turned.copy()
    still[:, :3] = q[:3]
    rates[:, :3] = 0.0
    assert fb.Motion.of(model, t, still, rates).notices == ()
    rates[:, 4] *= -1.0
    (told,) = fb.Motion.of(model, t, still, rates).notices
    assert told.startswith("The rates given for 'flight.wy' are not the slope of the positions")


def test_slow_rates_of_a_file_are_kept_as_they_are_given(tmp_path: Path):
    """Near rest too: an s-curve leaves it with the square of the time."""
    model = fb.load("2R")
    motion = fb.s_curve(model, [[0.0, 0.0], [1.0, -0.5]], jerk=50.0, acceleration=5.0)
    read = read_motion(model, fb.write_motion(model, motion, tmp_path / "m.csv"))
    t = np.linspace(*motion.t[[0, -1]], 2001)
    for found, exact in zip(read.at(t), motion.at(t), strict=True):
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8 * np.abs(exact).max())
    dense = fb.s_curve(model, [[0.0, 0.0], [1.0, -0.5]], jerk=50.0, acceleration=5.0, step=2e-4)
    read = read_motion(model, fb.write_motion(model, dense, tmp_path / "n.csv", "samples"))
    slow = (dense.qd != 0.0) & (np.abs(dense.qd) < 1e-6 * np.abs(dense.qd).max())
    assert slow.any()
    np.testing.assert_allclose(read.qd[slow], dense.qd[slow], rtol=1e-6)


ROWS = "0,0,0\n1,1,1\n2,2,2\n3,3,3\n"
BAD = {
    "": ": the file is empty.",
    "when,joint1,joint2\n"
    + ROWS: ":1: the header has no column 't' (time in s); it has 'when', 'joint1' and 'joint2'.",
    "t,joint1\n0,0\n1,1\n2,2\n3,3\n": ":1: there is no column for 'joint2'; "
    "a motion gives every position of '2R'.",
    "t,joint1,joint2,jont2\n"
    + ROWS: ":1: no column 'jont2' in a motion of '2R'. Did you mean 'joint2'? "
    "Columns: t, joint1, joint2, joint1.v, joint1.a, joint2.v, joint2.a; a column that is not "
    "part of the motion must be removed.",
    "t,joint1,joint1\n" + ROWS: ":1: column 'joint1' occurs twice in the header; remove one.",
    "t,joint1,joint2\n0,0,0\n1,x,1\n": ":1: 2 rows of numbers; a motion needs at least 4.",
    "t,joint1,joint2\n0,0,0\n\n1,x,1\n2,2,2\n3,3,3": ":4: column 'joint1': 'x' is not a number.",
    "t,joint1,joint2\n0,0,0\n1,,1\n2,2,2\n3,3,3": ":3: column 'joint1': there is no number.",
    "t,joint1,joint2\n0,0,0\n1,1,1\n2,2,nan\n3,3,3": ":4: column 'joint2': "
    "'nan' is not a finite number.",
    "t,joint1,joint2\n0,0,0\n1,1,1\n1,2,2\n3,3,3": ":4: t = 1 does not come after 1; "
    "times must increase.",
    "t,joint1,joint2\n0,0,0\n1,1\n2,2,2\n3,3,3": ":3: 2 values, the header names 3 columns.",
    "t,joint1,joint2\n0,0,0": ":1: 1 row of numbers; a motion needs at least 4.",
}


@pytest.mark.parametrize("text", BAD)
def test_a_bad_file_is_refused_with_its_line(text: str, tmp_path: Path):
    path = csv(tmp_path / "m.csv", text)
    with pytest.raises(FileError) as caught:
        read_motion(fb.load("2R"), path)
    assert str(caught.value) == f"{path}{BAD[text]}"


def test_what_is_no_text_file_is_refused(tmp_path: Path):
    model = fb.load("2R")
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    for name, why in (
        ("binary.csv", "the file is binary, not text."),
        ("none.csv", "there is no such file."),
        (".", "this is a folder; name a file in it, such as binary.csv."),
    ):
        with pytest.raises(FileError) as caught:
            read_motion(model, tmp_path / name)
        assert str(caught.value) == f"{tmp_path / name}: {why}"


def test_quaternions_of_a_file_must_be_of_unit_length_and_have_no_rates(tmp_path: Path):
    model = fb.load("quadrotor")
    names = ",".join(model.position_names)
    row = "0,0,1,1,0,0,0"
    rows = [f"{k},{row}" for k in range(5)]
    assert (
        read_motion(model, csv(tmp_path / "m.csv", "\n".join([f"t,{names}", *rows]))).qd.max()
        < 1e-12
    )
    rows[2] = "2,0,0,1,0.5,0,0,0"
    with pytest.raises(
        FileError, match=r"m\.csv:4: the quaternion .*quat_w.* has length 0\.5, expected 1\."
    ):
        read_motion(model, csv(tmp_path / "m.csv", "\n".join([f"t,{names}", *rows])))
    with pytest.raises(
        FileError, match=r"rates of a joint with a quaternion are differentiated; remove the column"
    ):
        read_motion(model, csv(tmp_path / "m.csv", f"t,{names},flight.wx.v\n"))


def test_a_dataset_is_a_motion_too():
    model = fb.load("2R")
    t = np.linspace(0, 1, 8)
    data = xr.Dataset(
        {"joint1": ("time", t**2), "joint2": ("time", t), "joint2.v": ("time", 1 + 0 * t)},
        {"time": t},
    )
    motion = fb.Motion.of(model, data)
    np.testing.assert_allclose(motion.qd, np.stack([2 * t, 1 + 0 * t], axis=-1), atol=1e-10)
    with pytest.raises(FreebodyError, match=r"^motion: the table: there is no column for 'joint2'"):
        fb.Motion.of(model, data.drop_vars(["joint2", "joint2.v"]))
    with pytest.raises(FreebodyError, match=r"needs a one-dimensional 'time'"):
        fb.Motion.of(model, xr.Dataset({"joint1": 1.0}))
    with pytest.raises(
        FreebodyError, match=r"'joint1' holds a value that is not finite\. \(sample 7\)"
    ):
        fb.Motion.of(model, data.assign(joint1=data.joint1.where(data.time < 1)))


def test_arrays_are_checked():
    model = fb.load("2R")
    with pytest.raises(FreebodyError, match=r"motion: t must increase; t\[2\] = 1 follows 1\."):
        fb.Motion.of(model, [0, 1, 1, 2], np.zeros((4, 2)))
    with pytest.raises(
        FreebodyError,
        match=r"^Motion\.of: q has shape \(3, 2\), expected \(4, 2\): one row a",
    ):
        fb.Motion.of(model, [0, 1, 2, 3], np.zeros((3, 2)))
    with pytest.raises(
        FreebodyError, match=r"default_motion: duration is -1, expected a number of seconds"
    ):
        fb.default_motion(model, duration=-1)
