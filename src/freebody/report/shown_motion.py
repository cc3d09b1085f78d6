"""The instants at which a study's page shows its motion: samples evenly apart, and those of which
the verdict tells, between samples too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array

if TYPE_CHECKING:
    from freebody.report.study import Study

MOST = 600
"""Instants at which a page shows a motion; of longer ones every second sample, or fewer."""
_NEAR = 1e-9  # of the duration: times that are one


@dataclass(frozen=True)
class ShownMotion:
    """A motion at n instants, and the torques of its study there."""

    samples: Array
    """Times (T,) of all samples of the study."""
    t: Array
    """Times (n,), s."""
    q: Array
    qd: Array
    qdd: Array
    """The state there: (n, nq), (n, nv), (n, nv)."""
    tau: Array
    """Torques (n, nv) there."""
    between: NDArray[np.intp]
    """Numbers of the instants that are no samples."""

    @property
    def whole(self) -> bool:
        """Whether all samples are shown."""
        return len(self.t) - len(self.between) == len(self.samples)

    def index(self, time: float) -> int:
        """The number of the instant that is nearest to a time."""
        return int(np.argmin(np.abs(self.t - time)))


def shown_motion(study: Study, times: Sequence[float], samples: Sequence[int]) -> ShownMotion:
    """The motion of a study at some times and samples of their own, and at others evenly apart.

    The loops of a closed chain are closed at samples only, so that the nearest is shown there.
    """
    motion, tau = study.motion, study.data["tau"].values
    t = motion.t
    nearest = [int(np.argmin(np.abs(t - time))) for time in times]
    off = np.array([time for time, k in zip(times, nearest, strict=True) if _apart(time, t, k)])
    if study.model.loops:
        off = np.empty(0)
    even = np.linspace(0, len(t) - 1, min(len(t), MOST)).round().astype(int).tolist()
    own = [k for time, k in zip(times, nearest, strict=True) if time not in off]
    kept = np.unique(np.array([*even, *own, *samples], dtype=np.intp))
    if not len(off):
        q, qd, qdd, own_tau = (x[kept] for x in (motion.q, motion.qd, motion.qdd, tau))
        return ShownMotion(t, t[kept], q, qd, qdd, own_tau, np.empty(0, dtype=np.intp))
    off = np.unique(off)
    states = motion.at(off)
    torques = inverse_dynamics(study.model, *states, study.wrenches)
    every = np.concatenate([t[kept], off])
    order = np.argsort(every, kind="stable")
    pairs = zip((motion.q, motion.qd, motion.qdd, tau), (*states, torques), strict=True)
    q, qd, qdd, own_tau = (np.concatenate([one[kept], found])[order] for one, found in pairs)
    between = np.flatnonzero(order >= len(kept))
    return ShownMotion(t, every[order], q, qd, qdd, own_tau, between)


def _apart(time: float, t: Array, k: int) -> bool:
    """Whether a time is not that of its nearest sample, number k."""
    return abs(float(t[k]) - time) > _NEAR * float(t[-1] - t[0])
