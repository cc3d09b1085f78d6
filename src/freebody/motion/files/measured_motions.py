"""Measured motions: whether noise makes their accelerations meaningless, and the motion without
it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.special import beta

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.model.model import Model
from freebody.motion.closed_chain_motion import completed
from freebody.motion.files.contradictions import GivenRates
from freebody.motion.files.smoothing import best_cutoff, noise, smooth
from freebody.motion.motion import Motion, derivatives
from freebody.motion.ranges import Flags, angular
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import continuous, state_of

REST = 1e-6
"""Of the fastest rate of its kind (turning, sliding): what is slower is at rest."""
LOUD = 0.05
"""Noise in an acceleration, as RMS over the largest acceleration of the motion, from which it is
worth a word."""
_STILL = 3.0  # standard deviations of a rate's noise that are rest
_GENTLE = 1e-2  # rad/s², m/s²: what a noise is held against where nothing accelerates more
ROUNDED = 64.0 * float(
    np.finfo(float).eps
)  # of the largest position, over a step: a rate that is rounding


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise in the samples that a motion's accelerations were differentiated from."""

    of: str
    """ "positions" or "rates"."""
    sigma: float
    """Standard deviation of the loudest coordinate: rad or m, of rates by s."""
    name: str
    """That coordinate."""
    acceleration: float
    """RMS of the noise in its acceleration, rad/s² or m/s²."""
    share: float
    """The same over the largest acceleration of the smoothed motion."""
    cutoff: float
    """Hz: where `smoothed` would cut."""
    text: str
    """A sentence."""


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
    """The noise of a motion whose accelerations mean little because of it; None where they do."""
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


def _amplified(motion: Motion) -> float:
    """RMS that white noise of unit size has in the accelerations, measured on some; of positions or
    of rates."""
    white = np.random.default_rng(0).normal(size=(len(motion.t), 8))
    found = derivatives(motion.t, white)[0 if motion.differentiated == "rates" else 1]
    return float(np.sqrt((found**2).mean()))


def along_rates(t: Array, q: Array, rates: Array) -> Array:
    """Positions (T, n) with noise, which most of the rates (T, n) do not explain, brought in line
    with these; without noise as they are.

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


def rested(
    model: Model, motion: Motion, speed: Array | float = 0.0, given: Flags | bool = False
) -> Motion:
    """The motion in which a coordinate slower than `speed`, or than a millionth of the fastest of
    its kind, is at rest; where its rate was `given` (nv,), only what is rounding is rest.

    A rate of 1e-14, such as differentiation leaves, would feel the whole Coulomb friction. Where
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


def _rate_noise(motion: Motion, samples: Array, cutoff: float) -> Array | float:
    """Standard deviation (nv,) of the noise that smoothing leaves in the rates; 0 with quaternions,
    which feel no friction."""
    if not motion.layout.flat:
        return 0.0
    sigma, step = noise(motion.t, samples), motion.duration / (len(motion.t) - 1)
    # ∫ H² df and ∫ (2π f)² H² df of H = 1 / (1 + (f / cutoff)⁶), twice: of both signs of f
    power = 2.0 * cutoff * step * _integral(0)
    if motion.differentiated != "rates":
        power *= (2.0 * np.pi * cutoff) ** 2 * _integral(2) / _integral(0)
    return sigma * np.sqrt(power)


def _integral(k: int) -> float:
    """∫ x^k / (1 + x⁶)² dx over x > 0: (1/6) B((k + 1)/6, 2 - (k + 1)/6)."""
    return float(beta((k + 1) / 6, 2.0 - (k + 1) / 6)) / 6.0


def _samples(motion: Motion) -> Array:
    """What the accelerations were differentiated from."""
    if motion.differentiated == "rates":
        return motion.qd
    return continuous(motion.layout, motion.q)
