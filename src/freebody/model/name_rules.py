"""Rules on names of links and joints, each with its test, and a file as short as they are few: they
are asked when a model is made, and by `doctor`."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from typing import NamedTuple, Protocol


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
