"""Long equations in several lines, broken before a sign, in the outermost bracket there is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

BREAK = "\u2028"
"""Stands where a line may be broken, in place of the space before a sign."""


@dataclass
class _LinePart:
    text: str
    depth: int
    """Brackets that are open where the piece begins."""


def broken(string: str, width: float, measure: Callable[[str], float] = len) -> list[str]:
    """Lines of at most `width`, as far as the breaks allow; a line is left where the fewest
    brackets are open."""
    pieces, depth = [], 0
    for text in string.split(BREAK):
        pieces.append(_LinePart(text, depth))
        depth += text.count("(") - text.count(")")
    lines = []
    while pieces:
        size = _fitting(pieces, width, measure)
        lines.append(" ".join(piece.text for piece in pieces[:size]))
        pieces = pieces[size:]
    return lines


def _fitting(pieces: list[_LinePart], width: float, measure: Callable[[str], float]) -> int:
    """How many pieces go on the next line."""
    sizes = []
    total = 0.0
    for piece in pieces:
        total += measure(piece.text) + (1 if sizes else 0)
        sizes.append(total)
    if total <= width or len(pieces) == 1:
        return len(pieces)
    most = max(1, sum(size <= width for size in sizes))
    breaks = [k for k in range(1, most + 1) if k < len(pieces) and sizes[k - 1] > 0.35 * width] or [
        most
    ]
    shallow = min(pieces[k].depth for k in breaks)
    return max(k for k in breaks if pieces[k].depth == shallow)
