"""What a changed copy of a model takes over from what it was made from, so that it costs what was changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from freebody.arrays import Array
from freebody.model.contributions import part_of, rows_of

if TYPE_CHECKING:
    from freebody.model.model import Model
    from freebody.model.structure import Structure


def made_from(new: Model, old: Model) -> Model:
    """`new`, a changed copy, which takes over what is known of the pieces that stay."""
    new.__dict__[_SOURCE] = old.__dict__.get(_SOURCE, old)
    return new


_SOURCE = "made from"
"""Under this name a model without `numbers` keeps one that it shares pieces with: what it was made from, or where
numbers were found of neither that nor anything else, the first copy of it of which they were. Never a row of models:
who has numbers keeps none."""


def _source(model: Model) -> Model | None:
    """Another model that shares pieces, whose structure and numbers are known."""
    source = model.__dict__.get(_SOURCE)
    if source is not None and "numbers" not in source.__dict__:
        source = source.__dict__.get(_SOURCE)
    return None if source is None or "numbers" not in source.__dict__ else source


def _other_bodies(model: Model, source: Model) -> list[int] | None:
    """Which bodies are others; None where more is, and structure and numbers have to be put together anew."""
    if (
        model.gravity_size is not source.gravity_size
        or model.gravity_direction is not source.gravity_direction
        or model.base_inertias is not source.base_inertias
        or model.loops is not source.loops
        or (model.loops and model.frames is not source.frames)
        or model.dim != source.dim
        or len(model.bodies) != len(source.bodies)
    ):
        return None
    return [i for i, (a, b) in enumerate(zip(model.bodies, source.bodies, strict=True)) if a is not b]


def inherited_structure(model: Model) -> Structure | None:
    """The structure of the model that this one is made from, if it is surely the same."""
    source = _source(model)
    others = None if source is None else _other_bodies(model, source)
    if source is None or others is None:
        return None
    for i in others:
        new, old = model.bodies[i], source.bodies[i]
        a, b = part_of(new, model.dim).joint, part_of(old, model.dim).joint
        if a is not b and (a.form is not b.form or a.driven != b.driven):
            return None
        if (
            new.parent != old.parent
            or new.joint.mimic is not old.joint.mimic
            or new.joint.name != old.joint.name
        ):
            return None
    return source.structure


def hand_on(model: Model, numbers: Array) -> None:
    """The model has its numbers: it lets go of what it was made from, which takes it as a source if it has no other."""
    source, origin = _source(model), model.__dict__.pop(_SOURCE, None)
    if source is None and origin is not None and numbers.ndim == 1:
        origin.__dict__.setdefault(_SOURCE, model)


def inherited_numbers(model: Model) -> Array | None:
    """The numbers of the model that this one is made from, those of the bodies that are others put in."""
    source = _source(model)
    others = None if source is None else _other_bodies(model, source)
    if source is None or others is None:
        return None
    numbers = source.numbers
    if model.structure is not source.structure or numbers.ndim > 1:
        return None
    numbers = numbers.copy()
    for i in others:
        start = model.structure.starts[i]
        for row in rows_of(part_of(model.bodies[i], model.dim), model.structure.driven):
            if row.ndim > 1:
                return None
            end = start + len(row)
            numbers[start:end] = row
            start = end
    return numbers
