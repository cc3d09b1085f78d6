"""Changes of attributes in the text of an XML file: as small as possible, with all other bytes as
they were."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from xml.parsers import expat

from freebody.diagnosis.facts import elements_in
from freebody.diagnosis.finding import AttributeChange
from freebody.formats.urdf_elements import XmlElement

_ATTRIBUTE = rb"""\s(%s)\s*=\s*("[^"]*"|'[^']*')"""
_NAME = re.compile(rb"<[^\s/>]+")


def changed(data: bytes, root: XmlElement, changes: Sequence[AttributeChange]) -> bytes:
    """The text of a file with other values of attributes; root is what was read of it. An attribute
    that an element lacks is put behind its name. The first of several changes of one attribute
    counts."""
    start_of = dict(zip(map(id, elements_in(root)), _starts(data), strict=True))
    pieces: dict[tuple[int, int], bytes] = {}
    for element, attribute, value in changes:
        begin = start_of[id(element)]
        text = escape(value).encode()
        found = re.compile(_ATTRIBUTE % re.escape(attribute.encode())).search(
            data, begin, _end(data, begin)
        )
        if found:
            pieces.setdefault((found.start(2) + 1, found.end(2) - 1), text)
        else:
            name = _NAME.match(data, begin)
            assert name is not None
            pieces.setdefault((name.end(), name.end()), b' %s="%s"' % (attribute.encode(), text))
    for (begin, end), text in sorted(pieces.items(), reverse=True):
        data = data[:begin] + text + data[end:]
    return data


def _starts(data: bytes) -> list[int]:
    """The byte at which each element begins."""
    found: list[int] = []
    text = data.rstrip(b"\0")
    before = len(text) - len(text.lstrip()) if text.lstrip().startswith(b"<?xml") else 0
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda *_: found.append(before + parser.CurrentByteIndex)
    parser.Parse(text[before:], True)
    return found


def _end(data: bytes, begin: int) -> int:
    """The end of a start tag; what stands in quotes does not end it."""
    tag = re.compile(rb"""<(?:[^"'>]|"[^"]*"|'[^']*')*>""").match(data, begin)
    assert tag is not None
    return tag.end()
