"""The common part of commands that judge measurements: these are read, and results with a verdict
are printed, saved and turned into an exit status."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Protocol, TypeVar

import typer

from freebody.cli import options, terminal
from freebody.outputs.display import TextTable

SIMULATED = "simulated"
"""The word in the place of a file, for measurements made from the model."""
T = TypeVar("T")


class WithVerdict(Protocol):
    """A result with a verdict."""

    @property
    def verdict(self) -> str: ...
    @property
    def notices(self) -> tuple[str, ...]: ...
    def _table(self) -> TextTable: ...


def measured(text: str, read: Callable[[str], T], simulated: Callable[[], T]) -> T:
    """The measurements of a file, or simulated ones where the text is that word."""
    return simulated() if text == SIMULATED else read(text)


def tell(found: WithVerdict, style: str) -> None:
    """Prints a result's verdict, table and notices."""
    console = terminal.out()
    console.print(found.verdict, style=style, soft_wrap=True, markup=False)
    terminal.table(found._table())
    for notice in found.notices:
        console.print(f"note:    {notice}", soft_wrap=True, markup=False, highlight=False)


def conclude(
    context: typer.Context,
    found: Any,
    beside: Iterable[WithVerdict] = (),
    write: Callable[[], Iterable[Path]] | None = None,
) -> None:
    """Prints a result that says whether it is `trusted`, and those beside it, writes their files,
    and repeats the command. Raises Exit, with status 1, where the result is not to be trusted."""
    console = terminal.out()
    tell(found, "bold green" if found.trusted else "bold red")
    for other in beside:
        tell(other, "bold")
    for path in () if write is None else write():
        console.print(f"written: {path}", soft_wrap=True, markup=False, highlight=False)
    console.print(f"again:   {options.again(context)}", soft_wrap=True, highlight=False)
    if not found.trusted:
        raise typer.Exit(1)
