"""Inverse functions that are often mixed up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from freebody.expressions.nodes import Arguments, Expression, Function, nodes


def swapped(node: Expression) -> Iterator[tuple[str, Expression, Expression]]:
    """Changes of a tree's functions: a sentence, what is written, what should be."""
    for part in nodes(node):
        if not isinstance(part, Function):
            continue
        match part.name, part.argument:
            case "atan2", Arguments(entries=(y, x)):
                turned = replace(part.argument, entries=(x, y))
                text = "atan2 takes the sine's part first: atan2(y, x)."
                yield text, part, replace(part, argument=turned)
            case "arccos", _:
                yield "It is the arcsine of that.", part, replace(part, name="arcsin")
            case "arcsin", _:
                yield "It is the arccosine of that.", part, replace(part, name="arccos")
