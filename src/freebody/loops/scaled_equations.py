"""All loop equations of a model as arrays, scaled so that lengths and angles compare; their
tolerances, and closing the loops by Levenberg-Marquardt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.kinematics import ancestors, frame_pose, joint_poses, world_poses
from freebody.algorithms.loop_scales import (
    equations_of_lengths,
    mechanism_length,
    rates_of_lengths,
    repeating,
)
from freebody.arrays import Array
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.model.bodies import Body
from freebody.model.contributions import pose_part
from freebody.model.geometry import first_member, geometric_fact
from freebody.model.model import Model
from freebody.model.parameters import Quantity
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached, Mass, Pieces, Pose, Tree, tree_of
from freebody.spatial import Vector, dot, of_dimension, times
from freebody.trees.states import difference, integrate

RANK = 1e-9
"""Singular values of Φ_q, relative to the largest, that count as zero."""
BLURRED = 1e-5
"""Singular values that count as zero for accelerations, in which rounding is divided by the square
of a singular value."""
AT_REST = 1e-6
"""Singular values that count as zero for accelerations of a mechanism at rest, where rounding in
the computation may change them by 1e-4."""
_NOTHING = 1e-13  # an equation that holds wherever the mechanism goes
_OF_LENGTH = 1e-3
"""How far rounding may open a loop, relative to its size: files print three digits at least."""
_MOST_OPEN = (1e-3, 1e-3)
"""(m, rad): files print metres to four digits and angles to three, and a loop adds up a few of
them."""
_WAYS = (0.05, 0.13, 0.31)  # rad: how far a neighbourhood is explored
_MOST_WAYS = 48  # directions, among many at random
_LONGEST_STEP = 0.6  # rad: the longest step towards closure
_ITERATIONS = 60


@geometric_fact
def mechanism(model: Model) -> Tree:
    """The tree of a geometry, without inertias, drives and gravity; names in it may be those of
    another model."""
    return tree_of(model, _Places(of_dimension(model.dim), VALUES))


class _Places(Pieces):
    """A reader of places alone, which makes a tree without masses, drives and gravity."""

    def pose(self, placement: Placement) -> Pose:
        return pose_part(placement, self.space.dim).pose

    def masses(self, parts: tuple[Attached, ...]) -> tuple[Mass, ...]:
        return ()

    def laws(self, body: Body) -> tuple[()]:
        return ()

    def gravity(self, size: Quantity, direction: tuple[Any, ...]) -> Vector:
        return self.space.zero


def row_names(model: Model) -> tuple[str, ...]:
    """A name for each loop equation: the loop's, and the component of its reaction."""
    tree = mechanism(model)
    return tuple(
        f"{loop.name}.{part}"
        for loop, lowered in zip(model.loops, tree.loops, strict=True)
        for part in lowered.closure.row_names(tree.space)
    )


def loop_of_row(model: Model) -> tuple[int, ...]:
    """Index of the loop of each equation."""
    tree = mechanism(model)
    return tuple(
        i for i, loop in enumerate(tree.loops) for _ in range(loop.closure.size(tree.space))
    )


@dataclass(frozen=True)
class Scales:
    """Factors that make lengths and angles compare: equations and rates become angles when
    multiplied by `rows`, divided by `rates`."""

    length: float
    """The mechanism's length (m): the farthest that a joint or frame is placed from the one
    before."""
    rows: Array
    """(m,): 1 / length for equations in metres, 1 for sines of angles."""
    metres: NDArray[np.bool_]
    """Flags (m,) of the equations of lengths."""
    rates: Array
    """Scales (nv,) of rates: the length for rates in m/s, 1 for angular ones."""
    turns: NDArray[np.bool_]
    """(nv,): whether a whole turn of the coordinate changes nothing."""
    tolerance: Array
    """(m,): of the scaled equations: what counts as rounding of the model's numbers
    (`loop_tolerance`)."""


@geometric_fact
def scales(model: Model) -> Scales:
    """The scales of a geometry, found once."""
    tree = mechanism(model)
    reach = float(mechanism_length(tree))
    tolerance: list[float] = []
    for i, loop in enumerate(tree.loops):
        turns = len(loop.closure.turns)
        lengths = loop.closure.size(tree.space) - turns
        apart, turned = _tolerance(model, tree, i)
        tolerance += [apart / reach] * lengths + [turned] * turns
    along = np.array(rates_of_lengths(tree), dtype=bool)
    whole = np.array(repeating(tree), dtype=bool)
    lengths, rates = np.array(equations_of_lengths(tree), dtype=bool), np.where(along, reach, 1.0)
    return Scales(
        reach, np.where(lengths, 1.0 / reach, 1.0), lengths, rates, whole, np.array(tolerance)
    )


def _tolerance(model: Model, tree: Tree, index: int) -> tuple[float, float]:
    """The tolerance (m, rad) of a loop: the model's `loop_tolerance`, or a default for the loop's
    size in `tree`."""
    if model.loop_tolerance is not None:
        return model.loop_tolerance
    loop = tree.loops[index]
    first, second = (ancestors(tree, tree.frames[frame][0]) for frame in loop.frames)
    offsets = [tree.bodies[i].p for i in set(first) ^ set(second)]
    offsets += [tree.frames[frame][2] for frame in loop.frames] + [(loop.distance,)]
    size = max(float(np.linalg.norm(np.asarray(p, dtype=float))) for p in offsets)
    metres, radians = _MOST_OPEN
    return min(metres, _OF_LENGTH * size), radians


def length(model: Model) -> float:
    """Length of the mechanism (m), see `Scales`."""
    return scales(model).length


def row_scale(model: Model) -> Array:
    """Factors (m,) that turn the residuals of loop equations into angles."""
    return scales(model).rows


def rate_scale(model: Model) -> Array:
    """Divisors (nv,) that turn rates into angular ones: the mechanism's length for rates in m/s, 1
    for angular ones."""
    return scales(model).rates


def shortest_way(model: Model, a: Array, b: Array) -> Array:
    """The shortest difference from positions a to b (..., nq) as angles (..., nv), whole turns left
    out."""
    way = difference(model, a, b) / rate_scale(model)
    return np.where(scales(model).turns, (way + np.pi) % (2.0 * np.pi) - np.pi, way)


def every_residual(model: Model, q: Array) -> Array:
    """Residuals of all loop equations, Φ(q) (..., m), in angles."""
    return row_scale(model) * fetch(first_member(model), ("constraint",), Option())(q)


def every_jacobian(model: Model, q: Array) -> Array:
    """The Jacobian Φ_q (..., m, nv) as angles over angular rates; rows of mere rounding are
    zero."""
    phi = fetch(first_member(model), ("constraint_jacobian",), Option())(q)
    A = row_scale(model)[:, None] * phi * rate_scale(model)
    A[np.abs(A).max(axis=-1, initial=0.0) < _NOTHING] = 0.0
    return A


def backward(model: Model, q: Array) -> NDArray[np.bool_]:
    """Flags (..., loops) of loops that are closed the wrong way round: turned by a half, or where
    three axes are held by a third, which their equations do not notice."""
    tree = mechanism(model)
    space = tree.space
    if not any(loop.closure.facing for loop in tree.loops):
        return np.zeros((*q.shape[:-1], len(tree.loops)), dtype=bool)
    world = world_poses(tree, joint_poses(tree, tuple(np.moveaxis(q, -1, 0))))
    found = np.zeros((*q.shape[:-1], len(tree.loops)), dtype=bool)
    for i, loop in enumerate(tree.loops):
        (A, _), (B, _) = (frame_pose(tree, world, frame) for frame in loop.frames)
        for n, u in loop.closure.facing:
            expected = space.turn(A, space.moment(u, n))
            found[..., i] |= np.asarray(dot(expected, space.moment(times(B, u), times(A, n)))) < 0.5
    return found


def null_space(A: Array, tolerance: float) -> tuple[Array, Array]:
    """Orthonormal bases of the null spaces of A (m, n) and of Aᵀ, (n, k) and (m, l); singular
    values below tolerance times the largest count as zero."""
    if A.shape[0] == 0:
        return np.eye(A.shape[1]), np.zeros((0, 0))
    U, s, Vt = np.linalg.svd(A)
    rank = int((s > tolerance * max(s.max(initial=0.0), 1e-300)).sum())
    return Vt[rank:].T, U[:, rank:]


Kept = Callable[[Array], NDArray[np.bool_]]
"""Singular values (..., k) of Φ_q, the largest first -> which of them count."""


def telling(A: Array, kept: Kept) -> Array:
    """The projector P (..., m, m) onto the combinations of equations that belong to the kept
    singular values of Φ_q = A (..., m, nv)."""
    U, s, _ = np.linalg.svd(A, full_matrices=False)
    return (U * kept(s)[..., None, :]) @ np.swapaxes(U, -1, -2)


def largest(rank: Array | int) -> Kept:
    """The rule that keeps the `rank` (...) largest singular values."""
    return lambda s: np.arange(s.shape[-1]) < np.asarray(rank)[..., None]


Telling = Callable[[Array], Array]
"""Φ_q (N, m, nv) -> P (N, m, m): the combinations of the equations that count, see
`scaled_equations.telling`."""
Closing = Callable[[Array], tuple[Array, NDArray[np.bool_]]]
"""q (N, nq) -> (positions near q (N, nq), whether they are closed (N,))."""


def closed_from(
    model: Model, q: Array, moving: Sequence[int], projector: Telling | None
) -> tuple[Array, Array]:
    """(positions (N, nq) closed as far as possible from q (N, nq), largest remaining scaled
    equation (N,))."""

    def at(q: Array) -> tuple[Array, Array]:
        phi, J = every_residual(model, q), every_jacobian(model, q)
        if projector is not None:
            P = projector(J)
            phi, J = np.einsum("nij,nj->ni", P, phi), P @ J
        return phi, J[..., list(moving)]

    stretch = rate_scale(model)
    q = np.array(q)
    phi, J = at(q)
    damping = np.full(len(q), 1e-2)
    for _ in range(_ITERATIONS):
        size = np.abs(phi).max(axis=-1, initial=0.0)
        active = np.flatnonzero((size > 1e-15) & (damping < 1e6))
        if not len(active):
            break
        step = _levenberg(
            J[active], phi[active], damping[active] * np.linalg.norm(phi[active], axis=-1)
        )
        full = np.zeros((len(active), model.nv))
        full[:, list(moving)] = step
        trial = integrate(model, q[active], full * stretch)
        left, slope = at(trial)
        better = np.linalg.norm(left, axis=-1) < np.linalg.norm(phi[active], axis=-1)
        at_better = active[better]
        q[at_better], phi[at_better], J[at_better] = trial[better], left[better], slope[better]
        damping[active] = np.where(
            better, np.maximum(damping[active] * 0.1, 1e-12), damping[active] * 10.0
        )
    return q, np.abs(phi).max(axis=-1, initial=0.0)


def _levenberg(J: Array, phi: Array, damping: Array) -> Array:
    """The step -Jᵀ (J Jᵀ + μ)⁻¹ φ (N, k), no longer than a sensible turn."""
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    floor = 1e-10 * s.max(axis=-1, keepdims=True, initial=1e-300)
    gain = np.where(s > floor, s / (s * s + damping[:, None]), 0.0)
    step = -np.einsum("nkj,nk->nj", Vt, gain * np.einsum("nmk,nm->nk", U, phi))
    longest = np.abs(step).max(axis=-1, initial=0.0)
    return step * np.minimum(1.0, _LONGEST_STEP / np.maximum(longest, 1e-300))[:, None]


def explored(model: Model, q: Array, directions: Array, close: Closing) -> Array:
    """Closed positions (k, nq) reached from q (nq,) by finite motions: steps along directions (n,
    nv), scaled, and along mixtures of them, that closing does not undo."""
    n = len(directions)
    if not n:
        return np.empty((0, model.nq))
    ways = np.concatenate([np.eye(n), np.random.default_rng(2).normal(size=(4 * n, n))])[
        :_MOST_WAYS
    ]
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    ways = np.concatenate([size * sign * ways for size in _WAYS for sign in (1.0, -1.0)])
    start = np.broadcast_to(q, (len(ways), model.nq))
    found, good = close(integrate(model, start, ways @ directions * rate_scale(model)))
    moved = np.linalg.norm(difference(model, start, found) / rate_scale(model), axis=-1)
    return found[good & (moved > 0.3 * np.linalg.norm(ways, axis=-1))]
