"""A closed chain at rest: the loops' multipliers from the passive joints, the torques of the driven
ones (2.41-2.51).

Each joint must be held by k_i + Σ A_ik λ_k: weights, springs and load, and what the loops add.
Where there is no motor that is zero, and these equations give λ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from freebody.expressions.polynomials.arithmetic import PolynomialRows, determinant, inner
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.closed_chains.first_kind import multiplier_names
from freebody_textbook.closed_chains.linear import Ratio, ratio, solved
from freebody_textbook.closed_chains.loops import LoopEquations


@dataclass(frozen=True)
class LoopStatics:
    """Joint torques of a closed chain at rest, linear in the multipliers, by coordinate; with the
    passive coordinates."""

    loops: LoopEquations
    needed: Mapping[int, Trig]
    passive: tuple[int, ...]

    @cached_property
    def A(self) -> PolynomialRows:
        """The matrix A of A λ = right, one row per passive joint."""
        return [self._slopes(k) for k in self.passive]

    @cached_property
    def right(self) -> list[Trig]:
        """Right side -k of the equations of the passive joints."""
        return [-self.unloaded(k) for k in self.passive]

    def _slopes(self, k: int) -> list[Trig]:
        return [self.needed[k].derivative(name) for name in multiplier_names(self.loops)]

    def unloaded(self, k: int) -> Trig:
        """The torque k_k that joint k needs when the loops exert no forces."""
        s = self.loops.symbols
        multipliers = [s.ring[name] for name in multiplier_names(self.loops)]
        return self.needed[k] - inner(self._slopes(k), multipliers, s)

    @cached_property
    def _solution(self) -> tuple[list[Trig], Trig] | None:
        """Multipliers with a common denominator: (Δ λ, Δ); None if statics does not determine
        them."""
        s = self.loops.symbols
        square = len(self.passive) == len(self.loops.names)
        if not square or determinant(self.A, s).is_zero:
            return None
        above, below = solved(self.A, [[x] for x in self.right], s)
        return [row[0] for row in above], below

    @property
    def determined(self) -> bool:
        """Whether there are as many passive joints as loop equations, and they determine the
        multipliers."""
        return self._solution is not None

    @cached_property
    def multipliers(self) -> list[Ratio] | None:
        """The multipliers λ; None if the passive joints do not determine them, so that they depend
        on how the drives share the load."""
        if self._solution is None:
            return None
        above, below = self._solution
        return [ratio(x, below) for x in above]

    def torque(self, k: int) -> Ratio | None:
        """The torque of joint k's motor with the multipliers substituted."""
        if self._solution is None:
            return None
        above, below = self._solution
        through_loops = inner(self._slopes(k), above, self.loops.symbols)
        return ratio(self.unloaded(k) * below + through_loops, below)
