"""Equations set into lines, whatever the notation: chains one sign below the other, wide arrays by
their entries."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from freebody.expressions.expression import Equation, Expression, Matrix, Symbol, Vector, eq

Measure = Callable[[Expression], float]

SIGN = 4.2
"""Width of an equals sign and of the indent behind it, in letters."""


@dataclass(frozen=True)
class Row:
    """left = right; a chain goes on where left is None."""

    left: Expression | None
    right: Expression


def rows(group: Iterable[Equation], width: float, measure: Measure) -> tuple[list[Row], float]:
    """The lines of a group of equations, and the room that their right sides have beside the widest
    left one."""
    turned = (turned_round(equation, width, measure) for equation in group)
    lines = [line for equation in turned for line in unfolded(equation, width, measure)]
    heads = [_head(line) for line in lines]
    room = width - SIGN - max((measure(head) for head, _ in heads), default=0.0)
    return [row for head, rest in heads for row in _chain(head, rest, room, measure)], room


def turned_round(equation: Equation, width: float, measure: Measure) -> Equation:
    """The equation; a = b as b = a where a is too wide for a line, as only the right side is
    broken."""
    left, *others = equation.sides
    sizes = [measure(side) for side in others]
    if len(others) > 1 or sizes[0] > width / 4 or measure(left) + SIGN + sizes[0] <= width:
        return equation
    return eq(others[0], left)


def unfolded(equation: Equation, width: float, measure: Measure) -> list[Equation]:
    """The equation; one whose last side is an array too wide for a line by the array's entries
    instead."""
    *before, last = equation.sides
    name = before[0]
    if not isinstance(last, Vector | Matrix) or not isinstance(name, Symbol):
        return [equation]
    if measure(last) + measure(name) + SIGN <= width:
        return [equation]
    return [*([Equation(tuple(before))] if len(before) > 1 else []), *_entries(name, last)]


def _entries(name: Symbol, array: Vector | Matrix) -> list[Equation]:
    if isinstance(array, Matrix):
        return [
            eq(part(name, place(i, j)), x)
            for i, row in enumerate(array.rows, 1)
            for j, x in enumerate(row, 1)
        ]
    labels = "xyz" if len(array.entries) <= 3 else map(str, range(1, len(array.entries) + 1))
    return [eq(part(name, label), x) for label, x in zip(labels, array.entries, strict=False)]


def place(i: int, j: int) -> str:
    """Row and column of an entry in one subscript: 12, above 9 with a comma, 4,11."""
    return f"{i}{j}" if max(i, j) < 10 else f"{i},{j}"


def part(name: Symbol, label: str) -> Symbol:
    """The symbol of an entry of an array: v of c2 becomes v of c2, x."""
    return Symbol(
        f"{name.name}_{label}",
        name.letter,
        (*name.low, *label.split(",")),
        name.dots,
        high=name.high,
    )


def left_side(equation: Equation) -> Expression:
    """What stands left of the sign at which equations are aligned."""
    return _head(equation)[0]


def _head(equation: Equation) -> tuple[Expression, tuple[Expression, ...]]:
    """What stands left of the sign that is aligned, and the sides right of it: names come first."""
    names = 1
    while names < len(equation.sides) - 1 and isinstance(equation.sides[names], Symbol):
        names += 1
    left = equation.sides[:names]
    return (left[0] if names == 1 else Equation(left)), equation.sides[names:]


def _chain(
    head: Expression, rest: tuple[Expression, ...], room: float, measure: Measure
) -> list[Row]:
    """One line if it fits, else a line a side."""
    joined = rest[0] if len(rest) == 1 else Equation(rest)
    if len(rest) == 1 or sum(map(measure, rest)) + SIGN * (len(rest) - 1) <= room:
        return [Row(head, joined)]
    return [Row(head if k == 0 else None, side) for k, side in enumerate(rest)]
