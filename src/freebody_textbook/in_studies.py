"""Equations of motion for a study's page, if they are short enough to read; loaded by name through
`freebody.beside`, so that freebody does not depend on the textbook."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody_textbook.equations.base_parameters import short_by_base
from freebody_textbook.equations.equations import equations
from freebody_textbook.render import page

JOINTS = 4
"""Joints up to which a robot's equations are looked at."""


@dataclass(frozen=True)
class Shown:
    """Equations as MathML; base: whether they use base parameters, whose definitions follow
    them."""

    mathml: str
    base: bool


def shown(model: Model) -> Shown | None:
    """The equations of a small arm, in base parameters if only these are short; None if neither is
    short."""
    if not _has_closed_form(model):
        return None
    closed = equations(model)
    if closed.is_short:
        return Shown(closed.mathml("named"), base=False)
    groups = short_by_base(closed)
    return None if groups is None else Shown(page.html(groups, alone=True), base=True)


def _has_closed_form(model: Model) -> bool:
    """Whether a closed form can be shown: few joints with one coordinate each, none following
    another, no loop and no strut."""
    bodies = model.bodies
    simple = all(body.kind.turns or body.kind.slides for body in bodies)
    return (
        len(bodies) <= JOINTS
        and simple
        and all(b.joint.mimic is None for b in bodies)
        and not model.loops
        and not model.struts
        and not lossy_joints(bodies)
    )
