"""Copies of a model with a few numbers changed: their numbers are computed at once, their pieces on
first access.

An edited copy is a `NumberLayout` and its *edits*, {slot: number}; an edit of an edited copy is one
of the same layout, so that a row of changes keeps no row of models. Whatever is no plain change
(arrays of a family, angles, what has to be looked at closely or refused) is not done here: None
says so, and the general way answers.

A *slot* is a number that stands as it is at one place or several. From slots follow the numbers of
the model's structure, by the same arithmetic as in `contributions`, so to the last bit as in a
model made anew; of these only what a changed slot leads to is found again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from operator import add as plus
from typing import TYPE_CHECKING, Any, NamedTuple

from freebody.arrays import Array
from freebody.errors import FreebodyError, ModelError, UnknownNameError
from freebody.model import changes, named_numbers
from freebody.model.drives import LAWS, NUMBERS
from freebody.model.families import copied, fields_of
from freebody.model.inertia import Inertia, is_surely_physical
from freebody.model.named_numbers import known
from freebody.model.number_editors import NewPayloadEditor
from freebody.model.number_rows import NumberRows, RowEntries, RowPart, SlotValues
from freebody.model.parameters import LARGEST
from freebody.model.piece_paths import PiecePath, put
from freebody.model.strut_ends import strut_fault
from freebody.model.tree import Attached

if TYPE_CHECKING:
    from freebody.model.model import Model


Edits = dict[int, float]


def bound(model: Model, values: Mapping[Any, Any]) -> Model:
    """The model with other numbers; see `Model.bind`."""
    if "_layout" in model.__dict__ or _are_plain(model, values):
        result = _edited(model, values)
        if result is None:
            result = _asked(model, named_numbers.bind(model, values))
    else:
        result = named_numbers.bind(model, values)
    if problem := strut_fault(result):
        raise ModelError(f"bind: {problem}.")
    return result


_FURTHER = tuple(
    f".{number.label}"
    for law in LAWS.values()
    for number in law.numbers[1:]
    if not number.waits and number.below == math.inf
)
"""Ends of names of numbers that have no effect without their law's strength."""


def driven(model: Model, joint: str, given: Mapping[str, Any]) -> Model:
    """The model with another drive in a joint; see `Model.with_drive`."""
    for name in given:
        if name not in NUMBERS:
            raise UnknownNameError("number", name, "a drive", tuple(NUMBERS))
    named = {f"{joint}.{NUMBERS[name].label}": x for name, x in given.items()}
    found = _edited(model, named) if type(joint) is str else None
    if found is None or any(name.endswith(_FURTHER) for name in named):
        return _asked(model, changes.with_drive(model, joint, given))
    return found


def loaded(model: Model, inertia: Inertia, frame: str | None, name: str) -> Model:
    """The model with another load; see `Model.with_payload`."""
    found = _loaded(model, inertia, frame, name)
    if found is None:
        found = _asked(model, changes.with_payload(model, inertia, frame, name))
    return found


def _edited(model: Model, values: Mapping[Any, Any]) -> Model | None:
    """The model with other numbers, given by their full names; None where the layout of numbers
    does not allow it."""
    layout = _layout(model)
    if layout is None:
        return None
    edits: Edits = model.__dict__.get("_edits", _NO_EDITS)
    changed: list[int] = []
    if len(values) > 1 and not layout.aliases.isdisjoint(values):  # which may be given twice
        return None
    for name, value in values.items():
        if type(value) is not float:
            if not isinstance(value, (float, int)) or isinstance(value, bool):
                return None
            if not -LARGEST <= value <= LARGEST:
                return None
            value = float(value)
        if not -LARGEST <= value <= LARGEST:
            return None
        slot = layout.slots.get(name)
        if slot is None:
            load = layout.absent.get(name)
            if load is None:
                return None
            if value == 0.0:
                continue
            grown = layout.loaded(load.frame, load.name)
            if grown is None:
                return None
            edits = {grown.moved[slot]: x for slot, x in edits.items()}
            changed = [grown.moved[slot] for slot in changed]
            layout = grown.layout
            slot = layout.slots[name]
        if edits.get(slot, layout.rows.values[slot]) != value:
            edits = {**edits, slot: value}
            changed.append(slot)
    if not changed:
        return model
    filled = layout.filled(edits)
    return _copy(layout, edits, filled) if layout.is_physical(changed, filled) else None


def _loaded(model: Model, inertia: Inertia, frame: str | None, name: str) -> Model | None:
    """The model with a load, made from the layout of its numbers; None where the layout does not
    allow it."""
    layout = _layout(model)
    entries = inertia.mass, *inertia.com, *inertia.tensor
    if (
        layout is None
        or {*map(type, entries)} != _FLOAT
        or inertia.dim != layout.dim
        or not is_surely_physical(inertia.mass, inertia.tensor)
        or not (type(frame) in (str, type(None)) and type(name) is str)
    ):
        return None
    grown = layout.loaded(frame, name)
    if grown is None:
        return None
    edits = {grown.moved[slot]: x for slot, x in model.__dict__.get("_edits", _NO_EDITS).items()}
    for slot, x in zip(grown.slots, entries, strict=True):
        if x != 0.0:
            edits[slot] = x
    return _copy(grown.layout, edits, grown.layout.filled(edits))


_NO_EDITS: Edits = {}
_FLOAT = {float}


def _copy(layout: NumberLayout, edits: Edits, values: SlotValues) -> Model:
    copy = object.__new__(type(layout.origin))
    own = copy.__dict__
    own.update(layout.shared)
    own["_layout"], own["_edits"], own["_slot_values"] = layout, edits, values
    return copy


# ---------------------------------------------------------------- when it is worth while
def _layout(model: Model) -> NumberLayout | None:
    """The layout of a model's numbers, made only for models that are changed repeatedly, since it
    takes as long as many changes; None for others, for families and where values are missing."""
    own = model.__dict__
    if "_layout" in own:
        return own["_layout"]
    if _ASKED not in own:
        own[_ASKED] = True
        return None
    try:
        found = None if model.family else NumberLayout(model)
    except FreebodyError:  # said where the numbers are asked for
        found = None
    return own.setdefault("_layout", found)


_ASKED = "_asked_for_layout"


def _asked(model: Model, copy: Model) -> Model:
    """The copy, marked as one of a series of changes if the model is."""
    if _ASKED in model.__dict__:
        copy.__dict__[_ASKED] = True
    return copy


def _are_plain(model: Model, names: Iterable[Any]) -> bool:
    """Whether numbers of these names can be changed by the layout, as angles and limits cannot."""
    known = named_numbers.known(model)
    rows = [known.rows.get(str(known.aliases.get(name, name))) for name in names]
    return all(
        row is not None
        and row.sort not in ("direction", "limit")
        and not (row.sort == "placement" and row.unit == "rad")
        for row in rows
    )


# ---------------------------------------------------------------- pieces
class LazyPiece:
    """A field that an edited copy computes on first access and then keeps in the instance."""

    def __init__(self, name: str):
        self.name = name

    def __get__(self, model: Model | None, owner: type) -> Any:
        if model is None:
            return self
        own = model.__dict__
        if "_edits" not in own:
            raise AttributeError(f"{owner.__name__!r} object has no attribute {self.name!r}")
        layout: NumberLayout = own["_layout"]
        values = {layout.rows.owner[slot]: x for slot, x in own["_edits"].items()}
        # of two threads that look at the same moment, both take the pieces of the first
        whole = own.setdefault("_whole", named_numbers.written(layout.origin, values))
        for field in CHANGING:
            own.setdefault(field, getattr(whole, field))
        own.pop("_whole", None)
        return own[self.name]


def make_lazy(kind: type) -> None:
    """Make a class of models compute the pieces of edited copies lazily. A `__getattr__` could do
    so too, but would cost every call of every robot ten nanoseconds."""
    for name in CHANGING:
        setattr(kind, name, LazyPiece(name))


RowPlan = tuple[list[int], list[tuple[slice, list[RowEntries]]]]
"""The positions, and the rows with their parts, that are found again."""


class NumberLayout:
    """The places of a model's numbers in its arrays, for a single robot with all values."""

    def __init__(self, model: Model):
        self.origin = copied(model)  # no circle of references
        names = known(model)
        self.origin.__dict__["_catalogue"] = names
        self.dim = model.dim
        self.structure, self.numbers = model.structure, model.numbers
        alone = {name: row.editor.alone(self.origin, row.field) for name, row in names.rows.items()}
        named = {path: name for name, paths in alone.items() for path in paths}
        self.rows = rows = NumberRows(self.origin, self.structure, named)
        following = {formula.name for formula in model.formulas}
        self.slots = {
            name: rows.by_name[name]
            for name, paths in alone.items()
            if name in rows.by_name and all(map(self._leads, paths)) and name not in following
        }
        """The slots of the numbers that can be changed, by name and by the place where a symbol
        stands."""
        self.slots |= {
            alias: self.slots[name] for alias, name in names.aliases.items() if name in self.slots
        }
        self.aliases = names.aliases.keys()
        """Names that some of them have besides."""
        self.absent = {
            name: row.editor
            for name, row in names.rows.items()
            if isinstance(row.editor, NewPayloadEditor)
        }
        """The numbers of a load that is not there yet."""
        self.shared: dict[str, Any] = {
            name: getattr(model, name)
            for name in (*fields_of(type(model)), *_KINDS)
            if name not in CHANGING
        }
        self.shared["_catalogue"] = names
        """Attributes that all edited copies have in common."""
        self._plans: dict[tuple[int, ...], RowPlan] = {}
        self._loads: dict[tuple[Any, Any], LoadedLayout | None] = {}

    def _leads(self, path: PiecePath) -> bool:
        """Whether all results of changing the number at a path are known; a tree's frames depend on
        none of its numbers."""
        return path in self.rows.at or (path[0] == "frames" and path[-2] == "by")

    # ------------------------------------------------------------ what follows
    def filled(self, edits: dict[int, float]) -> SlotValues:
        """The number in each slot, with some slots edited."""
        values = self.rows.values.copy()
        for slot, value in edits.items():
            values[slot] = value
        return values

    def is_physical(self, slots: Iterable[int], values: SlotValues) -> bool:
        """Whether the inertias and drives that use these slots are surely physical."""
        for slot in slots:
            if slot in self.rows.below and not 0.0 < values[slot] < self.rows.below[slot]:
                return False
            for take in self.rows.inertias.get(slot, ()):
                mass, *tensor = take(values)
                if not is_surely_physical(mass, tensor):
                    return False
        return True

    def numbers_with(self, edits: dict[int, float], values: SlotValues) -> Array | None:
        """The structure's numbers with some slots edited, whose values include the edits; None
        where the edits change the structure."""
        slots = tuple(edits)
        positions, rows = self._plans.get(slots) or self._planned(slots)
        places = self.rows.places.copy()
        for k in positions:
            places[k] = self.rows.sum(k, values)
        numbers = self.numbers.copy()
        for at, parts in rows:
            row, *others = [entries(values, places) for entries in parts]
            if row is None:
                return None
            for other in others:
                row = tuple(map(plus, row, other))
            numbers[at] = row
        numbers.setflags(write=False)
        return numbers

    def _planned(self, slots: tuple[int, ...]) -> RowPlan:
        """The positions and rows of numbers that depend on the given slots."""
        touched = frozenset(slots)
        positions = [k for k, x in enumerate(self.rows.positions) if x.slots & touched]
        rows = []
        for at, parts in self.rows.rows:
            if any(part.slots & touched for part in parts):
                rows.append((at, [p.entries if p.slots & touched else _known(p) for p in parts]))
        if len(self._plans) >= _MOST:
            self._plans.clear()
        return self._plans.setdefault(slots, (positions, rows))

    # ------------------------------------------------------------ loads
    def loaded(self, frame: str | None, name: str) -> LoadedLayout | None:
        """The layout with another load; None on the first request, since most loads are used
        once."""
        key = frame, name
        if key in self._loads:
            return self._loads.get(key) or self._grown(key)
        if len(self._loads) >= _MOST_LOADS:
            self._loads.clear()
        self._loads[key] = None
        return None

    def _grown(self, key: tuple[str | None, str]) -> LoadedLayout:
        frame, name = key
        at = self.origin.frame(frame)
        added = Attached(name, Inertia.nothing(self.dim), at.placement, True, at.name)
        path = ("base_inertias",) if at.body < 0 else ("bodies", at.body, "inertias")
        there = self.origin.base_inertias if at.body < 0 else self.origin.bodies[at.body].inertias
        layout = NumberLayout(put(self.origin, path, (*there, added)))
        new, own = layout.rows.at, (*path, len(there), "inertia")
        slots = (
            new[*own, "mass"],
            *(new[*own, "com", j] for j in range(self.dim)),
            *(new[*own, "tensor", j] for j in range(len(added.inertia.tensor))),
        )
        moved = {slot: new[path] for path, slot in self.rows.at.items()}
        self._loads[key] = found = LoadedLayout(layout, moved, slots)
        return found


def _known(part: RowPart) -> RowEntries:
    return lambda values, places: part.now


class LoadedLayout(NamedTuple):
    """The layout of a model's numbers with one more load."""

    layout: NumberLayout
    moved: dict[int, int]
    """Slots of the layout without the load -> slots of the layout with it."""
    slots: tuple[int, ...]
    """The slots of the load: mass, centre, tensor."""


CHANGING = ("bodies", "frames", "base_inertias", "gravity_size")
"""The fields of a model that numbers in slots stand in."""
_KINDS = (
    *("coordinates", "nq", "nv", "position_names", "velocity_names", "passive", "driven"),
    "family",
)
"""Facts of a model that no number changes."""
_MOST, _MOST_LOADS = 64, 16
"""Plans, and layouts with a load more, that a layout keeps."""
