"""A model with the places of its numbers: what follows where one of them changes.

A *slot* is a number that stands as it is at one place or several. From slots follow the numbers of
the model's structure, by the same arithmetic as in `contributions`, so to the last bit as in a
model made anew; of these only what a changed slot leads to is found again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import add as plus
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.model.contributions import (
    acting,
    gravity_part,
    inertial_entries,
    linear_row,
    pose_part,
)
from freebody.model.families import copied, fields_of
from freebody.model.inertia import Inertia, in_shape, is_surely_physical
from freebody.model.number_editors import NewPayloadEditor, Path, put
from freebody.model.numbers import known
from freebody.model.placement import Placement, Shift
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached, drive_numbers
from freebody.spatial import Matrix, Vector, add, identity, of_dimension, times

if TYPE_CHECKING:
    from freebody.model.description import Drive
    from freebody.model.model import Model
    from freebody.model.parameters import Quantity

SlotValues = list[float]
"""The number in each slot."""
TakeSlots = Callable[[Any], tuple[Any, ...]]
"""Picks the entries of several slots."""
RowEntries = Callable[[SlotValues, list[Vector]], Any]
"""Numbers of the structure, given the leaves and the positions of `NumberLayout`; None where the
structure is another."""


class RowPart(NamedTuple):
    """What adds to a row of numbers: the slots that it follows from, how, and what it is."""

    slots: frozenset[int]
    entries: RowEntries
    now: tuple[float, ...]


class NumberRow(NamedTuple):
    """A row of the structure's numbers: where it stands, and what adds up to it."""

    at: slice
    parts: tuple[RowPart, ...]


RowPlan = tuple[list[int], list[tuple[slice, list[RowEntries]]]]
"""Which positions, and which blocks by which parts, are found again."""


class ShiftSum(NamedTuple):
    """Where a placement leads: the sum of its shifts, each in turned axes, where it is not None."""

    slots: frozenset[int]
    terms: tuple[tuple[Matrix | None, TakeSlots], ...]


class NumberLayout:
    """The places of the numbers of a model that is one robot and has all values."""

    def __init__(self, model: Model):
        self.origin = copied(model)  # no circle of references
        names = known(model)
        self.origin.__dict__["_catalogue"] = names
        self.space = of_dimension(model.dim)
        self.structure, self.numbers = model.structure, model.numbers
        self.leaves: SlotValues = []
        self.at: dict[Path, int] = {}
        """The slot that stands at a path."""
        self.owner: dict[int, str] = {}
        """The name of the number in a slot."""
        self.inertias: dict[int, list[TakeSlots]] = {}
        """Of a slot, what picks mass and tensor of the inertias that it belongs to."""
        self._positions: list[ShiftSum] = []
        self._places: list[Vector] = []
        self._index: dict[Any, int] = {}
        self._named: dict[Path, str] = {}
        alone = {name: row.editor.alone(self.origin, row.field) for name, row in names.rows.items()}
        for name, paths in alone.items():
            self._named.update(dict.fromkeys(paths, name))
        self._by_name: dict[str, int] = {}
        self._blocks = [*self._all_blocks()]
        self.slots = {
            name: self._by_name[name]
            for name, paths in alone.items()
            if name in self._by_name and all(map(self._leads, paths))
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
        return path in self.at or (path[0] == "frames" and path[-2] == "by")

    # ------------------------------------------------------------ what there is
    def _slot(self, path: Path, quantity: Quantity) -> int:
        name = self._named.get(path)
        slot = None if name is None else self._by_name.get(name)
        if slot is None:
            slot = len(self.leaves)
            self.leaves.append(float(VALUES.quantity(quantity)))
            if name is not None:
                self._by_name[name], self.owner[slot] = slot, name
        self.at[path] = slot
        return slot

    def _all_blocks(self) -> Iterable[NumberRow]:
        """In the order of the structure's numbers."""
        model, dim = self.origin, self.space.dim
        for i, rows in zip(self.structure.order, self.structure.rows, strict=True):
            path, body = ("bodies", i), model.bodies[i]
            yield self._pose(body.joint.placement, (*path, "joint", "placement"), rows.position)
            if body.joint.numbers:
                yield self._own(body.joint.numbers, (*path, "joint", "numbers"), rows.joint)
            yield self._inertial(body.inertias, (*path, "inertias"), rows.inertia)
            if body.kind.nv == 1:
                yield self._drive(body.joint.drive, (*path, "joint", "drive"), rows.drive)
        start = self.structure.gravity
        yield self._gravity(start)
        start += len(gravity_part(model)[1])
        start += sum(loop.distance is not None for loop in model.loops)
        end = start + (10 if dim == 3 else 4)
        yield self._inertial(model.base_inertias, ("base_inertias",), slice(start, end))
        for k, frame in enumerate(model.frames if model.loops else ()):
            part = pose_part(frame.placement, dim)
            start, end = end, end + len(part.numbers)
            shift = slice(end - np.count_nonzero(part.pose[1]), end)
            yield self._pose(frame.placement, ("frames", k, "placement"), shift)

    def _position(self, placement: Placement, path: Path) -> int:
        """Index of where a placement leads."""
        whole, terms, slots = identity(self.space.dim), [], []
        for k, step in enumerate(placement.steps):
            if isinstance(step, Shift):
                R, _ = Placement(placement.steps[:k]).lower(self.space, VALUES)
                those = [self._slot((*path, "steps", k, "by", j), x) for j, x in enumerate(step.by)]
                terms.append((None if R is whole else R, tuple(those)))
                slots += those
        key = tuple(terms)
        if key not in self._index:
            self._index[key] = len(self._positions)
            position = ShiftSum(frozenset(slots), tuple((R, itemgetter(*s)) for R, s in terms))
            self._positions.append(position)
            self._places.append(self._sum(position, self.leaves))
        return self._index[key]

    def _sum(self, position: ShiftSum, leaves: SlotValues) -> Vector:
        """As `Placement.lower` finds it."""
        zero = p = self.space.zero
        for R, take in position.terms:
            by = take(leaves)
            if by != zero:
                p = add(p, by if R is None else times(R, by))
        return p

    def _pose(self, placement: Placement, path: Path, at: slice) -> NumberRow:
        k = self._position(placement, path)
        now = self._places[k]
        zeros = tuple([x == 0.0 for x in now])

        def entries(_: SlotValues, places: list[Vector]) -> Any:
            p = places[k]
            return (
                tuple([x for x in p if x != 0.0]) if tuple([x == 0.0 for x in p]) == zeros else None
            )

        return NumberRow(at, (RowPart(self._positions[k].slots, entries, now),))

    def _own(self, numbers: tuple[Quantity, ...], path: Path, at: slice) -> NumberRow:
        """What a joint's kind has besides."""
        those = [self._slot((*path, k), x) for k, x in enumerate(numbers)]

        def entries(leaves: SlotValues, _: list[Vector]) -> Any:
            return tuple([leaves[slot] for slot in those])

        return NumberRow(at, (RowPart(frozenset(those), entries, entries(self.leaves, [])),))

    def _inertial(self, parts: tuple[Attached, ...], path: Path, at: slice) -> NumberRow:
        return NumberRow(at, tuple(self._part(part, (*path, k)) for k, part in enumerate(parts)))

    def _part(self, part: Attached, path: Path) -> RowPart:
        inertia, own = part.inertia, (*path, "inertia")
        mass = self._slot((*own, "mass"), inertia.mass)
        com = [self._slot((*own, "com", j), x) for j, x in enumerate(inertia.com)]
        tensor = [self._slot((*own, "tensor", j), x) for j, x in enumerate(inertia.tensor)]
        for slot in {mass, *com, *tensor}:
            self.inertias.setdefault(slot, []).append(itemgetter(mass, *tensor))
        k = self._position(part.placement, (*path, "placement"))
        (R, _), dim = pose_part(part.placement, self.space.dim).pose, self.space.dim
        take = itemgetter(mass, *com, *tensor)

        def entries(leaves: SlotValues, places: list[Vector]) -> Any:
            return inertial_entries(self.space, in_shape(dim, take(leaves)), (R, places[k]))

        slots = frozenset((mass, *com, *tensor)) | self._positions[k].slots
        return RowPart(slots, entries, tuple(linear_row(part, dim).tolist()))

    def _drive(self, drive: Drive, path: Path, at: slice) -> NumberRow:
        """Without a place among the numbers of a model none of whose drives acts."""
        those = [
            self._slot((*path, name), getattr(drive, name))
            for name in ("viscous", "coulomb", "rotor", "gear", "stiffness", "rest")
        ]
        take: TakeSlots = itemgetter(*those)
        now = drive_numbers(*take(self.leaves))
        acts, present = acting(now), at.stop > at.start

        def entries(leaves: SlotValues, _: list[Vector]) -> Any:
            found = drive_numbers(*take(leaves))
            return None if acting(found) != acts else found if present else ()

        return NumberRow(at, (RowPart(frozenset(those), entries, now),))

    def _gravity(self, start: int) -> NumberRow:
        model = self.origin
        slot = self._slot(("gravity_size",), model.gravity_size)
        zeros, now = gravity_part(model)
        along = [
            VALUES.quantity(x)
            for x, zero in zip(model.gravity_direction, zeros, strict=True)
            if not zero
        ]

        def entries(leaves: SlotValues, _: list[Vector]) -> Any:
            size = leaves[slot]
            return [size * x for x in along]

        part = RowPart(frozenset((slot,)), entries, tuple(now.tolist()))
        return NumberRow(slice(start, start + len(now)), (part,))

    # ------------------------------------------------------------ what follows
    def filled(self, edits: dict[int, float]) -> SlotValues:
        """The leaves, other numbers in some slots."""
        leaves = self.leaves.copy()
        for slot, value in edits.items():
            leaves[slot] = value
        return leaves

    def is_physical(self, slots: Iterable[int], leaves: SlotValues) -> bool:
        """Whether the inertias that these slots belong to surely are those of rigid bodies."""
        for slot in slots:
            for take in self.inertias.get(slot, ()):
                mass, *tensor = take(leaves)
                if not is_surely_physical(mass, tensor):
                    return False
        return True

    def numbers_with(self, edits: dict[int, float], leaves: SlotValues) -> Array | None:
        """The numbers of the structure, those of `edits` being in the leaves; None where the
        structure is another."""
        slots = tuple(edits)
        positions, blocks = self._plans.get(slots) or self._planned(slots)
        places = self._places.copy()
        for k in positions:
            places[k] = self._sum(self._positions[k], leaves)
        numbers = self.numbers.copy()
        for at, parts in blocks:
            row, *others = [entries(leaves, places) for entries in parts]
            if row is None:
                return None
            for other in others:
                row = tuple(map(plus, row, other))
            numbers[at] = row
        numbers.setflags(write=False)
        return numbers

    def _planned(self, slots: tuple[int, ...]) -> RowPlan:
        """The positions and blocks that follow from slots."""
        touched = frozenset(slots)
        positions = [k for k, x in enumerate(self._positions) if x.slots & touched]
        blocks = []
        for at, parts in self._blocks:
            if any(part.slots & touched for part in parts):
                blocks.append((at, [p.entries if p.slots & touched else _known(p) for p in parts]))
        if len(self._plans) >= _MOST:
            self._plans.clear()
        return self._plans.setdefault(slots, (positions, blocks))

    # ------------------------------------------------------------ loads
    def loaded(self, frame: str | None, name: str) -> LoadedLayout | None:
        """The layout with a load more; None when it is first asked for, since most are once."""
        key = frame, name
        if key not in self._loads:
            if len(self._loads) >= _MOST:
                self._loads.clear()
            self._loads[key] = None
            return None
        return self._loads[key] or self._grown(key)

    def _grown(self, key: tuple[str | None, str]) -> LoadedLayout:
        frame, name = key
        at = self.origin.frame(frame)
        added = Attached(name, Inertia.nothing(self.space.dim), at.placement, True, at.name)
        path = ("base_inertias",) if at.body < 0 else ("bodies", at.body, "inertias")
        there = self.origin.base_inertias if at.body < 0 else self.origin.bodies[at.body].inertias
        layout = NumberLayout(put(self.origin, path, (*there, added)))
        own = (*path, len(there), "inertia")
        slots = (
            layout.at[*own, "mass"],
            *(layout.at[*own, "com", j] for j in range(self.space.dim)),
            *(layout.at[*own, "tensor", j] for j in range(len(added.inertia.tensor))),
        )
        moved = {slot: layout.at[path] for path, slot in self.at.items()}
        self._loads[key] = found = LoadedLayout(layout, moved, slots)
        return found


def _known(part: RowPart) -> RowEntries:
    return lambda leaves, places: part.now


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
_MOST = 64
"""Plans, and loads, that a layout keeps."""
