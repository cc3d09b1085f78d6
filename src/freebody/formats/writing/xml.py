"""XML for the writers of URDF, SDF and MJCF: numbers to the last bit, and angles that readers turn
back into the same rotation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from freebody.formats.urdf_elements import UNLIMITED
from freebody.formats.writing.contents import Contents
from freebody.model.placement import rpy
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Pose
from freebody.spatial import Matrix, space

SNAPPED = 3e-9
"""rad from a multiple of a right angle within which readers take an angle for that multiple."""
_ALIKE = 1e-12
_ROUNDED = 1e-15
"""Change of an entry of a rotation that is rounding."""

__all__ = ["Element", "SubElement"]


def text_of(root: Element) -> str:
    """The text of an XML document."""
    ElementTree.indent(root)
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{body}\n'


def numbers(values: Iterable[float]) -> str:
    """Numbers separated by blanks, each written so that it is read back exactly."""
    return " ".join(repr(float(x) + 0.0) for x in values)


def limit(value: float) -> str:
    """A limit as text; an infinite one as the number from which limits count as infinite."""
    return repr(max(-UNLIMITED, min(UNLIMITED, value)))


def angles(R: Matrix) -> tuple[float, float, float]:
    """Roll, pitch and yaw (rad) that give a rotation back; near a pitch of 90°, where many do,
    those with an exact right yaw if possible, which readers do not round."""
    across = math.hypot(R[0][0], R[1][0])
    pitch = math.atan2(-R[2][0], across)
    yaw = math.atan2(R[1][0], R[0][0])
    right = round(yaw / (math.pi / 2)) * (math.pi / 2)
    if abs(yaw - right) * across < _ROUNDED:
        yaw = right
    s, c = math.sin(yaw), math.cos(yaw)
    roll = math.atan2(s * R[0][2] - c * R[1][2], c * R[1][1] - s * R[0][1])
    return roll, pitch, yaw


def snapped(contents: Contents) -> list[str]:
    """A sentence on angles so close to right angles that readers round them unless told not to;
    none where there are none."""
    moved = [link.name for link in contents.links if _is_snapped(link.pose)]
    if not moved:
        return []
    return [
        f"angles within {SNAPPED:g} rad of a right one, at {', '.join(moved[:4])}: give "
        f"snap_angles=0 when you load it"
    ]


def _is_snapped(pose: Pose) -> bool:
    R = pose[0]
    read, _ = rpy(*angles(R), snap=SNAPPED).lower(space, VALUES)
    return any(
        abs(float(a) - float(b)) > _ALIKE
        for one, other in zip(R, read, strict=True)
        for a, b in zip(one, other, strict=True)
    )
