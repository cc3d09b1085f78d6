"""Cells that hold lists, as ROS's messages are written by way of tables: `"[0.1, 0.2]"` in a column
`position` becomes two cells below `position0` and `position1`."""

from __future__ import annotations

import re
from collections.abc import Sequence

_ENTRY = r"""(?:[-+.\w]+|'[^'"\[\]()]*'|"[^'"\[\]()]*"|""[^'"\[\]()]*"")"""
_LIST = re.compile(
    rf"""(?P<before>^|[,;\t ])
    (?P<quote>"?)(?:array\((?:'d'|"d"|""d""),\s*)?[\[(]
    (?P<entries>\s*{_ENTRY}(?:(?:\s*,\s*|\s+){_ENTRY})*\s*(?:,\s*)?)
    [\])](?:,\s*dtype=\w+)?\)?(?P=quote)(?=[,;\t\s]|$)""",
    re.VERBOSE,
)
"""A whole cell between separators that is a list or tuple of numbers or of words in quotes."""
_BETWEEN = re.compile(r"\s*,\s*|\s+")
_NUMBER = re.compile(r"[-+]?(?:\d|\.\d|nan|inf)", re.IGNORECASE)
_PLACE = "\0"
"""A sign that no line has, in the place of a cell while cells are counted."""


def has_lists(lines: Sequence[str]) -> bool:
    """Whether cells of these lines hold lists, of numbers or of words in quotes."""
    return any(_is_list(found) for line in lines for found in _LIST.finditer(line))


def without_lists(lines: Sequence[str]) -> list[str]:
    """The lines with one sign for each list, so that separators can be counted."""
    return [_LIST.sub(lambda x: x["before"] + _PLACE if _is_list(x) else x[0], x) for x in lines]


def lists_as_cells(lines: list[str], separator: str) -> list[str]:
    """The lines with a cell for each entry of a list; names above the first line that has some are
    numbered from 0."""
    first = next(k for k, line in enumerate(lines) if has_lists([line]))
    sizes = _sizes(lines[first], separator)
    above = [_numbered(line, sizes, separator) for line in lines[:first]]
    return above + [_LIST.sub(lambda x: _spread(x, separator), line) for line in lines[first:]]


def _is_list(found: re.Match[str]) -> bool:
    entries = _entries(found)
    return all(x[0] in "'\"" or _NUMBER.match(x) for x in entries)


def _entries(found: re.Match[str]) -> list[str]:
    return [x for x in _BETWEEN.split(found["entries"].strip()) if x]


def _spread(found: re.Match[str], separator: str) -> str:
    if not _is_list(found):
        return found[0]
    return found["before"] + separator.join(x.strip("'\"") for x in _entries(found))


def _sizes(line: str, separator: str) -> list[int]:
    """How many cells each cell of a line becomes, 0 for one that stays."""
    found = [x for x in _LIST.finditer(line) if _is_list(x)]
    counts = iter([len(_entries(x)) for x in found])
    cells = without_lists([line])[0].split(separator)
    return [next(counts) if cell.strip() == _PLACE else 0 for cell in cells]


def _numbered(line: str, sizes: Sequence[int], separator: str) -> str:
    names = line.rstrip("\r\n").split(separator)
    if len(names) != len(sizes):
        return line
    cells = [
        [name] if size == 0 else [f"{_bare(name)}{k}" for k in range(size)]
        for name, size in zip(names, sizes, strict=True)
    ]
    return separator.join(x for part in cells for x in part)


def _bare(name: str) -> str:
    return name.strip().strip('"')
