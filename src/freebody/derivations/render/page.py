"""Groups of equations as text, LaTeX and MathML."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.derivations.expressions.expression import (
    Derivative,
    Equation,
    Expression,
    Matrix,
    Quotient,
    Sum,
    Symbol,
    Vector,
)
from freebody.derivations.render import latex as tex
from freebody.derivations.render import mathml as web
from freebody.derivations.render import text as plain
from freebody.derivations.render.lines import broken
from freebody.derivations.render.mathml import mathml
from freebody.derivations.render.rows import Row, rows

_RIGHT = "text-align:right;text-align:-webkit-right;padding-right:0"
_LEFT = "text-align:left;text-align:-webkit-left;padding-left:0.25em"

Groups = Sequence[Sequence[Equation]]


# ---------------------------------------------------------------- text
def text(groups: Groups, width: int = 100) -> str:
    """A line an equation, longer ones broken; an empty line between groups."""
    return "\n\n".join("\n".join(_text_group(group, width)) for group in groups)


def _text_group(group: Sequence[Equation], width: int) -> list[str]:
    lines, indent = [], 0
    for row in rows(group, width, _letters)[0]:
        head = " " * indent if row.left is None else plain.text(row.left)
        indent = len(head)
        first, *rest = broken(plain.breakable(row.right), width - indent - 3)
        lines += [f"{head} = {first}", *(" " * min(indent + 3, 12) + line for line in rest)]
    return lines


def _letters(node: Expression) -> float:
    return len(plain.text(node))


# ---------------------------------------------------------------- LaTeX
def latex(groups: Groups, environment: str = "aligned", width: int = 76) -> str:
    """An amsmath environment: "aligned" inside a formula, "align*" in a document."""
    sizes = [rows(group, width, span) for group in groups]
    room = min((room for _, room in sizes), default=width)
    blocks = ["\n".join(_latex_row(row, room) for row in lines) for lines, _ in sizes]
    body = "[1.2ex]\n".join(blocks).removesuffix(" \\\\")
    return f"\\begin{{{environment}}}\n{body}\n\\end{{{environment}}}"


def _latex_row(row: Row, room: float) -> str:
    left = "" if row.left is None else tex.latex(row.left) + " "
    fits = span(row.right) <= room
    first, *rest = (
        [tex.latex(row.right)] if fits else broken(tex.breakable(row.right), room, tex.width)
    )
    return "\n".join(
        line + " \\\\" for line in (f"{left}&= {first}", *(f"&\\quad {x}" for x in rest))
    )


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
    return tex.width(tex.latex(node))


# ---------------------------------------------------------------- MathML
def html(groups: Groups, width: int = 74) -> str:
    """One MathML table, equations aligned at their sign, long ones broken before one.

    The width, in letters, suits a page of 960 px in the widest of the usual mathematical fonts
    (DejaVu's).
    """
    sizes = [rows(group, width, span) for group in groups]
    room = min((room for _, room in sizes), default=width)
    cells = "".join(
        _mathml_row(row, room, k == 0 and j > 0)
        for j, (lines, _) in enumerate(sizes)
        for k, row in enumerate(lines)
    )
    return (
        '<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">'
        f'<mtable displaystyle="true">{cells}</mtable></math>'
    )


def _mathml_row(row: Row, room: float, apart: bool) -> str:
    left = ("" if row.left is None else web.row(row.left)) + "<mo>=</mo>"
    lines = [web.row(row.right)] if span(row.right) <= room else web.broken_rows(row.right, room)
    cells = ""
    for k, part in enumerate(lines):
        space = "padding-top:1em;" if apart and k == 0 else ""
        indent = '<mspace width="1.5em"/>' if k else ""
        cells += (
            f'<mtr><mtd style="{space}{_RIGHT}">{left if k == 0 else ""}</mtd>'
            f'<mtd style="{space}{_LEFT}">{indent}{part}</mtd></mtr>'
        )
    return cells


__all__ = ["Groups", "html", "latex", "mathml", "span", "text"]
