"""Which frame of a robot is studied as its tip."""

from __future__ import annotations

from freebody.model.model import Model


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
    depths = {leaf: joints_before(model, leaf) for leaf in leaves}
    best = max(leaves, key=lambda leaf: depths[leaf])
    equals = [leaf for leaf in leaves if depths[leaf] == depths[best]]
    n = depths[best]
    joints = f"{n} movable joint{'' if n == 1 else 's'}"
    if len(equals) > 1:
        why = (
            f"the first in the file of the {len(equals)} ends behind {joints} ({', '.join(equals)})"
        )
    else:
        why = f"the end behind the most joints, {joints} (ends: {', '.join(leaves)})"
    return best, f"The tip is {best!r}, {why}; another is chosen with --tip or tip=."


def joints_before(model: Model, frame: str) -> int:
    """Number of movable joints between the base and a frame."""
    count, body = 0, model.frame(frame).body
    while body >= 0:
        count += 1
        body = model.bodies[body].parent
    return count


def coordinates_before(model: Model, frame: str) -> list[int]:
    """Indices of the velocity coordinates that move a frame, in the order of q̇."""
    found: set[int] = set()
    body = model.frame(frame).body
    while body >= 0:
        found.update(model.coordinates[body].v)
        body = model.bodies[body].parent
    return sorted(found)
