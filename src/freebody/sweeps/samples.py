"""`samples`: points spread over ranges, for one axis of a sweep.

They come in runs, each of which follows from the seed and its number alone: whoever needs some
points makes their runs, and nobody needs the list of all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats, is_count
from freebody.errors import (
    FreebodyError,
    KindError,
    OutOfMemoryError,
    UnknownNameError,
    listed,
)
from freebody.lazy import cached_property
from freebody.outputs.display import Titled

_RUN = 1 << 18
"""The number of points of a run."""
_HELD = 1 << 24
"""Numbers of samples that are held as a whole: 128 MB."""

UnitPoints = Callable[[int, int, np.random.Generator], Array]
"""(count, dimensions, generator) -> points of the unit cube (count, dimensions)."""


def _sobol(count: int, dimensions: int, rng: np.random.Generator) -> Array:
    from scipy.stats import qmc

    return qmc.Sobol(dimensions, rng=rng).random_base2((count - 1).bit_length())[:count]


def _latin(count: int, dimensions: int, rng: np.random.Generator) -> Array:
    from scipy.stats import qmc

    return qmc.LatinHypercube(dimensions, rng=rng).random(count)


def _random(count: int, dimensions: int, rng: np.random.Generator) -> Array:
    return rng.random((count, dimensions))


@dataclass(frozen=True)
class Sampler:
    """A method to spread points. runs: whether any run of points can be made without the others.
    scipy: whether its points come from SciPy, and may change with it."""

    unit: UnitPoints
    runs: bool
    scipy: bool


SAMPLERS = {
    "sobol": Sampler(_sobol, True, True),
    "latin-hypercube": Sampler(_latin, False, True),
    "random": Sampler(_random, True, False),
}


@dataclass(frozen=True, eq=False, repr=False)
class Samples(Titled, Mapping[str, Array]):
    """Sampled points by name, made on access: `found["m2"]` has all of them, (count, ...).

    bounds: by name (low, high), arrays of one shape.
    """

    count: int
    method: str
    seed: int
    bounds: dict[str, tuple[Array, Array]]

    def _title(self) -> str:
        return (
            f"Samples: {self.count} of {listed(self.bounds, 4)} by {self.method}, seed {self.seed}"
        )

    def __getitem__(self, name: str) -> Array:
        low, high = self.bounds[name]
        first = 0
        for other, (lows, _) in self.bounds.items():
            if other == name:
                break
            first += lows.size
        part = self._points(slice(0, self.count))[:, first : first + low.size]
        return low + (high - low) * part.reshape(-1, *low.shape)

    def __iter__(self) -> Iterator[str]:
        return iter(self.bounds)

    def __len__(self) -> int:
        return len(self.bounds)

    def at(self, places: slice | np.ndarray) -> dict[str, Array]:
        """The samples with the given indices by name, (*places, ...)."""
        points = self._points(places)
        found, first = {}, 0
        for name, (low, high) in self.bounds.items():
            part = points[..., first : first + low.size]
            first += low.size
            found[name] = low + (high - low) * part.reshape(*part.shape[:-1], *low.shape)
        return found

    def renamed(self, names: Mapping[str, str]) -> Samples:
        """The samples under other names."""
        bounds = {names[name]: pair for name, pair in self.bounds.items()}
        return Samples(self.count, self.method, self.seed, bounds)

    def __reduce__(self) -> tuple[Any, ...]:
        return Samples, (self.count, self.method, self.seed, self.bounds)  # without the points

    @property
    def _dimensions(self) -> int:
        return sum(low.size for low, _ in self.bounds.values())

    def _points(self, places: slice | np.ndarray) -> Array:
        """The points of the unit cube with the given indices, (*places, dimensions)."""
        if not SAMPLERS[self.method].runs or self.count * self._dimensions <= _HELD:
            return self._all[places]
        if isinstance(places, slice):
            start, stop, _ = places.indices(self.count)
            parts = [
                self._run(k)[max(start - k * _RUN, 0) : stop - k * _RUN]
                for k in range(start // _RUN, -(-stop // _RUN))
            ]
            return parts[0] if len(parts) == 1 else np.concatenate(parts)
        found = np.empty((*places.shape, self._dimensions))
        run, within = np.divmod(places, _RUN)
        for k in np.unique(run).tolist():
            here = run == k
            found[here] = self._run(k)[within[here]]
        return found

    @cached_property
    def _all(self) -> Array:
        size = _RUN if SAMPLERS[self.method].runs else self.count
        parts = [
            _made(self.method, min(size, self.count - first), self._dimensions, self.seed, k)
            for k, first in enumerate(range(0, self.count, size))
        ]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _run(self, number: int) -> Array:
        size = min(_RUN, self.count - number * _RUN)
        return _kept(self.method, size, self._dimensions, self.seed, number)


def _made(method: str, count: int, dimensions: int, seed: int, run: int) -> Array:
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(run,)))
    try:
        points = SAMPLERS[method].unit(count, dimensions, rng)
    except MemoryError:
        raise OutOfMemoryError(
            f"samples: {count} points of method {method!r} do not fit into memory, and are made "
            f"all at once; 'sobol' and 'random' make them in parts."
        ) from None
    points.flags.writeable = False
    return points


_kept = lru_cache(maxsize=4)(_made)
"""The last runs, of which a sweep reads a part at a time."""


def samples(
    count: int, ranges: Mapping[str, Any], *, method: str = "sobol", seed: int = 0
) -> Samples:
    """Points spread over ranges, as one axis of `fb.sweep`: arrays (count, ...) by name.

    ranges: by name (low, high), numbers or arrays of one shape, such as {"link2.mass": (1, 3),
    "q": (-np.ones(6), np.ones(6))}. method: "sobol" (scrambled Sobol points; most even for a power
    of two; more than 2**18 are several such sets, each scrambled by itself), "latin-hypercube"
    (each range cut into `count` equal parts, one point in each), both of scipy.stats.qmc, or
    "random" (uniform, independent). seed: a whole number from 0 up; the same seed gives the same
    points, and a smaller count the first of them (except for a Latin hypercube).

    Points are made when they are read. A sweep reads those of its block alone: Sobol and random
    points follow from the seed and the number of their set of 2**18, so that any number of them
    takes no memory; a Latin hypercube is made all at once.

    Raises FreebodyError, UnknownNameError.
    """
    if method not in SAMPLERS:
        raise UnknownNameError("method", method, "samples", SAMPLERS)
    if not is_count(count):
        raise KindError("samples", "count", count, "a whole number from 1 up")
    if not is_count(seed, 0):
        raise KindError("samples", "seed", seed, "a whole number from 0 up")
    if not isinstance(ranges, Mapping) or not ranges:
        raise KindError("samples", "ranges", ranges, "a dict, as {'link2.mass': (1.0, 3.0)}")
    bounds = {name: _bounds(name, pair) for name, pair in ranges.items()}
    return Samples(int(count), method, int(seed), bounds)


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
