"""freebody's own format in TOML: a robot as a person would write it down, with the values and
formulas of its parameters. docs/formats.md is its reference."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Literal, NoReturn

from freebody.errors import ModelError, UnknownNameError, listed, shown
from freebody.formats import toml_parts as parts
from freebody.formats.toml_table import TomlTable, table_of
from freebody.model import dh, planar_arms
from freebody.model.description import Link, Mount, RobotDescription
from freebody.model.doubts import DOUBT_KINDS, Doubt
from freebody.model.parameter_formulas import (
    ParameterFormula,
    ParameterFormulaError,
    formulas_of,
    of_link,
    refuse_negative,
)
from freebody.model.parameters import Parameter, Quantity, each_parameter, with_parameters
from freebody.outputs.number_text import compared

_TOLD_KINDS = [kind for kind in DOUBT_KINDS.values() if kind.key]
_GENERAL = (
    "name",
    "dim",
    "source",
    "about",
    "gravity",
    "tip",
    "base",
    "parameters",
    "frame",
    "payload",
    "loop",
    "loop_tolerance",
    "strut",
    "home",
    *(kind.key for kind in _TOLD_KINDS),
)
_TREE = ("link", "joint")
_BASES: tuple[Literal["fixed", "free"], ...] = ("fixed", "free")

_DH_NUMBERS = {
    "theta": "angle",
    "d": "number",
    "a": "number",
    "alpha": "angle",
    "rotor": "number",
    "gear": "number",
    "m": "number",
}
_DH_ROW = ("joint", "name", "joint_name", *_DH_NUMBERS, "com", "I", "friction", "limits", "passive")


def describe(file: str, text: str, *, name: str) -> RobotDescription:
    """The description in a TOML text. `name` stands in where the file gives none. Raises FileError
    with the line."""
    top = table_of(file, text)
    top.only(*_GENERAL, *_TREE, "planar", "dh")
    forms = [key for key in ("planar", "dh") if key in top]
    if len(forms) > 1 or (forms and any(key in top for key in _TREE)):
        top.refuse(
            f"[{forms[0]}] describes the whole arm; remove the other links and joints.", forms[0]
        )
    try:
        described = _FORMS[forms[0] if forms else "tree"](top)
    except ModelError as error:
        top.refuse(str(error), *forms)
    mounts = _mounts(top, described)
    names = [part.name for part in (*described.links, *mounts)]
    extra = replace(
        described,
        name=top.text("name", name),
        mounts=mounts,
        loops=tuple(parts.loop(t, described.dim) for t in top.tables("loop")),
        struts=tuple(map(parts.strut, top.tables("strut"))),
        payloads=tuple(parts.payload(t, described.dim, names) for t in top.tables("payload")),
        base=top.choice("base", _BASES, "fixed"),
        loop_tolerance=parts.loop_tolerance(top),
        home=parts.home(top, described.joints),
        tip=top.choice("tip", names, described.tip) if "tip" in top else described.tip,
        source=top.text("source", ""),
        about=top.text("about", ""),
        notices=tuple(
            Doubt(kind.name, text, file) for kind in _TOLD_KINDS for text in _texts(top, kind.key)
        ),
        file=file,
    )
    return _with_values(top, extra)


def _mounts(top: TomlTable, described: RobotDescription) -> tuple[Mount, ...]:
    """The frames that a description already has, then those of the file's [[frame]] tables."""
    found = list(described.mounts)
    # a dict for its order: an error lists the names in the order of the file
    names = dict.fromkeys(part.name for part in (*described.links, *found))
    for table in top.tables("frame"):
        found.append(parts.mount(table, described.dim, names))
        if found[-1].name in names:
            table.refuse(f"frame {found[-1].name!r}: the name is taken; rename it.", "name")
        names[found[-1].name] = None
    return tuple(found)


def _tree(top: TomlTable) -> RobotDescription:
    """Description of a robot whose file lists links and joints."""
    dim = int(given) if (given := top.number("dim", default=3.0)) in (2.0, 3.0) else 0
    if not dim:
        top.refuse(f"dim is {top.data['dim']}, expected 2 (the plane) or 3 (space).", "dim")
    links = tuple(parts.link(t, dim) for t in top.tables("link"))
    if not links:
        top.refuse("there are no links; write a [[link]] for each body, the base included.")
    tables = top.tables("joint")
    whole = [parts.flexible(table, parts.joint(table, dim)) for table in tables]
    joints = tuple(joint for found, _ in whole for joint in found)
    flexible = [found[0].name for found, _ in whole if len(found) > 1]
    for table, joint in zip(tables, (found[0] for found, _ in whole), strict=True):
        if joint.mimic is not None and joint.mimic.joint in flexible:
            problem = f"joint {joint.mimic.joint!r} is flexible, and its rotor would be followed"
            table.refuse(f"joint {joint.name!r}: {problem}; leave one of the two out.", "mimic")
    links = (*links, *(link for _, found in whole for link in found))
    return RobotDescription("", dim, links, joints, parts.gravity(top, dim))


def _planar(top: TomlTable) -> RobotDescription:
    """The description of a planar arm that is given as a word over R and P."""
    if "dim" in top and top.data["dim"] != 2:
        top.refuse("a [planar] arm has dim = 2; remove dim.", "dim")
    inner = top.inner(top.data["planar"], "planar").called("[planar]")
    inner.only("word", "l", "lc", "m", "I", "angles", "limits", "drives", "passive")
    word = inner.text("word")
    given: dict[str, Any] = {
        key: inner.quantities(key, len(word), default=None) for key in ("l", "lc", "m", "I")
    }
    limits = [
        parts.limits_of(t, angles=word[i : i + 1] == "R")
        for i, t in enumerate(inner.tables("limits"))
    ]
    drives = [
        parts.drive(t.only(*parts.DRIVE), angles=word[i : i + 1] == "R")
        for i, t in enumerate(inner.tables("drives"))
    ]
    described = planar_arms.describe(
        word,
        **given,
        angles=inner.vector("angles", len(word), "angle", None),
        limits=limits or None,
        drives=drives or None,
        passive=_texts(inner, "passive"),
    )
    links = tuple(_on_line(link, inner.line) for link in described.links)
    return replace(described, links=links, gravity=parts.gravity(top, 2))


def _texts(table: TomlTable, key: str) -> list[str]:
    """A list of names in a table; empty where the key is absent."""
    names = table.data.get(key, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        table.refuse(f'{key} is {names!r}, expected a list of names such as ["joint2"].', key)
    return names


def _dh(top: TomlTable) -> RobotDescription:
    """A serial arm from a Denavit-Hartenberg table."""
    if "dim" in top and top.data["dim"] != 3:
        top.refuse("a [dh] arm has dim = 3; remove dim.", "dim")
    inner = top.inner(top.data["dh"], "dh").called("[dh]").only("convention", "rows")
    convention: Any = inner.choice("convention", ("standard", "modified"))
    tables = inner.tables("rows")
    rows = [_dh_row(t.called(f"dh row {i + 1}")) for i, t in enumerate(tables)]
    described = dh.describe(
        [{key: value for key, value in row.items() if key != "joint_name"} for row in rows],
        convention=convention,
        file=top.file,
        lines=[t.line or 0 for t in tables],
        joint_names=[row.get("joint_name") for row in rows],
    )
    return replace(described, gravity=parts.gravity(top, 3))


def _dh_row(table: TomlTable) -> dict[str, Any]:
    """One row of a DH table, as `fb.dh` takes it, and joint_name."""
    table.only(*_DH_ROW)
    row: dict[str, Any] = {
        key: table.quantity(key, kind) for key, kind in _DH_NUMBERS.items() if key in table
    }
    row["joint"] = table.choice("joint", "RP", "R")
    for key in ("name", "joint_name"):
        if key in table:
            row[key] = table.text(key)
    if "com" in table:
        row["com"] = table.quantities("com", 3)
    if "I" in table:
        full = isinstance(table.data["I"], list) and len(table.data["I"]) == 3
        row["I"] = table.matrix("I", 3) if full else table.quantities("I", 6)
    if "friction" in table:
        inner = table.inner(table.data["friction"], "friction")
        row["friction"] = parts.drive_numbers(inner, "friction", angles=row["joint"] == "R")
    if "limits" in table:
        row["limits"] = parts.limits(table, angles=row["joint"] == "R")
    row["passive"] = table.flag("passive")
    return row


_FORMS = {"tree": _tree, "planar": _planar, "dh": _dh}


def _on_line(link: Link, line: int | None) -> Link:
    return replace(link, line=line)


def _with_values(top: TomlTable, described: RobotDescription) -> RobotDescription:
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
    """The [parameters] table of a robot, each name in it standing for one parameter, for a
    parameter of all links, or for a number that only formulas use."""

    def __init__(self, top: TomlTable, described: RobotDescription):
        self.top = top
        self.own = dict.fromkeys(p.name for p in each_parameter(described))
        self.numbers, self.texts = parts.parameter_table(top)
        self.formulas: dict[str, ParameterFormula] = {}
        self.values: dict[str, float | None] = {}
        """Values of all parameters; None of those without value, and of those with formulas."""
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
