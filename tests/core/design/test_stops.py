"""Brakes: holding at the worst posture, and stops by closed form and step by step."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")

MOTOR = fb.Motor(
    "M", inertia=2e-4, continuous_torque=2.0, peak_torque=6.0, max_speed=400.0, mass=0.0,
    brake_torque=1.5, brake_delay=0.05,
)  # fmt: skip
GEAR = fb.Gear(
    "G", efficiency=0.8, inertia=1e-4, mass=0.0, ratio=50.0, peak_torque=200.0,
    momentary_torque=300.0,
)  # fmt: skip


def pendulum(gravity: float) -> fb.Model:
    return fb.planar("R").bind(l1=1.0, m1=4.0, lc1=0.5, I1=0.2).replace(gravity=(0.0, -gravity))


def test_a_stop_without_gravity_by_hand():
    """1.2 kg m² at 2 rad/s: the brake takes 75 N m of them; 0.75 of what the gear transmits reaches
    the rotor's 0.75 kg m²."""
    model = pendulum(0.0)
    (joint,) = model.joint_names
    motion = fb.quintic(model, [[0.0], [2.0]], [0.0, 15.0 / 8.0])  # at most 2 rad/s
    found = fb.emergency_stops(model, motion, {joint: (MOTOR, GEAR)})
    a = 75.0 / (0.75 + 0.75 * 1.2)
    of = found.summary.sel(joint=joint)
    speed = np.abs(motion.qd).max()
    assert speed == pytest.approx(2.0, rel=1e-4)
    assert float(of.time) == pytest.approx(0.05 + speed / a)
    assert float(of.way) == pytest.approx(0.05 * speed + 0.5 * speed**2 / a)
    assert float(of.gear_torque) == pytest.approx(1.2 * a)
    assert float(of.momentary_share) == pytest.approx(1.2 * a / 300.0)


@pytest.mark.sample(5)
@pytest.mark.parametrize("load", [-60.0, -20.0, 0.0, 30.0, 74.0])
@pytest.mark.parametrize("back", [0.5, 0.9])
def test_stops_step_by_step(load: float, back: float):
    """Rotor and slide with a screw between them, on a slope, integrated in small steps; the load of
    74 N turns it round before the brake acts."""
    lead = 2.0 * math.pi / 50.0
    screw = fb.Gear("S", efficiency=0.7, back_efficiency=back, inertia=1e-4, mass=0.0, lead=lead)
    M, J, v, x, t = 1.2, 3e-4 * 2500.0, 2.0, 0.0, 0.0
    h, most, against = 1e-5, 0.0, load
    while v > 0.0:
        brake = 75.0 if t >= 0.05 else 0.0
        # what the gear transmits makes both slow down alike; losses are of the one that is driven
        k = back if M * brake / J >= against else 1.0 / 0.7
        a = (brake + k * against) / (J + k * M)
        most = max(most, abs(M * a - against))
        v, x, t = v - h * a, x + h * (v - 0.5 * h * a), t + h
        if v <= 0.0 and t < 0.05:
            v, against = h * back * load / (J + back * M), -load
    assert (against < load) == (load > 70.0)
    got = stop(load, 2.0, screw)
    assert float(got.time) == pytest.approx(t, rel=2e-3)
    assert float(got.way) == pytest.approx(x, rel=2e-3)
    assert float(got.gear_torque) == pytest.approx(most, rel=1e-6)
    assert math.isinf(stop(-200.0, 1.0, screw).time)
    assert math.isinf(stop(200.0, 1.0, screw).way)  # stops, and falls back through the brake


def stop(load: float, speed: float, screw: fb.Gear) -> Any:
    """The stop of 1.2 kg on a slide at a speed, against a constant load."""
    slide = fb.planar("P").bind(m1=1.2, lc1=0.0, I1=0.0).replace(gravity=(-load / 1.2, 0.0))
    t = np.linspace(0.0, 0.1, 5)
    qd = np.full((5, 1), speed)
    motion = fb.Motion.of(slide, t, speed * t[:, None], qd, 0.0 * qd)
    (joint,) = slide.joint_names
    return fb.emergency_stops(slide, motion, {joint: (MOTOR, screw)}).summary.sel(joint=joint)


def test_brakes_hold_at_the_worst_posture():
    """The motion hangs down, where nothing has to be held; level, m g l is."""
    model = pendulum(10.0)
    (joint,) = model.joint_names
    motion = fb.quintic(model, [[-1.6], [-1.5]], [0.0, 1.0])
    found = fb.emergency_stops(model, motion, {joint: (MOTOR, GEAR)})
    share = found.loads.uses.sel(limit="brake", joint=joint).item()
    assert share == pytest.approx(4.0 * 10.0 * 0.5 / 75.0, rel=1e-6)
    loose = fb.Motor("L", 2e-4, 2.0, 6.0, 400.0, 0.0)
    catalogue = fb.PartCatalogue((MOTOR, loose), (GEAR,))
    assert len(fb.size(model, motion, catalogue).choices) == 1
    held = fb.size(model, motion, catalogue, hold=True)
    (choice,) = held.choices
    assert choice.drives[joint][0] is MOTOR
    assert ("L", "brake") in [(x.motor, x.limit) for x in held.rejected(joint)]
    assert "does not stop it" in repr(fb.emergency_stops(model, motion, {joint: (loose, GEAR)}))


def test_who_stands_falls_without_a_brake_that_holds():
    """A level pendulum, 20 N m; the brake holds 75 N m, acts late, or is none."""
    model = pendulum(10.0)
    (joint,) = model.joint_names
    still = fb.dwell(model, [0.0], 1.0)

    def of(motor: fb.Motor) -> fb.EmergencyStops:
        return fb.emergency_stops(model, still, {joint: (motor, GEAR)})

    a, slows = 0.75 * 20.0 / (0.75 + 0.75 * 1.2), (75.0 - 0.75 * 20.0) / (0.75 + 0.75 * 1.2)
    late = of(MOTOR).summary.sel(joint=joint)
    assert float(late.time) == pytest.approx(0.05 * (1.0 + a / slows))
    assert float(late.way) == pytest.approx(0.5 * a * 0.05**2 * (1.0 + a / slows))
    weak, none = replace(MOTOR, brake_torque=0.3), replace(MOTOR, brake_torque=None)
    assert "does not stop it" in repr(of(weak))
    assert "does not stop it" in repr(of(none))
    loads = fb.drive_loads(model, still, {joint: (none, GEAR)}, hold=True)
    assert "more than the brake" in repr(loads)
    assert loads.margin == 0.0
    nothing = fb.drive_loads(pendulum(0.0), still, {joint: (MOTOR, GEAR)})
    assert nothing.margin == math.inf
