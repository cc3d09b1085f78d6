"""The fit of a chain's unknowns to measured poses: Gauss–Newton steps within the prior, the noise
estimated alongside, wild poses left out.

Everything is measured in the prior's standard deviations, x = S ξ with ξ ~ N(0, 1), so that the
posterior is proper whatever the poses tell: with A = W J S its covariance is C = (AᵀA + 1)⁻¹. The
hat matrix is A C Aᵀ, and residuals e have the covariance σ² (1 - A C Aᵀ): so each kind of noise
has Σ e² / (m - tr H) as its variance without bias, under the prior, and each pose is predicted
without it by e_i (1 - H_ii)⁻¹ (Allen 1974: PRESS).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.calibration.chain import MeasuredChain, rotation_vectors, skew, turned
from freebody.identification.calibration.instrument import FittedPose, Guess
from freebody.identification.calibration.poses import Poses
from freebody.motion.ranges import Flags
from freebody.outputs.display import counted
from freebody.trees.positions import random_state

_STEPS, _LATER = 60, 5
"""Most steps of a fit, and most times that wild poses are sought."""
_SETTLED, _NEARLY = 1e-3, 0.1
"""Standard deviations afterwards by which a step may still move what is found, and parts by which
it may change the noise; and those while poses are still doubted."""
_LEAST = 1e-10
"""Standard deviation (m, rad) below which noise is that of the arithmetic."""
_HUBER = 2.5
"""Standard deviations of a pose's distance from which on it counts less (Huber 1964)."""
_SMALL = 1e-3
"""Part of what the first guess leaves that noise is taken for at first."""
_MEDIAN = 1.5382
"""Median length of three normal numbers of deviation 1."""
_ACCIDENT = 1e-3
"""Probability, over all poses, that one is taken for wild by accident."""
_ROWS = 1.5
"""Measured coordinates for each number that they tell, below which they do not tell their noise."""
_LEAST_POSES, _GENERIC = 6, 60
"""Poses without which nothing is told, and random ones that tell as much as any do."""
_ONES = np.ones(2)
"""Noise of positions and rotations where it does not matter."""
_SOMEWHERE = FittedPose(np.eye(3), np.array([0.1, 0.2, 0.3]))
"""A marker on no joint's axis."""
_FARTHEST = 0.2
"""Standard deviation (m) of the marker's place in its frame beforehand: it sits on a tool. Poses
tell it far better, but for a height that moving the instrument makes up for."""
_RANK = 1e-9
"""Part of the largest singular value below which a combination is not told at all."""


class Residuals(NamedTuple):
    """Residuals of measured poses, in the instrument's axes: distances (n, 3) in m, and turns
    (n, 3) in rad or None; and the changes (n, 3, k) of what is predicted by the unknowns."""

    position: Array
    rotation: Array | None
    linear: Array
    angular: Array

    @property
    def kinds(self) -> list[Array]:
        """The residuals of each kind that is measured."""
        return [self.position] if self.rotation is None else [self.position, self.rotation]


@dataclass(frozen=True)
class CalibrationFit:
    """A fitted geometry x with the instrument and the marker, and what it leaves.

    spread: standard deviations (k,) of the unknowns beforehand, 1 for those of instrument and
    marker, whose prior is flat but for the marker's place. active: indices of those that are not
    known. root: (a, a), the covariance of these afterwards is root rootᵀ in these units. noise:
    standard deviations of positions, m, and of rotations, rad. freedom: degrees of freedom of each.
    kept: flags (n,) of the poses that count.
    """

    chain: MeasuredChain
    poses: Poses
    x: Array
    instrument: FittedPose
    marker: FittedPose
    active: NDArray[np.intp]
    spread: Array
    noise: Array
    given: bool
    kept: Flags
    freedom: Array
    root: Array
    robust: bool = True
    """Whether poses that are far off count less, before it is settled which are wild."""

    @property
    def geometry(self) -> int:
        """The number of active unknowns of the geometry, which come first."""
        return int(np.sum(self.active < len(self.chain.names)))

    @property
    def marker_place(self) -> NDArray[np.intp]:
        """Indices, among the active unknowns, of the marker's place: three, or none."""
        k = len(self.x)
        return np.flatnonzero((self.active >= k + 6) & (self.active < k + 9))

    def residuals(self, poses: Poses) -> Residuals:
        """Residuals of poses that are predicted."""
        found = self.chain.marker_poses(poses.q, self.x, self.instrument, self.marker)
        r_p = poses.position - found.position
        if poses.rotation is None:
            return Residuals(r_p, None, found.linear, found.angular)
        r_R = rotation_vectors(poses.rotation @ np.swapaxes(found.rotation, 1, 2))
        return Residuals(r_p, r_R, found.linear, _inverse_jacobian(r_R) @ found.angular)

    def whitened(self, left: Residuals) -> tuple[Array, Array]:
        """Columns (n, d, a) and residuals (n, d) of poses in standard deviations of noise."""
        columns = left.linear[:, :, self.active] * (self.spread[self.active] / self.noise[0])
        if left.rotation is None:
            return columns, left.position / self.noise[0]
        turns = left.angular[:, :, self.active] * (self.spread[self.active] / self.noise[1])
        return (
            np.concatenate([columns, turns], axis=1),
            np.concatenate([left.position / self.noise[0], left.rotation / self.noise[1]], axis=1),
        )

    def without_each(self) -> list[Array]:
        """Residuals (n, 3) of each kind, m and rad, with every pose predicted from the others."""
        columns, left = self.whitened(self.residuals(self.poses))
        own = columns @ self.root
        rest = np.eye(own.shape[1]) - own @ np.swapaxes(own, 1, 2)
        alone = np.linalg.solve(rest, left[:, :, None])[:, :, 0]
        found = np.where(self.kept[:, None], alone, left)
        return [found[:, 3 * k : 3 * k + 3] * noise for k, noise in enumerate(self.noise)]

    def wild(self) -> Flags:
        """Flags (n,) of poses that noise explains by no accident."""
        from scipy.stats import chi2

        columns, left = self.whitened(self.residuals(self.poses))
        own = columns @ self.root
        sign = np.where(self.kept, -1.0, 1.0)[:, None, None]
        expected = np.eye(own.shape[1]) + sign * (own @ np.swapaxes(own, 1, 2))
        alone = np.linalg.solve(expected, left[:, :, None])[:, :, 0]
        distance = np.sum(left * alone, axis=1)
        # noise may be more than was stated
        usual = np.median(distance) / chi2.median(left.shape[1])
        return distance / max(1.0, float(usual)) > chi2.isf(_ACCIDENT / len(left), left.shape[1])


def fit(
    chain: MeasuredChain,
    poses: Poses,
    start: Guess,
    unknown: tuple[bool, bool],
    spread: Array | None,
    noise: Array | None,
) -> CalibrationFit:
    """The fit from a first guess, with wild poses left out.

    unknown: whether instrument and marker are. spread: of the geometry, None where it is not to be
    changed. noise: standard deviations of positions (m) and rotations (rad), estimated if None.
    """
    found = _start(chain, poses, start, unknown, spread, noise)
    if not len(found.active):
        return found
    found = _settled(found, robust=True)
    for _ in range(_LATER):
        kept = ~found.wild()
        done = not found.robust and np.array_equal(kept, found.kept)
        if done:
            break
        found = _settled(replace(found, kept=kept), robust=False)
    count = int(found.kept.sum())
    if 2 * count < len(poses):
        raise FreebodyError(
            f"calibrate: only {count} of {len(poses)} poses agree with one geometry; check that "
            f"instrument and marker did not move between them, and leave out what is wrong."
        )
    return found


def marker_doubt(found: CalibrationFit) -> tuple[float, Array]:
    """How far (m, standard deviation) the marker may be from its place, and what that adds to the
    covariance of the geometry, in units of the prior.

    To first order nothing: the instrument makes up for it. But a frame that may be turned by φ
    moves a marker at a distance h by φ h, so that with h a shift is not told either.
    """
    g, place = found.geometry, found.marker_place
    if not len(place):
        return 0.0, np.zeros((g, g))
    _, size, ways = np.linalg.svd(found.root[place], full_matrices=False)
    poses = found.poses.of(found.kept)
    elsewhere = _moved(found, found.root @ ways[0])
    here, there = (
        x.whitened(x.residuals(poses))[0].reshape(-1, len(found.active)) for x in (found, elsewhere)
    )
    covariance = found.root @ found.root.T
    shifts = covariance[:g] @ here.T @ (there - here)[:, :g]
    return _FARTHEST * float(size[0]), shifts @ covariance[:g, :g] @ shifts.T


def require_enough(
    chain: MeasuredChain,
    poses: Poses,
    held: tuple[FittedPose | None, FittedPose | None],
    spread: Array,
) -> None:
    """Refuses poses that are too few to tell the unknowns and their own noise, with the number that
    suffices wherever they are; fewer do where they move few joints.

    held: the instrument and the marker, None where they are unknown. spread: as of `fit`.
    """
    unknown = held[0] is None, held[1] is None
    start = Guess(held[0] or FittedPose(np.eye(3), np.zeros(3)), held[1] or _SOMEWHERE, 0.0)

    def fewest(some: Poses) -> tuple[int, int]:
        return _fewest(_start(chain, some, start, unknown, spread, _ONES))

    _, least = fewest(poses)
    if len(poses) >= max(least, _LEAST_POSES):
        return
    q, _, _ = random_state(chain.model, 0, _GENERIC)
    axes = None if poses.rotation is None else np.tile(np.eye(3), (_GENERIC, 1, 1))
    told, needed = fewest(Poses(q, np.zeros((_GENERIC, 3)), axes))
    raise FreebodyError(
        f"calibrate: {counted(len(poses), 'pose')}; {told} numbers of {chain.model.name!r} show at "
        f"{chain.frame!r}: measure at least {max(needed, least, _LEAST_POSES)} poses, better twice "
        f"as many."
    )


def _fewest(found: CalibrationFit) -> tuple[int, int]:
    """How many numbers the poses of a fit tell, and how many poses tell so many, and noise."""
    columns, left = found.whitened(found.residuals(found.poses))
    size = np.linalg.svd(columns.reshape(-1, columns.shape[2]), compute_uv=False)
    told = int(np.sum(size > _RANK * size.max(initial=0.0)))
    return told, int(np.ceil(_ROWS * told / left.shape[1]))


def _start(
    chain: MeasuredChain,
    poses: Poses,
    start: Guess,
    unknown: tuple[bool, bool],
    spread: Array | None,
    noise: Array | None,
) -> CalibrationFit:
    k = len(chain.names)
    active = [*range(k)] if spread is not None else []
    active += [*range(k, k + 6)] if unknown[0] else []
    active += [*range(k + 6, k + (9 if poses.rotation is None else 12))] if unknown[1] else []
    first = np.full(1 if poses.rotation is None else 2, 1.0)
    whole = np.concatenate(
        [np.ones(k) if spread is None else spread, np.ones(6), np.full(3, _FARTHEST), np.ones(3)]
    )
    found = CalibrationFit(
        chain,
        poses,
        np.zeros(k),
        start.instrument,
        start.marker,
        np.array(active, dtype=np.intp),
        whole,
        first if noise is None else noise[: len(first)],
        noise is not None,
        np.ones(len(poses), dtype=bool),
        first,
        np.zeros((len(active), len(active))),
    )
    if noise is None:
        left = found.residuals(poses)
        # from small noise upwards: from large noise on, a robot that is further off than its
        # prior says would pass for one with a bad instrument
        noise = np.array([_SMALL * _by_median(x) for x in left.kinds])
        found = replace(found, noise=np.maximum(noise, _LEAST))
    return found


def _settled(found: CalibrationFit, robust: bool) -> CalibrationFit:
    """The fit after steps that no longer change it; robust: poses that are far off count less, and
    noise is that of the median."""
    found = replace(found, robust=robust)
    tolerance = _NEARLY if robust else _SETTLED
    for _ in range(_STEPS):
        found, changed = _stepped(found)
        if changed <= tolerance:
            break
    return found


def _stepped(found: CalibrationFit) -> tuple[CalibrationFit, float]:
    """The fit after a Gauss–Newton step, with the noise that is left behind it; and by how much
    that changed it, in standard deviations and in parts of the noise."""
    left = found.residuals(found.poses)
    columns, rest = found.whitened(left)
    weights = np.sqrt(_weights(found, rest))
    triangles = [
        _triangle(columns[:, rows], rest[:, rows], weights)
        for rows in (slice(3 * k, 3 * k + 3) for k in range(len(found.noise)))
    ]
    size = len(found.active)
    stacked = np.concatenate([*triangles, np.zeros((size, size + 1))])
    u, s, vt = np.linalg.svd(stacked[:, :-1], full_matrices=False)
    prior = np.zeros(size)
    prior[: found.geometry] = -(found.x / found.spread[: len(found.x)])[: found.geometry]
    place = found.marker_place
    prior[place] = -(found.marker.p / _FARTHEST)[: len(place)]
    scale = np.sqrt(1.0 + s**2)
    step = (s * (u.T @ stacked[:, -1]) + vt @ prior) / scale
    root = vt.T / scale
    shares = [float(np.sum((x[:, :-1] @ root) ** 2)) for x in triangles]
    freedom = 3.0 * np.sum(weights > 0.0) - np.array(shares)
    result = _moved(replace(found, root=root, freedom=freedom), root @ step)
    change = float(np.abs(step).max(initial=0.0))
    if found.given:
        return result, change
    after = (rest - columns @ (root @ step)).reshape(len(rest), -1, 3)
    after = np.moveaxis(after, 1, 0) * found.noise[:, None, None]
    noise = np.array([_noise(found, *x) for x in zip(after, freedom, strict=True)])
    return replace(result, noise=noise), max(change, float(np.abs(noise / found.noise - 1.0).max()))


def _triangle(columns: Array, rest: Array, weights: Array) -> Array:
    """The triangular factor of weighted columns (n, 3, a) with residuals (n, 3) as the last."""
    matrix = np.concatenate([columns, rest[:, :, None]], axis=2) * weights[:, None, None]
    return np.asarray(np.linalg.qr(matrix.reshape(-1, matrix.shape[2]), mode="r"))


def _noise(found: CalibrationFit, residual: Array, freedom: float) -> float:
    """The standard deviation of noise that residuals (n, 3) of one kind show."""
    freedom = max(freedom, 1.0)
    if found.robust:
        return _by_median(residual) * float(np.sqrt(residual.size / freedom))
    total = float(np.sum(residual[found.kept] ** 2))
    return max(float(np.sqrt(total / freedom)), _LEAST)


def _moved(found: CalibrationFit, step: Array) -> CalibrationFit:
    """The fit with its unknowns changed by a step, in standard deviations of the prior."""
    whole = np.zeros(len(found.spread))
    whole[found.active] = step
    k = len(found.x)
    change = found.spread * whole
    (R_I, p_I), (R_M, p_M) = found.instrument, found.marker
    a, b = change[k : k + 6], change[k + 6 :]
    return replace(
        found,
        x=found.x + change[:k],
        instrument=FittedPose(R_I @ turned(a[3:]), p_I + a[:3]),
        marker=FittedPose(R_M @ turned(b[3:]), p_M + b[:3]),
    )


def _weights(found: CalibrationFit, rest: Array) -> Array:
    """Weights (n,) of poses: Huber's, or 1 of those that are kept."""
    if not found.robust:
        return found.kept.astype(float)
    d = np.max([np.linalg.norm(x, axis=1) for x in np.split(rest, len(found.noise), axis=1)], 0)
    return np.minimum(1.0, _HUBER / np.maximum(d, _HUBER))


def _by_median(residual: Array) -> float:
    """The standard deviation of noise by the median length of residuals (n, 3)."""
    return max(float(np.median(np.linalg.norm(residual, axis=1))) / _MEDIAN, _LEAST)


def _inverse_jacobian(x: Array) -> Array:
    """J (n, 3, 3) with log(exp(x) exp(dx)) = x + J dx for rotation vectors x (n, 3)."""
    half = 0.5 * np.linalg.norm(x, axis=1)
    safe = np.where(half > 1e-3, half, 1.0)
    factor = np.where(half > 1e-3, 0.25 * (1.0 - safe / np.tan(safe)) / safe**2, 1.0 / 12.0)
    K = skew(x)
    return np.eye(3) + 0.5 * K + factor[:, None, None] * (K @ K)
