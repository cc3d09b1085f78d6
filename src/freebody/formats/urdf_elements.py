"""Reading of URDF elements: XML that knows its lines, checked numbers and texts, and a record of
everything that is not read.

Nothing outside the file is read, and entities are refused.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, NoReturn
from xml.parsers import expat

from freebody.errors import FileError, IncludedLine, shown
from freebody.formats import read_file
from freebody.model.description import Notice
from freebody.model.placement import Placement, rpy, shift
from freebody.outputs.display import counted

_ELEMENTS, _ATTRIBUTES, _DEEPEST = 500_000, 2_000_000, 200
_TEXT = 80  # characters kept of an element's text
_CUT_SHORT = [
    expat.errors.codes[message]
    for message in (expat.errors.XML_ERROR_NO_ELEMENTS, expat.errors.XML_ERROR_UNCLOSED_TOKEN)
]
UNLIMITED = 1e16
"""A limit from which Gazebo takes a joint to have none, and so what programs write that want a
number."""
_SHAPES = ("visual", "collision", "material")
_MOST_KINDS = 100
"""Kinds of elements and attributes that are not read and yet named one by one."""


@dataclass(slots=True)
class XmlElement:
    """One element: tag with its prefix as written, attributes, line, elements and text inside, and
    the file it is written in."""

    tag: str
    attributes: dict[str, str]
    line: int | IncludedLine
    children: list[XmlElement] = field(default_factory=list)
    content: str = ""
    """The beginning of the text directly inside, stripped."""
    file: str = ""
    passed_over: tuple[str, ...] = ()
    """Faults of the file that parsers are to refuse and simulators pass over; the root has them."""

    def all(self, tag: str) -> list[XmlElement]:
        """The elements of that tag directly inside."""
        return [child for child in self.children if child.tag == tag]

    def name(self) -> str:
        """The name attribute, empty where there is none."""
        return self.attributes.get("name", "").strip()


def parse(file: str, data: bytes, most: int = _TEXT) -> XmlElement:
    """The root element; of an element's text `most` characters are kept. Raises FileError with the
    line where the text is not XML, ends early or declares entities."""
    data, above, passed_over = _mended(data)
    parser = expat.ParserCreate()
    opened: list[XmlElement] = []
    roots: list[XmlElement] = []
    left, attributes_left = _ELEMENTS, _ATTRIBUTES

    def refuse(problem: str) -> NoReturn:
        raise FileError(file, above + parser.CurrentLineNumber, problem)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal left, attributes_left
        left, attributes_left = left - 1, attributes_left - len(attributes)
        if not left:
            refuse(
                f"the file has more than {_ELEMENTS} elements; a robot description has a few "
                f"thousand."
            )
        if attributes_left < 0:
            refuse(
                f"the file has more than {_ATTRIBUTES} attributes; a robot description has a few "
                f"thousand."
            )
        if len(opened) == _DEEPEST:
            refuse(f"elements are nested more than {_DEEPEST} deep.")
        element = XmlElement(tag, attributes, above + parser.CurrentLineNumber, file=file)
        (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    def text(data: str) -> None:  # line by line, and in pieces
        if opened and len(opened[-1].content) < most:
            opened[-1].content = (opened[-1].content + data).lstrip()[:most]

    def end(tag: str) -> None:
        element = opened.pop()
        element.content = element.content.rstrip()

    def doctype(*_: object) -> NoReturn:
        # expanding entities can fill the memory (the "billion laughs") or read other files
        refuse("the file has a <!DOCTYPE>, which can declare entities and is refused; remove it.")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        cut = error.code in _CUT_SHORT and opened
        problem = (
            f"the file ends inside <{opened[-1].tag}>, opened on line {opened[-1].line}; it seems "
            f"to be truncated."
            if cut
            else f"this is not well-formed XML: {expat.ErrorString(error.code)} at column "
            f"{error.offset + 1}."
        )
        raise FileError(file, above + error.lineno, problem) from None
    except (ValueError, LookupError) as error:  # an encoding that Python does not know
        raise FileError(file, None, f"the XML cannot be decoded: {error}.") from None
    roots[0].passed_over = passed_over
    return roots[0]


def _mended(data: bytes) -> tuple[bytes, int, tuple[str, ...]]:
    """(text, lines, remarks): a file's text without blanks before its declaration and NUL bytes at
    its end, how many lines were removed in front, and a sentence on each removal."""
    found, text = [], data.rstrip(b"\0")
    if len(text) < len(data):
        found.append(f"{len(data) - len(text)} NUL bytes at the end of the file are passed over.")
    begun = text.lstrip()
    before = text[: len(text) - len(begun)]
    if before and begun.startswith(b"<?xml"):
        found.append("what is blank before the XML declaration is passed over.")
        return begun, before.count(b"\n"), tuple(found)
    return text, 0, tuple(found)


UNEXPANDED = "which this suffix does not say: call the file .urdf.xacro, and it is expanded"
"""Advice on a .urdf file that is a xacro file."""


class Elements:
    """A URDF or SDF file being read: checked values of its elements, refusals with its name and
    line, and notices about it."""

    def __init__(self, file: str, snap: float):
        self.file, self.snap = file, snap
        self.notices: list[Notice] = []
        self.shapes: Counter[str] = Counter()
        self.ignored: dict[str, tuple[int, int | IncludedLine]] = {}
        self.unknown: dict[str, tuple[int, int | IncludedLine]] = {}
        self.changes: list[float] = []

    # ------------------------------------------------------------ values
    def text(self, element: XmlElement, key: str, where: str) -> str:
        value = element.attributes.get(key, "").strip()
        if not value:
            self.refuse(element, f'{where}: <{element.tag}> has no {key}; add {key}="...".')
        return value

    def number(
        self,
        element: XmlElement,
        key: str,
        where: str,
        default: float | None = None,
        infinite: bool = False,
    ) -> float:
        """The number in an attribute; infinite values are accepted only where asked for."""
        if key not in element.attributes and default is not None:
            return default
        return self.read(element, key, self.text(element, key, where), where, infinite)

    def vector(self, element: XmlElement, key: str, where: str) -> tuple[float, float, float]:
        """The three numbers in an attribute, zeros where it is absent."""
        words = element.attributes.get(key, "0 0 0").split()
        if len(words) != 3:
            text = " ".join(words)
            self.refuse(
                element,
                f"{where}: {key}={shown(text)} has {counted(len(words), 'entry')}, expected 3 "
                f"numbers{_unexpanded(text)}.",
            )
        x, y, z = (self.read(element, key, word, where) for word in words)
        return x, y, z

    def read(
        self, element: XmlElement, key: str, word: str, where: str, infinite: bool = False
    ) -> float:
        value = read_file.number(word)
        problem = None if value is None else read_file.fault(value, infinite)
        if value is None or problem == read_file.NOT_FINITE:
            kind = "number" if infinite else "finite number"
            self.refuse(
                element,
                f"{where}: {key} of <{element.tag}> is {shown(word)}, expected a "
                f"{kind}{_unexpanded(word)}.",
            )
        if problem:
            self.refuse(element, f"{where}: {key} of <{element.tag}> is {value:g}, {problem}.")
        return value

    def axis(self, element: XmlElement, where: str) -> tuple[float, float, float]:
        """The axis as written, (1, 0, 0) where there is none; refuses a zero one."""
        tag = self.one(element, "axis", where)
        if tag is None:
            return 1.0, 0.0, 0.0
        self.only(tag, "xyz")
        axis = self.vector(tag, "xyz", where)
        length = math.hypot(*axis)
        if not any(axis):
            self.refuse(tag, f'{where}: the axis is zero; give a direction such as xyz="0 0 1".')
        if abs(length - 1.0) > 1e-6:
            self.notice(
                "axis", tag, f"{where}: the axis has length {length:g}; it is made a unit vector."
            )
        return axis

    def origin(
        self, element: XmlElement, where: str
    ) -> tuple[tuple[float, float, float], Placement]:
        """Shift (m) and rotation of the <origin> inside."""
        tag = self.one(element, "origin", where)
        if tag is None:
            return (0.0, 0.0, 0.0), Placement()
        self.only(tag, "xyz", "rpy")
        angles = self.vector(tag, "rpy", where)
        for angle in angles:
            off = abs(angle - round(angle / (math.pi / 2)) * (math.pi / 2))
            if 0.0 < off <= self.snap:
                self.changes.append(off)
        return self.vector(tag, "xyz", where), rpy(*angles, snap=self.snap)

    def placement(self, element: XmlElement, where: str) -> Placement:
        """The placement that the <origin> inside gives."""
        xyz, turned = self.origin(element, where)
        return shift(*xyz).then(turned)

    # ------------------------------------------------------------ what is not used
    def only(self, element: XmlElement, *known: str, owner: str | None = None) -> None:
        """Count the attributes that are not read."""
        for key in element.attributes:
            if key not in known and not key.startswith("xmlns"):
                self.count(f"attribute {key} of {owner or f'<{element.tag}>'}", element.line)

    def sort_out(self, element: XmlElement, *known: str, owner: str | None = None) -> None:
        """Count the elements inside that are not read."""
        for child in element.children:
            if child.tag in _SHAPES:
                self.shapes[child.tag] += 1
            elif child.tag not in known:
                self.count(f"<{child.tag}> in {owner or f'<{element.tag}>'}", child.line)

    def count(self, what: str, line: int | IncludedLine) -> None:
        n, first = self.ignored.get(what, (0, line))
        self.ignored[what] = n + 1, first

    def one(self, element: XmlElement, tag: str, where: str) -> XmlElement | None:
        """The element of that tag directly inside, or None; of several the first, as in simulators,
        with a notice."""
        found = element.all(tag)
        for other in found[1:]:
            same = _contents(other) == _contents(found[0])
            kept = "they are equal" if same else "warning: they differ, and the first is used"
            self.notice("doubled", other, f"{where}: there are {len(found)} <{tag}>; {kept}.")
        return found[0] if found else None

    def summary(self) -> list[Notice]:
        """Notices on the whole file: snapped angles, shapes, ignored elements and attributes."""
        notices = []
        if self.changes:
            text = (
                f"{len(self.changes)} angles within {self.snap:g} rad of a multiple of a right "
                f"angle are read as that multiple; largest change {max(self.changes):.2g} rad. "
                f"snap_angles=0 reads them as written."
            )
            notices.append(Notice("snapped", text, self.file))
        if self.shapes:
            listed = ", ".join(f"{n} <{tag}>" for tag, n in sorted(self.shapes.items()))
            notices.append(
                Notice(
                    "skipped",
                    f"shapes play no part in the dynamics: {listed} serve drawings, or nothing.",
                    self.file,
                )
            )
        for key, (n, line) in self.unknown.items():
            text = f"{key} limits of 0 are read as no limit ({_times(n)})."
            notices.append(Notice("limits", text, self.file, line))
        if len(self.ignored) > _MOST_KINDS:
            text = (
                f"{len(self.ignored) - _MOST_KINDS} further kinds of elements and attributes "
                "are ignored."
            )
            notices.append(Notice("ignored", text, self.file))
        for what, (n, line) in islice(self.ignored.items(), _MOST_KINDS):
            notices.append(
                Notice(
                    "ignored",
                    f"{what} is ignored ({_times(n)}).",
                    self.file,
                    line,
                )
            )
        return notices

    def notice(self, kind: str, element: XmlElement, text: str) -> None:
        self.notices.append(Notice(kind, text, self.file, element.line))

    def refuse(self, element: XmlElement, problem: str) -> NoReturn:
        raise FileError(self.file, element.line, problem)


def is_unexpanded(value: str) -> bool:
    """Whether a value is an expression or substitution of xacro."""
    return "${" in value or "$(" in value


def _unexpanded(value: str) -> str:
    """Advice on a value that only xacro evaluates, else empty."""
    return f"; it is a xacro expression, {UNEXPANDED}" if is_unexpanded(value) else ""


def _contents(element: XmlElement) -> tuple[Any, ...]:
    """The contents of an element as nested tuples, without line numbers."""
    inside = tuple(map(_contents, element.children))
    return element.tag, element.attributes, element.content, inside


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n} times, first here"
