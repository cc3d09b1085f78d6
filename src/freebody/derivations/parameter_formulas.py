"""Parameters given by formulas: lc = l/2 of every link, I1 = m1 l1²/12, or a number."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping

from freebody.derivations.expressions.expression import Expression
from freebody.derivations.expressions.printed_names import sym
from freebody.derivations.polynomials.symbols import Formulas, Symbols
from freebody.derivations.polynomials.textbook_form import Layout
from freebody.derivations.relations.formula import FormulaError, names_in, parse
from freebody.derivations.relations.formula_values import value
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.model.model import Model
from freebody.model.parameters import Parameter, finite
from freebody.outputs.numbers import shortest
from freebody.scalars.trig import Trig

_NOT_FINITE = re.compile(r"\s*[-+]?(?:nan|inf(?:inity)?)\s*", re.IGNORECASE)
_ROUNDED = 1e-12
"""Of the terms of a formula: what rounding may leave of their sum."""


def formulas_of(caller: str, symbols: Symbols, given: Mapping[str, str | float]) -> dict[str, Trig]:
    """The values of the parameters that formulas give, in the others; a name without its number is
    that of every link.

    Raises UnknownNameError, and FreebodyError for a formula that cannot be read, that changes with
    the motion, that names a parameter given by a formula, or that makes a mass or a moment of
    inertia negative: with the model's values, and where it has none for all positive ones.
    """
    texts = {
        own: text
        for name, formula in given.items()
        for own, text in _of_each_link(caller, symbols, name, _text(caller, name, formula))
    }
    inertial = inertial_names(symbols.model)
    known = {name: symbols.ring[name] for name in symbols.ring.names}
    found: dict[str, Trig] = {}
    for name, text in texts.items():
        parsed = _parsed(caller, name, text)
        try:
            made = value(parsed, known)
        except FreebodyError as problem:
            raise _bad(caller, name, text, problem) from None
        except ZeroDivisionError:
            raise _bad(caller, name, text, FreebodyError("it divides by 0")) from None
        if isinstance(made, tuple):
            raise _bad(caller, name, text, FreebodyError("a parameter is one number"))
        made = made if isinstance(made, Trig) else symbols.zero() + made
        if any(set(powers) & set(texts) for powers, _ in made.terms()):
            raise FreebodyError(
                f"{caller}: {name} = {text} names a parameter that is given by a formula; write "
                "it with the others."
            )
        if not made.along(symbols.rates).is_zero:
            raise FreebodyError(
                f"{caller}: {name} = {text} changes with the motion; a parameter is constant."
            )
        if name in inertial:
            _refuse_negative(caller, f"{name} = {text}", made, symbols.model, inertial[name])
        found[name] = made
    return found


def inertial_names(model: Model) -> dict[str, str]:
    """Of the parameters that are never negative what each is: the mass of a body, or a moment of
    inertia."""
    found: dict[str, str] = {}
    for inertia in (x.inertia for body in model.bodies for x in body.inertias):
        moments = inertia.tensor if inertia.dim == 2 else inertia.tensor[0::3] + inertia.tensor[5:]
        for what, entries in (("mass", [inertia.mass]), ("moment of inertia", moments)):
            found |= {x.name: what for x in entries if isinstance(x, Parameter)}
    return found


def _refuse_negative(caller: str, formula: str, made: Trig, model: Model, what: str) -> None:
    """Refuse a mass or moment of inertia that is negative with the model's values."""
    known = {name: x for name, x in model.parameters.items() if isinstance(x, float)}
    terms = list(made.terms())
    parts = [
        float(k) * math.prod(known.get(x, 1.0) ** e for x, e in powers.items())
        for powers, k in terms
    ]
    names = {x for powers, _ in terms for x in powers}
    is_known = names <= set(known)
    total, size = sum(parts), sum(map(abs, parts))
    if (total if is_known else max(parts)) >= -_ROUNDED * size:
        return
    value = "is negative"
    if names and is_known:
        value = f"is {shortest(total)} with the values of {model.name!r}"
    raise FreebodyError(f"{caller}: {formula} {value}; a {what} is never negative.")


def _text(caller: str, name: str, formula: object) -> str:
    """A formula, or a number, as text."""
    if not isinstance(formula, str):
        return repr(finite(formula, f"{caller}: the parameter {name}"))
    if _NOT_FINITE.fullmatch(formula):
        raise _bad(caller, name, formula, FreebodyError("it is not a finite number"))
    return formula


def as_terms(values: Mapping[str, Trig]) -> Formulas:
    """Such values for `symbols`."""
    return tuple(
        (name, tuple((tuple(powers.items()), x) for powers, x in value.terms()))
        for name, value in values.items()
    )


def told(symbols: Symbols, layout: Layout) -> list[str]:
    """A sentence with the formulas that hold in what is derived."""
    ring = symbols.ring
    rows = [
        f"{sym(name)} = {layout.form(ring.polynomial((dict(x), k) for x, k in terms))}"
        for name, terms in symbols.formulas
    ]
    return [f"Here {listed(rows)}."] if rows else []


def _parsed(caller: str, name: str, formula: str) -> Expression:
    try:
        return parse(formula)
    except FormulaError as problem:
        raise _bad(caller, name, formula, problem) from None


def _bad(caller: str, name: str, formula: str, problem: FreebodyError) -> FreebodyError:
    own = problem.bare if isinstance(problem, FormulaError) else str(problem)
    return FreebodyError(f"{caller}: the parameter {name} = {formula}: {own.rstrip('.')}.")


def _of_each_link(
    caller: str, symbols: Symbols, name: str, formula: str
) -> Iterator[tuple[str, str]]:
    """A formula for one parameter, or that of a family for every link."""
    parameters = symbols.model.parameters
    if name in parameters:
        yield name, formula
        return
    of_links = (re.fullmatch(rf"{re.escape(name)}(\d+)", x) for x in parameters)
    numbers = [match[1] for match in of_links if match]
    if not numbers:
        raise UnknownNameError("parameter", name, repr(symbols.model.name), parameters)
    families = set(names_in(_parsed(caller, name, formula)))
    for k in numbers:
        own = re.sub(
            r"[^\W\d_]+(?![\w(])",
            lambda m, k=k: m[0] + k if m[0] in families and m[0] + k in parameters else m[0],
            formula,
        )
        yield name + k, own
