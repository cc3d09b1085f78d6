"""The one filter of identification, Butterworth's low pass run forward and then back: no delay, and
the same for whatever is compared with each other.

A regression that filters its columns as it filters the torque stays linear and unbiased, and its
residual has the filter's bandwidth: of fs samples a second only 2 fc are independent.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.signal import butter, sosfiltfilt

from freebody.arrays import Array, above_zero
from freebody.errors import FreebodyError
from freebody.outputs.number_text import compared

ORDER = 4
"""The order of the filter in each direction: a frequency f passes as 1 / (1 + (f / cutoff)⁸)."""
RATES, EVERYTHING = 25.0, 8.0
"""Cutoffs (Hz) of the rates from which columns are built, and then of columns and torque alike."""
SETTLES = 1.0
"""Time (s) at the ends of a log, and on both sides of a gap, that the filter's transients reach."""


def low_pass(x: Array, rate: float, cutoff: float) -> Array:
    """Samples x (n, ...) at `rate` (Hz) without what is faster than `cutoff` (Hz), without delay.

    Butterworth's filter of order 4, forward and back over the first axis; the ends are continued by
    reflection. Raises FreebodyError where the cutoff is not below half the rate, or the samples are
    too few for one period of it.
    """
    require_cutoff("low_pass", above_zero("low_pass", "rate", rate, "Hz"), cutoff)
    reflected = int(np.ceil(rate / cutoff)) + 3 * ORDER
    if len(x) <= reflected:
        raise FreebodyError(
            f"low_pass: {len(x)} samples at {rate:.4g} Hz are too few for a filter at "
            f"{cutoff:.4g} Hz; it needs {reflected + 1}."
        )
    return np.asarray(sosfiltfilt(butterworth(rate, cutoff), x, axis=0, padlen=reflected))


@lru_cache(maxsize=16)
def butterworth(rate: float, cutoff: float) -> tuple[tuple[float, ...], ...]:
    """The sections of second order of which the low pass at `cutoff` (Hz) of samples at `rate` (Hz)
    consists."""
    return tuple(map(tuple, np.asarray(butter(ORDER, cutoff, fs=rate, output="sos")).tolist()))


def require_cutoff(function: str, rate: float, cutoff: float) -> None:
    """Raises FreebodyError for a cutoff (Hz) that samples at this rate (Hz) do not have."""
    if not 0.0 < cutoff < 0.5 * rate:
        given, most = compared(cutoff, 0.5 * rate)
        raise FreebodyError(
            f"{function}: the cutoff is {given} Hz, expected more than 0 and less than half the "
            f"sampling rate, {most} Hz."
        )
