"""Inverses of square matrices of quantities: quotients of minors and the determinant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

from freebody.expressions.polynomials.arithmetic import PolynomialRows
from freebody.expressions.quantities import kinds
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value, over
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.closed_chains.linear import solved

MOST_ROWS = 3
"""Of a matrix that is inverted."""
_TRANSPOSED = "This is the entry of the inverse's transpose."
_UNDIVIDED = "It is not divided by the determinant."


def inverse(
    setting: RightEquations, rows: Sequence[Sequence[Callable[[], Trig]]], words: str
) -> QuantityTable:
    """The entries of the inverse of a matrix, told in words."""
    n = range(len(rows))

    @cache
    def made() -> tuple[PolynomialRows, Trig]:
        unit = [[setting.zero + int(i == j) for j in n] for i in n]
        matrix = [[entry() for entry in row] for row in rows]
        found, determinant = solved(matrix, unit, setting.symbols)
        if determinant.is_zero:
            raise AnswerError(f"{words} has no inverse: its determinant is 0 in all positions")
        return found, determinant

    def entry(i: int, j: int) -> AskedQuantity:
        def value() -> Value:
            return over(made()[0][i][j], made()[1])

        thoughts: list[Mistaken] = [(_UNDIVIDED, lambda: made()[0][i][j])]
        if i != j:
            thoughts.insert(0, (_TRANSPOSED, lambda: over(made()[0][j][i], made()[1])))
        return AskedQuantity(
            kinds.INVERSE_ENTRY, (i + 1, j + 1), value, joint=words, thoughts=tuple(thoughts)
        )

    return [[entry(i, j) for j in n] for i in n]
