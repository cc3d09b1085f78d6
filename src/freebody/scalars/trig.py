"""Exact polynomials in sines, cosines, coordinates, rates and parameters, in a normal form: equal
means identical.

For each angle x the ring has generators sin x, cos x and x itself; s² is always written 1 - c².
Coefficients are rational; a float is read as its shortest decimal. The arithmetic is FLINT's.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from numbers import Rational
from typing import Any

import flint
import numpy as np

from freebody.errors import FreebodyError, UnknownNameError
from freebody.scalars.generators import sign_of, waves_of
from freebody.scalars.rational import exactly, rational_sin_cos

LARGEST = 2 * 10**8
"""The largest size of a polynomial: terms times generators, which is about the bytes that it
takes."""
_MOST_WORK = (
    2 * 10**9
)  # the same of a product before its terms are collected; FLINT aborts where memory ends


_MOST_TURNS = 100
"""The largest factor of an angle in a sine: its polynomial has half as many terms, each with a
number as long as the factor."""


class TrigRing:
    """The ring of one derivation: `angles` have sines and cosines, `others` (lengths, rates,
    parameters) do not."""

    def __init__(self, angles: Sequence[str], others: Sequence[str]):
        names = [*angles, *others]
        self.angles = tuple(angles)
        self.names = tuple(names)
        generators = [wave for x in angles for wave in waves_of(x)] + names
        twice = [name for name, times in Counter(generators).items() if times > 1]
        if twice:
            raise FreebodyError(
                f"the name {min(twice)!r} stands for two quantities; rename one parameter."
            )
        ascii_names = [name.encode("ascii", "backslashreplace").decode() for name in generators]
        self.context = flint.fmpq_mpoly_ctx.get(ascii_names, "lex")
        self.generators = self.context.gens()
        self.index = {name: i for i, name in enumerate(generators)}
        self.relations = [
            self.generators[2 * k] ** 2 + self.generators[2 * k + 1] ** 2 - 1
            for k in range(len(angles))
        ]
        self._constants: dict[Any, Any] = {}

    def __eq__(self, other: object) -> bool:
        """Whether two rings have the same generators, so that their polynomials can be compared and
        added."""
        return isinstance(other, TrigRing) and (self.angles, self.names) == (
            other.angles,
            other.names,
        )

    def __hash__(self) -> int:
        return hash((self.angles, self.names))

    def __reduce__(self) -> tuple[Any, ...]:
        return TrigRing, (self.angles, self.names[len(self.angles) :])

    def __getitem__(self, name: str) -> Trig:
        """The generator of a coordinate, rate or parameter."""
        if name not in self.index:
            raise UnknownNameError("symbol", name, "the derivation", self.names)
        return Trig(self, self.generators[self.index[name]], 0)

    def sin(self, name: str) -> Trig:
        """The generator sin(name)."""
        k = self.angles.index(name)
        return Trig(self, self.generators[2 * k], 1 << k)

    def cos(self, name: str) -> Trig:
        """The generator cos(name)."""
        return Trig(self, self.generators[2 * self.angles.index(name) + 1], 0)

    def constant(self, number: float | Rational) -> Any:
        """A number as polynomial of the ring."""
        found = self._constants.get(number)
        if found is None:
            found = self.context.constant(_flint(exactly(number)))
            self._constants[number] = found
        return found

    def polynomial(self, terms: Iterable[tuple[Mapping[str, int], Fraction]]) -> Trig:
        """The polynomial with given terms, {generator: exponent} and coefficient; the inverse of
        `Trig.terms`."""
        rows: dict[tuple[int, ...], Any] = {}
        for powers, coefficient in terms:
            exponents = [0] * len(self.index)
            for name, exponent in powers.items():
                exponents[self.index[name]] = exponent
            rows[tuple(exponents)] = rows.get(tuple(exponents), 0) + _flint(coefficient)
        mask = (1 << len(self.angles)) - 1
        return Trig(self, self.reduced(self.context.from_dict(rows), mask), mask)

    def product(self, a: Any, b: Any, mask: int) -> Any:
        """The normal form of a · b, in which sines of the angles in `mask` may stand squared.

        Raises FreebodyError where it would be too large to be worked out.
        """
        if len(a) * len(b) * len(self.generators) > _MOST_WORK:
            raise _too_large()
        poly = a * b
        if mask:
            poly = self.reduced(poly, mask)
        if len(poly) * len(self.generators) > LARGEST:
            raise _too_large()
        return poly

    def reduced(self, poly: Any, mask: int) -> Any:
        """The normal form of a polynomial whose sines of the angles in `mask` may stand squared."""
        k = 0
        while mask:
            if mask & 1:
                poly = poly % self.relations[k]
            mask >>= 1
            k += 1
        return poly


def _too_large() -> FreebodyError:
    return FreebodyError(
        "the closed form of this robot is too large to be worked out: its terms multiply with "
        "every joint. Derive it with fewer joints; for numbers use fb.inverse_dynamics and the "
        "other numerical functions, for robots of any size."
    )


def _flint(number: Fraction) -> Any:
    return flint.fmpq(number.numerator, number.denominator)


def _again(
    ring: TrigRing, terms: tuple[tuple[Mapping[str, int], Fraction], ...], mask: int
) -> Trig:
    """A polynomial rebuilt from a pickle."""
    return Trig(ring, ring.polynomial(terms).poly, mask)


class Trig:
    """A polynomial of a `TrigRing`, usable as a scalar in algorithms. `mask` marks the angles whose
    sine may occur."""

    __slots__ = ("mask", "poly", "ring")
    __array_ufunc__ = None

    def __init__(self, ring: TrigRing, poly: Any, mask: int):
        self.ring = ring
        self.poly = poly
        self.mask = mask

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.ring, tuple(self.terms()), self.mask)

    # ------------------------------------------------------------ arithmetic
    def __add__(self, other: Any) -> Trig:
        if isinstance(other, Trig):
            return Trig(self.ring, self.poly + other.poly, self.mask | other.mask)
        return (
            self
            if other == 0
            else Trig(self.ring, self.poly + self.ring.constant(other), self.mask)
        )

    __radd__ = __add__

    def __sub__(self, other: Any) -> Trig:
        if isinstance(other, Trig):
            return Trig(self.ring, self.poly - other.poly, self.mask | other.mask)
        return (
            self
            if other == 0
            else Trig(self.ring, self.poly - self.ring.constant(other), self.mask)
        )

    def __rsub__(self, other: Any) -> Trig:
        return -self + other

    def __neg__(self) -> Trig:
        return Trig(self.ring, -self.poly, self.mask)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Trig):
            poly = self.ring.product(self.poly, other.poly, self.mask & other.mask)
            return Trig(self.ring, poly, self.mask | other.mask)
        if other == 0:
            return 0.0
        return (
            self
            if other == 1
            else Trig(self.ring, self.poly * self.ring.constant(other), self.mask)
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Trig:
        if not isinstance(other, Trig):
            return self * (1 / exactly(other))
        if other.is_constant:
            return self * (1 / other.fraction)
        quotient, rest = divmod(self.poly, other.poly)
        if (
            rest != 0
            or self.ring.reduced(quotient * other.poly, (1 << len(self.ring.angles)) - 1)
            != self.poly
        ):
            raise FreebodyError(
                "a quotient of polynomials is not a polynomial: this quantity has no such closed "
                "form."
            )
        return Trig(self.ring, quotient, self.mask)

    def __rtruediv__(self, other: Any) -> Trig:
        return Trig(self.ring, self.ring.constant(other), 0) / self

    def __pow__(self, exponent: int) -> Any:
        if exponent < 0:
            raise FreebodyError(f"the power {exponent} of a polynomial is not a polynomial.")
        power: Any = 1.0
        for _ in range(exponent):
            power = self * power
        return power

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Trig):
            return self.ring == other.ring and self.poly == other.poly
        return isinstance(other, int | float | Fraction) and self.poly == self.ring.constant(other)

    def __hash__(self) -> int:
        return hash(
            self.fraction
            if self.is_constant
            else (self.poly.degrees(), self.leading_coefficient, len(self))
        )

    # ------------------------------------------------------------ angles
    def elementary(self, name: str, operands: tuple[Any, ...]) -> Trig:
        """The sine, cosine, sign or absolute value of a polynomial, where that is a polynomial
        again."""
        if name == "absolute":
            return self * self.sign()
        if name not in ("sin", "cos", "sign"):
            raise FreebodyError(
                f"{name} of {self}: closed forms are polynomials in sines and cosines. For "
                f"numbers, use a kernel."
            )
        return getattr(self, name)()

    def sin(self) -> Trig:
        """The sine of a polynomial that is a sum of angles and a constant."""
        return self._sin_cos[0]

    def cos(self) -> Trig:
        """The cosine of a polynomial that is a sum of angles and a constant."""
        return self._sin_cos[1]

    @property
    def _sin_cos(self) -> tuple[Any, Any]:
        s: Any = 0.0
        c: Any = 1.0
        for monomial, coefficient in self.poly.terms():
            exact = Fraction(int(coefficient.p), int(coefficient.q))
            if not any(monomial):
                a, b = rational_sin_cos(float(exact))
                s, c = s * b + c * a, c * b - s * a
                continue
            name = self._angle(monomial)
            if name is None or exact.denominator != 1:
                raise FreebodyError(
                    f"sin and cos need a sum of angles with whole factors, not {self}."
                )
            if abs(exact.numerator) > _MOST_TURNS:
                raise FreebodyError(
                    f"sin and cos of {exact.numerator} {name} have more terms than a closed form "
                    f"is worth; the largest factor of an angle is {_MOST_TURNS}."
                )
            a, b = self.ring.sin(name), self.ring.cos(name)
            for _ in range(abs(exact.numerator)):
                s, c = (
                    (s * b + c * a, c * b - s * a) if exact > 0 else (s * b - c * a, c * b + s * a)
                )
        return s, c

    def _angle(self, monomial: tuple[int, ...]) -> str | None:
        """The angle of a monomial that is an angle to the first power; None for others."""
        if sum(monomial) != 1:
            return None
        name = self.ring.names[monomial.index(1) - 2 * len(self.ring.angles)]
        return name if name in self.ring.angles else None

    def sign(self) -> Trig:
        """The sign of a multiple of a single rate: an opaque generator sgn_…, negated for a
        negative factor."""
        factor = self.leading_coefficient
        name = str(self.poly / _flint(factor)) if factor else "0"
        if sign_of(name) not in self.ring.index:
            raise FreebodyError(f"the sign of {self} has no symbol: friction acts on single rates.")
        sign = self.ring[sign_of(name)]
        return sign if factor > 0 else -sign

    # ------------------------------------------------------------ analysis
    @property
    def is_zero(self) -> bool:
        """Whether the polynomial is 0."""
        return self.poly == 0

    @property
    def is_constant(self) -> bool:
        """Whether the polynomial is a number."""
        return self.poly.is_constant()

    @property
    def fraction(self) -> Fraction:
        """The value of a constant polynomial."""
        if self.is_zero:
            return Fraction(0)
        ((_, coefficient),) = self.poly.terms()
        return Fraction(int(coefficient.p), int(coefficient.q))

    @property
    def leading_coefficient(self) -> Fraction:
        """The coefficient of the first term in the ring's order; 0 for the zero polynomial."""
        if self.is_zero:
            return Fraction(0)
        lead = self.poly.leading_coefficient()
        return Fraction(int(lead.p), int(lead.q))

    def terms(self) -> Iterable[tuple[dict[str, int], Fraction]]:
        """Monomials as {generator: exponent} with their coefficients."""
        names = list(self.ring.index)
        for monomial, coefficient in self.poly.terms():
            powers = {names[i]: int(e) for i, e in enumerate(monomial) if e}
            yield powers, Fraction(int(coefficient.p), int(coefficient.q))

    def __len__(self) -> int:
        """Number of terms of the polynomial."""
        return len(self.poly)

    def factors(self) -> list[tuple[Trig, int]]:
        """Irreducible factors with exponents, up to a constant; s² = 1 - c² is not used."""
        _, rows = self.poly.factor()
        return [(Trig(self.ring, factor, self.mask), int(exponent)) for factor, exponent in rows]

    def derivative(self, name: str) -> Trig:
        """The derivative ∂/∂name; for an angle by the chain rule through its sine and cosine."""
        index = self.ring.index[name]
        result = Trig(self.ring, self.poly.derivative(index), self.mask)
        if name not in self.ring.angles:
            return result
        k = self.ring.angles.index(name)
        s, c = self.ring.sin(name), self.ring.cos(name)
        by_s = Trig(self.ring, self.poly.derivative(2 * k), self.mask)
        by_c = Trig(self.ring, self.poly.derivative(2 * k + 1), self.mask)
        return result + (c * by_s - s * by_c)

    def along(self, rates: Mapping[str, Trig]) -> Trig:
        """The sum Σ ∂/∂name · rate, which is the time derivative if `rates` gives that of each
        variable."""
        total = Trig(self.ring, self.ring.constant(0), 0)
        for name, rate in rates.items():
            slope = self.derivative(name)
            if not slope.is_zero:
                total = total + slope * rate
        return total

    def evaluate(self, values: Mapping[str, Any]) -> Any:
        """The value for given numbers or arrays of coordinates, rates and parameters."""
        n = 2 * len(self.ring.angles)
        used = (
            [i for i, degree in enumerate(self.poly.degrees()) if degree > 0]
            if len(self.poly)
            else []
        )
        point = {}
        for i in used:
            name = self.ring.angles[i // 2] if i < n else self.ring.names[i - n]
            if name not in values:
                raise UnknownNameError("value", name, "the values given", values)
            x = np.asarray(values[name], dtype=float)
            point[i] = x if i >= n else (np.cos(x) if i % 2 else np.sin(x))
        total: Any = 0.0
        for monomial, coefficient in self.poly.terms():
            term: Any = int(coefficient.p) / int(coefficient.q)
            for i in used:
                for _ in range(monomial[i]):
                    term = term * point[i]
            total = total + term
        return total

    def __str__(self) -> str:
        return str(self.poly)

    __repr__ = __str__
