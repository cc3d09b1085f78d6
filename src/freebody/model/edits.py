"""Copies of a model in which a few numbers are other: its numbers are found at once, its pieces
when somebody looks at them.

An edited copy is a `NumberLayout` and its *edits*, {slot: number}; an edit of an edited copy is one
of the same layout, so that a row of changes keeps no row of models. Whatever is no plain change
(arrays of a family, angles, what has to be looked at closely or refused) is not done here: None
says so, and the general way answers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from freebody.errors import FreebodyError
from freebody.model import changes, numbers
from freebody.model.inertia import Inertia, is_surely_physical
from freebody.model.layout import CHANGING, NumberLayout
from freebody.model.number_names import DRIVE
from freebody.model.number_rows import SlotValues
from freebody.model.parameters import LARGEST

if TYPE_CHECKING:
    from freebody.model.model import Model

Edits = dict[int, float]


def bound(model: Model, values: Mapping[Any, Any]) -> Model:
    """See `Model.bind`."""
    if "_layout" in model.__dict__ or _are_plain(model, values):
        found = _edited(model, values)
        return _asked(model, numbers.bind(model, values)) if found is None else found
    return numbers.bind(model, values)


def driven(model: Model, joint: str, given: Mapping[str, Any]) -> Model:
    """See `Model.with_drive`."""
    named = {f"{joint}.{DRIVE[name]}": x for name, x in given.items()}
    found = _edited(model, named) if type(joint) is str else None
    return _asked(model, changes.with_drive(model, joint, given)) if found is None else found


def loaded(model: Model, inertia: Inertia, frame: str | None, name: str) -> Model:
    """See `Model.with_payload`."""
    found = _loaded(model, inertia, frame, name)
    if found is None:
        found = _asked(model, changes.with_payload(model, inertia, frame, name))
    return found


def _edited(model: Model, values: Mapping[Any, Any]) -> Model | None:
    """The model with other numbers, by names in full."""
    layout = _layout(model)
    if layout is None:
        return None
    edits: Edits = model.__dict__.get("_edits", _NO_EDITS)
    changed: list[int] = []
    if len(values) > 1 and not layout.told.isdisjoint(values):  # which may be given twice
        return None
    for name, value in values.items():
        if type(value) is not float:
            if not isinstance(value, (float, int)) or not -LARGEST <= value <= LARGEST:
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
    """The model with a load."""
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
    """The model's layout, which takes as long to find as many changes: found when the model, or
    those that it is made from, have been changed before. None for families and where values are
    missing."""
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
    """The copy, which is one of a row of changes."""
    if _ASKED in model.__dict__:
        copy.__dict__[_ASKED] = True
    return copy


def _are_plain(model: Model, names: Iterable[Any]) -> bool:
    """Whether numbers of these names may have slots, as angles and limits do not."""
    known = numbers.known(model)
    rows = [known.rows.get(str(known.told.get(name, name))) for name in names]
    return all(
        row is not None
        and row.sort not in ("direction", "limit")
        and not (row.sort == "placement" and row.unit == "rad")
        for row in rows
    )


# ---------------------------------------------------------------- pieces
class LazyPiece:
    """A field that an edited copy has not yet; whatever has it keeps it in the instance, where it
    is found before this."""

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
        whole = own.setdefault("_whole", numbers.written(layout.origin, values))
        for field in CHANGING:
            own.setdefault(field, getattr(whole, field))
        own.pop("_whole", None)
        return own[self.name]


def make_lazy(kind: type) -> None:
    """Let the class of models find the pieces of edited copies. A `__getattr__` would do it too,
    but take ten nanoseconds from every call of every robot."""
    for name in CHANGING:
        setattr(kind, name, LazyPiece(name))
