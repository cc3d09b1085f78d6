"""Names of all numbers that a model is made of, which `fb.parameters` lists, `bind` sets and
kernels take as inputs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from freebody.model.bodies import Body, Frame
from freebody.model.number_editors import (
    ANGLES,
    TENSOR,
    Editor,
    Leaves,
    LinkInertiaEditor,
    NewPayloadEditor,
    PieceEntries,
    PoseEditor,
)
from freebody.model.piece_paths import PiecePath, get, is_plain, named_leaves
from freebody.model.struts import NUMBERS as STRUT_NUMBERS
from freebody.model.tree import Attached
from freebody.spatial import AnySpace, of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model

Sort = Literal["inertia", "placement", "direction", "drive", "limit", "symbol", "other"]

PAYLOAD = "payload"
"""The load whose numbers exist also when it is not there."""


@dataclass(frozen=True)
class ModelNumber:
    """One number of a model: the parts of its name, its owner, and the editor and field that hold
    it."""

    parts: tuple[str, ...]
    owner: str
    """Kind of what it belongs to: joint, link, load, frame, loop, strut, model, symbol."""
    editor: Editor
    field: str
    unit: str
    what: str
    sort: Sort = "other"

    @property
    def name(self) -> str:
        """Parts of the name, joined by dots."""
        return ".".join(self.parts)


@dataclass(frozen=True)
class Catalogue:
    """All records of a model's numbers in order, and by name."""

    rows: dict[str, ModelNumber]
    """The numbers by names that only one of them has."""
    several: dict[str, tuple[str, ...]]
    """Names that several things share -> what each is called instead."""
    aliases: dict[str, str]
    """Names of places that a symbol, or an entry of a DH table, stands in -> its name."""


def catalogue(model: Model) -> Catalogue:
    """The named numbers of a model."""
    space = of_dimension(model.dim)
    leaves = named_leaves(model)
    at = {path: name for name, paths in leaves.items() for path in paths}
    held: dict[tuple[str, ...], ModelNumber] = {}
    aliases: dict[str, str] = {}
    rows: list[ModelNumber] = []
    for row, path in _places(model, space):
        own = at.get(path)
        if own is None:
            rows.append(row)
            continue
        if own not in held:
            held[own] = _leaf(own, leaves[own], row)
            rows.append(held[own])
        if len(leaves[own]) == 1:
            aliases[row.name] = held[own].name
    for own, paths in leaves.items():  # in placements of several steps, where no place has a name
        if own not in held:
            held[own] = _leaf(own, paths, None)
            rows.append(held[own])
    return _by_name(rows, aliases)


def _leaf(own: tuple[str, ...], paths: list[PiecePath], row: ModelNumber | None) -> ModelNumber:
    """The record of a symbol, or of a named entry of a DH table; unit and meaning are those of the
    first place where it is used."""
    editor = Leaves(tuple(paths))
    if len(own) > 1:
        angle = own[1] in ("theta", "alpha")
        what = f"{own[1]} of {own[0]} in the DH table"
        return ModelNumber(own, "joint", editor, "", "rad" if angle else "m", what, "placement")
    unit, what = (row.unit, row.what) if row else ("", "in a placement")
    return ModelNumber(own, "symbol", editor, "", unit, what, "symbol")


def _by_name(rows: list[ModelNumber], aliases: dict[str, str]) -> Catalogue:
    """The catalogue of records by name; a name that several have is preceded by its owner's, and
    numbered where that is not enough."""
    sharing: dict[str, list[ModelNumber]] = {}
    for row in rows:
        sharing.setdefault(row.name, []).append(row)
    found: dict[str, ModelNumber] = {}
    several: dict[str, list[str]] = {}
    for row in rows:
        name = row.name
        if len(sharing[name]) > 1:
            name = longer = f"{row.owner}:{row.name}"
            count = 1
            while name in found or name in sharing:
                count += 1
                name = f"{longer} ({count})"
            several.setdefault(row.name, []).append(name)
        found[name] = row
    kept = {
        alias: name for alias, name in aliases.items() if alias not in sharing and name in found
    }
    return Catalogue(found, {name: tuple(names) for name, names in several.items()}, kept)


# ---------------------------------------------------------------- all places, in order
def _places(model: Model, space: AnySpace) -> Iterator[tuple[ModelNumber, PiecePath]]:
    """Pairs of a number's record and the path at which it is stored."""
    size = "size of the gravity field"
    yield _entry((), "gravity_size", ("gravity",), "model", "m/s²", size)
    along = "component of the gravity field's direction, a unit vector in world axes"
    for k, x in enumerate(space.axes):
        name = "gravity", "direction", x
        yield _entry(("gravity_direction",), k, name, "model", "1", along, "direction")
    for k, part in enumerate(model.base_inertias):
        yield from _part(model, part, ("base_inertias", k), space)
    for i, body in enumerate(model.bodies):
        yield from _joint(model, body, ("bodies", i), space)
        for k, part in enumerate(body.inertias):
            yield from _part(model, part, ("bodies", i, "inertias", k), space)
    for k, frame in enumerate(model.frames):
        if frame.parent:
            yield from _frame(model, frame, k, space)
    for k, loop in enumerate(model.loops):
        if loop.distance is not None:
            name, what = (loop.name, "distance"), f"between the frames of loop {loop.name!r}"
            yield _entry(("loops", k), "distance", name, "loop", "m", what)
    for k, strut in enumerate(model.struts):
        for number in STRUT_NUMBERS:
            name, what = (strut.name, number.name), f"{number.what} of strut {strut.name!r}"
            yield _entry(("struts", k), number.name, name, "strut", number.unit, what)
    loaded = any(part.link == PAYLOAD and part.load for part in _loads(model))
    if model.tip is not None and not loaded:
        editor = NewPayloadEditor(PAYLOAD, model.tip, space)
        yield from _mass(PAYLOAD, "load", editor, (), space, f"load in frame {model.tip!r}")


def _entry(
    path: PiecePath, step: str | int, name: tuple[str, ...], owner: str, unit: str, what: str,
    sort: Sort = "other",
) -> tuple[ModelNumber, PiecePath]:  # fmt: skip
    """The record of a number that is an attribute or entry of the piece at a path."""
    field = name[-1]
    editor = PieceEntries(path, {field: step})
    return ModelNumber(name, owner, editor, field, unit, what, sort), (*path, step)


def _loads(model: Model) -> Iterator[Attached]:
    yield from model.base_inertias
    for body in model.bodies:
        yield from body.inertias


def _outer(model: Model, name: str, steps: tuple[object, ...]) -> str | None:
    """The frame's name if a placement begins with that frame's own steps, else None; chains of many
    placements have been combined and do not."""
    outer = model.frame(name).placement.steps
    return name if steps[: len(outer)] == outer else None


def _joint(
    model: Model, body: Body, path: PiecePath, space: AnySpace
) -> Iterator[tuple[ModelNumber, PiecePath]]:
    joint = body.joint
    if joint.parent:
        outer = _outer(model, joint.parent, joint.placement.steps)
        pose = PoseEditor((*path, "joint", "placement"), outer, space)
        where = "its body" if outer is None else repr(outer)
        what = f"of the origin of joint {joint.name!r} in {where}"
        yield from _pose(model, joint.name, "joint", pose, what)
    of = f"of joint {joint.name!r}"
    for k, number in enumerate(body.kind.numbers):
        name, what = (joint.name, number.name), f"{number.what} {of}"
        yield _entry((*path, "joint", "numbers"), k, name, "joint", number.unit, what)
    if body.kind.nv != 1:
        return
    (turns,) = body.kind.angular
    place, listed = (*path, "joint", "drive"), joint.drive.listed
    drive = PieceEntries(place, {number.name: number.name for number in listed})
    for number in listed:
        name, what = (joint.name, *number.place), f"{number.what} {of}"
        unit = number.unit_of(turns)
        yield (
            ModelNumber(name, "joint", drive, number.name, unit, what, "drive"),
            (*place, number.name),
        )
    for attribute, unit in _LIMITS[turns].items():
        name, what = (joint.name, "limits", attribute), f"{attribute} limit {of}"
        yield _entry((*path, "joint", "limits"), attribute, name, "joint", unit, what, "limit")


_LIMITS = {
    True: {"lower": "rad", "upper": "rad", "velocity": "rad/s", "effort": "N m"},
    False: {"lower": "m", "upper": "m", "velocity": "m/s", "effort": "N"},
}
"""For joints that turn, and for those that slide."""


def _part(
    model: Model, part: Attached, path: PiecePath, space: AnySpace
) -> Iterator[tuple[ModelNumber, PiecePath]]:
    steps = part.placement.steps
    owner = "load" if part.load else "link"
    editor = LinkInertiaEditor(path, None if part.load else _outer(model, part.link, steps), space)
    yield from _mass(
        part.link, owner, editor, path, space, f"{owner} {part.link!r}", is_plain(part.inertia)
    )


def _mass(
    name: str,
    owner: str,
    editor: Editor,
    path: PiecePath,
    space: AnySpace,
    what: str,
    scales: bool = False,
) -> Iterator[tuple[ModelNumber, PiecePath]]:
    """The records of a part's mass, centre of mass and inertia, and of `scale` where these exist
    and have no names of their own."""
    fields = [("mass", "kg", ("mass",), f"mass of {what}")]
    fields += [
        (f"com.{x}", "m", ("com", k), f"centre of mass of {what}") for k, x in enumerate(space.axes)
    ]
    about = f"inertia of {what} about its centre of mass"
    fields += [
        (f"inertia.{x}", "kg m²", ("tensor", k), about) for k, x in enumerate(TENSOR[space.dim])
    ]
    for field, unit, leaf, text in fields:
        row = ModelNumber((name, *field.split(".")), owner, editor, field, unit, text, "inertia")
        yield row, (*path, "inertia", *leaf) if path else ()
    if scales:
        factor = f"factor on mass and inertia of {what}"
        yield ModelNumber((name, "scale"), owner, editor, "scale", "1", factor, "inertia"), ()


def _frame(
    model: Model, frame: Frame, k: int, space: AnySpace
) -> Iterator[tuple[ModelNumber, PiecePath]]:
    """The records of the placement of a frame that is mounted, or of a link fixed to another
    one."""
    outer = _outer(model, frame.parent, frame.placement.steps)
    pose = PoseEditor(("frames", k, "placement"), outer, space, frame.name)
    where = "its body" if outer is None else repr(outer)
    yield from _pose(model, frame.name, "frame", pose, f"of frame {frame.name!r} in {where}")


def _pose(
    model: Model, name: str, owner: str, pose: PoseEditor, what: str
) -> Iterator[tuple[ModelNumber, PiecePath]]:
    start = pose.start(model)
    if not PoseEditor.tells(get(model, pose.path).steps[start:]):
        return
    fields = pose.read(model)
    for field in fields:
        angle = field in ANGLES[pose.space.dim]
        unit, parts = "rad" if angle else "m", (name, "placement", field)
        row = ModelNumber(parts, owner, pose, field, unit, f"{field} {what}", "placement")
        at = () if angle else (*pose.path, "steps", start, "by", pose.space.axes.index(field))
        yield row, at
