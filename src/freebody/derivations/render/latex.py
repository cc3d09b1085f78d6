"""Expressions as LaTeX (amsmath)."""

from __future__ import annotations

import re

from freebody.derivations.expression import (
    Arguments,
    Cross,
    Derivative,
    Dot,
    Equation,
    Expression,
    Function,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    Transposed,
    Vector,
    Words,
)
from freebody.derivations.names import GREEK
from freebody.derivations.render.literal import tex, tex_math
from freebody.derivations.render.rules import (
    ATOM,
    BREAK,
    CALL,
    PRODUCT,
    SUM,
    Renderer,
    digits,
    precedence,
    summed,
    whole,
)

_GREEK = {letter: "\\lambda" if name == "lam" else f"\\{name}" for name, letter in GREEK.items()}
_DOTS = ("{}", "\\dot{{{}}}", "\\ddot{{{}}}")
_NAMES = {x: f"\\{x}" for x in ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "det", "exp", "log")} | {
    "sgn": "\\operatorname{sgn}", "∑": "\\sum ",
}  # fmt: skip


def latex(node: Expression) -> str:
    """LaTeX of an expression, without dollar signs."""
    return whole(_RENDER(node))


def breakable(node: Expression) -> str:
    """The same with `BREAK` where a line may end."""
    return _RENDER(node)


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


def _number(node: Number, _: Renderer) -> str:
    value = node.value
    if value.denominator == 1 and not (node.decimal and abs(value) >= 10**6):
        return str(value)
    if not node.decimal:
        sign = "-" if value < 0 else ""
        return f"{sign}\\tfrac{{{abs(value.numerator)}}}{{{value.denominator}}}"
    mantissa, exponent = digits(value)
    return mantissa + (f"\\cdot 10^{{{exponent}}}" if exponent else "")


def _symbol(node: Symbol, _: Renderer) -> str:
    letter = _letter(node.letter, node.bold)
    if node.dots:
        letter = _DOTS[node.dots].format(letter)
    low = ",".join(
        f"\\mathrm{{{x}}}" if x.isalpha() and len(x) > 2 and x.isascii() else _low(x)
        for x in node.low
    )
    low, high = low.replace("−", "-"), node.high.replace("−", "-").replace("′", "\\prime")
    return letter + _script("_", low) + _script("^", high)


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


def _product(node: Product, render: Renderer) -> str:
    pieces = ""
    for k, factor in enumerate(node.factors):
        before = node.factors[k - 1] if k else None
        apart = before is not None and (
            _is_call(before) or (_is_decimal(before) and not _is_call(factor))
        )
        gap = "\\," if apart else " "
        pieces += (gap if k else "") + _factor(factor, render)
    return pieces


def _factor(factor: Expression, render: Renderer) -> str:
    level = (
        SUM
        if isinstance(factor, Number)
        else CALL
        if isinstance(factor, Cross | Dot | Product)
        else PRODUCT
    )
    return render(factor, level)


def _is_decimal(node: Expression) -> bool:
    return isinstance(node, Number) and node.value.denominator != 1


def _is_call(node: Expression) -> bool:
    return isinstance(node, Function) or (
        isinstance(node, Power) and isinstance(node.base, Function)
    )


def _call(node: Function, exponent: str, render: Renderer) -> str:
    argument = (
        whole(render(node.argument)).replace(" + ", "+").replace(" - ", "-").replace("\\,", " ")
    )
    name = _NAMES.get(node.name, f"\\operatorname{{{node.name}}}") + exponent
    if node.name == "norm":
        return f"\\left|{render(node.argument)}\\right|"
    if isinstance(node.argument, Arguments):
        return f"{name}({render(node.argument)})"
    if precedence(node.argument) < PRODUCT or node.name == "sgn":
        return f"{name}({argument})"
    return f"{name} {argument}"


def _power(node: Power, render: Renderer) -> str:
    if isinstance(node.base, Function):
        return _call(node.base, _script("^", str(node.exponent)), render)
    if isinstance(node.base, Transposed) and node.exponent == -1:
        return render(node.base.operand, ATOM) + "^{-\\mathsf{T}}"
    return render(node.base, ATOM) + _script("^", str(node.exponent))


def _derivative(node: Derivative, render: Renderer) -> str:
    d = "\\partial " if node.partial else "\\mathrm{d}"
    below = d + render(node.by, ATOM)
    if isinstance(node.of, Symbol):
        return f"\\frac{{{d}{render(node.of)}}}{{{below}}}"
    return f"\\frac{{{d.strip()}}}{{{below}}}\\left({whole(render(node.of))}\\right)"


def _pair(node: Cross | Dot, sign: str, render: Renderer) -> str:
    def side(x: Expression) -> str:
        return render(x, CALL if isinstance(x, Cross | Dot) else PRODUCT)

    return f"{side(node.left)} {sign} {side(node.right)}"


def _array(rows: list[str]) -> str:
    return "\\begin{bmatrix} " + " \\\\ ".join(rows) + " \\end{bmatrix}"


_RENDER = Renderer(
    {
        Number: _number,
        Symbol: _symbol,
        Sum: lambda node, render: summed(node, render, f"{BREAK}+ ", f"{BREAK}- ", "-"),
        Negative: lambda node, render: "-" + render(node.operand, PRODUCT),
        Product: _product,
        Quotient: lambda node, render: (
            f"\\frac{{{whole(render(node.above))}}}{{{whole(render(node.below))}}}"
        ),
        Power: _power,
        Transposed: lambda node, render: render(node.operand, ATOM) + "^{\\mathsf{T}}",
        Function: lambda node, render: _call(node, "", render),
        Derivative: _derivative,
        Cross: lambda node, render: _pair(node, "\\times", render),
        Dot: lambda node, render: _pair(node, "\\cdot", render),
        Arguments: lambda node, render: ", ".join(render(x, SUM) for x in node.entries),
        Vector: lambda node, render: _array([whole(render(x)) for x in node.entries]),
        Matrix: lambda node, render: _array(
            [" & ".join(whole(render(x)) for x in row) for row in node.rows]
        ),
        Equation: lambda node, render: " = ".join(render(side, SUM) for side in node.sides),
        Words: lambda node, render: f"\\text{{{tex(node.text)}}}",
    }
)
