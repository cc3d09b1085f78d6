"""A model with the places of its numbers: what follows where one of them changes.

A *slot* is a number that stands as it is at one place or several. From slots follow the numbers of
the model's structure, by the same arithmetic as in `contributions`, so to the last bit as in a
model made anew; of these only what a changed slot leads to is found again.
"""

from __future__ import annotations

from collections.abc import Iterable
from operator import add as plus
from typing import TYPE_CHECKING, Any, NamedTuple

from freebody.arrays import Array
from freebody.model.families import copied, fields_of
from freebody.model.inertia import Inertia, is_surely_physical
from freebody.model.number_editors import NewPayloadEditor
from freebody.model.number_rows import NumberRows, RowEntries, RowPart, SlotValues
from freebody.model.numbers import known
from freebody.model.piece_paths import Path, put
from freebody.model.tree import Attached

if TYPE_CHECKING:
    from freebody.model.model import Model

RowPlan = tuple[list[int], list[tuple[slice, list[RowEntries]]]]
"""Which positions, and which rows by which parts, are found again."""


class NumberLayout:
    """The places of the numbers of a model that is one robot and has all values."""

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
            told: self.slots[name] for told, name in names.told.items() if name in self.slots
        }
        self.told = names.told.keys()
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
        """What edited copies have in common, as their attributes."""
        self._plans: dict[tuple[int, ...], RowPlan] = {}
        self._loads: dict[tuple[Any, Any], LoadedLayout | None] = {}

    def _leads(self, path: Path) -> bool:
        """Whether all that follows from the number at a path is known; frames of a tree are none of
        its numbers."""
        return path in self.rows.at or (path[0] == "frames" and path[-2] == "by")

    # ------------------------------------------------------------ what follows
    def filled(self, edits: dict[int, float]) -> SlotValues:
        """The number in each slot, other ones in some."""
        values = self.rows.values.copy()
        for slot, value in edits.items():
            values[slot] = value
        return values

    def is_physical(self, slots: Iterable[int], values: SlotValues) -> bool:
        """Whether the inertias that these slots belong to surely are those of rigid bodies, and
        the drives those of motors."""
        for slot in slots:
            if slot in self.rows.positive and values[slot] <= 0.0:
                return False
            for take in self.rows.inertias.get(slot, ()):
                mass, *tensor = take(values)
                if not is_surely_physical(mass, tensor):
                    return False
        return True

    def numbers_with(self, edits: dict[int, float], values: SlotValues) -> Array | None:
        """The numbers of the structure, those of `edits` being in the values; None where the
        structure is another."""
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
        """The positions and rows that follow from slots."""
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
        """The layout with a load more; None when it is first asked for, since most are once."""
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
    """A layout with a load more."""

    layout: NumberLayout
    moved: dict[int, int]
    """Slots before -> slots in it."""
    slots: tuple[int, ...]
    """Those of the load: mass, centre, tensor."""


CHANGING = ("bodies", "frames", "base_inertias", "gravity_size")
"""The fields of a model that numbers in slots stand in."""
_KINDS = (
    *("coordinates", "nq", "nv", "position_names", "velocity_names", "passive", "driven"),
    "family",
)
"""What no number changes."""
_MOST, _MOST_LOADS = 64, 16
"""Plans, and layouts with a load more, that a layout keeps."""
