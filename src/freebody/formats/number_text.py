"""The one reader of numbers in text that comes from outside: files, tables, the command line.

Python's own `float` also takes 1_0, digits of other scripts and blanks around; here a number is
what C would print.
"""

from __future__ import annotations

import math
import re

from freebody.model.parameters import LARGEST

DECIMAL = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
"""A decimal number, as a regular expression for ASCII text. No two parts of it can share digits:
100 000 digits that are no number would else be divided in as many ways, each tried to its end."""
NOT_FINITE = "not a finite number"
_NUMBER = re.compile(rf"{DECIMAL}|[+-]?inf(?:inity)?|nan", re.ASCII | re.IGNORECASE)


def number(text: str) -> float | None:
    """The number that a text is, perhaps infinite or NaN; None for any other text."""
    return float(text) if _NUMBER.fullmatch(text) else None


def fault(value: float, infinite: bool = False) -> str | None:
    """What a number is that cannot be used, or None. infinite: for bounds, which may be as large as
    they like."""
    if math.isnan(value) or (math.isinf(value) and not infinite):
        return NOT_FINITE
    if abs(value) > LARGEST and not infinite:
        return f"beyond {LARGEST:g}, more than any quantity of a robot"
    return None
