"""Rules on the names of links and joints, and on the limits of one joint, each with its test: they
are asked when a model is made, those on limits also where limits are used, and by `doctor`."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Sequence
from typing import Any, NamedTuple, Protocol

from freebody.outputs.number_text import compared


class NameRule(NamedTuple):
    """A rule on the names of all links, or of all joints: the places of those that break it, what
    is said of one, and what is to be done."""

    broken: Callable[[Sequence[str]], Iterator[int]]
    said: Callable[[str, str], str]
    remedy: str


def _empty(names: Sequence[str]) -> Iterator[int]:
    return (i for i, name in enumerate(names) if not name)


def _repeated(names: Sequence[str]) -> Iterator[int]:
    first: dict[str, int] = {}
    return (i for i, name in enumerate(names) if name and first.setdefault(name, i) != i)


UNNAMED = NameRule(_empty, lambda what, name: f"a {what} has no name", "give it one")
DUPLICATE = NameRule(_repeated, lambda what, name: f"two {what}s are called {name!r}", "rename one")
EVERY_NAME = (UNNAMED, DUPLICATE)
"""Rules without which a model is refused, in this order."""


class _Hanging(Protocol):
    @property
    def parent(self) -> str: ...

    @property
    def child(self) -> str: ...


def unknown_ends(joint: _Hanging, links: Container[str]) -> Iterator[tuple[str, str]]:
    """The ends of a joint ("parent" or "child"), each with its name, that name no link."""
    ends = ("parent", joint.parent), ("child", joint.child)
    return ((end, name) for end, name in ends if name not in links)


class LimitRule(NamedTuple):
    """A rule: which limits it is about, whether their values break it, and what is said of those
    that do."""

    about: tuple[str, ...]
    broken: Callable[..., bool]
    said: Callable[..., str]


def _swap_them(lower: float, upper: float) -> str:
    low, high = compared(lower, upper, digits=6)
    return (
        f"lower limit {low} is above upper {high}; swap them, or leave both out where there are "
        f"none"
    )


SWAPPED = LimitRule(("lower", "upper"), lambda lower, upper: lower > upper, _swap_them)
UNREACHABLE = LimitRule(
    ("lower", "upper"),
    lambda lower, upper: lower == math.inf or upper == -math.inf,
    lambda lower, upper: "no position lies between its limits; make one finite",
)
NEGATIVE = tuple(
    LimitRule(
        (name,),
        lambda most: most < 0.0,
        lambda most, name=name: f"{name} limit {most:g} is negative; give its size",
    )
    for name in ("velocity", "effort")
)
NO_JOINT_HAS = (SWAPPED, UNREACHABLE, *NEGATIVE)
"""Rules without which a model is refused, in this order."""


def is_not_given(*values: Any) -> bool:
    """Whether a limit of speed or effort, or the two of a range, are what files write where they
    give none: 0, or a range of no width."""
    return bool(values[0] == 0.0 if len(values) == 1 else values[0] == values[1])
