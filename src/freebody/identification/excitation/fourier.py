"""Fourier motions from rest to rest: joints as finite Fourier series, linear in their coefficients
(Swevers, Ganseman, Tükel, de Schutter and van Brussel, IEEE Trans. Robotics and Automation 13(5),
1997), whose rates and accelerations vanish where the period begins and ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from freebody.arrays import Array
from freebody.lazy import Keeps, cached_property


class FourierStates(NamedTuple):
    """Positions, rates and accelerations of joints, or the functions of time they are made of."""

    q: Array
    qd: Array
    qdd: Array


@dataclass(frozen=True)
class FourierMotions(Keeps):
    """All motions of one period with so many harmonics that begin and end at rest.

    A joint's coefficients (size,) are its middle, and then amplitudes of rates: of those sums of
    cosines that vanish at both ends, and of those sums of sines whose slopes do.
    """

    duration: float
    harmonics: int

    @property
    def size(self) -> int:
        """The number of coefficients of a joint."""
        return 2 * self.harmonics - 1

    @cached_property
    def _mixed(self) -> tuple[Array, Array]:
        """Mixtures of the harmonics (harmonics, harmonics - 1): of cosines with sum zero, of sines
        with slope zero at both ends."""
        k = np.arange(1.0, self.harmonics + 1.0)
        return null_space(np.ones((1, self.harmonics))), null_space(k[None, :])

    def functions(self, t: Array) -> FourierStates:
        """The functions (n, size) that the coefficients multiply, at times t (n,)."""
        w = 2.0 * np.pi / self.duration * np.arange(1, self.harmonics + 1)
        sine, cosine = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        of_cosines, of_sines = self._mixed
        still = np.zeros((len(t), 1))
        return FourierStates(
            np.hstack([still + 1.0, sine / w @ of_cosines, -cosine / w @ of_sines]),
            np.hstack([still, cosine @ of_cosines, sine @ of_sines]),
            np.hstack([still, -sine * w @ of_cosines, cosine * w @ of_sines]),
        )

    def states(self, t: Array, coefficients: Array) -> FourierStates:
        """The states (n, joints) of coefficients (size, joints) at times t (n,)."""
        return FourierStates(*(x @ coefficients for x in self.functions(t)))
