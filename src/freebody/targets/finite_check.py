"""A quick check that a kernel's inputs and outputs are finite, by which public functions avoid
looking at each input."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any

import numpy as np

HUGE = 1e100
"""Size that no quantity of a robot has in SI units; products of such numbers leave the range of
float64."""

_FEW = 100  # entries that are looked at sooner in plain Python

_SHORT = 2**16
"""Entries that are copied sooner than looked at one by one where they stand."""

UNIT = 1e-6
"""How far a quaternion may be off unit length."""


class Unclear(Exception):
    """Raised with a kernel's results where not all are sound, for callers that compute some again
    more closely."""

    def __init__(self, result: Any):
        super().__init__()
        self.result = result


def sound(
    kernel: Callable[..., Any],
    arrays: tuple[Any, ...],
    units: Sequence[tuple[int, int]] = (),
    every: bool = False,
    kept: bool = False,
) -> Any:
    """The kernel's results for the arrays; None where an input is no plain array or list, or an
    entry may have overflowed.

    Outputs are looked at, or inputs where those are fewer: of inputs below `HUGE` no output
    overflows, and one that is not finite all the same is the answer (at a singular position, say).
    units: (array, entry) where four entries begin that are to be of unit length; None also where
    they are not. every: whether outputs are looked at in any case. kept: whether results that are
    not sound are raised as `Unclear`.
    """
    if not all(map(_plain, arrays)):
        return None
    result = kernel(*arrays)
    outputs = result if type(result) is tuple else (result,)
    fine = _finite(outputs, () if every else arrays) and all(
        _is_unit(arrays[i], start) for i, start in units
    )
    if kept and not fine:
        raise Unclear(result)
    return result if fine else None


def _is_unit(q: Any, start: int) -> bool:
    x = np.asarray(q)[..., start : start + 4]
    return bool((np.abs(np.vecdot(x, x) - 1.0) < UNIT).all())


def _finite(outputs: tuple[Any, ...], arrays: tuple[Any, ...]) -> bool:
    entries = sum(x.size for x in outputs)
    if entries == 1:
        return isfinite(outputs[0].item())
    if entries <= _FEW:
        return isfinite(sum(sum(x.ravel().tolist()) for x in outputs))
    plain = arrays and all(type(x) is np.ndarray and x.dtype == np.float64 for x in arrays)
    if plain and sum(x.size for x in arrays) < entries:
        return all(x.min(initial=0.0) >= -HUGE and x.max(initial=0.0) <= HUGE for x in arrays)
    return all(np.isfinite(x).all() for x in outputs)


def plainly(value: Any) -> Any:
    """Lists of numbers, and arrays of other real types or with gaps, as a float64 array that the
    quickest calls take; anything else, and long arrays, unchanged."""
    if type(value) is np.ndarray:
        kind = value.dtype
        if (
            kind.kind not in "fiu"
            or value.size > _SHORT
            or (kind == np.float64 and value.flags.c_contiguous and value.flags.aligned)
            or kind.itemsize > np.float64().itemsize
        ):
            return value
    elif type(value) not in (list, tuple) or not _plain(value):
        return value
    return np.array(value, dtype=np.float64, order="C")


def _plain(value: Any) -> bool:
    """Whether a value is an array or nested lists of numbers, without labels."""
    kind = type(value)
    return kind in _PLAIN or (kind in (list, tuple) and all(map(_plain, value)))


_PLAIN = frozenset({np.ndarray, float, int, bool, np.float64, np.float32, np.int64, np.int32})
