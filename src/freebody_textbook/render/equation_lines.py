"""Groups of equations as text, LaTeX and MathML lines: chains with aligned signs, wide arrays by
their entries."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, groupby

from freebody.expressions.expression import eq
from freebody.expressions.nodes import (
    Derivative,
    Equation,
    Expression,
    Matrix,
    Quotient,
    Sum,
    Symbol,
    Vector,
    nodes,
)
from freebody.expressions.printed_names import component, place
from freebody.expressions.typesetting.latex import LATEX, width_of
from freebody.expressions.typesetting.mathml import MATHML, NAMESPACE
from freebody.expressions.typesetting.text import TEXT
from freebody.expressions.typesetting.typesetter import Typesetter
from freebody_textbook.render.styles import ROWS

_RIGHT = "text-align:right;text-align:-webkit-right;padding-right:0"
_LEFT = "text-align:left;text-align:-webkit-left;padding-left:0"
STYLE = f".aligned>mtr>mtd:first-child{{{_RIGHT}}}.aligned>mtr>mtd:last-child{{{_LEFT}}}{ROWS}"
"""A page with equations of `html` needs it: their rows say nothing of how they are aligned."""

EquationGroups = Sequence[Sequence[Equation]]

WIDE = 0.25
"""The part of a line from which on a left side is wide."""
_NOTHING = "<mi></mi>"
"""A sign that stands alone would have no space beside it."""
TALL = 24
"""About the rows of a table where there are many: a printed page breaks between tables."""


_WidthOf = Callable[[Expression], float]


_SIGN = 4.2
"""Width of an equals sign and of the indent behind it, in letters."""


# ---------------------------------------------------------------- text
def text(groups: EquationGroups, width: int = 100) -> str:
    """Equations as text, one per line with long ones broken; an empty line between groups."""
    return "\n\n".join("\n".join(_text_group(group, width)) for group in groups)


def _text_group(group: Sequence[Equation], width: int) -> list[str]:
    lines, indent = [], 0
    for row in _rows(group, width, _letters)[0]:
        head = " " * indent if row.left is None else TEXT.line(row.left)
        indent = len(head)
        first, *rest = TEXT.lines(row.right, width - indent - 3)
        lines += [f"{head} = {first}", *(" " * min(indent + 3, 12) + line for line in rest)]
    return lines


def _letters(node: Expression) -> float:
    return len(TEXT.line(node))


# ---------------------------------------------------------------- formulas
def _lines(
    group: Sequence[_Row], room: float, setter: Typesetter
) -> Iterator[tuple[str, str, bool]]:
    """Texts left and right of the sign, line by line, and whether a line continues the previous
    one."""
    for row in group:
        left = "" if row.left is None else setter.line(row.left)
        fits = _span(row.right) <= room
        parts = [setter.line(row.right)] if fits else setter.lines(row.right, room)
        yield from ((left, part, k > 0) for k, part in enumerate(parts))


def _set(
    groups: EquationGroups, width: float, setter: Typesetter
) -> list[list[tuple[str, str, bool]]]:
    """The lines of each group of equations; all groups have the same line width."""
    found = [_rows(group, width, _span) for group in groups]
    room = min((room for _, room in found), default=width)
    return [list(_lines(group, room, setter)) for group, _ in found]


def latex(groups: EquationGroups, environment: str = "aligned", width: int = 76) -> str:
    """Equations as an amsmath environment: "aligned" inside a formula, "align*" in a document."""
    blocks = [
        " \\\\\n".join(
            f"&\\quad {right}" if goes_on else f"{left} &= {right}".lstrip()
            for left, right, goes_on in group
        )
        for group in _set(groups, width, LATEX)
    ]
    body = " \\\\[1.2ex]\n".join(blocks)
    return f"\\begin{{{environment}}}\n{body}\n\\end{{{environment}}}"


def _span(node: Expression) -> float:
    """Approximate width of a printed expression, in letters."""
    if isinstance(node, Vector):
        return max(map(_span, node.entries)) + 2.5
    if isinstance(node, Matrix):
        return sum(max(map(_span, column)) + 1.5 for column in zip(*node.rows, strict=True)) + 1
    if isinstance(node, Equation):
        return sum(map(_span, node.sides)) + 3 * (len(node.sides) - 1)
    if isinstance(node, Sum):
        return sum(map(_span, node.terms)) + 2.2 * (len(node.terms) - 1)
    if isinstance(node, Derivative):
        above = _span(node.of) if isinstance(node.of, Symbol) else 0.0
        return max(above, _span(node.by)) + 1.2 + (0.0 if above else _span(node.of) + 1.5)
    if isinstance(node, Quotient):
        return max(_span(node.above), _span(node.below)) + 0.5
    return width_of(LATEX.line(node))


def html(groups: EquationGroups, width: float = 74, alone: bool = False) -> str:
    """Equations as MathML tables aligned at the sign, long ones broken before one; equations with a
    wide left side get a table of their own.

    The width, in letters, suits a page of 960 px in the widest of the usual mathematical fonts
    (DejaVu's). Equations that stand `alone` need no style of a page around them, and are not
    divided for its print.
    """
    tables = _tables(groups, width, math.inf if alone else TALL)
    return "".join(_table(table, width, alone) for table in tables)


def _parts(group: Sequence[Equation], tall: float) -> list[tuple[int, Equation]]:
    """Equations with the number of the part they are in: parts of about `tall` rows, and a single
    part up to twice that."""
    heights = [_height(line) for line in group]
    total = sum(heights)
    count = int(total // tall) if total > 2 * tall else 1
    before = accumulate(heights, initial=0)
    return [(count * row // total, line) for line, row in zip(group, before, strict=False)]


def _height(line: Equation) -> int:
    """Number of rows in the tallest array of an equation."""
    arrays = (x for x in nodes(line) if isinstance(x, Vector | Matrix))
    return max((len(x.rows if isinstance(x, Matrix) else x.entries) for x in arrays), default=1)


def _tables(groups: EquationGroups, width: float, tall: float) -> list[list[list[Equation]]]:
    """Groups of equations split into tables, in order: left sides in a table are all wide or all
    narrow, and tables are not very tall."""
    tables: list[list[list[Equation]]] = []
    last = None
    for group in groups:
        parts = _parts([_turned_round(line, width, _span) for line in group], tall)
        runs = groupby(parts, lambda row: (row[0], _span(_left_side(row[1])) > WIDE * width))
        for k, (kind, lines) in enumerate(runs):
            if kind != last:
                tables.append([])
            if kind != last or not k:
                tables[-1].append([])
            tables[-1][-1] += [line for _, line in lines]
            last = kind
    return tables


def _table(groups: EquationGroups, width: float, alone: bool) -> str:
    cells = ""
    for j, group in enumerate(_set(groups, width, MATHML)):
        for k, (left, right, goes_on) in enumerate(group):
            apart = "padding-top:1em;" if j and not k else ""
            signed = "" if goes_on else (left or _NOTHING) + "<mo>=</mo>"
            indent = '<mspace width="1.5em"/>' if goes_on else ""
            cells += (
                f"<mtr>{_cell(signed, apart + _RIGHT * alone)}"
                f"{_cell(indent + right, apart + _LEFT * alone)}</mtr>"
            )
    of_class = "" if alone else ' class="aligned"'
    table = f'<mtable displaystyle="true"{of_class}>{cells}</mtable>'
    return f'<math {NAMESPACE} display="block">{table}</math>'


def _cell(inside: str, style: str) -> str:
    return f'<mtd style="{style}">{inside}</mtd>' if style else f"<mtd>{inside}</mtd>"


@dataclass(frozen=True)
class _Row:
    """A printed line left = right; left is None for the continuation of a chain."""

    left: Expression | None
    right: Expression


def _rows(group: Iterable[Equation], width: float, measure: _WidthOf) -> tuple[list[_Row], float]:
    """The lines of a group of equations, and the width left for right sides beside the widest left
    side."""
    turned = (_turned_round(equation, width, measure) for equation in group)
    lines = [line for equation in turned for line in _unfolded(equation, width, measure)]
    heads = [_head(line) for line in lines]
    room = width - _SIGN - max((measure(head) for head, _ in heads), default=0.0)
    return [row for head, rest in heads for row in _chain(head, rest, room, measure)], room


def _turned_round(equation: Equation, width: float, measure: _WidthOf) -> Equation:
    """The equation, or b = a for a = b if a is too wide for a line, as only right sides are
    broken: where b is short, or where a, of more than half a line, is wider than b."""
    left, *others = equation.sides
    own, sizes = measure(left), [measure(side) for side in others]
    if len(others) > 1 or own + _SIGN + sizes[0] <= width:
        return equation
    is_short = sizes[0] <= width / 4 or sizes[0] < own > width / 2
    return eq(others[0], left) if is_short else equation


def _unfolded(equation: Equation, width: float, measure: _WidthOf) -> list[Equation]:
    """The equation; if its last side is an array too wide for a line, equations of the array's
    entries."""
    *before, last = equation.sides
    name = before[0]
    if not isinstance(last, Vector | Matrix) or not isinstance(name, Symbol):
        return [equation]
    if measure(last) + measure(name) + _SIGN <= width:
        return [equation]
    return [*([Equation(tuple(before))] if len(before) > 1 else []), *_entries(name, last)]


def _entries(name: Symbol, array: Vector | Matrix) -> list[Equation]:
    if isinstance(array, Matrix):
        return [
            eq(component(name, place(i, j)), x)
            for i, row in enumerate(array.rows, 1)
            for j, x in enumerate(row, 1)
        ]
    labels = "xyz" if len(array.entries) <= 3 else map(str, range(1, len(array.entries) + 1))
    return [eq(component(name, label), x) for label, x in zip(labels, array.entries, strict=False)]


def _left_side(equation: Equation) -> Expression:
    """The side left of the sign at which equations are aligned."""
    return _head(equation)[0]


def _head(equation: Equation) -> tuple[Expression, tuple[Expression, ...]]:
    """The side left of the aligned sign, and the sides right of it; names come first."""
    names = 1
    while names < len(equation.sides) - 1 and isinstance(equation.sides[names], Symbol):
        names += 1
    left = equation.sides[:names]
    return (left[0] if names == 1 else Equation(left)), equation.sides[names:]


def _chain(
    head: Expression, rest: tuple[Expression, ...], room: float, measure: _WidthOf
) -> list[_Row]:
    """Lines of a chain of equal sides: one line if it fits, otherwise one per side."""
    joined = rest[0] if len(rest) == 1 else Equation(rest)
    if len(rest) == 1 or sum(map(measure, rest)) + _SIGN * (len(rest) - 1) <= room:
        return [_Row(head, joined)]
    return [_Row(head if k == 0 else None, side) for k, side in enumerate(rest)]
