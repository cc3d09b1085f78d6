"""The README's moving pictures: a UR5e and a five-bar robot, as `study.figure("animation")` has
them.

    python tools/moving_pictures.py docs/images

A test holds them to what this script makes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import freebody as fb
from freebody.figures.moving_picture import moving_picture

ROBOTS = "ur5e", "five_bar"
QUICKER = 2.0
"""The pace of the default motion, which needs half as many pictures then."""


def picture(name: str) -> str:
    """SVG text of a bundled robot in motion."""
    model = fb.load(name)
    motion = fb.default_motion(model).faster(QUICKER)
    assert model.tip is not None
    tips = fb.forward_kinematics(model, motion.q, model.tip)[:, : model.dim, model.dim]
    return moving_picture(model, motion.t, motion.q, tips, 460.0, 400.0).text()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for name in ROBOTS:
        Path(sys.argv[1], f"{name}_moving.svg").write_text(picture(name), encoding="utf-8")
