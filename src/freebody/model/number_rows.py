"""The rows of a structure's numbers, and the numbers of a model that each row is computed from, by
the same arithmetic as in `contributions` and so to the last bit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import chain
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freebody.model.contributions import (
    counted_laws,
    gravity_part,
    inertial_entries,
    linear_row,
    pose_part,
)
from freebody.model.drives import DriveLaw
from freebody.model.drives.acting import USUAL
from freebody.model.inertia import in_shape
from freebody.model.piece_paths import PiecePath
from freebody.model.placement import Placement, Shift
from freebody.model.quantity_reader import VALUES
from freebody.model.structure import own_frames
from freebody.model.tree import Attached
from freebody.spatial import Matrix, Vector, add, identity, of_dimension, times

if TYPE_CHECKING:
    from freebody.model.description import Drive
    from freebody.model.model import Model
    from freebody.model.parameters import Quantity
    from freebody.model.structure import Structure

SlotValues = list[float]
"""Numbers in the slots of a structure, by slot."""
TakeSlots = Callable[[Any], tuple[Any, ...]]
"""Picks the entries of several slots."""
RowEntries = Callable[[SlotValues, list[Vector]], Any]
"""Numbers of the structure, given the number in each slot and the positions of `NumberRows`; None
where the structure is another."""


class RowPart(NamedTuple):
    """A summand of a row of numbers: the slots that it depends on, the function of them, and its
    value now."""

    slots: frozenset[int]
    entries: RowEntries
    now: tuple[float, ...]


class NumberRow(NamedTuple):
    """A row of the structure's numbers: its place, and the summands that make it up."""

    at: slice
    parts: tuple[RowPart, ...]


class ShiftSum(NamedTuple):
    """The position that a placement leads to, as a sum of shifts, each in axes turned by a matrix
    (None: not turned)."""

    slots: frozenset[int]
    terms: tuple[tuple[Matrix | None, TakeSlots], ...]


class NumberRows:
    """The rows of the numbers of one robot that has all its values."""

    def __init__(self, model: Model, structure: Structure, named: dict[PiecePath, str]):
        """Collect the rows; named: paths of numbers that share a name and so a slot."""
        self._model, self._structure, self._named = model, structure, named
        self.space = of_dimension(model.dim)
        self.values: SlotValues = []
        self.at: dict[PiecePath, int] = {}
        """The slot that stands at a path."""
        self.by_name: dict[str, int] = {}
        self.owner: dict[int, str] = {}
        """The name of the number in a slot, where it has one."""
        self.inertias: dict[int, list[TakeSlots]] = {}
        """Functions that pick mass and tensor of the inertias to which a number belongs, by its
        slot."""
        self.below: dict[int, float] = {}
        """Bounds by slot: numbers not above 0, or not below their bound, have to be looked at
        closely."""
        self.positions: list[ShiftSum] = []
        self.places: list[Vector] = []
        """The points of `positions`."""
        self._index: dict[Any, int] = {}
        self.rows = tuple(self._all_rows())

    def _slot(self, path: PiecePath, quantity: Quantity) -> int:
        name = self._named.get(path)
        slot = None if name is None else self.by_name.get(name)
        if slot is None:
            slot = len(self.values)
            self.values.append(float(VALUES.quantity(quantity)))
            if name is not None:
                self.by_name[name], self.owner[slot] = slot, name
        self.at[path] = slot
        return slot

    def _all_rows(self) -> Iterable[NumberRow]:
        """Rows of all pieces of the model, in the order of the structure's numbers."""
        model, dim = self._model, self.space.dim
        for i, rows in zip(self._structure.order, self._structure.rows, strict=True):
            path, body = ("bodies", i), model.bodies[i]
            yield self._pose(body.joint.placement, (*path, "joint", "placement"), rows.position)
            if body.joint.numbers:
                yield self._own(body.joint.numbers, (*path, "joint", "numbers"), rows.joint)
            yield self._inertial(body.inertias, (*path, "inertias"), rows.inertia)
            if body.kind.nv == 1:
                yield self._drive(body.joint.drive, (*path, "joint", "drive"), rows.drive)
        start = self._structure.gravity
        yield self._gravity(start)
        start += len(gravity_part(model)[1])
        start += sum(loop.distance is not None for loop in model.loops)
        start += sum(len(strut.numbers) for strut in model.struts)
        end = start + (10 if dim == 3 else 4)
        yield self._inertial(model.base_inertias, ("base_inertias",), slice(start, end))
        at = {name: k for k, name in enumerate(model.frame_names)}
        for name in own_frames(model):
            k, frame = at[name], model.frame(name)
            part = pose_part(frame.placement, dim)
            start, end = end, end + len(part.numbers)
            shift = slice(end - np.count_nonzero(part.pose[1]), end)
            yield self._pose(frame.placement, ("frames", k, "placement"), shift)

    def _position(self, placement: Placement, path: PiecePath) -> int:
        """The index of the position that a placement leads to, which is added where it is new."""
        whole, terms, slots = identity(self.space.dim), [], []
        for k, step in enumerate(placement.steps):
            if isinstance(step, Shift):
                R, _ = Placement(placement.steps[:k]).lower(self.space, VALUES)
                those = [self._slot((*path, "steps", k, "by", j), x) for j, x in enumerate(step.by)]
                terms.append((None if R is whole else R, tuple(those)))
                slots += those
        key = tuple(terms)
        if key not in self._index:
            self._index[key] = len(self.positions)
            position = ShiftSum(frozenset(slots), tuple((R, itemgetter(*s)) for R, s in terms))
            self.positions.append(position)
            self.places.append(self.sum(len(self.places), self.values))
        return self._index[key]

    def sum(self, k: int, values: SlotValues) -> Vector:
        """The point of a position with index k, from the numbers in the slots, computed as
        `Placement.lower` does."""
        zero = p = self.space.zero
        for R, take in self.positions[k].terms:
            by = take(values)
            if by != zero:
                p = add(p, by if R is None else times(R, by))
        return p

    def _pose(self, placement: Placement, path: PiecePath, at: slice) -> NumberRow:
        k = self._position(placement, path)
        now = self.places[k]
        zeros = tuple([x == 0.0 for x in now])

        def entries(_: SlotValues, places: list[Vector]) -> Any:
            p = places[k]
            return (
                tuple([x for x in p if x != 0.0]) if tuple([x == 0.0 for x in p]) == zeros else None
            )

        return NumberRow(at, (RowPart(self.positions[k].slots, entries, now),))

    def _own(self, numbers: tuple[Quantity, ...], path: PiecePath, at: slice) -> NumberRow:
        """The row of the numbers of a joint's kind, such as a pitch."""
        those = [self._slot((*path, k), x) for k, x in enumerate(numbers)]

        def entries(values: SlotValues, _: list[Vector]) -> Any:
            return tuple([values[slot] for slot in those])

        return NumberRow(at, (RowPart(frozenset(those), entries, entries(self.values, [])),))

    def _inertial(self, parts: tuple[Attached, ...], path: PiecePath, at: slice) -> NumberRow:
        return NumberRow(at, tuple(self._part(part, (*path, k)) for k, part in enumerate(parts)))

    def _part(self, part: Attached, path: PiecePath) -> RowPart:
        inertia, own = part.inertia, (*path, "inertia")
        mass = self._slot((*own, "mass"), inertia.mass)
        com = [self._slot((*own, "com", j), x) for j, x in enumerate(inertia.com)]
        tensor = [self._slot((*own, "tensor", j), x) for j, x in enumerate(inertia.tensor)]
        for slot in {mass, *com, *tensor}:
            self.inertias.setdefault(slot, []).append(itemgetter(mass, *tensor))
        k = self._position(part.placement, (*path, "placement"))
        space, dim = self.space, self.space.dim
        R, _ = pose_part(part.placement, dim).pose
        take = itemgetter(mass, *com, *tensor)

        def entries(values: SlotValues, places: list[Vector]) -> Any:
            return inertial_entries(space, in_shape(dim, take(values)), (R, places[k]))

        slots = frozenset((mass, *com, *tensor)) | self.positions[k].slots
        return RowPart(slots, entries, tuple(linear_row(part, dim).tolist()))

    def _drive(self, drive: Drive, path: PiecePath, at: slice) -> NumberRow:
        """The row of a drive's numbers; it has no slots where no drive of the model acts."""
        laws, names, present = drive.listed_laws, counted_laws(drive), at.stop > at.start
        own = [
            [self._slot((*path, x.name), getattr(drive, x.name)) for x in law.numbers]
            for law in laws
        ]
        for law, slots in zip(laws, own, strict=True):
            for slot, x in zip(slots, law.numbers, strict=True):
                if x.refused is not None:
                    self.below[slot] = min(x.below, self.below.get(slot, x.below))
        strengths = [slots[0] for slots in own]
        kept, usual = names or USUAL, sum(law.usual for law in laws)
        each = [_scalars(law, s) for law, s in zip(laws, own, strict=True) if law.name in kept]

        def counting(values: SlotValues) -> tuple[bool, list[bool]]:
            acting = [values[slot] != 0.0 for slot in strengths]
            return True in acting, acting[usual:]

        def row(values: SlotValues) -> tuple[float, ...]:
            return tuple(chain.from_iterable([scalars(values) for scalars in each]))

        counted = counting(self.values)

        def entries(values: SlotValues, _: list[Vector]) -> Any:
            if counting(values) != counted:
                return None
            return row(values) if present else ()

        slots = frozenset(chain.from_iterable(own))
        return NumberRow(at, (RowPart(slots, entries, row(self.values)),))

    def _gravity(self, start: int) -> NumberRow:
        model = self._model
        slot = self._slot(("gravity_size",), model.gravity_size)
        zeros, now = gravity_part(model)
        along = [
            VALUES.quantity(x)
            for x, zero in zip(model.gravity_direction, zeros, strict=True)
            if not zero
        ]

        def entries(values: SlotValues, _: list[Vector]) -> Any:
            size = values[slot]
            return [size * x for x in along]

        part = RowPart(frozenset((slot,)), entries, tuple(now.tolist()))
        return NumberRow(slice(start, start + len(now)), (part,))


def _scalars(law: DriveLaw, slots: list[int]) -> TakeSlots:
    """The scalars of a law, given the number in each slot."""
    take = itemgetter(*slots) if len(slots) > 1 else lambda values: (values[slots[0]],)
    scalars = law.scalars
    return take if scalars is None else lambda values: scalars(*take(values))
