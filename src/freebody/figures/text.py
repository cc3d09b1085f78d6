"""Text in drawings. A formula: `*f*_{0,1}` is a bold f with a subscript, `θ̈_1` an italic one,
`p^{i−1}_i` has both. A sentence: the same symbols among upright words.

Letters are italic, vectors (between stars) bold and upright, digits and signs upright, as in print.
Dots of time derivatives are full stops set above the letter: few fonts with serifs have them as
accents of any letter.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from itertools import groupby

from freebody.expressions import expression as ex

SIZE = 15.0
"""Height of the letters of formulas, pixels."""

_SMALL = 0.7
_DOTS = {"\u0307": ".", "\u0308": ".."}
_STOP = 0.25
"""Width of a full stop, in heights of a letter."""
_TALL = set("bdfhklβδθλ")
_TOKEN = re.compile(r"\*([^*]+)\*|([_^])(?:\{([^}]*)\}|(.[\u0300-\u036f]*))|([^*_^]+)")
_SYMBOL = re.compile(r"([^\W\d_]+)_(?:\{([^}]+)\}|(\w)(?!\w))")
_NARROW, _WIDE = set("iljtfrI.,:;'′|()[]! "), set("mwMWΣ@%")
_FONTS = {"serif": (0.36, 0.86, 0.56), "sans": (0.36, 0.9, 0.62)}
"""Widths of narrow, wide and other letters, in heights."""
_TAGS = {"v": "<i>{}</i>", "b": "<b>{}</b>", "r": "{}"}
_LEVELS = {1: "<sup>{}</sup>", 0: "{}", -1: "<sub>{}</sub>"}


@dataclass(frozen=True)
class Run:
    """Letters of one style in a formula; level 1 is raised, -1 lowered."""

    text: str
    style: str
    """v: italic, b: bold, r: upright, num: the number after a formula."""
    level: int = 0

    @property
    def width(self) -> float:
        """The approximate width of the run, in heights of a letter."""
        return width(self.text, 1.0, "serif") * (_SMALL if self.level else 1.0)


def label(name: ex.Expression) -> str:
    """A symbol as a formula: "f_{1,2}", "−τ_2", "θ̇_1"; "" for 0."""
    if isinstance(name, ex.Negative):
        return "−" + label(name.operand)
    if not isinstance(name, ex.Symbol):
        return ""
    dotted = name.letter + ("", *_DOTS)[name.dots]
    return indexed(unicodedata.normalize("NFC", dotted) + name.high, ",".join(name.low))


def indexed(symbol: str, low: str) -> str:
    """A symbol with its subscript, if that is not empty."""
    return f"{symbol}_{{{low}}}" if len(low) > 1 else f"{symbol}_{low}" if low else symbol


def bold(name: str) -> str:
    """The label of a vector: its letters bold, but not a sign in front, a subscript, or text in
    brackets."""
    sign, rest = (name[0], name[1:]) if name[:1] in ("−", "-") else ("", name)
    letters = re.split(r"[_^(]", rest, maxsplit=1)[0]
    return f"{sign}*{letters}*{rest[len(letters) :]}"


def canonical(name: str) -> str:
    """A name without braces around a single letter, its accents composed."""
    return re.sub(r"_\{(\w)\}", r"_\1", unicodedata.normalize("NFC", name))


def runs(formula: str) -> Iterator[Run]:
    """The runs of a formula: pieces that are set in one style and level."""
    for bold, mark, group, single, rest in _TOKEN.findall(formula):
        if bold:
            yield Run(bold, "b")
        elif mark:
            yield from _letters(group or single, 1 if mark == "^" else -1)
        else:
            yield from _letters(rest, 0)


def sentence(text: str) -> Iterator[Run]:
    """The runs of a sentence; letters in front of a subscript are a symbol."""
    pieces = _SYMBOL.split(text)
    yield Run(pieces[0], "r")
    for letters, group, single, words in zip(*(pieces[k::4] for k in (1, 2, 3, 4)), strict=True):
        yield from (Run(letters, "v"), *_joined(_letters(group or single, -1)), Run(words, "r"))


def _letters(text: str, level: int) -> Iterator[Run]:
    """Runs of a formula's letters, in italics with their dots, but for words of several letters
    that are raised or lowered."""
    dotted = r"[^\W\d_][\u0307\u0308]"
    pieces = rf"{dotted}|[^\W\d_]+(?![\u0307\u0308])|."
    for piece in re.findall(pieces, unicodedata.normalize("NFD", text)):
        alone = len(piece.rstrip("\u0307\u0308")) == 1
        yield Run(piece, "v" if piece[0].isalpha() and (alone or not level) else "r", level)


def marked(pieces: Iterable[Run], size: float = SIZE) -> str:
    """The runs as SVG tspans, with letters of `size` pixels; a subscript starts below its
    superscript's start."""
    parts, last, stacked = [], 0, 0.0
    for run in _joined(pieces):
        dx = f' dx="{-stacked:.2f}em"' if last > 0 and run.level < 0 and stacked else ""
        parts.append(_span(run, (_shift(run.level) - _shift(last)) * size, dx, size))
        stacked = stacked + 0.88 * run.width / _SMALL if run.level > 0 else 0.0
        last = run.level
    return "".join(parts)


def _joined(pieces: Iterable[Run]) -> Iterator[Run]:
    """Runs with neighbours of one style and level joined, except letters with dots."""
    for (style, level, dotted), alike in groupby(
        pieces, lambda run: (run.style, run.level, run.text[1:] in _DOTS)
    ):
        parts = list(alike)
        texts = [run.text for run in parts] if dotted else ["".join(run.text for run in parts)]
        yield from (Run(text, style, level) for text in texts)


def _shift(level: int) -> float:
    """The vertical offset of a level, in heights of a letter, positive downwards."""
    return -0.38 * level if level > 0 else -0.24 * level


def _span(run: Run, dy: float, dx: str, size: float) -> str:
    css = run.style + " l" * (run.level != 0)
    move = f' dy="{dy:.1f}"' if abs(dy) > 0.01 else ""
    dots = _DOTS.get(run.text[1:])
    if dots is None:
        return f'<tspan class="{css}"{dx}{move}>{escape(run.text)}</tspan>'
    # back to the middle of the letter, up, and forward again; italics lean to the right
    letter = run.text[0]
    back = (run.width + _STOP * len(dots)) / 2 - (0.06 if run.style == "v" else 0.0)
    rise = (0.72 if letter in _TALL or letter.isupper() else 0.52) * size
    return (
        f'<tspan class="{css}"{dx}{move}>{escape(letter)}</tspan>'
        f'<tspan class="{run.style} r" dx="{-back:.2f}em" dy="{-rise:.1f}">{dots}</tspan>'
        f'<tspan dx="{back - _STOP * len(dots):.2f}em" dy="{rise:.1f}">\u200b</tspan>'
    )


def html(formula: str) -> str:
    """A drawing's formula in HTML."""
    marks = ((run, _LEVELS[run.level].format(_TAGS[run.style])) for run in runs(formula))
    text = "".join(mark.format(escape(run.text)) for run, mark in marks)
    return unicodedata.normalize("NFC", text)


def plain(formula: str) -> str:
    """A formula without its marks, for tooltips, tables in a terminal and readers who cannot see
    the drawing."""
    return unicodedata.normalize("NFC", "".join(run.text for run in runs(formula)))


def width(text: str, size: float, font: str = "sans") -> float:
    """The approximate width of plain text in pixels."""
    narrow, wide, other = _FONTS[font]
    letters = (c for c in unicodedata.normalize("NFD", text) if not unicodedata.combining(c))
    return size * sum(narrow if c in _NARROW else wide if c in _WIDE else other for c in letters)


def formula_width(formula: str) -> float:
    """The approximate width of a formula in pixels; a subscript under a superscript takes no width
    of its own."""
    total = high = 0.0
    for run in runs(formula):
        if run.level > 0:
            high += run.width
        elif run.level < 0 and high:
            total, high = total + max(high, run.width), 0.0
        else:
            total, high = total + high + run.width, 0.0
    return (total + high) * SIZE
