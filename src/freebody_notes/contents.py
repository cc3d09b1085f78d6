"""The contents of the notes: chapters, sections and all items in order, and finding an item.

`contents.toml` names the files of `chapters`: of each, the .toml file holds what the notes say, the
.py file the checks.
"""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from importlib.resources import files
from typing import Any

from freebody.errors import UnknownNameError
from freebody_notes.checks import SHARED
from freebody_notes.item import Item


@dataclass(frozen=True)
class Chapter:
    """A chapter: its title, what it is for, where it is used, the files that hold it, the titles of
    its sections by number, and what to try: a command, and what to look for."""

    title: str
    about: str
    used: str
    parts: tuple[str, ...]
    sections: Mapping[str, str]
    tasks: tuple[Mapping[str, str], ...]


@cache
def chapters() -> Mapping[int, Chapter]:
    """The chapters by their numbers."""
    return {int(number): Chapter(**words) for number, words in data("contents.toml").items()}


@cache
def items() -> tuple[Item, ...]:
    """Every item of the notes."""
    parts = dict.fromkeys(part for chapter in chapters().values() for part in chapter.parts)
    return tuple(sorted((item for part in parts for item in _of_part(part)), key=_place))


def _of_part(part: str) -> Iterator[Item]:
    checks = SHARED | importlib.import_module(f"freebody_notes.chapters.{part}").CHECKS
    for section, entries in data(f"chapters/{part}.toml").items():
        for name, entry in entries.items():
            yield _item(name, section, entry, checks)


_FIELDS = {field.name for field in fields(Item)}


def _item(name: str, section: str, entry: dict[str, Any], checks: Mapping[str, Any]) -> Item:
    """Make an item from its entry in the data file; fields of the entry that are not the item's
    belong to its check."""
    check = entry.pop("check")
    if check not in checks:
        raise UnknownNameError("check", check, name, checks)
    details = {key: entry.pop(key) for key in sorted(entry.keys() - _FIELDS)}
    return Item(name, section, check=replace(checks[check], **details), **entry)


def _place(item: Item) -> tuple[list[int], bool]:
    """Sort key of an item: by section, figures first; within a section the order of the files is
    kept."""
    return [int(n) for n in item.section.split(".")], not item.is_figure


def item(name: str) -> Item:
    """Find an item by its id; "3.22" and "(3.22)" mean eq-3.22."""
    by_id = {x.id: x for x in items()}
    plain = name.strip().strip("()").lower()
    for spelling in (name, plain, f"eq-{plain}"):
        if spelling in by_id:
            return by_id[spelling]
    raise UnknownNameError("item", name, "the notes", by_id)


def about(words: str) -> tuple[Item, ...]:
    """Items of which the title or what they say contains some words."""
    sought = words.strip().casefold()
    return tuple(x for x in items() if sought and sought in f"{x.title} {x.says}".casefold())


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
