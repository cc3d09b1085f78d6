"""Motions that the loops of a closed chain leave to its compliant joints, and how the forces of the
loops stiffen them.

Along a curve of closed positions with rates v the potential energy has the second derivative

    vᵀ K v + r q̈,   Φ_q q̈ = c(q, v)

with K the slopes of the torques of the tree, loops cut, and r what these torques lack of balance
with the drives, which the loops give. The second term is that of a pendulum whose load hangs in two
ropes: no joint of it has a spring or a weight that turns with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.algorithms.singular_thresholds import RANK
from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, SingularError, listed
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.closure_checks import branches, counting, require_closed, scaled_jacobian
from freebody.loops.scaled_equations import rate_scale, row_scale
from freebody.model.model import Model
from freebody.reach.compliant_joints import (
    CompliantJoints,
    quaternion_coordinates,
    sprung_coordinates,
)
from freebody.trees.position_rates import Index

_MISSED = 1e-9
"""Part of the power of weights that drives may miss: rounding."""


@dataclass(frozen=True)
class LoopMotions:
    """The motions (n, nv, f), a column each, that loops and coordinates at rest leave free, at n
    closed positions, and what the forces of the loops add to their stiffness (n, f, f)."""

    ways: Array
    bend: Array


def loop_motions(
    function: str,
    joints: CompliantJoints,
    q: Array,
    needed: Array | None = None,
    drives_hold: bool = False,
) -> LoopMotions:
    """The free motions of a closed chain at positions (n, nq).

    needed: (n, nv), torques that the tree needs at rest, loops cut, of which the loops give what
    coordinates at rest do not, and with `drives_hold` what drives do not; None where the loops'
    forces do not count. Refuses open loops, and singular positions among others.
    """
    model, ways, bend = joints.model, {}, {}
    if not len(q):
        return LoopMotions(np.zeros((0, model.nv, 0)), np.zeros((0, 0, 0)))
    for taken, part in branches(model, q, np.ones(len(q), dtype=bool)):
        require_closed(function, taken, q, among=part)
        at = np.flatnonzero(part)
        A = scaled_jacobian(taken, q[at])
        decomposed = _Decomposed.of(_with_still(A, joints.still))
        for rank in np.unique(decomposed.rank):
            some = decomposed.rank == rank
            N = np.swapaxes(decomposed.Vt[some, rank:], -1, -2)
            added = np.zeros((len(N), N.shape[-1], N.shape[-1]))
            if needed is not None:
                left = rate_scale(model) * needed[at[some]]
                if drives_hold:
                    left = _left_to_loops(function, joints, A[some], left, at[some])
                h = decomposed.multipliers(some, int(rank), left)[:, : A.shape[1]]
                added = _bend(taken, q[at[some]], N, h)
            ways |= zip(at[some], rate_scale(model)[:, None] * N, strict=True)
            bend |= zip(at[some], added, strict=True)
    _require_alike(function, model, [ways[k].shape[-1] for k in range(len(q))])
    return LoopMotions(*(np.stack([x[k] for k in range(len(q))]) for x in (ways, bend)))


def _require_alike(function: str, model: Model, counts: list[int]) -> None:
    """Refuse positions of which some leave more motions than others, or none."""
    if max(counts) == 0:
        raise FreebodyError(
            f"{function}: the loops of {model.name!r} let nothing move while the drives stand "
            f"still; give stiffness= to some of {listed(model.driven_names, 8)}."
        )
    usual = min(counts)
    if max(counts) > usual:
        where = at_sample((counts.index(max(counts)),))
        raise SingularError(
            f"{function}: {model.name!r} is at a singular position{where}, where its loops leave "
            f"{max(counts)} motions to the joints that yield, elsewhere {usual}; look at it alone."
        )


def _with_still(A: Array, still: Index) -> Array:
    """The equations (n, m, nv) and, below, that coordinates stand still."""
    rows = np.zeros((len(A), len(still), A.shape[-1]))
    rows[:, np.arange(len(still)), still] = 1.0
    return np.concatenate([A, rows], axis=1)


@dataclass(frozen=True)
class _Decomposed:
    """Singular values of matrices (n, m, nv), and their ranks (n,)."""

    U: Array
    s: Array
    Vt: Array
    rank: Index

    @staticmethod
    def of(B: Array) -> _Decomposed:
        U, s, Vt = np.linalg.svd(B)
        least = RANK * s.max(axis=-1, keepdims=True, initial=1e-300)
        return _Decomposed(U, s, Vt, (s > least).sum(axis=-1))

    def multipliers(self, some: np.ndarray, rank: int, force: Array) -> Array:
        """The smallest h (k, m) with Bᵀ h = force (k, nv), of samples of one rank."""
        parts = np.einsum("nij,nj->ni", self.Vt[some, :rank], force) / self.s[some, :rank]
        return np.einsum("nij,nj->ni", self.U[some, :, :rank], parts)


def _left_to_loops(
    function: str, joints: CompliantJoints, A: Array, wanted: Array, samples: Index
) -> Array:
    """The part (n, nv) that loops give of the scaled torques that a tree needs at rest: all but the
    smallest ones of drives, springs and what stands still that have their power."""
    model = joints.model
    acting = np.setdiff1d(
        np.concatenate([model.driven, joints.still, sprung_coordinates(model)]).astype(np.intp),
        quaternion_coordinates(model),
    )
    loops, left = _Decomposed.of(A), wanted.copy()
    for rank in np.unique(loops.rank):
        some = np.flatnonzero(loops.rank == rank)
        V = loops.Vt[some, rank:]
        power = np.einsum("nfk,nk->nf", V, wanted[some])
        motions = V[..., acting]
        found = np.einsum("nkf,nf->nk", np.linalg.pinv(motions, rcond=RANK), power)
        missed = np.abs(np.einsum("nfk,nk->nf", motions, found) - power).max(axis=-1, initial=0.0)
        bad = missed > _MISSED * (1.0 + np.abs(wanted[some]).max(axis=-1, initial=0.0))
        if bad.any():
            where = at_sample((int(samples[some[np.argmax(bad)]]),))
            raise SingularError(
                f"{function}: the drives of {model.name!r} cannot hold it{where}: it can move with "
                f"these standing still. Drive another joint (actuated=), or give a position at "
                f"which it rests."
            )
        left[some[:, None], acting] -= found
    return left


def _bend(model: Model, q: Array, N: Array, h: Array) -> Array:
    """r q̈ as a form in the weights of the motions (n, f, f), where the loops' multipliers are h (n,
    m): of pairs by that of sums, since c is a square of rates."""
    f = N.shape[-1]
    i, j = np.triu_indices(f)
    sums = np.swapaxes(N[..., i] + N[..., j], -1, -2) * rate_scale(model)
    c = fetch(model, ("constraint_bias",), Option())(q[:, None], sums)
    at = np.broadcast_to(q[:, None], (*c.shape[:2], q.shape[-1]))
    forms = np.einsum("nm,npm->np", h, counting(model, at, row_scale(model) * c))
    own = forms[:, i == j] / 4.0
    found = np.empty((len(q), f, f))
    found[:, i, j] = 0.5 * (forms - own[:, i] - own[:, j])
    found[:, j, i] = found[:, i, j]
    return found
