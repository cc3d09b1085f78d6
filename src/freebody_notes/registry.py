"""All items, in the order of the notes, and how one is found."""

from __future__ import annotations

import importlib
from functools import cache

from freebody.errors import UnknownNameError
from freebody_notes.item import Item

CHAPTERS = (
    "planar_motion", "mass", "planar_body", "jacobian", "five_bar", "statics", "pendulum", "two_link", "recursion",
    "energy", "lagrange", "first_kind", "space_body", "quadrotor", "space_recursion", "drawings",
)  # fmt: skip
"""Files of `notes.chapters`."""


@cache
def items() -> tuple[Item, ...]:
    """Every item of the notes."""
    found: list[Item] = []
    for name in CHAPTERS:
        found += importlib.import_module(f"freebody_notes.chapters.{name}").ITEMS
    return tuple(sorted(found, key=_place))


def _place(item: Item) -> tuple[list[int], bool]:
    """By section, the figures in front; within that as the files have them."""
    return [int(n) for n in item.section.split(".")], item.kind != "figure"


def item(name: str) -> Item:
    """The item of an id; "3.22" and "(3.22)" are eq-3.22."""
    by_id = {x.id: x for x in items()}
    plain = name.strip().strip("()").lower()
    for spelling in (name, plain, f"eq-{plain}"):
        if spelling in by_id:
            return by_id[spelling]
    raise UnknownNameError("item", name, "the notes", by_id)
