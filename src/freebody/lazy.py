"""Values computed on first access and kept in the instance, without a lock."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

T = TypeVar("T")


class Keeps:
    """A frozen dataclass that keeps computed values in the instance; a pickle carries its fields
    only."""

    def __getstate__(self) -> dict[str, Any]:
        return by_field(self)


def by_field(instance: Any) -> dict[str, Any]:
    """The values of a dataclass's fields, by their names."""
    return {field.name: getattr(instance, field.name) for field in dataclasses.fields(instance)}


def kept(instance: object, name: str, find: Callable[..., T], *arguments: Any) -> T:
    """The value of `find(*arguments)`, computed once for a frozen instance and kept there by name;
    such an instance is of `Keeps`, or pickles its fields alone."""
    values = instance.__dict__
    if name not in values:
        return values.setdefault(name, find(*arguments))
    return values[name]


class cached_property(Generic[T]):
    """A property computed once for each instance, without the lock of `functools.cached_property`
    before Python 3.12, which is shared by all instances: a process forked while another thread
    computes would never see it released.

    Two threads that ask at the same moment may both compute; both get the value that was kept
    first. The value is of a frozen instance, so it does not matter which.

    The class shows a plain property in its place. By that, those who ask a class what its
    instances have (completion in a shell, `help`) know that looking at the value may compute or
    raise, and do not look; completion in Python's own shell would otherwise end at the first
    property that raises, such as the mass of a robot without numbers.
    """

    def __init__(self, function: Callable[[Any], T]):
        self.function = function
        self.__doc__ = function.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> property: ...

    @overload
    def __get__(self, instance: object, owner: type) -> T: ...

    def __get__(self, instance: object | None, owner: type) -> property | T:
        if instance is None:
            return property(self.function)
        # the instance's own entry is found before this descriptor from now on
        return instance.__dict__.setdefault(self.name, self.function(instance))
