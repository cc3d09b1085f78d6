"""Mimic joints, which follow another joint, and the independent joint that each follows in the
end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn, Protocol

from freebody.errors import IncludedLine, ModelError, UnknownNameError
from freebody.model.joints import KINDS
from freebody.model.parameters import finite

if TYPE_CHECKING:
    from freebody.model.description import Joint


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = ratio · q(joint) + offset."""

    joint: str
    ratio: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        for name in ("ratio", "offset"):
            object.__setattr__(self, name, finite(getattr(self, name), f"Mimic: {name}"))


class _Refuse(Protocol):
    """Raises with what is wrong and the line of the file."""

    def __call__(self, problem: str, line: int | IncludedLine | None = None) -> NoReturn: ...


def leaders(joints: Sequence[Joint], refuse: _Refuse) -> dict[str, Mimic]:
    """Mimics resolved to an independent leader: ratios multiply along a chain of mimics."""
    named = {joint.name: joint for joint in joints}
    resolved: dict[str, Mimic] = {}
    for joint in joints:
        # followers on the way to what is known, in the order walked
        path: dict[str, Joint] = {}
        leader = joint
        while leader.mimic is not None and leader.name not in resolved:
            path[leader.name] = leader
            name = leader.mimic.joint
            if name not in named:
                problem = UnknownNameError("joint", name, f"the mimic of {leader.name!r}", named)
                refuse(f"{problem} Correct it, or load with mimic='free'.", leader.line)
            if name in path:
                refuse(
                    f"joint {joint.name!r}: its mimic relations form a cycle; remove one.",
                    joint.line,
                )
            leader = named[name]
        for follower in reversed(path.values()):
            resolved[follower.name] = _follower(follower, leader, resolved.get(leader.name), refuse)
            leader = follower
    return resolved


def _follower(joint: Joint, above: Joint, of: Mimic | None, refuse: _Refuse) -> Mimic:
    """The mimic of an independent joint that a joint is: it follows `above`, which may be a
    follower itself."""
    given = joint.mimic
    assert given is not None
    if KINDS[above.kind].nv != 1 or KINDS[joint.kind].nv != 1:
        refuse(
            f"joint {joint.name!r}: only joints of one coordinate can mimic or be mimicked.",
            joint.line,
        )
    if of is None:
        return Mimic(above.name, given.ratio, given.offset)
    try:
        return Mimic(of.joint, given.ratio * of.ratio, given.offset + given.ratio * of.offset)
    except ModelError as error:
        refuse(f"joint {joint.name!r}: {error}", joint.line)
