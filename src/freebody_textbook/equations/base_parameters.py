"""Equations of motion by base parameters: the fewest combinations of masses, first moments and
inertias on which the motion depends.

tau = Σ column · parameter, exactly. A body's parameters are called μ (mass), κ (first moment) and J
(inertia about its joint), a rotor's J_r; each is defined by the model's own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.algorithms.regressor import regressor
from freebody.algorithms.regrouped_parameters import kept, regrouped
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation
from freebody.expressions.polynomials.arithmetic import collected, inner
from freebody.expressions.polynomials.symbol_order import Order
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols, symbols
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.model.inertial_parameters import body_parameters
from freebody.scalars.trig import Trig
from freebody_textbook.equations.closed_form import NOTES, SHORT, ClosedForm, Letters, named

if TYPE_CHECKING:
    from freebody_textbook.equations.equations import Equations

TOLERANCE = 1e-9
"""Relative rest below which a column counts as a combination of others; what is found is then
proved exactly."""


@dataclass(frozen=True)
class Base:
    """A base parameter: name, body (counted from 0 in the model's order), kind, column of the
    regressor, and value."""

    name: str
    body: int
    kind: int
    column: int
    value: Trig


def base_parameters(s: Symbols) -> tuple[Base, ...]:
    """The base parameters of a model as polynomials, inner bodies first."""
    rows = regressor(s.tree, s.q, s.qd, s.qdd)
    columns = {
        base.column: [s.element(row[base.column]) for row in rows] for base in _candidates(s)
    }
    found = [
        base
        for base in _candidates(s)
        if not base.value.is_zero and any(not x.is_zero for x in columns[base.column])
    ]
    return tuple(_independent(s, found, columns))


def _candidates(s: Symbols) -> list[Base]:
    """Parameters of each body that may remain after regrouping, and the rotors' inertias."""
    tree, names = s.tree, body_parameters(s.tree.space)
    gathered = regrouped(tree, named=True)
    found = []
    for n, i in enumerate(tree.body_of):
        m, h, inertia = gathered[i]
        I = tree.space.inertia_matrix(inertia)
        entries = (m, *h, *(I[a][b] for a in range(len(I)) for b in range(a, len(I))))
        for k, (name, value) in enumerate(zip(names, entries, strict=True)):
            if name in kept(tree, i):
                kind = 0 if name[0] in "mh" else 1
                found.append(
                    Base(_called(s, name, n + 1), n, kind, n * len(names) + k, s.element(value))
                )
    column = len(tree.body_of) * len(names)
    for n, i in enumerate(tree.body_of):
        drive = tree.bodies[i].drive
        if drive is None:
            continue
        for inertia in drive.unit_inertias():
            if inertia:  # the parameter of a rotor
                value = s.element(drive.inertia)
                found.append(Base(_free(s, f"Jr{n + 1}"), n, 1, column, value))
            column += 1
    return sorted(found, key=lambda base: base.body)


def _called(s: Symbols, name: str, n: int) -> str:
    """Name of a base parameter: mu1, kappa1x, J1xx for m, hx, Ixx."""
    letter = {"m": "mu", "h": "kappa", "I": "J"}[name[0]]
    return _free(s, f"{letter}{n}{name[1:]}")


def _free(s: Symbols, name: str) -> str:
    """A name derived from the given one that the model does not use."""
    while name in s.ring.names:
        name = f"B{name}"
    return name


def _independent(s: Symbols, found: list[Base], columns: dict[int, list[Trig]]) -> list[Base]:
    """Base parameters with linearly independent regressor columns; the values of dependent ones are
    added to theirs."""
    samples = [_samples(s, [columns[base.column] for base in found], seed) for seed in (0, 1)]
    result: list[Base] = []
    places: list[int] = []
    for k, base in enumerate(found):
        used = [i for i in _used(samples, places, k) if i < len(result)]
        weights = _weights(s, columns[base.column], [columns[result[i].column] for i in used])
        if weights is None:
            result.append(base)
            places.append(k)
            continue
        for i, weight in zip(used, weights, strict=True):
            result[i] = replace(result[i], value=result[i].value + base.value * weight)
    return result


def _samples(s: Symbols, columns: list[list[Trig]], seed: int) -> np.ndarray:
    """Regressor values (samples, columns) at random states with the same random lengths."""
    rng = np.random.default_rng(seed)
    count = 4 * len(columns) + 8
    moving = {x + dots for x in s.coordinates for dots in ("", RATE, SECOND)}

    def draw(name: str) -> np.ndarray:
        size = count if name in moving else 1
        return np.broadcast_to(rng.uniform(0.5, 2.0, size) * rng.choice([-1.0, 1.0], size), count)

    values = {name: draw(name) for name in (*s.ring.names, *s.ring.angles)}
    rows = [[np.broadcast_to(x.evaluate(values), count) for x in column] for column in columns]
    return np.array([np.concatenate(row) for row in rows]).T if rows else np.zeros((0, 0))


def _used(samples: list[np.ndarray], places: list[int], k: int) -> list[int]:
    """The columns among those at `places` of which column k is a linear combination in some sample;
    empty if it is not in all samples."""
    used: set[int] = set()
    for sample in samples:
        others, column = sample[:, places], sample[:, k]
        if not places:
            return []
        weights = np.linalg.lstsq(others, column, rcond=None)[0]
        if np.abs(others @ weights - column).max() > TOLERANCE * np.abs(column).max():
            return []
        used |= set(np.flatnonzero(np.abs(weights) > TOLERANCE * np.abs(weights).max()).tolist())
    return sorted(used)


def _weights(s: Symbols, column: list[Trig], others: list[list[Trig]]) -> list[Trig] | None:
    """Polynomials in lengths with Σ others · weights = column, verified exactly; None if none are
    found."""
    parts = [_by_motion(s, other) for other in others]
    mine = _by_motion(s, column)
    weights = []
    for k, part in enumerate(parts):
        # a place where this one stands alone, with a number: what stands there in the column is its
        # weight
        alone = [
            at
            for at, value in part.items()
            if value.is_constant and not any(at in other for i, other in enumerate(parts) if i != k)
        ]
        if not alone:
            return None
        weights.append(mine.get(alone[0], s.zero()) / part[alone[0]].fraction)
    for row, x in enumerate(column):
        for other, weight in zip(others, weights, strict=True):
            x = x - other[row] * weight
        if not x.is_zero:
            return None
    return weights or None


def _by_motion(s: Symbols, column: list[Trig]) -> dict[tuple, Trig]:
    """Coefficients (polynomials in lengths) of each product of coordinates, rates and gravity in a
    regressor column, by row."""
    moving = {x + dots for x in s.coordinates for dots in ("", RATE, SECOND)}
    moving |= {f"{f}_{x}" for f in ("sin", "cos") for x in s.coordinates} | {Order(s).gravity}
    return {
        (row, *key): part
        for row, x in enumerate(column)
        for key, part in collected(x, moving).items()
    }


@dataclass(frozen=True, eq=False)
class BaseEquations(ClosedForm):
    """The closed-form equations with base parameters as symbols; the model's own inertial
    parameters do not occur in M, c and g."""

    bases: tuple[Base, ...] = ()

    @property
    def is_vast(self) -> bool:
        """Whether M is too long to read; found only by computing M, which base parameters make
        shorter."""
        return False

    @cached_property
    def _inertial(self) -> list[Trig]:
        """Torques τ without those of friction and springs, by base parameters."""
        s = self.symbols
        bases = [s.ring[base.name] for base in self.bases]
        rows = regressor(s.tree, s.q, s.qd, s.qdd)
        return [inner([s.element(row[x.column]) for x in self.bases], bases, s) for row in rows]

    @cached_property
    def M(self) -> list[list[Trig]]:
        """The mass matrix, rotors included."""
        return [
            [x.derivative(name + SECOND) for name in self.symbols.coordinates]
            for x in self._inertial
        ]

    @cached_property
    def g(self) -> list[Trig]:
        """Gravity terms of the equations."""
        names = {name for name in self.symbols.ring.names if name.endswith((RATE, SECOND))}
        ring = self.symbols.ring
        return [
            ring.polynomial((powers, c) for powers, c in x.terms() if not names & set(powers))
            for x in self._inertial
        ]

    def definitions(self, layout: ClosedForm) -> list[Equation]:
        """Definitions of the base parameters by the model's own; `layout` prints them."""
        return [ex.eq(sym(base.name), layout.form(base.value)) for base in self.bases]


def base_view(equations: ClosedForm, names: Letters = NOTES) -> list[list[Equation]]:
    """The named view of the equations in base parameters, with their definitions."""
    short = by_base_parameters(equations)
    return [*named(short, short.layout, names), short.definitions(equations)]


def short_by_base(equations: Equations, names: Letters = NOTES) -> list[list[Equation]] | None:
    """The equations in base parameters, if they fit on about a page; None otherwise."""
    if equations.symbols.is_rewritten or not by_base_parameters(equations).is_short:
        return None
    groups = base_view(equations, names)
    return groups if sum(ex.size(line) for group in groups for line in group) <= SHORT else None


def by_base_parameters(equations: ClosedForm) -> BaseEquations:
    """A model's closed-form equations rewritten in base parameters."""
    before = equations.symbols
    before.require_plain("equations by base parameters")
    bases = base_parameters(before)
    ranks = {base.name: (base.body, base.kind) for base in bases}
    after = symbols(before.model, before.reader.numbers, inertial=ranks)
    return BaseEquations(after, bases)
