"""A check for public functions whose first argument is a model: it says what to write where
something else is given."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from functools import wraps
from typing import Any

from freebody.arrays import too_large
from freebody.errors import KindError
from freebody.model.families import FamilyError
from freebody.model.model import Model


def require_model(name: str, model: object) -> None:
    """Refuse an object that is no model; functions that are called a million times a second check
    this themselves."""
    if not isinstance(model, Model):
        raise KindError(name, "the first argument", model, "a Model", _advice(name, model))


def require_one(name: str, model: Model) -> None:
    """Refuse an object that is no model, and a family."""
    require_model(name, model)
    if model.family:
        raise FamilyError(name, model.name, model.family)


_OF_FAMILIES = (
    *("parameters", "kernel", "reactions", "simulate", "inverse_kinematics"),
    *("payload_map", "workspace", "natural_frequencies", "deflection"),
)
"""Public functions of families, besides those that look themselves what they are given."""


def takes_model(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """The function under its public name, which refuses a first argument that is no model, or a
    family where one robot is needed, and names the argument that is too large where memory does not
    suffice."""
    plain = name in _OF_FAMILIES
    require = require_model if plain else require_one

    @wraps(function)
    def checked(model: Model, *args: Any, **kwargs: Any) -> Any:
        if not plain or type(model) is not Model:
            require(name, model)
        try:
            return function(model, *args, **kwargs)
        except (MemoryError, ValueError) as problem:
            named = inspect.signature(function).bind(model, *args, **kwargs).arguments
            explained = too_large(name, named, problem)
            if explained is problem:
                raise
            raise explained from None

    # a function is pickled by the place where it is found
    checked.__module__, checked.__qualname__ = "freebody", name
    return checked


def _advice(name: str, given: object) -> str:
    """Advice on how to get a model, or to put the arguments in order."""
    if isinstance(given, str | os.PathLike):
        return f"Write fb.{name}(fb.load({os.fspath(given)!r}), …)."
    return f"Write fb.{name}(model, …) with a model from fb.load, fb.planar or fb.dh."
