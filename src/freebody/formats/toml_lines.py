"""On which line of a TOML text each key stands; the standard library's parser does not tell.

The text must be valid TOML (parse it first): this only walks over it.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping

from freebody.errors import FileError

Path = tuple[str | int, ...]

MOST_TEXT, MOST_VALUES, DEEPEST = 16 * 2**20, 2_000_000, 64

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_INLINE_BLANK = re.compile(r"[ \t]*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\])*"|\'[^\']*\'', re.DOTALL
)
_MARK = re.compile(rf"{_STRING.pattern}|#[^\n]*|[.,=\n\[\]{{}}]", re.DOTALL)
_SCALAR = re.compile(r"[^,\]}#\r\n]+")


def bounded(file: str, text: str) -> None:
    """Refuse what takes the parser too long, or too deep: too many values, keys of many parts,
    nested brackets."""
    if len(text) > MOST_TEXT:
        raise FileError(file, None, f"the text has more than {MOST_TEXT >> 20} million characters.")
    depth = dots = values = 0
    for match in _MARK.finditer(text):
        mark = match[0]
        if mark == ".":
            dots += 1
        elif mark in "[{":
            depth, dots = depth + 1, 0
        elif mark in "]}":
            depth, dots = max(0, depth - 1), 0
        elif len(mark) == 1:  # an end of line, a comma, an equals sign
            values, dots = values + 1, 0
        too = (
            f"brackets are nested more than {DEEPEST} deep"
            if depth > DEEPEST
            else f"a key has more than {DEEPEST} parts"
            if dots > DEEPEST
            else f"there are more than {MOST_VALUES} lines and values"
            if values > MOST_VALUES
            else ""
        )
        if too:
            raise FileError(file, text.count("\n", 0, match.start()) + 1, f"{too}.")


def lines(text: str) -> dict[Path, int]:
    """Line (from 1) of every table, key and array entry, by its path such as ("joint", 2,
    "axis")."""
    return _Scanner(text).found


def line_of(found: Mapping[Path, int], path: Path) -> int | None:
    """The line of a path, or of the nearest thing around it."""
    while path and path not in found:
        path = path[:-1]
    return found.get(path)


class _Scanner:
    def __init__(self, text: str):
        self.text, self.at = text, 0
        self.ends = [match.start() for match in re.finditer("\n", text)]
        self.found: dict[Path, int] = {}
        self.sizes: dict[Path, int] = {}  # of arrays of tables
        self.table: Path = ()
        self.skip(_BLANK)
        while self.at < len(text):
            if text[self.at] == "[":
                self.header()
            else:
                self.entry(self.table)
            self.skip(_BLANK)

    def skip(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.at)
        assert match, f"no {pattern.pattern} at {self.at}"  # the text was parsed before
        self.at = match.end()
        return match[0]

    def note(self, path: Path, start: int) -> None:
        self.found.setdefault(path, bisect_left(self.ends, start) + 1)

    def key(self) -> list[str]:
        """A dotted key."""
        parts: list[str] = []
        while True:
            self.skip(_INLINE_BLANK)
            parts.append(
                self.skip(_STRING)[1:-1] if self.text[self.at] in "\"'" else self.skip(_BARE)
            )
            self.skip(_INLINE_BLANK)
            if self.text[self.at] != ".":
                return parts
            self.at += 1

    def header(self) -> None:
        """[table] or [[array of tables]]; parts of the name that are arrays mean their last
        entry."""
        start = self.at
        twice = self.text.startswith("[[", start)
        self.at += 2 if twice else 1
        *outer, last = self.key()
        self.at += 2 if twice else 1
        path: Path = ()
        for part in outer:
            path = self.entered((*path, part))
        path = (*path, last)
        self.note(path, start)
        if twice:
            self.sizes[path] = self.sizes.get(path, 0) + 1
            path = self.entered(path)
        self.table = path
        self.note(path, start)

    def entered(self, path: Path) -> Path:
        return (*path, self.sizes[path] - 1) if path in self.sizes else path

    def entry(self, table: Path) -> None:
        """key = value."""
        start = self.at
        path = (*table, *self.key())
        self.note(path, start)
        self.at += 1  # the equals sign
        self.skip(_INLINE_BLANK)
        self.value(path)

    def value(self, path: Path) -> None:
        first = self.text[self.at]
        if first in "\"'":
            self.skip(_STRING)
        elif first == "[":
            self.items("]", path)
        elif first == "{":
            self.items("}", path)
        else:
            self.skip(_SCALAR)

    def items(self, end: str, path: Path) -> None:
        """Entries of an array, or of an inline table, up to its bracket."""
        self.at += 1
        index = 0
        self.skip(_BLANK)
        while self.text[self.at] != end:
            if end == "]":
                self.note((*path, index), self.at)
                self.value((*path, index))
            else:
                self.entry(path)
            index += 1
            self.skip(_BLANK)
            if self.text[self.at] == ",":
                self.at += 1
                self.skip(_BLANK)
        self.at += 1
