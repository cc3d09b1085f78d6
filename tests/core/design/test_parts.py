"""Motors, gears and bearings: makers' printed formulas and examples, catalogues and their
refusals."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import freebody as fb

RPM = math.pi / 30.0


def strain_wave(**other: object) -> fb.Gear:
    """A gear with the rated numbers of the worked example of its size."""
    given = {
        "efficiency": 0.7, "inertia": 1e-5, "mass": 0.5, "ratio": 100.0, "kind": "strain wave",
        "rated_torque": 108.0, "rated_speed": 2000 * RPM, "rated_life": 7000.0,
    }  # fmt: skip
    return fb.Gear("W", **{**given, **other})  # type: ignore[arg-type]


def test_a_printed_example_of_a_strain_wave_gear():
    """Honpine, How to select a harmonic reduction gear: 150, 82, 130 and 0 N m during 0.2, 3, 0.3
    and 0.2 s at 10, 20, 10 and 0 rpm give a mean of 89 N m."""
    torque, time, rpm = [150, 82, 130, 0], [0.2, 3, 0.3, 0.2], np.array([10, 20, 10, 0])
    mean = strain_wave().mean_torque(torque, rpm * RPM, time)
    assert f"{mean:.0f}" == "89"
    # by hand: (2·150³ + 60·82³ + 3·130³) / 65 = (6 750 000 + 33 082 080 + 6 591 000) / 65
    assert mean**3 == pytest.approx(46_423_080 / 65, rel=1e-12)
    assert fb.mean_load([-x for x in torque], -rpm, time, 3.0) == pytest.approx(mean, rel=1e-12)


def test_a_printed_selection_of_a_strain_wave_gear():
    """Harmonic Drive, CSF/CSG catalogue, Selection Example: 400, 320, 200 and 0 N m during 0.3, 3,
    0.4 and 0.2 s at 7, 14, 7 and 0 rpm have a mean of 319 N m at 12 rpm (the fractions are cut
    off); CSF-40-120 of 294 N m at 2000 rpm and 7000 h lasts 7610 h at 319 N m and 12·120 rpm."""
    torque, time, rpm = [400, 320, 200, 0], [0.3, 3, 0.4, 0.2], np.array([7, 14, 7, 0])
    gear = strain_wave(ratio=120.0, rated_torque=294.0)
    assert math.floor(gear.mean_torque(torque, rpm * RPM, time)) == 319
    assert math.floor(rpm @ time / sum(time)) == 12
    assert math.floor(gear.life(319.0, 12 * 120 * RPM)) == 7610


def test_the_life_of_gears_by_hand():
    """Equation 20.2 of Harmonic Drive AG; twice the speed halves it, twice the torque leaves an
    eighth."""
    gear = strain_wave()
    assert gear.life(108.0, 2000 * RPM) == pytest.approx(7000.0)
    assert gear.life(216.0, 4000 * RPM) == pytest.approx(7000.0 / 16.0)
    assert gear.life(0.0, 100.0) == gear.life(10.0, 0.0) == math.inf
    # by hand: 6000 h · 15/20 rpm · (1000/500)^(10/3) = 4500 h · 10.0794
    cycloidal = strain_wave(
        kind="cycloidal", rated_torque=1000.0, rated_speed=1500 * RPM, rated_life=6000.0
    )
    assert cycloidal.life(500.0, 2000 * RPM) == pytest.approx(4500 * 2 ** (10 / 3))
    unrated = fb.Gear("U", efficiency=0.9, inertia=0.0, mass=1.0, ratio=10.0)
    assert math.isnan(unrated.life(1.0, 1.0))


def test_the_load_and_life_of_bearings_by_hand():
    crossed = fb.Bearing("B", "crossed roller", 20_000.0, static_load=30_000.0, pitch_diameter=0.1)
    # 1000 + 2·50/0.1 = 2000 N across; 600 N along it is less than 1.5 of that
    assert crossed.equivalent_load(1000, -600, 50) == pytest.approx(2000 + 0.45 * 600)
    assert crossed.equivalent_load(1000, 4000, 50) == pytest.approx(0.67 * 6000)
    assert crossed.static_equivalent_load(1000, 600, 50) == pytest.approx(2000 + 0.44 * 600)
    # 10⁶/(60·10) h · (20000/2000)^(10/3)
    assert crossed.life(2000.0, 10 * RPM) == pytest.approx(1e6 / 600 * 10 ** (10 / 3))
    # ISO 281, a deep groove ball bearing of e = 0.26, X = 0.56, Y = 1.71
    ball = fb.Bearing("6", "radial", 10_000.0, x=0.56, y=1.71, e=0.26, load_factor=1.5)
    found = ball.equivalent_load([1000, 1000], [200, 500])
    assert found == pytest.approx([1000, 560 + 855])
    assert ball.life(1000.0, 100 * RPM) == pytest.approx(1e6 / 6000 * (10 / 1.5) ** 3)
    with pytest.raises(fb.FreebodyError, match="carries no tilting moment"):
        ball.equivalent_load(1.0, 0.0, 1.0)


def test_printed_examples_of_ball_bearings():
    """A bearing 6208 of C = 22.4 kN under 3.2 kN at 650 rpm: 343 million turns, 8795 h
    (Antifriction Bearings, example 1, scribd.com/document/365728687). Loads of X = 1, Y = 1.5 that
    change with speed and shock wear as 5767 N do, so 15 000 h take C = 49.2 kN (Khurmi and Gupta,
    A Textbook of Machine Design, chapter 27)."""
    small = fb.Bearing("6208", "radial", 22_400.0, x=1.0, y=0.0, e=1.0)
    assert f"{small.life(3200.0, 650 * RPM):.0f}" == "8795"
    assert f"{small.life(3200.0, 650 * RPM) * 650 * 60 / 1e6:.0f}" == "343"
    share, rpm = np.array([0.1, 0.1, 0.2, 0.6]), np.array([400, 500, 600, 800])
    radial, thrust, shock = [2000, 1500, 1000, 1200], [1200, 1000, 1500, 2000], [3, 1.5, 2, 1]
    bearing = fb.Bearing("215", "radial", 49_200.0, x=1.0, y=1.5, e=0.0)
    mean = fb.mean_load(shock * bearing.equivalent_load(radial, thrust), rpm, share, 3.0)
    assert f"{mean:.0f}" == "5767"
    assert bearing.life(mean, float(share @ rpm) * RPM) == pytest.approx(15_000, rel=1e-3)


def test_a_mean_load_is_that_of_equal_wear():
    rng = np.random.default_rng(3)
    load, speed, time = rng.normal(size=(3, 20))
    for p in (3.0, 10 / 3):
        mean = fb.mean_load(load, speed, np.abs(time), p)
        worn = np.sum(np.abs(speed) * np.abs(time) * np.abs(load) ** p)
        assert worn == pytest.approx(mean**p * np.sum(np.abs(speed * time)))
    assert fb.mean_load(load, 0.0 * speed, time, 3.0) == 0.0


def test_the_torques_of_a_motor_fall_with_the_speed():
    curve = ((0.0, 3.0), (100.0, 3.0), (200.0, 1.0))
    motor = fb.Motor("M", 1e-4, 1.0, 3.0, 200.0, 1.0, peak_curve=curve)
    assert motor.peak_at([0, 50, -150, 200, 201]) == pytest.approx([3, 3, 2, 1, 0])
    assert motor.continuous_at([0, 200, 201]) == pytest.approx([1, 1, 0])


GOOD = """
[[motor]]
name = "M1"
inertia = 1e-4
continuous_torque = 1.0
peak_torque = 3.0
max_speed = "3000 rpm"
mass = 1.0
peak_curve = [["0 rpm", 3.0], ["3000 rpm", 1.0]]

[[gear]]
name = "G1"
ratio = 50
efficiency = 0.8
inertia = 0
mass = 1.5
fits = ["M1"]
"""


def test_a_catalogue_from_a_file(tmp_path: Path):
    (tmp_path / "parts.toml").write_text(GOOD)
    found = fb.catalogue(tmp_path / "parts.toml")
    assert found.motor("M1").max_speed == pytest.approx(3000 * RPM)
    assert found.motor("M1").peak_curve[1] == pytest.approx((3000 * RPM, 1.0))
    assert found.gear("G1").back_efficiency == pytest.approx(2 - 1 / 0.8)
    with pytest.raises(fb.UnknownNameError, match="M1"):
        found.motor("M2")
    invented = fb.catalogue("invented")
    assert "Invented" in invented.note
    assert "11 motors, 19 gears, 3 bearings" in repr(invented)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("mass = 1.0", "", 2, "[[motor]] 1, 'M1': mass is missing"),
        ("mass = 1.0", "mass = -1.0", 2, "[[motor]] 1, 'M1': mass is -1 kg, expected"),
        ("mass = 1.0", 'mass = "heavy"', 8, "'M1': mass is 'heavy', expected a number"),
        ("mass = 1.0", "mas = 1.0", 8, "Did you mean 'mass'"),
        ('name = "M1"', "", 2, "[[motor]] 1: name is missing"),
        ("peak_torque = 3.0", "peak_torque = 0.5", 2, "is below continuous_torque"),
        ('["3000 rpm", 1.0]', '["3000 rpm", 4.0]', 2, "torques must not"),
        ("efficiency = 0.8", "efficiency = 80", 11, "'G1': efficiency is 80, expected a number"),
        ("efficiency = 0.8", "efficiency = 0.4", 11, "may lock itself; give its back_efficiency"),
        ("ratio = 50", "ratio = 50\nlead = 0.01", 11, "a ratio, or the lead of a screw"),
        ("inertia = 0\n", "inertia = 0\nrated_life = 7000\n", 11, "belong together"),
        ('fits = ["M1"]', 'fits = ["M9"]', None, "no motor 'M9'"),
        ('fits = ["M1"]', "fits = [1]", 17, "fits must be a list of names"),
        ("[[gear]]", "[gear]", 11, "write [[gear]] above each"),
        ('"3000 rpm"\n', '"3000 mph"\n', 7, 'such as "30 deg/s" or "30 rpm"'),
    ],
)
def test_what_a_catalogue_refuses(tmp_path: Path, old: str, new: str, line: int | None, words: str):
    file = tmp_path / "parts.toml"
    assert old in GOOD
    file.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(fb.FileError, match=re.escape(words)) as caught:
        fb.catalogue(file)
    where = f"{file}:{line}:" if line else f"{file}:"
    assert str(caught.value).startswith(where), caught.value


def test_the_page_names_every_key():
    page = (Path(__file__).parents[3] / "docs" / "sizing.md").read_text(encoding="utf-8")
    for kind in (fb.Motor, fb.Gear, fb.Bearing):
        for number in kind.NUMBERS:
            assert f"`{number.name}`" in page
            assert number.what in page


def test_parts_that_nobody_builds():
    with pytest.raises(fb.FreebodyError, match="a crossed roller bearing needs pitch_diameter"):
        fb.Bearing("B", "crossed roller", 100.0)
    with pytest.raises(fb.FreebodyError, match="expected 'crossed roller' or 'radial'"):
        fb.Bearing("B", "ball", 100.0)  # type: ignore[arg-type]
    with pytest.raises(fb.FreebodyError, match="its life has no life_exponent"):
        strain_wave(kind="planetary")
    assert strain_wave(kind="planetary", life_exponent=3.3).life_exponent == 3.3
    twice = fb.catalogue("invented").motors[:1] * 2
    with pytest.raises(fb.FreebodyError, match="there are two of this name"):
        fb.PartCatalogue(twice)
