"""Coloured cells of a plane, and the key of their colours, as SVG."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from itertools import groupby

import numpy as np

from freebody.figures.drawing import Cells, ColourKey
from freebody.figures.svg_symbols import path, words

_SWATCH = 14.0
KEY = 46.0
"""Height of a key, pixels."""


def cells(e: Cells, at: Callable[[Sequence[float]], complex]) -> list[str]:
    """One path for each colour; neighbours in a row are one piece of it. at: pixels of a place."""
    corner, across, up = map(np.asarray, (e.corner, e.across, e.up))
    d: dict[int, list[str]] = {}
    for i, row in enumerate(e.colours):
        j = 0
        for colour, run in groupby(row):
            end = j + len(list(run))
            if colour >= 0:
                ends = ((i, j), (i, end), (i + 1, end), (i + 1, j))
                places = [at(tuple(corner + b * across + a * up)) for a, b in ends]
                d.setdefault(colour, []).append(path(places, closed=True))
            j = end
    return [f'<path class="m{colour}" d="{"".join(d[colour])}"/>' for colour in sorted(d)]


def key(shown: ColourKey, middle: complex, wide: float) -> list[str]:
    """The colours in a row, their numbers below, at the edges between two or under each."""
    count = len(shown.colours)
    step = min(wide / max(count, 1), 60.0)
    left = middle - count * step / 2
    out = [words("unit", middle - 4j, escape(shown.title), "middle")]
    for k, colour in enumerate(shown.colours):
        corner = left + k * step
        ends = [corner, corner + step, corner + step + _SWATCH * 1j, corner + _SWATCH * 1j]
        out.append(f'<path class="m{colour}" d="{path(ends, closed=True)}"/>')
    shift = 0.0 if shown.between else 0.5
    for k, text in enumerate(shown.texts):
        at = left + (k + shift) * step + (_SWATCH + 13.0) * 1j
        out.append(words("tick", at, escape(text), "middle"))
    return out
