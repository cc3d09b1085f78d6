"""Pieces of a model addressed by paths: to get one, and to replace one."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from freebody.model.families import Members, NamedNumber, copied, fields_of
from freebody.model.parameters import Parameter, Quantity

PiecePath = tuple[Any, ...]
"""Names of fields and indices of tuples that lead from a model to one of its pieces."""
Fields = Mapping[str, Quantity]
"""Numbers of a piece by the names that they have there."""


def get(thing: Any, path: PiecePath) -> Any:
    """The piece of an object at a path."""
    for step in path:
        thing = thing[step] if type(step) is int else getattr(thing, step)
    return thing


def put(thing: Any, path: PiecePath, piece: Any) -> Any:
    """A copy of an object with another piece at a path."""
    return put_at(thing, (path,), piece)


def put_at(thing: Any, paths: tuple[PiecePath, ...], piece: Any) -> Any:
    """A copy of an object with one piece at several paths, none of which leads through another.

    What was one object at several of these places is one again.
    """
    return _put(thing, _branch(paths), piece, {})


class _Branch:
    """Paths at which one piece is put, as a tree of steps."""

    __slots__ = ("again", "steps")

    def __init__(self, steps: tuple[tuple[Any, _Branch | None], ...]):
        self.steps = steps
        """(field or index, what lies behind it; None where the piece goes)."""
        self.again = False
        """Whether there may be others like it, so that the same object may be met twice."""


@lru_cache(maxsize=1024)
def _branch(paths: tuple[PiecePath, ...]) -> _Branch | None:
    return _grown(paths, {})


def _grown(
    paths: tuple[PiecePath, ...], known: dict[tuple[PiecePath, ...], _Branch]
) -> _Branch | None:
    """Several paths as a tree of steps; equal branches are one object."""
    if paths == ((),):
        return None
    if paths in known:
        _mark(known[paths])
    else:
        behind: dict[Any, list[PiecePath]] = {}
        for path in paths:
            behind.setdefault(path[0], []).append(path[1:])
        known[paths] = _Branch(
            tuple((step, _grown(tuple(rest), known)) for step, rest in behind.items())
        )
    return known[paths]


def _mark(branch: _Branch) -> None:
    branch.again = True
    for _, rest in branch.steps:
        if rest is not None and not rest.again:
            _mark(rest)


def _put(
    thing: Any, branch: _Branch | None, piece: Any, made: dict[tuple[int, _Branch] | None, Any]
) -> Any:
    """A copy of an object with a piece put at all paths of a branch; made: copies made so far,
    which are used again where an object occurs twice."""
    if branch is None:
        return piece
    place = (id(thing), branch) if branch.again else None
    if place in made:
        return made[place]
    if type(thing) is tuple:
        items = list(thing)
        for step, rest in branch.steps:
            items[step] = _put(items[step], rest, piece, made)
        copy = tuple(items)
    else:
        copy = copied(thing)
        own = copy.__dict__
        for step, rest in branch.steps:
            own[step] = _put(own[step], rest, piece, made)
    if place is not None:
        made[place] = copy
    return copy


def named_leaves(thing: Any) -> dict[tuple[str, ...], list[PiecePath]]:
    """Paths of each symbol, and of each number with a name of its own, in order."""
    found: dict[tuple[str, ...], list[PiecePath]] = {}
    _walk(thing, (), found)
    return found


def _walk(thing: Any, path: PiecePath, found: dict[tuple[str, ...], list[PiecePath]]) -> None:
    kind = type(thing)
    if kind is float or kind is str:
        return
    if isinstance(thing, Parameter):
        found.setdefault((thing.name,), []).append(path)
    elif kind is NamedNumber or (kind is Members and thing.name):
        found.setdefault(thing.name, []).append(path)
    elif kind is tuple:
        for i, item in enumerate(thing):
            _walk(item, (*path, i), found)
    elif kind is not Members:
        for name in fields_of(kind):
            _walk(getattr(thing, name), (*path, name), found)


def is_plain(thing: Any) -> bool:
    """Whether an object holds neither symbols nor numbers with names of their own."""
    return not named_leaves(thing)
