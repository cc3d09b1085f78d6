"""Expressions as MathML, for a page that fetches no script."""

from __future__ import annotations

import re
from xml.sax.saxutils import escape

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
    nodes,
)
from freebody.derivations.render.lines import broken
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
)

_OPEN, _CLOSE = '<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>'
_THIN, _APPLY, _TIMES = '<mspace width="0.17em"/>', "<mo>&#x2061;</mo>", "<mo>&#x2062;</mo>"
_DOTS = ("", "˙", "¨")
_PLUS, _MINUS = f'{BREAK}<mo form="infix">+</mo>', f'{BREAK}<mo form="infix">−</mo>'
_TAGS = re.compile(r"<[^>]*>|&[^;]*;|[˙¨]")


def mathml(node: Expression, display: bool = True) -> str:
    """A `<math>` element, set as a line of its own unless `display` is false."""
    kind = ' display="block"' if display else ""
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML"{kind}>{row(node)}</math>'


def row(node: Expression) -> str:
    """The inside of a `<math>` element."""
    return f"<mrow>{_RENDER(node).replace(BREAK, '')}</mrow>"


def broken_rows(node: Expression, room: float) -> list[str]:
    """The same in lines of about `room` letters, broken before signs, in brackets only where it
    must be."""
    pieces: list[str] = []
    for piece in _RENDER(node).split(BREAK):
        # a break inside an element, such as a root or an exponent, is none
        if pieces and _opened(pieces[-1]):
            pieces[-1] += piece
        else:
            pieces.append(piece)
    return [f"<mrow>{line}</mrow>" for line in broken(BREAK.join(pieces), room, _width)]


def _opened(string: str) -> bool:
    """Whether an element that begins here does not end here."""
    return len(re.findall(r"<[a-z]", string)) - string.count("/>") > string.count("</")


def _width(string: str) -> float:
    """About how wide it is, in letters; scripts are smaller, elements take no room."""
    full = len(_TAGS.sub("", string))
    scripts = sum(
        len(_TAGS.sub("", s)) for s in re.findall(r"(?:</mi>|</mover>)<mrow>(.*?)</mrow>", string)
    )
    return 0.85 * (full - 0.4 * scripts) + 0.8 * string.count('form="infix"')


def _number(node: Number, _: Renderer) -> str:
    value = node.value
    if value.denominator == 1 and not (node.decimal and abs(value) >= 10**6):
        return f"<mn>{value}</mn>"
    if not node.decimal:
        fraction = f"<mfrac><mn>{value.numerator}</mn><mn>{value.denominator}</mn></mfrac>"
        return f'<mstyle displaystyle="false">{fraction}</mstyle>'
    mantissa, exponent = digits(value)
    if not exponent:
        return f"<mn>{mantissa}</mn>"
    return f"<mn>{mantissa}</mn><mo>·</mo><msup><mn>10</mn><mn>{exponent}</mn></msup>".replace(
        ">-", ">−"
    )


def _symbol(node: Symbol, render: Renderer, exponent: str = "") -> str:
    bold = ' mathvariant="bold" style="font-weight:bold;font-style:normal"' if node.bold else ""
    upright = ' mathvariant="normal"' if len(node.letter) > 1 and not bold else bold
    letter = f"<mi{upright}>{escape(node.letter)}</mi>"
    if node.dots:
        letter = f'<mover accent="true">{letter}<mo>{_DOTS[node.dots]}</mo></mover>'
    low = f"<mrow>{_low(node.low)}</mrow>" if node.low else ""
    high = exponent or (f"<mi>{escape(node.high)}</mi>" if node.high else "")
    if low and high:
        return f"<msubsup>{letter}{low}{high}</msubsup>"
    return (
        f"<msub>{letter}{low}</msub>" if low else f"<msup>{letter}{high}</msup>" if high else letter
    )


def _low(parts: tuple[str, ...]) -> str:
    return "<mo>,</mo>".join(map(_letters, parts))


def _letters(part: str) -> str:
    """Digits as numbers, letters in italics, words upright."""
    runs = re.findall(r"\d+|[^\W\d_]{3,}|.", part)
    return "".join(
        f"<mn>{run}</mn>" if run.isdigit() else f"<mi>{escape(run)}</mi>" for run in runs
    )


def _product(node: Product, render: Renderer) -> str:
    pieces = ""
    for k, factor in enumerate(node.factors):
        before = node.factors[k - 1] if k else None
        gap = _THIN if before is not None and (_is_call(before) or _is_call(factor)) else _TIMES
        level = (
            SUM
            if isinstance(factor, Number)
            else CALL
            if isinstance(factor, Cross | Dot | Product)
            else PRODUCT
        )
        pieces += (gap if k else "") + render(factor, level)
    return pieces


def _is_call(node: Expression) -> bool:
    return isinstance(node, Function) or (
        isinstance(node, Power) and isinstance(node.base, Function)
    )


def _call(node: Function, exponent: str, render: Renderer) -> str:
    name = f"<mi>{node.name}</mi>"
    if node.name == "norm":
        return f"<mrow><mo>|</mo>{render(node.argument)}<mo>|</mo></mrow>"
    if isinstance(node.argument, Arguments):
        return f"<mrow>{name}{_APPLY}{_OPEN}{render(node.argument)}{_CLOSE}</mrow>"
    if exponent:
        name = f"<msup>{name}<mn>{exponent}</mn></msup>"
    argument = render(node.argument)
    if precedence(node.argument) < PRODUCT or node.name == "sgn":
        argument = _OPEN + argument + _CLOSE
        return f"<mrow>{name}{_APPLY}{argument}</mrow>"
    return f"<mrow>{name}{_APPLY}{_THIN}{argument}</mrow>"


def _power(node: Power, render: Renderer) -> str:
    exponent = str(node.exponent).replace("-", "−")
    if isinstance(node.base, Function):
        return _call(node.base, exponent, render)
    if isinstance(node.base, Symbol) and not node.base.high:
        return _symbol(node.base, render, f"<mn>{exponent}</mn>")
    if isinstance(node.base, Transposed) and node.exponent == -1:
        return f"<msup><mrow>{render(node.base.operand, ATOM)}</mrow><mrow><mo>−</mo><mi>T</mi></mrow></msup>"
    if precedence(node.base) < ATOM and any(
        isinstance(part, Quotient) for part in nodes(node.base)
    ):
        # as tall as it
        return (
            f"<msup><mrow><mo>(</mo>{render(node.base)}<mo>)</mo></mrow><mn>{exponent}</mn></msup>"
        )
    return f"<msup><mrow>{render(node.base, ATOM)}</mrow><mn>{exponent}</mn></msup>"


def _derivative(node: Derivative, render: Renderer) -> str:
    d = "<mo>∂</mo>" if node.partial else '<mi mathvariant="normal">d</mi>'
    below = f"<mrow>{d}{render(node.by, ATOM)}</mrow>"
    if isinstance(node.of, Symbol):
        return f"<mfrac><mrow>{d}{render(node.of)}</mrow>{below}</mfrac>"
    return (
        f"<mfrac><mrow>{d}</mrow>{below}</mfrac><mrow><mo>(</mo>{render(node.of)}<mo>)</mo></mrow>"
    )


def _pair(node: Cross | Dot, sign: str, render: Renderer) -> str:
    def side(x: Expression) -> str:
        return render(x, CALL if isinstance(x, Cross | Dot) else PRODUCT)

    return f"{side(node.left)}<mo>{sign}</mo>{side(node.right)}"


def _array(rows: list[list[str]]) -> str:
    cells = "".join(
        f"<mtr>{''.join(f'<mtd>{cell}</mtd>' for cell in cells)}</mtr>" for cells in rows
    )
    return f"<mrow><mo>[</mo><mtable>{cells}</mtable><mo>]</mo></mrow>"


_RENDER = Renderer(
    {
        Number: _number,
        Symbol: _symbol,
        Sum: lambda node, render: summed(node, render, _PLUS, _MINUS, "<mo>−</mo>"),
        Negative: lambda node, render: "<mo>−</mo>" + render(node.operand, PRODUCT),
        Product: _product,
        Quotient: lambda node, render: (
            f"<mfrac>{_group(node.above, render)}{_group(node.below, render)}</mfrac>"
        ),
        Power: _power,
        Transposed: lambda node, render: (
            f"<msup><mrow>{render(node.operand, ATOM)}</mrow><mi>T</mi></msup>"
        ),
        Function: lambda node, render: _call(node, "", render),
        Derivative: _derivative,
        Cross: lambda node, render: _pair(node, "×", render),
        Dot: lambda node, render: _pair(node, "·", render),
        Arguments: lambda node, render: "<mo>,</mo>".join(render(x, SUM) for x in node.entries),
        Vector: lambda node, render: _array([[render(x)] for x in node.entries]),
        Matrix: lambda node, render: _array(
            [[render(x) for x in entries] for entries in node.rows]
        ),
        Equation: lambda node, render: "<mo>=</mo>".join(render(side, SUM) for side in node.sides),
        Words: lambda node, render: f"<mtext>{escape(node.text)}</mtext>",
    },
    (_OPEN, _CLOSE),
)


def _group(node: Expression, render: Renderer) -> str:
    return f"<mrow>{render(node)}</mrow>"
