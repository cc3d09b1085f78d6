"""Array types with named dimensions, and the one check of shape that every public function uses.

Dimensions: `nq` positions, `nv` velocities, `nj` joints, `six` = 6 in space and 3 in the plane,
`dim` = 3 or 2. Leading dimensions `...` are a batch of any shape.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freebody.errors import FreebodyError, NotFiniteError, ShapeError
from freebody.labels import refuse_labelled

Array = NDArray[np.float64]
"""float64 array; the docstring of each function gives its shape."""


def as_floats(function: str, argument: str, value: ArrayLike) -> Array:
    """`value` as float64 array without a copy where possible; refuses text, objects, complex
    numbers and names."""
    refuse_labelled(f"{function}: {argument}", value)
    try:
        array = np.asarray(value)
    except ValueError:
        raise FreebodyError(
            f"{function}: {argument} has rows of different lengths; make them equal."
        ) from None
    if array.dtype == np.float64:
        return array
    if array.dtype.kind not in "iufb":
        raise FreebodyError(
            f"{function}: {argument} holds {array.dtype} values, expected real numbers."
        )
    return array.astype(np.float64)


def above_zero(function: str, argument: str, value: float, unit: str = "") -> float:
    """`value` as a finite number above 0; `unit`: what it counts, for the message."""
    array = as_floats(function, argument, value)
    if array.ndim or not (np.isfinite(array) and array > 0.0):
        said = f"{float(array):g}" if array.ndim == 0 else f"of shape {array.shape}"
        what = f"a number of {unit} above 0" if unit else "a number above 0"
        raise FreebodyError(f"{function}: {argument} is {said}, expected {what}.")
    return float(array)


def is_count(value: object, least: int = 1) -> bool:
    """Whether a value is a whole number from `least` up, NumPy's too; True and False are none."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        return False
    return bool(value >= least)


def check_core(
    function: str, argument: str, array: Array, core: tuple[int, ...], because: str
) -> None:
    """Refuse an array whose last dimensions are not `core`."""
    if array.shape[array.ndim - len(core) :] != core or array.ndim < len(core):
        raise ShapeError(
            function, argument, array.shape, f"(..., {', '.join(map(str, core))})", because
        )


def refuse_not_finite(
    function: str, argument: str, array: Array, core: int, labels: Sequence[str] = ()
) -> None:
    """Refuse NaN and infinity, naming the sample (leading index) and, with `labels`, the
    component."""
    bad = np.argwhere(~np.isfinite(array))
    if not len(bad):
        return
    index = tuple(int(i) for i in bad[0])
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
