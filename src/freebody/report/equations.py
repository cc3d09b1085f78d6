"""The equations of motion in the report, where they are short enough to read."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.derivations.base import by_base_parameters
from freebody.derivations.equations import SHORT, Equations, equations
from freebody.derivations.expression import size
from freebody.model.model import Model

JOINTS = 4
"""Joints up to which a robot's equations are looked at."""


@dataclass(frozen=True)
class Shown:
    """Equations as MathML; base: whether they are in base parameters, which stand below them."""

    mathml: str
    base: bool


def shown(model: Model) -> Shown | None:
    """The equations of a small arm, by base parameters where only that is short; None where neither is."""
    if not _has_closed_form(model):
        return None
    closed = equations(model)
    view = next((view for view in ("named", "base") if _is_short(closed, view)), None)
    if view is None:
        return None
    return Shown(closed.mathml(view), view == "base")


def _has_closed_form(model: Model) -> bool:
    """Whether there are few joints of one axis each, none that follows another, and no loop."""
    bodies = model.bodies
    simple = all(body.kind.name in ("revolute", "continuous", "prismatic") for body in bodies)
    return len(bodies) <= JOINTS and simple and all(b.joint.mimic is None for b in bodies) and not model.loops


def _is_short(closed: Equations, view: str) -> bool:
    if view == "named":
        return closed.is_short
    by_base = by_base_parameters(closed)
    lines = [line for group in closed.groups("base") for line in group]
    return by_base.is_short and sum(map(size, lines)) <= SHORT
