"""Redundant loop equations: those that are redundant for the mechanism that a model's rounded
numbers stand for.

Exactness comes first: numbers whose loops close to the last digit, at a position where no singular
value of Φ_q is small without being zero, are taken as they stand, and so are those that move to
such a position with all loops closed.

A real machine often has more equations than its motion needs, and numbers with a few digits, by
which they contradict each other a little. What tells such a machine from one that is stuck is that
it moves: along a way of half a radian and more every loop stays closed within `loop_tolerance`.
There the singular values of Φ_q that rounding makes out of zeros show, and how many are left is the
rank of the mechanism. It is found at regular positions on that way, near the model's home.

Where that is so, the combinations of equations that tell most count, as many as the rank: P = U_r
U_rᵀ of the singular value decomposition of Φ_q. No fixed choice of equations would do: in a
parallelogram with a third crank either equation of the third is singular twice a turn, P is only
where the mechanism is. What P leaves out stays open by the misfit, which must not exceed the
tolerance. The rank is that of a branch of the motion, and what was found near home does not bind
another: where more singular values stand clear of rounding, more combinations count
(`counting_values`), and where what is known does not hold at all, the position asked about is taken
for the home (`equations.branches`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.scaled_equations import (
    Closing,
    Kept,
    backward,
    closed_from,
    every_jacobian,
    every_residual,
    explored,
    largest,
    length,
    mechanism,
    rate_scale,
    scales,
    shortest_way,
    telling,
)
from freebody.model.geometry import geometric_fact
from freebody.model.model import Model
from freebody.trees.states import generic_state, home_guess, integrate

EXACT = 1e-12
"""Scaled equations that are open by less are closed but for rounding in the computation."""
_ZERO = 1e-9  # singular values, relative to the largest, that rounding in the computation makes
_TOLERANCES = 8.0  # a singular value below so many moves an eighth of a radian within one
_NEAR = 0.3  # rad: how far an exact position may be from one within the tolerance
_STRIDE, _WAY = 0.1, 0.5  # rad: of the way that shows a motion, each step and the least of all
_FOLLOWED = 4  # directions in which an exact motion is followed
_STARTS = 16
_AS_GOOD = 0.2  # of what the best row tells: a row before it is taken
# misfits: what is left out turns with the motion, the faster the nearer a singular position
_SLACK = 30.0


@dataclass(frozen=True, eq=False)
class Redundancy:
    """The number of independent combinations of the loop equations, and what is left of the
    redundant ones by rounding."""

    rank: int | None
    """The number of combinations that count; None where all equations hold together, to rounding in
    the computation."""
    rows: tuple[int, ...] = ()
    """Where rank is not None, equations, as many, that tell everything near the positions that were
    looked at."""
    misfit: tuple[float, float] = (0.0, 0.0)
    """(m, rad): by how much the others were open there, at most."""
    blur: float = 0.0
    """The misfit as an angle: what scaled equations are uncertain by."""
    threshold: float = 0.0
    """Singular values that rounding of the model's numbers may have made out of zeros are below."""

    @property
    def slack(self) -> float:
        """The relative amount that rounding of the model's numbers may add to a gap, its rate or a
        balance."""
        return _SLACK * self.blur


_NONE = Redundancy(None)


@geometric_fact
def redundancy(model: Model) -> Redundancy:
    """The redundancy of a geometry's loop equations near its home; found once."""
    threshold = rounding_threshold(model)
    if not threshold:
        return _NONE
    search = _Search(model, threshold)
    at = search.start()
    if at is None or search.is_exact(at):
        return _NONE
    reached = search.neighbours(at)  # from a singular position to regular ones
    if not len(reached):
        return _NONE
    at = max(reached, key=search.regularity)
    _, s, Vt = np.linalg.svd(every_jacobian(model, at))
    rank = int((s > threshold).sum())
    # singular values between rounding in the computation and rounding in the file: do they let it
    # move?
    ways = [search.way(at, Vt[k], rank) for k in np.flatnonzero(_doubtful(s, threshold))]
    seen = np.concatenate([at[None], *(way for way in ways if way is not None)])
    rank += sum(way is None for way in ways)
    return _NONE if rank == mechanism(model).constraints else _weighed(model, seen, rank, threshold)


def rounding_threshold(model: Model) -> float:
    """The limit below which a singular value of the scaled Φ_q may be a zero changed by rounding of
    the model's numbers; 0 where these are taken as exact."""
    return _TOLERANCES * float(scales(model).tolerance.max(initial=0.0))


def _doubtful(s: Array, threshold: float) -> NDArray[np.bool_]:
    """Flags of singular values s (..., k) that are neither zero nor above the limit of rounding."""
    return (s > _ZERO * s.max(axis=-1, keepdims=True, initial=1e-300)) & (s <= threshold)


def surely_exact(model: Model, q: Array) -> NDArray[np.bool_]:
    """Flags (...) of the positions q (..., nq) where all equations are independent beyond rounding
    of the model's numbers, or where all hold to the last digit and no singular value is small
    without being zero."""
    s = np.asarray(np.linalg.svd(every_jacobian(model, q), compute_uv=False), dtype=np.float64)
    threshold, every = rounding_threshold(model), mechanism(model).constraints
    closed = (np.abs(every_residual(model, q)) <= EXACT).all(axis=-1)
    return ((s > threshold).sum(axis=-1) == every) | (
        closed & ~_doubtful(s, threshold).any(axis=-1)
    )


def moves_exactly(model: Model, q: Array) -> bool:
    """Whether all loops close to the last digit near the position q (nq,), and no singular value is
    in doubt: at q itself, or at positions that a closed motion leads to."""
    search = _Search(model, rounding_threshold(model))
    return search.is_exact(search.exactly(q))


def counting_values(known: Redundancy) -> Kept:
    """The rule that keeps as many singular values of Φ_q as the known rank, and further ones that
    exceed rounding.

    Where a position is found by combinations whose least singular value is s_r, it is uncertain by
    the tolerance over s_r, and further singular values by as much.
    """
    rank = known.rank or 0

    def kept(s: Array) -> NDArray[np.bool_]:
        before = np.concatenate([s[..., :1], s[..., :-1]], axis=-1)
        clear = s > known.threshold * np.maximum(1.0, s[..., :1] / np.maximum(before, 1e-300))
        return np.logical_and.accumulate(clear | (np.arange(s.shape[-1]) < rank), axis=-1)

    return kept


def _weighed(model: Model, seen: Array, rank: int, threshold: float) -> Redundancy:
    """The redundancy of the loop equations that positions (k, nq) along the mechanism's motions
    show."""
    seen, _ = closed_from(model, seen, range(model.nv), lambda A: telling(A, largest(rank)))
    phi, A = every_residual(model, seen), every_jacobian(model, seen)
    s = np.linalg.svd(A, compute_uv=False)
    if np.abs(phi).max(initial=0.0) < EXACT and (s[:, rank:] <= _ZERO * s[:, :1]).all():
        return _NONE
    metres = scales(model).metres
    most = np.abs(phi).max(axis=0)
    most[most < EXACT] = 0.0
    misfit = (
        float(length(model) * most[metres].max(initial=0.0)),
        float(most[~metres].max(initial=0.0)),
    )
    return Redundancy(rank, _telling_rows(A, rank), misfit, float(most.max()), threshold)


@dataclass(frozen=True, eq=False)
class _Search:
    """The search for positions at which all loops are closed within the tolerance; singular values
    below `threshold` may be rounding."""

    model: Model
    threshold: float

    def start(self) -> Array | None:
        """The closed position nearest to home among those found from fixed starts; None where none
        is found."""
        model = self.model
        guess = home_guess(model)
        rng = np.random.default_rng(4)
        spread = (
            rng.uniform(-np.pi, np.pi, (_STARTS, model.nv))
            * np.geomspace(0.02, 1.0, _STARTS)[:, None]
        )
        away = integrate(
            model, np.broadcast_to(guess, (_STARTS, model.nq)), spread * rate_scale(model)
        )
        for begun in (guess[None], away, generic_state(model, seed=4, batch=_STARTS)[0]):
            q, good = self.closed(begun)
            if good.any():
                way = shortest_way(model, np.broadcast_to(guess, q[good].shape), q[good])
                return self.exactly(q[good][int(np.argmin(np.linalg.norm(way, axis=-1)))])
        return None

    def exactly(self, q: Array) -> Array:
        """The position (nq,) near q at which every loop is closed to the last digit; q itself where
        there is none near."""
        model = self.model
        found, good = self.closed_exactly(q[None])
        away = np.abs(shortest_way(model, q, found[0])).max(initial=0.0)
        return found[0] if good[0] and away < _NEAR else q

    def is_exact(self, q: Array) -> bool:
        """Whether all loops close to the last digit at q, or at positions that a motion leads to
        (`moves_exactly`)."""
        model = self.model
        if np.abs(every_residual(model, q)).max(initial=0.0) > EXACT:
            return False
        if surely_exact(model, q):
            return True
        _, s, Vt = np.linalg.svd(every_jacobian(model, q))
        rank = int((s > _ZERO * s[0]).sum())
        return any(
            bool(surely_exact(model, p))
            for direction in Vt[rank:][:_FOLLOWED]
            for sense in (1.0, -1.0)
            for p in self.followed(q, sense * direction, rank, self.closed_exactly)
        )

    def closed(self, q: Array, rank: int | None = None) -> tuple[Array, NDArray[np.bool_]]:
        """(positions (N, nq) near q at which the independent equations hold, flags (N,) of those
        where the redundant ones hold within the tolerance)."""
        model = self.model
        kept = largest(rank) if rank is not None else lambda s: s > self.threshold
        q, left = closed_from(model, q, range(model.nv), lambda A: telling(A, kept))
        within = (np.abs(every_residual(model, q)) <= scales(model).tolerance).all(axis=-1)
        return q, within & (left < EXACT) & ~backward(model, q).any(axis=-1)

    def closed_exactly(self, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Positions near q at which every equation holds, and flags (N,) of those where it does so
        to the last digit."""
        q, left = closed_from(self.model, q, range(self.model.nv), None)
        return q, (left < EXACT) & ~backward(self.model, q).any(axis=-1)

    def neighbours(self, q: Array) -> Array:
        """Positions (k, nq) reached from q (nq,) by motions within the tolerance."""
        _, s, Vt = np.linalg.svd(every_jacobian(self.model, q))
        return explored(self.model, q, Vt[int((s > self.threshold).sum()) :], self.closed)

    def regularity(self, q: Array) -> tuple[int, float]:
        """(the number of independent combinations of equations at q (nq,), the smallest of their
        singular values)."""
        s = np.linalg.svd(every_jacobian(self.model, q), compute_uv=False)
        clear = s[s > self.threshold]
        return len(clear), float(clear.min(initial=1.0))

    def way(self, start: Array, direction: Array, rank: int) -> Array | None:
        """Positions (k, nq) on the motion that starts in a direction (nv,), with `rank`
        combinations of equations satisfied; None where it exceeds the tolerance at once."""
        found = [
            q
            for sense in (1.0, -1.0)
            for q in self.followed(start, sense * direction, rank, lambda q: self.closed(q, rank))
        ]
        return np.array(found) if len(found) * _STRIDE >= _WAY else None

    def followed(self, q: Array, along: Array, rank: int, close: Closing) -> Iterator[Array]:
        """Positions (nq,) on the motion from q (nq,) that starts in a direction (nv,), with `rank`
        combinations of equations satisfied; it ends where closing fails."""
        model = self.model
        for _ in range(round(2.0 * _WAY / _STRIDE)):
            null = np.linalg.svd(every_jacobian(model, q))[2][rank:]
            along = null.T @ (null @ along)
            along = along / max(float(np.abs(along).max()), 1e-300)
            found, good = close(integrate(model, q, _STRIDE * along * rate_scale(model))[None])
            if not good[0]:
                return
            q = found[0]
            yield q


def _telling_rows(A: Array, rank: int) -> tuple[int, ...]:
    """The indices of `rank` rows of Φ_q = A (k, m, nv) that at each of the k positions determine as
    nearly as possible as much as all rows; the first of equally good ones."""
    left = np.linalg.svd(A, full_matrices=False)[0][..., :rank]  # (k, m, r)
    chosen: list[int] = []
    for _ in range(rank):
        sizes = np.linalg.norm(left, axis=-1).min(axis=0)
        sizes[chosen] = 0.0
        k = int(np.argmax(sizes > _AS_GOOD * sizes.max()))
        chosen.append(k)
        unit = left[:, k] / np.linalg.norm(left[:, k], axis=-1, keepdims=True)
        left = left - np.einsum("kmr,kr->km", left, unit)[..., None] * unit[:, None]
    return tuple(sorted(chosen))
