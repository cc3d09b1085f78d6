"""Findings on axes and angles."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from freebody.diagnosis.facts import RobotFacts, elements_in, norm
from freebody.diagnosis.finding import AttributeChange, FileLine, FindingKind, FoundFault
from freebody.diagnosis.urdf_facts import vector
from freebody.formats.urdf_elements import XmlElement

_UNIT = 1e-4
"""Difference from length 1 that a rounded axis may have."""
_SLIGHT = 1e-2
"""Size of what is left beside a coordinate axis that is meant."""
_FULL = 2.0 * math.pi * 1.01
_TOLERATED = 3e-9
"""rad by which a right angle is read as one."""
_FELT = 1e-5
"""rad by which an angle may be off before a robot notices: 10 µm at a metre."""
_DIGITS = re.compile(r"[-+]?\d+\.(\d+)")


def _axes(
    facts: RobotFacts,
) -> Iterator[tuple[str, XmlElement | None, tuple[float, ...], FileLine]]:
    for joint in facts.joints:
        if joint.axis is not None and (joint.moves or joint.kind == "planar"):
            element = next(iter(joint.element.all("axis")), None) if joint.element else None
            yield joint.name, element, joint.axis, element.line if element else joint.line


def _no_axis(facts: RobotFacts) -> Iterator[FoundFault]:
    for name, _, axis, line in _axes(facts):
        if not any(axis):
            yield FoundFault(f"joint {name!r}: its axis is zero", line)


def _not_unit(facts: RobotFacts) -> Iterator[FoundFault]:
    for name, element, axis, line in _axes(facts):
        length = norm(axis)
        if length and abs(length - 1.0) > _UNIT and element is not None:
            text = " ".join(f"{x / length:.9g}" for x in axis)
            reason = f"joint {name!r}: its axis has the length {length:g}, expected 1"
            yield FoundFault(reason, line, (AttributeChange(element, "xyz", text),))


def _nearly(facts: RobotFacts) -> Iterator[FoundFault]:
    for name, element, axis, line in _axes(facts):
        length = norm(axis)
        if not length or len(axis) != 3:
            continue
        unit = np.array(axis) / length
        rest = np.abs(np.delete(unit, np.argmax(np.abs(unit))))
        if 1e-12 < rest.max() < _SLIGHT:
            k = int(np.argmax(np.abs(unit)))
            text = " ".join(f"{math.copysign(1.0, unit[k]):g}" if i == k else "0" for i in range(3))
            angle = math.asin(float(norm(rest)))
            reason = f"joint {name!r}: its axis is {angle:.2g} rad off {'xyz'[k]}"
            changes = (AttributeChange(element, "xyz", text),) if element and angle < 1e-5 else ()
            yield FoundFault(reason, line, changes)


def _absent(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        if joint.element is not None and joint.moves and not joint.element.all("axis"):
            yield FoundFault(f"joint {joint.name!r} has no <axis>; x is taken", joint.line)


def _origins(facts: RobotFacts) -> Iterator[tuple[str, XmlElement, tuple[float, ...]]]:
    """Each <origin> of a joint or link, with the part's name and its angles (rad)."""
    for what, parts in (("joint", facts.joints), ("link", facts.links)):
        for part in parts:
            for element in elements_in(part.element) if part.element else ():
                angles = vector(element, "rpy") if element.tag == "origin" else None
                if angles is not None:
                    yield f"{what} {part.name!r}", element, angles


def _rounded(facts: RobotFacts) -> Iterator[tuple[float, FoundFault]]:
    """Findings of right angles that are written with few digits, with their error (rad); origins of
    shapes are left out, since they do no harm."""
    for where, element, angles in _of_frames(facts):
        words = element.attributes.get("rpy", "").split()
        mended = [_right(word, x) for word, x in zip(words, angles, strict=False)]
        off = max((abs(a - float(b)) for a, b in zip(angles, mended, strict=False)), default=0.0)
        if off > _TOLERATED:
            reason = f"{where}: rpy holds a right angle that is rounded, {off:.1g} rad off"
            yield (
                off,
                FoundFault(
                    reason, element.line, (AttributeChange(element, "rpy", " ".join(mended)),)
                ),
            )


def _far_off(facts: RobotFacts) -> Iterator[FoundFault]:
    return (found for off, found in _rounded(facts) if off > _FELT)


def _slightly_off(facts: RobotFacts) -> Iterator[FoundFault]:
    return (found for off, found in _rounded(facts) if off <= _FELT)


def _of_frames(facts: RobotFacts) -> Iterator[tuple[str, XmlElement, tuple[float, ...]]]:
    shapes = {
        id(inner)
        for link in facts.links
        if link.element
        for role in ("visual", "collision")
        for shape in link.element.all(role)
        for inner in elements_in(shape)
    }
    for where, element, angles in _origins(facts):
        if id(element) not in shapes:
            yield where, element, angles


def _right(word: str, angle: float) -> str:
    """The right angle that a number with few digits stands for, else the number itself."""
    digits = _DIGITS.fullmatch(word)
    meant = round(angle / (0.5 * math.pi)) * 0.5 * math.pi
    if not digits or len(digits[1]) < 2 or abs(angle - meant) <= _TOLERATED:
        return word
    unit = 10.0 ** -len(digits[1])
    rounded, cut = round(meant / unit) * unit, math.trunc(meant / unit) * unit
    is_meant = meant and min(abs(angle - rounded), abs(angle - cut)) < 1e-3 * unit
    return repr(meant) if is_meant else word


def _degrees(facts: RobotFacts) -> Iterator[FoundFault]:
    for where, element, angles in _origins(facts):
        if max(map(abs, angles)) > _FULL:
            whole = all(x % 1.0 == 0.0 and abs(x) <= 360.0 for x in angles)
            text = " ".join(repr(math.radians(x)) for x in angles)
            changes = (AttributeChange(element, "rpy", text),) if whole else ()
            shown = " ".join(f"{x:g}" for x in angles)
            yield FoundFault(f"{where}: rpy {shown} rad is more than a turn, as though in degrees",
                        element.line, changes)  # fmt: skip


NO_AXIS = FindingKind("zero axis", "error", "give a direction such as 0 0 1", _no_axis)
NOT_UNIT = FindingKind("axis not unit", "warning", "give a unit vector", _not_unit)
NEARLY = FindingKind("slightly turned axis", "notice", "write the axis if it is meant", _nearly)
ABSENT = FindingKind("no axis", "notice", "write the axis", _absent)
ROUNDED = FindingKind("rounded right angle", "warning", "write all digits", _far_off)
SHORT = FindingKind("right angle in few digits", "notice", "write all digits", _slightly_off)
DEGREES = FindingKind("angles in degrees", "warning", "give radians", _degrees)
