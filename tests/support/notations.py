"""Notations of books by their names, and one's own as the file that a user writes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import pytest

import freebody as fb

with pytest.raises(fb.UnknownNameError) as _told:
    fb.check(fb.planar("R"), "T = 0", notation="none")
NOTATIONS = tuple(str(_told.value).rpartition("Notations: ")[2].rstrip(".").split(", "))
"""The notations that freebody has, as it tells who asks for another."""


def own_notation(folder: Path, name: str, /, **entries: str | Mapping[str, str | float]) -> Path:
    """A file in the folder with these keys and tables, such as zero="down", names={"a": "l"}."""
    texts = {"title": name} | {key: x for key, x in entries.items() if isinstance(x, str)}
    tables = {key: x for key, x in entries.items() if not isinstance(x, str)}
    lines = [_line(*row) for row in texts.items()]
    for key, table in tables.items():
        lines += [f"[{key}]", *(_line(*row) for row in table.items())]
    path = folder / f"{name}.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def _line(key: str, value: str | float) -> str:
    return f"{json.dumps(key, ensure_ascii=False)} = {json.dumps(str(value), ensure_ascii=False)}"
