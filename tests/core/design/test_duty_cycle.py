"""Duty cycles and what they ask of given drives: closed forms, freebody's own dynamics of the robot
with its drives, energy, and refusals."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")

MOTOR = fb.Motor(
    "M", inertia=2e-4, continuous_torque=2.0, peak_torque=6.0, max_speed=400.0, mass=1.2,
    torque_constant=0.1,
)  # fmt: skip
GEAR = fb.Gear(
    "G", efficiency=0.8, inertia=1e-4, mass=0.8, ratio=50.0, kind="strain wave", peak_torque=200.0,
    rated_torque=100.0, rated_speed=200.0, rated_life=7000.0,
)  # fmt: skip
SCREW = fb.Gear("S", efficiency=0.9, inertia=1e-5, mass=1.0, lead=0.01)


def swing(model: fb.Model, size: float = 1.0, seconds: float = 1.0) -> fb.Motion:
    """There and back, at rest in between."""
    q = np.full(model.nq, 0.3)
    return fb.quintic(model, [q, q + size, q], [0.0, seconds, 2.0 * seconds])


def test_a_pendulum_by_its_closed_form():
    """m g l cos q + m l² q̈ behind the gear; its rest hangs with no losses."""
    m, l = 2.0, 0.5
    model = fb.planar("R").bind(l1=1.0, m1=m, lc1=l, I1=0.0)
    motion = swing(model)
    found = fb.drive_loads(
        model, fb.Segment(motion, dwell=3.0), {model.joint_names[0]: (MOTOR, GEAR)}
    )
    q, qd, qdd = (x[:, 0] for x in (motion.q, motion.qd, motion.qdd))
    weight = float(np.abs(model.gravity).max())
    load = m * weight * l * np.cos(q) + m * l**2 * qdd
    eta, back, N, J = 0.8, 2.0 - 1.0 / 0.8, 50.0, 3e-4
    k = np.where(load * qd > 0, 1.0 / eta, np.where(load * qd < 0, back, 1.0))
    motor = k * load / N + J * N * qdd
    got = found.data["motor_torque"].values[:, 0]
    assert got[:-1] == pytest.approx(motor, abs=1e-12)
    rest = m * weight * l * math.cos(0.3) / N
    assert got[-1] == pytest.approx(rest)
    of = found.summary.isel(cycle=0, joint=0)
    square = np.trapezoid(motor**2, motion.t) + 3.0 * rest**2
    assert float(of.rms_motor_torque) == pytest.approx(math.sqrt(square / 5.0))
    assert float(of.rms_motor_current) == pytest.approx(10.0 * math.sqrt(square / 5.0))
    assert float(of.mean_motor_speed) == pytest.approx(N * 2.0 / 5.0, rel=1e-4)
    mean = np.trapezoid(np.abs(qd * load**3), motion.t) / np.trapezoid(np.abs(qd), motion.t)
    assert float(of.mean_gear_torque) == pytest.approx(mean ** (1 / 3))
    life = GEAR.life(float(mean ** (1 / 3)), float(of.mean_motor_speed))
    assert float(of.gear_life) == pytest.approx(life)
    share = found.uses.sel(limit="continuous torque").item()
    assert share == pytest.approx(float(of.rms_motor_torque) / 2.0)
    assert found.margin == pytest.approx(1.0 / float(found.uses.max()))


def test_motors_give_what_the_robot_with_its_drives_needs():
    """The motors' torques are inverse dynamics of the model that carries them, with friction,
    payload and wrenches."""
    arm = fb.load("ur5e").with_drive("elbow_joint", viscous=3.0, coulomb=2.0)
    pairs = dict.fromkeys(arm.joint_names, (MOTOR, GEAR))
    wrench = np.linspace(-20.0, 30.0, 401 * 6).reshape(401, 6)
    segment = fb.Segment(
        swing(arm), {"mass": 3.0, "com": [0, 0.02, 0.1]}, {"wrist_3_link": wrench}, dwell=0.5
    )
    found = fb.drive_loads(arm, fb.DutyCycle([segment, fb.Segment(swing(arm))]), pairs)
    rates = [np.ptp(segment.motion.qd), len(segment.motion.t)]
    assert rates[0] > 1.0
    assert rates[1] == 401
    loaded = found.model.with_payload(3.0, com=[0, 0.02, 0.1])
    motion = segment.motion
    state = motion.q, motion.qd, motion.qdd
    tau = fb.inverse_dynamics(loaded, *state, {"wrist_3_link": wrench})
    tau = np.concatenate(
        [tau, fb.static_torque(loaded, motion.q[-1:], {"wrist_3_link": wrench[-1]})]
    )
    tau = np.concatenate([tau, fb.inverse_dynamics(found.model, *state)])
    got = 50.0 * found.data["motor_torque"].values
    assert np.abs(got - tau).max() < 1e-11 * np.abs(tau).max()
    assert found.model.mass == pytest.approx(arm.mass + 5 * 2.0)  # the first rides on the ground


def test_a_study_of_the_robot_with_its_drives_judges_them():
    """Its joints have the limits of the motors, and of speed no more than before."""
    arm = fb.load("ur5e").bind({"elbow_joint.limits.velocity": 1.0})
    pairs = dict.fromkeys(arm.joint_names, (MOTOR, GEAR))
    cycle = fb.DutyCycle([fb.Segment(swing(arm, 0.1))])
    fitted = fb.drive_loads(arm, cycle, pairs).model
    assert fitted.limits.effort == pytest.approx(50.0 * MOTOR.peak_torque)
    slowest = np.minimum(arm.limits.velocity, MOTOR.max_speed / 50.0)
    assert fitted.limits.velocity == pytest.approx(slowest)
    assert fitted.limits.velocity[2] == 1.0
    assert np.array_equal(fitted.limits.lower, arm.limits.lower)


def test_the_energy_of_a_cycle_without_losses_comes_back():
    arm = fb.load("2R")
    ideal = fb.Gear("I", efficiency=1.0, inertia=1e-4, mass=0.0, ratio=30.0)
    found = fb.drive_loads(
        arm.without("friction"), swing(arm), dict.fromkeys(arm.joint_names, (MOTOR, ideal))
    )
    work, braking = (found.summary[x].sum().item() for x in ("motor_work", "motor_braking"))
    assert work == pytest.approx(braking, rel=1e-3)
    real = fb.drive_loads(arm, swing(arm), dict.fromkeys(arm.joint_names, (MOTOR, GEAR)))
    assert real.summary["motor_work"].sum() > 1.2 * real.summary["motor_braking"].sum()


def test_a_gear_loses_in_the_direction_in_which_power_flows():
    """A weight is lifted slowly for m g h/η, and gives m g h η' as it sinks."""
    arm = fb.planar("R", l=[1.0], lc=[0.5], m=[2.0], I=[0.0])
    gear = fb.Gear("L", efficiency=0.8, back_efficiency=0.5, inertia=0.0, mass=0.0, ratio=40.0)
    light = fb.Motor("M", 0.0, 5.0, 15.0, 400.0, 0.0)
    up, down = (fb.quintic(arm, x, [0.0, 300.0]) for x in ([[0.0], [1.0]], [[1.0], [0.0]]))
    (name,) = arm.joint_names
    height = 0.5 * math.sin(1.0)
    found = fb.drive_loads(arm, [up, down], {name: (light, gear)}).summary
    work, braking = (found[x].values[:, 0] for x in ("motor_work", "motor_braking"))
    assert work == pytest.approx([2.0 * 9.81 * height / 0.8, 0.0], rel=1e-5, abs=1e-9)
    assert braking == pytest.approx([0.0, 2.0 * 9.81 * height * 0.5], rel=1e-5, abs=1e-9)


def test_each_cycle_counts_by_itself():
    """Two cycles have the RMS values of each, and the larger is used of the limit."""
    arm = fb.load("2R")
    pairs = dict.fromkeys(arm.joint_names, (MOTOR, GEAR))
    slow, fast = swing(arm, 0.5, 2.0), swing(arm, 1.0, 0.6)
    both = fb.drive_loads(arm, [slow, fast], pairs)
    for k, motion in enumerate((slow, fast)):
        alone = fb.drive_loads(arm, motion, pairs)
        for name, x in alone.summary.items():
            assert both.summary[name].values[k] == pytest.approx(x.values[0], rel=1e-12)
    rms = both.summary["rms_motor_torque"].max("cycle").values
    assert both.uses.sel(limit="continuous torque").values == pytest.approx(rms / 2.0)


def test_loaded_there_empty_back_is_the_sum_of_both():
    arm = fb.load("2R")
    pairs = dict.fromkeys(arm.joint_names, (MOTOR, GEAR))
    q = np.array([0.1, 0.4])
    there, back = (fb.quintic(arm, points, [0.0, 1.0]) for points in ([q, q + 1.0], [q + 1.0, q]))
    cycle = fb.DutyCycle((fb.Segment(there, payload=4.0, dwell=1.0), fb.Segment(back)))
    assert cycle.duration == pytest.approx(3.0)
    assert cycle.closes
    whole = fb.drive_loads(arm, cycle, pairs)
    parts = [fb.drive_loads(arm, segment, pairs) for segment in cycle.segments]
    assert "ends elsewhere" not in " ".join(whole.notices)
    assert "ends elsewhere than it begins" in parts[0].notices[0]
    for name in ("motor_work", "motor_braking"):
        total = sum(part.summary[name].values for part in parts)
        assert whole.summary[name].values == pytest.approx(total)
    square = sum(
        part.summary["rms_motor_torque"].values ** 2 * segment.duration
        for part, segment in zip(parts, cycle.segments, strict=True)
    )
    assert whole.summary["rms_motor_torque"].values ** 2 * 3.0 == pytest.approx(square)
    assert whole.summary["gear_life"].values[0].min() > 0.0


def test_a_closed_chain_and_a_screw():
    """A five-bar's drives feel its own dynamics; a screw turns 2π for each lead."""
    model = fb.load("five_bar")
    pairs = dict.fromkeys(model.driven_names, (MOTOR, GEAR))
    home = fb.assemble(model)[list(model.driven)]
    motion = fb.quintic(model, [home, home + 0.2, home], [0.0, 0.5, 1.0])
    found = fb.drive_loads(model, motion, pairs)
    state = motion.q, motion.qd, motion.qdd
    tau = fb.inverse_dynamics(found.model, *state)[:, list(model.driven)]
    ideal = found.data["gear_torque"].values + 3e-4 * 2500.0 * motion.qdd[:, list(model.driven)]
    assert ideal == pytest.approx(tau, abs=1e-9 * np.abs(tau).max())
    slide = fb.planar("P").bind(m1=3.0, lc1=0.0, I1=0.0)
    lift = fb.quintic(slide, [[0.1], [0.4], [0.1]], [0.0, 1.0, 2.0])
    screw = fb.drive_loads(slide, lift, {slide.joint_names[0]: (MOTOR, SCREW)})
    speed = screw.data["motor_speed"].values[:, 0]
    assert speed == pytest.approx(lift.qd[:, 0] * 2.0 * math.pi / 0.01)
    with pytest.raises(fb.FreebodyError, match="'joint1' slides, and this gear has a ratio"):
        fb.drive_loads(slide, lift, {slide.joint_names[0]: (MOTOR, GEAR)})


CYCLE = """
[[segment]]
motion = "there.csv"
payload = { mass = 4, com = [0.1, 0] }
dwell = 0.5

[[segment]]
points = [[1.1, "30 deg"], [0.1, 0.4]]
times = [0, 1]
wrench = [{ frame = "tcp", force = [0, -5] }]
"""


def test_a_cycle_from_a_file(tmp_path: Path):
    arm = fb.load("2R")
    there = fb.quintic(arm, [[0.1, 0.4], [1.1, math.radians(30.0)]], [0.0, 1.0])
    fb.write_motion(arm, there, tmp_path / "there.csv")
    text = CYCLE.replace("tcp", arm.tip or "")
    (tmp_path / "cycle.toml").write_text(text)
    cycle = fb.DutyCycle.read(arm, tmp_path / "cycle.toml")
    assert cycle.duration == pytest.approx(2.5)
    assert cycle.segments[0].payload == {"mass": 4.0, "com": [0.1, 0.0]}
    assert cycle.segments[1].wrenches[arm.tip] == pytest.approx([0.0, -5.0, 0.0])
    assert cycle.closes
    assert "2 segments in 2.5 s; cycle.toml" in repr(cycle)
    for old, new, words in (
        ("dwell = 0.5", "dwell = -1", "dwell is -1 s, expected 0 or more"),
        ("mass = 4,", "", "payload: mass is missing"),
        ("there.csv", "nowhere.csv", "there is no such file"),
        ('[1.1, "30 deg"]', "[1.1, 0.7]", "segment 2 begins with 0.7"),
        ("times = [0, 1]", "times = [0]", "times has 1 entry, expected 2"),
        ("force", "forces", "no key 'forces'"),
        (f'frame = "{arm.tip}"', 'frame = "hand"', "no frame 'hand'"),
        ('motion = "there.csv"', "", "give the file of a motion"),
    ):
        assert old in text
        (tmp_path / "cycle.toml").write_text(text.replace(old, new, 1))
        with pytest.raises(fb.FileError, match=re.escape(words)):
            fb.DutyCycle.read(arm, tmp_path / "cycle.toml")


def by_places(file: Path, first: str, second: str) -> str:
    """The text of a cycle there and back, which is written to a file."""
    there, back = (f"tip = [[{a}], [{b}]]" for a, b in ((first, second), (second, first)))
    text = "".join(f"[[segment]]\n{tip}\ntimes = [0, 1]\n" for tip in (there, back))
    file.write_text(text)
    return text


def test_a_cycle_by_places_of_the_tip(tmp_path: Path):
    """The tip is there at the ends of both segments, with the orientation where one is given."""
    robot, file = fb.load("scara"), tmp_path / "cycle.toml"
    second = '0.2, -0.3, 0.55, "180 deg", 0, 0.4'
    text = by_places(file, "0.3, 0.2, 0.6", second)
    cycle = fb.DutyCycle.read(robot, file)
    assert cycle.closes
    there, back = (fb.forward_kinematics(robot, x.motion.q[-1]) for x in cycle.segments)
    assert there[:3, 3] == pytest.approx([0.2, -0.3, 0.55], abs=1e-9)
    assert there[:2, 0] == pytest.approx([math.cos(0.4), math.sin(0.4)])
    assert back[:3, 3] == pytest.approx([0.3, 0.2, 0.6], abs=1e-9)
    for old, new, words in (
        (second, "3, 0, 0.6", "brings the tip to place 2: it is 2"),
        (second, "0.2, 0.3, 0.3", "joint3 at 0.377 is beyond its own"),
        ("tip =", "points =", "points[0] has 3 entries, expected 4: "),
        ("tip =", "#", "or places of the tip"),
        ("times", "points = []\ntimes", "and one of these"),
        (second, "0.1", "tip[1] has 1 entry, expected"),
    ):
        file.write_text(text.replace(old, new, 1))
        with pytest.raises(fb.FileError, match=re.escape(words)):
            fb.DutyCycle.read(robot, file)


WIDE = {"b": 0.7, "l1": 0.5, "l2": 0.5, "l3": 0.7, "l4": 0.7}
LOW = '[home]\ntheta1 = "-150 deg"\ntheta2 = "-70 deg"\nB = "110 deg"\nD = "-90 deg"\n'


@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("numbers", "home", "first", "second"),
    [
        # the tip is below the line of its pins, at home above it
        pytest.param(WIDE, "", "-0.15, 0.4", "0.15, 0.4", id="closed in another way than at home"),
        pytest.param({}, "", "0.1, 0.7", "0.2, 0.6", id="near home"),
        pytest.param({"h": 0.3}, "", "-0.15, 0.6", "0.15, 0.6", id="motors at unlike heights"),
        pytest.param({}, LOW, "-0.15, -0.6", "0.15, -0.6", id="below"),
        # D makes a whole turn more than an arctangent tells
        pytest.param({}, "", "-0.5, 0.3", "0.5, 0.3", id="far"),
    ],
)
def test_a_closed_chain_by_places_of_its_tip(
    numbers: dict[str, float], home: str, first: str, second: str, tmp_path: Path
):
    given = "".join(f"{name} = {x}\n" for name, x in numbers.items())
    text = f'[template]\nname = "five_bar"\n[template.numbers]\n{given}{home}'
    robot, file = fb.load(text=text, format="toml"), tmp_path / "cycle.toml"
    by_places(file, first, second)
    cycle = fb.DutyCycle.read(robot, file)
    assert cycle.closes
    for segment, place in zip(cycle.segments, (second, first), strict=True):
        there = pytest.approx([float(x) for x in place.split(",")], abs=1e-9)
        for pinned in ("P", "P4"):
            assert fb.forward_kinematics(robot, segment.motion.q[-1], pinned)[:2, 2] == there


def test_rates_that_jump_are_told():
    """At 1 rad/s out and at 1 rad/s back: the torque of turning at once is in no sample."""
    model = fb.planar("R").bind(l1=1.0, m1=2.0, lc1=0.5, I1=0.0)
    t = np.linspace(0.0, 1.0, 11)
    there, back = (
        fb.Motion.of(model, t, x[:, None], np.full((11, 1), s), np.zeros((11, 1)))
        for x, s in ((t, 1.0), (1.0 - t, -1.0))
    )
    cycle = fb.DutyCycle([fb.Segment(there), fb.Segment(back, dwell=1.0)])
    assert [words[:35] for words in cycle.jumps] == [
        "Behind segment 1 qd[0] jumps by 2: ", "Behind segment 2 qd[0] jumps by 1: "
    ]  # fmt: skip
    (joint,) = model.joint_names
    assert set(cycle.jumps) < set(fb.drive_loads(model, cycle, {joint: (MOTOR, GEAR)}).notices)
    assert fb.DutyCycle([swing(model)]).jumps == ()


def test_what_is_refused():
    arm = fb.load("2R")
    motion = swing(arm)
    with pytest.raises(fb.FreebodyError, match=re.escape("segment 1 ends with q[0] = 0.3")):
        fb.DutyCycle((motion, fb.quintic(arm, [[0, 0], [1, 1]], [0, 1])))  # type: ignore[arg-type]
    with pytest.raises(fb.KindError, match="a pair"):
        fb.drive_loads(arm, motion, {"joint1": MOTOR})  # type: ignore[dict-item]
    with pytest.raises(fb.UnknownNameError, match="elbow"):
        fb.drive_loads(arm, motion, {"elbow": (MOTOR, GEAR)})
    with pytest.raises(fb.FreebodyError, match="one for each of the 401 samples"):
        fb.drive_loads(
            arm, fb.Segment(motion, wrenches=np.zeros((7, 3))), {"joint1": (MOTOR, GEAR)}
        )
    with pytest.raises(fb.FreebodyError, match="payload has arrays of numbers"):
        fb.drive_loads(arm, fb.Segment(motion, {"mass": [1.0, 2.0]}), {"joint1": (MOTOR, GEAR)})
    with pytest.raises(fb.UnknownNameError, match="no entry 'kom' in Segment: payload"):
        fb.Segment(motion, {"mass": 1.0, "kom": [0.1, 0]})
    with pytest.raises(fb.KindError, match="a mass"):
        fb.Segment(motion, True)
    with pytest.raises(fb.FreebodyError, match="expected real numbers"):
        fb.Segment(motion, wrenches={"tip": "up"})
    with pytest.raises(fb.FreebodyError, match="life is 'long'"):
        fb.drive_loads(arm, motion, {"joint1": (MOTOR, GEAR)}, life="long")  # type: ignore[arg-type]
    with pytest.raises(fb.FreebodyError, match="there is no joint to choose a drive for"):
        fb.size(arm, motion, fb.catalogue("invented"), joints=[])
    with pytest.raises(fb.KindError, match="a DutyCycle, a Motion"):
        fb.drive_loads(arm, "cycle.toml", {"joint1": (MOTOR, GEAR)})  # type: ignore[arg-type]
