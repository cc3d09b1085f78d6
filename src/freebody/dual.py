"""Scalars with derivatives: a value and its slopes along numbered directions, over any other
scalar.

Fed to an algorithm, a `Dual` over floats gives numbers, over traced scalars a program, of the
function's derivatives (forward mode). Slopes that are zero by structure are absent and cost
nothing.
"""

from __future__ import annotations

from typing import Any

from freebody.elementary import CHOOSES, FUNCTIONS, PARTIALS, Scalar, where

Slopes = dict[int, Scalar]


class Dual:
    """value + Σ slopes[k] ε_k, with ε_j ε_k = 0.

    Those of a higher level are made of those of a lower one, which they take for plain scalars, so
    that the two kinds of slopes are never mixed up where a function that differentiates is itself
    differentiated.
    """

    __slots__ = ("slopes", "value")
    __array_ufunc__ = None  # array * dual is ours
    level = 1

    def __init__(self, value: Scalar, slopes: Slopes):
        self.value = value
        self.slopes = slopes

    def _made_of(self, other: Any) -> bool:
        """Whether the other operand is a dual number of a higher level, which then does the
        operation."""
        return isinstance(other, Dual) and other.level > self.level

    def __add__(self, other: Any) -> Any:
        kind = type(self)
        if type(other) is kind:
            return kind(self.value + other.value, _sum(self.slopes, other.slopes))
        return NotImplemented if self._made_of(other) else kind(self.value + other, self.slopes)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __neg__(self) -> Any:
        return type(self)(-self.value, {k: -s for k, s in self.slopes.items()})

    def __mul__(self, other: Any) -> Any:
        kind = type(self)
        if type(other) is kind:
            return kind(
                self.value * other.value,
                _sum(_scaled(other.value, self.slopes), _scaled(self.value, other.slopes)),
            )
        return (
            NotImplemented
            if self._made_of(other)
            else kind(self.value * other, _scaled(other, self.slopes))
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        kind = type(self)
        if type(other) is kind:
            ratio = self.value / other.value
            inverse = 1.0 / other.value
            return kind(
                ratio,
                _sum(_scaled(inverse, self.slopes), _scaled(-(ratio * inverse), other.slopes)),
            )
        return (
            NotImplemented
            if self._made_of(other)
            else kind(self.value / other, _scaled(1.0 / other, self.slopes))
        )

    def __rtruediv__(self, other: Any) -> Any:
        ratio = other / self.value
        return type(self)(ratio, _scaled(-(ratio / self.value), self.slopes))

    def __pow__(self, exponent: Any) -> Any:
        kind = type(self)
        if exponent == 0:
            return kind(self.value**exponent, {})
        return kind(
            self.value**exponent, _scaled(exponent * self.value ** (exponent - 1), self.slopes)
        )

    def __bool__(self) -> bool:
        return bool(self.value)

    def __eq__(self, other: object) -> bool:
        return self.value == value(other, type(self))

    def __lt__(self, other: Any) -> bool:
        return self.value < value(other, type(self))

    def __le__(self, other: Any) -> bool:
        return self.value <= value(other, type(self))

    def __gt__(self, other: Any) -> bool:
        return self.value > value(other, type(self))

    def __ge__(self, other: Any) -> bool:
        return self.value >= value(other, type(self))

    __hash__ = None  # type: ignore[assignment]  # as Python has it where == is no equality

    def __abs__(self) -> Any:
        return self.elementary("absolute", (self,))

    def elementary(self, name: str, operands: tuple[Any, ...]) -> Any:
        """An elementary function and its slopes; a plain scalar where it is constant wherever it
        has a derivative."""
        kind = max((type(x) for x in operands if isinstance(x, Dual)), key=lambda kind: kind.level)
        values = [value(x, kind) for x in operands]
        result = FUNCTIONS[name](*values)
        if name in CHOOSES:
            return kind(result, _chosen(kind, CHOOSES[name](*values), *operands[-2:]))
        if name not in PARTIALS:
            return result
        total: Slopes = {}
        for x, partial in zip(operands, PARTIALS[name](result, *values), strict=True):
            if type(x) is kind:
                total = _sum(total, _scaled(partial, x.slopes))
        return kind(result, total)


class Outer(Dual):
    """A dual number of the outer level: slopes of a whole computation, in which `Dual` may be used
    itself."""

    __slots__ = ()
    level = 0


def slopes(x: Scalar, directions: int, kind: type[Dual] = Dual) -> list[Scalar]:
    """The slopes of a scalar along directions 0 to directions - 1, in their order."""
    known = x.slopes if type(x) is kind else {}
    return [known.get(k, 0.0) for k in range(directions)]


def value(x: Scalar, kind: type[Dual] = Dual) -> Scalar:
    """The scalar without its slopes."""
    return x.value if type(x) is kind else x


def _scaled(s: Scalar, by: Slopes) -> Slopes:
    if isinstance(s, float) and s == 0.0:
        return {}
    return {k: s * slope for k, slope in by.items()}


def _chosen(kind: type[Dual], condition: Scalar, a: Scalar, b: Scalar) -> Slopes:
    """The slopes of one of two scalars; chosen, not weighted: what is not chosen may be
    infinite."""
    of_a, of_b = (x.slopes if type(x) is kind else {} for x in (a, b))
    return {
        k: where(condition, of_a.get(k, 0.0), of_b.get(k, 0.0))
        for k in dict.fromkeys((*of_a, *of_b))
    }


def _sum(a: Slopes, b: Slopes) -> Slopes:
    if not a or not b:
        return a or b
    total = dict(a)
    for k, slope in b.items():
        total[k] = total[k] + slope if k in total else slope
    return total
