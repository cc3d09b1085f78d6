"""Text in figures: subscripts, and how wide text will be."""

from __future__ import annotations

import re
from html import escape

_SYMBOL = re.compile(r"([^\W\d_]*)_(?:\{([^}]+)\}|(\w))")
"""Letters and their subscript."""
_NARROW, _WIDE = set("iljtfrI.,:;'|()[]! "), set("mwMWΣ@%")


def plain(text: str) -> str:
    """Without subscript marks, for titles and tooltips."""
    return _set(text, "{}{}")


def marked(text: str) -> str:
    """SVG tspans: symbols before a subscript in italics, subscripts lowered, the rest upright."""
    low = '<tspan dy="3.5" font-size="75%">{}</tspan><tspan dy="-3.5">\u200a</tspan>'
    return _set(escape(text), f'<tspan class="v">{{}}</tspan>{low}')


def html(text: str) -> str:
    """The same in HTML."""
    return _set(escape(text), "<i>{}</i><sub>{}</sub>")


def _set(text: str, form: str) -> str:
    """A text, its symbols and their subscripts in a form."""
    return _SYMBOL.sub(lambda m: form.format(m[1], m[2] or m[3]), text)


def width(text: str, size: float) -> float:
    """About how wide a text without subscripts is, pixels."""
    return size * sum(0.36 if c in _NARROW else 0.9 if c in _WIDE else 0.62 for c in text)
