"""Expressions as one line of text for a terminal: τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² …"""

from __future__ import annotations

from fractions import Fraction
from unicodedata import normalize

from freebody.expressions.nodes import Symbol
from freebody.expressions.typesetting.typesetter import Notation, Typesetter
from freebody.outputs.number_text import signed, superscript

_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_HIGH = str.maketrans("-0123456789T", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹ᵀ")
_DOTS = ("", "\u0307", "\u0308")
_VULGAR = {
    (1, 2): "½", (1, 4): "¼", (3, 4): "¾", (1, 8): "⅛", (3, 8): "⅜", (1, 3): "⅓", (2, 3): "⅔",
}  # fmt: skip


def _ratio(value: Fraction) -> str:
    return _VULGAR.get((value.numerator, value.denominator), signed(str(value)))


def _symbol(node: Symbol, high: str) -> str:
    letter = node.letter[0] + _DOTS[node.dots] + node.letter[1:]
    return normalize("NFC", letter) + _low(node.low) + _raised(node.high) + high


def _raised(high: str) -> str:
    """A superscript as text: raised digits, or other characters behind a ^."""
    return f"^{high}" if high and high != "T" and high[0].isalpha() else high.translate(_HIGH)


def _low(parts: tuple[str, ...]) -> str:
    if any("−" in part for part in parts):
        return f"_{{{','.join(parts)}}}"  # a link's number such as i−1
    word = "_" if parts and parts[0].replace(",", "").isalpha() else ""
    numbers = any(len(part) > 1 and part.isdigit() for part in parts) or any(
        "," in part for part in parts
    )
    # 1,c2 needs a comma, c2x and 1xx do not
    apart = numbers or any(part[0].isalpha() and part[-1].isdigit() for part in parts[1:])
    return word + ("," if apart else "").join(parts).translate(_LOW)


TEXT = Typesetter(
    Notation(
        digits=signed,
        ratio=_ratio,
        symbol=_symbol,
        exponent=superscript,
        tight=lambda argument: argument.replace(" ", ""),
        bar=False,
        brackets_before_factors=True,
        column=("[{}]ᵀ", ", ", ""),
    )
)
"""Notation of text for a terminal."""
