"""What follows from a model alone: found once, and kept with it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from freebody.model.model import Model

T = TypeVar("T")


def fact(find: Callable[[Model], T]) -> Callable[[Model], T]:
    """`find`, done once a model: it takes nothing else, so that no answer depends on what was asked
    before."""
    key = f"{find.__module__}.{find.__qualname__}"

    @wraps(find)
    def known(model: Model) -> T:
        facts = model.facts
        if key not in facts:
            facts.setdefault(
                key, find(model)
            )  # of two threads that find it at once, both take the first's
        return facts[key]

    return known
