"""The picture of docs/motions.md: the same waypoints by each planner, positions, speeds and
accelerations.

python tools/motions_picture.py docs/images/motions.svg
"""

from __future__ import annotations

import sys

import numpy as np

import freebody as fb
from freebody.figures.figure import save, sheet
from freebody.figures.plots import Plot, plot

ROBOT = fb.load("ur5e")
WAY = np.zeros((3, 6))
WAY[:, 1:3] = [[-1.2, 1.4], [-2.2, 2.0], [-1.0, 1.0]]
LIMIT = {"acceleration": 4.0}
MOTIONS = {
    "quintic": fb.quintic(ROBOT, WAY, **LIMIT),
    "trapezoid": fb.trapezoid(ROBOT, WAY, **LIMIT),
    "s_curve": fb.s_curve(ROBOT, WAY, jerk=20.0, **LIMIT),
    "spline": fb.spline(ROBOT, WAY, **LIMIT),
}
QUANTITIES = (("position", "rad"), ("speed", "rad/s"), ("acceleration", "rad/s²"))


def main(path: str) -> None:
    """Write the sheet: a row a quantity, a column a planner."""
    pictures = []
    for k, (quantity, unit) in enumerate(QUANTITIES):
        for name, motion in MOTIONS.items():
            t = np.linspace(0.0, motion.duration, 1201)
            values = motion.at(t)[k]
            curves = {ROBOT.joint_names[i]: values[:, i] for i in (1, 2)}
            limits = (4.0, -4.0) if quantity == "acceleration" else ()
            title = f"{name}: {quantity}"
            size = (300.0, 190.0)
            pictures.append(plot(Plot(title, t, curves, unit, limits, peaks=False, size=size)))
    save(sheet(pictures, "One way, four planners", columns=4).text(), path, "picture")


if __name__ == "__main__":
    main(*sys.argv[1:])
