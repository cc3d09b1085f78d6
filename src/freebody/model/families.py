"""Numbers of many robots at once: a model some of whose numbers hold one value for each member is a
*family*."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from freebody.arrays import Array, too_large
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, ModelError, shown
from freebody.labels import refuse_masked
from freebody.outputs.number_text import compared


@dataclass(frozen=True, eq=False)
class Members(ByValue):
    """One number of a model for each member of a family: an array of the family's shape, or one
    that broadcasts to it.

    Equal by value, hashable, read-only; it has no truth and no order of its own, so that nothing is
    decided from it.
    """

    array: Array
    name: tuple[str, str] | None = None
    """The name of its own that it has as a `NamedNumber`."""
    _aside = ("name",)
    _copies = True


class NamedNumber(float):
    """A number of placements that has a name of its own: an entry of a DH table, wherever it is
    used."""

    __slots__ = ("name",)
    name: tuple[str, str]

    def __new__(cls, value: float, name: tuple[str, str]) -> NamedNumber:
        entry = super().__new__(cls, value)
        entry.name = name
        return entry

    def __reduce__(self) -> tuple[Any, ...]:
        return NamedNumber, (float(self), self.name)


def is_array(value: object) -> bool:
    """Whether something is given as one number for each member: an array, or nested sequences, of
    at least one axis."""
    return isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0)


def is_nested(value: Any) -> bool:
    """Whether something is given as an array of more than one axis, or as sequences that all hold
    sequences."""
    if isinstance(value, (list, tuple)):
        return bool(value) and all(map(is_array, value))
    return isinstance(value, np.ndarray) and value.ndim > 1


def members(value: Any, owner: str, largest: float) -> Members:
    """Finite numbers, one a member, or an error that names their owner and the member."""
    refuse_masked(owner, value)
    try:
        array = np.array(value)
    except MemoryError as problem:
        raise too_large(owner, {"the array": np.asarray(value)}, problem) from None
    except ValueError:
        array = np.array(None)
    if array.dtype.kind not in "iuf":
        raise ModelError(
            f"{owner}: {shown(value)} is not an array of real numbers, one for each member."
        )
    array = array.astype(float)
    if not array.size:
        raise ModelError(
            f"{owner}: an array of shape {array.shape} holds no number; a family needs at least "
            f"one member."
        )
    wrong = np.argwhere(~(np.abs(array) <= largest))
    if len(wrong):
        at = tuple(map(int, wrong[0]))
        given, most = compared(array[at], largest, digits=6)
        raise ModelError(f"{owner}: {given}{of_member(at)} must be a finite number below {most}.")
    return Members(array)


def of_member(index: tuple[int, ...]) -> str:
    """` (member 3)`, ` (member 3, 0)`: behind what is said of a family."""
    return f" (member {', '.join(map(str, index))})" if index else ""


def arrays_in(thing: Any) -> list[Members]:
    """Numbers with members anywhere in a tree of dataclasses and tuples."""
    found: list[Members] = []
    _collect(thing, found)
    return found


def _collect(thing: Any, found: list[Members]) -> None:
    kind = type(thing)
    if kind is float or kind is str:
        return
    if kind is Members:
        found.append(thing)
    elif kind is tuple:
        for item in thing:
            _collect(item, found)
    else:
        for name in fields_of(kind):
            _collect(getattr(thing, name), found)


@cache
def fields_of(kind: type) -> tuple[str, ...]:
    """The names of a dataclass's fields, of anything else none."""
    return (
        tuple(field.name for field in dataclasses.fields(kind))
        if dataclasses.is_dataclass(kind)
        else ()
    )


def common_shape(arrays: list[Members], owner: str) -> tuple[int, ...]:
    """The shape that arrays of numbers broadcast to; () without any."""
    shapes = [x.array.shape for x in arrays]
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        listed = ", ".join(map(str, dict.fromkeys(shapes)))
        raise ModelError(
            f"{owner}: arrays of shapes {listed} do not broadcast to one family; give one number "
            f"per member."
        ) from None


def one_family(model: Any, old: Any, *new: Any) -> Any:
    """A changed copy of `old`, whose arrays broadcast together; refuses it where those among what
    is new do not."""
    if {*map(type, new)} != {float} and arrays_in(new):
        common_shape(arrays_in(model), repr(model.name))
    elif (
        not old.family
    ):  # known at once: to look for arrays everywhere takes longer than many a change
        model.__dict__["family"] = ()
    return model


def member_at(model: Any, sample: tuple[int, ...]) -> Any:
    """The member of a family that a sample of a batch is of, whose last axes are the family's; of
    one robot itself."""
    shape = model.family
    if not shape:
        return model
    return model[
        tuple(
            k if n > 1 else 0
            for k, n in zip(sample[len(sample) - len(shape) :], shape, strict=True)
        )
    ]


def taken(thing: Any, shape: tuple[int, ...], index: Any) -> Any:
    """A tree of dataclasses and tuples with the members that `index` picks out of a family of that
    shape."""
    if isinstance(thing, Members):
        picked = np.broadcast_to(thing.array, shape)[index]
        number = float(picked) if np.ndim(picked) == 0 else None
        if number is None:
            return Members(picked, thing.name)
        return number if thing.name is None else NamedNumber(number, thing.name)
    if isinstance(thing, tuple):
        items = tuple(taken(item, shape, index) for item in thing)
        return thing if all(a is b for a, b in zip(items, thing, strict=True)) else items
    names = fields_of(type(thing))
    new = {name: taken(getattr(thing, name), shape, index) for name in names}
    if all(new[name] is getattr(thing, name) for name in names):
        return thing
    return changed(thing, new)


def changed(thing: Any, new: dict[str, Any]) -> Any:
    """A copy of a frozen dataclass with some fields other, unchecked: for numbers that have been
    checked where they came in. What the old one has found out since it was made is not carried
    over."""
    copy = copied(thing)
    copy.__dict__.update(new)
    return copy


def copied(thing: Any) -> Any:
    """A copy of a frozen dataclass with its fields alone, for callers that put others there at
    once."""
    kind = type(thing)
    copy = object.__new__(kind)
    own = copy.__dict__
    for name in fields_of(kind):
        own[name] = getattr(thing, name)
    return copy


class MemberError(FreebodyError, IndexError):
    """An index that selects no member of a family."""


class FamilyError(FreebodyError, TypeError):
    """A family where one robot is needed."""

    def __init__(self, function: str, name: str, shape: tuple[int, ...]):
        example = ", ".join("0" for _ in shape)
        super().__init__(
            f"{function}: {name!r} is a family of robots, shape {shape}, and one robot is needed "
            f"here: take a member, model[{example}]."
        )


class LengthsDiffer(FamilyError):
    """A family whose members are not of one geometry, where that is needed."""

    def __init__(self, name: str, shape: tuple[int, ...]):
        example = ", ".join("0" for _ in shape)
        FreebodyError.__init__(
            self,
            f"{name!r} is a family of robots, shape {shape}, whose lengths or placements differ, "
            f"and robots of one geometry are needed here: take a member, model[{example}]. Members "
            f"may differ in masses, inertias, friction and gravity.",
        )
