"""The tables of the grammar as data for a page, whose script reads formulas by them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from typing import Any

from freebody.expressions.grammar import patterns
from freebody.expressions.grammar.tables import characters
from freebody.expressions.grammar.tables.classes import CLASSES, PATTERNS
from freebody.expressions.grammar.tables.spellings import SPELLINGS
from freebody_textbook.check.algebra.exact_polynomials import LARGEST_EXPONENT
from freebody_textbook.check.numbers.written_units import UNITS

_CHARACTERS = (
    "LETTERS", "LETTER_COMMANDS", "FONTS", "ACCENTS", "MARKS", "PRIMES", "STARS", "LOW", "HIGH",
    "OPERATORS", "BRACKETS", "VULGAR_FRACTIONS", "FRACTIONS", "FUNCTION_COMMANDS", "RECIPROCALS",
    "MATRICES", "SILENT_COMMANDS", "SILENT", "SIGNS", "KINDS_OF_SIGNS", "ANY_MARK",
)  # fmt: skip
_MENTIONED = re.compile(r"[%@](?:not_)?(\w+)")
_ASKED = ("@number", "%name", "@at_rest", "@condition")
"""What the script itself asks for: numbers, names, and what it leaves to `fb.check`."""


@cache
def tables() -> dict[str, Any]:
    """What a page's reader reads by: characters and commands, spellings, and of classes and parts
    of patterns those that these name."""
    spellings = [row[:2] for row in SPELLINGS]
    used = _used([*_ASKED, *(find for find, _ in spellings)])
    return {
        **{name: getattr(characters, name) for name in _CHARACTERS},
        "SPELLINGS": spellings,
        "PATTERNS": {name: x for name, x in PATTERNS.items() if name in used},
        "CLASSES": {name: _shorter(x) for name, x in CLASSES.items() if name in used},
        "ITEM": patterns.ITEM.pattern.replace("?P<", "?<"),
        "LARGEST_EXPONENT": LARGEST_EXPONENT,
        "UNITS": UNITS,
    }


def _shorter(texts: tuple[str, ...]) -> str | tuple[str, ...]:
    """Single characters as one text."""
    return "".join(texts) if all(len(x) == 1 for x in texts) else texts


def _used(texts: Iterable[str]) -> set[str]:
    """Names of classes and patterns that patterns mention, and what these do."""
    found: set[str] = set()
    waiting = [name for text in texts for name in _MENTIONED.findall(text)]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            parts = [PATTERNS.get(name, ""), *(x for x in CLASSES.get(name, ()) if x[0] == "%")]
            waiting += [x for part in parts for x in _MENTIONED.findall(part)]
    return found
