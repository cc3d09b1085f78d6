"""The quickest speeds along paths: limits as rows over a grid, and the passes that find the speeds.

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
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program
from freebody.targets.recurrence import recurrence

_SEARCHES = 40  # calls of `path_timing.ROUNDS` steps each: far more than there are lines
_CLOSE = 1e-9  # of the largest x: steps, and gaps between what is wanted and allowed, of no account


class PathRows(NamedTuple):
    """Limits over a grid of N intervals and P paths.

    h: (N, P) twice the intervals' lengths. most: (N + 1, P) largest x; most_between: (N, P) halfway
    in the intervals. a, b: (N + 1, P, m). lo, hi:
    (2, N, P, m) at the intervals' starts and ends.
    """

    h: Array
    most: Array
    most_between: Array
    a: Array
    b: Array
    lo: tuple[Array, Array]
    hi: tuple[Array, Array]


class SpeedProfile(NamedTuple):
    """x: (N + 1, P), NaN in a path without solution. reachable: (N + 1, P, 2) between which x may
    be with the end still to be reached at rest; NaN where it cannot be. lowest, highest: (N, P) x
    at the intervals' starts that the limits of the interval alone allow."""

    x: Array
    reachable: Array
    lowest: Array
    highest: Array


def quickest_profile(rows: PathRows) -> SpeedProfile:
    """The largest speeds from rest to rest."""
    kernels = _kernels(rows.a.shape[-1])
    count, paths = rows.h.shape
    *lines, corners = _polygons(kernels.polygon, rows)
    over_y, over_x = lines[:3], lines[3:]
    rest = np.zeros((paths, 2))
    tolerance = _CLOSE * rows.most[:-1]
    back = [x[::-1] for x in (*over_y, corners, tolerance)]
    reachable = recurrence(kernels.backward, rest, *back)[::-1]
    x = recurrence(kernels.forward, rest, *over_x, reachable[1:])[..., 0]
    starts = reachable[0, :, 0] <= tolerance[0] if count else np.ones(paths, dtype=bool)
    x = np.where(starts, x, np.nan)
    return SpeedProfile(x, reachable, corners[..., 3], corners[..., 0])


def _polygons(kernel: Kernel, rows: PathRows) -> tuple[Array, ...]:
    """What `path_timing.polygon` finds in each interval; where its search has not ended, it goes on
    from there."""
    given = (
        rows.a[:-1], rows.b[:-1], rows.lo[0], rows.hi[0],
        rows.a[1:], rows.b[1:], rows.lo[1], rows.hi[1],
    )  # fmt: skip
    ends = np.empty((*rows.h.shape, 5))
    for k, x in enumerate((0.0, rows.most[:-1], rows.most_between, rows.most[1:], rows.h)):
        ends[..., k] = x
    flat = (x.reshape(rows.h.size, x.shape[-1]) for x in (*given, ends))  # one axis is quickest
    *lines, corners = (x.reshape(*rows.h.shape, x.shape[-1]) for x in kernel(*flat))
    for _ in range(_SEARCHES):
        steps = np.abs(corners[..., 2::3]).max(axis=-1)
        open_ = (steps > _CLOSE * np.abs(corners[..., 0])) & (steps < path_timing.FAR)
        if not open_.any():
            break
        again = ends[open_]
        again[:, 0], again[:, 1] = corners[open_][:, 3], corners[open_][:, 0]
        corners[open_] = kernel(*(x[open_] for x in given), again)[-1]
    return (*lines, corners)


def timed_pieces(derivatives: Sequence[Array], x: Array, h: Array) -> tuple[Array, Array]:
    """(polynomials of time, durations (N, P)) of the motion in each interval, where s̈ is constant.

    derivatives: of the paths by s, (N, P, n) each, at the intervals' starts, all that are not 0. x:
    (N + 1, P). h: (N, P) twice the intervals' lengths. Polynomials: (P, degree + 1, N, n), highest
    power first.
    """
    n, degree = derivatives[0].shape[-1], len(derivatives) - 1
    speed = np.sqrt(x)
    found = np.empty((x.shape[1], 2 * degree + 1, len(h), n))
    half = (x[1:] - x[:-1]) / (2.0 * h)
    outs = tuple(np.moveaxis(found, 0, 2)[::-1])
    _timing(n, degree)(*derivatives, speed[:-1], half, out=outs)
    return found, h / (speed[:-1] + speed[1:])


@lru_cache(maxsize=8)
def _timing(n: int, degree: int) -> Kernel:
    """`path_timing.timed` of n coordinates."""

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
    """Of m rows at each end of an interval."""

    def vectors(size: int, *names: str) -> list[Argument]:
        return [Argument(name, (size,)) for name in names]

    def polygon(*given: Scalar) -> tuple[Scalar, ...]:
        start, end = path_timing.RowsAtEnd(*given[:4]), path_timing.RowsAtEnd(*given[4:8])
        return path_timing.polygon(start, end, *given[8])

    def backward(state: Scalar, *given: Scalar) -> tuple[Scalar]:
        return (path_timing.backward(state, path_timing.LimitLines(*given[:3]), *given[3:]),)

    def forward(state: Scalar, *given: Scalar) -> tuple[Scalar]:
        return (path_timing.forward(state, path_timing.LimitLines(*given[:3]), *given[3:]),)

    lines = vectors(2 * m + 1, "low", "high", "slope")
    over = [Argument(f"{x.name}_{of}", x.shape) for of in ("x", "y") for x in lines]
    state, corners = Argument("state", (2,)), Argument("corners", (6,))
    rows = vectors(m, "a", "b", "lo", "hi", "a_end", "b_end", "lo_end", "hi_end")

    def compiled(
        name: str,
        function: Callable[..., tuple[Scalar, ...]],
        inputs: list[Argument],
        outputs: list[Argument],
    ) -> Kernel:
        return compile_program(trace(name, function, inputs, outputs))

    return _Kernels(
        compiled("path_polygon", polygon, [*rows, Argument("ends", (5,))], [*over, corners]),
        compiled(
            "path_backward",
            backward,
            [state, *lines, corners, Argument("tolerance", ())],
            [Argument("reachable", (2,))],
        ),
        compiled(
            "path_forward",
            forward,
            [state, *lines, Argument("reachable", (2,))],
            [Argument("x", (2,))],
        ),
    )
