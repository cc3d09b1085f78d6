"""A moving robot as one picture without script: drawings of its poses over each other, shown in
turn by the style sheet, so that it moves wherever an SVG image may stand."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Drawing, Element, Label
from freebody.figures.kinematic import robot_scene, tip_path
from freebody.figures.layers import bare_robot
from freebody.figures.snapshot import snapshot
from freebody.figures.svg import Picture, alike
from freebody.model.model import Model

_RATE = 15.0
"""Poses a second, as many as an eye takes for a motion."""
_MOST = 75
"""Poses of a motion; of a long one they are further apart in time."""
_STYLE = (
    ".pose{visibility:hidden;animation:step-end infinite}"
    "@keyframes pose%d{0%%{visibility:visible}%.9g%%,100%%{visibility:hidden}}"
    "@media (prefers-reduced-motion:reduce){.pose{animation:none!important}}"
)
"""Shows one pose after the other: the number of poses, and the share of one in per cent.

What else a motion has of its own each pose says itself, so that several pictures may stand in one
page, where style sheets count for all.
"""


def moving_picture(
    model: Model, t: Array, q: Array, path: Array | None, width: float, tallest: float
) -> Picture:
    """The picture of a robot that runs through a motion in its own time, again and again.

    t: (k,), s. q: (k, nq). path: (k, dim), m, of the tip, or None. A reader who wants no motion, or
    whose program shows none, sees the first pose.
    """
    seconds = float(t[-1] - t[0])
    count = int(np.clip(round(_RATE * seconds), 2, _MOST))
    instants = t[0] + seconds * np.arange(count) / count
    poses = q[np.minimum(np.searchsorted(t, instants), len(t) - 1)]
    still = np.zeros(model.nv)
    seen = [snapshot(model, pose, still, still) for pose in poses]
    size = max(one.size for one in seen)
    seen = [replace(one, common_size=size) for one in seen]
    shown = [one.pose for one in seen]
    scene = robot_scene(shown, path, f"{model.name} in motion", size)
    tip_path(scene, path)
    moments = [Drawing(scene.view, scene.title) for _ in seen]
    for moment, one in zip(moments, seen, strict=True):
        if model.dim == 3:
            bare_robot.shadow(moment, one, shown)
        bare_robot.structure(moment, one)
    resting = _everywhere(moments)
    scene.add(*resting)
    for moment in moments:
        moment.elements = [
            e for e in moment.elements if e not in resting and not isinstance(e, Label)
        ]
    below, *drawn = alike([scene, *moments], width, tallest)
    frames = (
        f'<g class="pose" style="animation-delay:{seconds * (k / count - 1.0):.9g}s;'
        f"animation-duration:{seconds:.9g}s;animation-name:pose{count}"
        f'{"" if k else ";visibility:visible"}">{_LINES.sub(_relative, one.body)}</g>'
        for k, one in enumerate(drawn)
    )
    style = f"<style>{_STYLE % (count, 100.0 / count)}</style>"
    return Picture(style + below.body + "".join(frames), width, below.height, scene.title)


def _everywhere(moments: list[Drawing]) -> list[Element]:
    """The elements of the first drawing that all have: what does not move."""
    return [e for e in moments[0].elements if all(e in moment.elements for moment in moments)]


_LINES = re.compile(r' d="M([-\d. L]+)(Z?)"')
"""Path data of a polyline."""


def _relative(found: re.Match[str]) -> str:
    """Path data of a polyline as its first point and steps, which are half as long as places, in
    whole tenths, so that no rounding adds up."""
    tenths = [round(10.0 * float(x)) for x in found[1].replace("L", " ").split()]
    first, steps = tenths[:2], [b - a for a, b in zip(tenths, tenths[2:], strict=False)]
    return f' d="M{_pairs(first)}{"l" if steps else ""}{_pairs(steps)}{found[2].lower()}"'


def _pairs(tenths: list[int]) -> str:
    """Numbers of path data, with a blank where no sign parts them."""
    texts = (f"{x / 10:g}".replace("0.", ".") if abs(x) < 10 else f"{x / 10:g}" for x in tenths)
    return " ".join(texts).replace(" -", "-")
