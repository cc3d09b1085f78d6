"""The items of the notes, executed once in a process for all tests that read what came out."""

from __future__ import annotations

from functools import cache

import pytest

from freebody_notes import item as runner
from freebody_notes.contents import items
from freebody_notes.item import ExecutedItem, Item

_run = runner.run
_BY_ID = {x.id: x for x in items()}


@cache
def finding(name: str) -> ExecutedItem:
    """The item of this id, executed."""
    return _run(_BY_ID[name])


def findings() -> list[ExecutedItem]:
    """All items, executed, in their order."""
    return [finding(name) for name in _BY_ID]


def executing_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands take what has been executed before."""

    def run(item: Item) -> ExecutedItem:
        return finding(item.id) if _BY_ID.get(item.id) is item else _run(item)

    monkeypatch.setattr(runner, "run", run)
