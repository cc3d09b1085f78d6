"""How long the choice of drives takes: 200 motors × 50 gears × 6 joints of a UR5e × 10 motions of
1000 samples, masses fed back. All parts are invented.

    python benchmarks/sizing.py
"""

from __future__ import annotations

import time

import numpy as np

import freebody as fb


def catalogue(motors: int, gears: int) -> fb.PartCatalogue:
    """Motors and gears of many sizes, heavier and dearer with their torque."""
    rng = np.random.default_rng(0)
    some_motors, some_gears = [], []
    for k in range(motors):
        torque, speed = 0.05 * 10 ** (2.2 * rng.random()), rng.uniform(250.0, 630.0)
        peak = torque * rng.uniform(2.5, 3.5)
        some_motors.append(
            fb.Motor(
                f"M{k}", inertia=1e-4 * torque**1.3 * rng.uniform(1.0, 5.0),
                continuous_torque=torque, peak_torque=peak, max_speed=speed,
                mass=0.3 + torque * rng.uniform(0.6, 1.3),
                price=80.0 + torque * rng.uniform(50.0, 130.0),
                peak_curve=((0.0, peak), (0.6 * speed, peak), (speed, 0.4 * peak)),
            )
        )  # fmt: skip
    for k in range(gears):
        rated = 5.0 * 10 ** (2.0 * rng.random())
        some_gears.append(
            fb.Gear(
                f"G{k}", efficiency=rng.uniform(0.65, 0.9), inertia=1e-6 * rated,
                mass=0.1 + rated / 60.0, ratio=float(rng.choice([50, 80, 100, 120, 160])),
                price=200.0 + rated * rng.uniform(1.4, 2.8), peak_torque=2.2 * rated,
                average_torque=1.3 * rated, rated_torque=rated, rated_speed=209.0,
                rated_life=7000.0, max_speed=680.0, average_speed=370.0,
                kind=("strain wave", "cycloidal")[k % 2],
            )
        )  # fmt: skip
    return fb.PartCatalogue(tuple(some_motors), tuple(some_gears))


def motions(arm: fb.Model, count: int, samples: int) -> list[fb.Segment]:
    """Loops through random postures, each second one with 5 kg."""
    rng, found = np.random.default_rng(0), []
    for k in range(count):
        q = rng.uniform(-1.5, 1.5, (3, arm.nq))
        motion = fb.quintic(arm, [*q, q[0]], acceleration=rng.uniform(1.5, 4.5))
        t = np.linspace(motion.t[0], motion.t[-1], samples)
        found.append(fb.Segment(fb.Motion.of(arm, t, *motion.at(t)), 5.0 if k % 2 else None))
    return found


def main() -> None:
    arm = fb.load("ur5e")
    cycles, parts = motions(arm, 10, 1000), catalogue(200, 50)
    for words in ("with what is compiled for it", "again"):
        wall, processor = time.perf_counter(), time.process_time()
        found = fb.size(arm, cycles, parts, life=5000.0)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        print(f"{words}: {wall:.2f} s, of the processor {processor:.2f} s; {found!r}")


if __name__ == "__main__":
    main()
