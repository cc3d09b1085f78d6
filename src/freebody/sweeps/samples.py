"""`samples`: points spread over ranges, for one axis of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats
from freebody.errors import FreebodyError, KindError, UnknownNameError


def _sobol(count: int, dimensions: int, seed: int) -> Array:
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    return engine.random_base2((count - 1).bit_length())[:count]


def _latin(count: int, dimensions: int, seed: int) -> Array:
    from scipy.stats import qmc

    return qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(count)


def _random(count: int, dimensions: int, seed: int) -> Array:
    return np.random.default_rng(seed).random((count, dimensions))


SAMPLERS: dict[str, Callable[[int, int, int], Array]] = {
    "sobol": _sobol,
    "latin-hypercube": _latin,
    "random": _random,
}
"""(count, dimensions, seed) -> points of the unit cube (count, dimensions)."""


def samples(
    count: int, ranges: Mapping[str, Any], *, method: str = "sobol", seed: int = 0
) -> dict[str, Array]:
    """Points spread over ranges, as one axis of `fb.sweep`: by name arrays (count, ...).

    ranges: by name (low, high), numbers or arrays of one shape, such as {"link2.mass": (1, 3),
    "q": (-np.ones(6), np.ones(6))}. method: "sobol" (scrambled Sobol points; most even for a power
    of two), "latin-hypercube" (each range cut into `count` equal parts, one point in each), both of
    scipy.stats.qmc, or "random" (uniform, independent). seed: the same seed gives the same points.

    Raises FreebodyError, UnknownNameError.
    """
    if method not in SAMPLERS:
        raise UnknownNameError("method", method, "samples", SAMPLERS)
    if not isinstance(count, int | np.integer) or isinstance(count, bool) or count < 1:
        raise KindError("samples", "count", count, "a whole number from 1 up")
    if not isinstance(ranges, Mapping) or not ranges:
        raise KindError("samples", "ranges", ranges, "a dict, as {'link2.mass': (1.0, 3.0)}")
    bounds = {name: _bounds(name, pair) for name, pair in ranges.items()}
    points = SAMPLERS[method](int(count), sum(low.size for low, _ in bounds.values()), seed)
    found, first = {}, 0
    for name, (low, high) in bounds.items():
        part = points[:, first : first + low.size].reshape(count, *low.shape)
        found[name], first = low + (high - low) * part, first + low.size
    return found


def _bounds(name: str, pair: Any) -> tuple[Array, Array]:
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise KindError("samples", f"ranges[{name!r}]", pair, "a pair (low, high)")
    low, high = (as_floats("samples", f"ranges[{name!r}]", end) for end in pair)
    if low.shape != high.shape or not (np.isfinite(low) & np.isfinite(high) & (low <= high)).all():
        raise FreebodyError(
            f"samples: ranges[{name!r}] must be a pair (low, high) of finite numbers, or of arrays "
            f"of one shape, with low <= high."
        )
    return low, high
