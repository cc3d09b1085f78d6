"""Parts of a study by themselves: its checks see planted faults, pieces of the replay, torques at a
pace, work, bearings, what can be lifted where, and which equations are short enough.

A study of a robot that is right shows none of what they are for.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import freebody as fb
from freebody.capacity.time_scaling import motion_pace
from freebody.design.joint_loads import joint_loads
from freebody.math import cos, sin
from freebody.report import lifting, page, page_figures
from freebody.report import replay as replays
from freebody.report.checks import checks
from freebody.report.driven_runs import land
from freebody.report.replay import BOUND, amplification, exponentials, pieces
from freebody.report.summary import parted
from freebody.scalars.time_derivatives import Jet, parts
from freebody.spatial import space
from freebody_textbook.in_studies import shown
from support.symbolic import spatial_arm, with_values

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="link"><inertial><origin xyz="0.5 0 0"/><mass value="2.13"/>
    <inertia ixx="0.011" iyy="0.17" izz="0.17" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lift" type="revolute"><parent link="base"/><child link="link"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="{velocity}" effort="{effort}"/></joint>
</robot>
"""


def test_what_two_links_lift_by_hand(monkeypatch):
    """With motor 1 far stronger, motor 2 alone limits: (τ - m₂ g c₂ |cos φ|) / (g l₂ |cos φ|), φ
    being the last link's angle; of both elbows the better."""
    arm = fb.planar("RR", l=[0.5, 0.4], lc=[0.25, 0.2], m=[2.0, 1.5], I=[0.1, 0.1])
    arm = arm.bind({"joint1.limits.effort": 600.0, "joint2.limits.effort": 40.0})
    study = fb.study(arm)
    q = study.motion.q
    phi = q.sum(axis=1)
    by_hand = (40.0 - 1.5 * 9.81 * 0.2 * np.abs(np.cos(phi))) / (9.81 * 0.4 * np.abs(np.cos(phi)))
    mass = lifting.lifting_along(study)
    assert mass is not None
    assert np.allclose(mass, by_hand, rtol=1e-9)
    found = lifting.lifting_over_plane(study)
    assert found is not None
    assert found.words == "in any orientation"
    points, best = found.plane.points, found.mass
    radius = np.linalg.norm(points, axis=-1)
    assert (np.isfinite(best) == ((radius > 0.1) & (radius < 0.9))).all()
    for (i, j), place in zip(((0, 0), (40, 13)), points[[0, 40], [0, 13]], strict=True):
        across, height = found.plane.side[j], found.plane.height[i]
        assert found.plane.project(place) == pytest.approx([across, height], abs=1e-12)
        assert place == pytest.approx(across * found.plane.across + [0.0, height], abs=1e-12)
    i, j = np.argwhere(np.isfinite(best))[7]
    ways = fb.inverse_kinematics(arm, points[i, j]).q.sum(axis=1)
    masses = (40.0 / np.abs(np.cos(ways)) - 1.5 * 9.81 * 0.2) / (9.81 * 0.4)
    assert np.isclose(best[i, j], masses.max(), rtol=1e-9)
    text = page.page(study)
    assert "Largest payload at rest, kg" in text
    assert f"At least {by_hand.min():.3g} kg" in text
    assert "Blank points" in text
    # no closed form: no map
    monkeypatch.setattr(page_figures, "lifting_over_plane", lambda study: None)
    assert "Blank points" not in page.page(study)


def test_nothing_is_said_of_lifting_without_limits():
    study = fb.study(fb.load("2R"))
    assert lifting.lifting_along(study) is None
    assert "Largest payload at rest" not in page.page(study)


def test_a_planted_fault_is_found():
    arm = fb.study(fb.load("ur5e"))

    def failing(**changes: np.ndarray) -> set[str]:
        data = arm.data.copy()
        for name, value in changes.items():
            data[name] = (data[name].dims, value)
        return {c.name for c in checks(arm.model, arm.motion, data, arm.replay) if not c.passed}

    assert failing() == set()
    values = {
        name: arm.data[name].values.copy()
        for name in ("tau", "reaction_force", "reaction_moment", "qdd")
    }
    values["reaction_force"][100, 2, 0] += 1e-6
    assert failing(reaction_force=values["reaction_force"]) == {
        "forces on each body",
        "moments on each body",
    }
    values["reaction_moment"][100, 2, 0] += 1e-6
    assert failing(reaction_moment=values["reaction_moment"]) == {"moments on each body"}
    values["tau"][100, 2] += 1e-5
    wrong = {"equation of motion", "reactions along the axes", "forward dynamics"}
    assert failing(tau=values["tau"]) == wrong
    off = arm.data["energy_residual"].values + 1e-3
    assert failing(energy_residual=off) == {"energy balance"}
    assert failing(energy_residual=off * np.nan) == {"energy balance"}


def test_the_replay_finds_a_wrong_torque():
    model = fb.load("2R")
    motion = fb.default_motion(model)
    whole, allowed = replays.system(model), replays.ranges(model)
    heavier = replace(
        whole,
        inverse=fb.kernel(model.bind(m2=model.parameters["m2"] * (1 + 1e-4)), "inverse_dynamics"),
    )
    edges = np.array([0.0, 1.0, 2.0, 3.0])
    assert land(whole, motion, edges[:-1], edges[1:], allowed, "DOP853").max() < 1e-9
    assert land(heavier, motion, edges[:-1], edges[1:], allowed, "DOP853").max() > 1e-6


def test_pieces_are_as_long_as_the_bound_lets_them():
    times = np.linspace(0, 10, 101)
    growth = np.exp(2.0 * 0.1)  # e-fold in half a second
    steps = np.broadcast_to(np.diag([growth, 1 / growth]), (100, 2, 2))
    edges, factors = pieces(times, steps)
    length = np.log(BOUND) / 2.0
    assert np.diff(edges)[:-1] == pytest.approx(np.full(len(edges) - 2, np.floor(length * 10) / 10))
    assert (factors <= BOUND).all()
    assert amplification(steps) == pytest.approx(20.0 / np.log(10))


def test_exponentials():
    A = np.random.default_rng(0).normal(size=(5, 6, 6))
    A[:, 2, 2] -= 1e4  # friction
    np.testing.assert_allclose(exponentials(A), expm(A), atol=1e-9)
    assert (exponentials(np.zeros((1, 3, 3))) == np.eye(3)).all()


def test_an_inverted_pendulum_drifts_as_it_must():
    """The linearised error of a uniform rod held upright grows as exp(sqrt(3 g / 2 l) t)."""
    model = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[1 / 12])
    t = np.linspace(0, 4, 201)
    motion = fb.Motion.of(model, t, np.full((201, 1), np.pi / 2) + 1e-3 * np.sin(t)[:, None])
    found = replays.replayed(model, motion)
    rate = np.sqrt(1.5 * 9.81)
    assert found.amplification == pytest.approx(rate * 4 / np.log(10), abs=1.0)
    assert found.misses.max() < 1e-8


def test_jets_are_exact():
    t = np.linspace(0, 1, 5)
    x = Jet(t, np.ones(5), np.zeros(5))
    value, rate, second = parts((sin(x) * x / (2.0 + cos(x)), 1.0 - x, 3.0))
    c, s = np.cos(t), np.sin(t)
    np.testing.assert_allclose(value[0], s * t / (2 + c))
    n, d = s * t, 2 + c
    nd, dd = c * t + s, -s
    np.testing.assert_allclose(rate[0], (nd * d - n * dd) / d**2)
    ndd, ddd = -s * t + 2 * c, -c
    np.testing.assert_allclose(
        second[0], (ndd - 2 * dd * (nd * d - n * dd) / d**2 - n / d * ddd) / d, atol=1e-14
    )
    np.testing.assert_array_equal(rate[1], -np.ones(5))
    assert rate[2] == 0.0
    R, Rd, _ = parts(space.rotation((0.0, 0.0, 1.0), x))
    np.testing.assert_allclose(Rd[0][1], -R[0][0])


def test_the_pace_is_held_by_the_torque_at_rest_and_friction():
    drive = fb.Drive(viscous=0.7, coulomb=0.4, rotor=2e-3, gear=10.0, stiffness=1.5, rest=0.1)
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.4], m=[2, 1], I=[0.1, 0.05], drives=[drive, drive])
    t = np.linspace(0.0, 2.0, 201)
    wave = 0.5 * np.sin(np.pi * t / 2.0)[:, None] ** 2
    study = fb.study(model, fb.Motion.of(model, t, wave * [1.0, -0.6]))
    tau = np.abs(fb.static_torque(model, study.motion.q) + 0.4 * np.sign(study.motion.qd))
    for k, most in enumerate(tau.max(axis=0)):
        effort = np.where(np.arange(2) == k, 0.8 * most, np.inf)
        found = motion_pace(study.model, study.motion, study.data, effort=effort)
        assert found.factor == 0.0
        assert (found.joint, found.quantity) == (model.velocity_names[k], "torque")
        assert found.share == pytest.approx(1.25, rel=1e-9)
        assert found.time == study.motion.t[np.argmax(tau[:, k])]


def test_work_is_parted_where_the_power_changes_its_sign():
    done, braked = parted(
        np.array([0.0, 1.0, 2.0]), np.array([[3.0, 0.0], [-1.0, 0.0], [-1.0, 2.0]])
    )
    np.testing.assert_allclose(done, [9 / 8, 1.0])
    np.testing.assert_allclose(braked, [1 / 8 + 1.0, 0.0])


# ------------------------------------------------------------ bearings
def test_a_bearing_is_told_from_its_drive(tmp_path: Path):
    """Three kilograms at (0.4, 0.3, 0.2) from joints about y, about z, and along z: statics by
    hand."""
    weight = 3.0 * 9.81
    expected = {
        ("revolute", "0 1 0"): {"axial_force": 0, "radial_force": weight,
                                "tilting_moment": 0.3 * weight,
                                "drive_load": -0.4 * weight},
        ("revolute", "0 0 1"): {"axial_force": weight, "radial_force": 0,
                                "tilting_moment": 0.5 * weight,
                                "drive_load": 0},
        ("prismatic", "0 0 1"): {"radial_force": 0, "tilting_moment": 0.5 * weight,
                                 "guide_moment": 0,
                                 "drive_load": weight},
        ("prismatic", "1 0 0"): {"radial_force": weight, "tilting_moment": 0.4 * weight,
                                 "guide_moment": 0.3 * weight,
                                 "drive_load": 0},
    }  # fmt: skip
    for (kind, axis), loads in expected.items():
        file = tmp_path / "mast.urdf"
        file.write_text(
            ARM.format(velocity=3, effort=99)
            .replace('type="revolute"', f'type="{kind}"')
            .replace('axis xyz="0 1 0"', f'axis xyz="{axis}"')
            .replace('xyz="0.5 0 0"', 'xyz="0.4 0.3 0.2"')
            .replace("2.13", "3")
        )
        model = fb.load(file)
        wrench = fb.joint_wrenches(model, *np.zeros((3, 1, 1)), reference="child")
        data = joint_loads(model, wrench[..., :3], wrench[..., 3:])
        for name in ("axial_force", "radial_force", "tilting_moment", "guide_moment", "drive_load"):
            want = loads.get(name, np.nan)
            np.testing.assert_allclose(
                data[name][:, 0], want, atol=1e-9, err_msg=f"{kind} {axis} {name}"
            )


@pytest.mark.parametrize("name", ["2R", "3R", "RP", "gyro", "scara"])
def test_equations_of_small_arms_are_in_the_report(name):
    found = shown(fb.load(name))
    assert found is not None
    assert ET.fromstring(found.mathml).tag == "{http://www.w3.org/1998/Math/MathML}math"


def test_equations_that_are_short_by_base_parameters_only():
    model = with_values(spatial_arm(11, 4))
    found = shown(model)
    assert not fb.equations(model).is_short
    assert found is None or found.base


@pytest.mark.parametrize("name", ["ur5e", "panda", "quadrotor"])
def test_long_equations_are_left_out(name):
    assert shown(fb.load(name)) is None
