"""Closed chains in independent coordinates: q̇ = N u̇, q̈ = N ü + γ, and the forces n."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value, negative, over
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.closed_chains.first_kind import Reduction

_N = LexemePattern("!-%latin N !~%latin")
_H, _M = (LexemePattern(f"!-%latin {letter} _? {{? < %counted | %low_digit >") for letter in "HM")


class ReducedQuantities(QuantityGroup):
    """n, N, γ and u of a closed chain in the plane or in space."""

    def single(self) -> Iterator[NamedTarget]:
        if self.setting.system is None:
            return
        for i in self.numbers:
            yield (f"n{i}",), self._applied(i)
        for k, of_loop in enumerate(self.setting.system.loops.c, 1):
            also = (("It is read as c of Φ_q q̈ = c.", self.element(lambda x=of_loop: x)),)
            asked = AskedQuantity(
                kinds.LOOP_REST, (k,), also[0][1], words=f"what row {k} of Φ_q q̈ must be"
            )
            yield (
                (f"gamma{k}",),
                replace(self._drift[k - 1][0], also=also) if self._drift else asked,
            )
        for (x,) in self._drift:
            yield (f"gamma{x.index[0]}",), x

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        if self.setting.system is None:
            return {}
        found: dict[str, QuantityTable] = {"n": [[self._applied(i)] for i in self.numbers]}
        if self._reduction is None:
            return found
        own = [k + 1 for k in self._reduction.independent]
        N = [[self._entry(k, j) for j in range(1, len(own) + 1)] for k in self.numbers]
        found |= {"N": N, **({"gamma": self._drift} if _N.found_in(self.formulas) else {})}
        for dots, ending in enumerate(("", RATE, SECOND)):
            names = [self.setting.symbols.coordinates[k - 1] + ending for k in own]
            column = [
                [AskedQuantity(kinds.COORDINATE, (k,), lambda x=x: self.setting.ring[x])]
                for k, x in zip(own, names, strict=True)
            ]
            found |= dict.fromkeys(spellings("u", "", dots), column)
        return found

    @property
    def _reduction(self) -> Reduction | None:
        return reduction_of(self.setting)

    def _applied(self, i: int) -> AskedQuantity:
        """n_i: the drive, less what the velocities, the weights, springs and friction need."""

        def value() -> Trig:
            tau, rest = self.entry("tau", i), [self.entry(x, i)() for x in ("c", "g", "drives")]
            idle = i in self.passive
            return (self.setting.zero if idle else tau()) - sum(rest, self.setting.zero)

        words = f"the generalized force of joint {i} without what accelerations and loops need"
        return AskedQuantity(kinds.APPLIED, (i,), value, words=words)

    def _entry(self, k: int, j: int) -> AskedQuantity:
        def value(k: int = k, j: int = j) -> Value:
            assert self._reduction is not None
            above = self._reduction.scaled[k - 1][j - 1]
            return over(self.setting.element(above), self.setting.element(self._reduction.delta))

        return AskedQuantity(
            kinds.OF_INDEPENDENT, (k, j), value, words=f"entry {k}, {j} of N, q̇ = N u̇"
        )

    @cached_property
    def _drift(self) -> QuantityTable:
        """γ: what q̈ is where ü = 0."""
        return [[self._drift_of(k)] for k in self.numbers] if self._reduction else []

    def _drift_of(self, k: int) -> AskedQuantity:
        def value() -> Value:
            assert self._reduction is not None
            above, below = self._reduction.scaled_drift[k - 1], self._reduction.delta
            return over(self.setting.element(above), self.setting.element(below))

        return AskedQuantity(
            kinds.DRIFT, (k,), value, words=f"entry {k} of γ, q̈ = N ü + γ",
            thoughts=(("It has the wrong sign: Φ_q γ = c = −Φ̇_q q̇.", lambda: negative(value())),),
        )  # fmt: skip


class ReducedMass(QuantityGroup):
    """H_ij of NᵀM N, in answers that call it H and that of the cut chain M."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether both are in it."""
        first = next(_H.all(formulas), None)
        return first is not None and _M.found_in(formulas, first.stop)

    def single(self) -> Iterator[NamedTarget]:
        reduction = reduction_of(self.setting)
        n = range(len(reduction.independent) if reduction else 0)
        for i in n:
            for j in n:
                yield (f"H{i + 1}{j + 1}",), self._entry(i, j)

    def _entry(self, i: int, j: int) -> AskedQuantity:
        def value() -> Value:
            reduction = reduction_of(self.setting)
            assert reduction is not None
            below = self.setting.element(reduction.delta)
            return over(self.setting.element(reduction.mass[i][j]), below * below)

        words = f"entry {i + 1}, {j + 1} of the mass matrix in independent coordinates, NᵀM N"
        return AskedQuantity(kinds.OF_INDEPENDENT, (i + 1, j + 1), value, words=words)


def reduction_of(setting: RightEquations) -> Reduction | None:
    """A closed chain in independent coordinates."""
    system = setting.system if setting.turned is None else None
    return system and system.reduction
