"""Text for an output that cannot hold all of its letters: theta1 for θ₁, as formulas are typed in
ASCII.

Windows redirects in an encoding of its own, and `PYTHONIOENCODING=ascii` is set in many a pipeline.
"""

from __future__ import annotations

import re
import unicodedata

_PLAIN = {
    "−": "-", "–": "-", "—": "-", "·": "*", "⋅": "*", "•": "*", "×": "x", "…": "...", "‘": "'",
    "’": "'", "“": '"', "”": '"', "′": "'", "→": "->", "←": "<-", "↔": "<->", "⇒": "=>", "⇔": "<=>",
    "≈": "~", "≠": "!=", "≤": "<=", "≥": ">=", "±": "+-", "√": "sqrt ", "∞": "inf", "∂": "d",
    "∫": "int ", "°": " deg", "∈": "in", "∥": "||", "λ": "lambda", "Λ": "Lambda", "⊥": "_|_",
    "✓": "ok", "⎡": "[", "⎢": "[", "⎣": "[", "⎤": "]", "⎥": "]", "⎦": "]",
}  # fmt: skip
_DOTS = {"\u0307": "_d", "\u0308": "_dd"}
"""Rates, as names are typed: theta1_d."""
_SUB = "".join(
    c for c in map(chr, range(0x1D62, 0x209D)) if unicodedata.decomposition(c).startswith("<sub>")
)
_SUPER = "²³¹" + "".join(
    c for c in map(chr, range(0x1D2C, 0x2080)) if unicodedata.decomposition(c).startswith("<super>")
)
_RATE = re.compile(f"([{''.join(_DOTS)}])([a-z]*[{_SUB}]*)")
_POWER = re.compile(f"[{_SUPER}]+")


def spelled(text: str, encoding: str) -> str:
    """The text, what the encoding lacks written in letters that it has."""
    if _fits(text, encoding):
        return text
    text = _RATE.sub(lambda m: m[0] if _fits(m[0], encoding) else m[2] + _DOTS[m[1]], text)
    text = _POWER.sub(lambda m: m[0] if _fits(m[0], encoding) else "^" + _bare(m[0]), text)
    return "".join(c if _fits(c, encoding) else _letter(c) for c in text)


def _fits(text: str, encoding: str) -> bool:
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


def _letter(c: str) -> str:
    """One character in ASCII; one that has no such spelling by its number."""
    if c in _PLAIN:
        return _PLAIN[c]
    name = unicodedata.name(c, "")
    if name.startswith("BOX DRAWINGS"):
        return "-" if name.endswith(" HORIZONTAL") else "|" if name.endswith(" VERTICAL") else "+"
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", name)
    if greek:
        return greek[2].lower() if greek[1] == "SMALL" else greek[2].capitalize()
    return _bare(c) or c.encode("ascii", "backslashreplace").decode()


def _bare(text: str) -> str:
    """Digits and letters without their place or accents: 2 for ₂, e for é, 1/2 for ½."""
    parts = unicodedata.normalize("NFKD", text).replace("\u2044", "/").replace("−", "-")
    return parts.encode("ascii", "ignore").decode()
