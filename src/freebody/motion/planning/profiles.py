"""How one axis gets from rest to rest: the quickest curves of each family under limits.

Trapezoid: constant acceleration, constant speed, constant deceleration; without the middle where
the way is short. S-curve: constant jerk, in up to seven phases (Biagiotti and Melchiorri,
Trajectory Planning for Automatic Machines and Robots, 2008, section 3.4). Quintic: rate and
acceleration zero at both ends, jerk least in the mean square (Flash and Hogan 1985).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import factorial, sqrt

import numpy as np

from freebody.motion.piecewise import PiecewisePolynomial

LIMITS = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Profile:
    """A family of rest-to-rest curves.

    needs: the limits without which nothing bounds its accelerations, or its jerk. quickest: the
    curve from 0 over a way > 0 under limits of velocity, acceleration, jerk, which may be infinite.
    """

    words: str
    needs: tuple[str, ...]
    quickest: Callable[[float, float, float, float], PiecewisePolynomial]


def _quintic(way: float, velocity: float, acceleration: float, jerk: float) -> PiecewisePolynomial:
    # largest rate 15/8, acceleration 10/√3 and jerk 60 of the way over the duration and its powers
    T = max(
        1.875 * way / velocity,
        sqrt(10.0 / sqrt(3.0) * way / acceleration),
        np.cbrt(60.0 * way / jerk),
    )
    powers = np.array([6.0 / T**5, -15.0 / T**4, 10.0 / T**3, 0.0, 0.0, 0.0])
    return PiecewisePolynomial(np.array([0.0, T]), way * powers[:, None, None])


def _trapezoid(
    way: float, velocity: float, acceleration: float, jerk: float
) -> PiecewisePolynomial:
    a = acceleration
    ramp = min(velocity / a, sqrt(way / a))
    cruise = max(way / (a * ramp) - ramp, 0.0)
    return _phases([(ramp, a), (cruise, 0.0), (ramp, -a)], order=2)


def _s_curve(way: float, velocity: float, acceleration: float, jerk: float) -> PiecewisePolynomial:
    j = jerk
    bend = np.cbrt(way / (2.0 * j))  # as if nothing but the jerk were limited
    v, a = min(velocity, j * bend**2), min(acceleration, j * bend)
    bend = min(a / j, sqrt(v / j))
    a = j * bend
    ramp = min(bend + v / a, 0.5 * bend + sqrt(0.25 * bend**2 + way / a))
    hold = max(ramp - 2.0 * bend, 0.0)
    cruise = max(way / (a * (bend + hold)) - 2.0 * bend - hold, 0.0)
    up = [(bend, j), (hold, 0.0), (bend, -j)]
    down = [(bend, -j), (hold, 0.0), (bend, j)]
    return _phases([*up, (cruise, 0.0), *down], order=3)


PROFILES = {
    "quintic": Profile("polynomials of degree 5", (), _quintic),
    "trapezoid": Profile("trapezoids of speed", ("acceleration",), _trapezoid),
    "s-curve": Profile("curves of limited jerk", ("jerk",), _s_curve),
}
"""By name."""


def _phases(phases: Sequence[tuple[float, float]], order: int) -> PiecewisePolynomial:
    """From 0 at rest: (duration, derivative of that order) in turn, those of no duration left
    out."""
    state = np.zeros(order)  # value, first derivative, …
    breaks, pieces = [0.0], []
    for duration, top in phases:
        if duration <= 1e-12 * breaks[-1]:
            continue
        powers = np.append(state, top) / [factorial(k) for k in range(order + 1)]
        p = np.polynomial.Polynomial(powers)
        pieces.append(powers[::-1])
        state = np.array([p.deriv(k)(duration) if k else p(duration) for k in range(order)])
        breaks.append(breaks[-1] + duration)
    return PiecewisePolynomial(np.array(breaks), np.array(pieces).T[:, :, None])
