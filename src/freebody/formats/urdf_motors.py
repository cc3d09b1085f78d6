"""The motors and loops of a URDF, for which URDF 1.0 has no elements.

Gears stand in ROS's `<transmission>` as `<mechanicalReduction>`, rotors beside them as Drake reads
them (`<drake:rotor_inertia value>`, `<drake:gear_ratio value>`). Loops are `<loop>` of URDF+
(Chignoli, Slotine, Wensing, Kim 2024): a joint between a frame of a predecessor and one of a
successor.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from freebody.errors import UnknownNameError
from freebody.formats import read_file
from freebody.formats.urdf_elements import Elements, XmlElement
from freebody.model.description import Drive, Joint, Loop, Mount
from freebody.model.joints import KINDS

LOOPS = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    # as of joints, outside the proposal's own list
    "spherical": "spherical",
    "universal": "universal",
}
"""Kinds of loops by the types of URDF+."""
_WHERE = "<transmission> in <robot>"
_ROTOR, _GEAR = "drake:rotor_inertia", "drake:gear_ratio"


def with_motors(
    reader: Elements, robot: XmlElement, joints: Iterable[Joint], closed: bool
) -> list[Joint]:
    """The joints with the rotors and gears of their transmissions; in a closed chain where some
    joint has a transmission, the others become passive."""
    joints = list(joints)
    single = {joint.name for joint in joints if KINDS[joint.kind].nv == 1}
    drives: dict[str, Drive] = {}
    for element in robot.all("transmission"):
        ends, actuators = element.all("joint"), element.all("actuator")
        names = [end.name() for end in ends]
        drive = None
        if len(names) == len(actuators) == 1 and names[0] in single and names[0] not in drives:
            drive = _drive(reader, element, actuators[0])
        if drive is None:
            reader.count(_WHERE, element.line)
        else:
            drives[names[0]] = drive
    _tell_bare_gears(reader, robot, drives)
    return [_driven(joint, drives, closed) for joint in joints]


def _driven(joint: Joint, drives: dict[str, Drive], closed: bool) -> Joint:
    """The joint with its motor; without one it is passive where a closed chain has motors
    elsewhere."""
    motor = drives.get(joint.name)
    if motor is None:
        moves = KINDS[joint.kind].nv > 0 and joint.mimic is None
        return replace(joint, passive=closed and bool(drives) and moves)
    return replace(joint, drive=replace(joint.drive, rotor=motor.rotor, gear=motor.gear))


def _drive(reader: Elements, element: XmlElement, actuator: XmlElement) -> Drive | None:
    """The rotor and gear of a transmission with one joint; None where the gear is no number."""
    where = f"transmission {element.name()!r}"
    given = {tag: reader.one(actuator, tag, where) for tag in (_ROTOR, _GEAR)}
    values = {
        tag: reader.number(found, "value", where)
        for tag, found in given.items()
        if found is not None
    }
    gear = values.get(_GEAR)
    for part in (actuator, element):
        for reduction in part.all("mechanicalReduction"):
            if gear is None and reduction.content:
                gear = read_file.number(reduction.content)
                if not gear or read_file.fault(gear):
                    return None
    return Drive(rotor=values.get(_ROTOR, 0.0), gear=1.0 if gear is None else gear)


def _tell_bare_gears(reader: Elements, robot: XmlElement, drives: dict[str, Drive]) -> None:
    bare = [name for name, drive in drives.items() if drive.gear != 1.0 and not drive.rotor]
    if bare:
        reader.notice(
            "drive",
            robot.all("transmission")[0],
            f"{len(bare)} transmissions give a gear without the inertia of a rotor (first of "
            f"{bare[0]!r}: {drives[bare[0]].gear:g}); <{_ROTOR}> in the file or model.with_drive("
            f"joint, rotor=...) adds it.",
        )


def loops(reader: Elements, robot: XmlElement) -> tuple[list[Loop], list[Mount]]:
    """The loops of URDF+, and the frames that they join."""
    for element in robot.all("coupling"):
        reader.refuse(
            element, "<coupling> of URDF+ is not read; write <mimic> in the joint that follows."
        )
    found, mounts = [], []
    for element in robot.all("loop"):
        where = f"loop {element.name()!r}"
        name = reader.text(element, "name", "a loop")
        given = reader.text(element, "type", where)
        if given not in LOOPS:
            reader.refuse(element, str(UnknownNameError("type", given, where, LOOPS)))
        reader.only(element, "name", "type")
        reader.sort_out(element, "predecessor", "successor", "axis", owner="a loop")
        ends = [
            _end(reader, element, tag, f"{name}_{side}", mounts)
            for tag, side in (("predecessor", "a"), ("successor", "b"))
        ]
        kind = LOOPS[given]
        axis = reader.axis(element, where) if kind in ("revolute", "prismatic") else ()
        found.append(Loop(name, kind, (ends[0], ends[1]), axis, line=element.line))
    return found, mounts


def _end(reader: Elements, loop: XmlElement, tag: str, name: str, mounts: list[Mount]) -> str:
    """The name of the frame at one end of a loop: the link's own, or a new one mounted on it."""
    where = f"loop {loop.name()!r}"
    end = reader.one(loop, tag, where)
    if end is None:
        reader.refuse(loop, f'{where}: it has no <{tag}>; add <{tag} link="..."/>.')
    reader.only(end, "link")
    reader.sort_out(end, "origin")
    link = reader.text(end, "link", where)
    placement = reader.placement(end, where)
    if not placement.steps:
        return link
    mounts.append(Mount(name, link, placement))
    return name
