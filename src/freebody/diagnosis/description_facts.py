"""Facts of any other format, from the description that is read of a file."""

from __future__ import annotations

from math import isfinite

from freebody.diagnosis.facts import FRICTIONS, InertiaFacts, JointFacts, LinkFacts, Written
from freebody.model.description import Joint, Link, RobotDescription
from freebody.model.parameters import each_parameter


def links_and_joints(
    description: RobotDescription,
) -> tuple[tuple[LinkFacts, ...], tuple[JointFacts, ...]]:
    """The links and joints of a description; quantities without value are left out."""
    dim = description.dim
    return (
        tuple(_link(link) for link in description.links),
        tuple(_joint(joint, dim) for joint in description.joints),
    )


def _known(quantity: object) -> bool:
    return not any(p.missing for p in each_parameter(quantity))


def _link(link: Link) -> LinkFacts:
    known = link.inertia is not None and _known((link.inertia, link.placement))
    inertial = InertiaFacts(link.inertia, link.placement, link.line) if known else None
    return LinkFacts(
        link.name, link.line, inertial, link.shapes, filled=link.filled, stated=link.stated
    )


def _joint(joint: Joint, dim: int) -> JointFacts:
    limits = {
        name: Written(value)
        for name, value in vars(joint.limits).items()
        if isinstance(value, float) and isfinite(value)
    }
    drive = {
        name: Written(value)
        for name, number in FRICTIONS.items()
        if isinstance(value := getattr(joint.drive, number), float) and value
    }
    pose = joint.placement.arrays(dim) if _known(joint.placement) else None
    return JointFacts(
        joint.name,
        joint.kind,
        joint.parent,
        joint.child,
        joint.line,
        pose,
        joint.axis or None,
        limits,
        drive,
        joint.mimic.joint if joint.mimic else "",
        limit_line=joint.line,
    )
