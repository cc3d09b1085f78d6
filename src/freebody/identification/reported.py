"""Results with a verdict as reports in text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from freebody.outputs.display import Tabled, TextTable


class _HasReport(Protocol):
    def lines(self) -> list[str]: ...
    def _title(self) -> str: ...
    def _table(self) -> TextTable: ...
    def _sections(self) -> Sequence[tuple[str, TextTable]]: ...


class Reported(Tabled):
    """A base class for results with a verdict and notices, which `_table()` has below its rows:
    `str` of one is its report, title, tables, verdict and notices."""

    def __str__(self: _HasReport) -> str:
        return "\n".join(self.lines())

    def lines(self: _HasReport) -> list[str]:
        """The result in words and tables, line by line."""
        table, lines = self._table(), [self._title(), ""]
        for heading, section in (("", table), *self._sections()):
            rows = [*([section.head] if section.head else []), *section.rows]
            lines += [*([heading] if heading else []), *aligned_rows(rows), ""]
        return [*lines, *table.notes]

    def _sections(self) -> Sequence[tuple[str, TextTable]]:
        """Tables of the report that the short one does not have, with a line above each, or ""."""
        return ()


def aligned_rows(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table of texts, its columns below one another."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
