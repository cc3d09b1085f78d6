"""Mimic joints, which follow other joints, and the independent joints that each follows in the end.

A joint that follows several is built as several joints on one axis, each of which follows one:
their turns, or shifts, add up, and what lies between has no mass.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NoReturn, Protocol

from freebody.errors import IncludedLine, ModelError, UnknownNameError
from freebody.model.joints import KINDS
from freebody.model.parameters import finite
from freebody.model.placement import Placement

if TYPE_CHECKING:
    from freebody.model.description import Joint


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = ratio · q(joint) + offset; of several leaders the
    sum, `more` being (joint, ratio) of the others."""

    joint: str
    ratio: float = 1.0
    offset: float = 0.0
    more: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        for name in ("ratio", "offset"):
            object.__setattr__(self, name, finite(getattr(self, name), f"Mimic: {name}"))
        more = tuple((joint, finite(ratio, "Mimic: ratio")) for joint, ratio in self.more)
        object.__setattr__(self, "more", more)

    @property
    def ratios(self) -> tuple[tuple[str, float], ...]:
        """(joint, ratio) of each leader."""
        return ((self.joint, self.ratio), *self.more)


class _Refuse(Protocol):
    """Raises with what is wrong and the line of the file."""

    def __call__(self, problem: str, line: int | IncludedLine | None = None) -> NoReturn: ...


def leaders(joints: Sequence[Joint], refuse: _Refuse) -> dict[str, Mimic]:
    """Mimics resolved to independent leaders: ratios multiply along a chain of mimics."""
    named = {joint.name: joint for joint in joints}
    resolved: dict[str, Mimic] = {}
    for joint in joints:
        # followers that wait for what they follow, in the order walked
        path = [joint]
        while path:
            follower = path[-1]
            if follower.mimic is None or follower.name in resolved:
                path.pop()
                continue
            waits = _first_open(follower, named, resolved, refuse)
            if waits is None:
                resolved[follower.name] = _follower(follower, named, resolved, refuse)
            elif any(waits is other for other in path):
                refuse(
                    f"joint {joint.name!r}: its mimic relations form a cycle; remove one.",
                    joint.line,
                )
            else:
                path.append(waits)
    return resolved


def _first_open(
    joint: Joint, named: Mapping[str, Joint], resolved: Collection[str], refuse: _Refuse
) -> Joint | None:
    """The first of a joint's leaders of which it is not known yet what it follows itself."""
    assert joint.mimic is not None
    for name, _ in joint.mimic.ratios:
        if name not in named:
            problem = UnknownNameError("joint", name, f"the mimic of {joint.name!r}", named)
            refuse(f"{problem} Correct it, or load with mimic='free'.", joint.line)
        if named[name].mimic is not None and name not in resolved:
            return named[name]
    return None


def _follower(
    joint: Joint, named: Mapping[str, Joint], resolved: Mapping[str, Mimic], refuse: _Refuse
) -> Mimic:
    """The mimic of independent joints that a joint is, whose leaders may be followers."""
    given = joint.mimic
    assert given is not None
    above = [named[name] for name, _ in given.ratios]
    if any(KINDS[other.kind].nv != 1 for other in (joint, *above)):
        refuse(
            f"joint {joint.name!r}: only joints of one coordinate can mimic or be mimicked.",
            joint.line,
        )
    ratios: dict[str, float] = {}
    offset = given.offset
    for name, ratio in given.ratios:
        of = resolved.get(name, Mimic(name))
        offset += ratio * of.offset
        for leader, own in of.ratios:
            ratios[leader] = ratios.get(leader, 0.0) + ratio * own
    (first, ratio), *more = [x for x in ratios.items() if x[1]] or list(ratios.items())[:1]
    try:
        return Mimic(first, ratio, offset, tuple(more))
    except ModelError as error:
        refuse(f"joint {joint.name!r}: {error}", joint.line)


def one_by_one(joint: Joint, mimic: Mimic, taken: Collection[str]) -> tuple[Joint, ...]:
    """Joints on one axis that together move as a joint that follows several, the last of which has
    its name; taken: names of links and joints."""
    found, parent, placement = [], joint.parent, joint.placement
    for leader, ratio in mimic.ratios[:-1]:
        name, between = (_free(f"{x}_{leader}", taken) for x in (joint.name, joint.child))
        found.append(
            replace(
                joint,
                name=name,
                parent=parent,
                child=between,
                placement=placement,
                limits=type(joint.limits)(),
                mimic=Mimic(leader, ratio),
            )
        )
        parent, placement = between, Placement()
    last, ratio = mimic.ratios[-1]
    follows = Mimic(last, ratio, mimic.offset)
    end = replace(
        joint, parent=parent, placement=placement, limits=type(joint.limits)(), mimic=follows
    )
    return (*found, end)


def _free(name: str, taken: Collection[str]) -> str:
    while name in taken:
        name += "_"
    return name
