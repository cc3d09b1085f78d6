"""URDF of a model: links, joints, limits, viscous and Coulomb friction, mimics; the rotors in
transmissions as Drake reads them, loops as URDF+ proposes them (Chignoli, Slotine, Wensing, Kim,
2024)."""

from __future__ import annotations

from freebody.formats.urdf import TYPES
from freebody.formats.urdf_elements import UNLIMITED
from freebody.formats.urdf_motors import LOOPS
from freebody.formats.writing.format_contents import (
    Contents,
    Holds,
    WrittenJoint,
    WrittenLink,
    contents_of,
    fixed_name,
)
from freebody.formats.writing.xml import (
    TENSOR,
    Element,
    SubElement,
    angles,
    checked,
    limit,
    numbers,
    text_of,
)
from freebody.model.description import INFINITE, Limits
from freebody.model.inertia import Inertia
from freebody.model.joints import KINDS
from freebody.model.model import Model
from freebody.model.tree import Pose

HOLDS = Holds(
    "URDF",
    kinds={kind: name for name, kind in TYPES.items()},
    drive=frozenset(("viscous", "coulomb", "rotor", "gear")),
    loops=frozenset(LOOPS.values()),
    base="load it with base='free'",
    passive=True,
    no_zero=frozenset(("velocity", "effort")),
    unlimited=UNLIMITED,
)


def written(model: Model) -> tuple[str, list[str]]:
    """The URDF text of a model, and sentences on what it loses of the model."""
    contents = checked(contents_of(model, HOLDS), "URDF")
    robot = Element("robot", {"name": contents.name})
    for link in contents.links:
        _link(robot, link)
    taken = contents.taken
    for link in contents.joined:
        _joint(robot, link, taken)
    for link in contents.joined:
        if link.joint:
            _transmission(robot, link.joint, bool(contents.loops))
    _loops(robot, contents)
    if any("drake:" in element.tag for element in robot.iter()):
        robot.set("xmlns:drake", "http://drake.mit.edu")
    return text_of(robot), list(contents.losses)


def _link(robot: Element, link: WrittenLink) -> None:
    element = SubElement(robot, "link", {"name": link.name})
    if link.inertia is not None:
        _inertial(SubElement(element, "inertial"), link.inertia)


def _inertial(element: Element, inertia: Inertia) -> None:
    mass, com, tensor = inertia.numbers()
    SubElement(element, "origin", {"xyz": numbers(com)})
    SubElement(element, "mass", {"value": repr(mass)})
    SubElement(element, "inertia", {key: numbers((tensor[i, j],)) for key, i, j in TENSOR})


def _origin(element: Element, pose: Pose) -> None:
    R, p = pose
    given = {"xyz": p, "rpy": angles(R)}
    told = {key: numbers(values) for key, values in given.items() if any(values)}
    if told:
        SubElement(element, "origin", told)


def _joint(robot: Element, link: WrittenLink, taken: set[str]) -> None:
    """Add the joint that moves a link, or fixes it to its parent."""
    joint = link.joint
    name = joint.name if joint else link.fixed or fixed_name(link.name, taken)
    kind = HOLDS.kinds[joint.kind] if joint else "fixed"
    element = SubElement(robot, "joint", {"name": name, "type": kind})
    SubElement(element, "parent", {"link": link.parent})
    SubElement(element, "child", {"link": link.name})
    _origin(element, link.pose)
    if joint is None:
        return
    if KINDS[joint.kind].needs_axis:
        SubElement(element, "axis", {"xyz": numbers(joint.axis)})
        _limit(element, joint.kind, joint.limits)
        friction = {"damping": joint.drive["viscous"], "friction": joint.drive["coulomb"]}
        if any(friction.values()):
            SubElement(element, "dynamics", {key: repr(x) for key, x in friction.items()})
    elif joint.kind == "planar":
        SubElement(element, "axis", {"xyz": "0 0 1"})
    if joint.mimic:
        follow = joint.mimic
        given = {"multiplier": repr(follow.ratio), "offset": repr(follow.offset)}
        SubElement(element, "mimic", {"joint": follow.joint, **given})


def _limit(element: Element, kind: str, limits: Limits) -> None:
    """Add the limits of a joint: speed and effort, which other readers require, and its range if it
    has one."""
    ranges = {"lower": limits.lower, "upper": limits.upper} if KINDS[kind].ranged else {}
    given = {**ranges, "velocity": limits.velocity, "effort": limits.effort}
    if ranges or min(limits.velocity, limits.effort) < INFINITE:
        SubElement(element, "limit", {key: limit(x) for key, x in given.items()})


def _transmission(robot: Element, joint: WrittenJoint, closed: bool) -> None:
    """Add the transmission of a joint with a rotor or gear, or in a closed chain of every joint
    with a motor."""
    rotor, gear = joint.drive["rotor"], joint.drive["gear"]
    motor = closed and not joint.passive and joint.mimic is None
    if KINDS[joint.kind].nv != 1 or not (motor or (rotor, gear) != (0.0, 1.0)):
        return
    element = SubElement(robot, "transmission", {"name": f"{joint.name}_transmission"})
    SubElement(element, "type").text = "transmission_interface/SimpleTransmission"
    SubElement(element, "joint", {"name": joint.name})
    actuator = SubElement(element, "actuator", {"name": f"{joint.name}_motor"})
    SubElement(actuator, "mechanicalReduction").text = repr(gear)
    if rotor:
        SubElement(actuator, "drake:rotor_inertia", {"value": repr(rotor)})
        SubElement(actuator, "drake:gear_ratio", {"value": repr(gear)})


def _loops(robot: Element, contents: Contents) -> None:
    types = {kind: name for name, kind in reversed(LOOPS.items())}
    for loop in contents.loops:
        element = SubElement(robot, "loop", {"name": loop.name, "type": types[loop.kind]})
        for tag, frame in zip(("predecessor", "successor"), loop.frames, strict=True):
            SubElement(element, tag, {"link": frame})
        if loop.axis:
            SubElement(element, "axis", {"xyz": numbers(loop.axis)})
