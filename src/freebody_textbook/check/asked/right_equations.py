"""The model's equations with which an answer is compared, in a ring that also contains symbols
users write by mistake."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import MappingProxyType
from typing import Any

from freebody.expressions.closed_form_kinematics import Kinematics
from freebody.expressions.grammar.atoms import atom, undotted
from freebody.expressions.grammar.parser import PI
from freebody.expressions.nodes import Expression
from freebody.expressions.notations.notation import BookNotation, Weights, angles_of
from freebody.expressions.polynomials.symbol_order import Order
from freebody.expressions.polynomials.symbols import (
    RATE,
    SECOND,
    Symbols,
    names_by_formulas,
    symbols,
)
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities.kinds import LOOP
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.number_names import catalogue
from freebody.scalars.generators import generators_in, waves_of
from freebody.scalars.trig import Trig, TrigRing
from freebody_textbook.check.algebra.quotients import Value, pair, slope
from freebody_textbook.check.asked.letters_for_numbers import COORDINATES, PARAMETERS, with_letters
from freebody_textbook.check.asked.quantity import ActingLoads
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.closed_chains.linear_equations import Ratio
from freebody_textbook.closed_chains.loop_equations import LoopEquations
from freebody_textbook.closed_chains.multiplier_equations import (
    FirstKind,
    is_multiplier,
    multipliers,
)
from freebody_textbook.equations.closed_form import require_polynomial_drives
from freebody_textbook.equations.equations import Equations
from freebody_textbook.given_parameters import formulas_of
from freebody_textbook.methods.free_body_steps import XYZ
from freebody_textbook.methods.whole_bodies import are_free, symbols_of_bodies, velocity_names

ALONG_SLIDE = "F"
"""The symbol of a force along the one slide of a mechanism that nothing drives."""
FORCES = tuple(f"{letter}_{axis}" for letter in "fn" for axis in XYZ)
"""Force and moment on a free body."""


@dataclass(frozen=True)
class RightEquations:
    """The correct equations, and their symbols in the larger ring of answers."""

    equations: Equations
    symbols: Symbols
    foreign: frozenset[str]
    """Symbols of the notes that this model does not have, such as l2 of a link that slides."""
    zeros: frozenset[str] = frozenset()
    """Parameters of the model whose value is 0: an answer may name them."""
    turned: Weights | None = None
    """The matrix B of θ = B φ for absolute angles, where θ are the model's coordinates and φ the
    answer's, in which all turns are measured from one direction. Torques and forces are then those
    of φ."""
    quarters: tuple[int, ...] = ()
    """The right angles by which each coordinate of the answer is 0 elsewhere, where angles are not
    measured from the x axis."""
    formulas: Mapping[str, str | float] = field(default_factory=lambda: MappingProxyType({}))
    """Parameters that are given by formulas."""
    opposed: frozenset[str] = frozenset()
    """Loop equations, Phi1, and multipliers that have the other sign in the answer."""

    @cached_property
    def layout(self) -> Layout:
        """The layout for printing polynomials."""
        return Layout(self.symbols)

    @property
    def order(self) -> Order:
        """The order of symbols in print, and the meaning of each."""
        return self.layout.order

    @property
    def ring(self) -> TrigRing:
        """The ring of polynomials that answers are read in."""
        return self.symbols.ring

    @cached_property
    def system(self) -> FirstKind | None:
        """A closed chain's equations with multipliers, which its torques refer to; None for open
        chains."""
        symbols = self.equations.symbols
        loops = LoopEquations(symbols) if symbols.model.loops else None
        return loops and FirstKind(loops, self.equations)

    @property
    def is_planar(self) -> bool:
        """Whether the model moves in the plane."""
        return self.symbols.model.dim == 2

    @cached_property
    def is_free_body(self) -> bool:
        """Whether the robot is a single free body."""
        symbols = self.equations.symbols
        return _is_free_body(symbols.given or symbols.model)

    @property
    def loads(self) -> tuple[str, ...]:
        """Symbols of a force and a moment at the tip, if the answer has them."""
        symbols = self.equations.symbols
        if self.is_free_body:
            return ()
        return tuple(x for x in symbols.extra if not is_multiplier(x))

    @property
    def force_at_tip(self) -> tuple[str, ...]:
        """The force components of the load, without the moment."""
        return tuple(x for x in self.loads if x[0] == "f")

    def turns(self, name: str) -> bool:
        """Whether a coordinate, or the coordinate of a rate, is an angle."""
        return undotted(name) in self.ring.angles

    def held(self, acting: ActingLoads) -> list[Trig]:
        """The generalized forces of drives and loops in a closed chain that exerts a force at its
        tip or slide; with weights and motion as `acting` says."""
        return [self._told(x, acting) + y for x, y in zip(self._all, self._by_load, strict=True)]

    @cached_property
    def _all(self) -> list[Trig]:
        """The generalized forces of the equations of motion, without a load."""
        return [self.element(x) for x in self.all_of("tau")]

    def _told(self, force: Trig, acting: ActingLoads) -> Trig:
        """The terms of a generalized force that `acting` includes: all, those at rest, or those
        without weights."""
        still, weightless = acting in ("weight", "load"), acting == "load"

        def counts(name: str) -> bool:
            return not (still and atom(name).dots) and not (
                weightless and name == self.order.gravity
            )

        return self.ring.polynomial(
            (powers, k) for powers, k in force.terms() if all(map(counts, powers))
        )

    @cached_property
    def _by_load(self) -> list[Trig]:
        """The generalized forces that balance the load."""
        symbols, found = self.equations.symbols, [self.zero for _ in self.symbols.coordinates]
        for name in self.loads:
            force = self.image(name)
            for k, x in enumerate(self._arms(name, symbols)):
                found[k] = found[k] + self.element(x) * force
        return found

    def _arms(self, load: str, symbols: Symbols) -> list[Trig]:
        """The generalized forces of a unit load."""
        if load == ALONG_SLIDE:
            slides = slides_of(symbols.model)
            return [symbols.element(float(k in slides)) for k in range(len(symbols.coordinates))]
        return list(Kinematics(symbols, symbols.model.frame().name).J["xy".index(load[-1])])

    @cached_property
    def rates(self) -> dict[str, Trig]:
        """Time derivatives of all variable symbols, also those that occur only in answers."""
        ring = self.ring
        pairs = [(x, x + RATE) for x in ring.names] + [(x + RATE, x + SECOND) for x in ring.names]
        own = {x: ring[rate] for x, rate in pairs if {x, rate} <= ring.index.keys()}
        return own | dict(self.symbols.rates)

    def rate(self, x: Value) -> Value:
        """The time derivative of a polynomial or quotient; raises AnswerError if it is unknown."""
        for name in sorted(generators_in(*pair(x))):
            changes = name in self._of_unknown_rate or atom(name).dots == 2
            if (changes or is_multiplier(name)) and name not in self.rates:
                raise AnswerError(f"nothing here tells how {sym(name)} changes in time")
        return slope(x, lambda p: p.along(self.rates))

    @cached_property
    def _of_unknown_rate(self) -> frozenset[str]:
        """Names of the external forces, whose rates are unknown."""
        return frozenset(FORCES if self.is_free_body else self.loads)

    @property
    def joints(self) -> int:
        """The highest joint number in a coordinate's name."""
        return max((int(atom(x).figures or 0) for x in self.symbols.coordinates), default=0)

    @property
    def zero(self) -> Trig:
        """The zero polynomial in the ring of answers."""
        return self.symbols.zero()

    def element(self, x: Trig) -> Trig:
        """A polynomial of the equations converted to the larger ring and to the answer's
        coordinates."""
        if not self._images:
            return self.ring.polynomial(x.terms())
        found = self.zero
        for powers, coefficient in x.terms():
            term = self.zero + coefficient
            for name, power in powers.items():
                term = term * self.image(name) ** power
            found = found + term
        return found

    def image(self, name: str) -> Trig:
        """The polynomial in the answer's symbols that replaces a symbol of the equations."""
        kept = self._images.get(name)
        return self.ring.polynomial([({name: 1}, Fraction(1))]) if kept is None else kept

    @cached_property
    def _images(self) -> dict[str, Trig]:
        """The model's coordinates and rates as polynomials in the answer's coordinates and
        rates."""
        images = dict(self.given)
        images |= {x: -self.ring[x] for x in self.opposed if x in self.ring.index}
        names = self.symbols.coordinates
        if self.turned is None and not any(self.quarters):
            return images
        unit = tuple(tuple(int(i == k) for k in range(len(names))) for i in range(len(names)))
        for name, row in zip(names, self.turned or unit, strict=True):
            for ending in ("", RATE, SECOND):
                parts = (k * self.ring[x + ending] for x, k in zip(names, row, strict=True) if k)
                images[name + ending] = sum(parts, self.zero)
            quarters = sum(k * q for k, q in zip(row, self.quarters, strict=bool(self.quarters)))
            images[name] = images[name] + self.zero + PI / 2 * quarters
            if name in self.ring.angles:
                sine, cosine = waves_of(name)
                images[sine], images[cosine] = images[name].sin(), images[name].cos()
        return images

    @cached_property
    def given(self) -> dict[str, Trig]:
        """Values of the parameters that are given by formulas."""
        return self.symbols.followed(formulas_of("check", self.symbols, self.formulas))

    def all_of(self, name: str) -> Any:
        """A quantity of the equations by name, in the answer's coordinates: tau, c or g (Bᵀ τ), M
        or C (Bᵀ M B), T or V."""
        found: Any = self.system.forces if self.system and name == "tau" else None
        if found is None:
            found = getattr(self.equations, name)
        if self.turned is None or isinstance(found, Trig):
            return found
        rows = self.forces(found)
        if isinstance(rows[0], list):
            columns = self.forces(list(zip(*rows, strict=True)))
            return [list(row) for row in zip(*columns, strict=True)]
        return rows

    def forces(self, values: Sequence[Any]) -> list[Any]:
        """Generalized forces converted from the model's coordinates to the answer's, Bᵀ τ; a matrix
        is converted row by row."""
        if self.turned is None:
            return list(values)
        B, n = self.turned, range(len(values))
        return [_combined([B[k][i] for k in n], values) for i in n]

    @cached_property
    def units(self) -> Mapping[str, str]:
        """Units of the model's parameters, by parameter name."""
        return {name: row.unit for name, row in catalogue(self.symbols.model).rows.items()}

    def parameter(self, name: str) -> Trig | None:
        """The polynomial of a parameter's name: its symbol, or 0 if its value is 0; None if there
        is no such parameter."""
        if name in self.zeros:
            return self.zero
        return self.ring[name] if name in self.ring.index else None

    def form(self, x: Value) -> str:
        """Printed text of a polynomial or a quotient of two."""
        return str(self.printed(x))

    def printed(self, x: Value) -> Expression:
        """A polynomial or a quotient of two as it is printed."""
        return x.form(self.layout) if isinstance(x, Ratio) else self.layout.form(x)


def loop_equation(i: int) -> str:
    """The name of loop equation i, counted from 1."""
    return f"{LOOP.name}{i}"


def _combined(factors: Sequence[int], values: Sequence[Any]) -> Any:
    """The sum of values, or of rows of values, multiplied by factors."""
    if isinstance(values[0], list | tuple):
        columns = zip(*values, strict=True)
        return [_combined(factors, column) for column in columns]
    return sum((x * k for x, k in zip(values, factors, strict=True) if k), values[0] * 0)


def in_notation(
    equations: Equations, notation: BookNotation, absolute: bool = False
) -> RightEquations:
    """The correct equations of a model for answers in a book's notation."""
    model, given = equations.symbols.model, equations.symbols.given or equations.symbols.model
    following = names_by_formulas(model)
    zeros = [x for x, value in given.parameters.items() if value == 0 and x not in following]
    turned, quarters = angles_of("check", notation, model, absolute)
    plain = setting(equations, zeros, turned)
    return replace(plain, quarters=quarters, formulas=notation.parameters)


def slides_of(model: Model) -> list[int]:
    """Indices of sliding coordinates without a drive."""
    made = symbols(model, follows=False)
    return [k for k in model.passive if made.coordinates[k] not in made.ring.angles]


def equations_of(model: Model, loads: tuple[str, ...] = ()) -> Equations:
    """The model's equations in closed form; for a closed chain those of the tree with its loops
    cut, in a ring with multipliers. loads: symbols of a load on the tip."""
    if _is_free_body(model):
        lettered = with_letters(model)
        return Equations(
            symbols_of_bodies("check", lettered, (*velocity_names(model), *FORCES), euler=True)
        )
    extra = (*multipliers(model), *loads) if model.loops else loads
    known = symbols(model, extra=extra, follows=False)
    require_polynomial_drives(known)
    return Equations(known)


def _is_free_body(model: Model) -> bool:
    """Whether a model is a single free body without a payload; with one, answers about it are not
    read."""
    return len(model.bodies) == 1 and are_free(model) and len(model.bodies[0].inertias) == 1


def setting(
    equations: Equations, zeros: Collection[str] = (), turned: Weights | None = None
) -> RightEquations:
    """The correct equations of a model; `zeros`: names of parameters whose value is 0; turned: see
    `RightEquations`."""
    symbols = equations.symbols
    ring = symbols.ring
    foreign: list[str] = []
    if symbols.model.dim == 2:
        numbers = [atom(x).figures for x in symbols.coordinates]
        listed = [f"{x.letter}{k}" for k in numbers for x in PARAMETERS]
        moving = [f"{x}{k}" for k in numbers for x in COORDINATES]
        still = set(ring.index) - set(symbols.coordinates)  # a length may be called d1
        listed += [x + e for x in moving if x not in still for e in ("", RATE, SECOND)]
        foreign = [
            name for name in dict.fromkeys(listed) if name not in ring.index and name not in zeros
        ]
    angles = [x for x in foreign if atom(x).letter == "theta" and not atom(x).dots]
    others = [name for name in foreign if name not in angles]
    wide = TrigRing([*ring.angles, *angles], [*ring.names[len(ring.angles) :], *others])
    return RightEquations(
        equations, replace(symbols, ring=wide), frozenset(foreign), frozenset(zeros), turned
    )
