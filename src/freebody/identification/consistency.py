"""From base values to the masses, inertias and frictions of a robot that can exist: Newton's method
on the fit of the data and a log-det prior.

A body exists if its pseudo-inertia, the matrix of second moments of its mass with first moments and
mass beside them, is positive definite (Wensing, Kim, Slotine 2018). The prior is the Bregman
divergence of -log det between pseudo-inertias (Lee, Wensing, Park 2020): it ties what the data
do not tell to the inertia that was given beforehand, by amounts that suit each direction's size, and it
is infinite where a body ceases to exist, so that no constraint is left to a solver.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array

_STEPS = 60
"""Most steps of Newton's method; it takes some ten."""
_SETTLED = 1e-10
"""Newton's decrement, in units of half a squared standard deviation, at which it ends."""
_WEAKEST, _STRONGEST = 1e-7, 1e2
"""Bounds of the prior's weight: with the least it is no more than the constraint that bodies exist."""
_HALVINGS = 24
"""Trials by which the prior's weight is found, to a fifth of its size."""


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
class Physical:
    """What is physical about unknowns x: bodies, one after the other, then scalars.

    basis: see `pseudo_inertia_basis`. bodies: (nb, k) their prior parameters. scalars: (ns,) prior
    values of what is positive, such as friction, or NaN for what has either sign. below: (ns,) upper
    bounds. of_masses: weight of what is held of masses alone, beside that of their distribution.
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
        return np.einsum("bk,kij->bij", x[: self.bodies.size].reshape(self.bodies.shape), self.basis)

    def divergence(self, x: Array) -> float:
        """The prior's divergence, infinite where something is not physical."""
        P, s = self.pseudo_inertias(x), x[self.bodies.size :]
        positive = ~np.isnan(self.scalars)
        if np.any(s[positive] <= 0.0) or np.any(s >= self.below):
            return np.inf
        try:
            roots = np.linalg.cholesky(P)
        except np.linalg.LinAlgError:
            return np.inf
        of_bodies = -2.0 * np.log(np.diagonal(roots, axis1=1, axis2=2)).sum()
        of_bodies += np.einsum("bij,bji->", self._prior, P)
        m = P[:, -1, -1] / self.bodies[:, 0]
        of_bodies += self.of_masses * (m - np.log(m)).sum()
        bounded = np.isfinite(self.below)
        of_scalars = (s[positive] / self.scalars[positive] - np.log(s[positive])).sum()
        of_scalars -= np.log(1.0 - s[bounded] / self.below[bounded]).sum()
        return float(of_bodies + of_scalars)

    @property
    def _prior(self) -> Array:
        return np.linalg.inv(self.pseudo_inertias(self.start()))

    def slopes(self, x: Array) -> tuple[Array, Array]:
        """Gradient and second derivatives of the divergence."""
        (nb, k), P = self.bodies.shape, self.pseudo_inertias(x)
        inverse = np.linalg.inv(P)
        gradient, second = np.zeros(len(x)), np.zeros((len(x), len(x)))
        gradient[: nb * k] = np.einsum("bij,kji->bk", self._prior - inverse, self.basis).ravel()
        half = np.einsum("bij,kjl->bkil", inverse, self.basis)
        blocks = np.einsum("bkil,bmli->bkm", half, half)
        for b in range(nb):
            second[b * k : (b + 1) * k, b * k : (b + 1) * k] = blocks[b]
        masses, m = np.arange(0, nb * k, k), P[:, -1, -1]
        gradient[masses] += self.of_masses * (1.0 / self.bodies[:, 0] - 1.0 / m)
        second[masses, masses] += self.of_masses / m**2
        s = x[nb * k :]
        positive, places = ~np.isnan(self.scalars), np.arange(nb * k, len(x))
        at = places[positive]
        gradient[at] = 1.0 / self.scalars[positive] - 1.0 / s[positive]
        second[at, at] = s[positive] ** -2.0
        bounded = np.isfinite(self.below)
        at, left = places[bounded], self.below[bounded] - s[bounded]
        gradient[at] += 1.0 / left
        second[at, at] += left**-2.0
        return gradient, second


@dataclass(frozen=True)
class Fitted:
    """Physical unknowns x with the prior's weight, and how far they are from the data: chi2, twice
    the misfit in units of the noise, above that of the unconstrained estimate."""

    x: Array
    weight: float
    chi2: float


def nearest_physical(
    estimate: Array, information: Array, combine: Array, physical: Physical, allowed: float
) -> Fitted:
    """Physical unknowns with the greatest weight of the prior that the data's noise allows.

    estimate: (b,) of regression, with information (b, b), the inverse of its covariance. combine:
    (b, x), of which physical unknowns the estimated are made. allowed: chi2 that fits the data as
    well as the estimate does, within its noise; it is added to what physics alone cost.
    """
    least = _newton(estimate, information, combine, physical, _WEAKEST, physical.start())
    allowed = allowed + least.chi2
    low, high, best = np.log(_WEAKEST), np.log(_STRONGEST), least
    strongest = _newton(estimate, information, combine, physical, _STRONGEST, physical.start())
    if strongest.chi2 <= allowed:
        return strongest
    while high - low > 0.2:
        middle = 0.5 * (low + high)
        tried = _newton(estimate, information, combine, physical, np.exp(middle), best.x)
        if tried.chi2 <= allowed:
            low, best = middle, tried
        else:
            high = middle
    return best


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
        return 0.5 * misfit(x) + weight * physical.divergence(x)

    x, now = start, value(start)
    for _ in range(_STEPS):
        by_prior, second = physical.slopes(x)
        gradient = combine.T @ (information @ (combine @ x - estimate)) + weight * by_prior
        H = of_data + weight * second
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        scaled = H / np.outer(size, size) + 1e-13 * np.eye(len(x))
        step = -np.linalg.solve(scaled, gradient / size) / size
        decrement = -gradient @ step
        if decrement < _SETTLED * max(1.0, weight):
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
