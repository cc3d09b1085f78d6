"""What the font that pages bring for their formulas has."""

from __future__ import annotations

import html
import re
from functools import cache
from importlib import resources

from support.extras import extra

_INVISIBLE = {"\n", "\u2061", "\u2062"}
_ITALICS = {"A": 0x1D434, "a": 0x1D44E, "Α": 0x1D6E2, "α": 0x1D6FC}
"""Of letters of these alphabets the first, and its italics."""


@cache
def _characters() -> frozenset[str]:
    extra("brotli")
    reader = extra("fontTools.ttLib", "fonttools")
    font = resources.files("freebody.outputs").joinpath("fonts/formulas.woff2")
    with resources.as_file(font) as path:
        return frozenset(map(chr, reader.TTFont(path).getBestCmap()))


def _italic(letter: str) -> str:
    """What browsers set for a letter that is alone in an <mi>."""
    if letter == "h":
        return "ℎ"
    first = max((x for x in _ITALICS if x <= letter), default="")
    place = ord(letter) - ord(first or letter)
    return chr(_ITALICS[first] + place) if first and place < 26 else letter


def lacking(page: str) -> set[str]:
    """The characters of a page's formulas that browsers would take from another font."""
    formulas = "".join(re.findall(r"<math.*?</math>", page, re.DOTALL))
    alone = {html.unescape(x) for x in re.findall(r"<mi(?: [^>]*bold[^>]*)?>(\w)</mi>", formulas)}
    shown = set(html.unescape(re.sub(r"<[^>]*>", "", formulas))) | set(map(_italic, alone))
    return shown - _INVISIBLE - _characters()
