"""An item of the notes with its formula, its check, and the verdict, which comes out of the printed
form, and of the corrected one where that fails."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from typing import Protocol

from freebody.errors import FreebodyError

VERDICTS = ("holds", "misprint", "inconsistent", "incomplete")
"""Verdicts on the printed form: true; a misprint; in contradiction to the rest of the notes; true
only with an addition."""

SOURCE = "S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019"


def parts(form: str) -> list[str]:
    """The equations of a formula text, which are separated by semicolons."""
    return [part.strip() for part in form.split(";") if part.strip()]


@dataclass(frozen=True)
class Outcome:
    """Result of checking one formula: whether it holds, computed values, and an example at which it
    fails."""

    holds: bool
    lines: tuple[str, ...] = ()
    example: str = ""


class ItemCheck(Protocol):
    """A way to check a formula of the notes."""

    def run(self, form: str) -> Outcome:
        """Check one formula of the item: the printed or the corrected one."""
        ...

    def call(self, form: str) -> str:
        """Text of the call with which a user checks the formula."""
        ...

    @property
    def bold(self) -> Collection[str]:
        """Names printed in bold, of vectors and matrices."""
        ...


@dataclass(frozen=True)
class Item:
    """One item of the notes. `printed` and `corrected` are formulas (see
    `freebody_textbook.relations.formula`) or statements in words."""

    id: str
    section: str
    title: str
    check: ItemCheck
    says: str = ""
    """Statement of the item, in other words than the notes'."""
    printed: str = ""
    flaw: str = ""
    """Kind of the flaw where the printed form fails: misprint, inconsistent or incomplete."""
    corrected: str = ""
    why: str = ""
    """Sentence for the author on what is wrong."""
    figure: str = ""
    """Number of the figure that belongs to it, "1.2"."""
    same_as: tuple[str, ...] = ()
    """Ids of items that state the same: the results of an example, an equation printed twice."""

    @property
    def chapter(self) -> int:
        """The number of the chapter, 1 to 6."""
        return int(self.section[0])

    @property
    def number(self) -> str:
        """The item's number in the notes: equation (3.22), figure 1.2, or its section."""
        kind, _, rest = self.id.partition("-")
        if kind == "eq":
            return f"equation ({rest})"
        return f"figure {rest}" if kind == "fig" else f"section {self.section}"

    @property
    def label(self) -> str:
        """The item's number as cited: (3.22), Figure 1.2; "" without one."""
        kind, _, rest = self.id.partition("-")
        return {"eq": f"({rest})", "fig": f"Figure {rest}"}.get(kind, "")

    @property
    def is_text(self) -> bool:
        """Whether the item is a statement that cannot be executed."""
        return not self.check.call(self.printed or self.corrected)

    @property
    def is_figure(self) -> bool:
        """Whether the item is a figure."""
        return self.id.startswith("fig-")


@dataclass(frozen=True)
class ExecutedItem:
    """An item with the result of running its check."""

    item: Item
    verdict: str
    printed: Outcome
    corrected: Outcome | None = None
    seconds: float = field(default=0.0, compare=False)

    @property
    def lines(self) -> tuple[str, ...]:
        """Lines of evidence: on the printed formula, then on the corrected one."""
        return self.printed.lines + (self.corrected.lines if self.corrected else ())


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
