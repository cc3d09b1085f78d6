"""The one reader of what comes from outside: bytes of regular files, never more than asked for,
their lines and cells, and numbers in text; and the bundled data.

Python's own `float` also takes 1_0, digits of other scripts and blanks around; here a number is
what C would print.
"""

from __future__ import annotations

import csv
import math
import os
import re
import stat
from importlib import resources
from pathlib import Path

from freebody.errors import FileError, KindError, likely, shown
from freebody.model.parameters import LARGEST

LARGEST_FILE = 32 * 2**20
"""Bytes of a robot description; the longest known has less than one megabyte."""
_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
DECIMAL = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
"""A decimal number, as a regular expression for ASCII text. No two parts of it can share digits:
100 000 digits that are no number would else be divided in as many ways, each tried to its end."""
NOT_FINITE = "not a finite number"
_NUMBER = re.compile(rf"{DECIMAL}|[+-]?inf(?:inity)?|nan", re.ASCII | re.IGNORECASE)


def read(
    path: str | os.PathLike[str], most: int = LARGEST_FILE, what: str = "a robot description"
) -> bytes:
    """The bytes of a text file: as `contents`, and binary ones refused; NUL bytes at the end do not
    make it one."""
    data = contents(path, most, what)
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in data.rstrip(b"\0") and not wide:
        raise FileError(Path(path), None, "the file is binary, not text.")
    return data


def path_of(function: str, argument: str, given: object, what: str) -> str:
    """The path that a function was given, as text; refuses what is none. what: of which file."""
    if not isinstance(given, str | os.PathLike) or isinstance(path := os.fspath(given), bytes):
        raise KindError(function, argument, given, f"the path of {what}")
    return path


def contents(path: str | os.PathLike[str], most: int, what: str) -> bytes:
    """The bytes of a regular file of at most `most` bytes; what: the kind of file, for errors.

    Raises FileError for what is missing, no regular file, empty, or larger. A pipe or device is not
    even opened, which may wait for ever, or do something. A symbolic link to a file is as good as
    the file.
    """
    path = Path(path)
    try:
        _regular(path, os.stat(path).st_mode)
        data = _bytes(path, most + 1)
    except FileError:  # a ValueError too
        raise
    except FileNotFoundError:
        raise FileError(path, None, _missing(path)) from None
    except OSError as error:
        raise FileError(path, None, f"the file cannot be read: {error.strerror}.") from None
    except ValueError:  # a NUL in the name
        raise FileError(shown(str(path)), None, "there is no such file.") from None
    if len(data) > most:
        raise FileError(path, None, f"the file has more than {_size(most)}, too much for {what}.")
    if not data or data.isspace():
        raise FileError(path, None, "the file is empty.")
    return data


def decoded(file: str, data: bytes) -> str:
    """The text of UTF-8 data, with or without byte order mark."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError(file, line, "the text is not UTF-8; save it as UTF-8.") from None


def lines(text: str) -> list[str]:
    """The lines of a text as editors count them, with the line ends of any system."""
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


def cells(file: str | Path, line: int, text: str, delimiter: str = ",") -> list[str]:
    """The cells of one line of a CSV file, blanks around them removed."""
    try:
        (row,) = csv.reader([text], delimiter=delimiter, skipinitialspace=True)
    except (csv.Error, ValueError) as error:
        raise FileError(file, line, f"this is not a line of a CSV table: {error}.") from None
    return [cell.strip() for cell in row]


def number(text: str) -> float | None:
    """The number that a text stands for, perhaps infinite or NaN; None for any other text."""
    return float(text) if _NUMBER.fullmatch(text) else None


def fault(value: float, infinite: bool = False) -> str | None:
    """The reason why a number cannot be used, or None. infinite: for bounds, which may be as large
    as they like."""
    if math.isnan(value) or (math.isinf(value) and not infinite):
        return NOT_FINITE
    if abs(value) > LARGEST and not infinite:
        return f"beyond {LARGEST:g}, more than any quantity of a robot"
    return None


def bundled_names() -> list[str]:
    """Names of the models that come with freebody, sorted without regard to case."""
    folder = resources.files("freebody").joinpath("robots")
    names = [
        entry.name.removesuffix(".toml")
        for entry in folder.iterdir()
        if entry.name.endswith(".toml")
    ]
    return sorted(names, key=str.lower)


def bundled_text(name: str) -> str:
    """The TOML text of a bundled model."""
    return (
        resources.files("freebody").joinpath("robots", f"{name}.toml").read_text(encoding="utf-8")
    )


def template_names() -> list[str]:
    """Names of the templates, sorted."""
    folder = resources.files("freebody").joinpath("robots", "templates")
    return sorted(
        x.name.removesuffix(".toml") for x in folder.iterdir() if x.name.endswith(".toml")
    )


def template_text(name: str) -> str:
    """The TOML text of a template."""
    folder = resources.files("freebody").joinpath("robots", "templates")
    return folder.joinpath(f"{name}.toml").read_text(encoding="utf-8")


def _regular(path: Path, mode: int) -> None:
    """Refuse a path that is no regular file, such as a folder or a device."""
    if stat.S_ISDIR(mode):
        raise FileError(path, None, f"this is a folder; name a file in it{_examples(path)}.")
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "no file")
        raise FileError(
            path,
            None,
            f"this is {kind}, not a file; save its contents in a file and name that file.",
        )


def _bytes(path: Path, most: int) -> bytes:
    # not waiting, and looking again at what was opened: another file may have taken the place of
    # the first
    flags = (
        os.O_RDONLY
        | getattr(os, "O_NONBLOCK", 0)
        | getattr(os, "O_CLOEXEC", 0)
        | getattr(os, "O_BINARY", 0)
    )
    with open(os.open(path, flags), "rb") as file:
        _regular(path, os.fstat(file.fileno()).st_mode)
        return file.read(most) or b""


def _size(most: int) -> str:
    return f"{most / 2**20:g} MB" if most >= 2**20 else f"{most // 1000} kB"


def _examples(folder: Path) -> str:
    try:
        names = sorted(p.name for p in folder.iterdir() if p.suffix in (".urdf", ".toml", ".csv"))
    except OSError:
        names = []
    return f", such as {names[0]}" if names else ""


def _missing(path: Path) -> str:
    folder = path.parent
    if not folder.is_dir():
        return f"there is no such file: folder {os.fspath(folder)!r} does not exist."
    try:
        near = likely(path.name, sorted(p.name for p in folder.iterdir()), most=3)
    except OSError:
        near = []
    hint = f" Similar names: {', '.join(near)}." if near else ""
    return f"there is no such file.{hint}"
