"""Array types with named dimensions, and the one check of shape that every public function uses.

Dimensions: `nq` positions, `nv` velocities, `nj` joints, `six` = 6 in space and 3 in the plane,
`dim` = 3 or 2. Leading dimensions `...` are a batch of any shape.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freebody.errors import (
    FreebodyError,
    NotFiniteError,
    OutOfMemoryError,
    ShapeError,
    listed,
    no_real_numbers,
    shown,
)
from freebody.labels import refuse_labelled

Array = NDArray[np.float64]
"""float64 array; the docstring of each function gives its shape."""


def as_floats(function: str, argument: str, value: ArrayLike) -> Array:
    """`value` as float64 array without a copy where possible; refuses text, objects, complex
    numbers and names."""
    refuse_labelled(f"{function}: {argument}", value)
    array = as_array(function, argument, value)
    if array.dtype == np.float64:
        return array
    if array.dtype.kind not in "iufb":
        raise FreebodyError(no_real_numbers(f"{function}: {argument}", array))
    return array.astype(np.float64)


def as_array(function: str, argument: str, value: Any) -> np.ndarray[Any, Any]:
    """`value` as array of whatever it holds; refuses rows of different lengths."""
    try:
        return np.asarray(value)
    except ValueError:
        raise FreebodyError(
            f"{function}: {argument} has rows of different lengths; make them equal."
        ) from None


def above_zero(function: str, argument: str, value: float, unit: str = "") -> float:
    """`value` as a finite number above 0; `unit`: what it counts, for the message."""
    what = f"a number of {unit} above 0" if unit else "a number above 0"
    if isinstance(value, bool | np.bool_):
        raise FreebodyError(f"{function}: {argument} is {value!r}, expected {what}.")
    array = as_floats(function, argument, value)
    if array.ndim or not (np.isfinite(array) and array > 0.0):
        said = f"{float(array):g}" if array.ndim == 0 else f"of shape {array.shape}"
        raise FreebodyError(f"{function}: {argument} is {said}, expected {what}.")
    return float(array)


def is_count(value: object, least: int = 1) -> bool:
    """Whether a value is a whole number from `least` up, NumPy's too; True and False are none."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        return False
    return bool(value >= least)


def check_core(
    function: str, argument: str, array: Any, core: tuple[int, ...], because: str = ""
) -> None:
    """Refuse an array, or another library's, whose last dimensions are not `core`."""
    shape = tuple(array.shape)
    if shape[len(shape) - len(core) :] != core or len(shape) < len(core):
        raise ShapeError(
            function, argument, shape, f"({', '.join(['...', *map(str, core)])})", because
        )


def refuse_not_finite(
    function: str, argument: str, array: Array, core: int, labels: Sequence[str] = ()
) -> None:
    """Refuse NaN and infinity, naming the sample (leading index) and, with `labels`, the
    component."""
    try:
        finite = np.isfinite(array)
    except MemoryError as problem:
        raise too_large(function, {argument: array}, problem) from None
    if finite.all():
        return
    index = tuple(int(i) for i in np.argwhere(~finite)[0])
    sample, component = index[: array.ndim - core], index[array.ndim - core :]
    where = at_sample(sample)
    if component:
        last = component[-1]
        where += f" for {labels[last]!r}" if last < len(labels) else f" at component {component}"
    raise NotFiniteError(function, argument, float(array[index]), where.strip() or "as given")


def at_sample(index: Sequence[int]) -> str:
    """ " at sample 3", " at sample (3, 1)" or, without a batch, nothing: for messages."""
    return (
        f" at sample {int(index[0]) if len(index) == 1 else tuple(map(int, index))}"
        if len(index)
        else ""
    )


def too_large(function: str, given: Mapping[str, Any], problem: Exception) -> Exception:
    """The error to raise where NumPy says that an array does not fit into memory: one that names
    the argument that its size comes from. Any other error is returned as it is.

    given: the arguments by name. The one is named that counts as many things as the array has
    entries, or most nearly: a number counts so many, or so many steps to 1, an array its entries.
    """
    if isinstance(problem, MemoryError):
        shape = getattr(problem, "shape", None)
    elif isinstance(problem, ValueError) and str(problem).startswith(_BEYOND_ADDRESSES):
        shape = ()
    else:
        return problem
    if shape is None:
        return (
            problem
            if isinstance(problem, OutOfMemoryError)
            else OutOfMemoryError(f"{function}: no memory is left.")
        )
    size = math.prod(shape) if shape else 2.0**63
    found = [
        (abs(math.log(count / size)), name, value)
        for name, value in given.items()
        for count in _counts(value)
        if count >= _MANY
    ]
    cause = "this call"
    if found:
        _, name, value = min(found, key=lambda x: x[0])
        if isinstance(value, Mapping):
            cause = f"{name} of {listed(map(str, value), most=6)}"
        elif isinstance(value, np.ndarray) and value.ndim:
            cause = f"{name} of shape {value.shape}"
        else:
            cause = f"{name}={shown(value)}"
    array = f"an array of shape {tuple(shape)}" if shape else "an array beyond all addresses"
    room = f", {_bytes(8.0 * size)} of 64-bit numbers," if shape else ""
    return OutOfMemoryError(
        f"{function}: {cause} asks for {array}{room} which does not fit into memory; give less "
        f"at a time.",
        shape,
    )


_BEYOND_ADDRESSES = ("Maximum allowed", "array is too big")
"""Beginnings of NumPy's messages on sizes that no address space has."""

_MANY = 1000
"""Size below which an argument is not to blame for an array that does not fit into memory."""


def _counts(value: Any) -> Iterator[float]:
    """The numbers of entries that an argument may stand for, from which `too_large` guesses which
    one an array's size comes from."""
    if isinstance(value, Mapping):
        sizes = [count for entry in value.values() for count in _counts(entry)]
        yield math.prod(sizes) if sizes else 0.0
    elif isinstance(value, np.ndarray) and value.ndim:
        yield float(value.size)
    elif isinstance(value, tuple) and all(is_count(x, 0) for x in value):
        yield float(math.prod(value))
    elif isinstance(value, int | float | np.number) and np.isfinite(value) and value > 0:
        yield float(value)
        yield 1.0 / float(value)


def _bytes(size: float) -> str:
    """A size in bytes as NumPy writes it, such as "72.8 TiB"."""
    power = min(int(math.log2(size) // 10), len(_UNITS) - 1)
    return f"{size / 1024.0**power:.3g} {_UNITS[power]}"


_UNITS = ("bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB")
