"""`Log`: what a robot did and what its drives gave, on a uniform grid of times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.identification.filters import RATES, SETTLES, low_pass
from freebody.outputs.display import Tabled, TextTable, counted


class LogStates(NamedTuple):
    """Positions, rates and accelerations (n, joints) of a log, filtered alike."""

    q: Array
    qd: Array
    qdd: Array


@dataclass(frozen=True, eq=False, repr=False)
class Log(Tabled, ByValue):
    """Samples of a robot's joints on a uniform grid of times, as `fb.read_log` makes them.

    time: (n,) s, evenly spaced. position, velocity: (n, joints) rad, rad/s (m, m/s). torque:
    (n, joints) of the joints, N m (N), or None where only currents are known. current: (n, joints)
    of the motors, A, with unknown gains; or None.
    """

    time: Array
    position: Array
    velocity: Array
    torque: Array | None
    current: Array | None
    names: tuple[str, ...]
    """Names of the joints, of a model in its order."""
    measured: NDArray[np.bool_]
    """Flags (n,): whether there are samples around a time; elsewhere, such as in a gap, the values
    are lines between those that there are."""
    temperature: Array | None = None
    """Temperatures of the joints (n, joints), °C, or None."""
    rates_measured: bool = True
    """Whether the velocities are the file's; else they are differences of positions."""
    source: str = ""
    notices: tuple[str, ...] = ()
    """Sentences on what was wrong or doubtful in the file, and on what was made of it."""
    _aside = ("source", "notices")
    _copies = True

    @property
    def rate(self) -> float:
        """Samples a second, Hz."""
        return (len(self.time) - 1) / (self.time[-1] - self.time[0])

    def states(self, cutoff: float = RATES) -> LogStates:
        """Positions, rates and accelerations (n, joints): the log's, low-pass filtered at `cutoff`
        (Hz) without delay; accelerations are central differences of the filtered rates."""
        q, qd = (low_pass(x, self.rate, cutoff) for x in (self.position, self.velocity))
        return LogStates(q, qd, np.gradient(qd, 1.0 / self.rate, axis=0))

    def settled(self, margin: float = SETTLES) -> NDArray[np.bool_]:
        """Flags (n,): whether a time is `margin` (s) from both ends of the log and from every time
        that was not measured, so that no filter's transient reaches it."""
        reach = int(np.ceil(margin * self.rate - 1e-6))
        bad = np.concatenate([[True], ~self.measured, [True]])
        places = np.arange(len(bad))
        before = np.maximum.accumulate(np.where(bad, places, -len(bad)))
        after = np.minimum.accumulate(np.where(bad, places, 2 * len(bad))[::-1])[::-1]
        return (np.minimum(places - before, after - places) > reach)[1:-1]

    def _title(self) -> str:
        what = "torques" if self.torque is not None else "currents"
        return (
            f"Log: {counted(len(self.names), 'joint')}, {self.time[-1] - self.time[0]:.4g} s at "
            f"{self.rate:.4g} Hz, positions{', rates' if self.rates_measured else ''} and {what}"
        )

    def _table(self) -> TextTable:
        given = self.torque if self.torque is not None else self.current
        assert given is not None
        rows = [
            (
                name,
                f"{self.position[:, k].min():.4g} … {self.position[:, k].max():.4g}",
                f"{np.abs(self.velocity[:, k]).max():.4g}",
                f"{np.abs(given[:, k]).max():.4g}",
            )
            for k, name in enumerate(self.names)
        ]
        unit = "torque (N m, N)" if self.torque is not None else "current (A)"
        head = ("joint", "range (rad, m)", "largest rate (rad/s, m/s)", f"largest {unit}")
        return TextTable(head, rows, self.notices)
