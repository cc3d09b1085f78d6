"""The information of a motion on a robot's parameters, and the criteria that motions are compared
by.

With noise of known size in the torques, the least variance with which parameters can be found from
a motion is the inverse of its information M = Σ Yᵀ W Y (Y the columns of the regression, W the
inverse variances).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.any_friction import spline_columns, spline_knots
from freebody.identification.columns import Columns, friction_laws, regression_columns
from freebody.identification.excitation.fourier import FourierStates
from freebody.identification.first_gains import inverse_products
from freebody.model.model import Model
from freebody.trees.base_parameters import independent
from freebody.trees.public_calls import JointVector, finite_vector

_SMOOTH = 0.05
"""Rate within which dry friction changes its sense in the columns: slopes have to see it."""
_SHARE = 0.01
"""Noise in a torque, as a part of the effort limit, where none is given."""
_POWER = 6
"""Power of the mean of variances that stands for the largest."""
_DETERMINANT = 0.25
"""Weight of the determinant beside the largest variance, so that friction stays told."""


@dataclass(frozen=True)
class MotionInformation:
    """The columns of a robot's parameters, and the noise (nv,) in the torque of each joint.

    told: places of the unknowns that count, base parameters first. base: the number of base
    parameters that count. slow: whether accelerations are left out.
    """

    columns: Columns
    told: NDArray[np.intp]
    base: int
    noise: Array
    slow: bool

    @staticmethod
    def of(model: Model, friction: Sequence[str], noise: Array, slow: bool) -> MotionInformation:
        """The information that motions give of a robot with these laws of friction; slow ones tell
        gravity and friction alone."""
        laws = friction_laws("excitation", model, friction)
        columns = replace(regression_columns("excitation", model, laws), smooth=_SMOOTH)
        if columns.by_load:
            raise FreebodyError(
                "excitation: load-dependent friction has no columns of its own; leave 'load' out "
                "of friction, the motion is as good for it."
            )
        told = np.arange(len(columns.names))
        if slow:
            told = np.concatenate([_by_gravity(columns), told[columns.base :]])
        base = int((told < columns.base).sum())
        return MotionInformation(columns, told, base, noise, slow)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters that count."""
        return tuple(self.columns.names[k] for k in self.told)

    def entries(self, states: FourierStates) -> list[tuple[Array, NDArray[np.intp]]]:
        """For each joint the columns (..., c) at states, over the torque's noise, and the places
        among what counts that they belong to."""
        values = self.columns.results(*states)
        at_rest = values
        if self.slow:
            still = np.zeros_like(states.q)
            at_rest = self.columns.results(states.q, still, still)
        place = np.full(len(self.columns.names), -1)
        place[self.told] = np.arange(len(self.told))
        found = []
        for row, sigma in zip(self.columns.rows, self.noise, strict=True):
            of_base = row.unknowns < self.columns.base
            x = np.where(of_base, at_rest[..., row.results], values[..., row.results])
            kept = place[row.unknowns] >= 0
            found.append((x[..., kept] / sigma, place[row.unknowns[kept]]))
        return found

    def matrix(self, states: FourierStates, used: NDArray[np.bool_] | None = None) -> Array:
        """M of the samples (n, nv) of states, those of each joint that are used (n, nv), friction
        following the laws."""
        M = np.zeros((len(self.told), len(self.told)))
        for j, (x, places) in enumerate(self.entries(states)):
            x = x if used is None else x[used[:, j]]
            M[np.ix_(places, places)] += x.T @ x
        return M

    def deviations(self, states: FourierStates, used: NDArray[np.bool_]) -> Array:
        """Standard deviations with which `fb.identify` finds what counts from the samples (n, nv)
        of each joint that are used: base parameters whatever the friction, friction by the laws.
        Raises LinAlgError where some are not told."""
        qd, sign = states.qd, self.columns.sign(states.qd)
        n, M = qd.shape[1], np.zeros((self.base, self.base))
        knots = spline_knots([qd[used[:, j], j] for j in range(n)])
        spline = np.stack(spline_columns(qd, sign, knots), axis=1)
        for j, (x, places) in enumerate(self.entries(states)):
            x, kept = x[used[:, j]], places < self.base
            local = np.concatenate([x[:, ~kept], spline[used[:, j], :, j]], axis=1)
            own, across = x[:, kept], local.T @ x[:, kept]
            own = own.T @ own - across.T @ inverse_products(local.T @ local) @ across
            M[np.ix_(places[kept], places[kept])] += own
        by_laws = np.diag(_inverse(self.matrix(states, used)))[self.base :]
        return np.sqrt(np.concatenate([np.diag(_inverse(M)), by_laws]))

    def by_slopes(self, states: FourierStates, S: Array) -> Array:
        """tr(W Y S Yᵀ) (...) of each state, whose slope is that of the criterion with this S."""
        told = sum(
            np.einsum("...i,...i", y @ S[np.ix_(at, at)], y) for y, at in self.entries(states)
        )
        return np.asarray(told)


def criterion(M: Array, base: int, worst: bool) -> tuple[float, Array]:
    """The value that is made small, and the matrix S by which its slope is -Σ tr(dM S)."""
    size = len(M)
    d = np.sqrt(np.diag(M))
    logs = float(np.linalg.slogdet(M / np.outer(d, d))[1] + 2.0 * np.log(d).sum()) / size
    inverse = _inverse(M)
    if not worst:
        return -logs, inverse / size
    variances = np.diag(inverse)[:base]
    largest = float(variances.max())
    powers = (variances / largest) ** _POWER
    D = np.zeros(size)
    D[:base] = powers / (variances * powers.sum())
    value = float(np.log(largest) + np.log(powers.sum()) / _POWER)
    return value - _DETERMINANT * logs, (inverse * D) @ inverse + _DETERMINANT / size * inverse


def _inverse(M: Array) -> Array:
    """M⁻¹ of an information matrix, scaled to a unit diagonal meanwhile. Raises LinAlgError where
    it is not positive definite."""
    d = np.sqrt(np.diag(M))
    factor = np.linalg.inv(np.linalg.cholesky(M / np.outer(d, d)))
    return factor.T @ factor / np.outer(d, d)


def noise_of_torques(
    model: Model, noise: JointVector | float | None, effort: Array
) -> tuple[Array, tuple[str, ...]]:
    """The noise (nv,) in each joint's torque, and words on where it is from."""
    if noise is None:
        size = np.where(np.isfinite(effort), _SHARE * effort, 1.0)
        return size, (
            f"Standard deviations are for torques whose noise is {_SHARE:.0%} of the effort limit, "
            f"or 1 N m where there is none; give noise, in proportion to which they are.",
        )
    alike = not isinstance(noise, Mapping) and np.ndim(noise) == 0
    given = np.full(model.nv, noise) if alike else noise
    size = finite_vector("excitation", model, "noise", given)
    if size.shape != (model.nv,) or not (size > 0.0).all():
        raise FreebodyError(f"excitation: noise is {noise}, expected a number above 0, or (nv,).")
    return size, ()


def _by_gravity(columns: Columns) -> NDArray[np.intp]:
    """Places of the base parameters that torques at rest tell, those that are no combination of
    others."""
    n = len(columns.rows)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (4 * columns.base, n))
    values = columns.results(q, np.zeros_like(q), np.zeros_like(q))
    Y = np.zeros((n, len(q), columns.base))
    for y, row in zip(Y, columns.rows, strict=True):
        of_base = row.unknowns < columns.base
        y[:, row.unknowns[of_base]] = values[:, row.results][:, of_base]
    chosen, _ = independent(Y.reshape(-1, columns.base))
    if not chosen:
        raise FreebodyError(
            "excitation: gravity loads none of the joints, so that a quasi-static motion tells no "
            "mass; leave quasi_static out."
        )
    return np.array(chosen, dtype=np.intp)
