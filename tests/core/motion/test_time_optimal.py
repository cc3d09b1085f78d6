"""Time-optimal motions along paths: closed forms of one joint, limits held between the points, and
toppra's durations."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline, PPoly
from scipy.optimize import brentq

import freebody as fb
from support import real_files
from support.command import run
from support.extras import extra

WAY = [[0.0, 0.0], [1.0, -0.5], [0.4, 1.0], [-0.8, 0.3]]


@cache
def arm() -> fb.Model:
    """Two joints with limits of speed and torque."""
    model = with_limits(fb.load("2R"), velocity=2.0, effort=150.0)
    return model.bind({"joint2.limits.effort": 40.0})


def with_limits(model: fb.Model, **limits: float) -> fb.Model:
    names = model.joint_names
    return model.bind({f"{j}.limits.{name}": x for j in names for name, x in limits.items()})


def slider(mass: float = 2.0, **drive: float) -> fb.Model:
    """A mass on a rail."""
    model = fb.planar("P").bind(lc1=0.0, m1=mass, I1=0.0).replace(gravity=0.0)
    return model.with_drive("joint1", **drive) if drive else model


def pendulum(**drive: float) -> fb.Model:
    model = fb.planar("R").bind(l1=1.0, lc1=0.5, m1=2.0, I1=0.1)
    return model.with_drive("joint1", **drive) if drive else model


def fine(motion: fb.Motion, times: int = 10) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States between the samples."""
    fractions = (np.arange(times) + 0.5) / times
    return motion.at((motion.t[:-1, None] + fractions * np.diff(motion.t)[:, None]).ravel())


# ---------------------------------------------------------------- one joint
@pytest.mark.parametrize(("way", "speed"), [(1.0, np.inf), (3.0, 1.2)])
def test_a_mass_on_a_rail_is_pushed_and_braked_with_all_force(way: float, speed: float):
    a = 5.0 / 2.0
    top = min(speed, np.sqrt(way * a))
    exact = 2 * top / a + (way - top**2 / a) / top
    limits = {} if np.isinf(speed) else {"velocity": speed}
    motion = fb.time_optimal(slider(), [[0.0], [way]], torque=5.0, **limits)
    assert exact < motion.duration < exact * 1.0002
    assert motion.q[[0, -1], 0] == pytest.approx([0.0, way])
    assert np.abs(motion.qd[[0, -1]]).max() == 0.0
    assert motion.at(0.1 * exact)[2] == pytest.approx(a, rel=3e-4)
    assert motion.at(0.9 * exact)[2] == pytest.approx(-a, rel=3e-4)


def pendulum_duration(start: float, end: float, torque: float, viscous: float, dry: float) -> float:
    """By the two differential equations of all torque forwards and backwards."""
    inertia = 2.0 * 0.5**2 + 0.1

    def rate(sign: float) -> Callable[[float, np.ndarray], list[float]]:
        def right(q: float, x: np.ndarray) -> list[float]:  # x = q̇²
            speed = np.sqrt(max(x[0], 0.0))
            weight = 2.0 * 9.81 * 0.5 * np.cos(q)
            return [2.0 * (sign * torque - weight - dry - viscous * speed) / inertia]

        return right

    given = {"dense_output": True, "rtol": 1e-10, "atol": 1e-12}
    up = solve_ivp(rate(1.0), (start, end), [0.0], **given).sol
    down = solve_ivp(rate(-1.0), (end, start), [0.0], **given).sol
    switch = brentq(lambda q: up(q)[0] - down(q)[0], start, end)

    def time(of: Callable[[float], np.ndarray], rest: float, other: float) -> float:
        # q - rest = ± r², so that 1 / q̇ has no pole
        sign = np.sign(other - rest)
        root = np.sqrt(abs(other - rest))
        return quad(lambda r: 2 * r / np.sqrt(of(rest + sign * r * r)[0]), 1e-7, root)[0]

    return time(up, start, switch) + time(down, end, switch)


@pytest.mark.parametrize(("viscous", "dry"), [(0.0, 0.0), (0.0, 1.5), (3.0, 0.0), (3.0, 1.5)])
def test_a_pendulum_with_friction_is_as_quick_as_its_equation_says(viscous: float, dry: float):
    model = pendulum(viscous=viscous, coulomb=dry)
    exact = pendulum_duration(-1.2, 1.7, 15.0, viscous, dry)
    motion = fb.time_optimal(model, [[-1.2], [1.7]], torque=15.0, points=4001)
    slower = 1.0003 + (0.0006 if viscous else 0.0) + (0.0002 if dry else 0.0)
    assert exact < motion.duration < exact * slower  # on the safe side
    torque = fb.inverse_dynamics(model, *fine(motion))
    assert np.abs(torque).max() < 15.0 * (1 + 5e-4)
    assert np.mean(np.abs(torque) > 14.9) > 0.97


@pytest.mark.parametrize("way", [[[0.0], [1.0]], [[1.0], [0.0]]])
def test_no_friction_helps_to_brake_at_the_very_end(way: list[list[float]]):
    model = slider(coulomb=1.0)
    motion = fb.time_optimal(model, way, torque=5.0)
    ends = fb.inverse_dynamics(model, motion.q, motion.qd, motion.qdd)[[0, -1], 0]
    assert np.abs(ends).max() <= 5.0
    within = fb.inverse_dynamics(model, *fine(motion))[:, 0]
    assert np.mean(np.abs(within) > 5.0 * 0.999) > 0.99  # but everywhere else


def rounded(way: np.ndarray) -> PPoly:
    curve = CubicSpline(np.linspace(0.0, 1.0, len(way)), way)
    curve.c[:-1] -= 1e-16
    return curve


@pytest.mark.parametrize("form", [np.array, rounded])
def test_a_joint_that_does_not_move_along_the_path_feels_no_friction(form: Callable[..., Any]):
    """Rounding of the spline is no motion."""
    way = np.column_stack([WAY, np.full(4, 0.3)])
    model = fb.planar("PPP", lc=[0, 0, 0], m=[1, 1, 1], I=[0, 0, 0]).replace(gravity=0.0)
    model = with_limits(model, velocity=2.0, effort=20.0)
    stuck = model.with_drive("joint3", coulomb=19.9)
    motion = fb.time_optimal(stuck, form(way))
    assert motion.duration == fb.time_optimal(model, form(way)).duration
    q, qd, qdd = fine(motion)
    np.testing.assert_allclose(q[:, 2], 0.3, rtol=1e-15)
    assert not qd[:, 2].any()
    assert not qdd[:, 2].any()


def test_a_weak_motor_lifts_where_the_load_is_light():
    """Held nowhere near the horizontal: with a swing it would pass, from rest on the path not."""
    model = pendulum()  # 9.81 N m when horizontal
    fb.time_optimal(model, [[-1.4], [-0.9]], torque=8.0)
    told = (
        r"^time_optimal: the path cannot be followed: at s = 0\.5\d* \(q = \S+\) joint1 "
        r"needs 9\.81 N m to move slowly, and its largest torque is 8 N m\."
    )
    with pytest.raises(fb.FreebodyError, match=told):
        fb.time_optimal(model, [[-1.0], [0.9]], torque=8.0)


def test_a_stretch_that_cannot_be_held_is_passed_with_a_swing():
    """Falling through the horizontal: the motor is too weak to stop there, and need not."""
    motion = fb.time_optimal(pendulum(), [[0.6], [-1.5]], torque=9.5)
    torque = fb.inverse_dynamics(pendulum(), *fine(motion))
    assert np.abs(torque).max() < 9.5 * 1.001
    assert np.abs(fine(motion)[1][fine(motion)[0][:, 0] < 0.2]).min() >= 0.0


# ---------------------------------------------------------------- several joints
@pytest.mark.parametrize("points", [101, 1001])
def test_limits_are_held_between_the_points_and_reached_at_nearly_all(points: int):
    model = arm().with_drive("joint1", viscous=2.0, coulomb=1.0).with_payload(1.0)
    motion = fb.time_optimal(model, WAY, acceleration=[30.0, 40.0], points=points)
    assert motion.notices == ()
    q, qd, qdd = fine(motion)
    used = np.stack(
        [
            np.abs(fb.inverse_dynamics(model, q, qd, qdd)) / model.limits.effort,
            np.abs(qd) / 2.0,
            np.abs(qdd) / [30.0, 40.0],
        ]
    )
    assert used.max() <= 1.0 + (1e-5 if points == 101 else 0.0)
    assert np.mean(used.max(axis=(0, 2)) > 0.99) > (0.8 if points == 101 else 0.97)
    slower = fb.time_optimal(model, WAY, acceleration=[30.0, 40.0], torque=[120.0, 30.0])
    assert slower.duration > motion.duration or points == 101


@pytest.mark.parametrize("seed", [7, 31])
def test_with_much_viscous_friction_torques_are_held_at_the_points_too(seed: int):
    """Where the first tangents of friction already keep the middle of every interval."""
    rng = np.random.default_rng(seed)
    model = arm().with_drive("joint1", viscous=rng.uniform(1, 6))
    model = model.with_drive("joint2", viscous=rng.uniform(0.5, 4))
    motion = fb.time_optimal(model, rng.uniform(-1.5, 1.5, (4, 2)), points=301)
    assert motion.notices == ()
    t = motion.t
    sides = motion.at(t[1:-1], 0.5 * (t[1:-1] + t[:-2])), motion.at(t[:-1])
    for states in (*sides, fine(motion)):
        used = np.abs(fb.inverse_dynamics(model, *states)) / model.limits.effort
        assert used.max() < 1.0003


@pytest.mark.parametrize("torque", [10.5, 12.0])
def test_viscous_friction_grows_fast_at_a_start_from_rest(torque: float):
    """With the square root of the way: the torque is largest early in the first interval."""
    model = pendulum(viscous=0.3)
    motion = fb.time_optimal(model, [[0.3], [2.5]], torque=torque, points=21)
    assert motion.notices == ()
    assert np.abs(fb.inverse_dynamics(model, *fine(motion))).max() < 1.0005 * torque


@pytest.mark.parametrize("length", [1e-9, 1e9])
def test_the_motion_is_that_of_the_path_whatever_s_is_counted_in(length: float):
    one = CubicSpline([0.0, 0.3, 0.7, 1.0], WAY)
    other = PPoly(one.c / (length ** np.arange(3, -1, -1.0))[:, None, None], one.x * length)
    found, exact = (fb.time_optimal(arm(), path, points=201) for path in (other, one))
    assert found.duration == pytest.approx(exact.duration, rel=1e-9)


def test_no_limit_is_exceeded_as_the_motion_itself_tells():
    motion = fb.time_optimal(arm(), WAY, points=np.int64(101))
    assert fb.exceeded_limits(arm(), motion) == ()
    rng = np.random.default_rng(5)
    for motion in fb.time_optimal(arm(), rng.uniform(-1.0, 1.0, (30, 5, 2)), points=301):
        assert fb.exceeded_limits(arm(), motion) == ()
        torque = np.abs(fb.inverse_dynamics(arm(), motion.q, motion.qd, motion.qdd))
        assert (torque <= arm().limits.effort * (1 + 1e-9)).all()


def test_what_a_motion_exceeds_between_points_is_mended_or_told():
    """Seen at 40 places of each interval, on coarse grids and finer ones; the figure is no less
    than the truth."""
    model = fb.load("elbow_arm")
    ways = np.cumsum(0.1 * np.random.default_rng(0).normal(size=(24, 11, 3)), axis=1)
    still = np.zeros((24 * 11, 3))
    limit = 1.0 + 3.0 * np.abs(fb.inverse_dynamics(model, ways.reshape(-1, 3), still, still)).max(0)
    told = 0
    for points in (61, 251):
        for motion in fb.time_optimal(model, ways, torque=limit, points=points):
            start, length = motion.knots[:-1, None], np.diff(motion.knots)[:, None]
            t = start + length * np.linspace(0.0125, 0.9875, 40)
            state = motion.at(t, np.repeat(start + 0.5 * length, 40, axis=1))
            over = 100.0 * (np.abs(fb.inverse_dynamics(model, *state) / limit).max() - 1.0)
            said = [re.search(r"exceeded by ([\d.e-]+) %;", text) for text in motion.notices]
            assert over <= max((float(found[1]) for found in said if found), default=1e-4)
            told += bool(said)
    assert told == 1


def test_few_points_cost_little_time_and_no_limit():
    """Most of what they cost, if their first and last interval were one, is lost there."""
    ways = np.random.default_rng(8).uniform(-1.2, 1.2, (8, 5, 2))
    exact = [motion.duration for motion in fb.time_optimal(arm(), ways, points=3001)]
    for points, slower in ((21, 0.05), (101, 0.006), (301, 0.0015)):
        motions = fb.time_optimal(arm(), ways, points=points)
        off = np.array([x.duration for x in motions]) / exact - 1.0
        assert off.min() > -1e-5
        assert off.max() < slower
        for motion in motions:
            assert (motion.peaks.velocity.size <= arm().limits.velocity).all()
            assert (np.diff(motion.t) > 0.0).all()
            assert np.diff(motion.t).max() < 0.1 * motion.duration


# ---------------------------------------------------------------- joints that follow others
HOIST = """
name = "hoist"
dim = 2
gravity = [0, -9.81]
link = [
  { name = "base" }, { name = "upper", mass = 3, com = [0.4, 0], inertia = 0.2 },
  { name = "fore", mass = 2, com = [0.3, 0], inertia = 0.1 },
]
[[joint]]
name = "shoulder"
kind = "revolute"
parent = "base"
child = "upper"
limits = { velocity = 3, effort = 300 }
[[joint]]
name = "elbow"
kind = "revolute"
parent = "upper"
child = "fore"
origin = [0.8, 0]
limits = { velocity = 10, effort = 12 }
friction = { viscous = 0.4, coulomb = 0.5 }
mimic = { joint = "shoulder", ratio = -2, offset = 0.2 }
"""


def test_a_follower_is_held_within_its_own_limit():
    """What reaches it, by the robot whose joints are all free: at its limit, and not beyond it
    between the points either."""
    model = fb.load(text=HOIST, format="toml")
    free = fb.load(text=HOIST, format="toml", mimic="free")
    motion = fb.time_optimal(model, [[0.1], [1.9]], wrenches={"fore": [0.0, -3.0, 0.0]})
    q, qd, qdd = fine(motion)
    states = np.hstack([q, 0.2 - 2.0 * q]), np.hstack([qd, -2.0 * qd]), np.hstack([qdd, -2.0 * qdd])
    tau = fb.inverse_dynamics(free, *states, {"fore": [0.0, -3.0, 0.0]})
    at_elbow = np.abs(tau[:, 1]) / 12.0
    assert at_elbow.max() == pytest.approx(1.0, abs=1e-3)
    assert at_elbow.max() < 1.0 + 1e-5
    fastest = np.abs(qd).max() / 3.0
    assert fastest < 1.0 + 1e-3
    # at each instant something is at its limit, but at rest, where no friction helps to brake
    shoulder = np.abs(fb.inverse_dynamics(model, q, qd, qdd, {"fore": [0, -3, 0]})[:, 0]) / 300.0
    most = np.maximum.reduce([at_elbow, shoulder, np.abs(qd[:, 0]) / 3.0])
    assert np.quantile(most, 0.05) > 0.99
    slow = model.bind({"elbow.limits.velocity": 4.0})
    for planned in (
        fb.time_optimal(slow, [[0.1], [1.9]]),
        fb.trapezoid(slow, [[0.1], [1.9]], acceleration=20.0),
    ):
        assert planned.peaks.velocity.size == pytest.approx([4.0 / 2.0], rel=1e-3)
    weak = model.bind({"elbow.limits.effort": 4.0})
    with pytest.raises(fb.FreebodyError, match=r"elbow needs \S+ N m to move slowly"):
        fb.time_optimal(weak, [[0.1], [1.9]])


def test_the_path_is_followed_and_the_motion_is_its_own_derivative():
    motion = fb.time_optimal(arm(), WAY, points=301)
    chords = np.linalg.norm(np.diff(WAY, axis=0), axis=1)
    s = np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
    path = CubicSpline(s, WAY, bc_type="natural")
    places = np.array([np.abs(motion.q - point).max(axis=1).min() for point in WAY])
    assert places.max() < 1e-12  # waypoints are points of the grid
    q = fine(motion, 4)[0]
    near = path(np.linspace(0, 1, 20001))
    assert np.abs(q[:, None, :] - near[None, ::10]).max(axis=2).min(axis=1).max() < 2e-3
    t = 0.5 * (motion.t[:-1] + motion.t[1:])
    step = 1e-5
    before, after = motion.at(t - step), motion.at(t + step)
    assert (after[0] - before[0]) / (2 * step) == pytest.approx(motion.at(t)[1], abs=1e-6)
    assert (after[1] - before[1]) / (2 * step) == pytest.approx(motion.at(t)[2], rel=1e-4, abs=1e-4)
    for given, found in zip((motion.q, motion.qd, motion.qdd), motion.at(motion.t), strict=True):
        assert found == pytest.approx(given, abs=1e-9)


def test_a_wrench_and_a_payload_count():
    free = fb.time_optimal(arm(), WAY, points=201)
    loaded = fb.time_optimal(arm().with_payload(2.0), WAY, points=201)
    pulled = fb.time_optimal(arm(), WAY, wrenches=[0.0, -30.0, 0.0], points=201)
    assert min(loaded.duration, pulled.duration) > 1.01 * free.duration
    torque = fb.inverse_dynamics(arm(), *fine(pulled), wrenches=[0.0, -30.0, 0.0])
    assert (np.abs(torque) / arm().limits.effort).max() < 1.001


def test_springs_and_rotors_count():
    model = arm().with_drive("joint1", stiffness=40.0, rest=0.8, rotor=2.0)
    q, qd, qdd = fine(fb.time_optimal(model, WAY, points=201))
    torque = np.abs(fb.inverse_dynamics(model, q, qd, qdd)) / model.limits.effort
    used = np.maximum(torque, np.abs(qd) / 2.0)
    assert torque.max() < 1.001
    assert np.mean(used.max(axis=-1) > 0.99) > 0.9


def test_speeds_alone_may_be_limited():
    motion = fb.time_optimal(fb.load("2R"), [[0.0, 0.0], [1.0, 0.5]], velocity=[2.0, 1.5])
    assert motion.duration == pytest.approx(0.5, rel=1e-4)


def test_many_paths_are_what_each_is_alone():
    rng = np.random.default_rng(2)
    ways = rng.uniform(-1.2, 1.2, (19, 5, 2))
    model = arm().with_drive("joint1", viscous=3.0).with_drive("joint2", viscous=4.0)
    together = fb.time_optimal(model, ways, points=151)
    assert isinstance(together, tuple)
    assert len(together) == 19
    for k in (0, 7, 16, 18):
        assert together[k] == fb.time_optimal(model, ways[k], points=151)
    curve = CubicSpline([0.0, 0.3, 0.7, 1.0], WAY)
    both = fb.time_optimal(arm(), [fb.spline(arm(), WAY), curve], points=201)
    assert both[1] == fb.time_optimal(arm(), curve, points=201)
    assert both[0].duration == pytest.approx(both[1].duration, rel=0.2)


def test_a_changed_robot_has_limits_of_its_own():
    """What is found of a model is kept with it, not with what is made from it."""
    before = fb.time_optimal(arm(), WAY, points=101)
    slow = with_limits(arm(), velocity=0.5)
    dry = arm().with_drive("joint1", coulomb=60.0).with_drive("joint1", coulomb=70.0)
    for model in (slow, dry):
        assert fb.time_optimal(model, WAY, points=101).duration > 1.05 * before.duration
    assert fb.time_optimal(arm(), WAY, points=101) == before


def test_a_finer_path_is_as_quick_as_its_spline():
    """The positions of a motion along it are the path, whatever its timing."""
    slow = fb.spline(arm(), WAY, ends="natural", degree=3)
    reference = fb.time_optimal(arm(), slow.curve._pieces, points=2001)
    assert fb.time_optimal(arm(), slow).duration == pytest.approx(reference.duration, rel=2e-3)
    rest = fb.quintic(arm(), WAY[:2])
    assert fb.time_optimal(arm(), rest).duration == pytest.approx(
        fb.time_optimal(arm(), WAY[:2]).duration, rel=1e-3
    )


def test_the_command_plans_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = tmp_path / "motion.csv"
    limits = ["--velocity", "2", "--acceleration", "9"]
    way = "0, 0; 1, -0.5; 0.4, 1"
    assert run(["plan", "2R", way, "--by", "time-optimal", *limits, "--out", str(file)]) == 0
    assert "the quickest along a path within the limits" in capsys.readouterr().out
    model = fb.load("2R")
    planned = fb.time_optimal(model, [[0, 0], [1, -0.5], [0.4, 1]], velocity=2.0, acceleration=9.0)
    assert fb.read_motion(model, file).duration == pytest.approx(planned.duration)
    (tmp_path / "way.csv").write_text("t,joint1,joint2\n0,0,0\n1,1,1\n")
    assert run(["plan", "2R", str(tmp_path / "way.csv"), "--by", "time-optimal"]) == 2
    assert "the times of waypoints are what it finds" in capsys.readouterr().err


# ---------------------------------------------------------------- beside toppra
def toppra_duration(model: fb.Model, path: CubicSpline, points: int, effort: np.ndarray) -> float:
    """With limits at both ends of each interval, on an even grid that is finer at rest."""
    toppra = extra("toppra")
    algorithm, limits = extra("toppra.algorithm"), extra("toppra.constraint")
    toppra.setup_logging("ERROR")
    scheme = {"discretization_scheme": limits.DiscretizationType.Interpolation}
    speed, torque = (np.stack([-x, x], axis=-1) for x in (model.limits.velocity, effort))
    friction, even = np.zeros(model.nv), np.linspace(0.0, 1.0, points)
    start = even[1] * (np.arange(1, 10) / 10) ** 2
    s = np.concatenate([even[:1], start, even[1:-1], 1.0 - start[::-1], even[-1:]])
    problem = algorithm.TOPPRA(
        [
            limits.JointVelocityConstraint(speed),
            limits.JointTorqueConstraint(
                lambda q, v, a: fb.inverse_dynamics(model, q, v, a), torque, friction, **scheme
            ),
        ],
        toppra.SplineInterpolator(path.x, path(path.x), bc_type="natural"),
        gridpoints=s,
    )
    _, speeds, _ = problem.compute_parameterization(0, 0)
    return float(np.sum(2.0 * np.diff(s) / (speeds[1:] + speeds[:-1])))


def compared(model: fb.Model, count: int, points: int, seed: int) -> np.ndarray:
    """(count, 2): durations relative to toppra's, and torques on a ten times finer check."""
    rng = np.random.default_rng(seed)
    low, high = np.maximum(model.limits.lower, -2.5), np.minimum(model.limits.upper, 2.5)
    knots = np.linspace(0.0, 1.0, 6)
    rows = []
    while len(rows) < count:
        way = 0.5 * (low + high) + 0.3 * (high - low) * rng.uniform(-1, 1, (6, model.nq))
        path = CubicSpline(knots, way, bc_type="natural")
        if (np.abs(path(np.linspace(0, 1, 200)) - 0.5 * (low + high)) > 0.5 * (high - low)).any():
            continue
        motion = fb.time_optimal(model, path, points=points)
        torque = np.abs(fb.inverse_dynamics(model, *fine(motion))) / model.limits.effort
        other = toppra_duration(model, path, points, model.limits.effort)
        rows.append([motion.duration / other, torque.max()])
    return np.array(rows)


def test_durations_are_those_of_toppra():
    found = compared(arm(), 6, 501, 3)
    assert found[:, 0] == pytest.approx(1.0, abs=1e-3)
    assert found[:, 1].max() < 1.001


@pytest.mark.long
@pytest.mark.parametrize("name", ["ur5e", "panda", "iiwa14"])
def test_durations_and_torques_of_large_arms(name: str):
    model = fb.load(name).without("friction")
    found = compared(model, 200, 1001, 7)
    assert found[:, 0] == pytest.approx(1.0, abs=1e-3)
    assert found[:, 1].max() < 1.001
    coarse = [fine(fb.time_optimal(model, path, points=101)) for path in paths(model, 200)]
    torque = [(np.abs(fb.inverse_dynamics(model, *x)) / model.limits.effort).max() for x in coarse]
    assert np.quantile(torque, 0.99) < 1.005


def paths(model: fb.Model, count: int) -> list[CubicSpline]:
    rng = np.random.default_rng(11)
    low, high = np.maximum(model.limits.lower, -2.5), np.minimum(model.limits.upper, 2.5)
    way = 0.5 * (low + high) + 0.2 * (high - low) * rng.uniform(-1, 1, (count, 6, model.nq))
    return [CubicSpline(np.linspace(0.0, 1.0, 6), one, bc_type="natural") for one in way]


# ---------------------------------------------------------------- refused
CURVE = CubicSpline([0.0, 0.3, 0.7, 1.0], WAY)
STEP = PPoly([[[0.0, 0.0], [0.0, 0.0]], [[1.0, 0.0], [1.0, 1.0]]], [0.0, 1.0, 2.0])
DWELL = PPoly(
    [
        [[-2.0, 0.0], [0.0, 0.0], [-2.0, 0.0]],
        [[3.0, 0.0], [0.0, 0.0], [3.0, 0.0]],
        [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]],
    ],
    [0.0, 1.0, 2.0, 3.0],
)
"""Smooth, with a pause."""
TURNS = CubicSpline([0.0, 0.1, 0.2, 1.0], [[0.0], [1.0], [0.9], [2.0]], bc_type="natural")
REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: fb.time_optimal(arm(), WAY[:1]), "expected at least two rows: (k, 2)"),
    (lambda: fb.time_optimal(arm(), [[0.3, 0.3]] * 3), "3 positions, all the same"),
    (
        lambda: fb.time_optimal(arm(), [[0.0, np.nan], [1, 1]]),
        "path is nan at sample 0 for 'joint2'",
    ),
    (lambda: fb.time_optimal(arm(), np.zeros((3, 5))), "time_optimal: path has shape (3, 5)"),
    (
        lambda: fb.time_optimal(arm(), []),
        "time_optimal: path has shape (0,), expected (..., 2)",
    ),
    (
        lambda: fb.time_optimal(arm(), [WAY, [[0, 0], [1, 1], [np.nan, 1], [1, 2]]]),
        "time_optimal: path 1 is nan at sample 2 for 'joint1'",
    ),
    (
        lambda: fb.time_optimal(
            with_limits(arm(), lower=-2.0, upper=2.0), [WAY, 5 * np.array(WAY)]
        ),
        "waypoint 1 of path 1 has joint1 at 5, outside its range",
    ),
    (lambda: fb.time_optimal(arm(), [CURVE, STEP]), "path 1 jumps at s = 1: itself of joint2 by 1"),
    (lambda: fb.time_optimal(arm(), WAY, points=1), "points is 1, expected a whole number from 2"),
    (lambda: fb.time_optimal(arm(), WAY, points=9.5), "points is 9.5, expected a whole number"),
    (lambda: fb.time_optimal(arm(), WAY, torque=-1.0), "torque of joint1 is -1, expected a limit"),
    (lambda: fb.time_optimal(arm(), WAY, torque=np.ones(3)), "torque has shape (3,)"),
    (lambda: fb.time_optimal(arm(), WAY, acceleration={"joint1": 1.0}), "acceleration lacks"),
    (lambda: fb.time_optimal(fb.load("2R"), WAY), "has no quickest motion: at s = 0"),
    (
        lambda: fb.time_optimal(arm(), PPoly([[[0.0, 0.0]], [[1.0, 2.0]]], [0.0, 1.0])),
        "the path does not move",
    ),
    (lambda: fb.time_optimal(arm(), DWELL), "stands still at s = 1"),
    (
        lambda: fb.time_optimal(slider(), TURNS, torque=5.0, points=8),
        "between points of the grid the path exceeds a limit by",
    ),
    (lambda: fb.time_optimal(arm(), STEP), "the path jumps at s = 1: itself of joint2 by 1"),
    (
        lambda: fb.time_optimal(arm(), PPoly([[[1.0]], [[0.0]]], [0.0, 1.0])),
        "the path has values of shape (1,), expected (2,)",
    ),
    (
        lambda: fb.time_optimal(arm(), WAY, wrenches=np.zeros((5, 3))),
        "wrenches['tip'] has shape (5, 3), expected (3,): one wrench",
    ),
    (lambda: fb.time_optimal(arm(), WAY, wrenches=[0, np.inf, 0]), "wrenches['tip'] is inf"),
    (lambda: fb.time_optimal(fb.load("quadrotor"), np.zeros((2, 7))), "positions are quaternions"),
    (
        lambda: fb.time_optimal(arm().replace(actuated=["joint1"]), WAY),
        "nothing drives joint2 of '2R'",
    ),
    (
        lambda: fb.time_optimal(with_limits(arm(), lower=-1.005, upper=1.005), WAY),
        "is at 1.0",
    ),
    (
        lambda: fb.time_optimal(arm(), WAY, torque=[3.0, 25.0]),
        "joint1 needs",
    ),
    (
        lambda: fb.time_optimal(arm().with_drive("joint1", coulomb=90.0), WAY),
        "joint1 needs",
    ),
]


@pytest.mark.parametrize(("call", "told"), REFUSED, ids=[told for _, told in REFUSED])
def test_what_cannot_be_is_refused_with_what_to_do(call: Callable[[], object], told: str):
    with pytest.raises(fb.FreebodyError, match=re.escape(told)):
        call()


@pytest.mark.parametrize(
    ("inertia", "viscous", "coulomb", "torque"),
    [
        (1e-3, 3.0, 10.0, 15.0),
        (1e-2, 10.0, 1.0, 20.0),
        (0.1, 3.0, 10.0, 15.0),
        (0.1, 3.0, 0.0, 15.0),
    ],
)
def test_strong_friction_holds_a_light_joint_at_the_speed_that_the_drive_keeps_up(
    inertia: float, viscous: float, coulomb: float, torque: float
):
    """One joint without gravity: full torque forward, then backward, each an exponential. Friction
    at the speed limit would be above the drive's torque."""
    arm = fb.planar("R").bind(l1=0.04, lc1=0.02, m1=0.03, I1=inertia, g=0.0)
    arm = arm.with_drive("joint1", viscous=viscous, coulomb=coulomb)
    found = fb.time_optimal(arm, [[0.0], [1.0]], velocity=7.0, torque=torque)
    time = (inertia + 0.03 * 0.02**2) / viscous
    kept, against = (torque - coulomb) / viscous, (torque + coulomb) / viscous

    def stop(speed: float) -> tuple[float, float]:
        t = time * np.log1p(speed / against)
        return t, time * speed - against * t

    def start(speed: float) -> tuple[float, float]:
        t = -time * np.log1p(-speed / kept)
        return t, kept * t - time * speed

    def left(speed: float) -> float:
        return 1.0 - start(speed)[1] - stop(speed)[1]

    # nearly the speed that is kept up: how nearly does not matter to the time
    most = kept * (1.0 - 1e-14)
    top = most if left(most) > 0.0 else brentq(left, 0.0, most)
    way = left(top)
    expected = start(top)[0] + stop(top)[0] + way / top
    assert found.duration == pytest.approx(expected, rel=2e-3)


@pytest.mark.skipif(not real_files.FILES, reason="needs example-robot-data")
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_a_hand_whose_motors_have_much_friction_keeps_its_limits():
    (file,) = real_files.ROBOTS.glob("allegro*/**/allegro_right_hand.urdf")
    hand = fb.load(file)
    ends = fb.random_state(hand, 3, 16)[0].reshape(8, 2, hand.nq)
    for path in ends:
        motion = fb.time_optimal(hand, path)
        used = np.abs(fb.inverse_dynamics(hand, *fine(motion))) / hand.limits.effort
        assert used.max() < 1.0005
        speed = np.abs(fine(motion)[1]) / hand.limits.velocity
        assert max(used.max(), speed.max()) > 0.99
