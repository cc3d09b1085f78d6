"""A model whose joints have one coordinate each: what formulas and derivations are written for.

A joint of several coordinates is as many joints with links without mass and length between them;
q, q̇ and every number stay what they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from freebody.model.bodies import Body, Frame
from freebody.model.joints import KINDS
from freebody.model.placement import Placement
from freebody.spatial import of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model

_OWN = ("x", "y", "z")
"""Slides of these names have them for their coordinates."""


def with_single_joints(model: Model) -> Model:
    """The model, its joints of several coordinates taken apart; spherical and free ones, whose
    coordinates are no plain numbers, stay."""
    if not any(body.kind.composed for body in model.bodies):
        return model
    taken = {*model.joint_names, *model.frame_names, *model.parameters}
    bodies: list[Body] = []
    links: list[Frame] = []
    index = {-1: -1}
    parts = [list(_parts(body, model.dim, taken)) for body in model.bodies]
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
    renamed = dict(zip(model.position_names, single.position_names, strict=True))
    return replace(single, home=tuple((renamed[name], x) for name, x in model.home))


def _parts(body: Body, dim: int, taken: set[str]) -> Iterator[Body]:
    """The bodies that stand for one, its name and mass with the last."""
    if not body.kind.composed:
        yield body
        return
    joint, above, placement = body.joint, body.joint.parent, body.joint.placement
    moves = body.kind.primitives(of_dimension(dim), joint.axis, joint.numbers)
    for k, ((primitive, axis), component) in enumerate(
        zip(moves, body.kind.position_names, strict=True), 1
    ):
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


def _new(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "′"
    taken.add(name)
    return name
