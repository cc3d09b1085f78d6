"""Reasons of the errors that a calibration leaves, where they are more than noise.

Each suspicion is a joint whose reading is wrong in a way that no geometry explains. If it were
noise alone, residuals e would have the covariance 1 - A C Aᵀ, and with the displacements F that
suspicions would cause, Fᵀ e the covariance Fᵀ (1 - A C Aᵀ) F: a score test.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.identification.calibration.fit import CalibrationFit

_UNLIKELY = 1e-4
"""Probability below which a dependence is no accident, over all suspicions."""
_EXPLAINED = 1e-4
"""Part of a suspicion that geometry does not explain, below which nothing can be said of it."""


@dataclass(frozen=True)
class _Suspicion:
    """Something by which a joint's reading may be wrong. errors: (q, loads) of the joint (n,), to
    its possible errors (n, m), each up to a factor."""

    words: str
    of_sliding: bool
    errors: Callable[[Array, Array], Array]


def _by_angle(q: Array, load: Array) -> Array:
    return np.stack([np.sin(q), np.cos(q), np.sin(2 * q), np.cos(2 * q)], axis=-1)


def _by_load(q: Array, load: Array) -> Array:
    return load[:, None]


_SUSPICIONS = (
    _Suspicion("the angle of {joint}, as with an encoder that is off centre", False, _by_angle),
    _Suspicion("the torque of a weight at {joint}, as when it yields", True, _by_load),
)


def misfits_of(found: CalibrationFit) -> tuple[str, ...]:
    """Reasons of the errors that are left which are no accident, in words, the surest first."""
    chain, kept = found.chain, found.kept
    poses = found.poses.of(kept)
    left = found.residuals(poses)
    columns, rest = found.whitened(left)
    rest = rest / max(1.0, np.sqrt(np.sum(rest**2) / np.sum(found.freedom)))  # stated noise may lie
    own = (columns @ found.root).reshape(-1, len(found.active))
    q, loads = chain.moved(poses.q, found.x), _loads(found, poses.q)
    tried = []
    for j, joint in enumerate(chain.joints):
        at = j * len(chain.own) + 6
        kinds = [left.linear[:, :, at], left.angular[:, :, at]][: len(found.noise)]
        moves = np.concatenate(
            [x / noise for x, noise in zip(kinds, found.noise, strict=True)], axis=1
        )
        for suspicion in _SUSPICIONS:
            if not (chain.turns[j] or suspicion.of_sliding):
                continue
            errors = suspicion.errors(q[:, j], loads[:, j])
            F = (moves[:, :, None] * errors[:, None, :]).reshape(moves.size, -1)
            chance = _chance(F, own, rest.ravel())
            tried.append((chance, suspicion.words.format(joint=joint)))
    return tuple(words for chance, words in sorted(tried) if chance < _UNLIKELY / len(tried))


def _chance(F: Array, own: Array, rest: Array) -> float:
    """The probability with which noise alone would be as like F as the residuals are."""
    from scipy.stats import chi2

    F = F / np.maximum(np.linalg.norm(F, axis=0), 1e-300)
    shared = own.T @ F
    size, axes = np.linalg.eigh(F.T @ F - shared.T @ shared)
    tested = size > _EXPLAINED
    if not tested.any():
        return 1.0
    score = (axes.T @ (F.T @ rest))[tested] ** 2 / size[tested]
    return float(chi2.sf(score.sum(), int(tested.sum())))


def _loads(found: CalibrationFit, q: Array) -> Array:
    """Torques or forces (n, k) about the joints of a weight of 1 N at the end of the chain."""
    chain = found.chain
    R, p = chain.frames(q, found.x)
    gravity = np.asarray(chain.model.gravity, dtype=float)
    size = np.linalg.norm(gravity)
    down = gravity / size if size > 0.0 else np.array([0.0, 0.0, -1.0])
    arms = p[:, -1:] - p[:, :-1]
    spins = np.einsum("nkij,kj->nki", R[:, :-1], chain.spins)
    slides = np.einsum("nkij,kj->nki", R[:, :-1], chain.slides)
    return np.cross(spins, arms) @ down + slides @ down
