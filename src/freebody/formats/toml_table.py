"""A TOML text as checked tables: every value is read by kind, every refusal names file and line.

The standard library's parser does not tell on which line a key stands, so a scanner walks over the
text, which is valid TOML by then (parse it first).
"""

from __future__ import annotations

import math
import re
import tomllib
from bisect import bisect_left
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn, TypeVar

from freebody.errors import FileError, UnknownNameError, shown
from freebody.formats import read_file
from freebody.model.parameters import Parameter, Quantity
from freebody.outputs.display import counted

KeyPath = tuple[str | int, ...]
"""The place of a value in a text, such as ("joint", 2, "axis")."""

MOST_TEXT, MOST_VALUES, DEEPEST = 16 * 2**20, 2_000_000, 64

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_INLINE_BLANK = re.compile(r"[ \t]*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\])*"|\'[^\']*\'', re.DOTALL
)
_MARK = re.compile(rf"{_STRING.pattern}|#[^\n]*|[.,=\n\[\]{{}}]", re.DOTALL)
_SCALAR = re.compile(r"[^,\]}#\r\n]+")
_TEXT_NUMBER = re.compile(rf"({read_file.DECIMAL})(?:\s*([a-z/]+))?", re.ASCII)
UNITS: dict[str, dict[str, float]] = {
    "number": {},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "rate": {"rad/s": 1.0, "deg/s": math.pi / 180},
    "speed": {"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": math.pi / 30},
}
"""Units that a number may have when it is written as text, in SI units."""
_REQUIRED = object()
_TextChoice = TypeVar("_TextChoice", bound=str)


def table_of(file: str, text: str) -> TomlTable:
    """The parsed text, with its lines. Raises FileError with the line where it is not TOML."""
    _bounded(file, text)
    try:
        data, found = tomllib.loads(text), lines(text)
    except tomllib.TOMLDecodeError as error:
        where = re.search(r" \(at (?:line (\d+), column \d+|end of document)\)", str(error))
        message = str(error)[: where.start()] if where else str(error)
        line = int(where[1]) if where and where[1] else text.count("\n") + 1
        raise FileError(
            file, line, f"this is not valid TOML: {message[0].lower()}{message[1:]}."
        ) from None
    except ValueError:  # Python's own limit, against time that grows with the square of the digits
        long = re.search(r"[0-9_]{4000,}", text)
        line = text.count("\n", 0, long.start()) + 1 if long else None
        raise FileError(file, line, "a number has more than 4300 digits.") from None
    return TomlTable(file, found, (), data)


def in_units(text: str, kind: str) -> float | None:
    """Number of a text such as "30 deg", in SI units; None if it is no number of that kind."""
    match = _TEXT_NUMBER.fullmatch(text.strip())
    if not match or (match[2] and match[2] not in UNITS[kind]):
        return None
    if match[2] and match[2].startswith("deg"):
        return math.radians(float(match[1]))
    return float(match[1]) * UNITS[kind].get(match[2] or "", 1.0)


def is_name(text: str) -> bool:
    """Whether a text can name a parameter."""
    return text.isidentifier() and text.lower() not in ("nan", "inf", "infinity")


@dataclass(frozen=True)
class TomlTable:
    """A TOML table with its place in the file and its name in errors."""

    file: str
    lines: Mapping[KeyPath, int]
    path: KeyPath
    data: Mapping[str, Any]
    where: str = ""

    @property
    def line(self) -> int | None:
        """The line on which the table begins."""
        return line_of(self.lines, self.path)

    def called(self, where: str) -> TomlTable:
        """This table, called `where` in errors."""
        return TomlTable(self.file, self.lines, self.path, self.data, where)

    def refuse(self, problem: str, *at: str | int) -> NoReturn:
        """Raise FileError at a key or entry of this table."""
        prefix = f"{self.where}: " if self.where else ""
        raise FileError(self.file, line_of(self.lines, (*self.path, *at)), prefix + problem)

    def unknown(self, what: str, name: str, known: Iterable[str], *at: str | int) -> NoReturn:
        """Refuse a name that does not exist."""
        problem = str(UnknownNameError(what, name, self.where or "the file", known))
        raise FileError(self.file, line_of(self.lines, (*self.path, *at)), problem)

    def only(self, *known: str) -> TomlTable:
        """Refuse keys that nothing reads."""
        for key in self.data:
            if key not in known:
                self.unknown("key", key, known, key)
        return self

    def __contains__(self, key: str) -> bool:
        return key in self.data

    # ------------------------------------------------------------ values by kind
    def text(self, key: str, default: Any = _REQUIRED) -> str:
        """Value of a key as a text that is not empty."""
        value = self.get(key, default)
        if value is not default and (not isinstance(value, str) or not value.strip()):
            self.refuse(f"{key} is {shown(value)}, expected text in quotes.", key)
        return value

    def flag(self, key: str) -> bool:
        """A value that is true or false; false where the key is absent."""
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            self.refuse(f"{key} is {shown(value)}, expected true or false.", key)
        return value

    def choice(
        self, key: str, allowed: Collection[_TextChoice], default: Any = _REQUIRED
    ) -> _TextChoice:
        """Value of a key that must be one of some words."""
        value = self.text(key, default)
        for word in allowed:
            if word == value:
                return word
        self.unknown(key, value, allowed, key)

    def number(
        self, key: str, kind: str = "number", default: Any = _REQUIRED, infinite: bool = False
    ) -> float:
        """A number in SI units, or text with a unit of `kind`."""
        value = self.get(key, default)
        return value if value is default else self.read_number(value, kind, (key,), infinite)

    def quantity(self, key: str, kind: str = "number", default: Any = _REQUIRED) -> Quantity:
        """A number, a name, or {name = ..., value = ...}."""
        value = self.get(key, default)
        return value if value is default else self.read_quantity(value, kind, (key,))

    def vector(
        self, key: str, size: int, kind: str = "number", default: Any = _REQUIRED
    ) -> tuple[float, ...]:
        """Value of a key as `size` numbers."""
        value = self.get(key, default)
        if value is default:
            return value
        return tuple(
            self.read_number(x, kind, (key, i)) for i, x in enumerate(self.listed(value, key, size))
        )

    def quantities(
        self, key: str, size: int | None, kind: str = "number", default: Any = _REQUIRED
    ) -> tuple[Quantity, ...]:
        """Value of a key as `size` quantities (None: any number of quantities)."""
        value = self.get(key, default)
        if value is default:
            return value
        return tuple(
            self.read_quantity(x, kind, (key, i))
            for i, x in enumerate(self.listed(value, key, size))
        )

    def matrix(self, key: str, size: int) -> tuple[tuple[float, ...], ...]:
        """Value of a key as `size` rows of `size` numbers."""
        rows = self.listed(self.get(key, _REQUIRED), key, size)
        return tuple(
            tuple(
                self.read_number(x, "number", (key, i, j))
                for j, x in enumerate(self.listed(row, key, size, i))
            )
            for i, row in enumerate(rows)
        )

    def table(self, key: str) -> TomlTable | None:
        """The table of that key, or None."""
        return self.inner(self.data[key], key) if key in self.data else None

    def tables(self, key: str) -> list[TomlTable]:
        """The tables of an array of tables, perhaps none."""
        items = self.data.get(key, [])
        if not isinstance(items, list):
            self.refuse(
                f"{key} is {_kind(items)}, expected tables: write [[{key}]] above each.", key
            )
        return [self.inner(item, key, i) for i, item in enumerate(items)]

    # ------------------------------------------------------------ helpers
    def get(self, key: str, default: Any) -> Any:
        if key in self.data:
            return self.data[key]
        if default is _REQUIRED:
            self.refuse(f"{key} is missing; add {key} = ...")
        return default

    def inner(self, value: Any, *at: str | int) -> TomlTable:
        """The value at a key as a table inside this one."""
        if not isinstance(value, dict):
            self.refuse(
                f"{_label(at)} is {_kind(value)}, expected a table such as {{ key = value }}.", *at
            )
        return TomlTable(self.file, self.lines, (*self.path, *at), value, self.where)

    def listed(self, value: Any, key: str, size: int | None, *at: int, each: str = "") -> list[Any]:
        """The value at a key as a list of so many entries; `each` says what they are, for who gave
        another number of them."""
        if not isinstance(value, list):
            self.refuse(
                f"{_label((key, *at))} is {_kind(value)}, expected a list of numbers in brackets.",
                key,
                *at,
            )
        if size is not None and len(value) != size:
            self.refuse(
                f"{_label((key, *at))} has {counted(len(value), 'entry')}, expected {size}"
                f"{each and f': {each}'}.",
                key,
                *at,
            )
        return value

    def read_number(self, value: Any, kind: str, at: KeyPath, infinite: bool = False) -> float:
        """The number that a TOML value stands for."""
        units = " or ".join(f'"30 {unit}"' for unit in UNITS[kind] if unit[:3] in ("deg", "rpm"))
        expected = f"a number{f', or text such as {units}' if units else ''}"
        if isinstance(value, str):
            number = in_units(value, kind)
            if number is None:
                self.refuse(f"{_label(at)} is {shown(value)}, expected {expected}.", *at)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            try:
                number = float(value)
            except OverflowError:
                number = math.inf
        else:
            self.refuse(f"{_label(at)} is {_kind(value)}, expected {expected}.", *at)
        problem = read_file.fault(number, infinite)
        if problem:
            self.refuse(f"{_label(at)} is {number:g}, {problem}.", *at)
        return number

    def read_quantity(self, value: Any, kind: str, at: KeyPath) -> Quantity:
        """The quantity that a TOML value stands for."""
        if isinstance(value, dict):
            inner = self.inner(value, *at).only("name", "value")
            return inner.parameter(inner.text("name"), inner.number("value", kind, None))
        if isinstance(value, str) and in_units(value, kind) is None:
            if is_name(value):
                return Parameter(value)
            hint = "; angles also as text such as '30 deg'" if kind == "angle" else ""
            if any(in_units(value, other) is not None for other in UNITS):
                hint = ", in SI units"
            elif re.search(r"[-+*/^]", value):
                hint += "; write a formula below [parameters], and its name here"
            self.refuse(
                f"{_label(at)} is {shown(value)}, expected a number or a name such as 'l1'{hint}.",
                *at,
            )
        return self.read_number(value, kind, at)

    def parameter(self, name: str, value: float | None) -> Parameter:
        if not is_name(name):
            self.refuse(
                f"{shown(name)} is not a parameter name; use letters, digits and _, such as 'l1'."
            )
        return Parameter(name, value)


def _label(at: KeyPath) -> str:
    """A key path as messages write it: inertia[2] for ("inertia", 2)."""
    return "".join(
        f"[{part}]" if isinstance(part, int) else f".{part}" for part in at
    ).removeprefix(".")


def _kind(value: object) -> str:
    names = {
        dict: "a table",
        list: "a list",
        bool: "true or false",
        str: "text",
        int: "a number",
        float: "a number",
    }
    return names.get(type(value), f"a {type(value).__name__}")


def _bounded(file: str, text: str) -> None:
    """Refuse a text on which the parser would take too long or nest too deeply: too many values,
    keys of many parts, nested brackets."""
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


def lines(text: str) -> dict[KeyPath, int]:
    """Line (from 1) of every table, key and array entry, by its path such as ("joint", 2,
    "axis")."""
    return _Scanner(text).found


def line_of(found: Mapping[KeyPath, int], path: KeyPath) -> int | None:
    """Line of a path, or of the nearest key above it that has a line."""
    while path and path not in found:
        path = path[:-1]
    return found.get(path)


class _Scanner:
    def __init__(self, text: str):
        self.text, self.at = text, 0
        self.ends = [match.start() for match in re.finditer("\n", text)]
        self.found: dict[KeyPath, int] = {}
        self.sizes: dict[KeyPath, int] = {}  # of arrays of tables
        self.table: KeyPath = ()
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

    def note(self, path: KeyPath, start: int) -> None:
        self.found.setdefault(path, bisect_left(self.ends, start) + 1)

    def key(self) -> list[str]:
        """Read a key, which may be dotted."""
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
        """Read a header [table] or [[array of tables]]; a part of its name that is an array stands
        for the array's last entry."""
        start = self.at
        twice = self.text.startswith("[[", start)
        self.at += 2 if twice else 1
        *outer, last = self.key()
        self.at += 2 if twice else 1
        path: KeyPath = ()
        for part in outer:
            path = self.entered((*path, part))
        path = (*path, last)
        self.note(path, start)
        if twice:
            self.sizes[path] = self.sizes.get(path, 0) + 1
            path = self.entered(path)
        self.table = path
        self.note(path, start)

    def entered(self, path: KeyPath) -> KeyPath:
        return (*path, self.sizes[path] - 1) if path in self.sizes else path

    def entry(self, table: KeyPath) -> None:
        """Read one line key = value of a table and note where each key stands."""
        start = self.at
        path = (*table, *self.key())
        for size in range(len(table) + 1, len(path) + 1):
            self.note(path[:size], start)
        self.at += 1  # the equals sign
        self.skip(_INLINE_BLANK)
        self.value(path)

    def value(self, path: KeyPath) -> None:
        first = self.text[self.at]
        if first in "\"'":
            self.skip(_STRING)
        elif first == "[":
            self.items("]", path)
        elif first == "{":
            self.items("}", path)
        else:
            self.skip(_SCALAR)

    def items(self, end: str, path: KeyPath) -> None:
        """Read the entries of an array or inline table up to its closing bracket."""
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
