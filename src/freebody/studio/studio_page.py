"""The page of a studio as one HTML file: the robot drawn, its joints, and the script by which both
are moved; without scripts a drawing and a table of limits."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.any_chain.effort_limits import effort_limits, followers
from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.figures.kinematic import robot_drawing
from freebody.figures.snapshot import snapshot
from freebody.figures.svg import picture
from freebody.lazy import cached_property
from freebody.loops.assembly import assemble
from freebody.model.doubt_rules.aspects import ALL
from freebody.model.doubts import capital, doubts_used
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.motion.ranges import position_columns, ranges
from freebody.motion.smooth_friction import without_friction
from freebody.moving.renderer import renderer
from freebody.moving.scene import Scene, joint_marks, scene
from freebody.moving.shape_solids import drawn_shapes
from freebody.outputs.number_text import significant
from freebody.outputs.pages import joined, packed
from freebody.report.page import filled, how_read, source
from freebody.report.tables import shortened
from freebody.report.what_if import round_up
from freebody.studio.kernels import PageKernel, Studied, kernels
from freebody.studio.states import COUNT, DAMPING, STEP, states
from freebody.trees.positions import random_state
from freebody.trees.public_calls import single_vector

_FILES = ("proof.js", "state.js", "bench.js", "run.js", "studio.js")
_POSES = 24
"""Poses that the first view is chosen for."""
_CLOSER = 0.8
"""The share of the box around them that is seen: few poses are at its edges."""
_STILL = (560.0, 480.0)  # of the drawing without scripts, pixels
_CONTENTS = ("robot", "Robot"), ("joints", "Joints"), ("state", "State"), ("method", "Method")


@dataclass(frozen=True)
class SlidJoint:
    """A coordinate with a slider: its places among positions and rates, its unit, its limits where
    it has them."""

    name: str
    at: int
    rate: int
    turns: bool
    low: float | None
    high: float | None
    effort: float | None
    moves: bool
    """Whether it moves the tip in the rows that count."""

    @property
    def data(self) -> dict[str, Any]:
        """The coordinate as a page reads it."""
        unit = "N m" if self.turns else "N"
        return {**vars(self), "unit": unit, "ends": self.ends}

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the slider: the limits, or half a turn or a metre to where there is none."""
        free = math.pi if self.turns else 1.0
        low = -free if self.low is None else self.low
        high = free if self.high is None else self.high
        return low, high

    @property
    def range(self) -> str:
        """The limits in print."""
        unit, scale = ("°", 180.0 / math.pi) if self.turns else (" m", 1.0)
        low, high = (
            "no limit" if x is None else f"{significant(scale * x)}{unit}"
            for x in (self.low, self.high)
        )
        return low if low == high == "no limit" else f"{low} to {high}"


@dataclass(frozen=True)
class StudioPage:
    """A studio's page of a robot that stands at q first."""

    robot: Studied
    q: Array

    @property
    def model(self) -> Model:
        """The robot."""
        return self.robot.model

    @cached_property
    def made(self) -> dict[str, PageKernel]:
        """The kernels by name."""
        return {kernel.name: kernel for kernel in kernels(self.robot)}

    @cached_property
    def joints(self) -> list[SlidJoint]:
        """The coordinates that have a slider: all but those of quaternions."""
        model, allowed, efforts = self.model, ranges(self.model), effort_limits(self.model)
        moving = self.robot.moving if self.robot.arm and self.robot.rows else range(model.nv)

        def number(x: Any) -> float | None:
            return float(x) if math.isfinite(x) else None

        return [
            SlidJoint(
                model.velocity_names[k], int(at), int(k), bool(allowed.turns[k]),
                number(allowed.lower[k]), number(allowed.upper[k]), number(efforts[k]),
                k in moving,
            )
            for at, k in zip(*position_columns(model), strict=True)
        ]  # fmt: skip

    @cached_property
    def heaviest(self) -> float:
        """The largest load of the slider, kg; 0 where the robot has no tip that carries it."""
        return round_up(0.5 * self.model.mass) if self.robot.tip is not None else 0.0

    @property
    def data(self) -> dict[str, Any]:
        """All that the page's script is given."""
        model, robot = self.model, self.robot
        given = states(robot, self.q, self.heaviest or 1.0, self.made)
        return {
            "scene": self._scene().data,
            "bodies": len(model.bodies),
            "nq": model.nq,
            "nv": model.nv,
            "dim": model.dim,
            "q0": self.q.tolist(),
            "joints": [joint.data for joint in self.joints],
            "carried": self._carried(),
            "parents": [body.parent for body in model.bodies],
            "driven": list(model.driven),
            "tip": robot.tip,
            "arm": robot.arm,
            "loops": bool(model.loops),
            "sizes": min(len(robot.rows), model.nv) if robot.arm else 0,
            "whole": robot.arm and len(robot.rows) > model.dim,
            "heaviest": self.heaviest,
            "step": STEP,
            "damping": DAMPING,
            "proofs": {name: kernel.proof(given) for name, kernel in self.made.items()},
        }

    def _carried(self) -> list[int]:
        """The slider, for each body, that moves the joint it hangs on; -1 without one."""
        sliders = {joint.rate: k for k, joint in enumerate(self.joints)}
        first = (at.v[0] if at.v else -1 for at in self.model.coordinates)
        return [sliders.get(k, -1) for k in first]

    def _scene(self) -> Scene:
        """The robot as solids in a view that holds most of what an open chain reaches, on the floor
        that its first pose stands on."""
        first = scene(self.model, self.q[None])
        if self.model.loops:
            return first
        q, _, _ = random_state(self.model, 0, _POSES - 1)
        wide = scene(self.model, np.vstack([self.q, q]))
        middle = wide.box.mean(axis=0)
        return replace(wide, box=middle + _CLOSER * (wide.box - middle), level=first.level)

    @property
    def script(self) -> str:
        """The page's script."""
        made = list(self.made.values())
        text = "\n".join(kernel.script for kernel in made)
        known = ", ".join(kernel.name for kernel in made)
        own = joined("freebody.studio", _FILES)
        data = packed(json.dumps(self.data, allow_nan=False, separators=(",", ":")))
        own = own.replace('"STUDIO"', f'"{data}"')
        return f'"use strict";\n{text}\nconst kernels = {{{known}}};\n{renderer()}\n{own}\n'

    @property
    def html(self) -> str:
        """The HTML text."""
        robot, model = self.robot, self.model
        name, _ = source(model)
        return filled(
            "studio.html",
            package="freebody.studio",
            scripts=(self.script,),
            model=model,
            joints=self.joints,
            names=shortened([joint.name for joint in self.joints]),
            marks=joint_marks(model, self.q),
            robot=robot,
            page=self,
            still=picture(robot_drawing(model, self.q), *_STILL).text(css=False),
            source=name,
            ordered=["x", "y", "z"][: model.dim],
            closed_form="branches" in self.made,
            spare=robot.arm and model.nv > len(robot.rows) > 0,
            dissipates=without_friction(model) != model,
            followed=followers(model) is not None,
            limited=any(joint.range != "no limit" for joint in self.joints),
            unslid=model.nq - len(self.joints),
            doubts=[capital(doubt.text) for doubt in doubts_used(model, *ALL)],
            readings=how_read(model),
            bodies=drawn_shapes(model).words,
            proven=COUNT,
            step=STEP,
            contents=_CONTENTS,
            math_style="",
        )


def studio_page(model: Model, q: Any = None) -> str:
    """The HTML text of a robot's studio.

    q: (nq,), where it stands first, rad or m; default: a pose in which it is clearly visible. The
    loops of a closed chain are closed near it. Raises FreebodyError for a robot that cannot move, a
    family, and parameters without value.
    """
    caller = "freebody studio"
    model.require_values(caller)
    if model.family:
        raise FamilyError(caller, model.name, model.family)
    if not model.nv:
        raise FreebodyError(f"{caller}: {model.name!r} has no joint that moves.")
    start = snapshot(model, caller=caller).q if q is None else single_vector(caller, model, "q", q)
    if model.loops:
        start = assemble(model, start)
    return StudioPage(Studied(model), np.asarray(start, dtype=float)).html
