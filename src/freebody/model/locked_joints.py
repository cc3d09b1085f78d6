"""A model in which some joints are locked: what they carry is a part of the body that they hang
on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from freebody.errors import ModelError, UnknownNameError, listed
from freebody.model.families import one_family
from freebody.model.parameters import finite
from freebody.model.placement import Placement, rotate, shift
from freebody.model.quantity_reader import VALUES
from freebody.model.tip import left_by, with_tip
from freebody.model.tree import Attached, parents_first
from freebody.outputs.number_text import compared
from freebody.spatial import of_dimension

if TYPE_CHECKING:
    from freebody.model.bodies import Body, Frame
    from freebody.model.description import Joint
    from freebody.model.model import Model

_WHERE = "with_locked"


def with_locked(model: Model, positions: Mapping[str, Any]) -> Model:
    """The model without the coordinates of some joints; see `Model.with_locked`."""
    values = _checked(model, positions)
    if not values:
        return model
    place = _LockedBodies.of(model, _locked(model, values))
    kept = {k: i for i, k in enumerate(k for k in place.on if place.on[k] == k and k >= 0)}
    bodies = tuple(
        replace(
            model.bodies[k],
            joint=place.hung(model.bodies[k]),
            parent=kept.get(place.on[model.bodies[k].parent], -1),
            inertias=place.parts(k),
        )
        for k in kept
    )
    frames = tuple(
        replace(
            place.named(frame),
            body=kept.get(place.on[frame.body], -1),
            placement=place.seen[frame.body].then(frame.placement),
        )
        for frame in model.frames
    )
    gone = {name for i, name in enumerate(model.position_names) if i in values}
    locked = replace(
        model,
        bodies=bodies,
        frames=frames,
        base_inertias=place.parts(-1),
        home=tuple((name, x) for name, x in model.home if name not in gone),
    )
    _refuse_idle(locked)
    if model.tip is None:
        still = {body.joint.name for k, body in enumerate(model.bodies) if place.on[k] != k}
        locked = with_tip(locked, left_by(still, model, locked))
    return one_family(locked, model)


@dataclass(frozen=True)
class _LockedBodies:
    """Where the bodies of a model are when some joints are locked.

    on: the body that carries each body (-1: the base), itself unless its joint is locked, in the
    model's order. seen: its placement in the frame of that one.
    """

    model: Model
    on: dict[int, int]
    seen: dict[int, Placement]

    @staticmethod
    def of(model: Model, moves: Mapping[int, float]) -> _LockedBodies:
        """The places where the joints of some bodies are held at their own positions."""
        on = {-1: -1} | {k: k for k in range(len(model.bodies))}
        seen = dict.fromkeys(on, Placement())
        for k in parents_first(model.bodies):
            if k in moves:
                body = model.bodies[k]
                at = body.joint.placement.then(_moved(model, k, moves[k]))
                on[k], seen[k] = on[body.parent], seen[body.parent].then(at)
        return _LockedBodies(model, on, seen)

    def hung(self, body: Body) -> Joint:
        """A body's joint, placed in the frame of the body that carries the one it hangs on."""
        return replace(body.joint, placement=self.seen[body.parent].then(body.joint.placement))

    def parts(self, k: int) -> tuple[Attached, ...]:
        """The inertias of all bodies that a body, or the base, carries."""
        bodies = self.model.bodies
        own = bodies[k].inertias if k >= 0 else self.model.base_inertias
        others = (i for i, carrier in self.on.items() if carrier == k != i)
        return own + tuple(
            replace(part, placement=self.seen[i].then(part.placement))
            for i in others
            for part in bodies[i].inertias
        )

    def named(self, frame: Frame) -> Frame:
        """A frame; the first of a locked body as one behind a fixed joint of the joint's name."""
        if self.on[frame.body] == frame.body or frame.parent:
            return frame
        joint = self.model.bodies[frame.body].joint
        return replace(frame, parent=joint.parent, joint=joint.name)


def _locked(model: Model, values: Mapping[int, float]) -> dict[int, float]:
    """The position of the joint of each body that is moved by one of the held entries of q."""
    q = tuple(values.get(i, 0.0) for i in range(model.nq))
    return {
        k: at.position(q)[0] for k, at in enumerate(model.coordinates) if at.q and at.q[0] in values
    }


def _checked(model: Model, positions: Mapping[str, Any]) -> dict[int, float]:
    """The entries of q that are held, each with its value; refuses joints that cannot be locked,
    and positions at which they cannot be."""
    single = {body.joint.name: k for k, body in enumerate(model.bodies) if body.kind.nv == 1}
    found = {}
    for name, given in _by_name(model, positions, single).items():
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


def _by_name(
    model: Model, positions: Mapping[str, Any], single: Mapping[str, int]
) -> dict[str, Any]:
    """The positions by the names of joints. A pattern stands for all joints that it matches, but
    for followers of what is locked; names count before patterns, which may not disagree."""
    found = {name: given for name, given in positions.items() if not _is_pattern(name, single)}
    matched = {
        pattern: [name for name in single if fnmatchcase(name, pattern)]
        for pattern in positions
        if pattern not in found
    }
    locked = {*found, *(name for names in matched.values() for name in names)}
    meant: dict[str, str] = {}
    for pattern, names in matched.items():
        if not names:
            raise UnknownNameError("one-coordinate joint", pattern, f"{model.name!r}", single)
        for name in names:
            leaders = _leaders(model, single[name])
            if name in found or (leaders and leaders <= locked):
                continue
            before = meant.setdefault(name, pattern)
            if positions[before] != positions[pattern]:
                raise ModelError(
                    f"{_WHERE}: {before!r} and {pattern!r} hold joint {name!r} at two positions; "
                    f"give it one by its name."
                )
    return found | {name: positions[pattern] for name, pattern in meant.items()}


def _leaders(model: Model, k: int) -> set[str]:
    """The joints that the joint of a body follows."""
    mimic = model.bodies[k].joint.mimic
    return set() if mimic is None else {mimic.joint, *(joint for joint, _ in mimic.more)}


def _is_pattern(name: object, single: Mapping[str, int]) -> bool:
    """Whether a name is a shell pattern, and not that of a joint with such characters."""
    return isinstance(name, str) and name not in single and not {*name}.isdisjoint("*?[")


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
