"""Formulas in figures: `*f*_{0,1}` is a bold f with a subscript, `θ̈_1` an italic one, `p^{i−1}_i`
has both.

Letters are italic, vectors (between stars) bold and upright, digits and signs upright, as in print.
Dots of time derivatives are full stops set above the letter: few fonts with serifs have them as
accents of any letter.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape

SIZE = 15.0
"""Height of the letters, pixels."""

_SMALL = 0.7
_DOTS = {"\u0307": ".", "\u0308": ".."}
_STOP = 0.25
"""Width of a full stop, in heights of a letter."""
_TALL = set("bdfhklβδθλ")
_TOKEN = re.compile(r"\*([^*]+)\*|([_^])(?:\{([^}]*)\}|(.[\u0300-\u036f]*))|([^*_^]+)")
_NARROW, _WIDE = set("iljtfrI.,:;'′|()[]! "), set("mwMWΣ@%")


@dataclass(frozen=True)
class Run:
    """Letters of one style; level 1 is raised, -1 lowered."""

    text: str
    style: str
    """v: italic, b: bold, r: upright."""
    level: int = 0

    @property
    def width(self) -> float:
        """About how wide, in heights of a letter."""
        letters = (
            c for c in unicodedata.normalize("NFD", self.text) if not unicodedata.combining(c)
        )
        total = sum(0.36 if c in _NARROW else 0.86 if c in _WIDE else 0.56 for c in letters)
        return total * (_SMALL if self.level else 1.0)


def runs(text: str) -> Iterator[Run]:
    """The pieces of a formula."""
    for bold, mark, group, single, rest in _TOKEN.findall(text):
        if bold:
            yield Run(bold, "b")
        elif mark:
            yield from _letters(group or single, 1 if mark == "^" else -1)
        else:
            yield from _letters(rest, 0)


def _letters(text: str, level: int) -> Iterator[Run]:
    """Letters in italics, with their dots; of what is raised or lowered only indices and axes."""
    dotted = r"[^\W\d_][\u0307\u0308]"
    pieces = rf"{dotted}|[^\W\d_]+(?![\u0307\u0308])|." if level == 0 else rf"{dotted}|."
    for piece in re.findall(pieces, unicodedata.normalize("NFD", text)):
        italic = piece[0].isalpha() and (level == 0 or piece in "inxyz")
        yield Run(piece, "v" if italic else "r", level)


def marked(text: str) -> str:
    """SVG tspans; a subscript under a superscript starts where that started."""
    parts, last, stacked = [], 0, 0.0
    for run in runs(text):
        dx = f' dx="{-stacked:.2f}em"' if last > 0 and run.level < 0 and stacked else ""
        size = f' font-size="{100 * _SMALL:.0f}%"' if run.level else ""
        parts.append(_span(run, (_shift(run.level) - _shift(last)) * SIZE, dx, size))
        stacked = stacked + 0.88 * run.width / _SMALL if run.level > 0 else 0.0
        last = run.level
    return "".join(parts)


def _shift(level: int) -> float:
    """How far a level stands below the line, in heights of a letter."""
    return -0.38 * level if level > 0 else -0.24 * level


def _span(run: Run, dy: float, dx: str, size: str) -> str:
    move = f' dy="{dy:.1f}"' if abs(dy) > 0.01 else ""
    letter, dots = run.text[0], _DOTS.get(run.text[1:])
    if dots is None:
        return f'<tspan class="{run.style}"{dx}{move}{size}>{escape(run.text)}</tspan>'
    # back to the middle of the letter, up, and forward again; italics lean to the right
    back = (run.width + _STOP * len(dots)) / 2 - (0.06 if run.style == "v" else 0.0)
    rise = (0.72 if letter in _TALL or letter.isupper() else 0.52) * SIZE
    return (
        f'<tspan class="{run.style}"{dx}{move}{size}>{escape(letter)}</tspan>'
        f'<tspan class="{run.style} r" dx="{-back:.2f}em" dy="{-rise:.1f}">{dots}</tspan>'
        f'<tspan dx="{back - _STOP * len(dots):.2f}em" dy="{rise:.1f}">\u200b</tspan>'
    )


def width(text: str, size: float = SIZE) -> float:
    """About how wide a formula is, pixels; what stands under a superscript counts once."""
    total = high = 0.0
    for run in runs(text):
        if run.level > 0:
            high += run.width
        elif run.level < 0 and high:
            total, high = total + max(high, run.width), 0.0
        else:
            total, high = total + high + run.width, 0.0
    return (total + high) * size


def plain(text: str) -> str:
    """Without marks, for tooltips and for those who cannot see it."""
    return "".join(run.text for run in runs(text))
