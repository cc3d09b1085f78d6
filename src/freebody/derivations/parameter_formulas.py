"""Parameters given by formulas: lc = l/2 of every link, I1 = m1 l1²/12, or a number."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from freebody.derivations.expressions.expression import Expression
from freebody.derivations.expressions.printed_names import sym
from freebody.derivations.polynomials.symbols import Formulas, Symbols
from freebody.derivations.polynomials.textbook_form import Layout
from freebody.derivations.relations.formula import FormulaError, names_in, parse
from freebody.derivations.relations.formula_values import value
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.scalars.trig import Trig


def formulas_of(caller: str, symbols: Symbols, given: Mapping[str, str | float]) -> dict[str, Trig]:
    """The values of the parameters that formulas give, in the others; a name without its number is
    that of every link.

    Raises UnknownNameError, and FreebodyError for a formula that cannot be read, that changes with
    the motion, or that names a parameter given by a formula.
    """
    texts = {
        own: text
        for name, formula in given.items()
        for own, text in _of_each_link(caller, symbols, name, str(formula))
    }
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
        found[name] = made
    return found


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
