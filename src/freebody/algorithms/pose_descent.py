"""A step of Levenberg and Marquardt that brings a frame nearer to a pose, over scalars (Levenberg
1944; Marquardt 1963)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from freebody.algorithms.loop_constraints import solved
from freebody.elementary import Scalar, absolute, less, maximum, minimum, sqrt, where
from freebody.model.tree import Pose
from freebody.spatial import Matrix, Vector, dot, product, scale, sub, transposed

LEAST_DAMPING = 1e-14
_HALF_TURN = 1e-12
"""The least of 1 + cos of an angle by which is divided."""


def missing(at: Pose, target: Pose, rows: Sequence[int], scales: Vector) -> tuple[Vector, Scalar]:
    """The difference (rows,) between a pose and its target, of the counted rows, linear ones first,
    world axes: the way, and of the turn by θ the vector 2 sin(θ/2) along its axis, which is longest
    at a half turn; and the square of its length.

    scales: by which linear and angular rows are multiplied.
    """
    (R, p), (goal, to) = at, target
    d = len(p)
    turned = product(goal, transposed(R))
    if d == 3:
        axis = tuple(0.5 * (turned[b][a] - turned[a][b]) for a, b in ((1, 2), (2, 0), (0, 1)))
        cosine = 0.5 * (turned[0][0] + turned[1][1] + turned[2][2] - 1.0)
    else:
        axis, cosine = (turned[1][0],), turned[0][0]
    angular = scale(sqrt(2.0 / maximum(1.0 + cosine, _HALF_TURN)), axis)
    every = (*scale(scales[0], sub(to, p)), *scale(scales[1], angular))
    linear = tuple(every[r] for r in rows if r < d)
    turn = tuple(every[r] for r in rows if r >= d)
    square = _square(turn)
    if len(turn) == len(axis):  # at a half turn the axis is lost, but not the angle
        whole = scales[1] * scales[1] * (2.0 * (1.0 - cosine))
        square = where(less(cosine, 0.0), whole, square)
    return (*linear, *turn), _square(linear) + square


def _square(v: Vector) -> Scalar:
    return dot(v, v) if v else 0.0


def step_towards(
    pose: Callable[[Vector], Pose],
    jacobian: Callable[[Vector], Matrix],
    rows: Sequence[int],
    columns: Sequence[int],
    q: Vector,
    damping: Scalar,
    target: Pose,
    scales: Vector,
    limits: tuple[Vector, Vector],
) -> tuple[Vector, Scalar, Scalar, Scalar]:
    """(q, damping, remaining error, longest entry of the step) after one damped least-squares step
    towards a target pose; the step is taken only if it leads nearer.

    columns: of the coordinates that move, whose rates are their derivatives. limits: lower and
    upper, to which q is brought.
    """
    d = len(target[1])
    error, before = missing(pose(q), target, rows, scales)
    J = jacobian(q)
    E = tuple(tuple(scales[0 if r < d else 1] * J[r][k] for k in columns) for r in rows)
    way = _damped(E, error, damping)
    trial = list(q)
    for k, x in zip(columns, way, strict=True):
        trial[k] = minimum(maximum(q[k] + x, limits[0][k]), limits[1][k])
    _, after = missing(pose(tuple(trial)), target, rows, scales)
    better = less(after, before)
    longest: Scalar = 0.0
    for x in way:
        longest = maximum(longest, absolute(x))
    return (
        tuple(where(better, a, b) for a, b in zip(trial, q, strict=True)),
        where(better, maximum(0.2 * damping, LEAST_DAMPING), 4.0 * damping),
        sqrt(where(better, after, before)),
        longest,
    )


def _damped(E: Matrix, error: Vector, damping: Scalar) -> Vector:
    """x = (Eᵀ E + λ)⁻¹ Eᵀ e = Eᵀ (E Eᵀ + λ)⁻¹ e, by the smaller of the two matrices."""
    by_columns = transposed(E, len(E[0]))
    wide = len(E) < len(by_columns)
    factors = E if wide else by_columns
    S = [[dot(a, b) for b in factors] for a in factors]
    for k, row in enumerate(S):
        row[k] = row[k] + damping
    right = error if wide else tuple(dot(column, error) for column in by_columns)
    x, _ = solved(S, right)
    return tuple(dot(column, x) for column in by_columns) if wide else x
