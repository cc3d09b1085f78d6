"""The closed form of a model's equations: its matrices and vectors as exact polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from freebody.algorithms.crba import crba
from freebody.algorithms.energy import potential_energy
from freebody.algorithms.rnea import friction_and_spring
from freebody.expressions.expression import size
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.expressions.polynomials.textbook_form import InTextbookForm
from freebody.lazy import cached_property
from freebody.model.tree import Tree
from freebody.scalars.trig import Trig
from freebody.values import ByValue
from freebody_textbook.equations import equation_views

SHORT = 700
"""Numbers and symbols that fit on about a page."""
MOST = 2000
"""Terms of M, c and g that will not fit whatever their form."""


@dataclass(frozen=True, eq=False)
class ClosedForm(InTextbookForm, ByValue):
    """Exact polynomials in normal form: equal means identical."""

    symbols: Symbols

    @cached_property
    def M(self) -> list[list[Trig]]:
        """Mass matrix, rotors included."""
        s = self.symbols
        rows = [s.of_angles([s.element(x) for x in row]) for row in crba(s.tree, s.q)]
        return [list(row) for row in zip(*map(s.of_angles, zip(*rows, strict=True)), strict=True)]

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

        table: list[list[list[Trig]]] = [
            [[self.symbols.zero()] * n for _ in range(n)] for _ in range(n)
        ]
        for i in range(n):
            for j in range(n):
                for k in range(j, n):
                    value = (dM(i, j, k) + dM(i, k, j) - dM(j, k, i)) * 0.5
                    table[i][j][k] = table[i][k][j] = value
        return table

    @cached_property
    def C(self) -> list[list[Trig]]:
        """Coriolis matrix of Christoffel symbols: C q̇ = c and Ṁ - 2C is skew-symmetric."""
        return [[self._along_rates(row) for row in plane] for plane in self.christoffel]

    @cached_property
    def c(self) -> list[Trig]:
        """Coriolis and centrifugal terms."""
        return [self._along_rates(row) for row in self.C]

    def _along_rates(self, row: Sequence[Trig]) -> Trig:
        return inner(row, self.symbols.own(RATE), self.symbols)

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
                total[k] = total[k] + body.coordinates.ratio * friction_and_spring(body, s.q, s.qd)
        return s.of_angles(total)

    @cached_property
    def tau(self) -> list[Trig]:
        """Joint torques M q̈ + c + g + friction and springs."""
        s = self.symbols
        parts = zip(self.M, self.c, self.g, self.drives, strict=True)
        qdd = s.own(SECOND)
        return [c + g + drive + inner(row, qdd, s) for row, c, g, drive in parts]

    @cached_property
    def T(self) -> Trig:
        """Kinetic energy ½ q̇ᵀ M q̇."""
        return self._along_rates(list(map(self._along_rates, self.M))) * 0.5

    @cached_property
    def V(self) -> Trig:
        """Potential energy: gravity, zero at the world's origin, and springs."""
        s = self.symbols
        return s.element(potential_energy(s.tree, s.q))

    # ------------------------------------------------------------ for the reader
    def count(self) -> dict[str, int]:
        """Number of terms of M (upper triangle), c and g, as exact polynomials."""
        return {
            "M": sum(len(x) for i, row in enumerate(self.M) for x in row[i:]),
            "c": sum(map(len, self.c)),
            "g": sum(map(len, self.g)),
        }

    @cached_property
    def is_vast(self) -> bool:
        """Whether the mass matrix alone is too long; looked at from the tip inward, before anything
        else is worked out.

        The rows and columns of a chain's last joints are the mass matrix of what they carry, the
        rest held still.
        """
        tree, terms = self.symbols.tree, 0
        for first in reversed(range(len(tree.bodies))):
            M = crba(_from_body(tree, first), self.symbols.q)
            terms = sum(len(x) for i, row in enumerate(M) for x in row[i:] if isinstance(x, Trig))
            if terms > MOST:
                return True
        return False

    @cached_property
    def is_short(self) -> bool:
        """Whether the named view fits on about a page."""
        if self.is_vast or sum(self.count().values()) > MOST:
            return False
        return (
            sum(size(line) for group in equation_views.named(self, self.layout) for line in group)
            <= SHORT
        )

    @property
    def length(self) -> str:
        """How many terms there are, in words; of what is vast only that."""
        if self.is_vast:
            return f"M alone has more than {MOST} terms"
        terms = self.count()
        return (
            f"M has {terms['M']} terms (mass matrix), c {terms['c']} (products of rates) and "
            f"g {terms['g']} (gravity)"
        )


def _from_body(tree: Tree, first: int) -> Tree:
    """The bodies from one on (whatever they carry is among them), each whose parent is left out
    held by the base."""
    bodies = (replace(body, parent=max(body.parent - first, -1)) for body in tree.bodies[first:])
    return replace(tree, bodies=tuple(bodies))


def _without_drives(tree: Tree) -> Tree:
    return replace(tree, bodies=tuple(replace(body, drive=None) for body in tree.bodies))
