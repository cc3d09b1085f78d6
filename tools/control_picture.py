"""The picture of docs/control.md: a UR5e under torques that its controller does not know, without
and with what the momentum observer finds.

python tools/control_picture.py docs/images/control.svg
"""

from __future__ import annotations

import sys

import numpy as np

import freebody as fb
from freebody.figures.figure import save, sheet
from freebody.figures.plots import Plot, plot

ROBOT = fb.load("ur5e")
START, GOAL = np.array([0.0, -1.5, 1.5, 0.0, 0.5, 0.0]), np.array([0.5, -1.0, 1.0, 0.3, 0.8, -0.4])
HIDDEN, STILL, H = np.array([5.0, 0.0, 3.0, 0.0, 0.0, 0.0]), np.zeros(6), 1e-3
SHOWN = (0, 2)
TIMES = np.linspace(0.0, 1.5, 151)


def closed_loop(ko: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions at TIMES, and at every sampling instant what the observer finds."""
    observe, found = fb.kernel(ROBOT, "momentum_observer"), []
    memory = {"tau": fb.gravity_torque(ROBOT, START), "integral": np.zeros(6)}

    def controller(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        given = (q, qd, memory["tau"], H, memory["integral"], np.full(6, ko))
        r, memory["integral"] = observe(*given)
        found.append(r)
        wanted = fb.computed_torque(ROBOT, q, qd, GOAL, STILL, STILL, 100.0, 20.0)
        memory["tau"] = wanted - r
        return memory["tau"] + HIDDEN

    run = fb.simulate(
        ROBOT, START, STILL, TIMES, controller, sample_time=H, tolerance=1e-6, record="q"
    )
    return run.q.values, np.array(found)[::10]


def main(path: str) -> None:
    """Write the sheet: errors without and with the observer, and what it finds."""
    (alone, _), (helped, r) = closed_loop(0.0), closed_loop(30.0)

    def curves(values: np.ndarray) -> dict[str, np.ndarray]:
        return {ROBOT.joint_names[k]: values[:, k] for k in SHOWN}

    size = (340.0, 230.0)
    pictures = [
        plot(Plot(title, TIMES[: len(values)], curves(values), unit, peaks=False, size=size))
        for title, values, unit in (
            ("computed torque: error", GOAL - alone, "rad"),
            ("with the observer: error", GOAL - helped, "rad"),
            ("what the observer finds", r, "N m"),
        )
    ]
    save(
        sheet(pictures, "Torques that the controller does not know", columns=3).text(),
        path,
        "picture",
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
