"""Quantities of a model: plain numbers, or parameters with a name and perhaps a value."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from freebody.errors import ModelError, shown
from freebody.model.families import Members, fields_of
from freebody.outputs.number_text import compared

T = TypeVar("T")


@dataclass(frozen=True)
class Parameter:
    """A named quantity: equations show its name, numbers use its value (None: not known yet)."""

    name: str
    value: Any = None
    """A float, `Members`, or None."""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise ModelError(
                f"parameter name {self.name!r} must be a word of letters, digits and _, such as "
                f"'l1'."
            )
        if self.value is not None and not isinstance(self.value, Members):
            object.__setattr__(self, "value", finite(self.value, f"parameter {self.name!r}"))

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the parameters whose values are needed for this one's value."""
        return (self.name,) if self.value is None else ()


@dataclass(frozen=True)
class ParameterProduct:
    """A product that a kernel computes of quantities, some of which are its inputs."""

    factors: tuple[Any, ...]


Quantity = float | Parameter | Members

LARGEST = 1e60
"""No number of a robot is larger, in any unit; some products of five such numbers would
overflow."""


def real(value: object, owner: str) -> float:
    """`value` as a float, perhaps infinite or NaN, or an error that names its owner."""
    try:
        if isinstance(value, str | bytes | bool | np.bool_):  # float() would read some
            raise TypeError
        return float(value)  # type: ignore[arg-type]  # whatever float() refuses is told below
    except (TypeError, ValueError):
        raise ModelError(f"{owner}: {shown(value)} is not a number.") from None
    except OverflowError:  # an integer
        return math.inf


def finite(value: object, owner: str) -> float:
    """`value` as a finite float, or an error that names its owner."""
    if type(value) is float and -LARGEST <= value <= LARGEST:  # most are
        return value
    number = real(value, owner)
    if not math.isfinite(number):
        raise ModelError(f"{owner}: {number} is not a finite number.")
    if abs(number) > LARGEST:
        given, most = compared(number, LARGEST, digits=6)
        raise ModelError(f"{owner}: {given} is too large; numbers of a robot stay below {most}.")
    return number


def quantity(value: object, owner: str, default_name: str | None = None) -> Quantity:
    """A number, a name, a Parameter or None as a Quantity.

    A name becomes a parameter without value, None the parameter `default_name`; with a
    `default_name` a number becomes that parameter's value.
    """
    if isinstance(value, (Parameter, Members)):
        return value
    if isinstance(value, str):
        return Parameter(value)
    if value is None:
        if default_name is None:
            raise ModelError(f"{owner}: a number or a name is needed.")
        return Parameter(default_name)
    number = finite(value, owner)
    return number if default_name is None else Parameter(default_name, number)


def each_parameter(thing: Any) -> Iterator[Parameter]:
    """All parameters inside a tree of dataclasses, tuples and dicts, in order."""
    if isinstance(thing, Parameter):
        yield thing
    elif isinstance(thing, tuple):
        for item in thing:
            if type(item) is not float:  # most are
                yield from each_parameter(item)
    else:
        for name in fields_of(type(thing)):
            item = getattr(thing, name)
            if type(item) is not float:
                yield from each_parameter(item)


def one_value_each(thing: T, owner: str) -> T:
    """A tree of dataclasses and tuples in which each name has the same value at all its places.

    Raises ModelError for a name that has two.
    """
    known: dict[str, Any] = {}
    without = False
    for parameter in each_parameter(thing):
        value = known.setdefault(parameter.name, parameter.value)
        without = without or parameter.value is None
        if value is None:
            known[parameter.name] = parameter.value
        elif parameter.value is not None and parameter.value != value:
            raise ModelError(
                f"{owner}: parameter {parameter.name!r} has two values, {_shown(value)} and "
                f"{_shown(parameter.value)}; a name is one number."
            )
    if not without or not any(value is not None for value in known.values()):
        return thing
    return with_parameters(thing, lambda old: _valued(old, known[old.name]))


def _shown(value: Any) -> str:
    return "those of a family" if isinstance(value, Members) else f"{value:g}"


def _valued(old: Parameter, value: Any) -> Parameter:
    return old if value is None or old.value is not None else Parameter(old.name, value)


def with_parameters(thing: Any, change: Callable[[Parameter], Any]) -> Any:
    """A copy of a tree of dataclasses and tuples, each parameter replaced by change(parameter)."""
    if isinstance(thing, Parameter):
        return change(thing)
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        old = {
            field.name: getattr(thing, field.name)
            for field in dataclasses.fields(thing)
            if field.init
        }
        new = {
            name: value if type(value) is float else with_parameters(value, change)
            for name, value in old.items()
        }
        if all(new[name] is old[name] for name in old):
            return thing
        return dataclasses.replace(thing, **new)
    if isinstance(thing, tuple):
        items = tuple(with_parameters(item, change) for item in thing)
        return thing if all(a is b for a, b in zip(items, thing, strict=True)) else items
    return thing
