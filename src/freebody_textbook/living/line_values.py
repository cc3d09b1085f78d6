"""Exact values of a derivation's lines; in space in each body's axes, or with all vectors in world
axes, so that those of several bodies can be added."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.errors import FreebodyError
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.nodes import Derivative, Matrix, Quotient, Vector, Words, nodes, replaced
from freebody.expressions.printed_names import vec
from freebody.scalars.expr import Expr
from freebody.scalars.trig import Trig
from freebody.spatial import product, times, transposed
from freebody_textbook.derivation import Derivation, Step
from freebody_textbook.living.page_program import PageProgram, entries
from freebody_textbook.methods import METHODS
from freebody_textbook.methods.body_quantities import BODY_QUANTITIES, BodyQuantity, numbers
from freebody_textbook.methods.recursive import GRAVITIES
from freebody_textbook.relations.formula import symbol
from freebody_textbook.relations.formula_values import rank, value
from freebody_textbook.relations.quantities import Quantities, quantities

_GRAVITY: dict[Expression, Expression] = {vec("g"): symbol("gravity")}
"""The vector of gravity has the letter of its magnitude, and another name among quantities."""
_RATES = {"q_d": "qd", "q_dd": "qdd"}


@dataclass(frozen=True)
class ValuedLine:
    """A line with the exact value of its sides: a scalar, a vector as a tuple, or for a quotient
    that is no polynomial an expression in symbols."""

    step: Step
    line: Equation
    value: Any
    names: tuple[str, ...]
    """The line's own symbols that have a value, those of its left side first."""
    in_world: bool = False
    """Whether the line holds, and has this value, only with all vectors in axes of the world."""


@dataclass(frozen=True)
class LineValues:
    """The lines of a derivation that have a value, with the values of all names, and which names
    the model gives and which the lines."""

    quantities: Quantities
    known: frozenset[str]
    """Names that the model of an open chain itself gives; others are defined by a line."""
    lines: tuple[ValuedLine, ...]
    defined: frozenset[str] = frozenset()
    """Names that only a line gives a value."""


def line_values(derivation: Derivation, values: Quantities | None = None) -> LineValues:
    """Values of a derivation's lines in exact arithmetic.

    A line has one where two of its sides are found to be the same polynomial, or where its left
    side is a new name that it defines. Of the two ways to count gravity (`quantities`) the one is
    taken by which more lines hold. values: those of a closed chain, in the derivation's symbols.
    """
    if values is not None:
        return _lines(derivation, values, frozenset())
    found = [_by(derivation, gravity) for gravity in GRAVITIES]
    return max(found, key=lambda one: len(one.lines))


def _by(derivation: Derivation, gravity: str) -> LineValues:
    symbols = derivation.equations.symbols
    values = quantities(
        symbols.given or symbols.model,
        load="fx" in symbols.extra,
        at_rest=METHODS[derivation.method].at_rest,
        gravity=gravity,
    )
    return _lines(derivation, values, frozenset(values))


def _lines(derivation: Derivation, values: Quantities, known: frozenset[str]) -> LineValues:
    symbols = derivation.equations.symbols
    values |= {
        new: values[name] for new, name in _RATES.items() if name in values and new not in values
    }
    if symbols.model.dim == 3:
        values = own_axes(values, {name: symbols.ring[name] for name in symbols.ring.names})
    waiting = [(step, line) for step in derivation.steps for line in step.equations]
    given = frozenset(values)
    while new := _defined((line for _, line in waiting), values):
        values |= new
    defined = frozenset(values) - given
    made = [_valued(step, line, values) for step, line in waiting]
    if symbols.model.dim == 3:
        world = world_axes(values)
        made = [
            one or _valued(step, line, world, in_world=True)
            for one, (step, line) in zip(made, waiting, strict=True)
        ]
    told = tuple(_with_quotients(waiting, made, values))
    return LineValues(values, known, told, defined)


def traced_values(
    derivation: Derivation, values: Mapping[str, Any], program: PageProgram
) -> LineValues:
    """Values of a derivation's lines over a program's scalars, in which `values` are expressed;
    sides that have a value must agree at random states. Where gravity is an acceleration of the
    base, the lines themselves define the accelerations."""
    bare = {name: x for name, x in values.items() if not _is_acceleration(name)}
    found = [_traced(derivation, known, program) for known in (values, bare)]
    return max(found, key=lambda one: len(one.lines))


def _is_acceleration(name: str) -> bool:
    """Whether a name is an acceleration of a centre of mass."""
    own = atom(name)
    return own.letter == "vc" and own.is_numbered and own.dots == 1


def _traced(derivation: Derivation, values: Mapping[str, Any], program: PageProgram) -> LineValues:
    waiting = [(step, line) for step in derivation.steps for line in step.equations]
    hidden = {scalar_name(x): program.inputs[x] for x in values if x in program.inputs}
    found = Quantities(_with_parts(values) | hidden, derivation.equations.layout)
    given = frozenset(found)
    while new := _defined((line for _, line in waiting), found):
        found = Quantities(_with_parts(new) | found | new, found.layout)
    world = world_axes(found) if derivation.equations.symbols.model.dim == 3 else found
    told = [*_with_sides(waiting, found, False), *_with_sides(waiting, world, True)]
    unlike = _unlike((sides for _, sides in told), program)
    right = {(x.step, x.line): x for k, (x, _) in reversed([*enumerate(told)]) if k not in unlike}
    known = frozenset(name for name in values if name.startswith("tau"))
    told_lines = tuple(right[x] for x in waiting if x in right)
    return LineValues(found, known, told_lines, frozenset(found) - given)


def _with_sides(
    waiting: Iterable[tuple[Step, Equation]], names: Quantities, in_world: bool
) -> Iterator[tuple[ValuedLine, list[Any]]]:
    """The lines with at least two sides that can be computed, with these values."""
    for step, line in waiting:
        own = [x for side in line.sides if (x := _value(side, names)) is not None]
        if len(own) > 1 and any(isinstance(x, Expr) for x in entries(own[-1])):
            yield ValuedLine(step, line, own[-1], _names(line, names), in_world), own


def _with_parts(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values, together with the components of spatial vectors, by their names in lines."""
    vectors = {name: x for name, x in values.items() if rank(x) == 1 and len(x) == 3}
    parts = {
        f"{name}_{axis}": part
        for name, x in vectors.items()
        for axis, part in zip("xyz", x, strict=True)
    }
    return {**parts, **values}


def _unlike(lines: Iterable[list[Any]], program: PageProgram) -> set[int]:
    """Indices of lines whose sides differ, or are not numbers."""
    found, pairs = set(), []
    for k, sides in enumerate(lines):
        first = entries(sides[0])
        if any(rank(x) > 1 or len(entries(x)) != len(first) for x in sides):
            found.add(k)
            continue
        pairs += [(k, *both) for x in sides[1:] for both in zip(first, entries(x), strict=True)]
    one, two = (program.at_random([pair[i] for pair in pairs]) for i in (1, 2))
    size = np.maximum(np.abs(one), np.abs(two)) + 1.0
    return found | {pairs[j][0] for j in np.flatnonzero((np.abs(one - two) > 1e-9 * size).any(1))}


def _with_quotients(
    waiting: Iterable[tuple[Step, Equation]],
    made: Iterable[ValuedLine | None],
    values: Quantities,
) -> Iterator[ValuedLine]:
    """The valued lines, together with those that define a name as a quotient that is no
    polynomial."""
    quotients: dict[str, Expression] = {}
    for (step, line), one in zip(waiting, made, strict=True):
        name = line.lhs.name if isinstance(line.lhs, Symbol) else ""
        if one is not None:
            yield one
        elif name and any(isinstance(x, Quotient) for x in nodes(line.rhs)):
            form = _in_symbols(line.rhs, values, quotients)
            if form is not None:
                quotients[name] = form
                yield ValuedLine(step, line, form, _names(line, values))


def _in_symbols(
    side: Expression, values: Quantities, quotients: Mapping[str, Expression]
) -> Expression | None:
    """A scalar side with the values of names substituted; None if a name has none."""
    new: dict[Expression, Expression] = {}
    for x in nodes(side):
        if isinstance(x, Symbol):
            found = quotients.get(x.name, values.get(x.name))
            if not isinstance(found, Expression | Trig):
                return None
            new[x] = found if isinstance(found, Expression) else values.form(found)
        elif isinstance(x, Vector | Matrix | Derivative | Words):
            return None
    return replaced(side, new)


def _valued(
    step: Step, line: Equation, values: Quantities, in_world: bool = False
) -> ValuedLine | None:
    x = _common(line, values)
    return None if x is None else ValuedLine(step, line, x, _names(line, values), in_world)


def _defined(lines: Iterable[Equation], values: Quantities) -> dict[str, Any]:
    """Names without a value that a line defines, with the value from the line."""
    found: dict[str, Any] = {}
    for line in lines:
        left = line.lhs
        if isinstance(left, Symbol) and left.name not in values and left.name not in found:
            x = _value(line.rhs, values)
            if x is not None:
                found[left.name] = x
    return found


def _common(line: Equation, values: Quantities) -> Any:
    """The common value of a line's sides that can be evaluated, at least two; None if they differ
    or are a plain number."""
    sides = [x for side in line.sides if (x := _value(side, values)) is not None]
    last = sides[-1] if sides else None
    if len(sides) < 2 or rank(last) > 1 or not any(isinstance(x, Trig) for x in entries(last)):
        return None
    return last if all(_same(x, last) for x in sides[:-1]) else None


def _same(a: Any, b: Any) -> bool:
    if rank(a) != rank(b) or len(entries(a)) != len(entries(b)):
        return False
    return all(x == y for x, y in zip(entries(a), entries(b), strict=True))


def _value(side: Expression, values: Quantities) -> Any:
    try:
        return value(replaced(side, _GRAVITY | _scalars(side, values)), values)
    except (FreebodyError, KeyError, ZeroDivisionError):
        return None


def _scalars(side: Expression, values: Quantities) -> dict[Expression, Expression]:
    """Replacements for parameters that have a matrix's name; the matrix is bold."""
    return {
        x: symbol(name)
        for x in nodes(side)
        if isinstance(x, Symbol) and not x.bold and (name := scalar_name(x.name)) in values
    }


def _names(line: Equation, values: Quantities) -> tuple[str, ...]:
    found = [x.name for x in nodes(replaced(line, _GRAVITY)) if isinstance(x, Symbol)]
    return tuple(dict.fromkeys(name for name in found if name in values))


def _letters(rows: Iterable[BodyQuantity]) -> frozenset[str]:
    return frozenset(atom(x.known.format(**numbers(1))).letter for x in rows)


_VECTORS = _letters(x for x in BODY_QUANTITIES if x.has_axes_of_body) - _letters(
    x for x in BODY_QUANTITIES if not x.own_axes
)
"""Letters of vectors in axes of their body, whose number is the last figure."""
_PARTIAL = ("omega", "vc")
"""Letters of partial velocities, whose indices are body and joint."""


def body_of(name: str) -> str:
    """The number of the body in whose axes a vector is expressed, from the name on a line's left
    side."""
    own = atom(name)
    turns = own.letter == "R" and own.is_figures and len(own.figures) == 2 and not own.dots
    return own.figures[-1] if turns else _of_vector(name)


def _of_vector(name: str) -> str:
    """The number of the body whose vector a symbol is; "" for anything else."""
    own = atom(name)
    if not own.is_figures or own.primes or len(own.figures) > 2 or own.letter not in _VECTORS:
        return ""
    is_partial = own.letter in _PARTIAL and len(own.index) == 2 and not own.dots
    return own.figures[0 if is_partial else -1]


def scalar_name(name: str) -> str:
    """The key for the value of a parameter that has the same name as a matrix, such as I1."""
    return f"{name} (scalar)"


def own_axes(values: Quantities, parameters: dict[str, Any]) -> Quantities:
    """Vectors in their bodies' axes by printed names: n0_1 for the moment n1 at joint 1, R1_2 for
    the rotation from body 1 to body 2; joint axes are left to the lines that define them."""
    found: dict[str, Any] = {}
    further: dict[str, Any] = {}
    for name, x in values.items():
        own = atom(name)
        match own.letter, own.index, own.dots:
            case "z" | "w", (k,), 0 if k.isdigit():
                continue
            case "n", (k,), 0 if k.isdigit():
                further[f"n{int(k) - 1}_{k}"] = x
            case "R", (k,), 0 if k.isdigit() and k != "0":
                further[f"R0_{k}"] = transposed(x)
            case "R", (_, _), 0:
                further[name] = transposed(x)
        found[name] = x
    found |= further
    found |= {scalar_name(name): x for name, x in parameters.items() if rank(found.get(name)) > 0}
    return Quantities(found, values.layout)


def world_axes(values: Quantities) -> Quantities:
    """Quantities with vectors converted from body axes to world axes."""
    found: dict[str, Any] = {}
    for name, x in values.items():
        own = atom(name)
        body = own.figures if own.letter == "I" and own.is_numbered else _of_vector(name)
        turn = values.get(f"R{body}") if body else None
        if turn is None or rank(x) == 0:
            found[name] = x
        else:
            found[name] = (
                product(product(turn, x), transposed(turn)) if rank(x) == 2 else times(turn, x)
            )
    return Quantities(found, values.layout)
