"""Numbers as text for people: significant digits, a real minus sign, powers of ten."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import combinations

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_ALL = 17
"""Digits that tell any two floats apart."""
_LIMIT_SLACK = 1e-9
"""Relative: a share of a limit that is beyond it by no more is at it."""
_UNLIMITED = 1e6
"""Hours, a century."""
SMALLEST, LARGEST = -3, 5
"""Powers of ten from which and below which a number has no exponent."""


def significant(value: float, digits: int = 3) -> str:
    """A number with `digits` significant digits, trailing zeros included, and a power of ten where
    it is very small or large; a dash for NaN."""
    if not math.isfinite(value):
        return "–" if math.isnan(value) else "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    size = decade(value)
    if SMALLEST <= size < LARGEST:
        return fixed(value, max(digits - 1 - size, 0))
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{signed(mantissa)}·10{superscript(int(exponent))}"


def shortest(value: float, digits: int = 6) -> str:
    """A number with at most `digits` significant digits and no trailing zeros."""
    mantissa, exponent = mantissa_and_exponent(value, digits)
    return signed(mantissa) + (f"·10{superscript(exponent)}" if exponent else "")


def compared(
    *values: float, digits: int = 4, holds: Callable[..., bool] | None = None
) -> tuple[str, ...]:
    """Numbers that a message compares, in the form in which one types them: with at most `digits`
    digits, and more where different numbers would look equal or in another order.

    holds: says of the printed numbers whether what the message states of them is true.
    """
    texts: tuple[str, ...] = ()
    for count in range(digits, _ALL + 1):
        texts = tuple(f"{x:.{count}g}" for x in values)
        read = tuple(map(float, texts))
        told = zip(combinations(values, 2), combinations(read, 2), strict=True)
        same = all((a == b) == (x == y) for (a, b), (x, y) in told)
        if same and (holds is None or holds(*read)):
            break
    return texts


def rounded_down(value: float, digits: int = 3) -> str:
    """A number of at least 0 in the form in which one types it, with at most `digits` digits and
    rounded down, for what can be promised."""
    if value == 0.0:
        return "0"
    scale = 10.0 ** (digits - 1 - math.floor(math.log10(value)))
    return f"{math.floor(value * scale * (1 + 1e-12)) / scale:.{digits}g}"


def rounded_up(value: float, digits: int = 4) -> str:
    """A positive number in the form in which one types it, with at most `digits` digits and rounded
    up, for least values that a user has to give."""
    text = f"{value:.{digits}g}"
    if float(text) >= value:
        return text
    return f"{value + 0.5 * 10.0 ** (decade(value) - digits + 1):.{digits}g}"


def percent(share: float) -> str:
    """A fraction as a percentage that is not rounded across the limit: 100.4 % does not become 100
    %."""
    decimals = 0 if not _LIMIT_SLACK < abs(share - 1.0) < 0.01 else 2
    while share > 1.0 + _LIMIT_SLACK and float(f"{100 * share:.{decimals}f}") <= 100.0:
        decimals += 1
    return f"{100 * share:.{decimals}f} %"


def lifetime(hours: float) -> str:
    """A life with three digits, rounded down; beyond a million hours no law of wear was measured,
    and no machine runs."""
    if hours > _UNLIMITED:
        return f"practically unlimited (beyond {_UNLIMITED:.0e} h)".replace("e+0", "e")
    digits = rounded_down(hours)
    return f"{float(digits):.0f} h" if hours >= 100.0 else f"{digits} h"


def fixed(value: float, decimals: int) -> str:
    """A number with a fixed number of decimals."""
    return signed(f"{value:.{decimals}f}")


def mantissa_and_exponent(value: float, digits: int) -> tuple[str, int]:
    """The digits, at most `digits`, and the power of ten (0: none) with which a number prints;
    numbers below 10¹⁰ print all digits before the point."""
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    if exponent and 0 < int(exponent) < 10:
        return f"{value:.0f}", 0
    return mantissa, int(exponent or 0)


def decade(value: float) -> int:
    """The power of ten of a number's first digit."""
    return math.floor(math.log10(abs(value)))


def signed(digits: str) -> str:
    """Digits with a real minus sign."""
    return digits.replace("-", "−")


def superscript(exponent: int) -> str:
    """An exponent in raised digits."""
    return str(exponent).translate(_RAISED)


def weighted_sum(terms: Iterable[tuple[str, float]], digits: int) -> str:
    """A sum of names with weights as text, such as vx + 0.309 vy - 2 w."""
    text = ""
    for name, weight in terms:
        size = f"{abs(weight):.{digits}g}"
        sign = (" - " if weight < 0.0 else " + ") if text else ("-" if weight < 0.0 else "")
        text += f"{sign}{'' if size == '1' else f'{size} '}{name}"
    return text
