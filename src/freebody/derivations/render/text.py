"""Expressions as one line of text for a terminal: τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² …"""

from __future__ import annotations

from unicodedata import normalize

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
from freebody.derivations.render.rules import (
    ATOM,
    BREAK,
    CALL,
    POWER,
    PRODUCT,
    SUM,
    Renderer,
    digits,
    precedence,
    summed,
    whole,
)

_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_HIGH = str.maketrans("-0123456789T", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹ᵀ")
_DOTS = ("", "\u0307", "\u0308")
_VULGAR = {
    (1, 2): "½",
    (1, 4): "¼",
    (3, 4): "¾",
    (1, 8): "⅛",
    (3, 8): "⅜",
    (1, 3): "⅓",
    (2, 3): "⅔",
}


def text(node: Expression) -> str:
    """One line of text."""
    return whole(_RENDER(node))


def breakable(node: Expression) -> str:
    """The same with `BREAK` where a line may end."""
    return _RENDER(node)


def _number(node: Number, _: Renderer) -> str:
    value = node.value
    if value.denominator == 1 and not (node.decimal and abs(value) >= 10**6):
        return str(value).replace("-", "−")
    if not node.decimal:
        return _VULGAR.get((value.numerator, value.denominator), str(value).replace("-", "−"))
    mantissa, exponent = digits(value)
    power = f"·10{str(exponent).translate(_HIGH)}" if exponent else ""
    return (mantissa + power).replace("-", "−")


def _symbol(node: Symbol, _: Renderer) -> str:
    letter = node.letter[0] + _DOTS[node.dots] + node.letter[1:]
    return normalize("NFC", letter) + _low(node.low) + _raised(node.high)


def _raised(high: str) -> str:
    """A superscript: digits as such, letters behind a ^."""
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


def _product(node: Product, render: Renderer) -> str:
    pieces = []
    for k, factor in enumerate(node.factors):
        after = node.factors[k + 1] if k + 1 < len(node.factors) else None
        if _is_call(factor) and after is not None and not _is_call(after):
            pieces.append(_bracketed(factor, render))
        else:
            pieces.append(_factor(factor, render))
    return " ".join(pieces)


def _factor(factor: Expression, render: Renderer) -> str:
    if isinstance(factor, Number):
        return render(factor, ATOM) if precedence(factor) < PRODUCT else render(factor)
    return render(factor, CALL if isinstance(factor, Cross | Dot | Product) else PRODUCT)


def _is_call(node: Expression) -> bool:
    return isinstance(node, Function) or (
        isinstance(node, Power) and isinstance(node.base, Function)
    )


def _call(node: Function, exponent: str, bracket: bool, render: Renderer) -> str:
    if node.name == "norm":
        return f"|{whole(render(node.argument))}|"
    if isinstance(node.argument, Arguments):
        return f"{node.name}({render(node.argument)})"
    argument = whole(render(node.argument)).replace(" ", "")
    if bracket or precedence(node.argument) < PRODUCT or node.name == "sgn":
        return f"{node.name}{exponent}({argument})"
    return f"{node.name}{exponent} {argument}"


def _bracketed(node: Expression, render: Renderer) -> str:
    """A function before a factor that could be read as its argument."""
    return _power(node, render, True) if isinstance(node, Power) else _call(node, "", True, render)  # type: ignore[arg-type]


def _power(node: Power, render: Renderer, bracket: bool = False) -> str:
    exponent = str(node.exponent).translate(_HIGH)
    if isinstance(node.base, Function):
        return _call(node.base, exponent, bracket, render)
    if isinstance(node.base, Transposed) and node.exponent == -1:
        return render(node.base.operand, ATOM) + "⁻ᵀ"
    return render(node.base, ATOM) + exponent


def _derivative(node: Derivative, render: Renderer) -> str:
    d, by = ("∂", "∂") if node.partial else ("d", "d")
    below = by + render(node.by, ATOM)
    if isinstance(node.of, Symbol):
        return f"{d}{render(node.of)}/{below}"
    return f"{d}/{below} ({whole(render(node.of))})"


def _pair(node: Cross | Dot, sign: str, render: Renderer) -> str:
    def side(x: Expression) -> str:
        return render(x, CALL if isinstance(x, Cross | Dot) else PRODUCT)

    return f"{side(node.left)} {sign} {side(node.right)}"


_RENDER = Renderer(
    {
        Number: _number,
        Symbol: _symbol,
        Sum: lambda node, render: summed(node, render, f"{BREAK}+ ", f"{BREAK}− ", "−"),
        Negative: lambda node, render: "−" + render(node.operand, PRODUCT),
        Product: _product,
        Quotient: lambda node, render: f"{render(node.above, CALL)}/{render(node.below, POWER)}",
        Power: _power,
        Transposed: lambda node, render: render(node.operand, ATOM) + "ᵀ",
        Function: lambda node, render: _call(node, "", False, render),
        Derivative: _derivative,
        Cross: lambda node, render: _pair(node, "×", render),
        Dot: lambda node, render: _pair(node, "·", render),
        Arguments: lambda node, render: ", ".join(whole(render(x, SUM)) for x in node.entries),
        Vector: lambda node, render: (
            "[" + ", ".join(whole(render(x, SUM)) for x in node.entries) + "]ᵀ"
        ),
        Matrix: lambda node, render: (
            "[" + "; ".join(", ".join(whole(render(x)) for x in row) for row in node.rows) + "]"
        ),
        Equation: lambda node, render: " = ".join(render(side, SUM) for side in node.sides),
        Words: lambda node, render: node.text,
    }
)
