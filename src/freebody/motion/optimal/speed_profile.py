"""The fastest speeds along paths: limits as rows over a grid, and the passes that find the speeds.

With x = ṡ² and u = s̈ every limit is a row lo <= a u + b x <= hi at both ends of each interval of
the grid (see `algorithms.path_timing`). Arrays have the grid first, then the paths, which are
computed side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from freebody.algorithms import path_timing
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.motion.ranges import Flags
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program, result_memory
from freebody.targets.in_turn import recurrence

_SEARCHES = 40  # calls of some steps each: far more than there are lines
_CLOSE = 1e-9  # of the largest x: a gap between what is wanted and allowed of no account


class PathRows(NamedTuple):
    """Limits over a grid of N intervals along P paths.

    h: (N, P) twice the intervals' lengths. most: (N + 1, P) largest x, 0 at the end. a, b: (N + 1,
    P, m). lo, hi: (2, N, P, m) at the intervals' starts and ends.
    """

    h: Array
    most: Array
    a: Array
    b: Array
    lo: tuple[Array, Array]
    hi: tuple[Array, Array]


class SpeedProfile(NamedTuple):
    """Speeds along paths: x = ṡ² (N + 1, P), NaN for a path without solution; reachable: the range
    (N + 1, P, 2) of x from which the end can still be reached at rest, NaN where none."""

    x: Array
    reachable: Array

    @property
    def moves(self) -> Flags:
        """Flags (P,) of paths whose end is reached without a stop on the way."""
        slowest = self.x[1:-1].min(axis=0, initial=np.inf)  # NaN where one is
        return (slowest > 0.0) & np.isfinite(self.x[0]) & np.isfinite(self.x[-1])

    @property
    def starts(self) -> Flags:
        """Flags (P,) of paths whose end can be reached from rest."""
        return ~(self.reachable[0, :, 0] > _CLOSE * self.reachable[0, :, 1])


def quickest_profile(rows: PathRows) -> SpeedProfile:
    """The largest speeds from rest to rest."""
    polygon, backward, forward = _kernels(rows.a.shape[-1])
    over_y, over_x, corners = _polygons(polygon, rows)
    rest = np.zeros((rows.h.shape[1], 2))
    reachable = recurrence(backward, rest, over_y[::-1], corners[::-1])[::-1]
    x = recurrence(forward, rest[:, :1], over_x, reachable[1:, :, 1])[..., 0]
    return SpeedProfile(x, reachable)


def _polygons(kernel: Kernel, rows: PathRows) -> tuple[Array, ...]:
    """The polygon of each interval from `path_timing.polygon`, called again where its search has
    not ended."""
    given = [x.reshape(rows.h.size, x.shape[-1]) for x in both_ends(rows)]  # one axis is quickest
    most, beyond = (x.ravel() for x in (rows.most[:-1], rows.most[1:]))
    given += [beyond, rows.h.ravel()]
    over_y, over_x, corners, goes_on = kernel(*given, 0.0, most)
    for _ in range(_SEARCHES):
        left = np.flatnonzero(goes_on > 0.0)
        if not left.size:
            break
        reached = corners[left]
        found = kernel(*(x[left] for x in given), reached[:, 2], reached[:, 0])
        corners[left], goes_on[left] = found[2:]
    return tuple(x.reshape(*rows.h.shape, *x.shape[1:]) for x in (over_y, over_x, corners))


def both_ends(rows: PathRows) -> tuple[Array, ...]:
    """The rows at both ends of the intervals, (N, P, m) each, as `row_arguments` names them."""
    return (
        rows.a[:-1], rows.b[:-1], rows.lo[0], rows.hi[0],
        rows.a[1:], rows.b[1:], rows.lo[1], rows.hi[1],
    )  # fmt: skip


ENDS = tuple(Argument(name, ()) for name in ("x", "y", "h"))


def row_arguments(m: int) -> list[Argument]:
    names = ("a", "b", "lo", "hi")
    return [Argument(f"{name}{end}", (m,)) for end in ("", "_end") for name in names]


def speed_limits(first: Array, velocity: Array) -> Array:
    """The largest ṡ² (T, P) that limits of speed (n,) allow; first: q' (T, P, n)."""
    n = len(velocity)
    finite = np.minimum(velocity, path_timing.FAR)
    return _speed_limit(n)(first.reshape(-1, n), finite).reshape(first.shape[:2])


@lru_cache(maxsize=8)
def _speed_limit(n: int) -> Kernel:
    """The kernel of `path_timing.speed_limit` for n coordinates."""

    def limit(*given: Scalar) -> tuple[Scalar]:
        return (path_timing.speed_limit(*given),)

    inputs = [Argument(name, (n,)) for name in ("first", "velocity")]
    return compile_program(trace("path_speed_limit", limit, inputs, [Argument("most", ())]))


def timed_pieces(derivatives: Sequence[Array], x: Array, h: Array) -> tuple[list[Array], Array]:
    """The polynomials in time and durations (N, P) of the motion in each interval, where s̈ is
    constant.

    derivatives: of the paths by s, (N, P, n) each, at the intervals' starts, all that are not 0. x:
    (N + 1, P). h: (N, P) twice the intervals' lengths. Polynomials: (degree + 1, N, n) of each
    path, highest power first.
    """
    n, degree = derivatives[0].shape[-1], len(derivatives) - 1
    speed = np.sqrt(x)
    half = (x[1:] - x[:-1]) / (2.0 * h)
    kernel = _timing(n, degree)
    found = [result_memory.empty((2 * degree + 1, len(h), n)) for _ in range(x.shape[1])]
    for k, own in enumerate(found):
        given = (*derivatives, speed[:-1], half)
        kernel(*(column[:, k] for column in given), out=tuple(own[::-1]))
    return found, h / (speed[:-1] + speed[1:])


@lru_cache(maxsize=8)
def _timing(n: int, degree: int) -> Kernel:
    """The kernel of `path_timing.timed` for n coordinates."""

    def timed(*given: Scalar) -> tuple[Scalar, ...]:
        return tuple(path_timing.timed(given[:-2], *given[-2:]))

    derivatives = [Argument(f"d{k}", (n,)) for k in range(degree + 1)]
    powers = [Argument(f"c{k}", (n,)) for k in range(2 * degree + 1)]
    inputs = [*derivatives, Argument("speed", ()), Argument("half", ())]
    return compile_program(trace("path_timed", timed, inputs, powers))


class _Kernels(NamedTuple):
    polygon: Kernel
    backward: Kernel
    forward: Kernel


@lru_cache(maxsize=8)
def _kernels(m: int) -> _Kernels:
    """The kernels for m rows at each end of an interval."""

    def polygon(*given: Scalar) -> tuple[Scalar, ...]:
        start, end = path_timing.RowsAtEnd(*given[:4]), path_timing.RowsAtEnd(*given[4:8])
        return path_timing.polygon(start, end, *given[8:])

    def backward(after: Scalar, over: Scalar, corners: Scalar) -> tuple[Scalar]:
        return (path_timing.backward(after, path_timing.LimitLines(*over), corners),)

    def forward(x: Scalar, over: Scalar, most: Scalar) -> tuple[tuple[Scalar]]:
        high, slope = over
        return ((path_timing.forward(x[0], high, slope, most),),)

    over_y, over_x = (Argument(f"over_{x}", (k, 2 * m + 1)) for x, k in (("y", 3), ("x", 2)))
    corners = Argument("corners", (4,))
    ends = [Argument(name, ()) for name in ("most_next", "h", "least", "most")]

    def compiled(
        name: str,
        function: Callable[..., tuple[Scalar, ...]],
        inputs: list[Argument],
        outputs: list[Argument],
    ) -> Kernel:
        return compile_program(trace(name, function, inputs, outputs))

    return _Kernels(
        compiled(
            "path_polygon",
            polygon,
            [*row_arguments(m), *ends],
            [over_y, over_x, corners, Argument("goes_on", ())],
        ),
        compiled(
            "path_backward",
            backward,
            [Argument("after", (2,)), over_y, corners],
            [Argument("reachable", (2,))],
        ),
        compiled(
            "path_forward",
            forward,
            [Argument("x", (1,)), over_x, Argument("most", ())],
            [Argument("y", (1,))],
        ),
    )
