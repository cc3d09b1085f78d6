"""Functions given as formulas: values, Jacobians and time derivatives in closed form (notes,
1.1-1.9, 2.1-2.9)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats
from freebody.errors import FreebodyError, KindError, ShapeError, UnknownNameError
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.outputs.display import Titled
from freebody.scalars.composed import Composed, Factor, FactorPowers
from freebody_textbook.relations.formula import FormulaError, parse
from freebody_textbook.relations.formula_values import value


@dataclass(frozen=True, repr=False)
class VectorFunction(Titled):
    """y = f(x) of several variables (2.1); call it with numbers (..., n) for the values (...,
    m)."""

    rows: tuple[Composed, ...]
    """The entries, exact; Python's arithmetic and `freebody.math` take them."""
    names: tuple[str, ...]
    decimal: bool = False
    """Whether numbers print as decimals."""

    def _title(self) -> str:
        return f"Function of {', '.join(self.names)}: {self._entries()}"

    def _entries(self) -> str:
        return f"[{', '.join(map(str, self.expressions))}]"

    @property
    def expressions(self) -> tuple[Expression, ...]:
        """The function's entries as expressions for print."""
        return tuple(self.form(row) for row in self.rows)

    def form(self, x: Composed) -> Expression:
        """An exact function of these variables as expression for print."""
        return printed(x, self.decimal)

    @cached_property
    def jacobian(self) -> tuple[tuple[Composed, ...], ...]:
        """The Jacobian ∂y_i/∂x_j (2.6), exact, row by row."""
        return tuple(tuple(row.derivative(x) for x in self.names) for row in self.rows)

    @property
    def symbols(self) -> tuple[Composed, ...]:
        """The variables as exact functions."""
        return tuple(map(Composed.variable, self.names))

    def __call__(self, x: ArrayLike) -> Array:
        """Values (..., m) at x (..., n)."""
        return self._numbers(self.rows, x)

    def jacobian_at(self, x: ArrayLike) -> Array:
        """The Jacobian (..., m, n) in numbers at x (..., n)."""
        flat = self._numbers(tuple(entry for row in self.jacobian for entry in row), x)
        return flat.reshape(*flat.shape[:-1], len(self.rows), len(self.names))

    def _numbers(self, rows: Sequence[Composed], x: ArrayLike) -> Array:
        x = np.asarray(x, dtype=float)
        if not x.ndim or x.shape[-1] != len(self.names):
            raise ShapeError("VectorFunction", "x", x.shape, f"(..., {len(self.names)})")
        at = dict(zip(self.names, np.moveaxis(x, -1, 0), strict=True))
        columns = [np.broadcast_to(row.evaluate(at), x.shape[:-1]) for row in rows]
        return np.stack(columns, axis=-1)


@dataclass(frozen=True, repr=False)
class Trajectory(Titled):
    """The path of a point as a function of the time t, and its derivatives (1.1-1.3)."""

    position: VectorFunction

    def _title(self) -> str:
        return f"Trajectory: r = {self.position._entries()}"

    @cached_property
    def velocity(self) -> VectorFunction:
        """The velocity dr/dt (1.2)."""
        return self._derivative(1)

    @cached_property
    def acceleration(self) -> VectorFunction:
        """The acceleration d²r/dt² (1.3)."""
        return self._derivative(2)

    def _derivative(self, order: int) -> VectorFunction:
        rows = self.position.rows
        for _ in range(order):
            rows = tuple(row.derivative("t") for row in rows)
        return VectorFunction(rows, self.position.names, self.position.decimal)

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity, acceleration (..., dim) at the times t (...)."""
        time = np.asarray(t, dtype=float)[..., None]
        return self.position(time), self.velocity(time), self.acceleration(time)

    @property
    def values(self) -> Mapping[str, Any]:
        """The quantities r, r_d, r_dd and t by name, for `fb.relation`."""
        r = self.position
        return {
            "t": r.symbols[0],
            "r": r.rows,
            "r_d": self.velocity.rows,
            "r_dd": self.acceleration.rows,
        }


@dataclass(frozen=True, repr=False)
class SampledTrajectory(Titled):
    """The path of a point through samples, a quintic spline, with its derivatives."""

    spline: Any

    def _title(self) -> str:
        return f"Trajectory through samples, {self.spline.t[0]:.4g} to {self.spline.t[-1]:.4g} s"

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity, acceleration (..., dim) at the times t (...)."""
        times = np.asarray(t, dtype=float)
        r, v, a = (self.spline(times, nu=order) for order in range(3))
        return r, v, a


def sampled_trajectory(t: ArrayLike, points: ArrayLike) -> SampledTrajectory:
    """The quintic spline through points (k, dim) at the times t (k,), rising and at least six
    (1.1-1.3).

    Raises ShapeError, FreebodyError.
    """
    from scipy.interpolate import make_interp_spline

    times, places = (
        as_floats("sampled_trajectory", n, x) for n, x in (("t", t), ("points", points))
    )
    if times.ndim != 1 or places.ndim != 2 or len(places) != len(times):
        raise ShapeError(
            "sampled_trajectory", "points", places.shape, f"({times.size}, dim), one row per time"
        )
    if len(times) < 6 or not np.all(np.diff(times) > 0) or not np.isfinite(places).all():
        raise FreebodyError(
            "sampled_trajectory: give at least 6 samples, finite, at increasing times."
        )
    return SampledTrajectory(make_interp_spline(times, places, k=5))


def vector_function(rows: Sequence[str], names: Sequence[str]) -> VectorFunction:
    """A function of several variables from formulas: vector_function(["3*cos(a) + 2*cos(b)"], ["a",
    "b"]).

    Parameters
    ----------
    rows
        One formula for each entry, with sin, cos, tan, sqrt, exp, log.
    names
        The variables.

    Returns
    -------
    VectorFunction
        The exact function.

    Raises
    ------
    FreebodyError
        A formula that cannot be read.
    UnknownNameError
        A name that is not a variable.
    """
    for argument, given in (("rows", rows), ("names", names)):
        several = isinstance(given, Iterable) and not isinstance(given, str)
        if not several or not all(isinstance(x, str) for x in given):
            raise KindError("vector_function", argument, given, "a list of texts")
    parsed = [parse(row) for row in rows]
    for node in parsed:
        for part in ex.nodes(node):
            if isinstance(part, ex.Symbol) and part.name not in names:
                raise UnknownNameError("variable", part.name, "the function", names)
            if isinstance(part, ex.Vector | ex.Matrix | ex.Equation):
                raise FormulaError(f"{node}: a row is one scalar formula")
    decimal = any(
        isinstance(part, ex.Number) and part.decimal for node in parsed for part in ex.nodes(node)
    )
    at = {name: Composed.variable(name) for name in names}
    return VectorFunction(
        tuple(Composed.of(value(node, at)) for node in parsed), tuple(names), decimal
    )


def trajectory(*rows: str) -> Trajectory:
    """The path of a point, one formula in t for each coordinate: trajectory("5*cos(3.14*t)",
    "5*sin(3.14*t)")."""
    if not rows:
        raise FreebodyError("trajectory: give a formula in t for each coordinate.")
    return Trajectory(vector_function(rows, ("t",)))


def printed(x: Composed, decimal: bool) -> Expression:
    """An exact function as an expression, terms with highest powers first."""
    terms = sorted(x.terms, key=lambda m: (-_degree(m), str(_term(m, Fraction(1), decimal))))
    return ex.add(*(_term(m, x.terms[m], decimal) for m in terms))


def _degree(monomial: FactorPowers) -> int:
    return sum(exponent for factor, exponent in monomial if not factor.function)


def _term(monomial: FactorPowers, coefficient: Fraction, decimal: bool) -> Expression:
    above, below = (
        ex.mul(*(ex.power(_factor(f, decimal), s * e) for f, e in monomial if s * e > 0))
        for s in (1, -1)
    )
    return ex.mul(ex.num(coefficient, decimal), ex.div(above, below))


def _factor(factor: Factor, decimal: bool) -> Expression:
    if isinstance(factor.of, str):
        return sym(factor.of)
    inner = printed(factor.of, decimal)
    return inner if factor.function == "sum" else ex.Function(factor.function, inner)
