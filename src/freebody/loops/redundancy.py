"""Which loop equations are redundant for the mechanism that a model's rounded numbers mean.

A real machine often has more equations than its motion needs, and numbers with a few digits, by
which they contradict each other a little. What tells such a machine from one that is stuck is that
it moves: along a way of half a radian and more every loop stays closed within `loop_tolerance`.
There the singular values of Φ_q that rounding makes out of zeros show, and how many are left is the
rank of the mechanism. It is found at regular positions on that way, from fixed starts, so it
depends on the geometry alone, never on a position that is asked about.

Where that is so, the combinations of equations that tell most count, as many as the rank: P = U_r
U_rᵀ of the singular value decomposition of Φ_q. No fixed choice of equations would do: in a
parallelogram with a third crank either equation of the third is singular twice a turn, P is only
where the mechanism is. What P leaves out stays open by the misfit, which must not exceed the
tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.closing_solver import closed_from
from freebody.loops.scaled_equations import (
    backward,
    every_jacobian,
    every_residual,
    length,
    mechanism,
    rate_scale,
    scales,
    shortest_way,
    telling,
)
from freebody.model.geometry import geometric_fact
from freebody.model.model import Model
from freebody.trees.states import difference, generic_state, home_guess, integrate

EXACT = 1e-12
"""Of scaled equations: what is open by less is closed but for rounding in the computation."""
_ZERO = 1e-9  # singular values, relative to the largest, that rounding in the computation makes
_SOFT = 8.0  # tolerances: a singular value below moves an eighth of a radian within the tolerance
_STEPS = (0.13, 0.31)  # rad: lengths of the ways to regular positions
_STRIDE, _WAY = 0.1, 0.5  # rad: of the way that shows a motion, each step and the whole
_STARTS = 16
# misfits: what is left out turns with the motion, the faster the nearer a singular position
_SLACK = 30.0


@dataclass(frozen=True, eq=False)
class Redundancy:
    """What of the loop equations counts."""

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

    @property
    def slack(self) -> float:
        """What rounding of the model's numbers may add to a gap, its rate, a balance, all
        relative."""
        return _SLACK * self.blur


_NONE = Redundancy(None)


@geometric_fact
def redundancy(model: Model) -> Redundancy:
    """Of a geometry, found once."""
    tolerance = scales(model).tolerance
    soft = _SOFT * float(tolerance.max(initial=0.0))
    if not soft:
        return _NONE
    search = _Search(model, soft)
    at = search.start()
    if at is None or search.regularity(at)[0] == mechanism(model).constraints:
        return _NONE
    reached = search.neighbours(at)  # from a singular position to regular ones
    if not len(reached):
        return _NONE
    at = max(reached, key=search.regularity)
    _, s, Vt = np.linalg.svd(every_jacobian(model, at))
    rank = int((s > soft).sum())
    if rank == mechanism(model).constraints:
        return _NONE
    # singular values between rounding in the computation and rounding in the file: do they let it
    # move?
    doubtful = [k for k in range(rank, len(s)) if s[k] > _ZERO * s[0]]
    ways = [search.way(at, Vt[k], rank) for k in doubtful]
    seen = np.concatenate([at[None], *(way for way in ways if way is not None)])
    rank += sum(way is None for way in ways)
    return _weighed(model, seen, rank)


def _weighed(model: Model, seen: Array, rank: int) -> Redundancy:
    """From positions (k, nq) on the mechanism's ways."""
    seen, _ = closed_from(model, seen, range(model.nv), lambda A: telling(A, rank))
    phi, A = every_residual(model, seen), every_jacobian(model, seen)
    s = np.linalg.svd(A, compute_uv=False)
    if np.abs(phi).max(initial=0.0) < EXACT and (s[:, rank:] <= _ZERO * s[:, :1]).all():
        return _NONE
    metres = scales(model).metres
    largest = np.abs(phi).max(axis=0)
    largest[largest < EXACT] = 0.0
    misfit = (
        float(length(model) * largest[metres].max(initial=0.0)),
        float(largest[~metres].max(initial=0.0)),
    )
    return Redundancy(rank, _telling_rows(A, rank), misfit, float(largest.max()))


@dataclass(frozen=True, eq=False)
class _Search:
    """Positions at which all loops are closed within the tolerance; singular values below `soft`
    may be rounding."""

    model: Model
    soft: float

    def start(self) -> Array | None:
        """The one nearest to home, of those found from fixed starts."""
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
                return q[good][int(np.argmin(np.linalg.norm(way, axis=-1)))]
        return None

    def closed(self, q: Array, rank: int | None = None) -> tuple[Array, NDArray[np.bool_]]:
        """(positions (N, nq) near q at which all that tells holds, whether the rest does within the
        tolerance (N,))."""
        model = self.model
        soft = 0.0 if rank is not None else self.soft
        q, left = closed_from(model, q, range(model.nv), lambda A: telling(A, rank, soft))
        within = (np.abs(every_residual(model, q)) <= scales(model).tolerance).all(axis=-1)
        return q, within & (left < EXACT) & ~backward(model, q).any(axis=-1)

    def neighbours(self, q: Array) -> Array:
        """Positions (k, nq) that a motion within the tolerance leads to from q (nq,)."""
        model = self.model
        _, s, Vt = np.linalg.svd(every_jacobian(model, q))
        directions = Vt[int((s > self.soft).sum()) :]
        n = len(directions)
        if not n:
            return np.empty((0, model.nq))
        ways = np.concatenate([np.eye(n), np.random.default_rng(2).normal(size=(n, n))])
        ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
        ways = np.concatenate([sign * size * ways for size in _STEPS for sign in (1.0, -1.0)])
        start = np.broadcast_to(q, (len(ways), model.nq))
        found, good = self.closed(integrate(model, start, ways @ directions * rate_scale(model)))
        moved = np.linalg.norm(difference(model, start, found) / rate_scale(model), axis=-1)
        return found[good & (moved > 0.3 * np.linalg.norm(ways, axis=-1))]

    def regularity(self, q: Array) -> tuple[int, float]:
        """(how many combinations of equations tell something at q (nq,), how much the last of
        them)."""
        s = np.linalg.svd(every_jacobian(self.model, q), compute_uv=False)
        clear = s[s > self.soft]
        return len(clear), float(clear.min(initial=1.0))

    def way(self, start: Array, direction: Array, rank: int) -> Array | None:
        """Positions (k, nq) on the motion that starts along a direction (nv,), with `rank`
        combinations held; None where it leaves the tolerance at once."""
        model = self.model
        found: list[Array] = []
        for sense in (1.0, -1.0):
            q, along = start, sense * direction
            for _ in range(round(2.0 * _WAY / _STRIDE)):
                null = np.linalg.svd(every_jacobian(model, q))[2][rank:]
                along = null.T @ (null @ along)
                along /= max(float(np.linalg.norm(along)), 1e-300)
                there, good = self.closed(
                    integrate(model, q, _STRIDE * along * rate_scale(model))[None], rank
                )
                if not good[0]:
                    break
                q = there[0]
                found.append(q)
        return np.array(found) if len(found) * _STRIDE >= _WAY else None


def _telling_rows(A: Array, rank: int) -> tuple[int, ...]:
    """`rank` rows of Φ_q = A (k, m, nv) that tell as much as all together at every one of k
    positions, as far as any do; of equals the first."""
    left = np.linalg.svd(A, full_matrices=False)[0][..., :rank]  # (k, m, r)
    chosen: list[int] = []
    for _ in range(rank):
        sizes = np.linalg.norm(left, axis=-1).min(axis=0)
        sizes[chosen] = 0.0
        k = int(np.argmax(sizes > 0.5 * sizes.max()))
        chosen.append(k)
        unit = left[:, k] / np.linalg.norm(left[:, k], axis=-1, keepdims=True)
        left = left - np.einsum("kmr,kr->km", left, unit)[..., None] * unit[:, None]
    return tuple(sorted(chosen))
