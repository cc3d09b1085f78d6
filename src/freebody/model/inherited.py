"""What a changed copy of a model takes over from what it was made from, so that it costs what was
changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from freebody.arrays import Array
from freebody.model.contributions import (
    JointContribution,
    gravity_part,
    inertial,
    joint_part,
    part_of,
    rows_of,
)

if TYPE_CHECKING:
    from freebody.model.bodies import Body
    from freebody.model.model import Model
    from freebody.model.structure import Structure


def made_from(new: Model, old: Model) -> Model:
    """`new`, a changed copy, which takes over what is known of the pieces that stay."""
    new.__dict__[_SOURCE] = old.__dict__.get(_SOURCE, old)
    return new


_SOURCE = "made from"
"""Under this name a model without `numbers` keeps one that it shares pieces with: what it was made
from, or where numbers were found of neither that nor anything else, the first copy of it of which
they were. Never a row of models: who has numbers keeps none."""


def _source(model: Model) -> Model | None:
    """Another model that shares pieces, whose structure and numbers are known."""
    source = model.__dict__.get(_SOURCE)
    if source is not None and "numbers" not in source.__dict__:
        source = source.__dict__.get(_SOURCE)
    return None if source is None or "numbers" not in source.__dict__ else source


def inherited(model: Model) -> tuple[Structure, Array] | None:
    """Structure and numbers of the model that this one is made from, the numbers of what is other
    put in; None where more than numbers may be other, or a family's numbers come in."""
    source = _source(model)
    if (
        source is None
        or model.base_inertias is not source.base_inertias
        or model.loops is not source.loops
        or (model.loops and model.frames is not source.frames)
        or model.dim != source.dim
        or len(model.bodies) != len(source.bodies)
        or source.numbers.ndim > 1
    ):
        return None
    structure, numbers = source.structure, source.numbers.copy()
    driven = structure.driven
    for i, (new, old) in enumerate(zip(model.bodies, source.bodies, strict=True)):
        if new is old:
            continue
        before = part_of(old, model.dim)
        joint = before.joint if new.joint is old.joint else joint_part(new, model.dim)
        if not _moves_alike(new, old, joint, before.joint):
            return None
        inertia = (
            before.inertia if new.inertias is old.inertias else inertial(new.inertias, model.dim)
        )
        end = structure.starts[i]
        for row, known in zip(
            rows_of((joint, inertia), driven), rows_of(before, driven), strict=True
        ):
            start, end = end, end + row.shape[-1]
            if row is known:
                continue
            if row.ndim > 1:
                return None
            numbers[start:end] = row
    if (
        model.gravity_size is not source.gravity_size
        or model.gravity_direction is not source.gravity_direction
    ):
        zeros, row = gravity_part(model)
        if row.ndim > 1 or zeros != gravity_part(source)[0]:
            return None
        numbers[structure.gravity : structure.gravity + len(row)] = row
    numbers.setflags(write=False)
    return structure, numbers


def _moves_alike(new: Body, old: Body, a: JointContribution, b: JointContribution) -> bool:
    """Whether the structure of two bodies is surely the same, a and b being the parts of their
    joints."""
    if new.joint is old.joint:
        return new.parent == old.parent
    return (
        a.form is b.form
        and a.driven == b.driven
        and new.parent == old.parent
        and new.joint.mimic is old.joint.mimic
        and new.joint.name == old.joint.name
    )


def let_go(model: Model) -> Model | None:
    """The model has its numbers and needs what it was made from no longer, which is returned."""
    return model.__dict__.pop(_SOURCE, None)


def hand_on(model: Model, numbers: Array) -> None:
    """The model has found its numbers: what it was made from takes it as a source if it has no
    other."""
    source, origin = _source(model), let_go(model)
    if source is None and origin is not None and numbers.ndim == 1:
        origin.__dict__.setdefault(_SOURCE, model)
