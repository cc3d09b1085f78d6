"""Results in shells and notebooks: one line in a shell, a small table in a notebook."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from freebody.outputs.text import legal

MOST = 24
"""Rows of a table that are shown."""

_LONGEST = 160
"""Number of letters that a line may have."""


@dataclass(frozen=True)
class TextTable:
    """A table of texts: a head, rows, and sentences below."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Iterable[str] = ()

    def html(self, title: str = "", most: int = MOST) -> str:
        """The table as HTML elements; names in it stay text. Columns of words are aligned left,
        which notebooks do not do; empty columns are left out."""
        above = f"<p><b>{_text(title)}</b></p>" if title else ""
        shown = self.rows[:most]
        align = {k: "" if numeric else _LEFT for k, numeric in columns_of(shown).items()}
        head = "".join(f"<th{own}>{_text(self.head[k])}</th>" for k, own in align.items())
        rows = "".join(
            f"<tr>{''.join(f'<td{own}>{_text(row[k])}</td>' for k, own in align.items())}</tr>"
            for row in shown
        )
        left = len(self.rows) - most
        notes = [*([f"… and {left} more"] if left > 0 else []), *self.notes]
        below = "".join(f"<p>{_text(note)}</p>" for note in notes)
        table = (
            f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
            if self.rows
            else ""
        )
        return above + table + below


class _HasTitle(Protocol):
    def _title(self) -> str: ...


class _HasTable(_HasTitle, Protocol):
    def _table(self) -> TextTable: ...


class Titled:
    """A base class for results that a shell shows as one line, `_title()`, instead of all their
    contents."""

    def __repr__(self: _HasTitle) -> str:
        title = legal(" ".join(self._title().split()))
        return f"<{title if len(title) <= _LONGEST else title[: _LONGEST - 1] + '…'}>"


class InWords(Titled):
    """A base class for results that IPython and notebooks show in the words of their `str`."""

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(legal(str(self)))


class Tabled(Titled):
    """A base class for results that notebooks also show as a table, `_table()`."""

    def _repr_html_(self: _HasTable) -> str:
        return self._table().html(self._title())


def counted(count: int, what: str) -> str:
    """A count with its noun: "1 body", "2 bodies"."""
    plural = f"{what[:-1]}ies" if what.endswith("y") else f"{what}s"
    return f"{count} {what if count == 1 else plural}"


_LEFT = ' style="text-align:left"'
_NUMBER = re.compile(r"[-−+]?(\d|\.\d|∞|inf|nan|–)")


def columns_of(rows: Sequence[Sequence[str]]) -> dict[int, bool]:
    """For each column that is not entirely empty whether it holds numbers, some of which may be
    missing."""
    return {
        k: all(_NUMBER.match(cell) for cell in cells if cell and cell != "?")
        for k, cells in enumerate(zip(*rows, strict=True))
        if any(cells)
    }


def _text(text: str) -> str:
    return html.escape(legal(text))
