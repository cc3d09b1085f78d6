"""Threads and gears of SDF: the pitch of a screw joint, and gearboxes, which are no joints of a
tree but couple how two links turn."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.errors import UnknownNameError, shown
from freebody.formats.urdf_elements import XmlElement
from freebody.model.mimics import Mimic

if TYPE_CHECKING:
    from freebody.formats.sdf import SdfReader

GEARBOX = "gearbox"
SCREW = "screw"
SCREW_TAGS = ("screw_thread_pitch", "thread_pitch")
GEARBOX_TAGS = ("gearbox_ratio", "gearbox_reference_body")
_PARALLEL = 1e-9
"""1 - |cos| of the angle between two axes that are one."""
_TURNING = ("revolute", "continuous")


def pitch(reader: SdfReader, element: XmlElement, where: str) -> float:
    """The pitch of a screw joint in m/rad: that of <screw_thread_pitch>, m a turn, or of the older
    <thread_pitch>, rad/m for a left-handed thread."""
    given = reader.inside_of(element, SCREW_TAGS[0], where)
    older = reader.inside_of(element, SCREW_TAGS[1], where)
    for tag, value in zip(SCREW_TAGS, (given, older), strict=True):
        if value is not None and (not value or not math.isfinite(value)):
            reader.refuse(
                element, f"{where}: <{tag}> is {value:g}; a screw advances: give its pitch."
            )
    if given is None and older is not None:
        return -1.0 / older
    if given is None:
        told = f"warning: {where} is a screw without pitch, for which SDF assumes 1 m for each turn"
        reader.notice("pitch", element, f"{told}; give <screw_thread_pitch>.")
        given = 1.0
    return given / (2.0 * math.pi)


def couple(reader: SdfReader, gearbox: XmlElement, joints: list[XmlElement]) -> None:
    """Make the joint of a gearbox's child link follow that of its parent link: seen from the
    reference body, the child turns about <axis2> by minus the ratio of what the parent turns about
    <axis>."""
    where = f"joint {gearbox.name()!r}"
    reader.only(gearbox, "name", "type")
    reader.sort_out(gearbox, "parent", "child", "pose", "axis", "axis2", *GEARBOX_TAGS)
    element = reader.one(gearbox, GEARBOX_TAGS[1], where)
    body = element.content if element is not None else ""
    known = [reader.world, *reader.links]
    if not body:
        reader.refuse(
            gearbox, f"{where}: a gearbox needs its <gearbox_reference_body>, which holds the gears"
        )
    if body not in known:
        reader.refuse(gearbox, str(UnknownNameError("link", body, where, known)))
    given = reader.inside_of(gearbox, GEARBOX_TAGS[0], where)
    ratio = 1.0 if given is None else given
    if not ratio or not math.isfinite(ratio):
        reader.refuse(gearbox, f"{where}: the <gearbox_ratio> {ratio:g} is that of no gears.")
    (leader, one), (follower, other) = (
        _turning(reader, gearbox, tag, body, axis, joints)
        for tag, axis in zip(("parent", "child"), reader.axes(gearbox, where), strict=True)
    )
    for k, joint in enumerate(reader.joints):
        if joint.name == follower:
            if joint.mimic is not None:
                reader.refuse(
                    gearbox,
                    f"{where}: joint {follower!r} follows {joint.mimic.joint!r} already; keep one "
                    f"of the two.",
                )
            reader.joints[k] = replace(joint, mimic=Mimic(leader, -ratio * one * other))


def _turning(
    reader: SdfReader,
    gearbox: XmlElement,
    tag: str,
    body: str,
    axis: tuple[tuple[float, ...], XmlElement | None],
    joints: list[XmlElement],
) -> tuple[str, int]:
    """The joint about which a link of the gearbox turns in the reference body, and whether it turns
    as about the gearbox's axis (1) or against it (-1)."""
    where = f"joint {gearbox.name()!r}"
    link = reader.end(gearbox, tag, where)
    along = reader.pose_of(gearbox.name(), gearbox)[0] @ np.array(axis[0])
    for joint in joints:
        if joint.attributes.get("type", "").strip() not in _TURNING:
            continue
        held, moved = (reader.end(joint, end, where) for end in ("parent", "child"))
        if {held, moved} != {body, link} or body == link:
            continue
        ((own, _),) = reader.axes(joint, where)
        cosine = float(along @ reader.pose_of(joint.name(), joint)[0] @ np.array(own))
        if 1.0 - abs(cosine) < _PARALLEL:
            return joint.name(), (1 if cosine > 0.0 else -1) * (1 if held == body else -1)
    name = "axis" if tag == "parent" else "axis2"
    reader.refuse(
        gearbox,
        f"{where}: a gearbox couples two links that turn in its reference body, and {link!r} has "
        f"no revolute joint with {shown(body)} about the gearbox's <{name}>; give it one, or "
        f"couple two joints by <mimic> in the <axis> of one.",
    )
