"""Base class of all groups of quantities: the model's equations, letters, and values as polynomials
in the answer's symbols."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, ClassVar

from freebody.expressions.grammar.lexemes import NOTHING, Lexemes
from freebody.expressions.polynomials.arithmetic import PolynomialRows
from freebody.expressions.quantities import kinds
from freebody.expressions.quantities.kinds import SUMS, Kind
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value, over
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.closed_chains.linear import solved
from freebody_textbook.methods.setting import Setting

NamedTarget = tuple[tuple[str, ...], AskedQuantity]
"""A quantity with its names, in plain spelling."""


def entries(tables: Mapping[str, QuantityTable]) -> Iterator[NamedTarget]:
    """Entries of matrices, each named by the matrix and its indices: M12."""
    for name, table in tables.items():
        for row in table:
            yield from (((name + "".join(map(str, x.index)),), x) for x in row)


def components(tables: Mapping[str, QuantityTable]) -> Iterator[NamedTarget]:
    """Components of vectors, each named by the vector and its axis, vc1x; a vector with one entry
    keeps its name."""
    for name, table in tables.items():
        for row in table:
            yield from (((name + x.axis,), x) for x in row if x.axis or len(table) == 1)


def column(
    kind: Kind,
    values: Iterable[Callable[[], Value]],
    words: str,
    index: tuple[int, ...] = (),
    axes: Sequence[str] = "xyz",
    is_angular: bool = False,
) -> QuantityTable:
    """A vector of quantities, each described in words."""
    return [
        [AskedQuantity(kind, index, value, axis=axis, words=words, is_angular=is_angular)]
        for axis, value in zip(axes, values, strict=False)
    ]


def matrix(kind: Kind, rows: Iterable[Iterable[Callable[[], Value]]], words: str) -> QuantityTable:
    """A matrix of quantities; `words` is their description, with places for row and column."""
    return [
        [
            AskedQuantity(kind, (i, j), value, words=words.format(i, j))
            for j, value in enumerate(row, 1)
        ]
        for i, row in enumerate(rows, 1)
    ]


def values(found: Iterable[Trig]) -> list[Callable[[], Value]]:
    """Functions that return the given polynomials."""
    return [lambda x=x: x for x in found]


class QuantityGroup:
    """A group of quantities of a model. letters: those of each kind of quantity. based: the base is
    accelerated by -g, which all accelerations then include. formulas: those of the answer."""

    in_equations_of_bodies: ClassVar[Mapping[str, str]] = {}
    """Vectors and matrices by names that others have in the equations of motion."""

    def __init__(
        self,
        setting: RightEquations,
        letters: Mapping[str, tuple[str, ...]],
        based: bool,
        formulas: Lexemes = NOTHING,
    ):
        self.setting, self.letters, self.based = setting, letters, based
        self.formulas = formulas

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer uses this group, whose names mean other things in most answers."""
        return bool(formulas)

    def single(self) -> Iterator[NamedTarget]:
        """Quantities with one polynomial as value, with their names."""
        yield from ()

    def namesakes(self) -> Iterator[NamedTarget]:
        """Quantities whose names other quantities have too; the answer decides between them."""
        yield from ()

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        """Vectors and matrices by name; single: the scalar quantities of all groups."""
        return {}

    @property
    def count(self) -> int:
        """The number of coordinates in the robot."""
        return len(self.setting.symbols.coordinates)

    @property
    def numbers(self) -> range:
        """Numbers of the coordinates, counted from 1."""
        return range(1, self.count + 1)

    @property
    def passive(self) -> tuple[int, ...]:
        """Numbers, counted from 1, of the joints without a drive."""
        return tuple(k + 1 for k in self.setting.symbols.model.passive)

    def joint(self, i: int) -> str:
        """Description of the joint of coordinate i; joints that follow others have no
        coordinate."""
        bodies = enumerate(self.setting.equations.symbols.model.bodies, 1)
        own = [n for n, body in bodies if body.joint.mimic is None]
        return f"joint {own[i - 1]}"

    @cached_property
    def _setting(self) -> Setting:
        """The mechanism for which the equations are derived."""
        return Setting(self.setting.equations.symbols)

    def element(self, value: Callable[[], Any]) -> Callable[[], Trig]:
        """Function that converts a number or polynomial of the model's equations to the ring of
        answers."""
        return lambda: self.setting.element(self.setting.equations.symbols.element(value()))

    def quotient(self, sides: Callable[[], tuple[Trig, Trig]]) -> Callable[[], Value]:
        """Function that converts a quotient of two polynomials of the model's equations to the ring
        of answers."""
        return lambda: over(*map(self.setting.element, sides()))

    def coordinate(self, name: str, k: int) -> AskedQuantity:
        """The quantity that is entry k of q, q̇ or q̈."""
        return AskedQuantity(kinds.COORDINATE, (k,), lambda: self.setting.ring[name])

    def entry(self, name: str, *index: int) -> Callable[[], Trig]:
        """Function that returns an entry of a named vector or matrix of the equations."""

        def value() -> Trig:
            return sum(map(part, SUMS.get(name, (name,))), self.setting.zero)

        def part(name: str) -> Trig:
            found: Any = self.setting.all_of(name)
            for i in index:
                found = found[i - 1]
            return self.setting.element(found)

        return value


MOST_ROWS = 3
"""The most rows of a matrix that is inverted."""
_TRANSPOSED = "This is the entry of the inverse's transpose."
_UNDIVIDED = "It is not divided by the determinant."


def inverse(
    setting: RightEquations, rows: Sequence[Sequence[Callable[[], Trig]]], words: str
) -> QuantityTable:
    """The entries of an inverse matrix as quantities, described in words."""
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
