"""Text of others inside freebody's output: characters that no page or drawing may hold, cells that
no spreadsheet may run."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import numpy as np

_UNSEEN = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ufffe\uffff\ud800-\udfff"  # no XML, or no character
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]"  # turn the direction of what follows
)
_RUN = re.compile(r"'*[=+\-@\t\r\n＝＋－＠]")
_QUOTED = re.compile("""[",;\t\r\n]|^ | $""")


def legal(text: str) -> str:
    """The text for a page or drawing, with � for characters that are not well-formed there or turn
    the direction of writing.

    A name keeps such characters wherever it is data; what is shown must not change what stands
    beside it.
    """
    return _UNSEEN.sub("\ufffd", text)


def encodable(text: str) -> str:
    """The text with ? for halves of surrogate pairs, which file names outside UTF-8 have and no
    file can hold."""
    return text.encode("utf-8", "replace").decode("utf-8")


def harmless(cell: str) -> str:
    """A cell that spreadsheets take as text: one that begins like a formula gets an apostrophe in
    front."""
    return f"'{cell}" if _RUN.match(cell) else cell


def as_meant(cell: str) -> str:
    """A cell's text without the apostrophe that `harmless` may have put in front."""
    return cell[1:] if cell.startswith("'") and _RUN.match(cell) else cell


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Rows as CSV text: texts made harmless, floats to the last bit and empty for NaN, truth values
    as yes and no."""
    listed = (row.tolist() if isinstance(row, np.ndarray) else row for row in rows)
    return "".join(",".join(map(_cell, row)) + "\r\n" for row in listed)


def _cell(value: Any) -> str:
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, str):
        text = harmless(value)
        # apart also where a spreadsheet separates cells by semicolons
        return '"' + text.replace('"', '""') + '"' if _QUOTED.search(text) else text
    if isinstance(value, int):
        return ("no", "yes")[value] if isinstance(value, bool) else str(value)
    number = float(value)
    return "" if number != number else repr(number)
