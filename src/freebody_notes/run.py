"""Items executed, below the command and for tests: the verdict comes out of the printed form, and
of the corrected one where that fails."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from freebody.errors import FreebodyError
from freebody_notes.item import VERDICTS, ExecutedItem, Item


class NotesError(FreebodyError):
    """Error for an item whose check is inconclusive: the printed formula fails, and its correction
    fails too or is not given."""


def run(item: Item) -> ExecutedItem:
    """Check one item of the notes.

    Where the printed form holds so does the item; where it fails the corrected form has to hold by
    the same check.
    """
    start = time.perf_counter()
    printed = item.check.run(item.printed)
    if printed.holds:
        return ExecutedItem(item, "holds", printed, seconds=time.perf_counter() - start)
    if item.flaw not in VERDICTS[1:]:
        raise NotesError(
            f"{item.id}: the printed form {item.printed!r} fails: {'; '.join(printed.lines)}"
        )
    corrected = item.check.run(item.corrected)
    if not corrected.holds:
        raise NotesError(
            f"{item.id}: the correction {item.corrected!r} fails: {'; '.join(corrected.lines)}"
        )
    return ExecutedItem(item, item.flaw, printed, corrected, time.perf_counter() - start)


def run_all(
    items: Iterable[Item], told: Callable[[str, float], None] | None = None
) -> list[ExecutedItem]:
    """Check items in order; `told` is called with the next item's name and the share that is
    done."""
    rows = list(items)
    found = []
    for k, item in enumerate(rows):
        if told is not None:
            told(item.id, k / len(rows))
        found.append(run(item))
    return found
