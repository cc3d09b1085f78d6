"""What Python and C share: operators, brackets, whole powers as products, numbers with all their
digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar

from freebody.expressions.nodes import Expression, Function, Number, Power
from freebody.expressions.typesetting.typesetter import (
    ATOM,
    CALL,
    EQUATION,
    PRODUCT,
    Notation,
    Typesetter,
)


def code(
    name: Callable[[str], str],
    functions: Mapping[str, str],
    variables: Mapping[Function, str] | None = None,
) -> Callable[[Expression], str]:
    """A renderer to infix code: `name` spells a symbol, `functions` sin, cos and sgn.

    `variables` names those sines and cosines that stand in a variable.
    """
    return _Code(name, functions, variables or {})


class _Code(Typesetter):
    fraction_levels = PRODUCT, EQUATION

    def __init__(
        self,
        name: Callable[[str], str],
        functions: Mapping[str, str],
        variables: Mapping[Function, str],
    ):
        super().__init__(
            Notation(
                symbol=lambda node, high: name(node.name),
                gap=lambda before, after: "*",
                plus=" + ",
                minus=" - ",
                lead="-",
                fraction="{}/({})",
                bar=False,
            )
        )
        self.functions, self.variables = functions, variables

    def _number(self, node: Number) -> str:
        return repr(node.value.numerator / node.value.denominator)

    def _call(self, node: Function) -> str:
        known = self.variables.get(node)
        return known or f"{self.functions[node.name]}({self(node.argument)})"

    def _power(self, node: Power) -> str:
        base = self(node.base, CALL if isinstance(node.base, Function) else ATOM)
        product = "*".join([base] * abs(node.exponent))
        return product if node.exponent > 0 else f"1.0/({product})"

    _rules: ClassVar = {**Typesetter._rules, Number: _number, Function: _call, Power: _power}
