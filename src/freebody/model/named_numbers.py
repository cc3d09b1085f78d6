"""The numbers of a model by name: listed (`fb.parameters`), found by name or pattern, and changed
(`Model.bind`)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from freebody.arrays import Array
from freebody.errors import ModelError, UnknownNameError, likely, listed, shown
from freebody.lazy import kept
from freebody.model.families import Members, arrays_in, common_shape, is_array, members, one_family
from freebody.model.gravity import direction_fault
from freebody.model.inertia import faults
from freebody.model.loops import checked_distance
from freebody.model.number_names import PAYLOAD, Catalogue, ModelNumber, catalogue
from freebody.model.parameter_formulas import followed, with_formulas
from freebody.model.parameters import LARGEST, Parameter, Quantity, finite, real
from freebody.model.quantity_reader import EXACT
from freebody.outputs.display import TextTable
from freebody.outputs.text import legal
from freebody.values import ByValue

if TYPE_CHECKING:
    from freebody.model.model import Model

Name = str | tuple[str, ...]
"""A name as one text, its parts joined by dots, or as a tuple of its parts."""


@dataclass(frozen=True, eq=False)
class ModelParameter(ByValue):
    """The record of one number of a model.

    value: None where a symbol has none yet; of a family an array where members differ. structural:
    an exact zero or right angle of a placement, or of gravity's direction, which patterns leave
    out, as they do limits; a name in full takes them.
    """

    name: str
    parts: tuple[str, ...]
    value: float | Array | None
    unit: str
    what: str
    structural: bool = False
    limit: bool = False
    formula: str = ""
    """The formula that it follows from; patterns leave such a number out, too."""


class Parameters(Sequence[ModelParameter]):
    """All numbers of a model in order: a sequence of records that are also found by name, as text
    or as the parts of it."""

    def __init__(self, model: Model):
        self._catalogue = known(model)
        self._model = model
        self._records = tuple(_records(model, self._catalogue))
        self._at = {record.name: record for record in self._records}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all numbers, in their order."""
        return tuple(self._at)

    @property
    def values(self) -> Array:
        """Values (..., k) of all numbers in order, NaN where there is none; for a family its shape
        comes first."""
        columns = [np.nan if record.value is None else record.value for record in self._records]
        return np.stack(np.broadcast_arrays(*columns), axis=-1) if columns else np.zeros(0)

    def matching(self, pattern: Name) -> tuple[ModelParameter, ...]:
        """The records that a full name or a shell pattern (`*`, `?`, `[ab]`) matches; see
        `fb.kernel`, inputs=."""
        return tuple(
            self._at[name] for name in matching(self._catalogue, self, pattern, self._model)
        )

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, (str, tuple)):
            return self._at[found(self._catalogue, index, self._model)]
        return self._records[index]

    def __contains__(self, name: object) -> bool:
        return name in self._at or name in self._records

    def __len__(self) -> int:
        return len(self._records)

    def __iter__(self) -> Iterator[ModelParameter]:
        return iter(self._records)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Parameters) and self._records == other._records

    def __hash__(self) -> int:
        return hash(self._records)

    def __repr__(self) -> str:
        rows = [(legal(r.name), _cell(r.value), r.unit, _what(r)) for r in self._records]
        widths = [max((len(row[k]) for row in rows), default=0) for k in range(3)]
        return "\n".join(
            f"{name:<{widths[0]}}  {value:>{widths[1]}}  {unit:<{widths[2]}}  {what}"
            for name, value, unit, what in rows
        )

    def _repr_html_(self) -> str:
        rows = [(r.name, _cell(r.value), r.unit, _what(r)) for r in self._records]
        return TextTable(("name", "value", "unit", ""), rows).html(most=len(rows))


def _cell(value: float | Array | None) -> str:
    if value is None:
        return "?"
    if isinstance(value, np.ndarray):
        return f"{value.min():.6g} … {value.max():.6g}"
    return f"{value:.6g}"


def _what(record: ModelParameter) -> str:
    added = " (structural)" if record.structural else f" = {record.formula}" * bool(record.formula)
    return legal(record.what + added)


def parameters(model: Model) -> Parameters:
    """Every number that a model is made of, by name, with its value, unit and meaning.

    Names: forearm.mass, forearm.com.x, forearm.inertia.xx (about the centre of mass, in the link's
    axes), forearm.scale (a factor on mass and inertia, also on a mass that is bound with it; it is
    1 again afterwards); elbow.placement.x … yaw (where the joint sits in its parent link);
    elbow.friction.viscous, elbow.rotor.gear, elbow.spring.stiffness, elbow.limits.upper; elbow.a,
    elbow.alpha of a DH table; gravity (the field's size), gravity.direction.z; loop.distance;
    gas_spring.stiffness of struts; tool.placement.z of frames; payload.mass at the tip, zero where
    there is no load; and the model's own symbols (l1), which stand for the names of the places
    where they occur. Joints' axes and mimic ratios are structure and have no name. Names shared by
    two things are told apart by what they belong to: "joint:elbow.placement.x".
    """
    return Parameters(model)


def known(model: Model) -> Catalogue:
    """The model's catalogue of numbers, made once and passed on to copies whose numbers have the
    same places."""
    return kept(model, "_catalogue", catalogue, model)


def _records(model: Model, names: Catalogue) -> Iterator[ModelParameter]:
    read: dict[int, dict[str, Quantity]] = {}
    formulas = {x.name: x.text for x in model.formulas}
    for name, row in names.rows.items():
        fields = read.get(id(row.editor))
        if fields is None:
            fields = read[id(row.editor)] = row.editor.read(model)
        value = _plain(fields[row.field])
        structural = (row.sort == "placement" and _is_structural(value, row.unit)) or (
            row.sort == "direction" and isinstance(value, float) and value in (0.0, 1.0, -1.0)
        )
        yield ModelParameter(
            name,
            row.parts,
            value,
            row.unit,
            row.what,
            structural,
            row.sort == "limit",
            formulas.get(name, "") if row.sort == "symbol" else "",
        )


def _plain(value: Quantity | None) -> float | Array | None:
    if isinstance(value, Parameter):
        value = value.value
    if isinstance(value, Members):
        return value.array
    return None if value is None else float(value)  # type: ignore[arg-type]  # a parameter's value is no parameter


def _is_structural(value: float | Array | None, unit: str) -> bool:
    if not isinstance(value, float):
        return False
    if unit != "rad":
        return value == 0.0
    quarter = math.pi / 2
    return abs(value - round(value / quarter) * quarter) <= EXACT


# ---------------------------------------------------------------- names
def found(names: Catalogue, given: Name, model: Model) -> str:
    """The full name of a number, from its text, its parts or the place of its symbol; raises an
    error for others."""
    name = given
    if isinstance(given, tuple) and given and all(isinstance(part, str) for part in given):
        name = ".".join(given)
    if isinstance(name, str):
        if name in names.rows:
            return name
        if name in names.aliases:
            return names.aliases[name]
        if name in names.several:
            longer = listed(map(repr, names.several[name]))
            raise ModelError(
                f"{model.name!r}: several things have a number {name!r}; write {longer}."
            )
    _require_tip(model, name)
    symbols = model.parameters
    meant = isinstance(name, str) and "." not in name and likely(name, symbols)
    raise UnknownNameError("parameter", given, repr(model.name), symbols if meant else names.rows)


def _require_tip(model: Model, name: object) -> None:
    """Refuse the name of a number of the payload at the tip where the model has no tip."""
    if model.tip is None and isinstance(name, str) and name.startswith(f"{PAYLOAD}."):
        raise ModelError(
            f"{model.name!r} has no {name!r}, which would be of a load at the tip. "
            f"{model.tip_reason} Choose the tip with tip= (--tip)."
        )


def matching(
    names: Catalogue, records: Sequence[ModelParameter], pattern: Name, model: Model
) -> list[str]:
    """The names that one full name or one pattern matches, in the model's order."""
    if not _is_pattern(pattern, names):
        return [found(names, pattern, model)]
    usual = [r.name for r in records if not (r.structural or r.limit or r.formula)]
    meant = {name for name in usual if fnmatchcase(name, pattern)}
    meant |= {name for alias, name in names.aliases.items() if fnmatchcase(alias, pattern)} & set(
        usual
    )
    if not meant:
        _require_tip(model, pattern)
        raise ModelError(
            f"no parameter of {model.name!r} matches {shown(pattern)}."
            f"{_hint(records, usual, pattern)} fb.parameters(model).names lists them."
        )
    return [name for name in usual if name in meant]


def _is_pattern(given: Name, names: Catalogue) -> TypeGuard[str]:
    """Whether a text is a shell pattern, and not a name that contains such characters."""
    if not isinstance(given, str) or given in names.rows:
        return False
    if given in names.aliases or given in names.several:
        return False
    return not {*given}.isdisjoint("*?[")


def _hint(records: Sequence[ModelParameter], usual: Sequence[str], pattern: str) -> str:
    """A hint for a pattern that matches no usual name: a number that patterns leave out, or similar
    names."""
    left_out = [r for r in records if fnmatchcase(r.name, pattern)]
    for record in left_out:
        if record.structural:
            return f" {record.name!r} is an exact zero or right angle: write it in full."
    for record in left_out:
        if record.limit:
            return f" {record.name!r} is a limit, which no kernel reads: bind it instead."
    bare = pattern.translate({ord(c): None for c in "*?[]"})
    near = likely(bare, usual, 3)
    if not near and bare.strip("."):
        near = [name for name in usual if bare.strip(".") in name][:3]
    return f" Similar names: {', '.join(near)}." if near else ""


# ---------------------------------------------------------------- other numbers
def bind(model: Model, values: Mapping[Any, Any]) -> Model:
    """The model with other numbers; see `Model.bind`."""
    texts = {name: value for name, value in values.items() if isinstance(value, str)}
    if texts:
        given, (model, plain) = model, with_formulas(model, texts, values)
        _check(given, model)
        values = {**plain, **{x: value for x, value in values.items() if x not in texts}}
    names, following = known(model), {x.name: x.text for x in model.formulas}
    wanted: dict[str, Quantity] = {}
    for given, value in values.items():
        name = found(names, given, model)
        if names.rows[name].sort == "symbol" and name in following:
            raise ModelError(
                f"{model.name!r}: {name} follows from {following[name]}; bind what it follows "
                f"from, or set it free first: bind({name}={name!r})."
            )
        if name in wanted:
            raise ModelError(f"{model.name!r}: parameter {name!r} is given twice; give it once.")
        wanted[name] = _checked(names.rows[name], value, name)
    return written(model, wanted)


def _checked(row: ModelNumber, value: Any, name: str) -> float | Members:
    owner = f"parameter {name!r}"
    if type(value) is not float and is_array(value):
        return members(value, owner, math.inf if row.sort == "limit" else LARGEST)
    if row.sort == "limit":
        return real(value, owner)
    return finite(value, owner)


def written(model: Model, wanted: Mapping[str, Quantity]) -> Model:
    """The model with other numbers under some names; plain numbers are checked."""
    names = known(model)
    by_editor: dict[int, tuple[Any, dict[str, Quantity]]] = {}
    for name, value in wanted.items():
        row = names.rows[name]
        by_editor.setdefault(id(row.editor), (row.editor, {}))[1][row.field] = value
    result, same_places = model, True
    for editor, fields in sorted(by_editor.values(), key=lambda item: not item[0].first):
        old = editor.read(result, fields)
        other = {field: value for field, value in fields.items() if not _same(old[field], value)}
        if other:
            result = editor.write(result, other)
            same_places = same_places and editor.keeps_places
    if result is model:
        return model
    if result.formulas:
        result = followed(result)
    if same_places:
        result.__dict__["_catalogue"] = names
    _check(model, result)
    return one_family(result, model, *wanted.values())


def _same(old: Quantity, new: Quantity) -> bool:
    value = old.value if isinstance(old, Parameter) and not isinstance(new, Parameter) else old
    return bool(value == new)


def _check(old: Model, new: Model) -> None:
    """Refuse changed parts that no robot has; parts as before are accepted again."""
    bodies = [(b, a) for b, a in zip(old.bodies, new.bodies, strict=True) if a is not b]
    for before, after in _pairs(old, new, bodies):
        if before is None or before.inertia is not after.inertia:
            fault = faults(after.inertia)
            if fault:
                raise ModelError(
                    f"{new.name!r}: link {after.link!r}: {fault}. Bind a physical value."
                )
    if new.gravity_direction is not old.gravity_direction:
        fault = direction_fault(new.gravity_direction)
        if fault:
            raise ModelError(
                f"{new.name!r}: {fault}. Bind all its components, or use model.replace(gravity=)."
            )
    if new.loops is not old.loops:
        for loop in new.loops:
            checked_distance(loop)
    of = [(f"joint {a.joint.name!r}", b.joint.limits, a.joint.limits) for b, a in bodies]
    of += [(f"joint {a.joint.name!r}", b.joint.drive, a.joint.drive) for b, a in bodies]
    of += [(f"strut {a.name!r}", b, a) for b, a in zip(old.struts, new.struts, strict=True)]
    for what, before, after in of:
        if after is not before and (problem := after.fault()):
            raise ModelError(f"{new.name!r}: {what}: {problem}.")


def _pairs(old: Model, new: Model, bodies: list[tuple[Any, Any]]) -> Iterable[tuple[Any, Any]]:
    """Pairs of inertias of the old and the new model, of the base and of the given pairs of bodies;
    a new load is paired with None."""
    if new.base_inertias is not old.base_inertias:
        yield from _beside(old.base_inertias, new.base_inertias)
    for b, a in bodies:
        if a.inertias is not b.inertias:
            yield from _beside(b.inertias, a.inertias)


def _beside(old: tuple[Any, ...], new: tuple[Any, ...]) -> Iterable[tuple[Any, Any]]:
    return zip((*old, *(None,) * (len(new) - len(old))), new, strict=True)


def family(model: Model) -> tuple[int, ...]:
    """The shape of the family that a model is; () for one robot."""
    return common_shape(arrays_in(model), repr(model.name))
