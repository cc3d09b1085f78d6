"""The data files, read in one place for items and exercises: what the notes say, as TOML beside the
checks."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any


def data(name: str) -> dict[str, Any]:
    """A file of this package, "contents.toml"; white space in its texts does no more than wrap
    lines."""
    text = (files("freebody_notes") / name).read_text(encoding="utf-8")
    return _unwrapped(tomllib.loads(text))


def _unwrapped(x: Any) -> Any:
    if isinstance(x, dict):
        return {key: _unwrapped(value) for key, value in x.items()}
    if isinstance(x, list):
        return tuple(map(_unwrapped, x))
    return " ".join(x.split()) if isinstance(x, str) else x
