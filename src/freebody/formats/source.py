"""From what a user calls a model to bytes: files, and the data that comes with the package."""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path

from freebody.errors import FileError, likely

LARGEST = 64 * 2**20  # bytes; the longest robot description known has less than one megabyte


def read(path: Path) -> bytes:
    """The bytes of a text file. Raises FileError for what is missing, a folder, empty, huge or binary."""
    try:
        if path.is_dir():
            raise FileError(path, None, f"this is a folder; name a file in it{_examples(path)}.")
        if not path.exists():
            raise FileError(path, None, _missing(path))
        size = path.stat().st_size
        if size > LARGEST:
            raise FileError(
                path, None, f"the file has {size / 2**20:.0f} MB; a robot description has less than 64."
            )
        data = path.read_bytes()
    except OSError as error:
        raise FileError(path, None, f"the file cannot be read: {error.strerror}.") from None
    if not data.strip():
        raise FileError(path, None, "the file is empty.")
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in data[:4096] and not wide:
        raise FileError(path, None, "the file is binary, not text.")
    return data


def decoded(file: str, data: bytes) -> str:
    """UTF-8 text, with or without byte order mark."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError(file, line, "the text is not UTF-8; save it as UTF-8.") from None


def bundled_names() -> list[str]:
    """Names of the models that come with freebody, sorted without regard to case."""
    folder = resources.files("freebody").joinpath("robots")
    names = [entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")]
    return sorted(names, key=str.lower)


def bundled_text(name: str) -> str:
    """The TOML text of a bundled model."""
    return resources.files("freebody").joinpath("robots", f"{name}.toml").read_text(encoding="utf-8")


def _examples(folder: Path) -> str:
    names = sorted(p.name for p in folder.iterdir() if p.suffix in (".urdf", ".toml", ".csv"))
    return f", such as {names[0]}" if names else ""


def _missing(path: Path) -> str:
    folder = path.parent
    if not folder.is_dir():
        return f"there is no such file: folder {os.fspath(folder)!r} does not exist."
    near = likely(path.name, sorted(p.name for p in folder.iterdir()), most=3)
    hint = f" Near it: {', '.join(near)}." if near else ""
    return f"there is no such file.{hint}"
