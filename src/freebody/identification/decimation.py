"""The filter of regressions: fewer samples that hold all that is slower than the cutoff, of columns
and torque alike.

Butterworth's low pass run forward and back is a sum over a symmetric window; of its results only
those are computed that are kept, some 1.5 for each independent one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import sosfilt

from freebody.arrays import Array
from freebody.identification.filters import SETTLES, butterworth, require_cutoff

_NEGLIGIBLE = 1e-6
"""Part of its largest weight below which the filter's window ends, of columns and torques alike."""
_PER_INDEPENDENT = 1.5
"""Samples kept for each independent one (of which there are twice the cutoff a second)."""
_AT_ONCE, _IN_PRODUCT = 128, 16
"""Kept samples whose columns are in memory at once, and those that one product of matrices yields:
its matrix of weights is a band, and with fewer rows less of it is 0."""


@dataclass(frozen=True)
class Decimation:
    """A low pass without delay that keeps every step-th sample.

    window: weights (2 reach + 1,) of the samples around one. step: samples from one that is kept
    to the next. inflation: by which the variance of a mean of kept samples exceeds that of
    independent ones, where what is filtered was white.
    """

    window: Array
    step: int
    inflation: float

    @property
    def reach(self) -> int:
        """Samples on each side that a filtered one depends on."""
        return len(self.window) // 2

    def kept(self, settled: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Places of the samples that are kept, of those that the flags (n,) tell to be settled."""
        places = np.arange(self.reach, len(settled) - self.reach, self.step)
        return places[settled[places]]

    def filtered(
        self, places: NDArray[np.intp], columns: Callable[[slice], Array]
    ) -> Iterator[tuple[slice, Array]]:
        """(which of the places, filtered columns (k, c) there), part by part, `columns` being a
        function of a range of samples -> (samples, c)."""
        width, start = len(self.window), 0
        weights = np.zeros((_IN_PRODUCT, (_IN_PRODUCT - 1) * self.step + width))
        for k, row in enumerate(weights):
            row[k * self.step : k * self.step + width] = self.window
        while start < len(places):
            first = places[start]
            end = int(np.searchsorted(places, first + _AT_ONCE * self.step))
            x = columns(slice(first - self.reach, places[end - 1] + self.reach + 1))
            every = np.empty(((len(x) - width) // self.step + 1, x.shape[1]))
            for k in range(0, len(every), _IN_PRODUCT):
                out = every[k : k + _IN_PRODUCT]
                span = (len(out) - 1) * self.step + width
                part = x[k * self.step : k * self.step + span]
                np.matmul(weights[: len(out), :span], part, out=out)
            yield slice(start, end), every[(places[start:end] - first) // self.step]
            start = end


def decimation(rate: float, cutoff: float) -> Decimation:
    """The low pass at a cutoff (Hz) of samples at a rate (Hz). Raises FreebodyError where the
    cutoff is not below half the rate."""
    require_cutoff("identify", rate, cutoff)
    sections = butterworth(rate, cutoff)
    impulse = np.zeros(int(np.ceil(SETTLES * rate)))
    impulse[0] = 1.0
    forward = sosfilt(sections, impulse)
    window = np.correlate(forward, forward, "full")
    centre = len(window) // 2
    large = np.flatnonzero(np.abs(window) > _NEGLIGIBLE * window[centre])
    reach = centre - large[0]
    window = window[centre - reach : centre + reach + 1]
    window = window / window.sum()
    step = max(1, int(rate / (2.0 * cutoff * _PER_INDEPENDENT)))
    likeness = np.correlate(window, window, "full")[2 * reach :]
    inflation = 1.0 + 2.0 * likeness[step::step].sum() / likeness[0]
    return Decimation(window, step, float(inflation))
