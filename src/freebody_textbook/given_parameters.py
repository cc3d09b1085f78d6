"""Parameters given by formulas in a derivation or an answer: lc = l/2 for every link, I1 = m1
l1²/12, or numbers."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import replace

from freebody.errors import FreebodyError, UnknownNameError, likely, listed
from freebody.expressions.expression import Expression
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.polynomials.symbols import Formulas, Symbols
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.expressions.printed_names import sym
from freebody.model.model import Model
from freebody.model.parameter_formulas import (
    ParameterFormula,
    inertial_names,
    negative,
    of_each_link,
    of_link,
)
from freebody.model.parameter_formulas import formulas_of as ordered
from freebody.model.parameters import finite
from freebody.scalars.trig import Trig
from freebody_textbook.relations.formula import FormulaError, names_in, parse
from freebody_textbook.relations.formula_values import value

_MOVING = ("theta", "d", "q", "tau")
"""Letters of coordinates and of torques, which no constant of one's own may have."""
_ROD = "l"
"""The letter of a body's own length, which an arm has only where another joint or the tip
follows."""
_NOT_FINITE = re.compile(r"\s*[-+]?(?:nan|inf(?:inity)?)\s*", re.IGNORECASE)


def formulas_of(caller: str, symbols: Symbols, given: Mapping[str, str | float]) -> dict[str, Trig]:
    """Values of the parameters given by formulas, as polynomials in the others; a name without
    number applies to every link.

    Raises UnknownNameError, and FreebodyError for a formula that cannot be read, that changes with
    the motion, that names a parameter given by a formula, or that makes a mass or a moment of
    inertia negative: with the model's values, and where it has none for all positive ones.
    """
    texts = {
        own: text
        for name, formula in given.items()
        for own, text in _of_each_link(
            caller, symbols, name, _formula_text(caller, name, formula)
        ).items()
        if text.strip() != own  # its own name
    }
    inertial = inertial_names(symbols.model)
    known = {name: symbols.ring[name] for name in symbols.ring.names} | symbols.followed({})
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
            model = symbols.model
            fault = negative(made.terms(), model.parameters, model.name, inertial[name])
            if fault:
                raise FreebodyError(f"{caller}: {name} = {text} {fault}.")
        found[name] = made
    return found


def _formula_text(caller: str, name: str, formula: object) -> str:
    """Text of a parameter's formula or number."""
    if not isinstance(formula, str):
        return repr(finite(formula, f"{caller}: the parameter {name}"))
    if _NOT_FINITE.fullmatch(formula):
        raise _bad(caller, name, formula, FreebodyError("it is not a finite number"))
    return formula


def as_terms(values: Mapping[str, Trig]) -> Formulas:
    """Parameter values in the form that `symbols` accepts."""
    return tuple(
        (name, tuple((tuple(powers.items()), x) for powers, x in value.terms()))
        for name, value in values.items()
    )


def _values_of(symbols: Symbols) -> dict[str, Trig]:
    """Values of the parameters that formulas in `symbols` give."""
    polynomial = symbols.ring.polynomial
    return {name: polynomial((dict(x), k) for x, k in terms) for name, terms in symbols.formulas}


def prepared(model: Model, given: Mapping[str, str | float]) -> Model:
    """A copy of the model for parameters that are given by formulas: without its own formulas for
    these, and with the letters that the formulas have and the model lacks, such as the length l2 of
    a rod that slides, or a radius r."""
    if not given:
        return model
    model = model.bind({name: name for name in given}) if model.formulas else model
    known = model.parameters
    found = _with_letters(model, known, given)
    if not found:
        return model
    letters = dict.fromkeys(x for formula in found.values() for x in formula.names)
    formulas = {x.name: x for x in model.formulas} | found
    return replace(model, formulas=ordered(formulas, letters | known))


def _with_letters(
    model: Model, known: Collection[str], given: Mapping[str, str | float]
) -> dict[str, ParameterFormula]:
    """The given formulas that have letters of their own, by the parameter that each gives."""
    lengths = {f"{_ROD}{k}" for k in range(1, len(model.bodies) + 1)} if model.dim == 2 else set()
    found = {}
    for name, text in given.items():
        if not isinstance(text, str):
            continue
        for own in of_each_link(name, text, (), known):
            with suppress(FreebodyError):  # told where all formulas are read
                names = names_in(parse(text))
                number = own.removeprefix(name)
                written = of_link(number, text, names, {*known, *lengths}) if number else text
                formula = ParameterFormula.of(own, written)
                letters = {x for x in formula.names if x not in known}
                if letters and all(_is_own(x, known, lengths) for x in letters):
                    found[own] = formula
    return found


def _is_own(name: str, known: Collection[str], lengths: Collection[str]) -> bool:
    """Whether a name is a letter of the user's own, rather than a misspelt parameter, gravity, a
    coordinate with its rates, or a torque."""
    if name in lengths:
        return True
    letter = atom(name)
    reserved = bool(letter.dots) or letter.letter in ("g", *_MOVING)
    return not (reserved or likely(name, known))


def formulas_in_words(symbols: Symbols, layout: Layout) -> list[str]:
    """A sentence with the parameter formulas that are used in a derivation."""
    if not symbols.follows:
        return []
    rows = [
        f"{sym(name)} = {layout.form(x)}"
        for name, x in symbols.followed(_values_of(symbols)).items()
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


def _of_each_link(caller: str, symbols: Symbols, name: str, formula: str) -> dict[str, str]:
    """A formula for one parameter, or for the parameters with that letter of every link."""
    parameters = symbols.model.parameters
    names = () if name in parameters else names_in(_parsed(caller, name, formula))
    found = of_each_link(name, formula, names, parameters)
    if not found:
        raise UnknownNameError("parameter", name, repr(symbols.model.name), parameters)
    return found
