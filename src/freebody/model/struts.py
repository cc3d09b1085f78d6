"""Struts: a spring, a damper and a preload between two points of different bodies, such as a gas
spring or a tension spring; checked when a model is made."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from freebody.errors import IncludedLine, ModelError, UnknownNameError
from freebody.model.families import Members
from freebody.model.parameters import Parameter, Quantity, quantity


class StrutNumber(NamedTuple):
    """A number of struts: its name in Python, in files and after the strut's name; its unit; its
    meaning; and whether it may be negative."""

    name: str
    unit: str
    what: str
    signed: bool


NUMBERS = (
    StrutNumber("stiffness", "N/m", "stiffness", signed=False),
    StrutNumber("rest", "m", "length without spring force", signed=False),
    StrutNumber("damping", "N s/m", "damping", signed=False),
    StrutNumber("preload", "N", "force at the rest length, above 0 where it pulls", signed=True),
)
"""The numbers of a strut, in the order in which algorithms take them."""


@dataclass(frozen=True)
class Strut:
    """A strut between the origins of two frames on two bodies. At length L it pulls them together
    with preload + stiffness (L - rest) + damping L̇ (N); a negative force pushes."""

    name: str
    frames: tuple[str, str]
    stiffness: Quantity = 0.0
    rest: Quantity = 0.0
    damping: Quantity = 0.0
    preload: Quantity = 0.0
    line: int | IncludedLine | None = field(default=None, compare=False)

    @property
    def numbers(self) -> tuple[Quantity, ...]:
        """The numbers in the order of `NUMBERS`."""
        return tuple([getattr(self, number.name) for number in NUMBERS])

    def fault(self) -> str | None:
        """The reason why no strut has these numbers, or None; for a family, that of the first
        member with one."""
        for number, x in zip(NUMBERS, self.numbers, strict=True):
            known = x.value if isinstance(x, Parameter) else x
            least = known.array.min() if isinstance(known, Members) else known
            if not number.signed and least is not None and least < 0.0:
                return f"{number.name} is {least:g} {number.unit}; give it as 0 or more"
        return None


def checked_strut(strut: Strut, body_of: Mapping[str, int], taken: Container[str]) -> Strut:
    """The strut with its numbers read; refuses one that joins no two bodies.

    body_of: the body of each frame; taken: names of joints, loops and other struts.
    """
    where = f"strut {strut.name!r}"
    useless = "its length never changes"
    frames = two_frames(where, strut.name, strut.frames, body_of, taken, useless)
    read = {n.name: quantity(getattr(strut, n.name), f"{where}: {n.name}") for n in NUMBERS}
    checked = replace(strut, frames=frames, **read)
    if fault := checked.fault():
        raise ModelError(f"{where}: {fault}.")
    return checked


def two_frames(
    where: str,
    name: object,
    frames: object,
    body_of: Mapping[str, int],
    taken: Container[str],
    useless: str,
) -> tuple[str, str]:
    """The names of the frames of a loop or strut; refuses one without a name of its own, and one
    whose frames are not on two bodies; useless: the reason that is then given."""
    if not isinstance(name, str):
        raise ModelError(f"{where}: the name must be text.")
    if not name or name in taken:
        raise ModelError(f"{where}: the name is taken or empty; choose another.")
    if not isinstance(frames, (tuple, list)) or len(frames) != 2:
        raise ModelError(f"{where}: frames must be the names of two frames.")
    for frame in frames:
        if not isinstance(frame, str) or frame not in body_of:
            raise UnknownNameError("frame", frame, where, body_of)
    first, second = frames
    if body_of[first] == body_of[second]:
        raise ModelError(
            f"{where}: frames {first!r} and {second!r} are on the same body, so {useless}; name "
            f"frames of two bodies."
        )
    return first, second
