"""Where each number of a model stands, and how another is put there: one mechanism for names,
values and inputs.

An *editor* knows one piece of the model (a placement, the inertia of a link, a drive): it reads the
numbers that the piece is made of, by field, and writes some of them. What is written may be a
number, one for each member of a family, or a parameter that a kernel reads as an input.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from freebody.errors import ModelError
from freebody.model.families import Members, NamedNumber, changed
from freebody.model.inertia import Inertia
from freebody.model.parameters import LARGEST, Parameter, ParameterProduct, Quantity, each_parameter
from freebody.model.piece_paths import Fields, Path, get, is_plain, put, put_at
from freebody.model.placement import Placement
from freebody.model.pose_editor import as_quantity, steps_to
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached
from freebody.spatial import AnySpace, of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model


TENSOR = {2: ("zz",), 3: ("xx", "xy", "xz", "yy", "yz", "zz")}
_TENSOR = {dim: tuple(f"inertia.{x}" for x in entries) for dim, entries in TENSOR.items()}
_CENTRE = {dim: tuple(f"com.{x}" for x in of_dimension(dim).axes) for dim in TENSOR}


class Editor(Protocol):
    """What reads and writes the numbers of one piece."""

    @property
    def first(self) -> bool:
        """Whether it writes at paths that others may move, and so goes before them."""
        ...

    @property
    def keeps_places(self) -> bool:
        """Whether all numbers stand where they stood after it has written."""
        ...

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        """Field -> number, symbol, or members: of all fields, or at least of those wanted."""
        ...

    def alone(self, model: Model, field: str) -> tuple[Path, ...]:
        """Where the number of a field stands as it is, if to write it is no more than to put
        another there."""
        ...

    def write(self, model: Model, values: Fields) -> Model:
        """The model with other numbers in some fields."""
        ...


@dataclass(frozen=True)
class Leaves:
    """A symbol, or an entry with a name of its own, wherever it stands."""

    paths: tuple[Path, ...]
    first = True
    keeps_places = True

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        return {"": get(model, self.paths[0])}

    def alone(self, model: Model, field: str) -> tuple[Path, ...]:
        return self.paths

    def write(self, model: Model, values: Fields) -> Model:
        value = values[""]
        old = get(model, self.paths[0])
        if not isinstance(value, Parameter):
            if isinstance(old, Parameter):
                value = Parameter(old.name, value)
            elif isinstance(value, Members):
                value = Members(value.array, old.name)
            else:
                value = NamedNumber(value, old.name)
        return put_at(model, self.paths, value)


@dataclass(frozen=True)
class PieceEntries:
    """Numbers that are each an attribute of a piece, or an entry of a tuple: field -> which."""

    path: Path
    steps: Mapping[str, str | int]
    first = False
    keeps_places = True

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        piece = get(model, self.path)
        return {field: get(piece, (step,)) for field, step in self.steps.items()}

    def alone(self, model: Model, field: str) -> tuple[Path, ...]:
        return ((*self.path, self.steps[field]),)

    def write(self, model: Model, values: Fields) -> Model:
        for field, value in values.items():
            model = put(model, (*self.path, self.steps[field]), value)
        return model


@dataclass(frozen=True)
class LinkInertiaEditor:
    """The inertia of a link, about its centre of mass and in the axes of the link; `scale` is a
    factor on all of it.

    frame: the link's, where the steps of the placement lead by way of it. Without, the numbers stay
    in the frame in which they are given.
    """

    path: Path
    frame: str | None
    space: AnySpace
    first = False
    keeps_places = True

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        part = get(model, self.path)
        if wanted is not None and _FACTORS.issuperset(wanted):
            return {"mass": part.inertia.mass, "scale": 1.0}
        return self._fields(self._told(model, part).inertia) | {"scale": 1.0}

    def alone(self, model: Model, field: str) -> tuple[Path, ...]:
        part, dim = get(model, self.path), self.space.dim
        if field == "mass":
            return ((*self.path, "inertia", "mass"),)
        if field == "scale" or self._told(model, part) is not part:
            return ()
        name, labels = ("com", _CENTRE[dim]) if field in _CENTRE[dim] else ("tensor", _TENSOR[dim])
        return ((*self.path, "inertia", name, labels.index(field)),)

    def write(self, model: Model, values: Fields) -> Model:
        part = get(model, self.path)
        factor = values.get("scale", 1.0)
        if not _FACTORS.issuperset(values):
            part = self._told(model, part)
        inertia = part.inertia
        other: dict[str, Any] = {"mass": _times(values.get("mass", inertia.mass), factor)}
        if len(values) > 1 or "mass" not in values:
            fields = self._fields(inertia) | dict(values)
            other["com"] = tuple([fields[label] for label in _CENTRE[self.space.dim]])
            other["tensor"] = tuple(
                [_times(fields[label], factor) for label in _TENSOR[self.space.dim]]
            )
        return put(model, self.path, changed(part, {"inertia": changed(inertia, other)}))

    def _fields(self, inertia: Inertia) -> dict[str, Quantity]:
        labels = ("mass", *_CENTRE[self.space.dim], *_TENSOR[self.space.dim])
        return dict(zip(labels, (inertia.mass, *inertia.com, *inertia.tensor), strict=True))

    def _told(self, model: Model, part: Attached) -> Attached:
        """The part with its inertia in the link's frame, where numbers alone lead there."""
        steps = part.placement.steps
        start = len(steps) if self.frame is None else steps_to(model, self.frame)
        inner = Placement(steps[start:])
        if not inner.steps or not is_plain((inner.steps, part.inertia)):
            return part
        R, p = inner.lower(self.space, VALUES)
        m, c, tensor = part.inertia.lower(VALUES)
        turned = self.space.inertia_matrix(self.space.turned_inertia(R, tensor))
        com = tuple(
            x + sum(a * b for a, b in zip(row, c, strict=True)) for x, row in zip(p, R, strict=True)
        )
        entries = tuple(turned[i][j] for i in range(len(turned)) for j in range(i, len(turned)))
        inertia = changed(
            part.inertia,
            {
                "mass": as_quantity(m),
                "com": tuple(map(as_quantity, com)),
                "tensor": tuple(map(as_quantity, entries)),
            },
        )
        return changed(part, {"inertia": inertia, "placement": Placement(steps[:start])})


@dataclass(frozen=True)
class NewPayloadEditor:
    """A load that is not there yet, at the tip."""

    name: str
    frame: str
    space: AnySpace
    first = False
    keeps_places = False

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        return dict.fromkeys(("mass", *_CENTRE[self.space.dim], *_TENSOR[self.space.dim]), 0.0)

    def alone(self, model: Model, field: str) -> tuple[Path, ...]:
        return ()

    def write(self, model: Model, values: Fields) -> Model:
        at = model.frame(self.frame)
        added = Attached(self.name, Inertia.nothing(self.space.dim), at.placement, True, self.frame)
        path = ("base_inertias",) if at.body < 0 else ("bodies", at.body, "inertias")
        there = get(model, path)
        grown = put(model, path, (*there, added))
        return LinkInertiaEditor((*path, len(there)), None, self.space).write(grown, values)


_FACTORS = frozenset({"mass", "scale"})
"""What is the same in any axes and about any point."""


def _times(x: Quantity, factor: Quantity) -> Quantity:
    """x · factor; of what a kernel reads, a product that it forms."""
    if isinstance(factor, float) and factor == 1.0:
        return x
    if any(each_parameter((x, factor))):
        return cast(Quantity, ParameterProduct((x, factor)))
    product = VALUES.quantity(x) * VALUES.quantity(factor)
    if np.max(np.abs(product)) > LARGEST:
        most = np.max(np.abs(VALUES.quantity(factor)))
        raise ModelError(
            f"scale: {most:g} makes a mass or inertia too large; numbers of a robot stay below "
            f"{LARGEST:g}."
        )
    return as_quantity(product)
