"""The equations of motion in closed form: M(q) q̈ + c(q, q̇) + g(q) + friction and springs = tau."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from freebody.algorithms.crba import crba
from freebody.algorithms.energy import potential_energy
from freebody.algorithms.rnea import drive_torque
from freebody.arrays import Array
from freebody.derivations.symbols import Symbols, symbols
from freebody.model.model import Model
from freebody.scalars.trig import Trig


@dataclass(frozen=True)
class Equations:
    """Closed forms of a model, exact polynomials in normal form: equal means identical."""

    symbols: Symbols

    @cached_property
    def M(self) -> list[list[Trig]]:
        """Mass matrix, rotors included."""
        s = self.symbols
        return [[s.element(x) for x in row] for row in crba(s.tree, s.q)]

    @cached_property
    def christoffel(self) -> list[list[list[Trig]]]:
        """[i][j][k] = ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j - ∂M_jk/∂q_i)."""
        n, names = len(self.symbols.coordinates), self.symbols.coordinates
        slope = [
            [[self.M[i][j].derivative(x) for x in names] if j >= i else [] for j in range(n)]
            for i in range(n)
        ]

        def dM(i: int, j: int, k: int) -> Trig:
            return slope[min(i, j)][max(i, j)][k]

        table: list[list[list[Trig]]] = [[[self.symbols.zero()] * n for _ in range(n)] for _ in range(n)]
        for i in range(n):
            for j in range(n):
                for k in range(j, n):
                    value = (dM(i, j, k) + dM(i, k, j) - dM(j, k, i)) * 0.5
                    table[i][j][k] = table[i][k][j] = value
        return table

    @cached_property
    def C(self) -> list[list[Trig]]:
        """Coriolis matrix of Christoffel's symbols: C q̇ = c and Ṁ - 2C is skew-symmetric."""
        return [[self._along_rates(row) for row in plane] for plane in self.christoffel]

    @cached_property
    def c(self) -> list[Trig]:
        """Coriolis and centrifugal terms."""
        return [self._along_rates(row) for row in self.C]

    def _along_rates(self, row: list[Trig]) -> Trig:
        total = self.symbols.zero()
        for x, rate in zip(row, self.symbols.qd, strict=True):
            if not x.is_zero:
                total = total + x * rate
        return total

    @cached_property
    def g(self) -> list[Trig]:
        """Gravity terms."""
        s = self.symbols
        tree = s.tree
        weight = s.element(potential_energy(_without_drives(tree), s.q))
        return [weight.derivative(x) for x in s.coordinates]

    @cached_property
    def drives(self) -> list[Trig]:
        """Friction and springs."""
        s = self.symbols
        total = [s.zero() for _ in s.coordinates]
        for body in s.tree.bodies:
            if body.drive is not None:
                k = body.coordinates.v[0]
                total[k] = total[k] + body.coordinates.ratio * drive_torque(body, s.q, s.qd)
        return total

    @cached_property
    def tau(self) -> list[Trig]:
        """Joint torques M q̈ + c + g + friction and springs."""
        rows = []
        for row, c, g, drive in zip(self.M, self.c, self.g, self.drives, strict=True):
            total = c + g + drive
            for x, second in zip(row, self.symbols.qdd, strict=True):
                total = total + x * second
            rows.append(total)
        return rows

    @cached_property
    def T(self) -> Trig:
        """Kinetic energy ½ q̇ᵀ M q̇."""
        total = self.symbols.zero()
        for row, rate in zip(self.M, self.symbols.qd, strict=True):
            total = total + rate * self._along_rates(row)
        return total * 0.5

    @cached_property
    def V(self) -> Trig:
        """Potential energy: gravity, zero at the world's origin, and springs."""
        s = self.symbols
        return s.element(potential_energy(s.tree, s.q))

    def evaluate(self, quantity: Any, q: Any, qd: Any = None, qdd: Any = None) -> Array:
        """Numbers of one of the above at q, qd, qdd (..., n), with the model's parameter values."""
        arrays = [None if x is None else np.asarray(x, dtype=float) for x in (q, qd, qdd)]
        values = self.symbols.values(*arrays)
        batch = np.broadcast_shapes(*(x.shape[:-1] for x in arrays if x is not None))

        def number(x: Any) -> Any:
            if isinstance(x, Trig):
                return np.broadcast_to(x.evaluate(values), batch)
            return np.stack([number(entry) for entry in x], axis=len(batch))

        return number(quantity)


def _without_drives(tree: Any) -> Any:
    from dataclasses import replace

    return replace(tree, bodies=tuple(replace(body, drive=None) for body in tree.bodies))


def equations(model: Model, numbers: bool = False) -> Equations:
    """The closed-form equations of a model; `numbers` puts in the values of its parameters."""
    return Equations(symbols(model, numbers))
