"""A model in which some joints are locked: what they carry is a part of the body that they hang
on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from freebody.errors import ModelError, UnknownNameError, listed
from freebody.model.families import one_family
from freebody.model.parameters import finite
from freebody.model.placement import Placement, rotate, shift
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import parents_first
from freebody.outputs.number_text import compared
from freebody.spatial import of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model

_WHERE = "with_locked"


def with_locked(model: Model, positions: Mapping[str, Any]) -> Model:
    """The model without the coordinates of some joints; see `Model.with_locked`."""
    values = _checked(model, positions)
    moves: dict[int, float] = {}
    for k, at in enumerate(model.coordinates):
        if at.q and at.q[0] in values:
            q = tuple(values.get(i, 0.0) for i in range(model.nq))
            (moves[k],) = at.position(q)
    if not moves:
        return model
    kept = [k for k in range(len(model.bodies)) if k not in moves]
    index = {-1: -1} | {k: i for i, k in enumerate(kept)}
    on, seen = {-1: -1}, {-1: Placement()}
    """The body that carries each body, itself unless it is locked, and where it is on that."""
    for k in parents_first(model.bodies):
        body = model.bodies[k]
        on[k], seen[k] = k, Placement()
        if k in moves:
            on[k] = on[body.parent]
            at = body.joint.placement.then(_moved(model, k, moves[k]))
            seen[k] = seen[body.parent].then(at)
    parts = {k: list(model.bodies[k].inertias) for k in kept} | {-1: list(model.base_inertias)}
    for k in moves:
        parts[on[k]] += [
            replace(part, placement=seen[k].then(part.placement))
            for part in model.bodies[k].inertias
        ]
    bodies = tuple(
        replace(
            body,
            joint=replace(body.joint, placement=seen[body.parent].then(body.joint.placement)),
            parent=index[on[body.parent]],
            inertias=tuple(parts[k]),
        )
        for k, body in enumerate(model.bodies)
        if k in index
    )
    frames = []
    for frame in model.frames:
        k = frame.body
        if k in moves and not frame.parent:
            joint = model.bodies[k].joint
            frame = replace(frame, parent=joint.parent, joint=joint.name)
        frames.append(replace(frame, body=index[on[k]], placement=seen[k].then(frame.placement)))
    names = {name for i, name in enumerate(model.position_names) if i in values}
    locked = replace(
        model,
        bodies=bodies,
        frames=tuple(frames),
        base_inertias=tuple(parts[-1]),
        home=tuple((name, x) for name, x in model.home if name not in names),
    )
    _refuse_idle(locked)
    return one_family(locked, model)


def _checked(model: Model, positions: Mapping[str, Any]) -> dict[int, float]:
    """The entries of q that are held, each with its value; refuses joints that cannot be locked,
    and positions at which they cannot be."""
    single = {body.joint.name: k for k, body in enumerate(model.bodies) if body.kind.nv == 1}
    found = {}
    for name, given in positions.items():
        if name not in single:
            raise UnknownNameError("one-coordinate joint", name, f"{model.name!r}", single)
        k = single[name]
        joint, unit = model.bodies[k].joint, "rad" if model.bodies[k].kind.angular[0] else "m"
        if joint.mimic is not None:
            raise ModelError(
                f"{_WHERE}: joint {name!r} follows {joint.mimic.joint!r}; lock that one, and both "
                f"are."
            )
        value = finite(given, f"{_WHERE}: joint {name!r}")
        (entry,), (rate,) = model.coordinates[k].q, model.coordinates[k].v
        lower, upper = model.limits.lower[..., rate].max(), model.limits.upper[..., rate].min()
        if not lower <= value <= upper:
            at, least, most = compared(value, float(lower), float(upper), digits=6)
            raise ModelError(
                f"{_WHERE}: joint {name!r} cannot be held at {at} {unit}: its range is {least} … "
                f"{most}."
            )
        found[entry] = value
    return found


def _moved(model: Model, k: int, position: float) -> Placement:
    """Where a body is in the frame of its joint of one coordinate."""
    space, body = of_dimension(model.dim), model.bodies[k]
    numbers = tuple(map(VALUES.quantity, body.joint.numbers))
    ((primitive, axis),) = body.kind.primitives(space, VALUES.axis(body.joint.axis), numbers)
    R, p = primitive.pose(space, axis, (position,))
    return shift(*p).then(rotate(R, _WHERE))


def _refuse_idle(model: Model) -> None:
    """Refuse a model with a loop or strut whose frames are fixed to one another."""
    body_of = {frame.name: frame.body for frame in model.frames}
    for part in (*model.loops, *model.struts):
        if len({body_of[name] for name in part.frames}) == 1:
            raise ModelError(
                f"{_WHERE}: the frames of {part.name!r}, {listed(map(repr, part.frames))}, are "
                f"then on one body; leave out what it holds, or lock fewer joints."
            )
