"""The notes' data files: statements of the notes as TOML beside the checks."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any


def data(name: str) -> dict[str, Any]:
    """Contents of a data file of this package, such as "contents.toml"; line breaks within its
    texts become spaces."""
    text = (files("freebody_notes") / name).read_text(encoding="utf-8")
    return _unwrapped(tomllib.loads(text))


def _unwrapped(x: Any) -> Any:
    if isinstance(x, dict):
        return {key: _unwrapped(value) for key, value in x.items()}
    if isinstance(x, list):
        return tuple(map(_unwrapped, x))
    return " ".join(x.split()) if isinstance(x, str) else x
