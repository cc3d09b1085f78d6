"""What a study finds besides time series: checks, worst instant, worst pose, singularities, the replay."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.arrays import Array


@dataclass(frozen=True)
class Check:
    """One comparison that must come out small: passed when `value` <= `bar`."""

    name: str
    value: float
    bar: float
    passed: bool
    text: str
    """What was compared, relative to what, in one sentence."""


@dataclass(frozen=True)
class Worst:
    """The instant at which the drives are loaded most."""

    index: int
    """Sample of `Study.data`."""
    time: float
    coordinate: str
    value: float
    """The torque (N m) or force (N) then."""
    fraction: float
    """|value| over the effort limit; NaN without limits."""
    unit: str
    text: str
    """Which coordinate, when, and why this instant."""


@dataclass(frozen=True)
class StaticPose:
    """The pose, among those within the limits, at which gravity loads a coordinate most."""

    coordinate: str
    q: Array
    """(nq,)."""
    torque: float
    """Gravity torque or force of the coordinate there, with its sign."""
    unit: str
    fraction: float
    """|torque| over the effort limit; NaN without a limit."""


@dataclass(frozen=True)
class Singularity:
    """Where along the motion the tip's Jacobian is nearest to losing rank."""

    index: int
    time: float
    smallest: float
    """Least singular value of the scaled Jacobian (1/rad)."""
    largest: float
    """Largest singular value at the same instant."""
    rows: str
    """Which rows of the Jacobian are counted: "position", or "position and orientation"."""
    length: float
    """Characteristic length (m) that linear rows are divided by."""
    text: str


@dataclass(frozen=True)
class Replay:
    """The torques of the motion drive the model; does it follow?

    In pieces, each restarted on the reference and short enough that the linearised dynamics amplify an error by at most
    `bound`; and once open loop from the start to the end.
    """

    edges: Array
    """(pieces + 1,) times at which pieces start and end (s)."""
    factors: Array
    """(pieces,) how much the linearised dynamics amplify an error within each piece, at most."""
    misses: Array
    """(pieces,) largest distance from the reference at the piece's end, over the joint range."""
    bound: float
    method: str
    """Integrator."""
    drift_time: Array
    """(k,) times of the open-loop run (s); it may stop early, see `text`."""
    drift: Array
    """(k, nv) distance from the reference, open loop (rad, m)."""
    amplification: float
    """Decimal logarithm of the factor by which the linearised dynamics amplify an error over the whole motion."""
    friction_width: float
    """Rate (rad/s, m/s) over which Coulomb friction is smoothed, c tanh(q̇ / width), in torque and model; 0: none."""
    text: str
    """What happened, and what the drift comes from."""

    @property
    def longest(self) -> float:
        """Length (s) of the longest piece."""
        return float((self.edges[1:] - self.edges[:-1]).max())
