"""A table that a crank lifts by a polynomial: payloads, drives, modes, deflections and stops by
hand. At y = p(q) the crank feels m p' (p' q̈ + p" q̇² + g)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")

G, EFFORT, WHEEL, TABLE = 9.81, 10.0, 0.05, 2.0
Q = np.array([[0.7], [-1.0], [-2.0]])  # at the last p' is 0
SLOPE, BEND = 0.2 + 0.1 * Q[:, 0], 0.1
TEXT = """
name = "lift"
dim = 2
gravity = [0, -9.81]
tip = "table"
link = [
    { name = "base" },
    { name = "wheel", mass = 1, inertia = 0.05 },
    { name = "table", mass = %s },
]
[[joint]]
name = "crank"
kind = "revolute"
parent = "base"
child = "wheel"
limits = { lower = -2, upper = 2, velocity = 8, effort = 10 }
[[joint]]
name = "slide"
kind = "prismatic"
axis = "y"
parent = "base"
child = "table"
rotor = { inertia = %s }
mimic = { joint = "crank", ratio = [0.2, 0.05], offset = 0.1 }
"""


def lift(folder: Path, mass: float = TABLE, rotor: float = 0.0) -> fb.Model:
    file = folder / "lift.toml"
    file.write_text(TEXT % (mass, rotor))
    return fb.load(file)


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> fb.Model:
    return lift(tmp_path_factory.mktemp("lift"))


def test_payloads(model):
    with np.errstate(divide="ignore"):
        holds = EFFORT / (np.abs(SLOPE) * G) - TABLE
    assert np.isinf(holds[2])
    np.testing.assert_allclose(fb.payload(model, Q).mass, holds, rtol=1e-12)
    np.testing.assert_allclose(fb.payload_map(model, Q).mass, holds, rtol=1e-12)
    motion = fb.quintic(model, [[-1.5], [1.5]], [0.0, 0.8])
    q, qd, qdd = motion.q[:, 0], motion.qd[:, 0], motion.qdd[:, 0]
    slope = 0.2 + 0.1 * q
    each = slope * (slope * qdd + BEND * qd**2 + G)
    most = (EFFORT * np.sign(each) - WHEEL * qdd) / each - TABLE
    found = fb.payload(model, motion)
    assert float(found.mass) == pytest.approx(most.min(), rel=1e-9)
    assert float(found.time) == motion.t[np.argmin(most)]


def test_modes_and_deflections(model):
    k = 50.0
    M = WHEEL + TABLE * SLOPE**2
    found = fb.natural_frequencies(model, Q, [k])
    np.testing.assert_allclose(found.squares[:, 0], (k + BEND * TABLE * G) / M, rtol=1e-12)
    bent = fb.deflection(model, Q, stiffness=[k]).displacement
    np.testing.assert_allclose(bent[:, 1], -TABLE * G * SLOPE**2 / k, atol=1e-15)


def test_drives(model, tmp_path):
    motor = fb.Motor("M", 2e-4, 2.0, 6.0, 900.0, 0.0, brake_torque=1.5, brake_delay=0.05)
    gear = fb.Gear("G", efficiency=0.8, inertia=1e-4, mass=0.0, ratio=50.0)
    drive = {"crank": (motor, gear)}
    motion = fb.quintic(model, [[-1.5], [1.5]], [0.0, 0.8])
    q, qd, qdd = motion.q[:, 0], motion.qd[:, 0], motion.qdd[:, 0]
    slope = 0.2 + 0.1 * q
    sent = WHEEL * qdd + TABLE * slope * (slope * qdd + BEND * qd**2 + G)
    through = np.select([sent * qd > 0.0, sent * qd < 0.0], [sent / 0.8, sent * 0.75], sent)
    found = fb.drive_loads(model, motion, drive).data.motor_torque.values[:, 0]
    np.testing.assert_allclose(found, through / 50.0 + 3e-4 * 50.0 * qdd, rtol=1e-9, atol=1e-12)
    # without gravity a rotor at the table is as good as so much more mass
    turning, heavier = lift(tmp_path, 2.0, 0.5).replace(gravity=0), lift(tmp_path, 2.5)
    stops = [
        fb.emergency_stops(x, motion, drive).data.time.values
        for x in (turning, heavier.replace(gravity=0))
    ]
    np.testing.assert_allclose(*stops, rtol=1e-9)


def limited(folder: Path, force: float, more: str = "") -> fb.Model:
    """The lift whose slide, which follows the crank, may carry no more than a force."""
    file = folder / "limited.toml"
    own = f'axis = "y"\nlimits = {{ effort = {force} }}\n'
    text = (TEXT % (TABLE, 0.0)).replace('axis = "y"\n', own).replace("effort = 10", "effort = 80")
    links = '    { name = "rod", mass = 1 },\n    { name = "bar", mass = 1 },\n]'
    file.write_text(text.replace("\n]", f"\n{links}", 1) + more if more else text)
    return fb.load(file)


FOUR_BAR = """
[[joint]]
name = "left"
kind = "revolute"
parent = "base"
child = "rod"
origin = [3, 0]
[[joint]]
name = "right"
kind = "revolute"
parent = "base"
child = "bar"
origin = [4, 0]
passive = true
[[loop]]
name = "coupler"
kind = "distance"
distance = 1
frames = ["A", "B"]
[[frame]]
name = "A"
parent = "rod"
origin = [0, 1]
[[frame]]
name = "B"
parent = "bar"
origin = [0, 1]
"""


@pytest.mark.sample(1)
@pytest.mark.parametrize("more", ["", FOUR_BAR], ids=["open", "beside a four-bar"])
def test_what_reaches_the_follower_has_a_limit_of_its_own(tmp_path, more):
    """At rest the slide carries m g wherever the crank stands; moved it carries m (g + ÿ). No
    mass is added to what the crank alone could hold."""
    force = 30.0
    model = limited(tmp_path, force, more)
    at = np.zeros((3, model.nq))
    at[:, 0] = Q[:, 0]
    left = force / G - TABLE
    for found in (fb.payload(model, at[:2]), fb.payload_map(model, at[:2])):
        np.testing.assert_allclose(found.mass, left, rtol=1e-12)
        assert {found.joint_names[k] for k in found.joint} == {"slide"}
    motion = fb.quintic(model, [[-1.5, *[0.0] * (len(model.driven) - 1)],
                                [1.5, *[0.0] * (len(model.driven) - 1)]], [0.0, 1.2])  # fmt: skip
    q, qd, qdd = motion.q[:, 0], motion.qd[:, 0], motion.qdd[:, 0]
    rise = (0.2 + 0.1 * q) * qdd + BEND * qd**2
    most = np.where(G + rise > 0.0, force, -force) / (G + rise) - TABLE
    found = fb.payload(model, motion)
    assert found.joint_names[int(found.joint)] == "slide"
    assert float(found.mass) == pytest.approx(most.min(), rel=1e-4)
    if more:
        return
    study = fb.study(model, motion)
    (use,) = (x for x in study.verdict.uses if x.coordinate == "slide")
    assert (use.quantity, use.unit, use.limit) == ("force", "N", force)
    assert abs(use.value) == pytest.approx(TABLE * np.abs(G + rise).max(), rel=1e-5)
    # m (g + k² ÿ) reaches the limit at the pace k
    some = rise[rise != 0.0]
    k = np.sqrt((np.sign(some) * force / TABLE - G) / some)
    assert study.card.faster == pytest.approx(k.min(), rel=1e-4)
    assert (study.card.faster_joint, study.card.faster_quantity) == ("slide", "force")
    drive = {
        "crank": (
            fb.Motor("M", 2e-4, 2.0, 6.0, 900.0, 0.0),
            fb.Gear("G", 0.9, 0.0, 0.0, ratio=50.0),
        )
    }
    assert not any("slide" in words for words in fb.drive_loads(model, motion, drive).notices)
    tight = limited(tmp_path, 19.0)
    (told,) = (x for x in fb.drive_loads(tight, motion, drive).notices if "slide" in x)
    assert told.endswith("of its own limit of 19 N, without the mass of any drive: no choice of "
                         "motors mends that.")  # fmt: skip
    found = fb.payload(tight, at[:2])
    assert found.overloaded.all()
    assert found.card == "carries nothing at each of 2 postures · slide is overloaded already"
