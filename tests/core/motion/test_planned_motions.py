"""Planned motions: closed forms, limits reached and kept between samples, ruckig's durations."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

import freebody as fb
from support.command import run
from support.extras import extra

ARM = fb.load("ur5e")
WAY = np.random.default_rng(0).uniform(-1.5, 1.5, (4, 6))
PLANNERS: dict[str, Callable[..., fb.Motion]] = {
    "quintic": lambda way, **given: fb.quintic(ARM, way, acceleration=3.0, **given),
    "trapezoid": lambda way, **given: fb.trapezoid(ARM, way, acceleration=3.0, **given),
    "s_curve": lambda way, **given: fb.s_curve(ARM, way, acceleration=3.0, jerk=20.0, **given),
    "spline": lambda way, **given: fb.spline(ARM, way, acceleration=3.0, **given),
}


def ruckig_duration(q: np.ndarray, v: np.ndarray, a: np.ndarray, j: np.ndarray | None) -> float:
    """From rest to rest, all axes together."""
    ruckig = extra("ruckig")
    given, found = ruckig.InputParameter(6), ruckig.Trajectory(6)
    given.current_position, given.target_position = q.tolist()
    given.max_velocity, given.max_acceleration = v.tolist(), a.tolist()
    given.max_jerk = [np.inf] * 6 if j is None else j.tolist()
    assert ruckig.Ruckig(6).calculate(given, found) == ruckig.Result.Working
    return found.duration


@pytest.mark.parametrize("seed", range(3))
def test_durations_are_those_of_ruckig(seed: int):
    rng = np.random.default_rng(seed)
    for _ in range(20):
        q = rng.uniform(-3, 3, (2, 6))
        v, a, j = 10.0 ** rng.uniform(-1, 2, (3, 6))
        v = np.minimum(v, ARM.limits.velocity)
        mine = fb.s_curve(ARM, q, velocity=v, acceleration=a, jerk=j)
        assert mine.duration == pytest.approx(ruckig_duration(q, v, a, j), rel=1e-9)
        mine = fb.trapezoid(ARM, q, velocity=v, acceleration=a)
        assert mine.duration == pytest.approx(ruckig_duration(q, v, a, None), rel=1e-9)


# ---------------------------------------------------------------- motions
@pytest.mark.parametrize("name", PLANNERS)
def test_planned_motions_pass_their_waypoints_at_the_quickest_within_limits(name: str):
    motion = PLANNERS[name](WAY)
    peaks = motion.peaks
    used = max(
        (peaks.velocity.size / ARM.limits.velocity).max(), peaks.acceleration.size.max() / 3.0
    )
    assert used == pytest.approx(1.0, rel=1e-6) or (name == "s_curve" and used < 1.0)
    assert fb.exceeded_limits(ARM, motion, acceleration=3.0) == ()
    (over,) = fb.exceeded_limits(ARM, motion, np.inf, 0.999 * peaks.acceleration.size)[:1]
    assert over.quantity == "acceleration"
    assert over.value == pytest.approx(over.limit / 0.999)
    assert np.abs(motion.qd[[0, -1]]).max() == 0.0
    for q in WAY:
        dense = motion.at(np.linspace(*motion.t[[0, -1]], 20001))[0]
        assert np.abs(dense - q).max(axis=1).min() < 2e-3
    for mine, curve in zip((motion.q, motion.qd, motion.qdd), motion.at(motion.t), strict=True):
        np.testing.assert_allclose(mine, curve, atol=1e-11)
    assert pickle.loads(pickle.dumps(motion)) == motion
    longer = PLANNERS[name](WAY, times=np.array([1.0, 7.0, 9.5, 13.0]), step=0.01)
    np.testing.assert_allclose(longer.at([1.0, 7.0, 9.5, 13.0])[0], WAY, atol=1e-12)
    assert np.diff(longer.t)[:-1] == pytest.approx(0.01)


def test_waypoints_and_limits_by_name():
    names = list(ARM.position_names)
    turned = pd.DataFrame(WAY, columns=names)[names[::-1]]
    limit = dict(zip(names[::-1], np.arange(6.0, 0.0, -1.0), strict=True))
    motion = fb.quintic(ARM, turned, acceleration=limit)
    assert motion == fb.quintic(ARM, WAY, acceleration=np.arange(1.0, 7.0))
    with pytest.raises(fb.FreebodyError, match="quintic: acceleration lacks"):
        fb.quintic(ARM, WAY, acceleration={"elbow_joint": 1.0})
    assert fb.quintic(ARM, WAY, velocity=np.inf) == fb.quintic(ARM, WAY)
    assert fb.quintic(ARM, WAY, velocity=np.int64(1)) == fb.quintic(ARM, WAY, velocity=1.0)


def test_positions_between_waypoints_count():
    """A spline sways beyond its waypoints, between samples too."""
    way = np.zeros((4, 6))
    way[:, 2] = [0.0, 3.0, 3.1, 0.0]
    with pytest.raises(
        fb.FreebodyError,
        match=r"^spline: the position of elbow_joint is 3\.\d+ rad .* s, its upper limit 3\.1416",
    ):
        fb.spline(ARM, way)
    t = np.array([0.0, 1.0, 2.0, 3.0])
    q = np.zeros((4, 6))
    q[:, 0] = [0.0, 1.0, 1.0, 0.0]
    motion = fb.Motion.of(ARM, t, q)
    assert motion.peaks.position.high[0] == pytest.approx(1.125)
    assert motion.peaks.position.high_at[0] == pytest.approx(1.5)


def test_motions_in_a_row():
    there = PLANNERS["trapezoid"](WAY[:2])
    back = fb.quintic(ARM, WAY[1::-1])
    both = there.then(fb.dwell(ARM, WAY[1], 0.5)).then(back)
    assert both.duration == pytest.approx(there.duration + 0.5 + back.duration)
    q, qd, qdd = both.at(there.duration + 0.2)
    assert (q == WAY[1]).all()
    assert not qd.any()
    assert not qdd.any()
    thrice = both.repeated(3)
    assert thrice.duration == pytest.approx(3 * both.duration)
    np.testing.assert_allclose(thrice.at(2 * both.duration + 0.3)[0], there.at(0.3)[0], atol=1e-12)
    assert np.isin(thrice.t, thrice.knots).all()
    assert np.diff(thrice.knots).min() > 1e-9 * thrice.duration
    for times in (6, 7):
        found, one = both.repeated(times), both
        for _ in range(times - 1):
            one = one.then(both)
        np.testing.assert_allclose(found.t, one.t, rtol=1e-14)
        for name in ("q", "qd", "qdd"):
            np.testing.assert_array_equal(getattr(found, name), getattr(one, name))
    slow = both.faster(0.5)
    np.testing.assert_allclose(slow.at(1.0)[1], 0.5 * both.at(0.5)[1], atol=1e-12)
    with pytest.raises(fb.FreebodyError, match=r"^then: the first motion ends with q\[\d\] ="):
        there.then(there)
    with pytest.raises(fb.FreebodyError, match=r"^then: the motions are of different robots"):
        there.then(fb.default_motion(fb.load("2R")))


def test_motions_of_joints_with_quaternions_follow_each_other():
    drone = fb.load("quadrotor")
    motion = fb.default_motion(drone, 2.0)
    turned = motion.q.copy()
    turned[:, 3:] *= -1.0
    again = fb.Motion(motion.t, turned, motion.qd, motion.qdd, "turned", motion.layout)
    both = motion.then(again)
    for t in (0.7, 2.7):
        for mine, other in zip(both.at(t), motion.at(0.7), strict=True):
            np.testing.assert_allclose(mine, other, atol=1e-12)
    fastest = np.abs(motion.at(np.linspace(0, 2, 5001))[1]).max(axis=0)
    assert motion.peaks.velocity.size == pytest.approx(fastest, rel=1e-3)


def test_the_work_along_jumping_accelerations_is_exact():
    arm = fb.load("2R")
    study = fb.study(arm, fb.trapezoid(arm, [[0, 0], [1, 0.7], [0.3, 0.2]], acceleration=3))
    (balance,) = (check for check in study.checks if check.name == "energy balance")
    assert balance.value < 1e-12
    assert study.replay is not None
    assert np.nanmax(study.replay.misses) < 1e-11


def test_torques_that_jump_hundreds_of_times_lead_back_to_the_motion():
    limits = [fb.Limits(-3.0, 3.0, 3.0, 60.0), fb.Limits(-3.0, 3.0, 3.0, 20.0)]
    arm = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1], limits=limits)
    motion = fb.time_optimal(arm, [[0, 0], [1, 0.7], [0.3, 0.2]], points=301)
    assert len(motion.jumps) > 200
    study = fb.study(arm, motion)
    assert all(check.passed for check in study.checks)
    assert study.replay is not None
    assert np.nanmax(study.replay.misses) < 1e-11


def test_a_jump_beside_a_sample_is_one(tmp_path: Path):
    """The turn of a triangle of speed, halfway, is a sample but for rounding; so is any break at a
    multiple of the step."""
    arm, lost = fb.load("2R"), []
    for way in np.random.default_rng(0).uniform(0.1, 0.5, size=(60, 2, 2)):
        motion = fb.trapezoid(arm, way, acceleration=3.0)
        lost += [motion.source] * (len(motion.jumps) != 1)
        assert motion.pieces is not None
        assert motion.pieces.breaks[1] in motion.t  # to the last bit: the side that it is on counts
    assert not lost
    at = motion.jumps[0]
    for off in (-1e-12, 1e-12):
        t = np.array([0.0, 0.3 * at, at + off, motion.duration])
        assert motion.pieces is not None
        beside = replace(motion, t=t, q=motion.at(t)[0], qd=motion.at(t)[1], qdd=motion.at(t)[2])
        assert beside.jumps.tolist() == [at + off]
    read = fb.read_motion(arm, fb.write_motion(arm, motion, tmp_path / "way.csv"))
    t = np.linspace(0.0, motion.duration, 1001) * (1.0 - 1e-6)
    for mine, planned in zip(read.at(t), motion.at(t), strict=True):
        np.testing.assert_allclose(mine, planned, atol=1e-8)


def test_samples_lie_on_the_pieces():
    motion = PLANNERS["quintic"](WAY)
    with pytest.raises(fb.FreebodyError, match="its samples lie off its pieces by"):
        fb.Motion(motion.t, motion.q + 1.0, motion.qd, motion.qdd, "", motion.layout,
                  pieces=motion.pieces)  # fmt: skip


# ---------------------------------------------------------------- Motion.of
def test_a_motion_of_samples_whatever_they_come_in():
    arm, t = fb.load("2R"), np.linspace(0.0, 1.0, 21)
    q = np.stack([t**2, t**3], axis=-1)
    motion = fb.Motion.of(arm, t, q)
    np.testing.assert_allclose(motion.qdd, np.stack([2 + 0 * t, 6 * t], axis=-1), atol=1e-9)
    assert (fb.Motion.of(arm, t, q, motion.qd, motion.qdd).qdd == motion.qdd).all()
    names = {"joint1": q[:, 0], "joint2": q[:, 1]}
    table = {"t": t, **names}
    degrees = pd.DataFrame({"joint2": q[:, 1], "joint1 (deg)": np.degrees(q[:, 0])}, index=t)
    data = xr.Dataset({name: ("time", x) for name, x in names.items()}, {"time": t})
    for other in (
        fb.Motion.of(arm, table),
        fb.Motion.of(arm, pd.DataFrame(table)),
        fb.Motion.of(arm, degrees),
        fb.Motion.of(arm, data),
        fb.Motion.of(arm, t, pd.DataFrame(names)),
        fb.Motion.of(arm, t, names),
    ):
        for mine, given in zip(
            (other.q, other.qd, other.qdd), (q, motion.qd, motion.qdd), strict=True
        ):
            np.testing.assert_allclose(mine, given, atol=1e-9)
    rated = fb.Motion.of(arm, {**table, "joint1.v": 2 * t})
    assert (rated.qd[:, 0] == 2 * t).all()


def test_a_result_of_a_simulation_or_a_study_is_a_motion():
    model, t = fb.load("2R"), np.linspace(0.0, 0.5, 51)
    run = fb.simulate(model, [0.3, -0.5], [0.0, 0.0], t)
    motion = fb.Motion.of(model, run)
    for name in ("q", "qd", "qdd"):
        np.testing.assert_array_equal(getattr(motion, name), run[name].values)
    study = fb.study(model, run)
    again = fb.Motion.of(model, study.data)
    np.testing.assert_allclose(again.at(t)[2], run.qdd.values, atol=1e-9)
    np.testing.assert_allclose(study.data.tau, 0.0, atol=1e-4)  # between samples
    np.testing.assert_allclose(fb.Motion.of(model, run[["q"]]).qd, motion.qd, atol=1e-3)
    five_bar = fb.load("five_bar")
    fall = fb.simulate(five_bar, fb.assemble(five_bar), np.zeros(five_bar.nv), t[:11])
    np.testing.assert_allclose(fb.Motion.of(five_bar, fall).qd, fall.qd.values, atol=1e-3)
    many = fb.simulate(model, np.zeros((3, 2)), [0.0, 0.0], t)
    with pytest.raises(fb.FreebodyError, match=r"many motions; .* such as table\.isel\(sample=0\)"):
        fb.Motion.of(model, many)


def test_a_closed_chain_follows_its_drives(tmp_path: Path):
    linkage = fb.load("four_bar")
    motion = fb.default_motion(linkage, samples=41)
    drive = linkage.driven_names[0]
    k = linkage.position_names.index(drive)
    again = fb.Motion.of(linkage, {"t": motion.t, drive: motion.q[:, k]})
    np.testing.assert_allclose(again.q, motion.q, atol=1e-9)
    path = fb.write_motion(linkage, motion, tmp_path / "crank.csv")
    np.testing.assert_allclose(fb.read_motion(linkage, path).q, motion.q, atol=1e-9)
    whole = fb.Motion.of(linkage, motion.t, motion.q)
    np.testing.assert_allclose(whole.q, motion.q, atol=1e-9)


T = np.linspace(0.0, 1.0, 5)
REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: fb.Motion.of(ARM, T, np.full((5, 6), np.nan)), "Motion.of: q is nan at sample 0"),
    (lambda: fb.Motion.of(ARM, T, np.zeros((4, 6))), r"q has shape (4, 6), expected (5, 6)"),
    (lambda: fb.Motion.of(ARM, T[::-1], np.zeros((5, 6))), "t must increase"),
    (lambda: fb.Motion.of(ARM, T), "Motion.of: t is ndarray"),
    (lambda: fb.Motion.of(ARM, T, qd=np.zeros((5, 6))), "rates are given without positions"),
    (lambda: fb.Motion.of(ARM, {"t": T, "elbow": T}), "no column 'elbow'"),
    (lambda: fb.Motion.of(ARM, {"t": T, "elbow_joint": 1.0}), "has shape (), expected one number"),
    (lambda: fb.Motion.of(ARM, {"elbow_joint": T}), "it needs a one-dimensional 'time' or 't'"),
    (lambda: fb.quintic(ARM, WAY, [0.0, 0.1, 0.2, 0.3]), "needs 1.6447 s within its limits"),
    (
        lambda: fb.quintic(fb.load("2R"), [[0, 0], [1, 1]], acceleration=1e300),
        "acceleration of joint1 is 1e+300, expected at most 1e+12; infinity means no limit",
    ),
    (
        lambda: fb.quintic(fb.load("2R"), [[0, 0], [1e-200, 0], [1, 1]], acceleration=1.0),
        "waypoints 0 and 1 are the same",
    ),
    (
        lambda: fb.spline(fb.load("2R"), [[0, 0], [1e-200, 0], [1, 1]], acceleration=1.0),
        "waypoints 0 and 1 are the same",
    ),
    (
        lambda: fb.quintic(fb.load("2R"), [[0, 0], [1, 1]]),
        "is not known; give times=, velocity=, acceleration= or jerk= (robot descriptions",
    ),
    (lambda: fb.quintic(ARM, WAY[:1]), "expected at least two rows: (k, 6)"),
    (lambda: fb.quintic(ARM, WAY, [0.0, 1.0]), "times has shape (2,), expected (4,)"),
    (lambda: fb.quintic(ARM, WAY, [0.0, 1.0, 1.0, 2.0]), "times must be finite and increase"),
    (lambda: fb.quintic(ARM, WAY, velocity=0.0), "is 0, expected a limit above 0"),
    (lambda: fb.quintic(ARM, WAY, velocity=np.ones(5)), "velocity has shape (5,)"),
    (
        lambda: fb.quintic(ARM, WAY, [0.0, 2.0, 4.0, 6.0], step=9.0),
        "step is 9 s, expected at most a third of the motion, 2 s",
    ),
    (lambda: fb.quintic(ARM, 9.0 * WAY), "waypoint 3 has elbow_joint at -12.735, outside"),
    (lambda: fb.quintic(ARM, WAY[[0, 0]]), "waypoints 0 and 1 are the same; leave one out"),
    (lambda: fb.quintic(fb.load("2R"), [[0, 0], [1, 1]]), "how fast '2R' may move is not known"),
    (
        lambda: fb.quintic(fb.load("quadrotor"), np.zeros((2, 7))),
        "quintic: the quaternion of joint 'flight' at sample 0 has length 0; it must be 1",
    ),
    (lambda: fb.quintic(fb.load("quadrotor"), np.zeros((2, 6))), "waypoints has shape (2, 6)"),
    (lambda: fb.spline(fb.load("quadrotor"), np.zeros((2, 7))), "positions are quaternions"),
    (lambda: fb.quintic(fb.load("four_bar"), np.zeros((2, 3))), "is open by 0.5 m at sample 0"),
    (lambda: fb.trapezoid(ARM, WAY), "give acceleration="),
    (lambda: fb.s_curve(ARM, WAY, acceleration=1.0), "give jerk="),
    (lambda: fb.spline(ARM, WAY, ends="free"), "no choice 'free'"),
    (lambda: fb.spline(ARM, WAY, ends="periodic"), "the last equal to the first"),
    (lambda: fb.spline(ARM, WAY, degree=4), "degree is 4, expected 3 or 5"),
    (lambda: fb.dwell(ARM, WAY[0], 0.0), "duration is 0, expected a number of seconds above 0"),
    (lambda: PLANNERS["quintic"](WAY).faster(-1.0), "factor is -1, expected a number above 0"),
    (lambda: PLANNERS["quintic"](WAY).repeated(0), "times is 0, expected a whole number"),
    (lambda: PLANNERS["quintic"](WAY).repeated(True), "times is True, expected a whole number"),
    (lambda: PLANNERS["quintic"](WAY).then("it"), "then: other is str 'it', expected a Motion"),
    (lambda: fb.quintic(ARM, WAY, acceleration=1e-300), "is 1e-300, expected a limit above 0"),
    (lambda: fb.quintic(ARM, np.nan * WAY), "quintic: waypoints is nan at sample 0"),
    (lambda: fb.exceeded_limits(ARM, fb.default_motion(fb.load("2R"))), "the motion has 2 pos"),
    (lambda: fb.write_motion(ARM, WAY, "x.csv"), "write_motion: motion is ndarray"),
    (lambda: fb.dwell(ARM, WAY, 1.0), "dwell: q has shape (4, 6), expected (6,)"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_what_cannot_be_is_refused_with_what_to_do(case: int):
    function, words = REFUSED[case]
    with pytest.raises(fb.FreebodyError) as problem:
        function()
    assert words in str(problem.value)


@pytest.mark.parametrize("plan", [fb.quintic, fb.trapezoid, fb.s_curve])
def test_a_free_body_goes_straight_and_turns_about_one_axis(plan: Callable[..., fb.Motion]):
    """As scipy's Slerp says, with the profile of a single joint over the angle."""
    drone, rng = fb.load("quadrotor"), np.random.default_rng(0)
    turns = Rotation.random(3, random_state=1)
    way = np.hstack([rng.normal(size=(3, 3)), turns.as_quat(scalar_first=True)])
    way[1, 3:] *= -1.0  # the same orientation
    limits = {"acceleration": 2.0} | ({"jerk": 20.0} if plan is fb.s_curve else {})
    motion = plan(drone, way, **limits)
    t = np.linspace(*motion.t[[0, -1]], 777)
    _, qd, qdd = motion.at(t)
    _, stop, _ = motion.knots[np.abs(motion.at(motion.knots)[1]).max(axis=1) < 1e-9]
    middle = 0.4 * stop
    place, _, _ = motion.at(middle)
    share = np.linalg.norm(place[:3] - way[0, :3]) / np.linalg.norm(way[1, :3] - way[0, :3])
    np.testing.assert_allclose(place[:3], way[0, :3] + share * (way[1, :3] - way[0, :3]))
    axis = (turns[0].inv() * turns[1]).as_rotvec()
    turned = (turns[0].inv() * Rotation.from_quat(place[3:], scalar_first=True)).as_rotvec()
    np.testing.assert_allclose(np.cross(axis, turned), 0.0, atol=1e-9)
    assert 0.0 < axis @ turned < axis @ axis
    ends = motion.at([0.0, stop, motion.t[-1]])[0]
    np.testing.assert_allclose(fb.difference(drone, ends, way), 0.0, atol=1e-6)
    inside, h = slice(5, -5), 1e-6
    before, after = (motion.at(t[inside] + x)[0] for x in (-h, h))
    numeric = fb.difference(drone, before, after) / (2 * h)
    np.testing.assert_allclose(qd[inside], numeric, atol=1e-6)
    fastest = np.abs(qdd).max(axis=0)
    assert fastest.max() == pytest.approx(2.0, rel=1e-2)
    assert fb.exceeded_limits(drone, motion, acceleration=2.0) == ()
    both = motion.then(fb.dwell(drone, motion.q[-1], 0.3))
    assert both.duration == pytest.approx(motion.duration + 0.3)


@pytest.mark.parametrize("plan", [fb.quintic, fb.trapezoid, fb.s_curve])
def test_a_joint_that_hardly_moves_goes_along(plan: Callable[..., fb.Motion]):
    """Its own quickest motion would take next to no time."""
    limits = {"acceleration": 2.0} | ({"jerk": 5.0} if plan is fb.s_curve else {})
    found = plan(fb.load("2R"), [[0.0, 0.0], [1.0, 1e-200], [0.0, 1e-13]], **limits)
    alone = plan(fb.load("2R"), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]], **limits)
    assert found.duration == alone.duration
    np.testing.assert_array_equal(found.q[:, 0], alone.q[:, 0])
    assert found.q[-1, 1] == pytest.approx(1e-13)
    assert np.abs(found.qdd[:, 1]).max() < 1e-12


@pytest.mark.parametrize("degree", [3, 5])
def test_a_joint_that_waypoints_leave_alone_is_at_rest(degree: int):
    """Between samples too, where the rounding of a spline would feel Coulomb friction."""
    way = WAY.copy()
    way[:, 4] = -0.3
    motion = fb.spline(ARM, way, acceleration=4.0, degree=degree)
    q, qd, qdd = motion.at(np.linspace(0.0, motion.duration, 999))
    np.testing.assert_allclose(q[:, 4], -0.3, rtol=1e-15)
    assert not qd[:, 4].any()
    assert not qdd[:, 4].any()


# ---------------------------------------------------------------- files and the command
def test_a_plan_is_written_and_studied(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    header = "t [ms],shoulder_pan_joint (deg)," + ",".join(ARM.position_names[1:])
    rows = ["0,10,-1,1,-1,-1,0", "1500,30,-1.2,1.5,-1,-1,0", "3000,30,-1.3,1.0,-1,-.5,0.4"]
    Path("way.csv").write_text("\n".join([header, *rows]))
    q, times = fb.read_waypoints(ARM, "way.csv")
    assert times is not None
    assert times.tolist() == [0.0, 1.5, 3.0]
    assert q[1] == pytest.approx([np.radians(30.0), -1.2, 1.5, -1.0, -1.0, 0.0])
    for by in ("spline", "trapezoid", "s-curve"):
        more = ["--acceleration", "8"] if by != "s-curve" else ["--jerk", "80"]
        assert run(["plan", "ur5e", "way.csv", "--by", by, *more, "--out", f"{by}.csv"]) == 0
        said = capsys.readouterr()
        assert "through 3 waypoints" in said.out
        assert f"\nwritten: {by}.csv\n" in said.out
        motion = fb.read_motion(ARM, f"{by}.csv")
        assert motion.notices == ()
        assert motion.duration == 3.0
        np.testing.assert_allclose(motion.at(1.5)[0][:3], [np.radians(30), -1.2, 1.5], atol=1e-9)
    assert run(["plan", "2R", "0, 0; 1.2, 30 deg; 0.5, -0.4", "--acceleration", "2"]) == 0
    studied = fb.study(fb.load("2R"), "motion.csv")
    assert studied.motion.q[-1] == pytest.approx([0.5, -0.4])
    assert all(check.passed for check in studied.checks)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", PLANNERS)
def test_what_is_written_is_read_as_it_was_planned(name: str, tmp_path: Path):
    motion = PLANNERS[name](WAY)
    path = fb.write_motion(ARM, motion, tmp_path / "planned.csv")
    # a rate below a millionth of the fastest is read as rest
    slacks = (1e-7, 4e-6, 1e-2) if name == "s_curve" else (1e-12, 1e-8, 1e-5)
    for again in (fb.read_motion(ARM, path), fb.Motion.of(ARM, pd.read_csv(path))):
        assert again.notices == ()
        t = np.linspace(0.0, motion.duration, 7001)
        for mine, given, slack in zip(again.at(t), motion.at(t), slacks, strict=True):
            near = np.abs(t[:, None] - motion.pieces.breaks).min(axis=1) > 1e-9
            np.testing.assert_allclose(mine[near], given[near], atol=slack)
        assert fb.exceeded_limits(ARM, again) == ()
    even = fb.read_motion(ARM, fb.write_motion(ARM, motion, tmp_path / "even.csv", "samples"))
    assert (even.t == motion.t).all()
    with pytest.raises(fb.FreebodyError, match="no choice 'all' in write_motion: rows="):
        fb.write_motion(ARM, motion, path, "all")


def test_a_time_stands_twice_only_where_accelerations_jump(tmp_path: Path):
    arm = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1])
    t = np.array([0.0, 1.0, 2.0, 2.0, 3.0, 4.0])
    table = {
        "t": t,
        "joint1": np.array([0.0, 0.5, 2.0, 2.0, 3.5, 4.0]),
        "joint1.v": np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0]),
        "joint1.a": np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0]),
    }
    motion = fb.Motion.of(arm, table)
    assert motion.t.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert motion.qdd[:, 0].tolist() == [1.0, 1.0, -1.0, -1.0, -1.0]
    assert motion.at([1.9, 2.1])[2][:, 0] == pytest.approx([1.0, -1.0])
    assert motion.peaks.velocity.high == pytest.approx(2.0)
    for name in ("joint1", "joint1.v"):
        other = {**table, name: table[name] + 0.1 * (np.arange(6) == 3)}
        with pytest.raises(fb.FreebodyError, match=r"t must increase; t\[3\] = 2 follows 2"):
            fb.Motion.of(arm, other)
    with pytest.raises(fb.FreebodyError, match=r"t must increase"):
        fb.Motion.of(arm, {k: np.insert(x, 3, x[3]) for k, x in table.items()})
    with pytest.raises(fb.FreebodyError, match=r"t must increase"):
        fb.Motion.of(arm, {k: x for k, x in table.items() if k != "joint1.a"})


MISTAKEN = [
    ("a,b\n1,2", [], "way.csv:1: no column 'a' in a motion of '2R'"),
    ("joint1,joint2.v\n1,2", [], "waypoints have positions alone"),
    ("joint1\n1", [], "way.csv:1: there is no column for 'joint2'"),
    ("joint1,joint2\n1,2\n2,x", [], "way.csv:3: column 'joint2': 'x' is not a number"),
    ("joint1,joint2\n1,2", ["--acceleration", "1"], "expected at least two rows: (k, 2)"),
    (
        "joint1,joint2\n1,2\n2,3",
        [],
        "give a column t of times, --velocity or --acceleration (robot descriptions",
    ),
    ("joint1,joint2\n1,2\n2,3", ["--by", "s-curve"], "not known; give --jerk (robot descriptions"),
    (
        "joint1,joint2\n1,2\n2,3",
        ["--by", "time-optimal"],
        "nothing limits the speed of joint1 and joint2; give --velocity, --acceleration or "
        "--torque.",
    ),
    ("joint1,joint2\n1,2\n2,3", ["--jerk", "1"], "--jerk has no meaning for spline; it takes"),
    ("# none", [], "the file is empty; a file of waypoints has a header, joint names, and"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(MISTAKEN)))
def test_what_the_command_cannot_use_is_one_line(
    case: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    text, more, words = MISTAKEN[case]
    Path("way.csv").write_text(text)
    assert run(["plan", "2R", "way.csv", *more]) == 2
    assert words in capsys.readouterr().err
    assert not Path("motion.csv").exists()


def test_the_command_says_where_places_of_the_tip_belong(capsys: pytest.CaptureFixture[str]):
    place = "'0.45, -0.3, 0.2' has 3 positions, 'ur5e' has 6 positions: shoulder_pan_joint"
    assert run(["plan", "ur5e", "0,0,0,0,0,0; 0.45, -0.3, 0.2"]) == 2
    said = capsys.readouterr().err
    assert place in said
    assert "a duty cycle has them as tip" in said
    assert run(["plan", "ur5e", "0,0,0,0; 1,1,1,1"]) == 2
    assert "duty cycle" not in capsys.readouterr().err
    assert run(["plan", "ur5e", "0,-1,1,0,0,0", "--line", "0.4,0.2,0.3; 0.4,0.2,0.1"]) == 2
    assert "With a stop at each place: a duty cycle" in capsys.readouterr().err


def test_the_command_plans_a_free_body(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    way = "0, 0, 1, 1, 0, 0, 0; 1, 0, 1, 0, 0, 0, 1"
    assert run(["plan", "quadrotor", way, "--by", "quintic", "--acceleration", "2"]) == 0
    assert "flight.vx" in capsys.readouterr().out
    read = fb.read_motion(fb.load("quadrotor"), "motion.csv")
    np.testing.assert_allclose(read.q[-1], [1, 0, 1, 0, 0, 0, 1], atol=1e-9)
    assert run(["plan", "quadrotor", way, "--acceleration", "2"]) == 2
    assert "positions are quaternions" in capsys.readouterr().err


def test_a_study_judges_what_lies_between_samples():
    """Four samples at 0, 1, 1, 0: the curve through them goes to 1.125, and is fastest at ends."""
    limits = [fb.Limits(-2.0, 1.1, 2.0, 100.0)]
    arm = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=limits)
    q = np.array([[0.0], [1.0], [1.0], [0.0]])
    found = fb.study(arm, fb.Motion.of(arm, [0.0, 1.0, 2.0, 3.0], q))
    assert found.verdict.outcome == "not feasible"
    assert "goes to 1.125 rad at t = 1.5 s" in found.verdict.text
    assert float(found.summary["highest"][0]) == pytest.approx(1.125)


def test_a_study_finds_peaks_between_samples_and_beside_jumps():
    """A torque grows until its joint is braked: it is largest just before that jump."""
    arm = fb.load("2R")
    way, limits = [[0.3, -1.2], [-1, 1], [1, 0.7]], {"velocity": 1.3, "acceleration": [3, 5]}
    motion = fb.trapezoid(arm, way, **limits, step=0.13)
    found = fb.study(arm, motion)
    t = np.linspace(*motion.t[[0, -1]], 100_001)
    tau = fb.inverse_dynamics(arm, *motion.at(t))
    exact = np.abs(tau).max(axis=0)
    at_samples = np.abs(fb.inverse_dynamics(arm, motion.q, motion.qd, motion.qdd)).max(axis=0)
    assert (at_samples < 0.999 * exact).any()
    np.testing.assert_allclose(np.abs(found.summary["peak_torque"]), exact, rtol=1e-4)
    force = fb.joint_wrenches(arm, *motion.at(t))[..., :2]
    sizes = np.linalg.norm(force, axis=-1).max(axis=0)
    np.testing.assert_allclose(found.summary["peak_force"], sizes, rtol=1e-4)
    assert set(motion.t) < set(found.motion.t)
    worst = found.data.isel(time=found.worst.index)
    assert float(np.abs(worst["tau"]).max()) == pytest.approx(abs(found.worst.value))
    limited = arm.bind({"joint1.limits.effort": 0.5 * (at_samples[0] + exact[0])})
    assert fb.study(limited, motion).verdict.outcome == "not feasible"


def test_a_waypoint_at_0_prints_as_0(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run(["plan", "2R", "0.6, 0; -1.1, 1.2; 0.8, 0", "--velocity", "3"]) == 0
    assert "e-" not in capsys.readouterr().out


def test_a_motion_has_no_states_outside_its_times():
    motion = fb.quintic(fb.load("2R"), [[0.0, 0.0], [1.0, 0.5]], velocity=1.0, acceleration=2.0)
    end = motion.t[-1]
    np.testing.assert_allclose(motion.at(end * (1 + 1e-15))[0], [1.0, 0.5], atol=1e-12)
    with pytest.raises(
        fb.FreebodyError, match=r"Motion\.at: t is .* s at sample 1, and the motion ends at"
    ):
        motion.at([0.0, end + 1e-3])
    with pytest.raises(fb.FreebodyError, match=r"t is -0\.5 s, and the motion begins at 0 s"):
        motion.at(-0.5)
    with pytest.raises(fb.FreebodyError, match="nan"):
        motion.at(np.nan)


def test_the_range_of_a_follower_is_its_leaders_for_every_function(tmp_path):
    """Random states and inverse kinematics took the leader's own, which planners refuse."""
    text = ['name = "coupled"', "dim = 2", '[[link]]\nname = "ground"']
    for k, (parent, upper, more) in enumerate(
        (("ground", 2.0, ""), ("l1", 1.0, 'mimic = { joint = "j1", ratio = 1.0 }\n')), start=1
    ):
        text.append(
            f'[[link]]\nname = "l{k}"\nmass = 1.0\ncom = [0.2, 0]\ninertia = 0.02\n[[joint]]\n'
            f'name = "j{k}"\nkind = "revolute"\nparent = "{parent}"\nchild = "l{k}"\n'
            f"origin = [{0.4 * (k - 1)}, 0]\n{more}"
            f"limits = {{ lower = 0.0, upper = {upper}, velocity = 1.0 }}"
        )
    file = tmp_path / "coupled.toml"
    file.write_text("\n".join(text))
    model = fb.load(file, tip="l2")
    q, _, _ = fb.random_state(model, 0, 500)
    assert 0.9 < q.max() <= 1.0
    point = fb.forward_kinematics(model, [1.8])[:2, 2]
    beyond = fb.inverse_kinematics(model, point, task="position")
    assert not beyond.within_limits.any()
    assert len(fb.inverse_kinematics(model, point, task="position", limits="drop")) == 0
    with pytest.raises(fb.FreebodyError, match=r"outside its range from 0 to 1"):
        fb.quintic(model, [[0.2], [1.8]], acceleration=1.0)
