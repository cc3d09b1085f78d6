"""Equations once more, in lines as long as a phone is wide."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from freebody.expressions.typesetting.mathml import lean
from freebody_textbook.render import page

if TYPE_CHECKING:
    from freebody_textbook.derivation import Step

LETTERS = 34.0
"""Of a line in a window of 400 px."""
LARGEST = 595_000
"""Bytes that a page may have with them."""


def short_lines(steps: Iterable[Step], room: int) -> dict[Step, str]:
    """Of each step whose equations are too long for a phone the same as HTML, in shorter lines and
    hidden where there is room for long ones; of the first steps only, if those of all take more
    than `room` bytes: the others are scrolled."""
    found: dict[Step, str] = {}
    for step in filter(lambda one: one.equations, steps):
        text = page.html([step.equations], LETTERS)
        if text == page.html([step.equations]):
            continue
        kind = "equations short" + " result" * step.result
        found[step] = f'<div class="{kind}">{text}</div>'
        room -= len(lean(found[step]).encode())
        if room < 0:
            del found[step]
            break
    return found
