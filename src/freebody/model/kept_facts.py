"""Facts about a model, found once: those that follow from the model alone, kept with it, and those
that follow from its geometry, kept with that.

The geometry of a model is its structure, with the numbers that say where things are, and how its
loops are taken. Masses, gravity, friction, springs and limits are no part of it. Models of equal
geometry share one object, and with it what follows from the geometry alone: how a closed chain can
move, which of its equations count. So another payload finds nothing anew.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakValueDictionary

from freebody.lazy import kept
from freebody.model.families import LengthsDiffer

if TYPE_CHECKING:
    from freebody.model.model import Model

T = TypeVar("T")


class Geometry:
    """The facts shared by models that differ in other numbers than lengths and angles; equal ones
    are one object."""

    __slots__ = ("__weakref__", "facts")

    def __init__(self) -> None:
        self.facts: dict[Any, Any] = {}
        """Facts that follow from the geometry and have been found before; see `geometric_fact`."""


_known: WeakValueDictionary[Any, Geometry] = WeakValueDictionary()


def geometry_of(model: Model) -> Geometry:
    """The geometry of a model with all values; refuses a family whose members are not all of
    one."""
    numbers = model.numbers.take(model.structure.geometric, axis=-1) + 0.0  # -0.0 is 0.0
    if numbers.ndim > 1:
        numbers = numbers.reshape(-1, numbers.shape[-1])
        if (numbers != numbers[0]).any():
            raise LengthsDiffer(model.name, model.family)
        numbers = numbers[0]
    # `home` speaks of coordinates by name
    names = tuple([body.joint.name for body in model.bodies]) if model.home else ()
    key = model.structure, numbers.tobytes(), model.home, names, model.loop_tolerance
    found = _known.get(key)
    return _known.setdefault(key, Geometry()) if found is None else found


def geometric_fact(find: Callable[[Model], T]) -> Callable[[Model], T]:
    """The function `find`, called once a geometry: it looks at nothing else of a model, and of a
    family at its first member."""
    return _kept(find, lambda model: model.geometry.facts, first_member)


def first_member(model: Model) -> Model:
    """A robot of the model's geometry: itself, or of a family the first."""
    if not model.family:
        return model
    return kept(model, "_first_member", lambda: model[(0,) * len(model.family)])


def fact(find: Callable[[Model], T]) -> Callable[[Model], T]:
    """The function `find`, called once a model: it takes nothing else, so that no answer depends on
    what was found before."""
    return _kept(find, lambda model: model.facts, lambda model: model)


def _kept(
    find: Callable[[Model], T],
    facts_of: Callable[[Model], dict[Any, Any]],
    asked: Callable[[Model], Model],
) -> Callable[[Model], T]:
    """The function `find`, called with the model that is asked, once for each of these facts."""
    key = f"{find.__module__}.{find.__qualname__}"

    @wraps(find)
    def known(model: Model) -> T:
        facts = facts_of(model)
        if key not in facts:  # of two threads both take what the first found
            facts.setdefault(key, find(asked(model)))
        return facts[key]

    return known
