"""The pictures of docs/reach.md: what a UR5e reaches and lifts, and how well it moves there.

python tools/reach_pictures.py docs/images/reach.svg
"""

from __future__ import annotations

import sys

import numpy as np

import freebody as fb
from freebody.figures.figure import save, sheet

ARM = fb.load("ur5e")
STANDS = [0.4, -1.3, 1.6, -1.8, -1.5, 0.3]
DOWN = np.diag([1.0, -1.0, -1.0])
TABLE = np.linspace(-1.2, 1.2, 49)


def main(path: str) -> None:
    """Write the sheet: ways to points of a table; payload and dexterity in an upright plane; the
    ellipsoids of one posture."""
    x, y = np.meshgrid(TABLE, TABLE)
    table = np.stack([x, y, np.full_like(x, 0.05)], axis=-1)
    cell = fb.workspace(ARM, table, orientation=DOWN)
    ways = np.where(cell.reached, cell.ways, np.nan)

    x, z = np.meshgrid(np.linspace(-1.1, 1.1, 45), np.linspace(-0.9, 1.3, 45))
    side = np.stack([x, np.full_like(x, -0.13), z], axis=-1)
    poses = np.tile(np.eye(4), (*x.shape, 1, 1))
    poses[..., :3, :3], poses[..., :3, 3] = DOWN, side
    found = fb.inverse_kinematics(ARM, poses, limits="drop")
    q = np.nan_to_num(found.q)

    def best(values: np.ndarray) -> np.ndarray:
        """Of the branches, NaN where there is none."""
        most = np.where(found.valid, values, -np.inf).max(axis=-1)
        return np.where(np.isfinite(most), most, np.nan)

    lifts = best(fb.payload_map(ARM, q, point=[0, 0, 0.1]).mass)
    moves = best(fb.dexterity(ARM, q).smallest)
    figures = (
        fb.map_diagram(ARM, table, ways, STANDS, title="ways to a point of the table, from above"),
        fb.map_diagram(ARM, side, lifts, STANDS, title="largest payload in kg, gripper downwards"),
        fb.map_diagram(ARM, side, moves, STANDS, title="distance to a singular posture"),
        fb.ellipsoid_diagram(ARM, STANDS),
    )
    pictures = [figure.picture for figure in figures]
    save(sheet(pictures, "Reach of a UR5e").text(), path, "the pictures of reach")


if __name__ == "__main__":
    main(sys.argv[1])
