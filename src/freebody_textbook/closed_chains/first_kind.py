"""Lagrange's equations of the first kind in closed form, and their reduction to independent
coordinates.

    M q̈ + Φ_qᵀ λ = n,   Φ_q q̈ = c                       (5.27-5.29)

With q̇ = N u̇, Φ_q N = 0 and q̈ = N ü + γ the multipliers leave: NᵀM N ü = Nᵀ(n - M γ), the second
kind (5.24).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.polynomials.arithmetic import PolynomialRows, determinant, inner, times
from freebody.expressions.polynomials.symbols import Symbols
from freebody.lazy import cached_property
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.model import Model
from freebody.scalars.trig import Trig
from freebody.spatial import of_dimension
from freebody_textbook.closed_chains.linear import Ratio, ratio, solved
from freebody_textbook.closed_chains.loops import LoopEquations
from freebody_textbook.equations.equations import Equations

MULTIPLIER = "lam"
"""Multipliers are lam1, lam2, … in the order of the loop equations."""


MOST = 8
"""Loop equations up to which they are solved for the rates in closed form."""


def multiplier_names(loops: LoopEquations) -> tuple[str, ...]:
    """Names of the multipliers of some loop equations."""
    return tuple(f"{MULTIPLIER}{k}" for k in range(1, len(loops.names) + 1))


def multipliers(model: Model) -> tuple[str, ...]:
    """Names of the multipliers of a model's loop equations."""
    space = of_dimension(model.dim)
    size = sum(LOOP_KINDS[loop.kind].closure(space, loop.axis).size(space) for loop in model.loops)
    return tuple(f"{MULTIPLIER}{k}" for k in range(1, size + 1))


def is_multiplier(name: str) -> bool:
    """Whether a name is one of a multiplier."""
    return atom(name).letter == MULTIPLIER


@dataclass(frozen=True)
class FirstKind:
    """Lagrange's equations of the first kind M q̈ + Φ_qᵀ λ = n, Φ_q q̈ = c as exact polynomials.
    The ring contains the multipliers and the drive torques."""

    loops: LoopEquations
    equations: Equations
    """The equations of the tree that is left when the loops are cut."""

    @property
    def symbols(self) -> Symbols:
        """Symbols of the ring, with the tree."""
        return self.loops.symbols

    @property
    def M(self) -> PolynomialRows:
        """Mass matrix of the tree."""
        return self.equations.M

    @cached_property
    def rest(self) -> list[Trig]:
        """Velocity terms, gravity, friction and springs: the generalized forces needed besides M
        q̈."""
        e = self.equations
        return [c + g + d for c, g, d in zip(e.c, e.g, e.drives, strict=True)]

    @cached_property
    def multipliers(self) -> list[Trig]:
        """Multipliers λ as symbols of the ring."""
        return [self.symbols.ring[name] for name in multiplier_names(self.loops)]

    @cached_property
    def pressed(self) -> list[Trig]:
        """Generalized forces of the loops, Φ_qᵀ λ."""
        columns = zip(*self.loops.Phi_q, strict=True)
        return [inner(column, self.multipliers, self.symbols) for column in columns]

    @cached_property
    def forces(self) -> list[Trig]:
        """Generalized forces M q̈ + velocity terms + gravity + friction and springs + Φ_qᵀ λ
        (5.23)."""
        return [a + b for a, b in zip(self.equations.tau, self.pressed, strict=True)]

    @cached_property
    def reduction(self) -> Reduction | None:
        """The equations in independent coordinates; None if there are no independent coordinates,
        if none of their choices determines the others, or if there are more than `MOST` loop
        equations."""
        chosen = _independent(self.loops)
        return None if chosen is None else Reduction(self, chosen)


def _independent(loops: LoopEquations) -> tuple[int, ...] | None:
    """Independent coordinates, whose rates determine all others: the drives if possible, otherwise
    the first suitable ones; None if there are none."""
    n, f = len(loops.symbols.coordinates), loops.gruebler
    if f <= 0 or len(loops.names) > MOST:
        return None
    order = sorted(range(n), key=lambda k: k not in loops.driven)
    for chosen in combinations(order, f):
        rest = [k for k in range(n) if k not in chosen]
        if not determinant([[row[k] for k in rest] for row in loops.Phi_q], loops.symbols).is_zero:
            return tuple(sorted(chosen))
    return None


@dataclass(frozen=True)
class Reduction:
    """q̇ = N u̇ and q̈ = N ü + γ for independent coordinates u (their indices), valid where Δ is
    not 0."""

    system: FirstKind
    independent: tuple[int, ...]

    @cached_property
    def dependent(self) -> tuple[int, ...]:
        """Dependent coordinates, which the loop equations give."""
        return tuple(
            k for k in range(len(self.system.symbols.coordinates)) if k not in self.independent
        )

    @cached_property
    def _solved(self) -> tuple[PolynomialRows, Trig]:
        """Δ times the dependent rates by u̇ with Δ times their γ as last column, and Δ."""
        loops, s = self.system.loops, self.system.symbols
        A = [[row[k] for k in self.dependent] for row in loops.Phi_q]
        right = [
            [*(-row[k] for k in self.independent), c]
            for row, c in zip(loops.Phi_q, loops.c, strict=True)
        ]
        return solved(A, right, s)

    @property
    def delta(self) -> Trig:
        """Determinant Δ of the columns of Φ_q of the dependent coordinates."""
        return self._solved[1]

    @cached_property
    def scaled(self) -> PolynomialRows:
        """The matrix Δ N as polynomials: Φ_q (Δ N) = 0 at every position, closed or not."""
        return [self._row(k, slice(None, -1)) for k in range(len(self.system.symbols.coordinates))]

    @cached_property
    def scaled_drift(self) -> list[Trig]:
        """Numerators Δ γ of the drift."""
        n = len(self.system.symbols.coordinates)
        return [
            self._row(k, slice(-1, None))[0] if k in self.dependent else self.system.symbols.zero()
            for k in range(n)
        ]

    def _row(self, k: int, part: slice) -> list[Trig]:
        if k in self.dependent:
            return self._solved[0][self.dependent.index(k)][part]
        s = self.system.symbols
        return [self.delta if k == j else s.zero() for j in self.independent]

    @cached_property
    def N(self) -> list[list[Ratio]]:
        """Derivatives of all rates by the independent ones, ∂q̇/∂u̇."""
        return [[ratio(x, self.delta) for x in row] for row in self.scaled]

    @cached_property
    def drift(self) -> list[Ratio]:
        """Accelerations γ of the coordinates where ü = 0."""
        return [ratio(x, self.delta) for x in self.scaled_drift]

    @cached_property
    def mass(self) -> PolynomialRows:
        """Reduced mass matrix Δ² NᵀM N, a matrix of polynomials."""
        s = self.system.symbols
        columns = list(zip(*self.scaled, strict=True))
        return times(times(columns, self.system.M, s), self.scaled, s)

    def right(self, Q: Sequence[Trig]) -> list[Trig]:
        """Δ² Nᵀ(Q - rest - M γ) for generalized forces Q."""
        s = self.system.symbols
        moved = [inner(row, self.scaled_drift, s) for row in self.system.M]
        left = [
            self.delta * (q - rest) - m
            for q, rest, m in zip(Q, self.system.rest, moved, strict=True)
        ]
        return [inner(column, left, s) for column in zip(*self.scaled, strict=True)]
