"""Symbols inside sentences: s_ci, f_0,1, θ₁, τ_2, 2 ω × ḋ u, set as formulas where the medium
can."""

from __future__ import annotations

import html
import re

from freebody.derivations.names import GREEK
from freebody.derivations.render import literal

_NAMES = {letter: "lambda" if name == "lam" else name for name, letter in GREEK.items()}

_SYMBOL = re.compile(r"(?<![\w.])(-?)([A-Za-zα-ωΑ-Ω])_([A-Za-z0-9]+(?:,[A-Za-z0-9]+)?)")
"""A letter with a subscript, such as f_0,1."""

_VECTORS = frozenset("sfvruzn")
"""Letters that are vectors in sentences."""

_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

_TEX = {
    **literal.TEX,
    **{chr(0x2080 + k): f"$_{{{k}}}$" for k in range(10)},
    "²": "$^2$",
    "·": r"$\cdot$",
    "×": r"$\times$",
    "ᵀ": r"$^{\mathsf T}$",
    "−": "$-$",
    "Σ": r"$\Sigma$",
    "δ": r"$\delta$",
    "ḋ": r"$\dot d$",
    "–": "--",
    "—": "---",
}


def tex_prose(words: str) -> str:
    """A sentence in LaTeX."""
    return literal.in_parts(words, _tex_words, literal.tex)


def _tex_words(words: str) -> str:
    parts, end = [], 0
    for match in _SYMBOL.finditer(words):
        parts += [_plain_tex(words[end : match.start()]), _tex_symbol(*match.groups())]
        end = match.end()
    return "".join([*parts, _plain_tex(words[end:])])


def _plain_tex(words: str) -> str:
    words = re.sub(r"(?<=[ (])-(?=[\w])", "−", words)
    return "".join(_TEX.get(c, c) for c in words)


def _tex_symbol(sign: str, letter: str, low: str) -> str:
    name = (
        f"\\{_NAMES[letter]}"
        if letter in _NAMES
        else f"\\mathbf{{{letter}}}"
        if letter in _VECTORS
        else letter
    )
    return f"${sign}{name}_{{{low}}}$"


def markdown_prose(words: str) -> str:
    """A sentence in Markdown, symbols between dollar signs."""
    return literal.in_parts(words, _markdown_words, literal.markdown)


def _markdown_words(words: str) -> str:
    return _SYMBOL.sub(lambda match: _tex_symbol(*match.groups()), words)


def text_prose(words: str) -> str:
    """A sentence for a terminal: numbers as subscripts."""
    return literal.in_parts(words, lambda part: _SYMBOL.sub(_text_symbol, part), literal.printable)


def _text_symbol(match: re.Match[str]) -> str:
    sign, letter, low = match.groups()
    if re.fullmatch(r"\d|\d,\d", low):
        return sign.replace("-", "−") + letter + low.replace(",", "").translate(_LOW)
    return match[0]


def web_prose(words: str) -> str:
    """A sentence in HTML."""
    return literal.in_parts(words, _web_words, literal.web)


def _web_words(words: str) -> str:
    parts, end = [], 0
    for match in _SYMBOL.finditer(words):
        parts += [_plain_web(words[end : match.start()]), _web_symbol(*match.groups())]
        end = match.end()
    return "".join([*parts, _plain_web(words[end:])])


def _plain_web(words: str) -> str:
    return html.escape(re.sub(r"(?<=[ (])-(?=[\w])", "−", words))


def _web_symbol(sign: str, letter: str, low: str) -> str:
    mark = "b" if letter in _VECTORS else "i"
    return f"{sign.replace('-', '−')}<{mark}>{letter}</{mark}><sub>{low}</sub>"
