"""Findings of a study besides time series: checks, worst instant, worst pose, singularities,
replay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from freebody.arrays import Array
from freebody.capacity.time_scaling import Pace
from freebody.model.doubts import Doubt
from freebody.motion.ranges import CLOSE
from freebody.outputs.display import Tabled, TextTable, Titled, counted
from freebody.outputs.number_text import compared, percent

VerdictOutcome = Literal["feasible", "not feasible", "not judged"]


@dataclass(frozen=True)
class LimitUse:
    """The fraction of one limit that a motion uses."""

    quantity: str
    """position, speed, torque, force, RMS torque, RMS force, or power; of a brake brake torque or
    brake force, of a bearing static load or tilting moment."""
    coordinate: str
    value: float
    """The value at which the motion comes nearest to the limit, or goes farthest beyond it."""
    limit: float
    fraction: float
    """The value as a share of the limit; of a position, from the middle of the range: 1 at its
    ends."""
    time: float
    """Time of that value (s); NaN for a mean over the motion."""
    unit: str
    end: Literal["", "lower", "upper"] = ""
    """The end of a range that is meant; empty where there is only one limit."""
    segment: int = 0
    """The segment of a duty cycle, from 1; 0 where there is none."""

    @property
    def exceeded(self) -> bool:
        """Whether the value is beyond the limit; a value equal to the limit is within."""
        return self.fraction > 1.0 + CLOSE

    @property
    def text(self) -> str:
        """The use of the limit as a phrase: what, how much, when, where."""
        when = instant(self.time, self.segment)
        value, limit = self.in_print()
        if self.quantity == "position":
            way = "beyond its" if self.exceeded else "its"
            return (
                f"{self.coordinate} goes to {value} {self.unit}{when}, {way} {self.end} limit "
                f"{'' if self.exceeded else 'being '}{limit} {self.unit}"
            )
        return (
            f"the {self.quantity} of {self.coordinate} is {value.lstrip('-')} {self.unit}{when}, "
            f"{percent(self.fraction)} of its limit of {limit} {self.unit}"
        )

    def in_print(self) -> tuple[str, ...]:
        """Value and limit as printed, with different digits unless they differ by rounding only."""
        size = abs(self.limit)
        if not self.exceeded and abs(abs(self.value) - size) <= CLOSE * (size or 1.0):
            return f"{self.value if size else self.limit:.4g}", f"{self.limit:.4g}"
        return compared(self.value, self.limit)


@dataclass(frozen=True)
class PaceLimit:
    """The limit that a motion reaches first where it is run faster, or slower until all are
    kept."""

    quantity: str
    """speed, torque or force; of a brake or bearing as of `LimitUse`."""
    coordinate: str
    time: float
    """When, in the motion as it is studied (s)."""
    segment: int = 0
    """The segment of a duty cycle, from 1; 0 where there is none."""

    @staticmethod
    def of(pace: Pace) -> PaceLimit | None:
        """The limit of a pace; None where it has none."""
        if not pace.joint:
            return None
        return PaceLimit(pace.quantity, pace.joint, pace.time, pace.segment)


@dataclass(frozen=True, repr=False)
class MotionVerdict(Tabled):
    """Whether the robot can make the motion, as far as its description shows; the first line of a
    study."""

    outcome: VerdictOutcome
    reason: str
    """Why, in a sentence or a few."""
    uses: tuple[LimitUse, ...]
    """Every limit that is given and can be told of, with what the motion uses of it; most used
    first."""
    doubts: tuple[Doubt, ...]
    """All that is doubtful about the robot: what bars the verdict, and what stands beside it."""
    factor: float
    """Run so many times as fast the motion reaches its first limit of speed or torque: above 1 it
    can be sped up so far, below 1 it must be slowed down to that. 0: no slowing helps; infinite: no
    limit depends on it; NaN: unknown, or passive joints would not follow."""
    factor_limit: PaceLimit | None = None
    """The limit that is reached at the factor; of a factor of 0 that which no slowing helps; None
    without one."""

    def _title(self) -> str:
        return f"Verdict: {self.text}"

    def _table(self) -> TextTable:
        rows = []
        for x in self.uses:
            value, limit = (f"{text} {x.unit}" for text in x.in_print())
            rows.append((x.quantity, x.coordinate, value, limit, percent(x.fraction)))
        return TextTable(("quantity", "joint", "value", "limit", "share"), rows)

    @property
    def heading(self) -> str:
        """The outcome with a capital letter, as a heading."""
        return self.outcome.capitalize()

    @property
    def text(self) -> str:
        """The whole verdict as text: heading and reason."""
        return f"{self.heading}: {self.reason}"

    def __str__(self) -> str:
        return self.text

    @property
    def good(self) -> bool:
        """Whether nothing has to be mended: no limit is exceeded, and no masses or limits in the
        file are wrong. Missing and estimated values do not count."""
        return self.outcome != "not feasible" and not any(x.of.mend for x in self.doubts)

    @property
    def binding(self) -> LimitUse | None:
        """The limit that the motion uses most, or exceeds most; None where there is none."""
        return self.uses[0] if self.uses else None


def instant(time: float, segment: int = 0) -> str:
    """Words for a time in a motion, or in a segment of a duty cycle; empty for NaN."""
    if time != time:
        return ""
    return f" at t = {time:.3g} s" + (f" of segment {segment}" if segment else "")


@dataclass(frozen=True)
class Check:
    """A comparison whose difference must be small: passed when `value` <= `bar`."""

    name: str
    value: float
    bar: float
    passed: bool
    text: str
    """Sentence on the check: what was compared, relative to what."""


@dataclass(frozen=True)
class Worst:
    """The instant of the motion at which the drives are loaded most."""

    index: int
    """Index of the sample in `Study.data`."""
    time: float
    coordinate: str
    value: float
    """The torque (N m) or force (N) then."""
    fraction: float
    """|value| over the effort limit; NaN without limits."""
    unit: str
    text: str
    """Sentence on the instant: which coordinate, when, and why then."""


@dataclass(frozen=True)
class StaticPose:
    """The pose within the limits at which gravity loads one coordinate most."""

    coordinate: str
    q: Array
    """Positions of the pose (nq,)."""
    torque: float
    """Gravity torque or force of the coordinate there, with its sign."""
    unit: str
    fraction: float
    """|torque| over the effort limit; NaN without a limit."""


@dataclass(frozen=True)
class Singularity:
    """The instant of a motion at which the tip's Jacobian is nearest to losing rank."""

    index: int
    time: float
    smallest: float
    """Least singular value of the scaled Jacobian (1/rad)."""
    largest: float
    """Largest singular value at the same instant."""
    rows: str
    """The rows of the Jacobian that are counted: "position", or "position and orientation"."""
    length: float
    """Characteristic length (m) that linear rows are divided by."""
    text: str


@dataclass(frozen=True, repr=False)
class Replay(Titled):
    """The result of driving the model by the torques of a motion: whether it follows the motion.

    In pieces, each restarted on the reference and short enough that the linearised dynamics amplify
    an error by at most `bound`; and once open loop from the start to the end.
    """

    edges: Array
    """(pieces + 1,) times at which pieces start and end (s)."""
    factors: Array
    """(pieces,) how much the linearised dynamics amplify an error within each piece, at most."""
    misses: Array
    """(pieces,) largest distance from the reference at the piece's end, over the joint range; NaN
    for pieces of a long log that were not run, infinite where the run was broken off."""
    bound: float
    method: str
    """Name of the integrator."""
    drift_time: Array
    """(k,) times of the open-loop run (s); it may stop early, see `text`."""
    drift: Array
    """Distances (k, nv) from the reference, open loop (rad, m)."""
    amplification: float
    """Decimal logarithm of the factor by which the linearised dynamics amplify an error over the
    whole motion."""
    friction_width: float
    """Rate (rad/s, m/s) over which dry friction is smoothed, c tanh(q̇ / width), in torque and
    model; 0: none."""
    text: str
    """Sentences on what happened, and what the drift comes from."""

    def _title(self) -> str:
        pieces = counted(len(self.factors), "piece")
        return f"Replay in {pieces}, the longest {self.longest:.3g} s; {self.text}"

    @property
    def longest(self) -> float:
        """The length (s) of the longest piece of the replay."""
        return float((self.edges[1:] - self.edges[:-1]).max())
