"""Parameters that follow from others by formulas, such as lc1 = l1/2: the formulas are part of a
model, and after each change of numbers dependent values are computed again (`followed`)."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from graphlib import CycleError, TopologicalSorter
from math import prod
from typing import Any

import numpy as np

from freebody.elementary import Scalar
from freebody.errors import ModelError, UnknownNameError, shown
from freebody.model.families import Members, members
from freebody.model.formula_text import FormulaTextError, Powers, polynomial, renamed
from freebody.model.parameters import LARGEST, Parameter, Quantity, each_parameter, finite
from freebody.model.piece_paths import get, named_leaves, put_at
from freebody.outputs.number_text import shortest


@dataclass(frozen=True)
class ParameterFormula:
    """A parameter that is a polynomial in other parameters."""

    name: str
    text: str
    """The formula as it was written."""
    terms: tuple[tuple[Powers, Fraction], ...]
    names: tuple[str, ...]
    arguments: tuple[Quantity, ...]
    """The quantities that stand for these names."""

    @classmethod
    def of(cls, name: str, text: str) -> ParameterFormula:
        """The formula of a text, with arguments that have no values. Raises
        ParameterFormulaError."""
        try:
            terms = polynomial(text)
        except FormulaTextError as error:
            raise ParameterFormulaError(name, text, str(error)) from None
        names = tuple(dict.fromkeys(x for powers in terms for x, _ in powers))
        return cls(name, text, tuple(terms.items()), names, tuple(map(Parameter, names)))

    def value(
        self, read: Callable[[Quantity], Scalar], number: Callable[[Fraction], Scalar] | None = None
    ) -> Scalar:
        """The value of the formula over any scalars; read: gives an argument's scalar; number:
        gives that of an exact factor."""
        known = dict(zip(self.names, map(read, self.arguments), strict=True))
        total: Any = 0.0
        for powers, k in self.terms:
            x: Any = prod((known[name] ** exponent for name, exponent in powers), start=1.0)
            total = total + (_times(x, k) if number is None else x * number(k))
        return total

    def quantity(self) -> Parameter:
        """The parameter with the value that follows from its arguments, or, where they have none,
        one that depends on them."""
        known = [_value(x) for x in self.arguments]
        if any(value is None for value in known):
            return FollowingParameter(self.name, None, self)
        found, owner = self.value(_value), f"parameter {self.name!r}"
        if isinstance(found, np.ndarray):
            return Parameter(self.name, members(found, owner, LARGEST))
        return Parameter(self.name, finite(found, owner))


@dataclass(frozen=True)
class FollowingParameter(Parameter):
    """A parameter whose value is not known yet, or follows from a kernel's inputs."""

    formula: ParameterFormula | None = None

    @property
    def missing(self) -> tuple[str, ...]:
        arguments = self.formula.arguments if self.formula else ()
        return tuple(name for x in each_parameter(arguments) for name in x.missing)


def _value(x: Quantity) -> Any:
    value = x.value if isinstance(x, Parameter) else x
    return value.array if isinstance(value, Members) else value


def _times(x: Any, k: Fraction) -> Any:
    """The product x k, rounded as the quotient x/12 would be."""
    if max(abs(k.numerator), k.denominator) > 2**53:
        return x * float(k)
    return x * float(k.numerator) / float(k.denominator)


def of_each_link(
    name: str, text: str, names: Collection[str], parameters: Collection[str]
) -> dict[str, str]:
    """The formula by the parameter's name, or by lc1, lc2, … of every link for a name like lc;
    names: those used in it. Empty where there is no such parameter."""
    if name in parameters:
        return {name: text}
    of_links = (re.fullmatch(rf"{re.escape(name)}(\d+)", parameter) for parameter in parameters)
    return {x[0]: of_link(x[1], text, names, parameters) for x in of_links if x}


def of_link(number: str, text: str, names: Collection[str], parameters: Collection[str]) -> str:
    """A formula written for all links as that of one link: l/2 becomes l2/2."""
    return renamed(text, {x: x + number for x in names if x + number in parameters})


def formulas_of(
    made: Mapping[str, ParameterFormula], parameters: Mapping[str, Any]
) -> tuple[ParameterFormula, ...]:
    """Formulas by the names of their parameters, each behind those that it uses; parameters: all,
    with their values. Raises ParameterFormulaError."""
    for name, formula in made.items():
        for other in formula.names:
            if other not in parameters:
                problem = UnknownNameError("parameter", other, "the model", parameters)
                raise ParameterFormulaError(name, formula.text, str(problem))
    depth = dict.fromkeys(made, 0)
    uses = {name: [x for x in formula.names if x in made] for name, formula in made.items()}
    try:
        order = tuple(TopologicalSorter(uses).static_order())
    except CycleError as error:
        name, *others = reversed(error.args[1])
        circle = " from ".join([name, *others])
        problem = f"it is circular, {circle}; give one of them a number"
        raise ParameterFormulaError(name, made[name].text, problem) from None
    for name in order:
        depth[name] = 1 + max((depth[x] for x in uses[name]), default=0)
        if depth[name] > _LONGEST_CHAIN:
            problem = f"more than {_LONGEST_CHAIN} formulas follow from one another"
            raise ParameterFormulaError(name, made[name].text, problem)
    return tuple(
        replace(
            made[name],
            arguments=tuple(
                Parameter(x, None if x in made else parameters[x]) for x in made[name].names
            ),
        )
        for name in sorted(order, key=lambda x: (depth[x], x))
    )


_LONGEST_CHAIN = 50


class ParameterFormulaError(ModelError):
    """A formula that cannot define its parameter."""

    def __init__(self, name: str, text: str, problem: str):
        self.name, self.problem = name, problem
        super().__init__(f"parameter {name!r} = {shown(text)}: {problem.rstrip('.')}.")

    def __reduce__(self) -> tuple[Any, ...]:
        return ModelError, (str(self),)


def followed(model: Any) -> Any:
    """The model with the values of parameters that have formulas computed from the others."""
    leaves = named_leaves(model)
    for k in range(len(model.formulas)):
        found = model.formulas[k].quantity()
        paths = tuple(leaves.get((found.name,), ()))
        if any(get(model, path) != found for path in paths):
            model = put_at(model, paths, found)
    return model


def used(model: Any) -> tuple[ParameterFormula, ...]:
    """The formulas of a model that one of its parts depends on."""
    names = set(replace(model, formulas=()).parameters)
    kept = []
    for formula in reversed(model.formulas):
        if formula.name in names:
            names |= set(formula.names)
            kept.append(formula)
    return tuple(reversed(kept))


def with_formulas(
    model: Any, texts: Mapping[str, str], asked: Collection[Any]
) -> tuple[Any, dict[str, Quantity]]:
    """The model with formulas for some parameters in place of those they had, such as {"lc": "l/2"}
    for every link except those in `asked`; and the parameters that a constant text, such as "1/12",
    makes numbers."""
    known, made = model.parameters, {x.name: x for x in model.formulas}
    numbers: dict[str, Quantity] = {}
    for name, text in texts.items():
        formula = ParameterFormula.of(name, text)
        own = of_each_link(name, text, formula.names, known)
        if formula.names and not own:
            raise UnknownNameError("parameter", name, repr(model.name), known)
        for x in own or (name,):
            if x != name and x in asked:
                continue
            made.pop(x, None)
            if not formula.names:
                numbers[x] = formula.value(_value)
            elif own[x].strip() != x:  # lc1 = "lc1" is no formula
                made[x] = ParameterFormula.of(x, own[x])
    found = replace(model, formulas=formulas_of(made, known))
    found = followed(replace(found, formulas=used(found)))
    refuse_negative(found, found.parameters)
    return found, numbers


# ---------------------------------------------------------------- what no body has
def inertial_names(model: Any) -> dict[str, str]:
    """The parameters of a model or description that are never negative, each with its meaning: the
    mass of a body, or a moment of inertia."""
    found: dict[str, str] = {}
    bodies = getattr(model, "bodies", ())
    loads = () if bodies else (*model.links, *model.payloads)
    for inertia in (x.inertia for x in (*loads, *(x for body in bodies for x in body.inertias))):
        if inertia is None:
            continue
        moments = [inertia.tensor[k] for k in (0, 3, 5) if k < len(inertia.tensor)]
        for what, entries in (("mass", [inertia.mass]), ("moment of inertia", moments)):
            found |= {x.name: what for x in entries if isinstance(x, Parameter)}
    return found


def refuse_negative(model: Any, values: Mapping[str, Any]) -> None:
    """Refuse formulas that make masses or moments of inertia negative."""
    names = inertial_names(model)
    for formula in model.formulas:
        terms = ((dict(powers), k) for powers, k in formula.terms)
        fault = formula.name in names and negative(terms, values, model.name, names[formula.name])
        if fault:
            raise ParameterFormulaError(formula.name, formula.text, f"it {fault}")


def negative(
    terms: Iterable[tuple[Mapping[str, int], Fraction]],
    values: Mapping[str, Any],
    owner: str,
    what: str,
) -> str | None:
    """The reason why a mass or moment of inertia cannot be a polynomial (negative with the owner's
    values, or for all positive ones), or None."""
    known = {name: x for name, x in values.items() if isinstance(x, float)}
    terms = list(terms)
    parts = [float(k) * prod(known.get(x, 1.0) ** e for x, e in own.items()) for own, k in terms]
    names = {x for powers, _ in terms for x in powers}
    is_known = names <= set(known)
    total, size = sum(parts), sum(map(abs, parts))
    if (total if is_known else max(parts)) >= -_ROUNDED * size:
        return None
    value = "is negative"
    if names and is_known:
        value = f"is {shortest(total)} with the values of {owner!r}"
    return f"{value}; a {what} is never negative"


_ROUNDED = 1e-12
"""Share of a formula's terms that rounding may leave of their sum."""
