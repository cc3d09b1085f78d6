"""Paths q(s), polynomials in pieces, and their derivatives at many points by one kernel."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from freebody.algorithms import path_timing
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.motion.piecewise import PiecewisePolynomial
from freebody.motion.ranges import Flags
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program, result_memory


class PathSamples(NamedTuple):
    """Paths at points s (T, P). orders: q and its derivatives by s (T, P, nv), as many as are not 0
    in some path, at least two."""

    s: Array
    orders: tuple[Array, ...]

    @property
    def q(self) -> Array:
        """(T, P, nv)."""
        return self.orders[0]

    @property
    def first(self) -> Array:
        """q' (T, P, nv)."""
        return self.orders[1]

    @property
    def second(self) -> Array:
        """q'' (T, P, nv)."""
        return self.orders[2]

    def part(self, points: slice) -> PathSamples:
        """At some of the points."""
        return PathSamples(self.s[points], tuple(x[points] for x in self.orders))

    def only(self, paths: Flags) -> PathSamples:
        """Of some paths."""
        return PathSamples(self.s[:, paths], tuple(x[:, paths] for x in self.orders))


def sampled(curves: Sequence[PiecewisePolynomial], s: Array) -> PathSamples:
    """Each path at its own points s (T, P)."""
    n = curves[0].coefficients.shape[-1]
    highest = max(len(curve.coefficients) for curve in curves) - 1
    kernel = _values(n, highest)
    orders = tuple(result_memory.empty((*s.shape, n)) for _ in kernel.program.outputs)
    own = result_memory.empty((len(s), highest + 1, n))
    for k, curve in enumerate(curves):
        powers = np.zeros((len(curve.breaks) - 1, highest + 1, n))
        powers[:, highest + 1 - len(curve.coefficients) :] = curve.coefficients.swapaxes(0, 1)
        piece = np.searchsorted(curve.breaks[1:-1], s[:, k], side="right")
        beyond = s[:, k] - curve.breaks.take(piece)
        powers.take(piece, axis=0, out=own, mode="clip")  # other modes make a copy of `own`
        kernel(own, beyond, out=tuple(x[:, k] for x in orders))
    return PathSamples(s, orders)


@lru_cache(maxsize=8)
def _values(n: int, degree: int) -> Kernel:
    """`path_timing.curve_values` of n coordinates."""

    def values(powers: Scalar, beyond: Scalar) -> tuple[Scalar, ...]:
        return tuple(path_timing.curve_values(powers, beyond))

    inputs = [Argument("powers", (degree + 1, n)), Argument("beyond", ())]
    outputs = [Argument(f"d{k}", (n,)) for k in range(max(degree, 2) + 1)]
    return compile_program(trace("path_values", values, inputs, outputs))
