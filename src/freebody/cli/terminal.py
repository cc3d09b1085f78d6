"""What the terminal sees: results on stdout, and on stderr red errors, yellow warnings, progress;
one line each."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from inspect import cleandoc
from typing import TYPE_CHECKING, Any, TextIO, cast

from freebody.cli.spelling import spelled
from freebody.errors import FileError, FreebodyWarning
from freebody.outputs.display import TextTable, columns_of
from freebody.outputs.files import reason
from freebody.outputs.text import legal

if TYPE_CHECKING:
    from rich.console import Console

_WIDE = 140
"""Columns where output goes to a file or a pipe."""
_MOST_WARNINGS = 40


def paragraphs(document: str | None) -> str:
    """A docstring as help: without the line breaks of the source, which are those of its width."""
    found = cleandoc(document or "").split("\n\n")
    return "\n\n".join(" ".join(one.split()) for one in found)


@cache
def out() -> Console:
    """stdout."""
    return _console(stderr=False)


@cache
def err() -> Console:
    """stderr."""
    return _console(stderr=True)


def _console(stderr: bool) -> Console:
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.segment import Segment

    class Inert(Console):
        """A console on which text from outside gives no orders: escape sequences and the like are
        shown as �."""

        def render(
            self, renderable: RenderableType, options: ConsoleOptions | None = None
        ) -> Iterator[Segment]:
            for segment in super().render(renderable, options):
                yield segment if segment.control else segment._replace(text=legal(segment.text))

    stream = sys.stderr if stderr else sys.stdout
    return Inert(stderr=stderr, highlight=False, width=None if stream.isatty() else _WIDE)


class Gone(Exception):
    """Whoever read stdout has read enough."""


class _Stream:
    """stdout, where what cannot be written is an error of that name; or stderr, where nothing is
    left to say it to.

    What its encoding lacks is spelled out.
    """

    def __init__(self, stream: TextIO | None, what: str):
        self._real, self._closed, self._what = stream or io.StringIO(), stream is None, what

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def write(self, text: str) -> int:
        if self._closed and text and self._what:
            raise FileError(self._what, None, "is closed; there is nowhere to print to.")
        self._tried(self._real.write, spelled(text, self._real.encoding or "utf-8"))
        return len(text)

    def flush(self) -> None:
        self._tried(self._real.flush)

    def _tried(self, act: Callable[..., Any], *arguments: str) -> Any:
        try:
            return act(*arguments)
        except OSError as failure:
            self._forget()
            if not self._what:
                return None
            if isinstance(failure, BrokenPipeError):
                raise Gone from None
            raise FileError(self._what, None, f"cannot be written: {reason(failure)}.") from None

    def _forget(self) -> None:
        """What is still in the buffer would fail again when the interpreter ends."""
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._real.fileno())
            os.close(nowhere)


@contextmanager
def streams() -> Iterator[None]:
    """Within the block a stdout that is closed, full or no longer read is said so."""
    real = sys.stdout, sys.stderr
    sys.stdout = cast(TextIO, _Stream(real[0], "standard output"))
    sys.stderr = cast(TextIO, _Stream(real[1], ""))
    try:
        yield
    finally:
        sys.stdout, sys.stderr = real


def error(text: str) -> int:
    """One red line; the exit code for bad input."""
    _line(f"error: {text}", "bold red")
    return 2


def warn(text: str) -> None:
    """One yellow line."""
    _line(text if "warning: " in text else f"warning: {text}", "yellow")


def _line(text: str, style: str) -> None:
    err().print(" ".join(text.split()), style=style, markup=False, highlight=False, soft_wrap=True)


def table(found: TextTable, red: Container[int] = ()) -> None:
    """Print a table, numbers on the right, columns that are empty throughout left out; red: rows
    that must be seen."""
    from rich.table import Table
    from rich.text import Text

    made, columns = Table(box=None, pad_edge=False, header_style="bold"), columns_of(found.rows)
    for k, numeric in columns.items():
        made.add_column(found.head[k], justify="right" if numeric else "left", no_wrap=numeric)
    for number, row in enumerate(found.rows):
        made.add_row(*(Text(row[k]) for k in columns), style="red" if number in red else None)
    out().print(made)


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Prints freebody's warnings as yellow lines, each once, when the block ends: the first of very
    many."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FreebodyWarning)
        try:
            yield
        finally:
            texts = [str(w.message) for w in caught if issubclass(w.category, FreebodyWarning)]
    different = list(dict.fromkeys(texts))
    for text in different[:_MOST_WARNINGS]:
        warn(text)
    if len(different) > _MOST_WARNINGS:
        warn(
            f"and {len(different) - _MOST_WARNINGS} more such warnings; in Python model.notices "
            f"has them all."
        )


@contextmanager
def progress(text: str) -> Iterator[Callable[[str, float], None]]:
    """A bar on stderr while the block runs, gone afterwards; the function tells it what is done and
    how much."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err(), transient=True, disable=not err().is_terminal) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda doing, done: bar.update(task, description=doing, completed=done)
