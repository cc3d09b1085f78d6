"""Findings on what is written in a file: values that are not numbers, and elements and attributes
that nobody reads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from freebody.diagnosis.facts import RobotFacts, elements_in
from freebody.diagnosis.finding import AttributeChange, FindingKind, FoundFault
from freebody.errors import likely, listed, shown
from freebody.formats import read_file
from freebody.formats.urdf import TYPES
from freebody.formats.urdf_elements import XmlElement

_COUNTS = {
    "inertia": {"ixx": 1, "ixy": 1, "ixz": 1, "iyy": 1, "iyz": 1, "izz": 1},
    "mass": {"value": 1},
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "velocity": 1, "effort": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
}
"""How many numbers each attribute holds, by element."""
_NEEDED = {"inertia": tuple(_COUNTS["inertia"]), "mass": ("value",)}
_KNOWN = {
    "robot": ("link", "joint", "material", "transmission", "gazebo"),
    "link": ("inertial", "visual", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "joint": (
        *("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration"),
        "safety_controller",
    ),
}
"""Elements that belong into each."""


def _structure(facts: RobotFacts) -> Iterator[XmlElement]:
    """The elements inside the links and joints of a file, those of shapes included."""
    for part in (*facts.links, *facts.joints):
        if part.element is not None:
            yield from elements_in(part.element)


def _no_number(facts: RobotFacts) -> Iterator[FoundFault]:
    for element in _structure(facts):
        for attribute, count in _COUNTS.get(element.tag, {}).items():
            text = element.attributes.get(attribute)
            if text is None:
                continue
            words = text.split()
            wrong = [word for word in words if not _is_number(word)]
            where = f"{attribute} of <{element.tag}>"
            if wrong:
                yield _not_read(element, attribute, words, wrong[0])
            elif len(words) != count:
                numbers = f"{len(words)} number{'s' if len(words) != 1 else ''}"
                yield FoundFault(f"{where} has {numbers}, expected {count}", element.line)


def _not_read(element: XmlElement, attribute: str, words: list[str], wrong: str) -> FoundFault:
    mended = [_mended(word) for word in words]
    changes = (
        (AttributeChange(element, attribute, " ".join(mended)),)
        if all(map(_is_number, mended))
        else ()
    )
    return FoundFault(
        f"{attribute} of <{element.tag}> is {shown(wrong)}, which is no finite number",
        element.line,
        changes,
        "write it with a decimal point" if changes else "",
    )


def _is_number(word: str) -> bool:
    value = read_file.number(word)
    return value is not None and not read_file.fault(value, infinite=True)


def _mended(word: str) -> str:
    """The number with a point in place of its decimal comma."""
    pointed = word.replace(",", ".")
    single = word.count(",") == 1 and "." not in word and _is_number(pointed)
    return pointed if single else word


def _absent(facts: RobotFacts) -> Iterator[FoundFault]:
    for element in _structure(facts):
        absent = [key for key in _NEEDED.get(element.tag, ()) if key not in element.attributes]
        if absent:
            yield FoundFault(f"<{element.tag}> has no {listed(absent)}", element.line)
        if element.tag == "inertial":
            lacks = [tag for tag in ("mass", "inertia") if not element.all(tag)]
            if lacks:
                yield FoundFault(f"<inertial> has no <{'> and no <'.join(lacks)}>", element.line)


def _misspelt(facts: RobotFacts) -> Iterator[FoundFault]:
    if facts.root is None:
        return
    for element in (facts.root, *_structure(facts)):
        known = _KNOWN.get(element.tag, ())
        for child in element.children if known else ():
            near = [] if child.tag in known else _misspelt_for(child.tag, known)
            if near:
                yield FoundFault(
                    f"<{child.tag}> in <{element.tag}> is read by nobody", child.line,
                    remedy=f"it seems to be <{near[0]}>",
                )  # fmt: skip
        keys = _COUNTS.get(element.tag, {})
        for key in element.attributes:
            near = [] if key in keys or ":" in key else _misspelt_for(key, keys)
            if near and near[0] not in element.attributes:
                yield FoundFault(
                    f"{key} of <{element.tag}> is read by nobody", element.line,
                    remedy=f"it seems to be {near[0]}",
                )  # fmt: skip


def _misspelt_for(name: str, known: Iterable[str]) -> list[str]:
    return [x for x in likely(name, known) if abs(len(x) - len(name)) <= 2]


def _unknown_type(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        if joint.element is None or joint.kind in TYPES.values():
            continue
        near = likely(joint.kind, TYPES)
        found = f"joint {joint.name!r} is of the type {shown(joint.kind)}, which does not exist"
        changes = (AttributeChange(joint.element, "type", near[0]),) if len(near) == 1 else ()
        yield FoundFault(found, joint.line, changes, f"write {near[0]}" if near else "")


NO_NUMBER = FindingKind("no number", "error", "write finite numbers there", _no_number)
ABSENT = FindingKind("absent number", "error", "add it", _absent)
MISSPELT = FindingKind("misspelt", "warning", "correct its name", _misspelt)
UNKNOWN_TYPE = FindingKind(
    "unknown type", "error", f"types are {listed(sorted(TYPES))}", _unknown_type
)
