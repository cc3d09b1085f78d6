"""The search for a motion that tells the most within limits: Fourier motions by gradients.

The determinant of the information M is made large (D-optimality: no scaling of parameters
matters), then the largest variance of a base parameter small. M is a sum over times, so the slope
of either criterion is one of a sum of functions of one state each, φ = tr(W Y S Yᵀ), with the same
matrix S for all: M⁻¹ for log det M, M⁻¹ D M⁻¹ for variances weighted by D. These slopes are taken
by central differences, all states side by side in one call of a kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.excitation.fourier import FourierMotions, FourierStates
from freebody.identification.excitation.information import MotionInformation, criterion
from freebody.identification.excitation.motion_limits import WITHIN, MotionLimits
from freebody.lazy import Keeps, cached_property

_PER_CYCLE = 16
"""Samples in a period of the highest harmonic at which a motion is judged while it is sought."""
_STEP = 1e-6  # rad, m, s: of central differences
_POSTURES, _STARTS = 2000, 20
"""Postures drawn as middles, and random motions of which the best is where the search begins."""


class _Stage(NamedTuple):
    """A part of the search: the weight of limits, that of the largest variance (else the
    determinant), and the most steps."""

    weight: float
    worst: bool
    steps: int


_STAGES = (
    _Stage(30.0, False, 60),
    _Stage(300.0, False, 30),
    _Stage(300.0, True, 60),
    _Stage(3000.0, True, 30),
)


@dataclass(frozen=True)
class MotionSearch(Keeps):
    """A search among Fourier motions, whose log has `rate` samples a second."""

    motions: FourierMotions
    information: MotionInformation
    limits: MotionLimits
    rate: float

    def found(self, rng: np.random.Generator) -> Array:
        """The coefficients (joints, size) of a motion that tells much and keeps the limits."""
        x = self._start(rng)
        for stage in _STAGES:
            found = minimize(
                self._cost, x.ravel(), (stage,), jac=True, method="L-BFGS-B",
                options={"maxiter": stage.steps},
            )  # fmt: skip
            x = found.x.reshape(x.shape)
        return self._within(x)

    @cached_property
    def _functions(self) -> FourierStates:
        """The functions (n, size) of the times at which motions are judged."""
        count = _PER_CYCLE * self.motions.harmonics
        times = np.arange(count, dtype=np.float64) * (self.motions.duration / count)
        return self.motions.functions(times)

    def _cost(self, flat: Array, stage: _Stage) -> tuple[float, Array]:
        """The criterion with the cost of limits, and its slope by the coefficients."""
        x, samples = flat.reshape(-1, self.motions.size).T, len(self._functions.q)
        states = FourierStates(*(f @ x for f in self._functions))
        scale = self.rate * self.motions.duration / samples
        M = scale * self.information.matrix(states)
        value, S = criterion(M, self.information.base, stage.worst)
        weight = stage.weight / samples

        def of_each(moved: FourierStates) -> Array:
            told = self.information.by_slopes(moved, S)
            return weight * self.limits.excess(moved) - scale * told

        slopes = _slopes(of_each, states)
        by_x = sum(g.T @ f for g, f in zip(slopes, self._functions, strict=True))
        cost = weight * float(self.limits.excess(states).sum())
        return value + cost, np.asarray(by_x).ravel()

    def _start(self, rng: np.random.Generator) -> Array:
        """The best of some random motions within the limits, (joints, size)."""
        middles, used = self.limits.postures(_POSTURES, rng)
        best: tuple[float, Array] | None = None
        for middle in middles[np.argsort(used)[: _STARTS * 5 : 5]]:
            x = np.vstack([middle, rng.normal(size=(self.motions.size - 1, len(middle)))])
            x = self._within(x.T, WITHIN)
            cost = self._cost(x.ravel(), _STAGES[0])[0]
            if best is None or cost < best[0]:
                best = cost, x
        assert best is not None
        return best[1]

    def _within(self, x: Array, most: float = 1.0 - 1e-3) -> Array:
        """The coefficients (joints, size) with so much smaller amplitudes that all limits are kept
        at a hundred times for each of the search."""
        count = 100 * self.motions.harmonics
        t = np.arange(count + 1, dtype=np.float64) * (self.motions.duration / count)
        x = x.copy()
        for _ in range(200):
            states = self.motions.states(t, x.T)
            if float(self.limits.used(states).max()) <= most:
                return x
            rates = self.limits.of_rates(states)
            x[:, 1:] *= max(0.5, most / rates) if rates > most else 0.98
        raise FreebodyError("excitation: no motion keeps the limits; widen them.")


def _slopes(of_each: Callable[[FourierStates], Array], states: FourierStates) -> list[Array]:
    """Slopes (n, nv) by positions, rates and accelerations of a function of states, by central
    differences, all at once."""
    nv = states.q.shape[1]
    moves = np.concatenate([np.eye(3 * nv), -np.eye(3 * nv)]).reshape(6 * nv, 1, 3, nv) * _STEP
    moved = FourierStates(*(x + moves[:, :, k] for k, x in enumerate(states)))
    forward, back = of_each(moved).reshape(2, 3, nv, -1)
    return [x.T for x in (forward - back) / (2.0 * _STEP)]
