"""Groups of equations as text, LaTeX and MathML."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate, groupby

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
from freebody.expressions.typesetting.latex import LATEX, width_of
from freebody.expressions.typesetting.mathml import MATHML, NAMESPACE
from freebody.expressions.typesetting.text import TEXT
from freebody.expressions.typesetting.typesetter import Typesetter
from freebody_textbook.render.paper import ROWS
from freebody_textbook.render.rows import Row, left_side, rows, turned_round

_RIGHT = "text-align:right;text-align:-webkit-right;padding-right:0"
_LEFT = "text-align:left;text-align:-webkit-left;padding-left:0"
STYLE = f".aligned>mtr>mtd:first-child{{{_RIGHT}}}.aligned>mtr>mtd:last-child{{{_LEFT}}}{ROWS}"
"""A page with equations of `html` needs it: their rows say nothing of how they are aligned."""

Groups = Sequence[Sequence[Equation]]

WIDE = 0.25
"""The part of a line from which on a left side is wide."""
_NOTHING = "<mi></mi>"
"""A sign that stands alone would have no space beside it."""
TALL = 24
"""About the rows of a table where there are many: a printed page breaks between tables."""


# ---------------------------------------------------------------- text
def text(groups: Groups, width: int = 100) -> str:
    """A line an equation, longer ones broken; an empty line between groups."""
    return "\n\n".join("\n".join(_text_group(group, width)) for group in groups)


def _text_group(group: Sequence[Equation], width: int) -> list[str]:
    lines, indent = [], 0
    for row in rows(group, width, _letters)[0]:
        head = " " * indent if row.left is None else TEXT.line(row.left)
        indent = len(head)
        first, *rest = TEXT.lines(row.right, width - indent - 3)
        lines += [f"{head} = {first}", *(" " * min(indent + 3, 12) + line for line in rest)]
    return lines


def _letters(node: Expression) -> float:
    return len(TEXT.line(node))


# ---------------------------------------------------------------- formulas
def _lines(
    group: Sequence[Row], room: float, setter: Typesetter
) -> Iterator[tuple[str, str, bool]]:
    """What stands left and right of the sign, line by line, and whether a line goes on with the one
    before."""
    for row in group:
        left = "" if row.left is None else setter.line(row.left)
        fits = span(row.right) <= room
        parts = [setter.line(row.right)] if fits else setter.lines(row.right, room)
        yield from ((left, part, k > 0) for k, part in enumerate(parts))


def _set(groups: Groups, width: float, setter: Typesetter) -> list[list[tuple[str, str, bool]]]:
    """The lines of each group; all have the same room."""
    found = [rows(group, width, span) for group in groups]
    room = min((room for _, room in found), default=width)
    return [list(_lines(group, room, setter)) for group, _ in found]


def latex(groups: Groups, environment: str = "aligned", width: int = 76) -> str:
    """An amsmath environment: "aligned" inside a formula, "align*" in a document."""
    blocks = [
        " \\\\\n".join(
            f"&\\quad {right}" if goes_on else f"{left} &= {right}".lstrip()
            for left, right, goes_on in group
        )
        for group in _set(groups, width, LATEX)
    ]
    body = " \\\\[1.2ex]\n".join(blocks)
    return f"\\begin{{{environment}}}\n{body}\n\\end{{{environment}}}"


def span(node: Expression) -> float:
    """About how wide an expression is as a formula, in letters."""
    if isinstance(node, Vector):
        return max(map(span, node.entries)) + 2.5
    if isinstance(node, Matrix):
        return sum(max(map(span, column)) + 1.5 for column in zip(*node.rows, strict=True)) + 1
    if isinstance(node, Equation):
        return sum(map(span, node.sides)) + 3 * (len(node.sides) - 1)
    if isinstance(node, Sum):
        return sum(map(span, node.terms)) + 2.2 * (len(node.terms) - 1)
    if isinstance(node, Derivative):
        above = span(node.of) if isinstance(node.of, Symbol) else 0.0
        return max(above, span(node.by)) + 1.2 + (0.0 if above else span(node.of) + 1.5)
    if isinstance(node, Quotient):
        return max(span(node.above), span(node.below)) + 0.5
    return width_of(LATEX.line(node))


def html(groups: Groups, width: float = 74, alone: bool = False) -> str:
    """MathML tables, equations aligned at their sign, long ones broken before one; equations with a
    wide left side have a table of their own, lest others have no room.

    The width, in letters, suits a page of 960 px in the widest of the usual mathematical fonts
    (DejaVu's). Equations that stand `alone` need no style of a page around them, and are not
    divided for its print.
    """
    tables = _tables(groups, width, math.inf if alone else TALL)
    return "".join(_table(table, width, alone) for table in tables)


def _parts(group: Sequence[Equation], tall: float) -> list[tuple[int, Equation]]:
    """Each equation with the number of its part: parts of about `tall` rows, one of few that are
    not twice as many."""
    heights = [_height(line) for line in group]
    total = sum(heights)
    count = int(total // tall) if total > 2 * tall else 1
    before = accumulate(heights, initial=0)
    return [(count * row // total, line) for line, row in zip(group, before, strict=False)]


def _height(line: Equation) -> int:
    """Rows of the tallest array in an equation."""
    arrays = (x for x in nodes(line) if isinstance(x, Vector | Matrix))
    return max((len(x.rows if isinstance(x, Matrix) else x.entries) for x in arrays), default=1)


def _tables(groups: Groups, width: float, tall: float) -> list[list[list[Equation]]]:
    """The groups, in the same order, in tables of left sides that are all wide or all narrow, and
    not of very many rows."""
    tables: list[list[list[Equation]]] = []
    last = None
    for group in groups:
        parts = _parts([turned_round(line, width, span) for line in group], tall)
        runs = groupby(parts, lambda row: (row[0], span(left_side(row[1])) > WIDE * width))
        for k, (kind, lines) in enumerate(runs):
            if kind != last:
                tables.append([])
            if kind != last or not k:
                tables[-1].append([])
            tables[-1][-1] += [line for _, line in lines]
            last = kind
    return tables


def _table(groups: Groups, width: float, alone: bool) -> str:
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
