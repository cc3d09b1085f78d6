"""Robots that cannot move their tip in all directions: a palletiser, an arm with five axes, a
delta."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import freebody as fb

PALLETISER = """
name = "palletiser"

[[link]]
name = "ground"

[[link]]
name = "column"
mass = 20

[[link]]
name = "arm"
mass = 10

[[link]]
name = "triangle"

[[link]]
name = "forearm"
mass = 8

[[link]]
name = "wrist"
mass = 2

[[link]]
name = "hand"
mass = 1

[[joint]]
name = "turn"
kind = "revolute"
parent = "ground"
child = "column"
axis = "z"

[[joint]]
name = "swing"
kind = "revolute"
parent = "column"
child = "arm"
origin = [0.1, 0, 0.4]
axis = "y"
limits = { lower = -1.6, upper = 1.6 }

[[joint]]
name = "parallel"
kind = "revolute"
parent = "arm"
child = "triangle"
origin = [0, 0, 0.7]
axis = "y"
mimic = { joint = "swing", ratio = -1 }

[[joint]]
name = "lift"
kind = "revolute"
parent = "triangle"
child = "forearm"
axis = "y"
limits = { lower = -1.5, upper = 1.5 }

[[joint]]
name = "level"
kind = "revolute"
parent = "forearm"
child = "wrist"
origin = [0.6, 0, 0]
axis = "y"
mimic = { joint = "lift", ratio = -1 }

[[joint]]
name = "spin"
kind = "revolute"
parent = "wrist"
child = "hand"
origin = [0.15, 0, 0]
axis = "z"

[[frame]]
name = "tip"
parent = "hand"
origin = [0, 0, -0.2]
"""
"""Four joints, the wrist kept level by two that follow; y axes turn x towards -z."""


def palletiser(folder: Path) -> fb.Model:
    """See `PALLETISER`."""
    file = folder / "palletiser.toml"
    file.write_text(PALLETISER)
    return fb.load(file)


def five_axes() -> fb.Model:
    """Turn, three that pitch, roll: the direction of the hand stays in the vertical plane of the
    arm."""
    rows = [
        {"d": 0.3, "alpha": np.pi / 2},
        {"a": 0.4},
        {"a": 0.3},
        {"alpha": np.pi / 2},
        {"d": 0.15},
    ]
    return fb.dh(rows, convention="standard")


DELTA = {"base": 0.2, "arm": 0.3, "rod": 0.7, "platform": 0.06, "half": 0.05}
"""Metres: drives from the middle, lengths, where the platform's rods are from its middle, and half
the distance of a pair."""


def delta_points(k: int) -> tuple[np.ndarray, np.ndarray]:
    """(the platform's two points of arm k (2, 3), the angle of its plane in x, y (3, 3))."""
    c, s = np.cos(2 * np.pi * k / 3), np.sin(2 * np.pi * k / 3)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.array([[DELTA["platform"], y, 0.0] for y in (DELTA["half"], -DELTA["half"])]) @ R.T, R


def delta(folder: Path, passive: Sequence[int] = ()) -> fb.Model:
    """Three driven arms, six rods in parallel pairs to a platform."""
    lines = [
        'name = "delta"\ntip = "platform"',
        '[[link]]\nname = "ground"',
        '[[link]]\nname = "platform"\nmass = 0.4\ninertia = [1e-3, 0, 0, 1e-3, 0, 2e-3]',
        '[[joint]]\nname = "pose"\nkind = "free"\nparent = "ground"\nchild = "platform"',
        "passive = true",
    ]
    for k in range(3):
        points, _ = delta_points(k)
        lines += [
            f'[[link]]\nname = "arm{k}"\nmass = 0.8\ncom = [0.15, 0, 0]',
            "inertia = [1e-3, 0, 0, 6e-3, 0, 6e-3]",
            f'[[joint]]\nname = "drive{k}"\nkind = "revolute"\nparent = "ground"\naxis = "y"',
            f'child = "arm{k}"\npassive = {str(k in passive).lower()}',
            f'steps = [{{ turn = "z", angle = "{120 * k} deg" }}, {{ shift = [0.2, 0, 0] }}]',
            "limits = { lower = -1, upper = 2.5, velocity = 20 }",
        ]
        for side, point, y in zip("ab", points.tolist(), (0.05, -0.05), strict=True):
            lines += [
                f'[[frame]]\nname = "elbow{k}{side}"\nparent = "arm{k}"\norigin = [0.3, {y}, 0]',
                f'[[frame]]\nname = "ball{k}{side}"\nparent = "platform"\norigin = {point}',
                f'[[loop]]\nname = "rod{k}{side}"\nkind = "distance"\ndistance = 0.7',
                f'frames = ["elbow{k}{side}", "ball{k}{side}"]',
            ]
    lines += ['[home]\n"pose.z" = -0.75', *(f'drive{k} = "30 deg"' for k in range(3))]
    file = folder / "delta.toml"
    file.write_text("\n".join(lines))
    return fb.load(file)
