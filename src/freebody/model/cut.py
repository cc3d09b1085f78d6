"""A model cut at a fixed joint, so that the wrench through it becomes the wrench of a joint."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from freebody.errors import UnknownNameError
from freebody.model.bodies import Body, Frame
from freebody.model.description import Joint
from freebody.model.tree import Attached

if TYPE_CHECKING:
    from freebody.model.model import Model


def fixed_frame(model: Model, joint: str, function: str) -> Frame:
    """The frame behind a fixed joint of that name, or the frame of that name that is fixed to
    another one; refuses other names."""
    found = {frame.name: frame for frame in model.frames if frame.parent}
    found |= {frame.joint: frame for frame in model.frames if frame.joint}
    if not isinstance(joint, str) or joint not in found:
        raise UnknownNameError("joint", joint, function, (*model.reaction_names, *found))
    return found[joint]


def cut(model: Model, frame: str) -> Model:
    """The model with a frame and all that is fixed to it as a body of its own, put last, behind a
    hinge.

    Its axes are those of the body that it was part of, so that no placement changes; the hinge has
    the last coordinate, and held at 0 transmits what the fixed joint does.
    """
    at, beyond = model.frame(frame), behind(model, frame)
    rest, apart = _split(_inertias(model, at.body), beyond)
    taken = (*model.reaction_names, *model.strut_names)
    name = at.joint or frame
    while name in taken:
        name += "_"
    axis = (1.0,) if model.dim == 2 else (0.0, 0.0, 1.0)
    hinge = Joint(name, "revolute", at.parent, frame, axis=axis)
    bodies = [
        replace(
            body,
            parent=len(model.bodies) if body.joint.parent in beyond else body.parent,
            inertias=rest if i == at.body else body.inertias,
        )
        for i, body in enumerate(model.bodies)
    ]
    return replace(
        model,
        bodies=(*bodies, Body(frame, hinge, at.body, apart)),
        frames=tuple(
            replace(f, body=len(model.bodies)) if f.name in beyond else f for f in model.frames
        ),
        base_inertias=rest if at.body < 0 else model.base_inertias,
    )


def behind(model: Model, name: str) -> set[str]:
    """Names of a frame and of all frames fixed to it, directly or through others."""
    on: dict[str, list[str]] = {}
    for frame in model.frames:
        on.setdefault(frame.parent, []).append(frame.name)
    reached, waiting = {name}, [name]
    while waiting:
        below = on.get(waiting.pop(), [])
        reached.update(below)
        waiting += below
    return reached


def rides(part: Attached, frames: Collection[str]) -> bool:
    """Whether an inertia is attached to one of some frames."""
    return (part.frame if part.load else part.link) in frames


def _inertias(model: Model, body: int) -> tuple[Attached, ...]:
    return model.base_inertias if body < 0 else model.bodies[body].inertias


def _split(
    parts: Iterable[Attached], beyond: Collection[str]
) -> tuple[tuple[Attached, ...], tuple[Attached, ...]]:
    """(inertias that are not attached to the frames, inertias that are)."""
    told = [(part, rides(part, beyond)) for part in parts]
    return tuple(part for part, at in told if not at), tuple(part for part, at in told if at)
