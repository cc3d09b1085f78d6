"""Groups of equations as text, LaTeX and MathML."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.derivations.expression import Equation, Expression, Sum
from freebody.derivations.render import latex as tex
from freebody.derivations.render import text as plain
from freebody.derivations.render.lines import broken, text_lines
from freebody.derivations.render.mathml import mathml, row

_SIGN = 4.2
"""Width of an equals sign and of the indent behind it, in letters."""

_RIGHT = "text-align:right;text-align:-webkit-right;padding-right:0"
_LEFT = "text-align:left;text-align:-webkit-left;padding-left:0.25em"

Groups = Sequence[Sequence[Equation]]


def text(groups: Groups, width: int = 100) -> str:
    """A line an equation, longer ones broken; an empty line between groups."""
    blocks = ["\n".join("\n".join(text_lines(plain.breakable(e), width)) for e in group) for group in groups]
    return "\n\n".join(blocks)


def latex(groups: Groups, environment: str = "aligned", width: int = 76) -> str:
    """An amsmath environment: "aligned" inside a formula, "align*" in a document."""
    rows = []
    room = width - _SIGN - max((tex.width(_left(e)) for group in groups for e in group), default=0)
    for group in groups:
        rows += [line + " \\\\" for equation in group for line in _latex_lines(equation, room)]
        rows[-1] += "[1.2ex]"
    body = "\n".join(rows).removesuffix(" \\\\[1.2ex]")
    return f"\\begin{{{environment}}}\n{body}\n\\end{{{environment}}}"


def _left(equation: Equation) -> str:
    return " = ".join(tex.latex(side) for side in equation.sides[:-1])


def _latex_lines(equation: Equation, room: float) -> list[str]:
    first, *rest = broken(tex.breakable(equation.rhs), room, tex.width)
    return [f"{_left(equation)} &= {first}", *(f"&\\quad {line}" for line in rest)]


def html(groups: Groups, width: int = 76) -> str:
    """One MathML table, equations aligned at their sign, long ones broken between terms."""
    rows = "".join(
        _mathml_rows(equation, width, k == 0 and j > 0)
        for j, g in enumerate(groups)
        for k, equation in enumerate(g)
    )
    return (
        '<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">'
        f'<mtable displaystyle="true">{rows}</mtable></math>'
    )


def _mathml_rows(equation: Equation, width: int, apart: bool) -> str:
    left = "<mo>=</mo>".join(row(side) for side in equation.sides[:-1]) + "<mo>=</mo>"
    space = "padding-top:1em;" if apart else ""
    cells = ""
    for k, part in enumerate(_parts(equation.rhs, width)):
        head = left if k == 0 else ""
        indent = '<mspace width="1.5em"/>' if k else ""
        style = space if k == 0 else ""
        cells += (
            f'<mtr><mtd style="{style}{_RIGHT}">{head}</mtd>'
            f'<mtd style="{style}{_LEFT}">{indent}{part}</mtd></mtr>'
        )
    return cells


def _parts(side: Expression, width: int) -> list[str]:
    """The terms of a sum, as many on a line as fit."""
    if not isinstance(side, Sum):
        return [row(side)]
    lines: list[list[Expression]] = [[]]
    used = 0.0
    for term in side.terms:
        size = tex.width(tex.latex(term)) + 2
        if lines[-1] and used + size > width:
            lines.append([])
            used = 0.0
        lines[-1].append(term)
        used += size
    rows = [row(Sum(tuple(lines[0])))]
    return rows + [_continued(terms) for terms in lines[1:]]


def _continued(terms: list[Expression]) -> str:
    """A line that begins with the sign of its first term."""
    string = row(Sum(tuple(terms)))
    string = string.removeprefix("<mrow>")
    minus = "<mo>−</mo>"
    sign, rest = ("−", string.removeprefix(minus)) if string.startswith(minus) else ("+", string)
    return f'<mrow><mo form="infix">{sign}</mo>{rest}'


__all__ = ["Groups", "html", "latex", "mathml", "text"]
