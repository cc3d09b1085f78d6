"""Text in figures: subscripts, and how wide text will be."""

from __future__ import annotations

import re
from html import escape

_SUBSCRIPT = re.compile(r"_(?:\{([^}]*)\}|(\w))")
_NARROW, _WIDE = set("iljtfrI.,:;'|()[]! "), set("mwMWΣ@%")


def plain(text: str) -> str:
    """Without subscript marks, for titles and tooltips."""
    return _SUBSCRIPT.sub(lambda m: m.group(1) or m.group(2), text)


def marked(text: str) -> str:
    """SVG tspans: symbols before a subscript in italics, subscripts lowered, the rest upright."""
    parts, at = [], 0
    for match in _SUBSCRIPT.finditer(text):
        before = text[at : match.start()]
        upright, symbol = _split_symbol(before)
        low = escape(match.group(1) or match.group(2))
        parts.append(
            f'{escape(upright)}<tspan class="v">{escape(symbol)}</tspan>'
            f'<tspan dy="3.5" font-size="75%">{low}</tspan><tspan dy="-3.5">\u200a</tspan>'
        )
        at = match.end()
    return "".join(parts) + escape(text[at:])


def html(text: str) -> str:
    """The same in HTML."""
    parts, at = [], 0
    for match in _SUBSCRIPT.finditer(text):
        upright, symbol = _split_symbol(text[at : match.start()])
        low = escape(match.group(1) or match.group(2))
        parts.append(f"{escape(upright)}<i>{escape(symbol)}</i><sub>{low}</sub>")
        at = match.end()
    return "".join(parts) + escape(text[at:])


def _split_symbol(before: str) -> tuple[str, str]:
    """What precedes the symbol, and the symbol: the letters that end the text."""
    start = len(before)
    while start and before[start - 1].isalpha():
        start -= 1
    return before[:start], before[start:]


def width(text: str, size: float = 13.0) -> float:
    """About how wide a text is, pixels."""
    total = 0.0
    for match in re.finditer(r"_\{([^}]*)\}|_(\w)|(.)", text):
        sub = match.group(1) or match.group(2)
        total += 0.75 * _plain_width(sub) if sub else _plain_width(match.group(3))
    return total * size


def _plain_width(text: str) -> float:
    return sum(0.36 if c in _NARROW else 0.9 if c in _WIDE else 0.62 for c in text)
