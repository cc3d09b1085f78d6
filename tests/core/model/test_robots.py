"""The bundled models: they load at once, cite their source, and give the numbers that their source
gives."""

import subprocess
import sys
import time

import numpy as np
import pytest

import freebody as fb
from support.command import run

NAMES = ["2R", "3R", "3RRR", "acrobot", "ball_and_beam", "bricard", "cart_pole", "cylindrical_arm",
         "double_four_bar", "elbow_arm", "five_bar", "five_bar_rods", "four_bar", "furuta",
         "gantry_crane", "gyro", "iiwa14", "panda", "pendubot", "pendulum", "polar_arm", "puma560",
         "quadrotor", "reaction_wheel", "RP", "scara", "slider_crank", "stanford", "stewart",
         "ur5e"]  # fmt: skip
NOT_PHYSICAL = {"puma560": ["link1", "link3"]}


def test_models_lists_names_and_sources():
    models = fb.models()
    assert list(models) == NAMES
    assert all(len(source) > 20 and "\n" not in source for source in models.values())
    lines = str(models).splitlines()
    assert [line.split()[0] for line in lines] == NAMES
    assert lines[0].startswith("2R               S. Bai, ")
    assert repr(models) == str(models)


def test_every_bundled_model_tells_what_is_worth_seeing(tmp_path, capsys):

    assert run(["models"]) == 0
    listed = " ".join(capsys.readouterr().out.split())
    for name in NAMES:
        model = fb.load(name, physical="ignore")
        assert model.about.endswith(".")
        assert f"{name} {' '.join(model.about.split())} source: " in listed
    fb.save(model, tmp_path / "copy.toml")
    assert fb.load(tmp_path / "copy.toml").about == model.about


def test_what_is_told_of_the_classics_holds():
    """Claims of `about` that are numbers."""
    cart = fb.equations(fb.load("cart_pole"))
    assert str(cart).splitlines()[1].startswith("0 = H₂₁ ẍ")
    ball = fb.load("ball_and_beam")
    q, b = [0.3, 0.1], ball.parameters
    rolls = -fb.gravity_torque(ball, q)[1] / fb.mass_matrix(ball, q)[1, 1]
    assert rolls == pytest.approx(-5 / 7 * b["g"] * np.sin(0.3), rel=1e-12)
    furuta = fb.load("furuta")
    f = furuta.parameters
    least = np.sqrt(f["m2"] * f["g"] * f["lc2"] / (f["m2"] * f["lc2"] ** 2 + f["I2"]))
    for rate, lifted in ((0.99 * least, False), (1.01 * least, True)):
        bias = fb.bias(furuta, [0.0, np.pi - 0.01], [rate, 0.0])[1]
        assert bool(bias > 0) is lifted  # it must be held back, away from straight down
    crane = fb.load("gantry_crane")
    lag = np.arctan2(1.5, crane.parameters["g"])
    assert fb.forward_kinematics(crane, [0, 0, 0, -lag])[0, 3] < 0.0  # behind the trolley
    found = fb.inverse_dynamics(crane, [0, 0, 0, -lag], [0] * 4, [1.5, 0, 0, 0])
    np.testing.assert_allclose(found[2:], 0.0, atol=1e-10)
    M = fb.mass_matrix(fb.load("polar_arm"), [0.3, 0.4, 0.5])
    np.testing.assert_allclose(M, np.diag(np.diag(M)), atol=1e-14)
    arm = fb.load("stanford")
    for q in ([0.1, 0.0, 0.5, 0.3, 0.7, 0.2], [0.1, 0.9, 0.5, 0.3, 0.0, 0.2]):
        assert abs(np.linalg.det(fb.jacobian(arm, q))) < 1e-12
    wheel = fb.load("reaction_wheel")
    np.testing.assert_allclose(fb.coriolis_matrix(wheel, [0.3, 0.4], [1.0, 2.0]), 0.0, atol=1e-15)


@pytest.mark.sample(16)
@pytest.mark.parametrize("name", NAMES)
def test_loads_physical_unless_its_source_is_not(name: str):
    if name in NOT_PHYSICAL:
        with pytest.warns(fb.PhysicalWarning) as warned:
            model = fb.load(name)
        assert [str(w.message).split("'")[1] for w in warned] == NOT_PHYSICAL[name]
        assert str(warned[0].message) == (
            "puma560.toml:10: warning: link 'link1': principal moments 0, 0, 0.35 kg m² break the "
            "triangle "
            "inequality (0 + 0 < 0.35)."
        )
    else:
        model = fb.load(name, physical="refuse")
        kinds = {notice.kind for notice in model.notices if notice.kind != "tip"}
        assert kinds <= {"estimated inertias", "estimated limits"}
        assert bool(kinds) == (name in {"iiwa14", "scara", "stanford"})
    assert (model.name, model.source) == (name, fb.models()[name])
    assert model.missing == ()
    assert model.tip is not None
    assert np.isfinite(model.mass)


@pytest.mark.parametrize("name", NAMES)
def test_loads_quickly(name: str):
    def once() -> float:
        start = time.perf_counter()
        fb.load(name, physical="ignore")
        return time.perf_counter() - start

    assert min(once() for _ in range(3)) < 0.05


def test_loading_reads_no_heavy_module():
    heavy = ("scipy", "pydantic", "xarray", "llvmlite")
    code = (
        f"import sys, freebody as fb; fb.load('panda'); print(*(m for m in {heavy} if m in "
        "sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("name", ["pendulum", "2R", "3R", "RP"])
def test_planar_models_carry_the_names_of_the_notes(name: str):
    model = fb.load(name)
    word = {"pendulum": "R", "2R": "RR", "3R": "RRR", "RP": "RP"}[name]
    n = len(word)
    expected = {"g"} | {f"{letter}{i + 1}" for i in range(n) for letter in ("l", "lc", "m", "I")}
    assert set(model.parameters) == expected
    for i in range(n):
        l, lc, m, I = (model.parameters[f"{letter}{i + 1}"] for letter in ("l", "lc", "m", "I"))
        assert (lc, I) == ((l or 0.5) / 2, pytest.approx(m * (l or 0.5) ** 2 / 12))  # slender bars


def test_mimic_of_the_hand():
    assert (fb.load("panda").nv, fb.load("panda", mimic="free").nv) == (8, 9)


def test_panda_is_the_file_it_was_taken_from():
    from support.real_files import ROBOTS

    if not ROBOTS.is_dir():
        pytest.skip("needs example-robot-data")
    ours, theirs = fb.load("panda"), fb.load(ROBOTS / "panda_description/urdf/panda.urdf")
    assert (ours.joint_names, ours.frame_names, ours.mass) == (
        theirs.joint_names,
        theirs.frame_names,
        theirs.mass,
    )
    for a, b in zip(ours.tree.bodies, theirs.tree.bodies, strict=True):
        assert (a.R, a.p, a.axis, a.drive) == (b.R, b.p, b.axis, b.drive)
        for mine, other in zip(a.masses, b.masses, strict=True):
            assert mine == other
    for field in ("lower", "upper", "velocity", "effort"):
        np.testing.assert_array_equal(getattr(ours.limits, field), getattr(theirs.limits, field))


def test_puma_against_its_toolbox():
    """Gravity torque, mass matrix with rotors and velocity terms printed in the tests of Corke's
    toolbox."""
    model = fb.load("puma560", physical="ignore")
    q = np.array([0, np.pi / 4, np.pi, 0, np.pi / 4, 0])
    zero, ones = np.zeros(6), np.ones(6)
    tolerance = {"rtol": 0, "atol": 0.5001e-4}
    np.testing.assert_allclose(
        fb.gravity_torque(model, q), [0, 31.6399, 6.0351, 0, 0.0283, 0], **tolerance
    )
    M = fb.mass_matrix(model, q)
    np.testing.assert_allclose(M[0], [3.6594, -0.4044, 0.1006, -0.0025, 0, 0], **tolerance)
    np.testing.assert_allclose(
        np.diag(M), [3.6594, 4.4137, 0.9378, 0.1925, 0.1713, 0.1941], **tolerance
    )
    smooth = model.without("friction")
    velocity = fb.inverse_dynamics(smooth, q, ones, zero)
    np.testing.assert_allclose(
        velocity, [-1.3911, 33.4228, 5.2831, 0.0012, 0.0306, 0.0001], **tolerance
    )
    lost = fb.inverse_dynamics(model, q, ones, zero) - velocity
    assert lost[0] == pytest.approx(1.48e-3 * 62.6111**2 + (0.395 + 0.435) / 2 * 62.6111, rel=1e-5)


def test_ur5e_stands_as_its_manufacturer_draws_it():
    """All joints at zero: the arm stretched along -x, the flange facing -y."""
    model = fb.load("ur5e")
    T = fb.forward_kinematics(model, np.zeros(6))
    np.testing.assert_allclose(T[:3, 3], [-0.8172, -0.2329, 0.0628], atol=1e-12)
    np.testing.assert_allclose(T[:3, 2], [0, -1, 0], atol=1e-15)
    assert model.mass == pytest.approx(17.7)


def test_iiwa_is_as_high_as_its_data_sheet_says():
    T = fb.forward_kinematics(fb.load("iiwa14"), np.zeros(7))
    np.testing.assert_allclose(T[:3, 3], [0, 0, 0.36 + 0.42 + 0.4 + 0.126], atol=1e-12)


def test_scara_reaches_down():
    T = fb.forward_kinematics(fb.load("scara"), [0, 0, 0.1, 0])
    np.testing.assert_allclose(T[:3, 3], [0.8, 0, 0.877 - 0.1 - 0.2], atol=1e-12)


def test_gyro_needs_the_gyroscopic_torque():
    """Example 1 of section 6.1, spun steadily: 150 N m about y, borne by the ring's bearings and
    not by a motor."""
    model = fb.load("gyro")
    np.testing.assert_allclose(
        fb.inverse_dynamics(model, [0, 0], [3, 5], [0, 0]), [0, 0], atol=1e-12
    )
    wrench = fb.joint_wrenches(model, [0, 0], [3, 5], [0, 0])[1]
    np.testing.assert_allclose(wrench, [0, 0, 9.81, 0, 150, 0], atol=1e-9)


def test_quadrotor_of_the_notes():
    """Example 2 of section 6.1, as corrected: g = 9.8, rates in world axes."""
    model = fb.load("quadrotor").replace(gravity=9.8)
    phi1, phi2, phi3 = np.pi / 4, 0.1, 0.2  # Rz Rx Rz
    s, d = (phi1 + phi3) / 2, (phi1 - phi3) / 2
    q = np.array([0, 0, 0, *(np.cos(phi2 / 2) * x for x in (np.cos(s),)), 0, 0, 0])
    q[4:] = np.sin(phi2 / 2) * np.cos(d), np.sin(phi2 / 2) * np.sin(d), np.cos(phi2 / 2) * np.sin(s)
    T = fb.forward_kinematics(model, q, frame="body")
    R = T[:3, :3]
    np.testing.assert_allclose(R[2], [0.01983, 0.09784, 0.9950], atol=5e-5)
    w = R.T @ [0.5, 0, 0.1]
    thrusts = {
        f"rotor{i + 1}": np.r_[R @ [0, 0, f], 0, 0, 0] for i, f in enumerate((3.2, 1.4, 2.5, 3.6))
    }
    qdd = fb.forward_dynamics(model, q, np.r_[0, 0, 0, w], np.zeros(6), thrusts)
    np.testing.assert_allclose(R @ qdd[:3], [0.15107, -0.15107, -7.67069], atol=5e-6)
    np.testing.assert_allclose(R @ qdd[3:], [-0.064561, -0.155539, -0.006455], atol=5e-7)
