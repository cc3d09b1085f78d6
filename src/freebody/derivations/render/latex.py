"""Expressions as LaTeX (amsmath)."""

from __future__ import annotations

import re
from fractions import Fraction

from freebody.derivations.expressions.expression import Expression, Number, Symbol
from freebody.derivations.expressions.printed_names import GREEK
from freebody.derivations.render.literal import tex, tex_math
from freebody.derivations.render.typesetter import BREAK, Typesetter, is_call

_GREEK = {letter: "\\lambda" if name == "lam" else f"\\{name}" for name, letter in GREEK.items()}
_DOTS = ("{}", "\\dot{{{}}}", "\\ddot{{{}}}")
_NAMES = {x: f"\\{x}" for x in ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "det", "exp",
                                "log")} | {
    "sgn": "\\operatorname{sgn}", "∑": "\\sum ",
}  # fmt: skip


def latex(node: Expression) -> str:
    """LaTeX of an expression, without dollar signs."""
    return _SETTER.whole(node)


def breakable(node: Expression) -> str:
    """The same with `BREAK` where a line may end."""
    return _SETTER(node)


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


def width(string: str) -> float:
    """About how wide a formula is, in letters."""
    total = 0.0
    for match in _PATTERN.finditer(string):
        total += _SIZES[(match.lastindex or 1) - 1][1]
        if match[0][0] in "_^":
            total += 0.66 * len(re.sub(r"\\mathrm|[{}_^]", "", match[0]))
    return total


class _Latex(Typesetter):
    minus, lead = f"{BREAK}- ", "-"
    cross, dot, tenfold = " \\times ", " \\cdot ", "\\cdot "
    differentials = "\\mathrm{d}", "\\partial "
    transposed, inverse_transposed = "^{\\mathsf{T}}", "^{-\\mathsf{T}}"

    def digits(self, digits: str) -> str:
        return digits

    def ratio(self, value: Fraction) -> str:
        sign = "-" if value < 0 else ""
        return f"{sign}\\tfrac{{{abs(value.numerator)}}}{{{value.denominator}}}"

    def symbol(self, node: Symbol, high: str = "") -> str:
        letter = _letter(node.letter, node.bold)
        if node.dots:
            letter = _DOTS[node.dots].format(letter)
        low = ",".join(
            f"\\mathrm{{{x}}}" if x.isalpha() and len(x) > 2 and x.isascii() else _low(x)
            for x in node.low
        )
        own = node.high.replace("−", "-").replace("′", "\\prime")
        return letter + _script("_", low.replace("−", "-")) + _script("^", own) + high

    def high(self, exponent: int) -> str:
        return _script("^", str(exponent))

    def gap(self, before: Expression, after: Expression) -> str:
        decimal = isinstance(before, Number) and before.value.denominator != 1
        return "\\," if is_call(before) or (decimal and not is_call(after)) else " "

    def function(self, name: str) -> str:
        return _NAMES.get(name, f"\\operatorname{{{name}}}")

    def tight(self, argument: str) -> str:
        return argument.replace(" + ", "+").replace(" - ", "-").replace("\\,", " ")

    def norm(self, argument: str) -> str:
        return f"\\left|{argument}\\right|"

    def fraction(self, above: str, below: str) -> str:
        return f"\\frac{{{above}}}{{{below}}}".replace(BREAK, " ")

    def operand(self, string: str) -> str:
        return f"\\left({string}\\right)"

    def array(self, rows: list[list[str]]) -> str:
        body = " \\\\ ".join(map(" & ".join, rows))
        return f"\\begin{{bmatrix}} {body} \\end{{bmatrix}}"

    def words(self, text: str) -> str:
        return f"\\text{{{tex(text)}}}"


def _script(mark: str, text: str) -> str:
    """A sub- or superscript, in braces where it is longer than a character."""
    return f"{mark}{text}" if len(text) == 1 else f"{mark}{{{text}}}" if text else ""


def _letter(letter: str, bold: bool) -> str:
    if letter in _GREEK:
        return f"\\boldsymbol{{{_GREEK[letter]}}}" if bold else _GREEK[letter]
    if bold:
        return f"\\mathbf{{{letter}}}"
    if len(letter) == 1 and letter.isascii() and letter.isalpha():
        return letter
    return f"\\mathrm{{{letter}}}" if letter.isalnum() and letter.isascii() else tex_math(letter)


def _low(text: str) -> str:
    """A subscript: indices such as i−1 are formulas, names are not."""
    return text if re.fullmatch(r"[A-Za-z0-9+−-]*", text) else tex_math(text)


_SETTER = _Latex()
