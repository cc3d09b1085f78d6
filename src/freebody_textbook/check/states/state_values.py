"""Values of polynomials and expressions at many states at once, with the sizes of their terms, to
distinguish differences from rounding."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from freebody.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.expressions.nodes import Arguments, Expression, Function, nodes
from freebody.lazy import cached_property
from freebody.scalars.generators import function_of, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Named, Value, Wave, pair
from freebody_textbook.closed_chains.linear_equations import Ratio

EQUAL = 1e-9
"""The share of a number's terms below which a difference counts as rounding: right equations need
1.5e-13 at regular states."""
_STEEPEST = 100.0
"""Slope of a function up to which it counts: arccos and roots are infinitely steep somewhere, but
rounding changes them by some 1e-8 at most."""

AnyArray = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, eq=False)
class Running:
    """Numbers with error bounds. value: the numbers; size: how much they change if all their inputs
    change by their own sizes."""

    value: Any
    size: Any

    @staticmethod
    def exact(x: Any) -> Running:
        """Running values of numbers that have no rounding error yet."""
        return Running(x, np.abs(x))

    def __add__(self, other: Running) -> Running:
        return Running(self.value + other.value, self.size + other.size)

    def __sub__(self, other: Running) -> Running:
        return Running(self.value - other.value, self.size + other.size)

    def __neg__(self) -> Running:
        return Running(-self.value, self.size)

    def __mul__(self, other: Running) -> Running:
        size = np.abs(self.value) * other.size + np.abs(other.value) * self.size
        return Running(self.value * other.value, size)

    def __truediv__(self, other: Running) -> Running:
        """Quotient of running values; NaN where the divisor is 0 up to rounding."""
        value = self.value / np.where(other.vanishes, np.nan, other.value)
        return Running(value, (self.size + np.abs(value) * other.size) / np.abs(other.value))

    def __pow__(self, exponent: int) -> Running:
        if exponent < 0:
            return Running.exact(np.ones_like(self.value)) / self**-exponent
        below = np.asarray(self.value, float) ** max(exponent - 1, 0)
        return Running(self.value**exponent, exponent * np.abs(below) * self.size)

    def by(self, value: Any, slope: Any) -> Running:
        """A function of running values, given its value and derivative."""
        return Running(value, np.minimum(np.abs(slope), _STEEPEST) * self.size + np.abs(value))

    @property
    def vanishes(self) -> AnyArray:
        """Whether each number is 0 up to rounding; False for NaN."""
        known = np.isfinite(self.value) & np.isfinite(self.size)
        return known & (np.abs(self.value) <= EQUAL * self.size)

    @property
    def worst(self) -> int:
        """The index of the number farthest from 0 relative to its size, ignoring NaN."""
        with np.errstate(invalid="ignore"):
            share = np.abs(self.value) / np.maximum(self.size, 1e-300)
        return int(np.argmax(np.where(np.isfinite(share), share, -1.0)))


_OF_GENERATORS = {"sin": np.sin, "cos": np.cos, "sgn": np.sign}
"""Functions by the names that generators of a ring have."""
MOST_BRANCHES = 5
"""Functions of several values in one answer."""
_AT_ONCE = 2000
"""Terms of a polynomial that are multiplied at once."""

Choice = Mapping[Expression, int]
"""Functions that have two values, with 1 for those whose second one is taken."""
Known = Mapping[Expression, Running]
"""Values that need not be worked out."""


def _principal_sqrt(x: Running) -> Running:
    root = np.sqrt(x.value)
    return x.by(root, 0.5 / root)


def _arccos(x: Running) -> Running:
    return x.by(np.arccos(x.value), 1 / np.sqrt(1 - x.value**2))


def _arcsin(x: Running) -> Running:
    return x.by(np.arcsin(x.value), 1 / np.sqrt(1 - x.value**2))


def _arctan(x: Running) -> Running:
    return x.by(np.arctan(x.value), 1 / (1 + x.value**2))


_OF_ONE_VALUE: Mapping[str, Callable[[Running], Running]] = {
    "sin": lambda x: x.by(np.sin(x.value), np.cos(x.value)),
    "cos": lambda x: x.by(np.cos(x.value), np.sin(x.value)),
    "tan": lambda x: x.by(np.tan(x.value), 1 / np.cos(x.value) ** 2),
    "abs": lambda x: x.by(np.abs(x.value), 1.0),
}
"""Functions of one value; sines and cosines of what is no whole multiple of an angle."""
_HALF_TURN = Running(np.pi, np.pi)
_FUNCTIONS: Mapping[str, tuple[Callable[[Running], Running], Callable[[Running], Running]]] = {
    "sqrt": (_principal_sqrt, lambda y: -y),
    "arccos": (_arccos, lambda y: -y),
    "arcsin": (_arcsin, lambda y: _HALF_TURN - y),
    "arctan": (_arctan, lambda y: y + _HALF_TURN),
}
"""A function's value and its second value by the first, by name of the function."""


@dataclass(frozen=True, eq=False)
class Polynomials:
    """Several polynomials prepared for evaluation at many states."""

    polynomials: Sequence[Trig]

    @cached_property
    def _terms(self) -> list[tuple[int, Mapping[str, int], Fraction]]:
        return [(i, *term) for i, x in enumerate(self.polynomials) for term in x.terms()]

    @cached_property
    def _powers(self) -> dict[tuple[str, int], int]:
        """Powers of generators, numbered from 1."""
        rows = {row for _, powers, _ in self._terms for row in powers.items()}
        return {row: k for k, row in enumerate(sorted(rows), 1)}

    @cached_property
    def _factors(self) -> AnyArray:
        """Numbers of the powers in each term, padded with 0."""
        at = np.zeros((len(self._terms), max((len(x[1]) for x in self._terms), default=0)), int)
        for row, (_, powers, _) in zip(at, self._terms, strict=True):
            row[: len(powers)] = [self._powers[x] for x in powers.items()]
        return at

    @cached_property
    def _coefficients(self) -> AnyArray:
        return np.array([[float(c)] for *_, c in self._terms])

    def at(self, states: StateValues) -> list[Running]:
        """Values of the polynomials at states; sizes are those of their terms."""
        table = np.ones((len(self._powers) + 1, states.count))
        for row, k in self._powers.items():
            table[k] = states.power(*row)
        value = np.zeros((len(self.polynomials), states.count))
        size, owners = np.zeros_like(value), np.array([i for i, *_ in self._terms], int)
        for first in range(0, len(self._terms), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            product = self._coefficients[some]
            for column in self._factors[some].T:
                product = product * table[column]
            np.add.at(value, owners[some], product)
            np.add.at(size, owners[some], np.abs(product))
        return list(map(Running, value, size))


@dataclass(frozen=True, eq=False)
class StateValues:
    """The values of a ring's names at several states, without sines, cosines and signs, which are
    computed."""

    values: Mapping[str, AnyArray]

    @property
    def count(self) -> int:
        """The number of states."""
        return len(next(iter(self.values.values())))

    @cached_property
    def _kept(self) -> dict[int, tuple[Trig, Running]]:
        return {}

    @cached_property
    def _powers(self) -> dict[tuple[str, int], AnyArray]:
        return {}

    def of(self, x: Value) -> Running:
        """The values of a polynomial or a quotient of two."""
        above, below = pair(x)
        found = self.polynomial(above)
        return found / self.polynomial(below) if isinstance(x, Ratio) else found

    def polynomial(self, x: Trig) -> Running:
        """The values of a polynomial, with the sizes of its terms."""
        kept = self._kept.get(id(x))
        if kept is None:
            kept = self._kept[id(x)] = x, Polynomials([x]).at(self)[0]
        return kept[1]

    def power(self, name: str, exponent: int) -> AnyArray:
        """The values of a power of a generator."""
        if (name, exponent) not in self._powers:
            self._powers[name, exponent] = self.generator(name) ** exponent
        return self._powers[name, exponent]

    def generator(self, name: str) -> AnyArray:
        """The values of a generator of the ring."""
        function, symbol = function_of(name), symbol_of(name)
        if not function or symbol not in self.values:
            return self.values[name]
        return _OF_GENERATORS[function](self.values[symbol])

    def at(self, node: Expression, choice: Choice, known: Known | None = None) -> Running:
        """The values of an expression, with the chosen branches of its functions; known: values of
        some nodes."""

        def wave(node: Wave, at: object) -> Running:
            angle = float(node.turn) + sum(k * self.values[name] for name, k in node.angle)
            value = getattr(np, node.function)(angle)
            return Running(value + np.zeros(self.count), np.ones(self.count))

        def function(node: Function, at: Callable[[Expression], Any]) -> Running:
            if node.name == "atan2":
                y, x = at(node.argument)
                value, far = np.arctan2(y.value, x.value), np.hypot(x.value, y.value)
                return Running(value, (x.size + y.size) / far + np.abs(value))
            if node.name in _OF_ONE_VALUE:
                return _OF_ONE_VALUE[node.name](at(node.argument))
            first, second = _FUNCTIONS[node.name]
            found = first(at(node.argument))
            return second(found) if choice.get(node, 0) else found

        rules: Rules = {
            **arithmetic(lambda x: Running.exact(np.full(self.count, float(x)))),
            Named: lambda node, at: self.of(node.value),
            Wave: wave,
            Arguments: lambda node, at: tuple(map(at, node.entries)),
            Function: function,
        }
        with np.errstate(all="ignore"):  # a root of a negative number is told by `vanishes`
            return evaluate(node, rules, known)

    def pieces(self, node: Expression) -> dict[Expression, Running]:
        """The values of all subexpressions without functions."""
        found: dict[Expression, Running] = {}
        for part in reversed(list(nodes(node))):
            if not isinstance(part, Arguments) and not functions_of(part):
                found[part] = self.at(part, {}, found)
        return found


def functions_of(node: Expression) -> list[Function]:
    """All functions in an expression."""
    return [x for x in nodes(node) if isinstance(x, Function)]


def of_several_values(node: Expression) -> list[Function]:
    """The functions in an expression that have two values to be tried, such as arccos."""
    return [x for x in functions_of(node) if x.name in _FUNCTIONS]


def choices(node: Expression) -> Sequence[Choice]:
    """Choices of function values: first the functions as they stand, then those with fewest second
    values."""
    several = of_several_values(node)
    every = itertools.product((0, 1), repeat=len(several))
    return [dict(zip(several, chosen, strict=True)) for chosen in sorted(every, key=sum)]


def second_values(choice: Choice) -> Iterator[str]:
    """Names of the functions whose second value is chosen."""
    for node, is_second in choice.items():
        if is_second and isinstance(node, Function):
            yield node.name
