"""What Python and C share: operators, brackets, whole powers as products, numbers with all their
digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from freebody.derivations.expression import (
    Expression,
    Function,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
)
from freebody.derivations.render.rules import ATOM, PRODUCT, Renderer, precedence, summed, whole


def code(
    name: Callable[[str], str],
    functions: Mapping[str, str],
    variables: Mapping[Function, str] | None = None,
) -> Callable[[Expression], str]:
    """A renderer to infix code: `name` spells a symbol, `functions` sin, cos and sgn.

    `variables` names those sines and cosines that stand in a variable.
    """
    known = variables or {}

    def function(node: Function, render: Renderer) -> str:
        return known[node] if node in known else f"{functions[node.name]}({render(node.argument)})"

    def number(node: Number, _: Renderer) -> str:
        value = node.value.numerator / node.value.denominator
        return repr(float(value))

    def product(node: Product, render: Renderer) -> str:
        return "*".join(_factor(factor, render) for factor in node.factors)

    def power(node: Power, render: Renderer) -> str:
        base = render(node.base, ATOM - 2 if isinstance(node.base, Function) else ATOM)
        product = "*".join([base] * abs(node.exponent))
        return product if node.exponent > 0 else f"1.0/({product})"

    renderer = Renderer(
        {
            Number: number,
            Symbol: lambda node, render: name(node.name),
            Sum: lambda node, render: summed(node, render, " + ", " - ", "-"),
            Negative: lambda node, render: "-" + render(node.operand, PRODUCT),
            Product: product,
            Quotient: lambda node, render: f"{render(node.above, PRODUCT)}/({render(node.below)})",
            Power: power,
            Function: function,
        }
    )
    return lambda node: whole(renderer(node))


def _factor(factor: Expression, render: Renderer) -> str:
    return render(factor) if precedence(factor) >= PRODUCT else render(factor, PRODUCT)
