"""The study of a duty cycle: each segment as loaded, RMS values and energies over the whole with
its rests, one verdict; by hand for a pendulum."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from freebody import FreebodyError

G, LENGTH, MASS = 9.81, 0.5, 2.0


def pendulum(effort: float = 60.0) -> fb.Model:
    limits = fb.Limits(-3.0, 3.0, 4.0, effort)
    return fb.planar("R", l=[LENGTH], lc=[LENGTH], m=[MASS], I=[0.0], limits=[limits])


def torque(mass: float, motion: fb.Motion) -> np.ndarray:
    """m g l cos q + m l² q̈."""
    q, qdd = motion.q[:, 0], motion.qdd[:, 0]
    return mass * (G * LENGTH * np.cos(q) + LENGTH**2 * qdd)


@pytest.fixture
def cycle() -> fb.DutyCycle:
    model = pendulum()
    there = fb.quintic(model, [[0.2], [1.2]], [0.0, 0.8])
    back = fb.quintic(model, [[1.2], [0.2]], [0.0, 0.6])
    loaded = fb.Segment(there, payload=3.0, wrenches={"tip": [0.0, -4.0, 0.0]}, dwell=0.5)
    return fb.DutyCycle([loaded, fb.Segment(back, dwell=2.0)], source="by hand")


def test_a_pendulum_by_its_closed_form(cycle, tmp_path: Path):
    """Loaded there, empty back: RMS over 3.9 s, the rests in it, and the largest of each."""
    model = pendulum()
    study = fb.study(model, cycle)
    assert study.checked
    loaded, empty = study.segments
    there, back = loaded.motion, empty.motion
    first = torque(5.0, there) + 4.0 * LENGTH * np.cos(there.q[:, 0])
    second = torque(2.0, back)
    np.testing.assert_allclose(loaded.data["tau"].values[:, 0], first, rtol=1e-12)
    np.testing.assert_allclose(empty.data["tau"].values[:, 0], second, rtol=1e-12)
    rests = (5.0 * G + 4.0) * LENGTH * np.cos(1.2), 2.0 * G * LENGTH * np.cos(0.2)
    moved = np.trapezoid(first**2, there.t) + np.trapezoid(second**2, back.t)
    rms = np.sqrt((moved + 0.5 * rests[0] ** 2 + 2.0 * rests[1] ** 2) / 3.9)
    of = study.summary.isel(coordinate=0)
    assert float(of.rms_torque) == pytest.approx(rms, rel=1e-12)
    assert float(of.rms_fraction) == pytest.approx(rms / 60.0, rel=1e-12)
    assert float(of.peak_torque) == pytest.approx(first.max(), rel=1e-12)
    assert float(of.peak_torque_segment) == 1.0
    power = [np.trapezoid(x * m.qd[:, 0], m.t) for x, m in ((first, there), (second, back))]
    assert float(of.net_work) == pytest.approx(sum(power), rel=1e-3)
    assert float(of.mean_power) == pytest.approx(sum(power) / 3.9, rel=1e-6)
    uses = {use.quantity: use for use in study.verdict.uses}
    assert uses["torque"].segment == 1
    assert "of segment 1" in uses["torque"].text
    assert uses["RMS torque"].value == float(of.rms_torque)
    assert uses["speed"].segment == 2
    assert study.verdict.outcome == "feasible"
    carried = study.card.payload
    most = [fb.payload(x.model, x.motion, wrenches=x.wrenches).mass for x in (loaded, empty)]
    assert carried == pytest.approx(min(most), rel=1e-12)
    assert study.card.payload_remark.endswith("of segment 1")
    assert study.card.rows[0].label == "carries by its effort limits"
    written = study.save(tmp_path / "out")
    names = {path.relative_to(tmp_path / "out").as_posix() for path in written}
    assert {"cycle.nc", "summary.csv", "card.json", "manifest.json", "segment-1/study.nc"} <= names
    kept = json.loads((tmp_path / "out" / "card.json").read_text("utf-8"))
    assert [case["payload"] for case in kept["load_cases"]] == [3.0, 0.0]
    with xr.open_dataset(tmp_path / "out" / "cycle.nc") as data:
        assert float(data["rms_torque"][0]) == float(of.rms_torque)


def test_the_pace_is_that_of_all_segments_together(cycle):
    """Speed gives out first, in the second segment; run so fast it is at its limit, the rests as
    long as before."""
    study = fb.study(pendulum(), cycle)
    factor = study.verdict.factor
    assert factor == pytest.approx(4.0 / study.segments[1].motion.peaks.velocity.size[0], rel=1e-8)
    always = pendulum().with_payload(1.0, com=[-0.5, 0.0], name="drive")
    fast = fb.study(always, cycle, speed=factor, wrenches={"tip": [0.0, 1.0, 0.0]})
    assert fast.loads == (3.0, 0.0)  # what rides on the axis rides in every segment
    assert [case.payload for case in fast.load_cases] == [4.0, 1.0]
    assert fast.cycle.duration == pytest.approx(1.4 / factor + 2.5)
    (speed,) = (use for use in fast.verdict.uses if use.quantity == "speed")
    assert speed.fraction == pytest.approx(1.0, rel=1e-8)
    np.testing.assert_array_equal(fast.segments[0].wrenches["tip"], [0.0, -3.0, 0.0])
    np.testing.assert_array_equal(fast.segments[1].wrenches["tip"], [0.0, 1.0, 0.0])


def test_a_rest_that_is_not_held_makes_the_cycle_infeasible():
    """The motion ends while gravity lets the pendulum go; to hold it there takes more."""
    model = pendulum(effort=9.0)
    t = np.linspace(0.0, 0.1, 21)
    q = 0.2 - 0.5 * 9.0 * t[:, None] ** 2
    falling = fb.Motion.of(model, t, q)
    bare = fb.study(model, falling)
    assert bare.verdict.outcome == "feasible"
    held = fb.study(model, fb.Segment(falling, dwell=1.0))
    assert held.verdict.outcome == "not feasible"
    assert held.verdict.factor == 0.0
    worst = MASS * G * LENGTH * np.cos(q[-1, 0])
    assert held.verdict.uses[0].value == pytest.approx(worst)
    assert float(held.summary["peak_torque"][0]) == pytest.approx(worst)
    assert held.card.payload == 0.0
    assert any("jumps" in words for words in held.warnings) or "elsewhere" in held.warnings[-1]


def test_what_a_study_of_a_cycle_does_not_take(cycle):
    model = pendulum()
    motion = cycle.segments[0].motion
    varying = fb.Segment(motion, wrenches={"tip": np.zeros((len(motion.t), 3))})
    with pytest.raises(FreebodyError, match="the wrench at 'tip' of segment 1 changes over time"):
        fb.study(model, varying)
    with pytest.raises(FreebodyError, match="smooth is for one motion"):
        fb.study(model, cycle, smooth=True)
