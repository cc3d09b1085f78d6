"""XML as a tree of elements that know their line. Nothing outside the file is read, entities are
refused."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NoReturn
from xml.parsers import expat

from freebody.errors import FileError

_ELEMENTS, _ATTRIBUTES, _DEEPEST = 500_000, 2_000_000, 200
_TEXT = 80  # characters kept of an element's text
_CUT_SHORT = [
    expat.errors.codes[message]
    for message in (expat.errors.XML_ERROR_NO_ELEMENTS, expat.errors.XML_ERROR_UNCLOSED_TOKEN)
]


@dataclass(slots=True)
class Element:
    """One element: tag with its prefix as written, attributes, line, elements and text inside."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    content: str = ""
    """The beginning of the text directly inside, stripped."""

    def all(self, tag: str) -> list[Element]:
        """The elements of that tag directly inside."""
        return [child for child in self.children if child.tag == tag]

    def name(self) -> str:
        """Its name attribute, empty where there is none."""
        return self.attributes.get("name", "").strip()


def parse(file: str, data: bytes) -> Element:
    """The root element. Raises FileError with the line where the text is not XML, ends early or
    declares entities."""
    parser = expat.ParserCreate()
    opened: list[Element] = []
    roots: list[Element] = []
    left, attributes_left = _ELEMENTS, _ATTRIBUTES

    def refuse(problem: str) -> NoReturn:
        raise FileError(file, parser.CurrentLineNumber, problem)

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
        element = Element(tag, attributes, parser.CurrentLineNumber)
        (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    def text(data: str) -> None:
        if opened and len(opened[-1].content) < _TEXT:
            opened[-1].content += data.strip()[:_TEXT]

    def doctype(*_: object) -> NoReturn:
        # expanding entities can fill the memory (the "billion laughs") or read other files
        refuse("the file has a <!DOCTYPE>, which can declare entities and is refused; remove it.")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: opened.pop()
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
        raise FileError(file, error.lineno, problem) from None
    except (ValueError, LookupError) as error:  # an encoding that Python does not know
        raise FileError(file, None, f"the XML cannot be decoded: {error}.") from None
    return roots[0]
