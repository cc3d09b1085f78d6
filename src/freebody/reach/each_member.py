"""Results of families of robots, a member at a time: of functions whose steps are those of one
robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.model.model import Model

MemberResult = TypeVar("MemberResult")


@dataclass(frozen=True)
class MemberResults(Generic[MemberResult]):
    """The results for each member of a family of this shape, in the order of its entries."""

    family: tuple[int, ...]
    results: Sequence[MemberResult]

    @property
    def first(self) -> MemberResult:
        """The result of the first member."""
        return self.results[0]

    def stacked(self, part: Callable[[MemberResult], Array], core: int) -> Array:
        """An array of all results (..., *family, core axes), of arrays (..., core axes)."""
        parts = [np.asarray(part(one)) for one in self.results]
        whole = np.stack(parts, axis=parts[0].ndim - core)
        batch = whole.shape[: parts[0].ndim - core]
        return whole.reshape(*batch, *self.family, *whole.shape[len(batch) + 1 :])


def of_members(
    model: Model, given: Mapping[str, Any], found: Callable[[Model, dict[str, Any]], MemberResult]
) -> MemberResults[MemberResult]:
    """The results of a function for each member of a family, with its part of the arguments.

    given: vectors (..., *family, n), and what all members share: vectors (n,), mappings of such
    (numbers, or vectors by frame), numbers, None.
    """
    family = model.family
    rows = {name: _rows(name, value, family) for name, value in given.items()}
    return MemberResults(
        family,
        [
            found(model[at], {name: of(at) for name, of in rows.items()})
            for at in np.ndindex(family)
        ],
    )


def _rows(name: str, value: Any, family: tuple[int, ...]) -> Callable[[tuple[int, ...]], Any]:
    """The function from a member's index to its part of a vector (..., *family, n)."""
    if isinstance(value, Mapping):
        parts = {key: _rows(f"{name}[{key!r}]", one, family) for key, one in value.items()}
        return lambda at: {key: of(at) for key, of in parts.items()}
    if value is None or np.ndim(value) < 2:
        return lambda at: value
    array, axes = np.asarray(value), len(family)
    shape, core = array.shape[:-1], array.shape[-1:]
    try:
        whole = np.broadcast_to(array, (*np.broadcast_shapes(shape, family), *core))
    except ValueError:
        whole = array
    if whole.shape[-1 - axes : -1] != family:
        raise FreebodyError(
            f"{name} has the shape {array.shape}, which does not go with a family of shape "
            f"{family}: its last axes but one are those of the family."
        )
    return lambda at: whole[(..., *at, slice(None))]
