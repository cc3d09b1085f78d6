"""The terminal: results on stdout, and on stderr red errors, yellow warnings, progress; one line
each."""

from __future__ import annotations

import io
import os
import re
import sys
import unicodedata
import warnings
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from inspect import cleandoc
from typing import TYPE_CHECKING, Any, TextIO, cast

from freebody.errors import FileError, FreebodyWarning
from freebody.outputs.display import TextTable, columns_of
from freebody.outputs.files import reason
from freebody.outputs.text import legal

if TYPE_CHECKING:
    from rich.console import Console


_WIDE = 140
"""Columns where output goes to a file or a pipe."""
_MOST_WARNINGS = 40

_PLAIN = {
    "−": "-", "–": "-", "—": "-", "·": "*", "⋅": "*", "•": "*", "×": "x", "…": "...", "‘": "'",
    "’": "'", "“": '"', "”": '"', "′": "'", "→": "->", "←": "<-", "↔": "<->", "⇒": "=>", "⇔": "<=>",
    "≈": "~", "≠": "!=", "≤": "<=", "≥": ">=", "±": "+-", "√": "sqrt ", "∞": "inf", "∂": "d",
    "∫": "int ", "°": " deg", "∈": "in", "∥": "||", "λ": "lambda", "Λ": "Lambda", "⊥": "_|_",
    "✓": "ok", "⎡": "[", "⎢": "[", "⎣": "[", "⎤": "]", "⎥": "]", "⎦": "]",
}  # fmt: skip
_DOTS = {"\u0307": "_d", "\u0308": "_dd"}
"""Rates, as names are typed: theta1_d."""
_SUB = "".join(
    c for c in map(chr, range(0x1D62, 0x209D)) if unicodedata.decomposition(c).startswith("<sub>")
)
_SUPER = "²³¹" + "".join(
    c for c in map(chr, range(0x1D2C, 0x2080)) if unicodedata.decomposition(c).startswith("<super>")
)
_RATE = re.compile(f"([{''.join(_DOTS)}])([a-z]*[{_SUB}]*)")
_POWER = re.compile(f"[{_SUPER}]+")


def paragraphs(document: str | None) -> str:
    """A docstring as help: without the line breaks of the source, which are those of its width."""
    found = cleandoc(document or "").split("\n\n")
    return "\n\n".join(" ".join(one.split()) for one in found)


@cache
def out() -> Console:
    """Console that writes to stdout."""
    return _console(stderr=False)


@cache
def err() -> Console:
    """Console that writes to stderr."""
    return _console(stderr=True)


def _console(stderr: bool) -> Console:
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.segment import Segment

    class Inert(Console):
        """A console on which text from outside gives no orders: no markup, no emoji by name, and
        escape sequences and the like are shown as �."""

        def render(
            self, renderable: RenderableType, options: ConsoleOptions | None = None
        ) -> Iterator[Segment]:
            for segment in super().render(renderable, options):
                yield segment if segment.control else segment._replace(text=legal(segment.text))

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else _WIDE
    return Inert(stderr=stderr, markup=False, emoji=False, highlight=False, width=width)


class Gone(Exception):
    """Raised when the reader of stdout, such as `head`, has closed it."""


class _Stream:
    """stdout, or stderr, with failures of writing handled: on stdout they raise an error that names
    the stream, on stderr they are ignored since nothing is left to report them to.

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
        """Forget what is still in the buffer, which would fail again when the interpreter ends."""
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._real.fileno())
            os.close(nowhere)


@contextmanager
def streams() -> Iterator[None]:
    """Context in which a stdout that is closed, full or no longer read is said so."""
    real = sys.stdout, sys.stderr
    sys.stdout = cast(TextIO, _Stream(real[0], "standard output"))
    sys.stderr = cast(TextIO, _Stream(real[1], ""))
    try:
        yield
    finally:
        sys.stdout, sys.stderr = real


def error(text: str) -> int:
    """Print an error as one red line; the exit code for bad input."""
    _line(f"error: {text}", "bold red")
    return 2


def warn(text: str) -> None:
    """Print a warning as one yellow line."""
    _line(text if "warning: " in text else f"warning: {text}", "yellow")


def _line(text: str, style: str) -> None:
    err().print(" ".join(text.split()), style=style, soft_wrap=True)


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
    """Context that prints freebody's warnings as yellow lines when its block ends, each once, and
    only the first of very many."""
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


def spelled(text: str, encoding: str) -> str:
    """The text as an encoding can hold it: characters that it lacks are spelled as in ASCII
    formulas, such as theta1 for θ₁.

    Windows redirects in an encoding of its own, and `PYTHONIOENCODING=ascii` is set in many a
    pipeline.
    """
    if _fits(text, encoding):
        return text
    text = _RATE.sub(lambda m: m[0] if _fits(m[0], encoding) else m[2] + _DOTS[m[1]], text)
    text = _POWER.sub(lambda m: m[0] if _fits(m[0], encoding) else "^" + _bare(m[0]), text)
    return "".join(c if _fits(c, encoding) else _letter(c) for c in text)


def _fits(text: str, encoding: str) -> bool:
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


def _letter(c: str) -> str:
    """A character in ASCII; one that has no such spelling by its number."""
    if c in _PLAIN:
        return _PLAIN[c]
    name = unicodedata.name(c, "")
    if name.startswith("BOX DRAWINGS"):
        return "-" if name.endswith(" HORIZONTAL") else "|" if name.endswith(" VERTICAL") else "+"
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", name)
    if greek:
        return greek[2].lower() if greek[1] == "SMALL" else greek[2].capitalize()
    return _bare(c) or c.encode("ascii", "backslashreplace").decode()


def _bare(text: str) -> str:
    """Text reduced to plain letters and digits, without accents or raised and lowered places: 2 for
    ₂, e for é, 1/2 for ½."""
    parts = unicodedata.normalize("NFKD", text).replace("\u2044", "/").replace("−", "-")
    return parts.encode("ascii", "ignore").decode()
