"""[parameters] of a robot in TOML: numbers, and formulas by which parameters follow from others."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import NoReturn

from freebody.errors import ModelError, UnknownNameError, listed, shown
from freebody.formats.toml_table import TomlTable, in_units
from freebody.model.description import RobotDescription
from freebody.model.parameter_formulas import (
    ParameterFormula,
    ParameterFormulaError,
    formulas_of,
    of_link,
    refuse_negative,
)
from freebody.model.parameters import Parameter, Quantity, each_parameter, with_parameters
from freebody.outputs.numbers import compared


def parameter_table(top: TomlTable) -> tuple[dict[str, float], dict[str, str]]:
    """Numbers and formulas by name."""
    table = top.table("parameters")
    if table is None:
        return {}, {}
    named = table.called("[parameters]")
    texts = {
        key: text
        for key, text in table.data.items()
        if isinstance(text, str) and text.strip() and in_units(text, "angle") is None
    }
    return {key: named.number(key, "angle") for key in table.data if key not in texts}, texts


def with_values(top: TomlTable, described: RobotDescription) -> RobotDescription:
    """Values and formulas from [parameters] given to the names; every one must be used, and no name
    may have two values."""
    table = _ParameterTable(top, described)
    known = {name: Parameter(name, value) for name, value in table.values.items()}
    formulas = []
    for formula in table.in_order():
        given = tuple(known[name] for name in formula.names)
        formulas.append(replace(formula, arguments=given))
        try:
            known[formula.name] = formulas[-1].quantity()
        except ModelError as error:
            table.refuse(formula.name, str(error))

    def valued(parameter: Parameter) -> Quantity:
        return known[parameter.name]

    found = replace(with_parameters(described, valued), formulas=tuple(formulas))
    try:
        refuse_negative(found, {name: x.value for name, x in known.items()})
    except ParameterFormulaError as error:
        table.refuse(error.name, error.problem)
    return found


class _ParameterTable:
    """The table, each name in it as that of parameters of the robot, of all links together, or of
    a number that formulas alone use."""

    def __init__(self, top: TomlTable, described: RobotDescription):
        self.top = top
        self.own = dict.fromkeys(p.name for p in each_parameter(described))
        self.numbers, self.texts = parameter_table(top)
        self.formulas: dict[str, ParameterFormula] = {}
        self.values: dict[str, float | None] = {}
        """Of all parameters; None of those without value, and of those with formulas."""
        self._keys: dict[str, str] = {}
        self._take(self.own)
        self._take_those_of_all_links()
        for parameter in each_parameter(described):
            self._add_value(parameter)
        unused = {*self.numbers, *self.texts} - set(self._keys.values())
        for name in (x for x in (*self.numbers, *self.texts) if x in unused):
            given = [x for x in self.own if _stem(x) == name]
            problem = UnknownNameError("parameter", name, "the model", sorted(self.own))
            told = f"[parameters]: {name} is that of no link, as {listed(given)} have their own."
            top.refuse(told if given else str(problem), "parameters", name)

    def in_order(self) -> tuple[ParameterFormula, ...]:
        """The formulas, each behind those that it names."""
        try:
            return formulas_of(self.formulas, dict(sorted(self.values.items())))
        except ParameterFormulaError as error:
            self.refuse(error.name, error.problem)

    def refuse(self, name: str, problem: str) -> NoReturn:
        """Refuse the formula of a parameter."""
        self._refuse(name, self.formulas[name].text, problem, self._keys[name])

    def _refuse(self, name: str, text: str, problem: str, key: str) -> NoReturn:
        told = f"[parameters]: {name} = {shown(text)}: {problem.rstrip('.')}."
        self.top.refuse(told, "parameters", key)

    def _take(self, names: Iterable[str]) -> None:
        """What the table says of these names, and of those in their formulas."""
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
        """The names in it."""
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
        """lc = "l/2" and m = 2, for the links whose own the table does not give."""
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
    """lc of lc1."""
    return name.rstrip("0123456789")
