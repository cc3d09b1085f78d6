"""Quantities of the tip: position, velocity, acceleration, and the Jacobian."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import ClassVar

from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.grammar.words import DETERMINANT
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.arithmetic import determinant
from freebody.expressions.quantities import kinds
from freebody.expressions.quantities.kinds import Kind
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import sub, times, transposed
from freebody_textbook.check.algebra.quotients import Value, plus
from freebody_textbook.check.algebra.quotients import times as multiplied
from freebody_textbook.check.asked.group import (
    MOST_ROWS,
    NamedTarget,
    QuantityGroup,
    column,
    entries,
    inverse,
    matrix,
)
from freebody_textbook.check.asked.loads import vectors
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity, QuantityTable

_TIP = {x: (x, *(x + end for end in ("P", "p", "E", "e", "tip")), f"p{x}", f"P{x}") for x in "xyz"}

_MOTION = (
    (kinds.TIP, "position"), (kinds.TIP_VELOCITY, "velocity"),
    (kinds.TIP_ACCELERATION, "acceleration"),
)  # fmt: skip


class TipQuantities(QuantityGroup):
    """The tip's quantities: x, y, r, J, J̇, det J."""

    in_equations_of_bodies: ClassVar[Mapping[str, str]] = {"J": "JP"}

    def single(self) -> Iterator[NamedTarget]:
        if self._tip is not None:
            yield from self._of_tip(self._tip)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        if self._tip is None:
            return {}
        J = [[single[f"J{i}{j}"] for j in self.numbers] for i in self._rows]
        position = J[: self.setting.symbols.model.dim]
        found = {"J": J, **self._tip_vectors(self._tip), "JP": position}
        if not self.setting.is_planar:
            found |= {"Js": self._of_twists(self._tip, "s"), "Jb": self._of_twists(self._tip, "b")}
        names = (f"{name}{INVERSE}" for name in ("J", "JP"))
        if self.setting.system is None:
            loads = vectors(self.setting, single)
            found |= {x: table for x, table in loads.items() if x not in single}
        if not self._inverse:
            return found
        return found | dict.fromkeys(names, self._inverse) | {"Lambda": self._operational}

    def _of_twists(self, tip: Kinematics, axes: str) -> QuantityTable:
        """The space Jacobian J_s and body Jacobian J_b of Lynch and Park (5.11), (5.18), angular
        rows first; the linear rows are the velocity of the body's point at the world's origin, in
        world axes, or of the hand's origin, in its own."""

        space = self.setting.equations.symbols.tree.space

        @cache
        def rows() -> list[tuple[Trig, ...]]:
            columns = []
            for whole in zip(*tip.J, strict=True):
                v, w = whole[:3], whole[3:]
                if axes == "b":
                    E = transposed(tuple(map(tuple, tip.rotation)))
                    columns.append((*times(E, w), *times(E, v)))
                else:
                    columns.append((*w, *sub(v, space.cross(w, tuple(tip.position)))))
            return list(zip(*columns, strict=True))

        words = {"s": "the space Jacobian", "b": "the body Jacobian"}[axes]
        return self._of_columns(kinds.TWIST_JACOBIAN, 6, rows, words)

    @cached_property
    def _inverse(self) -> QuantityTable:
        """The entries of J⁻¹, if some rows of J make it square."""
        rows = self._square(self._tip) if self._tip is not None else None
        if rows is None or len(rows) > MOST_ROWS:
            return []
        return inverse(
            self.setting,
            [[self._entry(i + 1, j) for j in self.numbers] for i in rows],
            "the tip's Jacobian",
        )

    @cached_property
    def _operational(self) -> QuantityTable:
        """The mass matrix at the tip, Λ = J⁻ᵀ M J⁻¹."""
        n = range(len(self._inverse))

        def entry(i: int, j: int) -> AskedQuantity:
            def value() -> Value:
                total: Value = self.setting.zero
                for k, m in itertools.product(n, repeat=2):
                    left, right = self._inverse[k][i].compute(), self._inverse[m][j].compute()
                    term = multiplied(multiplied(left, self.entry("M", k + 1, m + 1)()), right)
                    total = plus(total, term)
                return total

            words = f"entry {i + 1}, {j + 1} of the mass matrix at the tip"
            return AskedQuantity(kinds.INVERSE_ENTRY, (i + 1, j + 1), value, words=words)

        return [[entry(i, j) for j in n] for i in n]

    def _entry(self, i: int, j: int) -> Callable[[], Trig]:
        """Function that returns an entry of the tip's Jacobian J."""
        assert self._tip is not None
        J = self._tip.J
        return self.element(lambda: self.setting.forces(J[i - 1])[j - 1])

    @cached_property
    def _tip(self) -> Kinematics | None:
        symbols = self.setting.equations.symbols
        return None if symbols.model.tip is None else Kinematics(symbols, symbols.model.tip)

    def _tip_vectors(self, tip: Kinematics) -> dict[str, QuantityTable]:
        """The tip's vectors r, ṙ, r̈, and J̇ with the rows of the position."""
        dim = self.setting.symbols.model.dim
        found: dict[str, QuantityTable] = {}
        for dots, (kind, vector) in enumerate(_MOTION):
            words = f"the {vector} of the tip"
            own = [self.element(lambda k=k, x=vector: getattr(tip, x)[k]) for k in range(dim)]
            table = column(kind, own, words)
            of_vector = [
                x for x in ("x", "X") if dots and x not in self.setting.symbols.coordinates
            ]
            for letter in ("r", "rP", *of_vector):
                found |= dict.fromkeys(spellings(letter, "", dots), table)
            found |= {f"{'rva'[dots]}{place}": table for place in ("P", "E", "tip")}
            if dots == 2:
                found |= dict.fromkeys(spellings("vP", "", 1), table)
        rates = self._of_columns(
            kinds.JACOBIAN_RATE, dim, lambda: tip.J_dot, "the rate of the tip's Jacobian"
        )
        return found | dict.fromkeys(spellings("J", "", 1), rates)

    def _of_columns(
        self, kind: Kind, count: int, rows: Callable[[], Sequence[Sequence[Trig]]], words: str
    ) -> QuantityTable:
        """A matrix of quantities with one column per coordinate of the answer."""
        own = [
            [
                self.element(lambda i=i, j=j: self.setting.forces(rows()[i])[j])
                for j in range(self.count)
            ]
            for i in range(count)
        ]
        return matrix(kind, own, f"entry {{}}, {{}} of {words}")

    @property
    def _rows(self) -> range:
        """Numbers of the Jacobian's rows, counted from 1."""
        return range(1, 4 if self.setting.is_planar else 7)

    def _of_tip(self, tip: Kinematics) -> Iterator[NamedTarget]:
        for i in self._rows:
            for j in self.numbers:
                yield (f"J{i}{j}",), AskedQuantity(kinds.JACOBIAN, (i, j), self._entry(i, j))
        yield from entries({f"J{INVERSE}": self._inverse})
        for k in range(self.setting.symbols.model.dim):
            own = self.setting.symbols.coordinates
            taken = {*own, *(f"{p}{x}" for p in "pP" for x in own)}  # x of a cart, and its momentum
            names = tuple(name for name in _TIP["xyz"[k]] if name not in taken)
            yield names, AskedQuantity(kinds.TIP, (), self.element(lambda k=k: tip.position[k]))
            for kind, vector in _MOTION[1:]:
                dotted = tuple(s for name in names[:5] for s in spellings(name, "", kind.dots))
                dotted += (" va"[kind.dots] + "xyz"[k],)
                value = self.element(lambda k=k, vector=vector: getattr(tip, vector)[k])
                yield dotted, AskedQuantity(kind, (), value)
        yield from self._axes(tip, ("n", "os"))
        rows = self._square(tip)
        if rows is not None:
            value = self.element(
                lambda: determinant([tip.J[i] for i in rows], self.setting.equations.symbols)
            )
            yield ("detJ", f"J{DETERMINANT}"), AskedQuantity(kinds.DETERMINANT, (), value)

    def namesakes(self) -> Iterator[NamedTarget]:
        if self._tip is not None:  # a_x is an acceleration too
            yield from self._axes(self._tip, ("", "", "a"))

    def _axes(self, tip: Kinematics, letters_of: Sequence[str]) -> Iterator[NamedTarget]:
        """The axes of the hand, which are columns of its rotation matrix, by the letters of
        each."""
        for j, letters in enumerate(letters_of if not self.setting.is_planar else ()):
            for i, axis in enumerate("xyz"):
                value = self.element(lambda i=i, j=j: tip.rotation[i][j])
                words = f"component {axis} of the hand's {'xyz'[j]} axis"
                names = tuple(letter + axis for letter in letters)
                yield names, AskedQuantity(kinds.HAND_AXIS, (), value, words=words)

    def _square(self, tip: Kinematics) -> range | None:
        """The rows that make the Jacobian square: in space with three joints the position's, for a
        wrist the orientation's; None if there are none."""
        if self.setting.is_planar:
            return range(self.count) if self.count in (2, 3) else None
        if self.count == 6:
            return range(6)
        if self.count != 3:
            return None
        moves = any(not self.setting.element(x).is_zero for row in tip.J[:3] for x in row)
        return range(3) if moves else range(3, 6)
