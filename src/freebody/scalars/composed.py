"""Functions of variables in closed form: sums of products of powers, whose factors are variables
and elementary functions, with exact rational coefficients.

What a sum, product or derivative gives is brought to a form with like terms collected, and

    sin² u = 1 - cos² u,   (√u)² = u,   exp u exp v = exp(u + v),   sin(-u) = -sin u,
    cos(-u) = cos u.

A difference that becomes 0 so is 0. The converse holds for polynomials in the variables and in
sines and cosines of each; another difference may be 0 without becoming 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import reduce
from math import isqrt
from numbers import Rational
from typing import Any, NamedTuple

import numpy as np

from freebody.elementary import NUMERIC
from freebody.errors import FreebodyError, UnknownNameError
from freebody.lazy import cached_property
from freebody.scalars.rational import exactly

LARGEST = 300
"""Number of terms that a function may have."""


class Factor(NamedTuple):
    """A factor of a product: a variable ("", its name), a function of an argument, or ("sum", a
    sum) as a denominator."""

    function: str
    of: Any

    @property
    def key(self) -> tuple[Any, ...]:
        """The sort key of factors, in which variables come first."""
        return self.function, self.of if isinstance(self.of, str) else self.of.key


FactorPowers = tuple[tuple[Factor, int], ...]


def _written(power: tuple[Factor, int]) -> str:
    """A power of a factor as text in the form one types."""
    (function, of), exponent = power
    factor = of if not function else f"({of})" if function == "sum" else f"{function}({of})"
    return factor if exponent == 1 else f"{factor}^{exponent}"


class Composed:
    """A function of variables in closed form; a scalar for formulas and algorithms."""

    __array_ufunc__ = None

    def __init__(self, terms: Mapping[FactorPowers, Fraction]):
        if len(terms) > LARGEST:
            raise FreebodyError(f"the function has more than {LARGEST} terms.")
        self.terms = {m: c for m, c in terms.items() if c}

    @classmethod
    def variable(cls, name: str) -> Composed:
        """A variable as a function."""
        return cls({((Factor("", name), 1),): Fraction(1)})

    @classmethod
    def of(cls, x: Any) -> Composed:
        """A number as a function; a function unchanged."""
        return x if isinstance(x, cls) else cls({(): exactly(x)})

    # ------------------------------------------------------------ what it is
    @cached_property
    def key(self) -> tuple[Any, ...]:
        """A key that is equal for equal functions, with terms in an order that does not depend on
        how they were made."""
        return tuple(sorted((_key(monomial), c) for monomial, c in self.terms.items()))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Composed | Rational | float) and self.key == self.of(other).key

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        return (
            " + ".join("*".join([str(c), *map(_written, m)]) for m, c in self.terms.items()) or "0"
        )

    @property
    def is_zero(self) -> bool:
        """Whether the function is 0."""
        return not self.terms

    @property
    def number(self) -> Fraction | None:
        """The value of a constant function; None for other functions."""
        return self.terms.get((), Fraction(0)) if set(self.terms) <= {()} else None

    @cached_property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables that occur, sorted."""
        return tuple(sorted(set(self._names())))

    def _names(self) -> Iterator[str]:
        for monomial in self.terms:
            for factor, _ in monomial:
                yield from (factor.of,) if isinstance(factor.of, str) else factor.of.variables

    # ------------------------------------------------------------ arithmetic
    def __add__(self, other: Any) -> Composed:
        terms = dict(self.terms)
        for monomial, coefficient in self.of(other).terms.items():
            terms[monomial] = terms.get(monomial, Fraction(0)) + coefficient
        return Composed(terms)

    __radd__ = __add__

    def __neg__(self) -> Composed:
        return Composed({m: -c for m, c in self.terms.items()})

    def __sub__(self, other: Any) -> Composed:
        return self + -self.of(other)

    def __rsub__(self, other: Any) -> Composed:
        return -self + other

    def __mul__(self, other: Any) -> Composed:
        terms: dict[FactorPowers, Fraction] = {}
        for a, x in self.terms.items():
            for b, y in self.of(other).terms.items():
                for monomial, coefficient in _product(a, b, x * y).terms.items():
                    terms[monomial] = terms.get(monomial, Fraction(0)) + coefficient
        return Composed(terms)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Composed:
        return self * self.of(other) ** -1

    def __rtruediv__(self, other: Any) -> Composed:
        return self**-1 * other

    def __pow__(self, exponent: int) -> Composed:
        if self.is_zero and exponent < 0:
            raise FreebodyError("a function is divided by 0.")
        if len(self.terms) == 1:
            ((monomial, coefficient),) = self.terms.items()
            powers = tuple((factor, e * exponent) for factor, e in monomial)
            return _product(powers, (), coefficient**exponent)
        if exponent < 0:
            lead = self._leading
            return Composed({((Factor("sum", self * (1 / lead)), exponent),): lead**exponent})
        return reduce(lambda x, _: x * self, range(exponent), self.of(1))

    @property
    def _leading(self) -> Fraction:
        """The coefficient of the first term in a fixed order, by which multiples of a function
        compare."""
        return self.terms[min(self.terms, key=_key)]

    # ------------------------------------------------------------ functions
    def elementary(self, name: str, operands: tuple[Any, ...]) -> Composed:
        """An elementary function of one argument: sin, cos, sqrt, exp, log."""
        if name not in _DERIVATIVES:
            raise FreebodyError(
                f"{name} of a formula: closed forms have {', '.join(_DERIVATIVES)}."
            )
        x = self
        if x.number is not None and (name, x.number) in _KNOWN:
            return self.of(_KNOWN[name, x.number])
        if name == "sqrt" and x.number is not None:
            root = Fraction(isqrt(abs(x.number.numerator)), isqrt(x.number.denominator))
            if root * root == x.number:
                return self.of(root)
        sign = 1
        if name in ("sin", "cos") and x._leading < 0:
            x, sign = -x, (-1 if name == "sin" else 1)
        return Composed({((Factor(name, x), 1),): Fraction(sign)})

    def derivative(self, name: str) -> Composed:
        """Partial derivative of the function by a variable."""
        total = Composed({})
        for monomial, coefficient in self.terms.items():
            for k, (factor, exponent) in enumerate(monomial):
                if slope := _slope(factor, name):
                    rest = (*monomial[:k], *monomial[k + 1 :], (factor, exponent - 1))
                    total = total + _product(rest, (), coefficient * exponent) * slope
        return total

    def evaluate(self, values: Mapping[str, Any]) -> Any:
        """The value for given numbers or arrays of the variables."""
        total: Any = 0.0
        for monomial, coefficient in self.terms.items():
            term: Any = float(coefficient)
            for factor, exponent in monomial:
                term = term * _value(factor, values) ** exponent
            total = total + term
        return total


_DERIVATIVES: dict[str, Any] = {
    "sin": lambda u: _function("cos", u),
    "cos": lambda u: -_function("sin", u),
    "sqrt": lambda u: _function("sqrt", u) ** -1 * Fraction(1, 2),
    "exp": lambda u: _function("exp", u),
    "log": lambda u: u**-1,
}
"""The derivative of each function, by its argument."""

_KNOWN: dict[tuple[str, Any], int] = {
    ("sin", 0): 0,
    ("cos", 0): 1,
    ("exp", 0): 1,
    ("log", 1): 0,
}


def _function(name: str, u: Composed) -> Composed:
    return u.elementary(name, (u,))


def _slope(factor: Factor, name: str) -> Composed | None:
    """The derivative ∂factor/∂name; None where the factor does not depend on the variable."""
    if isinstance(factor.of, str):
        return Composed.of(1) if factor.of == name else None
    inner = factor.of.derivative(name)
    if inner.is_zero:
        return None
    return inner if factor.function == "sum" else _DERIVATIVES[factor.function](factor.of) * inner


def _value(factor: Factor, values: Mapping[str, Any]) -> Any:
    if isinstance(factor.of, str):
        if factor.of not in values:
            raise UnknownNameError("value", factor.of, "the values given", values)
        return np.asarray(values[factor.of], dtype=float)
    inner = np.asarray(factor.of.evaluate(values), dtype=float)
    return inner if factor.function == "sum" else NUMERIC[factor.function](inner)


def _key(monomial: FactorPowers) -> tuple[Any, ...]:
    return tuple((factor.key, exponent) for factor, exponent in monomial)


def _product(a: FactorPowers, b: FactorPowers, coefficient: Fraction) -> Composed:
    """The product coefficient · a · b in normal form."""
    exponents: dict[Factor, int] = {}
    growth = Composed({})
    for factor, exponent in (*a, *b):
        if factor.function == "exp":
            growth = growth + factor.of * exponent
        else:
            exponents[factor] = exponents.get(factor, 0) + exponent
    if not growth.is_zero:
        exponents[Factor("exp", growth)] = 1
    kept: dict[Factor, int] = {}
    others: list[Composed] = []
    for factor, exponent in exponents.items():
        whole, part = _folded(factor, exponent)
        kept[factor] = part
        others += [whole] if whole is not None else []
    monomial = tuple(sorted(((f, e) for f, e in kept.items() if e), key=lambda x: x[0].key))
    return reduce(lambda x, y: x * y, others, Composed({monomial: coefficient}))


def _folded(factor: Factor, exponent: int) -> tuple[Composed | None, int]:
    """The function into which a power of a factor is rewritten, and the exponent that is left: sin³
    is (1 - cos²) sin."""
    if factor.function == "sin" and exponent >= 2:
        c = _function("cos", factor.of)
        return (1 - c * c) ** (exponent // 2), exponent % 2
    if factor.function == "sqrt" and exponent not in (0, 1):
        return factor.of ** (exponent // 2), exponent % 2
    if factor.function == "sum" and exponent > 0:
        return factor.of**exponent, 0
    return None, exponent
