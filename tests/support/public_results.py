"""The classes of what public functions return, by introspection, and one value of each."""

from __future__ import annotations

import inspect
import sys
import typing
from collections.abc import Callable, Iterator
from typing import Any

import xarray

import freebody as fb

Made = dict[type, Any]


def result_classes() -> dict[type, str]:
    """Classes of freebody that a public function, or a public method or property of such a class,
    says it returns, and the first that does."""
    found: dict[type, str] = {}
    waiting = [(getattr(fb, name), f"fb.{name}") for name in fb.__all__ if name != "__version__"]
    while waiting:
        thing, name = waiting.pop()
        for kind in [thing] if inspect.isclass(thing) else returned(thing):
            if kind.__module__.startswith("freebody") and kind not in found:
                found[kind] = name
                waiting += [(x, f"{kind.__name__}.{n}") for n, x in members(kind)]
    return found


def members(kind: type) -> Iterator[tuple[str, Any]]:
    """Public methods and the functions of public properties."""
    for name, member in inspect.getmembers(kind):
        if not name.startswith("_"):
            yield name, member.fget if isinstance(member, property) else member


def returned(function: Callable[..., Any]) -> Iterator[type]:
    """The classes in a function's return annotation."""
    function = inspect.unwrap(function)
    if not inspect.isfunction(function):
        return
    names = {"xr": xarray, **vars(sys.modules[function.__module__])}
    try:
        given = eval(function.__annotations__.get("return", "None"), names)
    except NameError:  # of names that only a type checker imports
        return
    waiting = [given]
    while waiting:
        one = waiting.pop()
        waiting += typing.get_args(one)
        if inspect.isclass(one):
            yield one
