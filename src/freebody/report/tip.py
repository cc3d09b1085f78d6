"""Which frame of a robot is studied as its tip."""

from __future__ import annotations

from freebody.model.model import Model
from freebody.outputs.display import counted


def chosen_tip(model: Model, tip: str | None) -> tuple[str, str]:
    """(frame, one sentence why): the one asked for, the model's own, else the leaf behind the most
    movable joints.

    Among equals the first in the file's order. Raises UnknownNameError.
    """
    if tip is not None:
        return model.frame(tip).name, f"The tip is {tip!r}, as asked."
    if model.tip is not None:
        why = "the model's own tip" if len(model.leaves) != 1 else "the only end of the robot"
        return model.tip, f"The tip is {model.tip!r}, {why}."
    leaves = model.leaves or model.frame_names
    depths = {leaf: len(bodies_before(model, leaf)) for leaf in leaves}
    best = max(leaves, key=lambda leaf: depths[leaf])
    equals = [leaf for leaf in leaves if depths[leaf] == depths[best]]
    joints = counted(depths[best], "movable joint")
    if len(equals) > 1:
        why = (
            f"the first in the file of the {len(equals)} ends after {joints} ({', '.join(equals)})"
        )
    else:
        why = f"the end after the most joints, {joints} (ends: {', '.join(leaves)})"
    return best, f"The tip is {best!r}, {why}; another is chosen with --tip or tip=."


def bodies_before(model: Model, frame: str) -> list[int]:
    """The body that carries a frame and all that carry it, from there to the ground."""
    found, body = [], model.frame(frame).body
    while body >= 0:
        found.append(body)
        body = model.bodies[body].parent
    return found


def coordinates_before(model: Model, frame: str) -> list[int]:
    """Indices of the velocity coordinates that move a frame, in the order of q̇."""
    return sorted({k for i in bodies_before(model, frame) for k in model.coordinates[i].v})
