"""`fb.calibrate` on simulated robots that are off their models in a known way."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.simulated_poses import Displaced, random_arm, seen, turned

pytestmark = [
    pytest.mark.usefixtures("numpy_kernels"),
    pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning"),
]

NOISE = 5e-5


@cache
def case(name="ur5e", noise=NOISE, count=60):
    """A robot, one that is off it, by how much, and what is seen of that."""
    model, rng = fb.load(name), np.random.default_rng(7)
    real = Displaced(model, rng)
    return model, real, real.truth, seen(real, rng, count, noise)


@cache
def usual():
    model, _, _, data = case()
    return fb.calibrate(model, data.q, data.T)


def holds(found, truth):
    """Whether the interval of each measured combination holds its true value, and likewise those of
    the parameters that are not the prior's alone."""
    true = np.array([truth[x.name] for x in found.parameters])
    sizes = {x.name: x.prior for x in found.parameters}
    combined = []
    for x in found.combinations:
        if x.source == "measured":
            value = sum(w * truth[name] / sizes[name] for name, w in x.weights.items())
            combined.append(abs(value - x.value) <= 1.96 * x.deviation)
    single = [
        x.lower <= y <= x.upper
        for x, y in zip(found.parameters, true, strict=True)
        if x.source != "prior"
    ]
    return combined, single


def coverage(seeds):
    combined, single = [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        model = (
            random_arm(seed) if seed % 4 == 3 else fb.load(("ur5e", "panda", "puma560")[seed % 4])
        )
        real = Displaced(model, rng)
        data = seen(real, rng, int(rng.integers(40, 80)), 10 ** rng.uniform(-5.0, -3.7))
        found = fb.calibrate(model, data.q, data.T if seed % 2 else data.points)
        assert found.outcome == "calibrated", (seed, found.verdict)
        for kept, new in zip((combined, single), holds(found, real.truth), strict=True):
            kept += new
    return np.mean(combined), np.mean(single)


def test_intervals_hold_the_truth_on_a_sample():
    combined, single = coverage(range(4))
    assert combined > 0.88
    assert single > 0.85


def upright(seeds):
    """Results for a SCARA seen by points: of its marker's height and the instrument's only the sum
    shows."""
    for seed in seeds:
        model, rng = fb.load("scara"), np.random.default_rng(seed)
        real = Displaced(model, rng)
        data = seen(real, rng, 50, 1e-4)
        yield fb.calibrate(model, data.q, data.points), real.truth


def share_that_holds(results):
    return np.mean([hit for found, truth in results for hit in holds(found, truth)[0]])


def test_what_depends_on_a_marker_s_untold_height_is_less_sure():
    results = list(upright(range(6)))
    assert share_that_holds(results) > 0.85
    assert all("do not tell where the marker sits" in " ".join(x.notices) for x, _ in results)
    assert "where the marker sits" not in " ".join(usual().notices)


@pytest.mark.long
def test_intervals_of_an_upright_arm_hold():
    assert share_that_holds(upright(range(100))) > 0.93


@pytest.mark.long
def test_intervals_hold_the_truth():
    combined, single = coverage(range(200))
    assert 0.93 <= combined <= 0.97
    assert 0.93 <= single <= 0.97


@pytest.mark.parametrize("rotations", [True, False])
def test_exact_poses_are_predicted_exactly(rotations):
    model, real, _, data = case(noise=0.0)
    found = fb.calibrate(model, data.q, data.T if rotations else data.points)
    assert found.outcome == "calibrated"
    q, _, _ = fb.random_state(model, 99, 40)
    true = np.linalg.inv(data.instrument) @ real.forward(q) @ data.marker
    there = np.linalg.inv(found.instrument) @ fb.forward_kinematics(found.model, q) @ found.marker
    assert np.abs(there - true)[:, :3, 3].max() < 1e-9
    if rotations:
        assert np.abs(there - true).max() < 1e-9


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "turning", "sliding"), [("ur5e", 6, 0), ("panda", 7, 0), ("stanford", 5, 1)]
)
def test_as_many_combinations_are_measured_as_geometry_has(name, turning, sliding):
    """4 R + 2 P + 6 numbers show at the tip (Mooring, Roth, Driels 1991), of which instrument and
    marker take 12; where both are known, all are the robot's but the 4 of a fixed frame behind the
    last axis, which is known with the marker."""
    model, _, _, data = case(name)
    found = fb.calibrate(model, data.q, data.T)
    sources = [x.source for x in found.combinations]
    assert sources.count("measured") == 4 * turning + 2 * sliding - 6
    assert sources.count("partly") == 0
    known = fb.calibrate(model, data.q, data.T, instrument=data.instrument, marker=data.marker)
    assert [x.source for x in known.combinations].count("measured") == 4 * turning + 2 * sliding + 2


def test_what_the_poses_do_not_tell_is_not_called_measured():
    found = usual()
    first = found["shoulder_pan_joint.rz"]
    assert first.source == "prior"
    assert first.share > 0.99
    assert abs(first.value) < 1e-3 * first.prior
    prior = [x for x in found.combinations if x.source == "prior"]
    assert all(x.deviation > 0.94 and abs(x.value) < 0.01 for x in prior)
    offset = [x for x in prior if {n for n, w in x.weights.items() if abs(w) > 0.1} == {
        "wrist_3_joint.rz"}]  # fmt: skip
    assert offset
    assert "Not told by these poses" in str(found)
    assert "the prior" in str(found)


def test_deviations_and_errors_say_what_happens():
    model, real, _, data = case()
    found = usual()
    assert found.noise.position == pytest.approx(NOISE, rel=0.15)
    assert found.noise.rotation == pytest.approx(NOISE, rel=0.15)
    assert found.after.position < found.apart.position < 0.05 * found.before.position
    assert found.left_out == ()
    q, _, _ = fb.random_state(model, 3, 40)
    T = np.linalg.inv(data.instrument) @ real.forward(q) @ data.marker
    checked = fb.calibrate(model, data.q, data.T, validate=(q, T))
    # unseen poses without noise: only what the calibration itself is off by
    assert checked.validation.position < NOISE
    assert checked.validation_before.position == pytest.approx(found.before.position, rel=0.5)


@pytest.mark.parametrize("suffix", ["urdf", "toml"])
def test_the_calibrated_model_is_saved(tmp_path, suffix):
    found = usual()
    path = tmp_path / f"robot.{suffix}"
    fb.save(found.model, path)
    q, _, _ = fb.random_state(found.model, 5, 20)
    saved = fb.forward_kinematics(fb.load(path), q, found.frame)
    np.testing.assert_allclose(saved, fb.forward_kinematics(found.model, q), atol=1e-12)


def test_wild_poses_are_left_out():
    model, _, truth, data = case()
    T = data.T.copy()
    T[[5, 40], 0, 3] += [0.02, -3.0]
    T[23, :3, :3] = T[23, :3, :3] @ turned([0.0, 0.1, 0.0])
    found = fb.calibrate(model, data.q, T)
    assert found.left_out == (5, 23, 40)
    assert "Poses 5, 23 and 40 (counted from 0) are left out" in found.notices[0]
    assert np.mean(holds(found, truth)[0]) > 0.85
    assert found.trusted


def test_gear_factors_are_found():
    model, _, _, data = case()
    factors = 1.0 + 1e-3 * np.array([1.0, -2.0, 0.5, 1.5, -1.0, 0.7])
    found = fb.calibrate(model, data.q / factors, data.T, gears=1e-3)
    np.testing.assert_allclose(found.gears, factors, atol=2e-4)
    np.testing.assert_allclose(found.positions(data.q / factors), data.q / factors * found.gears)
    assert not fb.calibrate(model, data.q / factors, data.T).trusted


@pytest.mark.parametrize(
    ("joint", "wrong", "said"),
    [
        (2, lambda q: 1e-3 * np.sin(q + 0.3), "the angle of elbow_joint"),
        (1, lambda q: 5e-4 * np.cos(2.0 * q), "the angle of shoulder_lift_joint"),
    ],
)
def test_what_geometry_does_not_explain_is_said(joint, wrong, said):
    model, _, _, data = case()
    q = data.q.copy()
    q[:, joint] += wrong(q[:, joint])
    found = fb.calibrate(model, q, data.T)
    assert found.outcome == "does not fit"
    assert said in found.misfits[0]
    assert f"depends on {said}" in found.verdict


def test_noise_that_is_stated_too_small_is_told():
    model, _, _, data = case()
    found = fb.calibrate(model, data.q, data.T, noise=(1e-5, 1e-5))
    assert "more is left than the stated noise" in found.verdict
    assert found.outcome == "does not fit"


def test_a_robot_that_is_as_its_model_is_not_improved():
    model = fb.load("ur5e")
    data = seen(Displaced(model, np.random.default_rng(1), 0.0), np.random.default_rng(2), 40, 1e-4)
    found = fb.calibrate(model, data.q, data.T)
    assert found.outcome == "no better"
    assert found.verdict.startswith("No better than the model as it was")


def test_a_surprising_robot_is_told():
    model = fb.load("ur5e")
    real = Displaced(model, np.random.default_rng(1), 1e-2)
    data = seen(real, np.random.default_rng(2), 40, NOISE)
    found = fb.calibrate(model, data.q, data.T)
    assert any("Give a larger shift=, turn=" in x for x in found.notices)
    assert found.trusted


def test_the_next_poses_tell_more_than_others():
    model, real, _, data = case()
    q, T = data.q[:15], data.T[:15]
    found = fb.calibrate(model, q, T, noise=(NOISE, NOISE))
    others = fb.random_state(model, 50, len(found.next_poses))[0]

    def told(more):
        unit = np.linalg.inv(data.instrument) @ real.forward(more) @ data.marker
        both = fb.calibrate(model, np.r_[q, more], np.r_[T, unit], noise=(NOISE, NOISE))
        return sum(np.log(x.deviation) for x in both.combinations if x.source == "measured")

    assert told(found.next_poses) < told(others)


BAD = {
    "degrees": (lambda q, T: (np.degrees(q), T), "the angles in q are degrees (give radians"),
    "mm": (lambda q, T: (q, 1e3 * T[:, :3, 3]), "the positions are in mm (give metres)"),
    "both": (lambda q, T: (np.degrees(q), 1e3 * T[:, :3, 3]), "degrees (give radians, np.deg2rad("
             "q)) and the positions are in mm"),
    "mirrored points": (lambda q, T: (q, T[:, :3, 3] * [1, -1, 1]), "axes are left-handed"),
    "mirrored": (lambda q, T: (q, T @ np.diag([1, 1, -1, 1.0])), "rotation of pose 0 is left-hand"),
    "no rotation": (lambda q, T: (q, T * 2.0), "pose 0 is none: R Rᵀ differs from 1 by 3"),
    "order": (lambda q, T: (q[::-1], T), "Give q and poses row by row in one order"),
    "order of points": (lambda q, T: (q[::-1], T[:, :3, 3]), "row by row in one order"),
    "inverse": (lambda q, T: (q, np.linalg.inv(T)), "(give the inverse)"),
    "nan": (lambda q, T: (q, np.where(T[3, 0, 3] == T, np.nan, T)), "poses is nan at sample 3"),
    "rows": (lambda q, T: (q[:9], T), "q has 9 rows and poses 60"),
    "none": (lambda q, T: (q[:0], T[:0]), "0 poses; 30 numbers of 'ur5e' show at 'frame6': measure "
             "at least 8 poses"),
    "few": (lambda q, T: (q[:5], T[:5]), "5 poses; 30 numbers of 'ur5e' show at"),
    "few points": (lambda q, T: (q[:8], T[:8, :3, 3]), "8 poses; 27 numbers of 'ur5e' show at "
                   "'frame6': measure at least 14 poses"),
    "joints": (lambda q, T: (q[:, :5], T), "q has shape (60, 5), expected (n, 6)"),
    "kind": (lambda q, T: (3, None), "q is int 3, expected poses of fb.read_poses"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_in_one_line(name):
    change, said = BAD[name]
    model, _, _, data = case()
    q, T = change(data.q, data.T)
    with pytest.raises(fb.FreebodyError) as caught:
        fb.calibrate(model, q, T)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("robot", "given", "said"),
    [
        ("3R", {}, "is planar; calibrate its twin in space: model.to_space()"),
        ("four_bar", {}, "calibrate"),
        ("ur5e", {"frame": "base"}, "no joint is between the base and 'base'"),
        ("ur5e", {"shift": 0.0}, "shift is 0, expected a number of m above 0"),
        ("ur5e", {"noise": 1e-5}, "noise is 1e-05, expected (m, rad) above 0"),
        ("ur5e", {"marker": [0, 0, 0]}, "marker has shape (3,), expected a pose (4, 4)"),
        ("ur5e", {"validate": 3}, "validate is int 3, expected poses of fb.read_poses"),
    ],
)
def test_wrong_arguments_are_refused(robot, given, said):
    *_, data = case()
    with pytest.raises(fb.FreebodyError, match="calibrate") as caught:
        fb.calibrate(fb.load(robot), data.q, data.T, **given)
    assert said in str(caught.value)


def written(path, model, data, head=None, change=lambda rows: rows):
    from scipy.spatial.transform import Rotation

    quaternions = Rotation.from_matrix(data.T[:, :3, :3]).as_quat(scalar_first=True)
    rows = np.column_stack([np.degrees(data.q), 1e3 * data.points, quaternions])
    names = [f"{x} (deg)" for x in model.joint_names]
    names += ["x (mm)", "y (mm)", "z (mm)", "qw", "qx", "qy", "qz"]
    np.savetxt(path, change(rows), delimiter=",", header=",".join(head or names), comments="")
    return path


def test_poses_are_read_from_a_table(tmp_path):
    model, _, _, data = case()
    path = written(tmp_path / "poses.csv", model, data)
    read = fb.read_poses(path, model)
    np.testing.assert_allclose(read.q, data.q, atol=1e-12)
    np.testing.assert_allclose(read.position, data.points, atol=1e-12)
    np.testing.assert_allclose(read.rotation, data.T[:, :3, :3], atol=1e-9)
    assert str(read).startswith("<60 measured poses read from poses.csv")
    turns = np.random.default_rng(0).permutation(60)
    mixed = fb.calibrate(model, read.of(turns))
    np.testing.assert_allclose(
        [x.value for x in mixed.parameters], [x.value for x in usual().parameters], atol=1e-8
    )


@pytest.mark.parametrize(
    ("columns", "way"),
    [
        (("rx", "ry", "rz"), lambda R: R.as_rotvec()),
        (("roll", "pitch", "yaw"), lambda R: R.as_euler("xyz")),
        (
            [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)],
            lambda R: R.as_matrix().reshape(-1, 9),
        ),
    ],
)
def test_rotations_are_read_in_every_form(columns, way):
    from scipy.spatial.transform import Rotation

    model, rng = fb.load("ur5e"), np.random.default_rng(4)
    R = Rotation.random(7, rng=rng)
    table = {f"q{k + 1}": rng.normal(size=7) for k in range(6)}
    table |= {x: rng.normal(size=7) for x in "xyz"}
    table |= dict(zip(columns, way(R).T, strict=True))
    read = fb.read_poses({**table, "note": np.arange(7)}, model)
    np.testing.assert_allclose(read.rotation, R.as_matrix(), atol=1e-12)
    assert read.notices == ("Columns not read: note.",)


def test_faults_of_a_table_are_told_with_the_line(tmp_path):
    model, _, _, data = case()
    joints = [f"{x} (deg)" for x in model.joint_names]
    rest = ["x (mm)", "y (mm)", "z (mm)", "qw", "qx", "qy", "qz"]

    def nan(rows):
        rows[4, 6] = np.nan
        return rows

    def scaled(rows):
        rows[2, 9:] *= 1.1
        return rows

    for head, change, said in (
        ([*joints, "x (in)", *rest[1:]], np.copy, "'in' is not a unit of its length; units: m"),
        ([*joints, "X", *rest[1:]], np.copy, "poses.csv:1: the header has no column 'x'"),
        ([*joints[:-1], joints[0], *rest], np.copy, "occurs twice"),
        (None, nan, "poses.csv:6: column 'x' has no finite number"),
        (None, scaled, "the quaternion of pose 2 has length 1.1, expected 1"),
    ):
        path = written(tmp_path / "poses.csv", model, data, head, change)
        with pytest.raises(fb.FreebodyError) as caught:
            fb.read_poses(path, model)
        assert said in str(caught.value)
    np.savetxt(path, np.ones((8, 9)), delimiter=",")
    with pytest.raises(fb.FreebodyError, match="the table has no header; name its columns"):
        fb.read_poses(path, model)


def test_a_joint_called_like_a_coordinate_is_counted():
    gantry = fb.dh([{"joint": "P"}, {"joint": "R"}], convention="standard", name="g")
    assert gantry.joint_names == ("joint1", "joint2")
    described = {"q1": [0.1], "q2": [0.2], "x": [1.0], "y": [2.0], "z": [3.0]}
    read = fb.read_poses(described, gantry)
    np.testing.assert_allclose(read.q, [[0.1, 0.2]])
    np.testing.assert_allclose(read.position, [[1.0, 2.0, 3.0]])


def test_the_command_writes_robot_report_and_data(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    model, _, _, data = case()
    written(tmp_path / "poses.csv", model, data)
    words = ["calibrate", "ur5e", "poses.csv", "--out", "found"]
    assert run([*words, "--validate", "poses.csv"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("Calibrated: ")
    assert said.err == ""
    found = json.loads((tmp_path / "found/calibration.json").read_text(encoding="utf-8"))
    values = {x["name"]: x["value"] for x in found["parameters"]}
    expected = {x.name: x.value for x in usual().parameters}
    assert values == pytest.approx(expected, abs=1e-8)
    q, _, _ = fb.random_state(model, 5, 5)
    saved = fb.forward_kinematics(fb.load("found/model.toml"), q)
    np.testing.assert_allclose(saved, fb.forward_kinematics(usual().model, q), atol=1e-8)
    assert run([*words[:3], "--noise", "1e-6,1e-6"]) == 1
    assert "Does not fit" in capsys.readouterr().out
