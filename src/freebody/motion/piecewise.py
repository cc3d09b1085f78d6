"""Piecewise polynomial curves, and the exact places of their highest and lowest points."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, factorial, perm
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, PPoly, make_interp_spline

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.lazy import cached_property
from freebody.outputs.display import Tabled, TextTable, Titled, counted

Ends = Literal["rest", "natural", "periodic"]
Degree = Literal[3, 5]
_NEAR = 1e-12
"""Distance, as a part of the duration, at which two breaks are one."""
_REST = 1e-9
"""Movement, as a part of the largest excursion of all functions, of a function that is constant."""


@dataclass(frozen=True, eq=False, repr=False)
class PiecewisePolynomial(Titled, ByValue):
    """n functions of one variable t, polynomials between breaks.

    breaks: (m + 1,) increasing. coefficients: (degree + 1, m, n), of powers of t - breaks[i],
    highest first. At a break where a derivative jumps its value is that of the piece that begins
    there.
    """

    breaks: Array
    coefficients: Array

    def _title(self) -> str:
        count, pieces, functions = self.coefficients.shape
        return (
            f"PiecewisePolynomial: {counted(functions, 'function')} of degree {count - 1}, "
            f"{counted(pieces, 'piece')} from {self.breaks[0]:.4g} to {self.breaks[-1]:.4g}"
        )

    def resting(self) -> PiecewisePolynomial:
        """The curve with functions that move by no more than rounding made constant: a joint with a
        rate of 1e-15 would feel the whole dry friction."""
        lengths = np.diff(self.breaks)[:, None]
        starts = self.coefficients[-1]
        way = np.zeros_like(starts)
        for power in self.coefficients[:-1]:  # how far each piece comes at most, by Horner
            way = (way + np.abs(power)) * lengths
        most = way.max(axis=0)
        excursion = most + np.abs(starts - starts[0]).max(axis=0)
        still = (excursion <= _REST * excursion.max(initial=0.0)) & (most > 0.0)
        if not still.any():
            return self
        coefficients = self.coefficients.copy()
        coefficients[:-1, :, still] = 0.0
        coefficients[-1, :, still] = starts[0, still][:, None]
        return PiecewisePolynomial(self.breaks, coefficients)

    @cached_property
    def _pieces(self) -> PPoly:
        return PPoly(np.array(self.coefficients), np.array(self.breaks))

    def __call__(self, t: ArrayLike) -> Array:
        """Values (..., n) of the piecewise polynomial at times t (...)."""
        return self._pieces(t)

    def before(self, t: Array) -> Array:
        """Values (..., n) at t (...), at breaks those of the piece that ends there."""
        return self._of(np.searchsorted(self.breaks, t, side="left") - 1, t)

    def continued(self, t: Array, around: Array) -> Array:
        """Values (..., n) at t (...) of the pieces at other times `around` (...), continued beyond
        their ends."""
        return self._of(np.searchsorted(self.breaks, around, side="right") - 1, t)

    def _of(self, piece: Any, t: Array) -> Array:
        """Values of the pieces with given indices at times t."""
        piece = np.clip(piece, 0, len(self.breaks) - 2)
        return _polynomials(self.coefficients[:, piece], (t - self.breaks[piece])[..., None])

    def derivative(self, order: int = 1) -> PiecewisePolynomial:
        """The derivative with respect to t, of any order."""
        left = len(self.coefficients) - order
        if left <= 0:
            return PiecewisePolynomial(self.breaks, np.zeros((1, *self.coefficients.shape[1:])))
        factors = np.array([float(perm(k, order)) for k in range(left + order - 1, order - 1, -1)])
        return PiecewisePolynomial(self.breaks, self.coefficients[:left] * factors[:, None, None])

    @property
    def at_breaks(self) -> Array:
        """Values (m + 1, n) at the breaks."""
        end = _polynomials(self.coefficients[:, -1:], self.breaks[-1] - self.breaks[-2])
        return np.concatenate([self.coefficients[-1], end])

    @property
    def at_ends(self) -> Array:
        """Values (m, n) of each piece at its end."""
        return _polynomials(self.coefficients, np.diff(self.breaks)[:, None])

    def scaled(self, factor: float) -> PiecewisePolynomial:
        """The curve run `factor` times as fast from the same start."""
        start, degree = self.breaks[0], len(self.coefficients) - 1
        powers = factor ** np.arange(degree, -1, -1.0)
        return PiecewisePolynomial(
            start + (self.breaks - start) / factor, self.coefficients * powers[:, None, None]
        )

    def then(self, other: PiecewisePolynomial) -> PiecewisePolynomial:
        """This curve continued by the other, which begins where this one ends in t."""
        degree = max(len(self.coefficients), len(other.coefficients))
        both = [
            np.pad(x, ((degree - len(x), 0), (0, 0), (0, 0)))
            for x in (self.coefficients, other.coefficients)
        ]
        later = self.breaks[-1] + (other.breaks[1:] - other.breaks[0])
        return PiecewisePolynomial(
            np.concatenate([self.breaks, later]), np.concatenate(both, axis=1)
        )

    @cached_property
    def extremes(self) -> Extremes:
        """The lowest and highest values of each function, also between breaks, with their
        places."""
        low, low_at = _lowest(self)
        high, high_at = _lowest(PiecewisePolynomial(self.breaks, -self.coefficients))
        return Extremes(low, low_at, 0.0 - high, high_at)


def _polynomials(coefficients: Array, u: Any) -> Array:
    """Values of polynomials in u with coefficients (degree + 1, ..., n), highest power first."""
    value = coefficients[0] + 0.0 * u
    for c in coefficients[1:]:
        value = value * u + c
    return value


@dataclass(frozen=True, eq=False, repr=False)
class Extremes(Tabled, ByValue):
    """Lowest and highest values of n functions, and the first places where they occur; (n,)
    each."""

    low: Array
    low_at: Array
    high: Array
    high_at: Array

    def _title(self) -> str:
        return f"Extremes of {counted(len(self.low), 'function')}"

    def _table(self) -> TextTable:
        entries = zip(self.low, self.low_at, self.high, self.high_at, strict=True)
        rows = [(str(k), *(f"{x:.4g}" for x in entry)) for k, entry in enumerate(entries)]
        return TextTable(("", "lowest", "at", "highest", "at"), rows)

    @property
    def size(self) -> Array:
        """Largest absolute values (n,)."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def size_at(self) -> Array:
        """Times (n,) of the largest absolute values."""
        return np.where(np.abs(self.low) > np.abs(self.high), self.low_at, self.high_at)


def interpolated(
    breaks: Array, points: Array, degree: Degree = 5, ends: Ends = "rest"
) -> PiecewisePolynomial:
    """The spline of degree 3 (continuous second derivative) or 5 (continuous fourth) through points
    (k, n) at breaks (k,), k > 1.

    ends: "rest", first derivative zero at both, of degree 5 the second too; "natural", the free
    ends of an elastic ruler: second derivative zero, of degree 5 the third and fourth; "periodic",
    begun again as it ends, where the first point is the last.
    """
    k = (degree - 1) // 2
    orders = range(1, k + 1) if ends == "rest" else range(k + 1, degree)
    fixed = [(order, np.zeros(points.shape[1])) for order in orders]
    conditions = "periodic" if ends == "periodic" else (fixed, fixed)
    spline = make_interp_spline(breaks, points, k=degree, bc_type=conditions)
    return of_spline(spline)


def of_spline(spline: BSpline) -> PiecewisePolynomial:
    """A spline of n functions as a piecewise polynomial between its knots."""
    degree = spline.k
    knots = np.unique(spline.t[degree:-degree])
    powers = [spline(knots[:-1], j) / factorial(j) for j in range(degree, -1, -1)]
    return PiecewisePolynomial(knots, np.stack(powers))


def hermite(
    t: Array, x: Array, xd: Array, xdd: Array, before: Array | None = None
) -> PiecewisePolynomial:
    """The quintic in each interval of t (T,) with value, rate and acceleration (T, n) given at its
    ends; before: the accelerations (T, n) just before each time, where they jump."""
    h = np.diff(t)[:, None]
    x0, v0, a0 = x[:-1], xd[:-1] * h, xdd[:-1] * h**2 / 2
    rest = x[1:] - x0 - v0 - a0
    slope = xd[1:] * h - v0 - 2 * a0
    bend = (xdd if before is None else before)[1:] * h**2 / 2 - a0
    c3 = 10 * rest - 4 * slope + bend
    c4 = -15 * rest + 7 * slope - 2 * bend
    c5 = 6 * rest - 3 * slope + bend
    powers = [c5 / h**5, c4 / h**4, c3 / h**3, a0 / h**2, v0 / h, x0]
    return PiecewisePolynomial(t, np.stack(powers))


def side_by_side(curves: list[PiecewisePolynomial]) -> PiecewisePolynomial:
    """Curves that begin and end together as one curve with the breaks of all."""
    every = np.unique(np.concatenate([curve.breaks for curve in curves]))
    apart = np.diff(every, append=np.inf) > _NEAR * (every[-1] - every[0])
    breaks = every[apart]
    breaks[0], breaks[-1] = curves[0].breaks[0], curves[0].breaks[-1]
    middle = 0.5 * (breaks[:-1] + breaks[1:])
    degree = max(len(curve.coefficients) for curve in curves) - 1
    columns = []
    for curve in curves:
        own = len(curve.coefficients) - 1
        piece = np.clip(
            np.searchsorted(curve.breaks, middle, side="right") - 1, 0, len(curve.breaks) - 2
        )
        c, shift = curve.coefficients[:, piece], (breaks[:-1] - curve.breaks[piece])[:, None]
        moved = np.zeros((degree + 1, *c.shape[1:]))
        for j in range(own + 1):  # Taylor's coefficients about the new breaks
            moved[degree - j] = sum(
                comb(i, j) * c[own - i] * shift ** (i - j) for i in range(j, own + 1)
            )
        columns.append(moved)
    return PiecewisePolynomial(breaks, np.concatenate(columns, axis=-1))


def _lowest(curve: PiecewisePolynomial) -> tuple[Array, Array]:
    """The lowest values of a curve's functions and their places, (n,) each.

    A polynomial lies above the lowest of its Bernstein coefficients: only pieces in which these
    promise less than the ends of all pieces are searched for roots of the derivative.
    """
    h, c = np.diff(curve.breaks), curve.coefficients
    degree = len(c) - 1
    unit = c[::-1] * h[:, None] ** np.arange(degree + 1.0)[:, None, None]  # of powers of u = t / h
    bernstein = np.stack(
        [
            sum(comb(i, j) / comb(degree, j) * unit[j] for j in range(i + 1))
            for i in range(degree + 1)
        ]
    )
    ends = np.concatenate([bernstein[0], bernstein[-1]])
    first = np.argmin(ends, axis=0)
    low = np.take_along_axis(ends, first[None], axis=0)[0]
    at = np.concatenate([curve.breaks[:-1], curve.breaks[1:]])[first]
    for piece, n in np.argwhere(bernstein.min(axis=0) < low):
        p = np.polynomial.Polynomial(unit[:, piece, n])
        roots = p.deriv().roots()
        u = np.clip(roots.real[np.abs(roots.imag) < 1e-6], 0.0, 1.0)
        values = p(u)
        if len(u) and values.min() < low[n]:
            low[n] = values.min()
            at[n] = curve.breaks[piece] + h[piece] * u[np.argmin(values)]
    return low, at
