"""Symbols in sentences, s_ci, f_0,1, θ₁, τ_2, 2 ω × ḋ u, typeset as formulas where the medium
allows."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from freebody.expressions.typesetting import literal

_SYMBOL = re.compile(
    r"(?<![\w.])(-?)([A-Za-zα-ωΑ-Ω])_([A-Za-z0-9]+(?:,[A-Za-z0-9]+)?)"
    r"|(?<![\w.])([a-z])(?= [×·] [a-z](?!\w))|(?<=[a-z] [×·] )([a-z])(?!\w)"
)
"""A letter with a subscript, such as f_0,1; either factor of a product of vectors, a × b."""

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
    """How a medium typesets sentences: words, symbols (sign, letter, subscript or none, whether it
    is a vector), and other names."""

    words: Callable[[str], str]
    symbol: Callable[[str, str, str, bool], str]
    name: Callable[[str], str]
    vectors: frozenset[str] = frozenset("sfvruzn")
    """Letters that are vectors."""

    @property
    def planar(self) -> Medium:
        """The same medium for planar robots, where moments are scalars."""
        return replace(self, vectors=self.vectors - {"n"})

    def __call__(self, sentence: str) -> str:
        """A sentence typeset for the medium."""
        return literal.in_parts(sentence, self._set, self.name)

    def _set(self, words: str) -> str:
        string, end = "", 0
        for found in _SYMBOL.finditer(words):
            sign, letter, low, first, second = found.groups(default="")
            factor = first or second
            bold = bool(factor) or letter in self.vectors
            string += self.words(words[end : found.start()])
            string += self.symbol(sign, letter or factor, low, bold)
            end = found.end()
        return string + self.words(words[end:])


def _with_minus(words: str) -> str:
    return re.sub(r"(?<=[ (])-(?=[\w])", "−", words)


def _tex_symbol(sign: str, letter: str, low: str, bold: bool) -> str:
    name = f"\\mathbf{{{letter}}}" if bold else literal.GREEK_COMMANDS.get(letter, letter)
    return f"${sign}{name}{f'_{{{low}}}' if low else ''}$"


def _text_symbol(sign: str, letter: str, low: str, bold: bool) -> str:
    if re.fullmatch(r"\d|\d,\d", low):
        return sign.replace("-", "−") + letter + low.replace(",", "").translate(_LOW)
    return f"{sign}{letter}_{low}" if low else letter


def _web_symbol(sign: str, letter: str, low: str, bold: bool) -> str:
    mark, below = "b" if bold else "i", f"<sub>{low}</sub>" if low else ""
    return f"{sign.replace('-', '−')}<{mark}>{letter}</{mark}>{below}"


tex_prose = Medium(
    lambda words: "".join(_TEX.get(c, c) for c in _with_minus(words)), _tex_symbol, literal.tex
)
"""Setter of sentences in LaTeX."""

markdown_prose = Medium(str, _tex_symbol, literal.markdown)
"""A sentence in Markdown, symbols between dollar signs."""

text_prose = Medium(str, _text_symbol, literal.printable)
"""A sentence for a terminal: numbers as subscripts."""

web_prose = Medium(lambda words: html.escape(_with_minus(words)), _web_symbol, literal.web)
"""Setter of sentences in HTML."""


def cited(numbers: Sequence[str]) -> str:
    """Citation of equation numbers: `("3.16", "3.17", "4.1")` as (3.16), (3.17), (4.1); three or
    more consecutive ones as a range."""
    runs: list[list[str]] = []
    for number in sorted(dict.fromkeys(numbers), key=_place):
        if runs and _place(number) == _next(runs[-1][-1]):
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(part for run in runs for part in _run(run))


def _run(run: list[str]) -> list[str]:
    if len(run) < 3:
        return [f"({number})" for number in run]
    return [f"({run[0]})–({run[-1]})"]


def _place(number: str) -> tuple[int, ...]:
    return tuple(map(int, number.split(".")))


def _next(number: str) -> tuple[int, ...]:
    *chapter, last = _place(number)
    return (*chapter, last + 1)
