"""The picture of docs/sweeps.md: how a reach of 0.8 m is shared between two links, and what it
costs at the shoulder.

python tools/sweep_picture.py docs/images/sweep.svg
"""

from __future__ import annotations

import sys

import numpy as np

import freebody as fb
from freebody.figures.figure import save, sheet
from freebody.figures.plots import Plot, plot

SHARE, LOAD = np.linspace(0.5, 0.8, 31), np.array([0.0, 1.0, 2.0, 3.0])


def peaks() -> dict[str, np.ndarray]:
    """By joint the largest torque (share, load), N m."""
    l1, payload = (x.ravel() for x in np.meshgrid(0.8 * SHARE, LOAD, indexing="ij"))
    l2 = 0.8 - l1
    lengths = {"l1": l1, "l2": l2, "lc1": l1 / 2, "lc2": l2 / 2}
    masses = {"m1": 3 * l1, "m2": 3 * l2, "I1": l1**3 / 4, "I2": l2**3 / 4}
    arm = fb.planar("RR", l=[0.4, 0.4], lc=[0.2, 0.2], m=[1.2, 1.2], I=[0.016, 0.016])
    motion = fb.quintic(arm, [[0.0, 0.0], [1.2, 2.4], [0.3, -0.9]], [0.0, 0.7, 1.4])
    design = lengths | masses | {"payload.mass": payload}
    over = {"design": design, "motion": motion}
    found = fb.sweep(arm, "inverse_dynamics", over=over, reduce="peak").tau_peak
    return {
        name: found.sel(coordinate=name).values.reshape(len(SHARE), len(LOAD))
        for name in arm.velocity_names
    }


def main(path: str) -> None:
    """Write the sheet: a plot a joint, a curve a load."""
    pictures = []
    for name, torque in peaks().items():
        curves = {f"{load:g} kg": torque[:, k] for k, load in enumerate(LOAD)}
        picture = Plot(
            f"peak torque of {name}",
            100 * SHARE,
            curves,
            "N m",
            peaks=False,
            size=(420.0, 260.0),
            across="upper arm, % of the reach",
        )
        pictures.append(plot(picture))
    save(sheet(pictures, "A reach of 0.8 m, shared", columns=2).text(), path, "picture")


if __name__ == "__main__":
    main(*sys.argv[1:])
