"""The judgement of logs on what an identification takes as known: whether torques were in
time with positions, joints are where the model has them, and parts of the logs agree.

Where they do not, intervals do not hold, however small the residual is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Delay(NamedTuple):
    """The time (s) by which torques were logged later than positions, with half its interval of
    95 %. corrected: whether the logs were put right by it."""

    seconds: float
    half: float
    corrected: bool

    def text(self) -> str:
        """The delay in words: 50 ± 2 ms later than."""
        size, half = 1000.0 * abs(self.seconds), 1000.0 * self.half
        return f"{size:.3g} ± {half:.1g} ms {'later' if self.seconds > 0.0 else 'earlier'} than"


class Displacement(NamedTuple):
    """A way in which a joint may be misplaced: a shift (m) along or a turn (rad) about an axis of
    its own frame, x, y or z, as the model has it. of_zero: whether it is that of its own motion."""

    joint: str
    axis: str
    turns: bool
    of_zero: bool

    def text(self, size: float) -> str:
        """The displacement by a size, in words."""
        unit = "rad" if self.turns else "m"
        if self.of_zero:
            return f"the zero of {self.joint} by {size:.2g} {unit}"
        how = f"about {self.axis}" if self.turns else f"along {self.axis}"
        return f"{self.joint} by {size:.2g} {unit} {how} of its frame"


class Misplaced(NamedTuple):
    """The displacement of a joint that explains best what is left; its size (m, rad) with half its
    interval of 95 %; others, in words, that explain it as well; and the largest change of a base
    parameter with it, over half of its interval."""

    displacement: Displacement
    size: float
    half: float
    others: tuple[str, ...]
    moved: float

    def text(self) -> str:
        """The displacement and what would explain as much."""
        said = f"{self.displacement.text(self.size)} (± {self.half:.1g})"
        return ", or ".join([said, *self.others])


class Disagreement(NamedTuple):
    """Two parts of the logs whose base parameters differ: which, by how many times as much as the
    stated covariance allows, and the probability of that as an accident."""

    parts: str
    factor: float
    accident: float


@dataclass(frozen=True)
class JudgedStructure:
    """The judgement of logs on what an identification takes as known. Each part is None where
    they say nothing against it."""

    delay: Delay | None = None
    misplaced: Misplaced | None = None
    disagreement: Disagreement | None = None

    @property
    def withdrawn(self) -> str:
        """Why intervals are withdrawn, or ""."""
        if self.misplaced is not None:
            return "withdrawn: a joint is not where the model has it"
        if self.delay is not None and not self.delay.corrected:
            return "withdrawn: torques and positions are not of the same time"
        return ""

    @property
    def widened(self) -> float:
        """The factor by which intervals are wider, since parts of the logs disagree."""
        return 1.0 if self.disagreement is None else self.disagreement.factor

    @property
    def fits(self) -> bool:
        """Whether base parameters and their intervals can be believed."""
        return not self.withdrawn and self.disagreement is None

    def doubt(self) -> str:
        """Half a sentence for the verdict, or ""."""
        if self.withdrawn:
            return "what it takes as known is wrong, and intervals are withdrawn"
        if self.disagreement is not None:
            return (
                f"parts of the logs disagree on the parameters, and intervals are "
                f"{self.widened:.1f} times as wide for it"
            )
        return ""

    def notices(self) -> list[str]:
        """Sentences on what is wrong, and where to look."""
        found = []
        if self.delay is not None:
            said = f"Torques were logged {self.delay.text()} positions"
            found.append(
                f"{said}; the logs are put right by that. Look at the clocks of the log's columns, "
                f"and at filters that delay one of them."
                if self.delay.corrected
                else f"{said}, which is too much to be put right: intervals are withdrawn. Shift "
                f"the log's columns against each other."
            )
        if self.misplaced is not None:
            found.append(
                f"The torques are those of another geometry: they fit far better with "
                f"{self.misplaced.text()}, and base parameters then change by up to "
                f"{self.misplaced.moved:.2g} times half their intervals, so that these are "
                f"withdrawn. Look at lengths, zeros and directions of axes in the model, and at "
                f"gravity's."
            )
        if self.disagreement is not None:
            how = "" if self.withdrawn else "; intervals are wider by that"
            found.append(
                f"Parts of the logs disagree on base parameters: {self.disagreement.parts} differ "
                f"{self.disagreement.factor:.2g} times as much as their intervals allow{how}. Look "
                f"whether geometry, zeros and gravity are the robot's, whether torques and "
                f"positions have one clock, and whether it carries the same throughout."
            )
        return found
