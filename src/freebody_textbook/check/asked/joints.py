"""Quantities in the equations of motion: torques, mass matrix, velocity terms and gravity."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from fractions import Fraction

from freebody.expressions import expression as ex
from freebody.expressions.evaluate import arithmetic, evaluate
from freebody.expressions.expression import Expression
from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.polynomials.arithmetic import determinant
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.group import (
    MOST_ROWS,
    NamedTarget,
    QuantityGroup,
    entries,
    inverse,
)
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations

_VECTORS = (kinds.GRAVITY, kinds.BIAS, kinds.VELOCITY)
"""Kinds of the terms of the equations of motion: where two have a letter the last has it."""
_MATRICES = (kinds.CORIOLIS, kinds.MASS)
_OTHER_H = "It has the sign of Spong's h here; the notes' is its negative."
_OF_CHRISTOFFEL = "It is the Christoffel symbol."
_OF_LAGRANGE = (
    "It is ∂H_ij/∂q_k − ½ ∂H_jk/∂q_i, as Lagrange's equation gives it; the Christoffel symbol has "
    "half of each order of the rates."
)
_AS_PRINTED = "It is the coefficient of the closed form, the negative of the Christoffel symbol."


class JointQuantities(QuantityGroup):
    """Quantities of the joints: τ_i, M_ij, C_ij, c_i, g_i, the whole vectors and matrices, and
    q."""

    def single(self) -> Iterator[NamedTarget]:
        yield from self._named

    @cached_property
    def _named(self) -> list[NamedTarget]:
        """The quantities with their names, made once so that a quantity is the same object in a
        vector and alone."""
        return list(self._made())

    def _made(self) -> Iterator[NamedTarget]:
        alone = self.count == 1
        for i in self.numbers:
            yield (
                self._torque_names(i),
                AskedQuantity(
                    kinds.TORQUE, (i,), self.entry("tau", i), i in self.passive, self.joint(i)
                ),
            )
            for kind in _VECTORS:
                letters = self.letters[kind.name]
                names = [f"{x}{i}" for x in letters] + ([*letters] if alone else [])
                yield (
                    tuple(names),
                    AskedQuantity(kind, (i,), self.entry(kind.name, i), False, self.joint(i)),
                )
            for j in self.numbers:
                for kind in _MATRICES:
                    names = [f"{x}{i}{j}" for x in self.letters[kind.name]]
                    names += ["M", "H", "m", "D"] if alone and kind.is_symmetric else []
                    yield tuple(names), AskedQuantity(kind, (i, j), self.entry(kind.name, i, j))
                letters = filter(str.isupper, self.letters["M"])
                rates = (x for letter in letters for x in spellings(letter, f"{i}{j}", 1))
                yield tuple(rates), self._rate_of_mass(i, j)
        yield from self._christoffel()
        if 1 < self.count <= MOST_ROWS:
            names = ("detM", "detH", "detD", "detB")
            yield names, AskedQuantity(kinds.MASS_DETERMINANT, (), self._determinant)
        yield from entries(dict.fromkeys(self._inverse_names, self._inverse))

    @cached_property
    def _inverse(self) -> QuantityTable:
        """The entries of M⁻¹, for robots with few joints."""
        if not 1 < self.count <= MOST_ROWS:
            return []
        rows = [[self.entry("M", i, j) for j in self.numbers] for i in self.numbers]
        return inverse(self.setting, rows, "the mass matrix")

    def _determinant(self) -> Trig:
        """The determinant of the mass matrix."""
        rows = [[self.entry("M", i, j)() for j in self.numbers] for i in self.numbers]
        return determinant(rows, self.setting.symbols)

    @property
    def _inverse_names(self) -> list[str]:
        return [x + INVERSE for x in self.letters["M"] if x.isupper()]

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        asked = {(target.kind, target.index): target for _, target in self._named}
        n = self.numbers
        found: dict[str, QuantityTable] = {}
        for kind in (kinds.TORQUE, *_VECTORS):
            letters = self.letters[kind.name]
            column = [[asked[kind, (i,)]] for i in n if letters]
            names = [x for x in letters if self.setting.system is None or x != "c"]
            found |= dict.fromkeys(names, column) if column else {}  # c of loops: Φ_q q̈ = c
        if self.letters["c"] and n:
            found["V"] = [
                [asked[kinds.VELOCITY, (i,)]] for i in n
            ]  # the potential energy is no vector
        for kind in _MATRICES:
            for letter in filter(str.isupper, self.letters[kind.name]):
                found[letter] = [[asked[kind, (i, j)] for j in n] for i in n]
        for letter in filter(str.isupper, self.letters["M"]):
            rates = [[self._rate_of_mass(i, j) for j in n] for i in n]
            found |= dict.fromkeys(spellings(letter, "", 1), rates)
        if self._inverse:
            found |= dict.fromkeys(self._inverse_names, self._inverse)
        return found | self._columns_of_coordinates()

    def _columns_of_coordinates(self) -> dict[str, QuantityTable]:
        """The vectors q, q̇ and q̈ by name, for robots with several joints."""
        found: dict[str, QuantityTable] = {}
        coordinates = self.setting.symbols.coordinates
        for dots, ending in enumerate(("", RATE, SECOND) if self.count > 1 else ()):
            column = [[self.coordinate(x + ending, k)] for k, x in enumerate(coordinates, 1)]
            for letter in ("q", "theta", "Theta"):
                found |= dict.fromkeys(spellings(letter, "", dots), column)
        return found

    def _torque_names(self, i: int) -> tuple[str, ...]:
        """Names of the torque of joint i: τ_i; τ if it is the only one; F for a driven sliding
        joint; u if there is one joint, or some are passive."""
        driven = [k for k in self.numbers if k not in self.passive]
        own = self.setting.symbols.coordinates[i - 1]
        others = [
            *["F", "f"] * (own[0] in "dxyz" and i not in self.passive),
            *["u"] * (self.setting.system is None and (bool(self.passive) or self.count == 1)),
        ]
        taken = {letter for letters in self.letters.values() for letter in letters}
        letters = [*self.letters["tau"], *(letter for letter in others if letter not in taken)]
        numbers = (str(i), "") if driven == [i] else (str(i),)
        along = (f"F{own}", f"f{own}") if own in ("x", "y", "z") and i not in self.passive else ()
        return (*(letter + number for number in numbers for letter in letters), *along)

    def _rate_of_mass(self, i: int, j: int) -> AskedQuantity:
        """The quantity that is an entry of Ṁ, the rate of the mass matrix."""
        entry, rates = self.entry("M", i, j), self.setting.symbols.rates
        words = f"entry {i}, {j} of the rate of the mass matrix"
        return AskedQuantity(kinds.MASS_RATE, (i, j), lambda: entry().along(rates), words=words)

    def _christoffel(self) -> Iterator[NamedTarget]:
        """Christoffel symbols with their names: Spong's c_ijk, C_kj = Σ_i c_ijk q̇_i, and Γ_ijk of
        Murray, Li and Sastry, C_ij = Σ_k Γ_ijk q̇_k; Γ_kji = c_ijk."""
        for i, j, k in itertools.product(self.numbers, repeat=3):
            target = AskedQuantity(
                kinds.CHRISTOFFEL, (k, j, i), lambda x=(k, j, i): _christoffel(self.setting, *x)
            )
            yield (f"c{i}{j}{k}", f"Gamma{k}{j}{i}"), target


def _slope(setting: RightEquations, i: int, j: int, k: int) -> Trig:
    """∂M_ij/∂q_k, joints counted from 1."""
    entry = setting.element(setting.all_of("M")[i - 1][j - 1])
    return entry.derivative(setting.symbols.coordinates[k - 1])


def _christoffel(setting: RightEquations, i: int, j: int, k: int) -> Trig:
    """The Christoffel symbol of row i and the rates j and k: ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j −
    ∂M_jk/∂q_i)."""
    slopes = _slope(setting, i, j, k) + _slope(setting, i, k, j) - _slope(setting, j, k, i)
    return slopes * Fraction(1, 2)


def _of_lagrange(setting: RightEquations, i: int, j: int, k: int) -> Trig:
    """∂M_ij/∂q_k − ½ ∂M_jk/∂q_i, whose sum over j and k with the rates is the velocity term too
    (Asada and Slotine, Robot analysis and control, 1986)."""
    return _slope(setting, i, j, k) - _slope(setting, j, k, i) * Fraction(1, 2)


class VelocityCoefficients(QuantityGroup):
    """The velocity coefficients for answers that use them: h of (3.25), and h_ijk, of which
    c_i = Σ h_ijk q̇_j q̇_k."""

    def single(self) -> Iterator[NamedTarget]:
        printed = dict(self._printed())
        for name, side in printed.items():
            if len(name) < len("h111"):
                yield (name,), self._coefficient(side)
        for i, j, k in itertools.product(self.numbers, repeat=3):
            name = f"h{i}{j}{k}"
            yield (name,), self._of_rates((i, j, k), printed.get(name))

    def _printed(self) -> Iterator[tuple[str, Expression]]:
        """The coefficients of the closed form as it is printed, by name."""
        if not self.setting.equations.is_short:
            return
        for group in self.setting.equations.groups("named"):
            for equation in group:
                symbol = equation.lhs
                if isinstance(symbol, ex.Symbol) and symbol.letter == "h":
                    yield symbol.name.replace("_", ""), equation.rhs

    def _of_rates(self, index: tuple[int, int, int], printed: Expression | None) -> AskedQuantity:
        """The coefficient h_ijk in each of the ways that books define it, or as it is printed."""
        setting = self.setting
        also = [(_OF_LAGRANGE, lambda: _of_lagrange(setting, *index))]
        if printed is not None:
            also.append((_AS_PRINTED, lambda: polynomial(setting, printed)))
        return AskedQuantity(
            kinds.COEFFICIENT_OF_RATES,
            index,
            lambda: _christoffel(setting, *index),
            note=_OF_CHRISTOFFEL,
            also=tuple(also),
        )

    def _coefficient(self, printed: Expression) -> AskedQuantity:
        """A velocity coefficient as quantity; some books define it with the opposite sign."""

        def value() -> Trig:
            return polynomial(self.setting, printed)

        return AskedQuantity(kinds.COEFFICIENT, (), value, also=((_OTHER_H, lambda: -value()),))


def polynomial(setting: RightEquations, node: Expression) -> Trig:
    """The polynomial of a printed expression."""
    rules = {
        **arithmetic(lambda number: setting.zero + number),
        ex.Symbol: lambda node, at: setting.image(node.name),
        ex.Function: lambda node, at: getattr(at(node.argument), node.name)(),
    }
    return evaluate(node, rules)
