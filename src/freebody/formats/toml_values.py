"""Values of a robot's parameters in TOML: numbers and formulas from [parameters], and beneath these
what a template gives."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NoReturn

from freebody.errors import ModelError, UnknownNameError, listed, shown
from freebody.formats import toml_parts as parts
from freebody.formats.toml_table import TomlTable
from freebody.model.description import RobotDescription
from freebody.model.formula_text import renamed
from freebody.model.parameter_formulas import (
    ParameterFormula,
    ParameterFormulaError,
    formulas_of,
    of_link,
    refuse_negative,
)
from freebody.model.parameters import Parameter, Quantity, each_parameter, with_parameters
from freebody.outputs.number_text import compared


@dataclass(frozen=True)
class Beneath:
    """Values and formulas that a template gives the names of its robot, which a file may replace;
    `bound` are the names in whose place a file has put numbers."""

    numbers: Mapping[str, float] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    bound: Collection[str] = ()


def with_values(top: TomlTable, described: RobotDescription, beneath: Beneath) -> RobotDescription:
    """Values and formulas from [parameters], or from beneath, given to the names; every one in the
    file must be used, and no name may have two values."""
    table = _ParameterTable(top, described, beneath)
    known: dict[str, Quantity] = {
        name: value if name in beneath.bound and value is not None else Parameter(name, value)
        for name, value in table.values.items()
    }
    formulas = []
    for formula in table.in_order():
        given = {name: known[name] for name in formula.names}
        whole = replace(formula, arguments=tuple(given.values()))
        try:
            found = _among_numbers(whole, given)
            value = (found if found.names else whole).quantity()
        except ModelError as error:
            table.refuse(formula.name, str(error))
        if found.names:
            formulas.append(found)
        known[formula.name] = value if found.names or value.value is None else value.value

    def valued(parameter: Parameter) -> Quantity:
        return known[parameter.name]

    found = replace(with_parameters(described, valued), formulas=tuple(formulas))
    try:
        refuse_negative(
            found, {x.name: x.value for x in known.values() if isinstance(x, Parameter)}
        )
    except ParameterFormulaError as error:
        table.refuse(error.name, error.problem)
    return found


def _among_numbers(formula: ParameterFormula, given: Mapping[str, Quantity]) -> ParameterFormula:
    """The formula with numbers in the place of the names that stand for numbers."""
    numbers = {name: f"({x!r})" for name, x in given.items() if not isinstance(x, Parameter)}
    if not numbers:
        return formula
    made = ParameterFormula.of(formula.name, renamed(formula.text, numbers))
    return replace(made, arguments=tuple(given[name] for name in made.names))


class _ParameterTable:
    """The [parameters] table of a robot, each name in it standing for one parameter, for a
    parameter of all links, or for a number that only formulas use."""

    def __init__(self, top: TomlTable, described: RobotDescription, beneath: Beneath):
        self.top = top
        self.own = dict.fromkeys(p.name for p in each_parameter(described))
        numbers, texts = parts.parameter_table(top)
        asked = {**numbers, **texts}
        firm = {*asked, *beneath.bound}
        given = {key: x for key, x in beneath.numbers.items() if key not in asked}
        self.numbers = {**given, **numbers}
        self.texts = {key: x for key, x in beneath.texts.items() if key not in firm} | texts
        self.formulas: dict[str, ParameterFormula] = {}
        self.values: dict[str, float | None] = {}
        """Values of all parameters; None of those without value, and of those with formulas."""
        self._keys: dict[str, str] = {}
        self._take(self.own)
        self._take_those_of_all_links()
        for parameter in each_parameter(described):
            self._add_value(parameter)
        used = set(self._keys.values())
        for name in (x for x in asked if x not in used):
            given = [x for x in self.own if _stem(x) == name]
            problem = UnknownNameError("parameter", name, "the model", sorted(self.own))
            told = f"[parameters]: {name} is that of no link, as {listed(given)} have their own."
            top.refuse(told if given else str(problem), "parameters", name)

    def in_order(self) -> tuple[ParameterFormula, ...]:
        """The formulas of parameters in an order in which each follows those that it refers to."""
        try:
            return formulas_of(self.formulas, dict(sorted(self.values.items())))
        except ParameterFormulaError as error:
            self.refuse(error.name, error.problem)

    def refuse(self, name: str, problem: str) -> NoReturn:
        """Raise an error at the formula of a parameter."""
        self._refuse(name, self.formulas[name].text, problem, self._keys[name])

    def _refuse(self, name: str, text: str, problem: str, key: str) -> NoReturn:
        told = f"[parameters]: {name} = {shown(text)}: {problem.rstrip('.')}."
        self.top.refuse(told, "parameters", key)

    def _take(self, names: Iterable[str]) -> None:
        """Take the values and formulas of the given names from the table, and those of the names
        that their formulas use."""
        left = [*names]
        while left:
            name = left.pop()
            if name in self._keys:
                continue
            if name in self.numbers:
                self._keys[name], self.values[name] = name, self.numbers[name]
            elif name in self.texts:
                left += self._take_formula(name, name, self.texts[name])

    def _take_formula(self, name: str, key: str, text: str) -> tuple[str, ...]:
        """Enter a parameter's formula; returns the names that it uses."""
        formula = self._read(name, text, key)
        self._keys[name] = key
        if formula.names:
            self.formulas[name], self.values[name] = formula, None
        else:
            self.values[name] = formula.quantity().value
        return formula.names

    def _read(self, name: str, text: str, key: str = "") -> ParameterFormula:
        try:
            return ParameterFormula.of(name, text)
        except ParameterFormulaError as error:
            self._refuse(name, text, error.problem, key or name)

    def _take_those_of_all_links(self) -> None:
        """Take entries for all links, such as lc = "l/2" and m = 2, for the links without an entry
        of their own."""
        families: dict[str, list[str]] = defaultdict(list)
        for name in self.own:
            if name not in self._keys:
                families[_stem(name)].append(name)
        for key, names in families.items():
            if key in self._keys or key not in (self.numbers | self.texts):
                continue
            if key in self.numbers:
                self._keys |= dict.fromkeys(names, key)
                self.values |= dict.fromkeys(names, self.numbers[key])
                continue
            formula = self._read(key, self.texts[key])
            for name in names:
                text = of_link(name.removeprefix(key), formula.text, formula.names, self.own)
                self._take(self._take_formula(name, key, text))

    def _add_value(self, parameter: Parameter) -> None:
        name, own = parameter.name, parameter.value
        if own is not None and name in self.formulas:
            self.refuse(name, f"it has the value {own:g} elsewhere in the file; keep one")
        value = self.values.get(name)
        if value is None:
            self.values[name] = own
        if own is None or value is None or own == value:
            return
        at = ("parameters", self._keys[name]) if name in self._keys else ()
        one, other = compared(value, own, digits=6)
        self.top.refuse(f"{name!r} has two values, {one} and {other}; keep one.", *at)


def _stem(name: str) -> str:
    """A parameter's name without its number: lc of lc1."""
    return name.rstrip("0123456789")
