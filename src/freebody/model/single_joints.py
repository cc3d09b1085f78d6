"""A model whose joints have one coordinate each, the form that formulas and derivations need.

A joint of several coordinates is as many joints with links without mass and length between them;
q, q̇ and every number stay what they are. Only where it is asked for, spherical and free joints are
taken apart too: what was a quaternion is then three angles about z, the new y and the new x (yaw,
pitch, roll), and the rates of these stand for the angular velocity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from freebody.model.bodies import Body, Frame
from freebody.model.joints import KINDS
from freebody.model.joints.kind import Primitive
from freebody.model.placement import Placement
from freebody.spatial import Vector, of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model

_OWN = ("x", "y", "z")
"""Slides of these names have them for their coordinates."""


def with_single_joints(model: Model, euler: bool = False) -> Model:
    """The model with joints of several coordinates taken apart; spherical and free ones, whose
    coordinates are no plain numbers, only with `euler`, and then without home positions."""
    if not any(is_taken_apart(body, euler) for body in model.bodies):
        return model
    taken = {*model.joint_names, *model.frame_names, *model.parameters}
    bodies: list[Body] = []
    links: list[Frame] = []
    index = {-1: -1}
    parts = [list(_parts(body, model.dim, taken, euler)) for body in model.bodies]
    for i, chain in enumerate(parts):
        index[i] = sum(map(len, parts[: i + 1])) - 1
        links += [
            Frame(part.name, index[i] + 1 - len(chain) + k) for k, part in enumerate(chain[:-1])
        ]
    for body, chain in zip(model.bodies, parts, strict=True):
        above = index[body.parent]
        for part in chain:
            bodies.append(replace(part, parent=above))
            above = len(bodies) - 1
    frames = tuple(replace(frame, body=index[frame.body]) for frame in model.frames)
    single = replace(model, bodies=tuple(bodies), frames=(*frames, *links), home=())
    renamed, new = {}, iter(single.position_names)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is not None:
            continue
        if body.kind.quaternion is None:
            renamed |= {model.position_names[k]: next(new) for k in at.q}
        else:
            renamed |= dict.fromkeys([next(new) for _ in range(body.kind.nv)])
    home = ((renamed.get(name), x) for name, x in model.home)
    return replace(single, home=tuple((name, x) for name, x in home if name is not None))


def is_taken_apart(body: Body, euler: bool) -> bool:
    """Whether a body's joint is replaced by several joints; euler: also one with a quaternion."""
    return body.kind.composed or (euler and body.kind.quaternion is not None)


def _parts(body: Body, dim: int, taken: set[str], euler: bool) -> Iterator[Body]:
    """The chain of bodies that replaces one body, the last of which has its name and mass."""
    if not is_taken_apart(body, euler):
        yield body
        return
    joint, above, placement = body.joint, body.joint.parent, body.joint.placement
    moves = list(_moves(body, dim))
    for k, (component, primitive, axis) in enumerate(moves, 1):
        kind = next(x for x in KINDS.values() if x.motion is type(primitive))
        is_last = k == len(moves)
        name = _new(component if component in _OWN else f"{joint.name}.{component}", taken)
        child = body.name if is_last else _new(f"{body.name}.{component}", taken)
        single = replace(
            joint,
            name=name,
            kind=kind.name,
            parent=above,
            child=child,
            placement=placement,
            axis=axis,
            numbers=joint.numbers if kind.numbers else (),
        )
        yield Body(child, single, -1, body.inertias if is_last else ())
        above, placement = child, Placement()


def _moves(body: Body, dim: int) -> Iterator[tuple[str, Primitive, Vector]]:
    """The name, primitive and axis of each joint that replaces a body's joint."""
    kind, joint = body.kind, body.joint
    if kind.quaternion is not None:
        yield from kind.by_angles
        return
    moves = kind.primitives(of_dimension(dim), joint.axis, joint.numbers)
    for (primitive, axis), component in zip(moves, kind.position_names, strict=True):
        yield component, primitive, axis


def _new(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "′"
    taken.add(name)
    return name
