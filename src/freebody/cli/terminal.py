"""What the terminal sees: results on stdout, and on stderr red errors, yellow warnings, progress; one line each."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

from freebody.errors import FreebodyWarning

if TYPE_CHECKING:
    from rich.console import Console

_WIDE = 140
"""Columns where output goes to a file or a pipe."""


@cache
def out() -> Console:
    """stdout."""
    return _console(stderr=False)


@cache
def err() -> Console:
    """stderr."""
    return _console(stderr=True)


def _console(stderr: bool) -> Console:
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr, highlight=False, width=None if stream.isatty() else _WIDE)


def error(text: str) -> int:
    """One red line; the exit code for bad input."""
    _line(f"error: {text}", "bold red")
    return 2


def warn(text: str) -> None:
    """One yellow line."""
    _line(text if "warning: " in text else f"warning: {text}", "yellow")


def _line(text: str, style: str) -> None:
    err().print(" ".join(text.split()), style=style, markup=False, highlight=False, soft_wrap=True)


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Prints freebody's warnings as yellow lines, each once, when the block ends."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FreebodyWarning)
        try:
            yield
        finally:
            texts = [str(w.message) for w in caught if issubclass(w.category, FreebodyWarning)]
    for text in dict.fromkeys(texts):
        warn(text)


@contextmanager
def progress(text: str) -> Iterator[Callable[[str, float], None]]:
    """A bar on stderr while the block runs, gone afterwards; the function tells it what is done and how much."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err(), transient=True, disable=not err().is_terminal) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda doing, done: bar.update(task, description=doing, completed=done)
