"""Functions given as formulas: values, Jacobians and time derivatives in closed form (notes,
1.1-1.9, 2.1-2.9).

SymPy differentiates; it is imported when a function is made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats
from freebody.derivations import expression as ex
from freebody.derivations.expression import Expression
from freebody.derivations.formula import FormulaError, parse
from freebody.derivations.names import sym
from freebody.derivations.render.sympy import to_sympy
from freebody.errors import FreebodyError, ShapeError, UnknownNameError
from freebody.lazy import cached_property
from freebody.outputs.display import Titled


@dataclass(frozen=True)
class VectorFunction:
    """y = f(x) of several variables (2.1); call it with numbers (..., n) for the values (...,
    m)."""

    rows: tuple[Any, ...]
    """SymPy expressions."""
    names: tuple[str, ...]
    decimal: bool = False
    """Whether numbers print as decimals."""

    @property
    def expressions(self) -> tuple[Expression, ...]:
        """The entries as they are printed."""
        return tuple(self.form(row) for row in self.rows)

    def form(self, x: Any) -> Expression:
        """A SymPy expression in these variables as it is printed."""
        return printed(x, self.decimal)

    @cached_property
    def jacobian(self) -> tuple[tuple[Any, ...], ...]:
        """∂y_i/∂x_j (2.6) as rows of SymPy expressions."""
        return tuple(tuple(row.diff(x) for x in self.symbols) for row in self.rows)

    @cached_property
    def symbols(self) -> tuple[Any, ...]:
        """The variables as SymPy's symbols."""
        import sympy

        return tuple(sympy.Symbol(name, real=True) for name in self.names)

    def __call__(self, x: ArrayLike) -> Array:
        """Values (..., m) at x (..., n)."""
        return self._numbers(self.rows, x)

    def jacobian_at(self, x: ArrayLike) -> Array:
        """The Jacobian (..., m, n) in numbers at x (..., n)."""
        flat = self._numbers(tuple(entry for row in self.jacobian for entry in row), x)
        return flat.reshape(*flat.shape[:-1], len(self.rows), len(self.names))

    def _numbers(self, rows: Sequence[Any], x: ArrayLike) -> Array:
        import sympy

        x = np.asarray(x, dtype=float)
        if not x.ndim or x.shape[-1] != len(self.names):
            raise ShapeError("VectorFunction", "x", x.shape, f"(..., {len(self.names)})")
        columns = sympy.lambdify(self.symbols, list(rows), "numpy", dummify=True)(
            *np.moveaxis(x, -1, 0)
        )
        return np.stack(
            [np.broadcast_to(np.asarray(c, dtype=float), x.shape[:-1]) for c in columns], axis=-1
        )


@dataclass(frozen=True)
class Trajectory:
    """The path of a point as a function of the time t, and its derivatives (1.1-1.3)."""

    position: VectorFunction

    @cached_property
    def velocity(self) -> VectorFunction:
        """dr/dt (1.2)."""
        return self._derivative(1)

    @cached_property
    def acceleration(self) -> VectorFunction:
        """d²r/dt² (1.3)."""
        return self._derivative(2)

    def _derivative(self, order: int) -> VectorFunction:
        r = self.position
        return VectorFunction(
            tuple(x.diff(r.symbols[0], order) for x in r.rows), r.names, r.decimal
        )

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity, acceleration (..., dim) at the times t (...)."""
        time = np.asarray(t, dtype=float)[..., None]
        return self.position(time), self.velocity(time), self.acceleration(time)

    @property
    def values(self) -> Mapping[str, Any]:
        """r, r_d, r_dd and t by name, for `fb.relation`."""
        r = self.position
        return {
            "t": r.symbols[0],
            "r": r.rows,
            "r_d": self.velocity.rows,
            "r_dd": self.acceleration.rows,
        }


@dataclass(frozen=True, repr=False)
class SampledTrajectory(Titled):
    """The path of a point through samples, a spline of the fifth degree, and its derivatives."""

    spline: Any

    def _title(self) -> str:
        return f"Trajectory through samples, {self.spline.t[0]:.4g} to {self.spline.t[-1]:.4g} s"

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity, acceleration (..., dim) at the times t (...)."""
        times = np.asarray(t, dtype=float)
        r, v, a = (self.spline(times, nu=order) for order in range(3))
        return r, v, a


def sampled_trajectory(t: ArrayLike, points: ArrayLike) -> SampledTrajectory:
    """The path through points (k, dim) at the times t (k,), rising and at least six of them
    (1.1-1.3).

    Raises ShapeError, FreebodyError.
    """
    from scipy.interpolate import make_interp_spline

    times, places = (
        as_floats("sampled_trajectory", n, x) for n, x in (("t", t), ("points", points))
    )
    if times.ndim != 1 or places.ndim != 2 or len(places) != len(times):
        raise ShapeError(
            "sampled_trajectory", "points", places.shape, f"({times.size}, dim), one row a time"
        )
    if len(times) < 6 or not np.all(np.diff(times) > 0) or not np.isfinite(places).all():
        raise FreebodyError("sampled_trajectory: give at least 6 samples, finite, at rising times.")
    return SampledTrajectory(make_interp_spline(times, places, k=5))


def vector_function(rows: Sequence[str], names: Sequence[str]) -> VectorFunction:
    """A function of several variables from formulas: vector_function(["3*cos(a) + 2*cos(b)"], ["a",
    "b"]).

    rows: one formula an entry, with sin, cos, tan, sqrt, exp, log. names: the variables. Raises
    FormulaError for a formula that cannot be read, UnknownNameError for a name that is no variable.
    """
    parsed = [parse(row) for row in rows]
    for node in parsed:
        for part in ex.nodes(node):
            if isinstance(part, ex.Symbol) and part.name not in names:
                raise UnknownNameError("variable", part.name, "the function", names)
            if isinstance(part, ex.Vector | ex.Matrix | ex.Equation):
                raise FormulaError(f"{node}: a row is one scalar formula.")
    decimal = any(
        isinstance(part, ex.Number) and part.decimal for node in parsed for part in ex.nodes(node)
    )
    return VectorFunction(tuple(map(to_sympy, parsed)), tuple(names), decimal)


def trajectory(*rows: str) -> Trajectory:
    """The path of a point, one formula in t for each coordinate: trajectory("5*cos(3.14*t)",
    "5*sin(3.14*t)")."""
    if not rows:
        raise FreebodyError("trajectory: give a formula in t for each coordinate.")
    return Trajectory(vector_function(rows, ("t",)))


def printed(x: Any, decimal: bool) -> Expression:
    """A SymPy expression as expression."""
    if x.is_Rational:
        return ex.num(Fraction(int(x.p), int(x.q)), decimal)
    if x.is_Symbol:
        return sym(x.name)
    if x.is_Add:
        return ex.add(*(printed(term, decimal) for term in x.as_ordered_terms()))
    if x.is_Mul:
        number, rest = x.as_coeff_Mul()
        factors = [printed(factor, decimal) for factor in rest.as_ordered_factors()]
        return ex.mul(printed(number, decimal), *factors)
    if x.is_Pow and x.exp.is_Integer:
        base = printed(x.base, decimal)
        return ex.power(base, int(x.exp)) if x.exp > 0 else ex.div(1, ex.power(base, -int(x.exp)))
    if x.is_Pow and x.exp == 0.5:
        return ex.Function("sqrt", printed(x.base, decimal))
    return ex.Function(x.func.__name__, printed(x.args[0], decimal))
