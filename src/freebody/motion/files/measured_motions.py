"""Measured motions: whether noise makes their accelerations meaningless, and a filter that removes
noise without delay.

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

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.linalg import solveh_banded
from scipy.sparse import csr_array, diags_array
from scipy.special import beta

from freebody.arrays import Array
from freebody.errors import FreebodyError, require_kind
from freebody.model.model import Model
from freebody.motion.closed_chain_motion import completed
from freebody.motion.files.contradictions import GivenRates
from freebody.motion.motion import Motion, derivatives
from freebody.motion.ranges import Flags, angular
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import continuous, state_of

REST = 1e-6
"""Rate below which a coordinate is at rest, as a part of the fastest of its kind (turning,
sliding)."""
LOUD = 0.05
"""Noise in an acceleration, as RMS over the largest acceleration of the motion, from which it is
worth a word."""
_STILL = 3.0  # standard deviations of a rate's noise that are rest
_GENTLE = 1e-2  # rad/s², m/s²: what a noise is held against where nothing accelerates more
ROUNDED = 64.0 * float(
    np.finfo(float).eps
)  # of the largest position, over a step: a rate that is rounding
_FEWEST = 30
"""The number of samples from which noise can be recognised."""
# of the 4th differences' size that the 6th ones have in noise; of smooth curves next to nothing
_WHITE = 0.5
_SMALL = 0.02  # of the range: what is rougher was sampled too coarsely and is no noise on a curve
_FINE = 2e-3
"""Noise (rad or m, of rates by s) that is none of the motion, whatever the range."""
_ROUNDING = 1e-12  # of the largest sample: what is smaller is the arithmetic's
_KNOTS = 10.0  # a period of the cutoff frequency
_NOISE = (0.15, 0.2, 0.25, 0.3)
"""Cutoffs, of the sampling rate, above which nothing but noise is looked for."""
_TRIED = 24  # cutoffs
_DEGREE = 5


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise in the samples that a motion's accelerations were differentiated from."""

    of: str
    """The noisy samples: "positions" or "rates"."""
    sigma: float
    """Standard deviation of the loudest coordinate: rad or m, of rates by s."""
    name: str
    """Name of the loudest coordinate."""
    acceleration: float
    """RMS of the noise in its acceleration, rad/s² or m/s²."""
    share: float
    """RMS of the noise in its acceleration over the largest acceleration of the smoothed motion."""
    cutoff: float
    """The frequency (Hz) at which `smoothed` would cut."""
    text: str
    """A sentence about the noise."""

    @property
    def counted(self) -> str:
        """Sentences for a result in which the noise counts: what it is, and what takes it out."""
        return (
            f"{self.text} It counts as torque here; --smooth auto (fb.smoothed) takes it out, at "
            f"{self.cutoff:.3g} Hz."
        )


def smoothed(model: Model, motion: Motion, cutoff: float | None = None) -> Motion:
    """The motion low-pass filtered at `cutoff` (Hz), without delay: for measured positions or
    rates.

    The filter is the quintic smoothing spline: of a frequency f it passes 1 / (1 + (f / cutoff)⁶),
    the zero-phase Butterworth filter of order 3. It acts on the positions; where rates were given,
    on the rates, which positions then follow. cutoff: default by the residual analysis of Winter.
    Of a closed chain the positions of the driven joints are smoothed and the loops determine the
    others. A rate within three standard deviations of the noise left in it is rest. Raises
    FreebodyError where no noise is found and no cutoff given.
    """
    require_kind("smoothed", "motion", motion, Motion, "a Motion")
    samples = _samples(motion)
    chosen = cutoff
    if chosen is None:
        sigma = noise(motion.t, samples)
        if not motion.differentiated or not sigma.any():
            raise FreebodyError(
                "smoothed: no noise was found in the motion from which to choose a cutoff; give "
                "one (Hz), or leave the motion as it is."
            )
        chosen = best_cutoff(motion.t, samples, sigma)
    highest = 0.5 * (len(motion.t) - 1) / motion.duration
    if not 0.0 < chosen < highest:
        given, most = compared(chosen, highest)
        raise FreebodyError(
            f"smoothed: the cutoff is {given} Hz, expected more than 0 and less than half the "
            f"sampling rate, {most} Hz."
        )
    source = f"{motion.source}; smoothed: {chosen:.3g} Hz, without delay"
    curve = smooth(motion.t, samples, chosen)
    if model.loops:
        by_rates = motion.differentiated == "rates"
        q = smooth(motion.t, motion.q, chosen)(motion.t) if by_rates else curve(motion.t)
        of_drives = {}
        for name in set(model.driven_names) & set(model.position_names):
            of_drives[name] = q[:, model.position_names.index(name)]
            if by_rates:
                k = model.velocity_names.index(name)
                of_drives[f"{name}.v"] = curve(motion.t)[:, k]
                of_drives[f"{name}.a"] = curve.derivative()(motion.t)[:, k]
        clean = completed(model, motion.t, of_drives, source)
    else:
        if motion.differentiated == "rates":
            q = smooth(motion.t, motion.q, chosen)(motion.t)
            states = q, curve(motion.t), curve.derivative()(motion.t)
        else:
            x = curve(motion.t), curve.derivative()(motion.t), curve.derivative(2)(motion.t)
            states = state_of(motion.layout, *x)
        clean = replace(motion, q=states[0], qd=states[1], qdd=states[2], pieces=None)
    clean = replace(clean, source=source, notices=motion.notices, differentiated="")
    return rested(model, clean, _STILL * _rate_noise(motion, samples, chosen))


def recognised(model: Model, motion: Motion) -> Noise | None:
    """The noise of a motion that makes its accelerations meaningless; None where it does not."""
    if not motion.differentiated:
        return None
    samples = _samples(motion)
    sigma = noise(motion.t, samples)
    if not sigma.any():
        return None
    cutoff = best_cutoff(motion.t, samples, sigma)
    clean = smoothed(model, motion, cutoff)
    # what the filter takes away may be a vibration, or a corner of the path: no more than such
    # noise explains counts
    rms = np.sqrt(((motion.qdd - clean.qdd) ** 2).mean(axis=0))
    rms = np.minimum(rms, _amplified(motion) * (sigma if motion.layout.flat else 2.0 * sigma.max()))
    turns = angular(model)
    largest = np.abs(clean.qdd).max(axis=0)
    scale = np.array([max(largest[turns == kind].max(), _GENTLE) for kind in turns])
    k = int(np.argmax(rms / scale))
    share = float(rms[k] / scale[k])
    if share < LOUD:
        return None
    of, unit = motion.differentiated, "rad" if turns[k] else "m"
    size = float(sigma[k]) if motion.layout.flat else float(sigma.max())
    text = (
        f"The {of} carry noise (about {size:.2g} {unit}{'/s' if of == 'rates' else ''}), which "
        f"differentiated gives "
        f"{model.velocity_names[k]} {rms[k]:.2g} {unit}/s² RMS of spurious acceleration, "
        f"{f'{100 * share:.0f} % of the largest' if share < 10.0 else 'far above any'} of the "
        f"motion."
    )
    return Noise(of, size, model.velocity_names[k], float(rms[k]), share, cutoff, text)


def loudest(model: Model, motions: Iterable[Motion]) -> Noise | None:
    """The noise of the motion whose accelerations it spoils most; None where it spoils none."""
    found = [noise for motion in motions if (noise := recognised(model, motion))]
    return max(found, key=lambda noise: noise.share, default=None)


def rested(
    model: Model, motion: Motion, speed: Array | float = 0.0, given: Flags | bool = False
) -> Motion:
    """The motion with coordinates set to rest where they are slower than `speed`, or than a
    millionth of the fastest of their kind; where a rate was `given` (nv,), only where it is
    rounding.

    A rate of 1e-14, such as differentiation leaves, would feel the whole dry friction. Where
    nothing moves, what the rounding of the positions leaves is rest, and in a coordinate that rests
    all along no acceleration either. Of a closed chain all coordinates are at rest, or none is.
    """
    turns, size = angular(model), np.abs(motion.qd)
    fastest = np.array([size[:, turns == kind].max() for kind in turns])
    position = ROUNDED * float(np.abs(motion.q).max(initial=0.0))
    shortest, mean = float(np.diff(motion.t).min()), motion.duration / (len(motion.t) - 1)
    rest = size <= np.maximum(speed, np.where(given, ROUNDED, REST) * fastest)
    if model.loops:  # one rate alone that is made zero would open a loop
        rest &= rest.all(axis=1, keepdims=True)
    # samples of a planned motion may be next to each other; what is given there is not rounding
    rest |= size <= np.where(given, position / mean, position / shortest)
    still = 8.0 * position / shortest**2
    none = rest.all(axis=0) & (np.abs(motion.qdd).max(axis=0) <= still)
    return replace(motion, qd=np.where(rest, 0.0, motion.qd), qdd=np.where(none, 0.0, motion.qdd))


def along_rates(t: Array, q: Array, rates: Array) -> Array:
    """Positions (T, n), adjusted to the given rates (T, n) where they have noise that most of the
    rates do not show; without noise as they are.

    The rates are integrated, and the slow difference from the positions is added: what remains of
    it at the cutoff that its noise asks for.
    """
    spline = make_interp_spline(t, rates, k=5 if len(t) >= 6 else 3)
    travelled = spline.antiderivative()(t)
    sigma = noise(t, q)
    given = GivenRates.of(t, np.diff(q, axis=0), np.abs(q).max(), rates[:-1], rates[1:])
    loud = np.median(given.unexplained, axis=0) > 0.0
    positions, noisy = q.copy(), (sigma > 0.0) & loud
    if noisy.any():
        off = (q - travelled)[:, noisy]
        slow = smooth(t, off, best_cutoff(t, off, sigma[noisy]))
        positions[:, noisy] = travelled[:, noisy] + slow(t)
    return positions


def _samples(motion: Motion) -> Array:
    """The samples from which the motion's accelerations were differentiated: rates or positions."""
    if motion.differentiated == "rates":
        return motion.qd
    return continuous(motion.layout, motion.q)


def _rate_noise(motion: Motion, samples: Array, cutoff: float) -> Array | float:
    """Standard deviation (nv,) of the noise that smoothing leaves in the rates; 0 for joints with
    quaternions, which have no friction."""
    if not motion.layout.flat:
        return 0.0
    sigma, step = noise(motion.t, samples), motion.duration / (len(motion.t) - 1)
    # ∫ H² df and ∫ (2π f)² H² df of H = 1 / (1 + (f / cutoff)⁶), twice: of both signs of f
    power = 2.0 * cutoff * step * _integral(0)
    if motion.differentiated != "rates":
        power *= (2.0 * np.pi * cutoff) ** 2 * _integral(2) / _integral(0)
    return sigma * np.sqrt(power)


def _integral(k: int) -> float:
    """The integral ∫ x^k / (1 + x⁶)² dx over x > 0: (1/6) B((k + 1)/6, 2 - (k + 1)/6)."""
    return float(beta((k + 1) / 6, 2.0 - (k + 1) / 6)) / 6.0


def _amplified(motion: Motion) -> float:
    """The RMS of accelerations differentiated from white noise of unit size in the motion's
    positions or rates, measured on a sample."""
    white = np.random.default_rng(0).normal(size=(len(motion.t), 8))
    found = derivatives(motion.t, white)[0 if motion.differentiated == "rates" else 1]
    return float(np.sqrt((found**2).mean()))


def noise(t: Array, x: Array) -> Array:
    """Standard deviation (n,) of white noise in samples x (T, n) of smooth curves; 0 where none is
    recognised."""
    if len(t) < _FEWEST:
        return np.zeros(x.shape[1])
    low, high = _spread(t, x, 5), _spread(t, x, 7)
    found = (high > _WHITE * low) & (high > _ROUNDING * np.abs(x).max(axis=0))
    return np.where(found & (high < max(_SMALL * float(np.ptp(x, axis=0).max()), _FINE)), high, 0.0)


def _spread(t: Array, x: Array, width: int) -> Array:
    """Robust standard deviation (n,) of the divided differences over `width` samples, scaled to
    unit weight."""
    window = np.arange(len(t) - width + 1)[:, None] + np.arange(width)
    s = (t[window] - t[window[:, :1]]) / (t[window[:, -1:]] - t[window[:, :1]])
    gaps = s[:, :, None] - s[:, None, :] + np.eye(width)
    weights = 1.0 / gaps.prod(axis=-1)
    weights /= np.linalg.norm(weights, axis=-1, keepdims=True)
    found = np.abs(np.einsum("wk,wkn->wn", weights, x[window]))
    found[np.ptp(x[window], axis=1) == 0.0] = np.nan  # samples at rest, all alike, tell nothing
    moving = ~np.isnan(found).all(axis=0)
    size = np.zeros(x.shape[1])
    size[moving] = np.nanmedian(found[:, moving], axis=0) / 0.6745  # of |normal deviates|
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
