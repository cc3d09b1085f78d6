"""Symbols inside sentences: s_ci, f_0,1, θ₁, τ_2, 2 ω × ḋ u, set as formulas where the medium
can."""

from __future__ import annotations

import html
import re
from collections.abc import Callable
from dataclasses import dataclass, replace

from freebody.expressions.typesetting import literal

_SYMBOL = re.compile(r"(?<![\w.])(-?)([A-Za-zα-ωΑ-Ω])_([A-Za-z0-9]+(?:,[A-Za-z0-9]+)?)")
"""A letter with a subscript, such as f_0,1."""

_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

_TEX = {
    **literal.TEX,
    "²": "$^2$",
    "·": r"$\cdot$",
    "×": r"$\times$",
    "ᵀ": r"$^{\mathsf T}$",
    "Σ": r"$\Sigma$",
    "δ": r"$\delta$",
    "ḋ": r"$\dot d$",
}


@dataclass(frozen=True)
class Medium:
    """How a sentence is set: its words, its symbols (sign, letter, subscript, whether it is a
    vector), names of others."""

    words: Callable[[str], str]
    symbol: Callable[[str, str, str, bool], str]
    name: Callable[[str], str]
    vectors: frozenset[str] = frozenset("sfvruzn")
    """Letters that are vectors."""

    @property
    def planar(self) -> Medium:
        """The same where moments are scalars."""
        return replace(self, vectors=self.vectors - {"n"})

    def __call__(self, sentence: str) -> str:
        """The sentence set."""
        return literal.in_parts(sentence, self._set, self.name)

    def _set(self, words: str) -> str:
        pieces = _SYMBOL.split(words)
        string = self.words(pieces[0])
        for k in range(1, len(pieces), 4):
            sign, letter, low, words = pieces[k : k + 4]
            string += self.symbol(sign, letter, low, letter in self.vectors) + self.words(words)
        return string


def _with_minus(words: str) -> str:
    return re.sub(r"(?<=[ (])-(?=[\w])", "−", words)


def _tex_symbol(sign: str, letter: str, low: str, bold: bool) -> str:
    name = f"\\mathbf{{{letter}}}" if bold else literal.GREEK_COMMANDS.get(letter, letter)
    return f"${sign}{name}_{{{low}}}$"


def _text_symbol(sign: str, letter: str, low: str, bold: bool) -> str:
    if re.fullmatch(r"\d|\d,\d", low):
        return sign.replace("-", "−") + letter + low.replace(",", "").translate(_LOW)
    return f"{sign}{letter}_{low}"


def _web_symbol(sign: str, letter: str, low: str, bold: bool) -> str:
    mark = "b" if bold else "i"
    return f"{sign.replace('-', '−')}<{mark}>{letter}</{mark}><sub>{low}</sub>"


tex_prose = Medium(
    lambda words: "".join(_TEX.get(c, c) for c in _with_minus(words)), _tex_symbol, literal.tex
)
"""A sentence in LaTeX."""

markdown_prose = Medium(str, _tex_symbol, literal.markdown)
"""A sentence in Markdown, symbols between dollar signs."""

text_prose = Medium(str, _text_symbol, literal.printable)
"""A sentence for a terminal: numbers as subscripts."""

web_prose = Medium(lambda words: html.escape(_with_minus(words)), _web_symbol, literal.web)
"""A sentence in HTML."""
