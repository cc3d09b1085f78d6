"""The lines that a derivation prints, as data: all pieces of one and the symbols in it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import freebody as fb


def nodes(line: Any) -> Iterator[Any]:
    """A printed line, or a piece of one, and all pieces in it."""
    yield line
    for part in line.parts:
        yield from nodes(part)


def symbols_in(line: Any) -> Iterator[Any]:
    """The symbols that stand in a printed line."""
    return (x for x in nodes(line) if hasattr(x, "name") and not x.parts)


def names_in(lines: Any) -> set[str]:
    """The names of all symbols in some lines."""
    return {x.name for line in lines for x in symbols_in(line)}


def are_equal(first: Any, second: Any) -> bool:
    """Whether two derivations end in the same torques, exactly."""
    return all((a - b).is_zero for a, b in zip(first.tau, second.tau, strict=True))


@lru_cache(maxsize=24)
def derived(name: str, method: str | None = None) -> Any:
    """The derivation of a bundled robot, the same for all tests that read it."""
    return fb.derive(fb.load(name, physical="ignore"), method)
