"""Expressions as LaTeX (amsmath)."""

from __future__ import annotations

import re
from fractions import Fraction

from freebody.expressions.nodes import Expression, Number, Symbol
from freebody.expressions.typesetting.literal import GREEK_COMMANDS, tex, tex_math
from freebody.expressions.typesetting.typesetter import BREAK, Notation, Typesetter, is_call

_DOTS = ("{}", "\\dot{{{}}}", "\\ddot{{{}}}")
_NAMES = {x: f"\\{x}" for x in ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "det", "exp",
                                "log")} | {
    "sgn": "\\operatorname{sgn}", "∑": "\\sum ",
}  # fmt: skip


_SIZES = (
    (r"\\tfrac\{\d+\}\{\d+\}", 0.9),
    (r"[_^](?:\{(?:[^{}]|\\mathrm\{\w*\})*\}|.)", 0.0),
    (r"\\(?:sin|cos|operatorname\{sgn\})", 2.8),
    (r"\\(?:,|d?dot|mathbf|boldsymbol|mathrm)", 0.2),
    (r"\\[A-Za-z]+|[A-Za-z]", 1.0),
    (r"[+=-]", 1.7),
    (r"[()]", 0.7),
    (r"\d", 0.9),
    (r"\.", 0.3),
)
"""Patterns and their width, measured with TeX; scripts count apart."""

_PATTERN = re.compile("|".join(f"({pattern})" for pattern, _ in _SIZES))


def width_of(string: str) -> float:
    """The approximate width of a LaTeX formula, in letters."""
    total = 0.0
    for match in _PATTERN.finditer(string):
        total += _SIZES[(match.lastindex or 1) - 1][1]
        if match[0][0] in "_^":
            total += 0.66 * len(re.sub(r"\\mathrm|[{}_^]", "", match[0]))
    return total


def _ratio(value: Fraction) -> str:
    sign = "-" if value < 0 else ""
    return f"{sign}\\tfrac{{{abs(value.numerator)}}}{{{value.denominator}}}"


def _symbol(node: Symbol, high: str) -> str:
    low = ",".join(
        f"\\mathrm{{{x}}}" if x.isalpha() and len(x) > 2 and x.isascii() else _low(x)
        for x in node.low
    )
    own = node.high.replace("−", "-").replace("′", "\\prime")
    letter = _DOTS[node.dots].format(_letter(node.letter, node.bold))
    return letter + _script("_", low.replace("−", "-")) + _script("^", own) + high


def _gap(before: Expression, after: Expression) -> str:
    decimal = isinstance(before, Number) and before.value.denominator != 1
    return "\\," if is_call(before) or (decimal and not is_call(after)) else " "


def _script(mark: str, text: str) -> str:
    """A sub- or superscript with its mark, in braces where it is longer than one character."""
    return f"{mark}{text}" if len(text) == 1 else f"{mark}{{{text}}}" if text else ""


def _letter(letter: str, bold: bool) -> str:
    if letter in GREEK_COMMANDS:
        return f"\\boldsymbol{{{GREEK_COMMANDS[letter]}}}" if bold else GREEK_COMMANDS[letter]
    if bold:
        return f"\\mathbf{{{letter}}}"
    if len(letter) == 1 and letter.isascii() and letter.isalpha():
        return letter
    return f"\\mathrm{{{letter}}}" if letter.isalnum() and letter.isascii() else tex_math(letter)


def _low(text: str) -> str:
    """A LaTeX subscript: indices such as i−1 as a formula, other text escaped."""
    return text if re.fullmatch(r"[A-Za-z0-9+−-]*", text) else tex_math(text)


LATEX = Typesetter(
    Notation(
        ratio=_ratio,
        symbol=_symbol,
        exponent=lambda exponent: _script("^", str(exponent)),
        gap=_gap,
        function=lambda name: _NAMES.get(name, f"\\operatorname{{{name}}}"),
        tight=lambda x: x.replace(" + ", "+").replace(" - ", "-").replace("\\,", " "),
        words=lambda text: f"\\text{{{tex(text)}}}",
        minus=f"{BREAK}- ",
        lead="-",
        cross=" \\times ",
        dot=" \\cdot ",
        tenfold="\\cdot ",
        colon=":\\quad ",
        differentials=("\\mathrm{d}", "\\partial "),
        transposed="^{\\mathsf{T}}",
        inverse_transposed="^{-\\mathsf{T}}",
        norm="\\left|{}\\right|",
        root="\\sqrt{{{}}}",
        fraction="\\frac{{{}}}{{{}}}",
        operand="\\left({}\\right)",
        width=width_of,
        matrix=("\\begin{{bmatrix}} {} \\end{{bmatrix}}", " \\\\ ", " & "),
    )
)
"""LaTeX, without dollar signs."""
