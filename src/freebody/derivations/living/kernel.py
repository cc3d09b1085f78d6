"""A JavaScript function of everything that a page shows: in, the symbols of the equations; out, the
values of names and lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from freebody import elementary
from freebody.derivations.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.derivations.expressions.expression import Expression, Function, Symbol
from freebody.derivations.expressions.nodes import nodes
from freebody.derivations.living.line_values import entries
from freebody.derivations.relations.quantities import Quantities
from freebody.program import Argument, trace
from freebody.program.passes import share_reciprocals
from freebody.targets.text import LANGUAGES, Unit

NAME = "live"
"""Of the function: y = live(x, y)."""

_FUNCTIONS = {"sin": elementary.sin, "cos": elementary.cos, "sgn": elementary.sign}


class PageProgram:
    """Values that are asked for one by one get places in its output y; then it has a source."""

    def __init__(self, quantities: Quantities):
        self._quantities = quantities
        self._places: dict[Expression, int] = {}

    def places(self, value: Any) -> list[int]:
        """Where in y the entries of a value will be; equal ones have one place."""
        form = self._quantities.form
        forms = [x if isinstance(x, Expression) else form(x) for x in entries(value)]
        return [self._places.setdefault(form, len(self._places)) for form in forms]

    @property
    def size(self) -> int:
        """Length of y."""
        return len(self._places)

    @property
    def used(self) -> frozenset[str]:
        """Names of the symbols that what was asked for depends on."""
        return frozenset(
            x.name for form in self._places for x in nodes(form) if isinstance(x, Symbol)
        )

    def numbers(self, inputs: Mapping[str, Any]) -> list[Any]:
        """y over any scalars, given each symbol's value by name."""
        rules = _rules(inputs)
        return [evaluate(form, rules) for form in self._places]

    def source(self, inputs: Sequence[str]) -> str:
        """A plain script with the function; x are the symbols `inputs` in this order."""

        def live(x: Sequence[Any]) -> dict[str, Any]:
            found = self.numbers(dict(zip(inputs, x, strict=True)))
            return {"y": np.array(found, dtype=object)}

        program = share_reciprocals(trace(NAME, live, (Argument("x", (len(inputs),)),), None))
        return LANGUAGES["javascript-script"].emit(Unit(program, NAME))


def _rules(inputs: Mapping[str, Any]) -> Rules:
    return {
        **arithmetic(lambda number: number.numerator / number.denominator),
        Symbol: lambda node, at: inputs[node.name],
        Function: lambda node, at: _FUNCTIONS[node.name](at(node.argument)),
    }
