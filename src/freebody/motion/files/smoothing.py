"""Noise in samples, and a filter that takes it out without delay.

Noise is seen in divided differences: of a smooth curve the high ones all but vanish, of white noise
they do not, and scaled to unit length those of any order have its standard deviation. Samples whose
differences of orders 4 and 6 agree carry noise of that size.

The filter is the quintic smoothing spline, the curve s with the least Σ (x_k - s(t_k))² + λ ∫ s'''²
dt (Woltring 1986): of a frequency f it passes 1 / (1 + (f / cutoff)⁶), as a Butterworth filter of
order 3 run forwards and then backwards does, without its transients at the ends and at uneven times
as well. λ = 1 / (h (2π cutoff)⁶), h being the mean step. Unless a cutoff is given, it follows from
the residual analysis of Winter (Biomechanics and Motor Control of Human Movement, 3.4.4): the RMS
of what a filter takes out falls steeply with its cutoff while that is motion, then along a straight
line while it is noise; that line's value at 0 Hz is the noise, and the cutoff the one that takes
out as much.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.sparse import csr_array, diags_array

from freebody.arrays import Array

FEWEST = 30
"""Samples from which noise can be told."""

# of the 4th differences' size that the 6th ones have in noise; of smooth curves next to nothing
_WHITE = 0.5
_SMALL = 0.02  # of the range: what is rougher was sampled too coarsely and is no noise on a curve
_FINE = 2e-3
"""In rad, m or a second's: what is this small and this rough is no motion, whatever the range."""
_ROUNDING = 1e-12  # of the largest sample: what is smaller is the arithmetic's
_KNOTS = 10.0  # a period of the cutoff frequency
_NOISE = (0.15, 0.2, 0.25, 0.3)
"""Cutoffs, of the sampling rate, above which nothing but noise is looked for."""
_TRIED = 24  # cutoffs
_DEGREE = 5


def noise(t: Array, x: Array) -> Array:
    """Standard deviation (n,) of white noise in samples x (T, n) of smooth curves; 0 where none is
    recognised."""
    if len(t) < FEWEST:
        return np.zeros(x.shape[1])
    low, high = _spread(t, x, 5), _spread(t, x, 7)
    told = (high > _WHITE * low) & (high > _ROUNDING * np.abs(x).max(axis=0))
    return np.where(told & (high < max(_SMALL * float(np.ptp(x, axis=0).max()), _FINE)), high, 0.0)


def _spread(t: Array, x: Array, width: int) -> Array:
    """Robust standard deviation (n,) of the divided differences over `width` samples, scaled to
    unit length."""
    window = np.arange(len(t) - width + 1)[:, None] + np.arange(width)
    s = (t[window] - t[window[:, :1]]) / (t[window[:, -1:]] - t[window[:, :1]])
    gaps = s[:, :, None] - s[:, None, :] + np.eye(width)
    weights = 1.0 / gaps.prod(axis=-1)
    weights /= np.linalg.norm(weights, axis=-1, keepdims=True)
    found = np.abs(np.einsum("wk,wkn->wn", weights, x[window]))
    found[np.ptp(x[window], axis=1) == 0.0] = np.nan  # samples at rest, all alike, tell nothing
    told = ~np.isnan(found).all(axis=0)
    size = np.zeros(x.shape[1])
    size[told] = np.nanmedian(found[:, told], axis=0) / 0.6745  # of |normal deviates|
    return size


def best_cutoff(t: Array, x: Array, sigma: Array) -> float:
    """The cutoff (Hz) for samples x (T, n) with noise sigma (n,): the highest that any noisy column
    asks for."""
    noisy = x[:, sigma > 0.0]
    rate = (len(t) - 1) / (t[-1] - t[0])

    def rest(cutoff: float) -> Array:
        return np.sqrt(((noisy - smooth(t, noisy, cutoff)(t)) ** 2).mean(axis=0))

    high = np.array(_NOISE) * rate
    intercept = np.polynomial.polynomial.polyfit(high, np.array([rest(f) for f in high]), 1)[0]
    asking = np.ones(noisy.shape[1], dtype=bool)
    for cutoff in np.geomspace(min(2.0 / (t[-1] - t[0]), high[0]), high[0], _TRIED):
        asking &= rest(float(cutoff)) > intercept
        if not asking.any():
            return float(cutoff)
    return float(high[0])


def smooth(t: Array, x: Array, cutoff: float) -> BSpline:
    """The quintic smoothing spline of x (T, n) at the times t (T,); cutoff: Hz."""
    duration, step = t[-1] - t[0], (t[-1] - t[0]) / (len(t) - 1)
    intervals = int(np.ceil(duration / max(step, 1.0 / (_KNOTS * cutoff))))
    inner = np.linspace(t[0], t[-1], intervals + 1)
    knots = np.concatenate([np.full(_DEGREE, t[0]), inner, np.full(_DEGREE, t[-1])])
    basis = csr_array(BSpline.design_matrix(t, knots, _DEGREE))
    weight = 1.0 / (step * (2.0 * np.pi * cutoff) ** 6)
    normal = basis.T @ basis + weight * _roughness(knots, inner)
    bands = np.zeros((_DEGREE + 1, normal.shape[0]))
    for k in range(_DEGREE + 1):
        bands[_DEGREE - k, k:] = normal.diagonal(k)
    # as unit diagonals: coefficients at the ends differ much in size
    scale = 1.0 / np.sqrt(bands[_DEGREE])
    for k in range(_DEGREE + 1):
        bands[_DEGREE - k, k:] *= scale[k:] * scale[: len(scale) - k]
    middle = x.mean(axis=0)
    found = scale[:, None] * solveh_banded(bands, scale[:, None] * (basis.T @ (x - middle)))
    return BSpline(knots, found + middle, _DEGREE)


def _roughness(knots: Array, inner: Array) -> csr_array:
    """The matrix of ∫ s'''² dt in the spline's coefficients; the integrand is a quartic between
    knots."""
    derivative = csr_array(diags_array(np.ones(len(knots) - _DEGREE - 1)))
    at = knots
    for degree in range(_DEGREE, _DEGREE - 3, -1):
        n = len(at) - degree - 1
        rate = degree / (at[degree + 1 : degree + n] - at[1:n])
        step = diags_array([-rate, rate], offsets=[0, 1], shape=(n - 1, n))  # type: ignore[arg-type]  # scipy's stub knows one diagonal
        derivative = csr_array(step) @ derivative
        at = at[1:-1]
    points, weights = np.polynomial.legendre.leggauss(3)
    half, centre = 0.5 * np.diff(inner), 0.5 * (inner[1:] + inner[:-1])
    where = (centre[:, None] + half[:, None] * points).ravel()
    root = np.sqrt((half[:, None] * weights).ravel())
    thirds = (
        diags_array(root) @ csr_array(BSpline.design_matrix(where, at, _DEGREE - 3)) @ derivative
    )
    return csr_array(thirds.T @ thirds)
