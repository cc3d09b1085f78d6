"""Poses in which det J = 0 (2.20-2.23): the determinant factored, and each factor solved for a
joint where that is possible."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression
from freebody.expressions.kinematics import Kinematics, shortest_determinant
from freebody.expressions.polynomials.angle_sums import SymbolPowers, gathered, raw
from freebody.expressions.polynomials.factors import factored
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.outputs.display import Titled
from freebody.scalars.generators import symbols_in
from freebody.scalars.trig import Trig


@dataclass(frozen=True, repr=False)
class Condition(Titled):
    """A condition under which an arm is singular: a factor of the determinant that vanishes."""

    factor: Trig
    equation: Equation
    """The condition as an equation, factor = 0."""
    solutions: tuple[Equation, ...]
    """The equation solved for a joint or a sum of joints; empty where it has no short solution."""

    def _title(self) -> str:
        return f"Condition: {self}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __str__(self) -> str:
        return _joined([str(e) for e in self.solutions or (self.equation,)])

    def latex(self) -> str:
        """The condition as LaTeX, without dollar signs."""
        rows = [e.latex() for e in self.solutions or (self.equation,)]
        return r" \quad\text{or}\quad ".join(rows)


@dataclass(frozen=True)
class Determinant:
    """number · Π factor^exponent, a polynomial in normal form; the product has been multiplied out
    and compared."""

    kinematics: Kinematics
    polynomial: Trig

    @cached_property
    def _product(self) -> tuple[Fraction, list[tuple[Trig, int]]]:
        if self.polynomial.is_zero:
            return Fraction(0), []
        number, factors = factored(self.polynomial)
        oriented = []
        for factor, exponent in factors:
            scale = _readable(factor) * (-1 if self.kinematics.layout.is_negative(factor) else 1)
            oriented.append((factor * scale, exponent))
            number /= scale**exponent
        return number, sorted(oriented, key=lambda row: self._rank(row[0]))

    @property
    def factors(self) -> list[tuple[Trig, int]]:
        """Factors of the determinant with their exponents, lengths first."""
        return self._product[1]

    @property
    def number(self) -> Fraction:
        """Constant factor of the determinant."""
        return self._product[0]

    @cached_property
    def expression(self) -> Expression:
        """The determinant as a printed product, such as l1 l2 sin θ2 (2.22)."""
        form = self.kinematics.form
        number = form(self.kinematics.symbols.element(self.number))
        return ex.mul(number, *(ex.power(form(f), e) for f, e in self.factors))

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """Conditions under which the determinant vanishes: one for each factor that depends on the
        joints."""
        return tuple(self._condition(f) for f, _ in self.factors if self._moving(f))

    def _moving(self, x: Trig) -> list[str]:
        """The coordinates that a polynomial depends on."""
        used = symbols_in(x)
        return [name for name in self.kinematics.symbols.coordinates if name in used]

    def _rank(self, x: Trig) -> tuple:
        return len(self._moving(x)), self._moving(x), len(x), str(x)

    # ------------------------------------------------------------ solving
    def _condition(self, factor: Trig) -> Condition:
        equation = ex.eq(self.kinematics.form(factor), 0)
        return Condition(
            factor,
            equation,
            self._slid(factor) or self._turned(factor) or self._turned_alone(factor),
        )

    def _slid(self, factor: Trig) -> tuple[Equation, ...]:
        """The solution d = … of a factor that is linear in the position d of a sliding joint; empty
        where there is none."""
        s = self.kinematics.symbols
        for name in self._moving(factor):
            slope = factor.derivative(name) if name not in s.ring.angles else None
            if slope is not None and slope.is_constant and not slope.is_zero:
                rest = (slope * s.ring[name] - factor) / slope.fraction
                return (ex.eq(sym(name), self.kinematics.form(rest)),)
        return ()

    def _turned(self, factor: Trig) -> tuple[Equation, ...]:
        """The solutions φ = … of a factor a sin φ + b cos φ, where φ is a sum of angles; empty for
        other factors."""
        angles = self.kinematics.symbols.ring.angles
        parts: defaultdict[str, list[tuple[SymbolPowers, Fraction]]] = defaultdict(list)
        arguments = set()
        for (monomial, wave), coefficient in gathered(raw(factor), angles, (angles,)).items():
            if len(wave) != 1 or wave[0][2] != 1:
                return ()
            parts[wave[0][0]].append((monomial, coefficient))
            arguments.add(wave[0][1])
        if len(arguments) != 1:
            return ()
        argument = ex.add(*(ex.mul(k, sym(x)) for x, k in arguments.pop()))
        if len(parts) == 1:
            values = (
                (ex.num(0), sym("pi")) if "sin" in parts else (ex.neg(_half_turn()), _half_turn())
            )
            return tuple(ex.eq(argument, value) for value in values)
        sine, cosine = (self._polynomial(parts[f]) for f in ("sin", "cos"))
        if self._moving(sine) or self._moving(cosine):
            return ()
        form = self.kinematics.form
        return (ex.eq(ex.Function("tan", argument), ex.neg(ex.div(form(cosine), form(sine)))),)

    def _turned_alone(self, factor: Trig) -> tuple[Equation, ...]:
        """The solution tan θ = … of a factor a sin θ + b cos θ for its first angle θ, with a and b
        free of it; empty for other factors."""
        ring, form = self.kinematics.symbols.ring, self.kinematics.form
        for name in self._moving(factor):
            if name not in ring.angles:
                continue
            parts: dict[str, list[tuple[dict[str, int], Fraction]]] = {"sin": [], "cos": [], "": []}
            for powers, coefficient in factor.terms():
                f = "".join(f for f in ("sin", "cos") if powers.get(f"{f}_{name}") == 1)
                rest = {key: e for key, e in powers.items() if key != f"{f}_{name}"}
                alone = not any(key.endswith(f"_{name}") for key in rest)
                parts[f if f in ("sin", "cos") and alone else ""].append((rest, coefficient))
            if not parts[""] and parts["sin"] and parts["cos"]:
                sine, cosine = ring.polynomial(parts["sin"]), ring.polynomial(parts["cos"])
                if self.kinematics.layout.is_negative(sine):
                    sine, cosine = -sine, -cosine
                return (ex.eq(ex.Function("tan", sym(name)), ex.div(form(-cosine), form(sine))),)
        return ()

    def _polynomial(self, terms: Sequence[tuple[SymbolPowers, Fraction]]) -> Trig:
        return self.kinematics.symbols.ring.polynomial((dict(m), c) for m, c in terms)


def _readable(factor: Trig) -> Fraction:
    """A power of ten by which a factor's coefficients are readable where decimals were made large
    whole numbers; then the largest is below 1."""
    largest = max(abs(c) for _, c in factor.terms())
    return Fraction(1) if largest < 100 else Fraction(1, 10 ** len(str(int(largest))))


def _half_turn() -> Expression:
    return ex.div(sym("pi"), 2)


def _joined(texts: list[str]) -> str:
    """The solutions joined to one text, such as "θ = 0 or π": an equal left side is written
    once."""
    sides = [text.split(" = ") for text in texts]
    if len(sides) > 1 and all(len(row) == 2 and row[0] == sides[0][0] for row in sides):
        return f"{sides[0][0]} = {' or '.join(row[1] for row in sides)}"
    return " or ".join(texts)


def jacobian_determinant(kinematics: Kinematics, rows: Sequence[int]) -> Determinant:
    """The determinant of chosen rows of the Jacobian and of the columns that move the frame, of
    which there must be as many as rows."""
    everything = len(kinematics.J) == len(rows)
    polynomial = (
        shortest_determinant(kinematics.symbols, kinematics.frame)
        if everything
        else kinematics.determinant(rows)
    )
    return Determinant(kinematics, polynomial)
