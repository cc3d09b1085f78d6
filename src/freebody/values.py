"""Equality by value: one rule for models, equations and results."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar

import numpy as np

from freebody.lazy import by_field


class ByValue:
    """A frozen dataclass (`eq=False`) whose `==` compares type, structure and numbers exactly,
    arrays too.

    Hashes agree with that, arrays in it cannot be written to, and a pickle carries the fields, not
    what was found from them since.
    """

    _aside: ClassVar[tuple[str, ...]] = ()
    """Fields that do not count: names of files, notices, times that were taken."""
    _copies: ClassVar[bool] = False
    """Whether arrays are copied, since they may be those of whoever made the value."""

    def __post_init__(self) -> None:
        for name in _names(type(self)):
            value = getattr(self, name)
            if isinstance(value, np.ndarray) and value.flags.writeable:
                value = value.copy() if self._copies else value.view()
                value.flags.writeable = False
                object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[Any, ...]:
        kind: Any = type(self)
        return tuple(
            key(getattr(self, field.name))
            for field in dataclasses.fields(kind)
            if field.compare and field.name not in self._aside
        )

    def __getstate__(self) -> dict[str, Any]:
        return by_field(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)
        self.__post_init__()


@cache
def _names(kind: type) -> tuple[str, ...]:
    """Names of a dataclass's fields."""
    return tuple(field.name for field in dataclasses.fields(kind))


def key(value: Any) -> Any:
    """Hashable key of a value for comparisons: equal keys mean that all numbers in the values are
    equal; NaN equals NaN."""
    if isinstance(value, np.ndarray):
        plain = value + 0.0 if value.dtype.kind == "f" else value  # -0.0 is 0.0
        entries = plain.tobytes() if value.dtype.kind in "fiub" else tuple(value.ravel().tolist())
        return value.dtype.kind, value.shape, entries
    if isinstance(value, float):
        return value if value == value else "nan"
    if isinstance(value, ByValue):
        return type(value), value._key()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = (f for f in dataclasses.fields(value) if f.compare)
        return type(value), tuple(key(getattr(value, f.name)) for f in fields)
    if isinstance(value, (tuple, list)):
        return tuple(map(key, value))
    if hasattr(value, "data_vars"):
        dataset: Any = value  # of xarray
        arrays = {**dataset.coords, **dataset.data_vars}
        return tuple(sorted((str(name), x.dims, key(x.values)) for name, x in arrays.items()))
    if isinstance(value, Mapping):
        return tuple(sorted((str(name), key(x)) for name, x in value.items()))
    return value
