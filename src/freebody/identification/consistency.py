"""The masses, inertias and frictions of a robot that can exist, from base values: Newton's method
on the fit of the data and a log-det prior.

A body exists if its pseudo-inertia, the matrix of second moments of its mass with first moments and
mass beside them, is positive definite (Wensing, Kim, Slotine 2018). The prior is the Bregman
divergence of -log det between pseudo-inertias (Lee, Wensing, Park 2020): it ties what the data
do not tell to the inertia that was given beforehand, by amounts that suit each direction's size,
and it is infinite where a body ceases to exist, so that no constraint is left to a solver.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array
from freebody.lazy import Keeps, cached_property

_STEPS = 100
"""Most steps of Newton's method; it takes some ten."""
_SETTLED, _ROUNDED = 1e-3, 1e-11
"""Newton's decrement at which it ends, in units of half a squared standard deviation, and as part
of the value."""
_WEAKEST, _STRONGEST, _FALL = 1e-2, 1e2, 5.0
"""The prior's weights: the first, or one with which it outweighs the data; the factor from one that
is tried to the next, which starts where the last has ended; and the least, with which little more
is asked than that bodies exist."""
_HALVINGS = 3
"""Further trials by which the prior's weight is found, to a sixth of its size."""
_SIZES, _SIZED = 8, 1e-3
"""Most changes of the size of estimated shapes, and the part by which the last one changes it."""
_SINGULAR = 1e-7
"""Ratio of the smallest to the largest entry of a pseudo-inertia's Cholesky factor below which a
body counts as one that cannot be."""
_BARRIER = 0.1
"""Weight of the barriers that keep friction and rotors positive."""


def pseudo_inertia_basis(dim: int) -> Array:
    """(k, d, d): the pseudo-inertia of each of a body's parameters, in their usual order, being 1.

    In the plane, where a body has one moment of inertia, the matrix [[I, h], [hᵀ, m 1]], which is
    positive definite for the same bodies.
    """
    if dim == 2:
        basis = np.zeros((4, 3, 3))
        basis[0] = np.diag([0.0, 1.0, 1.0])
        for k in range(2):
            basis[1 + k, 0, 1 + k] = basis[1 + k, 1 + k, 0] = 1.0
        basis[3, 0, 0] = 1.0
        return basis
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1.0
    for k in range(3):
        basis[1 + k, k, 3] = basis[1 + k, 3, k] = 1.0
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    for k, (i, j) in enumerate(pairs):
        inertia = np.zeros((3, 3))
        inertia[i, j] = inertia[j, i] = 1.0
        basis[4 + k, :3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return basis


@dataclass(frozen=True)
class Physical(Keeps):
    """The conditions under which unknowns x are physical: bodies in their order, then scalars.

    basis: see `pseudo_inertia_basis`. bodies: (nb, k) their prior parameters. scalars: (ns,) prior
    values of what is positive, such as friction, or NaN for what has either sign. below: (ns,)
    upper bounds. of_masses: weight of what is held of masses alone, beside that of their
    distribution.
    """

    basis: Array
    bodies: Array
    scalars: Array
    below: Array
    of_masses: float = 0.0

    def start(self) -> Array:
        """Unknowns that are physical: the prior's."""
        return np.concatenate([self.bodies.ravel(), np.nan_to_num(self.scalars)])

    def pseudo_inertias(self, x: Array) -> Array:
        """The pseudo-inertias (nb, d, d) of the bodies."""
        return np.einsum(
            "bk,kij->bij", x[: self.bodies.size].reshape(self.bodies.shape), self.basis
        )

    def penalty(self, x: Array, weight: float) -> float:
        """The weighted divergence of the bodies and the barriers of the scalars; infinite where
        something is not physical."""
        P, s = self.pseudo_inertias(x), x[self.bodies.size :]
        positive, bounded = ~np.isnan(self.scalars), np.isfinite(self.below)
        if np.any(s[positive] <= 0.0) or np.any(s >= self.below):
            return np.inf
        try:
            roots = np.linalg.cholesky(P)
        except np.linalg.LinAlgError:
            return np.inf
        sizes = np.diagonal(roots, axis1=1, axis2=2)
        if np.any(sizes.min(axis=1) < _SINGULAR * sizes.max(axis=1)):
            return np.inf
        of_bodies = -2.0 * np.log(sizes).sum()
        of_bodies += np.einsum("bij,bji->", self._prior, P)
        m = P[:, -1, -1] / self.bodies[:, 0]
        of_bodies += self.of_masses * (m - np.log(m)).sum()
        parts = s[positive] / self.scalars[positive]
        barriers = (parts - np.log(parts)).sum()
        barriers -= np.log(1.0 - s[bounded] / self.below[bounded]).sum()
        return float(weight * of_bodies + _barrier(weight) * barriers)

    @property
    def dim(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.basis[0]) - 1

    @property
    def lengths(self) -> int:
        """How many rows of a pseudo-inertia, the first ones, grow with lengths."""
        return 1 if self.dim == 2 else 3

    @cached_property
    def _prior(self) -> Array:
        return np.asarray(np.linalg.inv(self.pseudo_inertias(self.start())), dtype=float)

    def slopes(self, x: Array, weight: float) -> tuple[Array, Array]:
        """Gradient and second derivatives of the penalty."""
        (nb, k), P = self.bodies.shape, self.pseudo_inertias(x)
        inverse = np.linalg.inv(P)
        gradient, second = np.zeros(len(x)), np.zeros((len(x), len(x)))
        by_body = np.einsum("bij,kji->bk", self._prior - inverse, self.basis)
        half = np.einsum("bij,kjl->bkil", inverse, self.basis)
        blocks = np.einsum("bkil,bmli->bkm", half, half)
        m = P[:, -1, -1]
        by_body[:, 0] += self.of_masses * (1.0 / self.bodies[:, 0] - 1.0 / m)
        blocks[:, 0, 0] += self.of_masses / m**2
        gradient[: nb * k] = weight * by_body.ravel()
        for b in range(nb):
            second[b * k : (b + 1) * k, b * k : (b + 1) * k] = weight * blocks[b]
        s, places, barrier = x[nb * k :], np.arange(nb * k, len(x)), _barrier(weight)
        positive, bounded = ~np.isnan(self.scalars), np.isfinite(self.below)
        at, value = places[positive], s[positive]
        gradient[at] = barrier * (1.0 / self.scalars[positive] - 1.0 / value)
        second[at, at] = barrier * value**-2.0
        at, left = places[bounded], self.below[bounded] - s[bounded]
        gradient[at] += barrier / left
        second[at, at] += barrier * left**-2.0
        return gradient, second


def _barrier(weight: float) -> float:
    """The weight of barriers, which falls with the prior's to its own: where data that are far
    surer than it pull against it from the start, Newton's steps end at it."""
    return _BARRIER * max(1.0, weight)


@dataclass(frozen=True)
class Fitted:
    """Physical unknowns x with the prior's weight, and how far they are from the data: chi2, twice
    the misfit in units of the noise, above that of the unconstrained estimate."""

    x: Array
    weight: float
    chi2: float


def nearest_physical(
    estimate: Array,
    information: Array,
    combine: Array,
    physical: Physical,
    allowed: float,
    near: Fitted | None = None,
) -> Fitted:
    """Physical unknowns with the greatest weight of the prior that the data's noise allows.

    estimate: (b,) of regression, with information (b, b), the inverse of its covariance. combine:
    (b, x), of which physical unknowns the estimated are made. allowed: chi2 that fits the data as
    well as the estimate does, within its noise; it is added to what physics alone cost. near: the
    solution of nearly the same problem, from which less is to be done.
    """
    x, found = physical.start(), []
    weight = _first_weight(estimate, information, combine, x)
    if near is not None:
        x, weight = near.x, min(weight, near.weight * _FALL)
    while weight >= _WEAKEST:
        found.append(_newton(estimate, information, combine, physical, weight, x))
        x, weight = found[-1].x, weight / _FALL
        if found[-1].chi2 <= allowed:
            break
    if found[-1].chi2 > allowed:
        allowed += found[-1].chi2
    best = next(k for k, fitted in enumerate(found) if fitted.chi2 <= allowed)
    if best == 0:
        return found[0]
    low, high = np.log(found[best].weight), np.log(found[best - 1].weight)
    closest = found[best]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        tried = _newton(estimate, information, combine, physical, np.exp(middle), closest.x)
        if tried.chi2 <= allowed:
            low, closest = middle, tried
        else:
            high = middle
    return closest


def _first_weight(estimate: Array, information: Array, combine: Array, x: Array) -> float:
    """A weight with which the prior outweighs the data: data that pull from the start end Newton's
    steps at the edge of what is physical."""
    gap = combine @ x - estimate
    return max(_STRONGEST, float(gap @ information @ gap))


def closest(
    estimate: Array, information: Array, combine: Array, physical: Physical, any_size: bool
) -> tuple[float, Physical]:
    """The least sum of half the misfit and the penalty with a prior of weight 1, above that of the
    prior itself, and the conditions that it is of.

    any_size: whether bodies of the prior may be as much larger or smaller as suits the data, at no
    cost: an estimated shape tells proportions.
    """
    x = physical.start()
    weight = _first_weight(estimate, information, combine, x)
    while weight > 1.0:
        x = _newton(estimate, information, combine, physical, weight, x).x
        weight /= _FALL
    for _ in range(_SIZES if any_size else 1):
        x = _newton(estimate, information, combine, physical, 1.0, x).x
        found = _of_size(physical, x) if any_size else physical
        settled = np.allclose(found.bodies, physical.bodies, rtol=_SIZED)
        physical = found
        if settled:
            break
    gap = combine @ x - estimate
    above = physical.penalty(x, 1.0) - physical.penalty(physical.start(), 1.0)
    return 0.5 * float(gap @ information @ gap) + above, physical


def _of_size(physical: Physical, x: Array) -> Physical:
    """The conditions with bodies of the prior as large as suits those of x best: with lengths α
    times as large the divergence is A / α² + 2 B / α + 2 d log α and a constant."""
    inverse = np.linalg.inv(physical.pseudo_inertias(physical.start()))
    P, k = physical.pseudo_inertias(x), physical.lengths
    A = np.einsum("bij,bji->b", inverse[:, :k, :k], P[:, :k, :k])
    B = np.einsum("bij,bij->b", inverse[:, :k, k:], P[:, :k, k:])
    alpha = (B + np.sqrt(B**2 + 4.0 * k * A)) / (2.0 * k)
    bodies = physical.bodies.copy()
    first = 1 + physical.dim
    bodies[:, 1:first] *= alpha[:, None]
    bodies[:, first:] *= alpha[:, None] ** 2
    return replace(physical, bodies=bodies)


def _newton(
    estimate: Array,
    information: Array,
    combine: Array,
    physical: Physical,
    weight: float,
    start: Array,
) -> Fitted:
    """The physical unknowns that minimise half the misfit plus the weighted divergence."""
    of_data = combine.T @ information @ combine

    def misfit(x: Array) -> float:
        gap = combine @ x - estimate
        return float(gap @ information @ gap)

    def value(x: Array) -> float:
        return 0.5 * misfit(x) + physical.penalty(x, weight)

    x, now = start, value(start)
    for _ in range(_STEPS):
        try:
            by_prior, second = physical.slopes(x, weight)
        except np.linalg.LinAlgError:  # at the edge of what exists, to the last bit
            break
        gradient = combine.T @ (information @ (combine @ x - estimate)) + by_prior
        H = of_data + second
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        scaled = H / np.outer(size, size) + 1e-13 * np.eye(len(x))
        step = -np.linalg.solve(scaled, gradient / size) / size
        decrement = -gradient @ step
        if decrement < max(_SETTLED, _ROUNDED * abs(now)):
            break
        length, found = 1.0, np.inf
        while length > 1e-12:
            found = value(x + length * step)
            if found <= now - 1e-4 * length * decrement:
                break
            length *= 0.5
        else:
            break
        x, now = x + length * step, found
    return Fitted(x, weight, misfit(x))
