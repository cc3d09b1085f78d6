"""`study`: freebody's main job. From a robot and a motion to kinematics, loads, energies, checks
and a replay, as data."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, overload

from freebody.arrays import Array, refuse_not_finite
from freebody.by_value import ByValue
from freebody.capacity.fitted_parts import NO_PARTS, FittedParts
from freebody.capacity.segments import loaded_segments
from freebody.design.drive_loads import ChosenDrives
from freebody.design.duty_cycle import DutyCycle, Segment
from freebody.design.notices import without_motor
from freebody.design.parts import Bearing
from freebody.errors import FreebodyError, SingularError
from freebody.model.doubts import readings
from freebody.model.model import Model
from freebody.motion.files.motion_tables import MotionTable
from freebody.motion.motion import Motion
from freebody.motion.simulation.prepared_simulation import Progress
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.files import write
from freebody.outputs.pdf import pdf
from freebody.report.card import Card, card
from freebody.report.checks import checks
from freebody.report.cycle_study import CycleStudy, cycle_study
from freebody.report.jacobians import singularity
from freebody.report.load_case import LoadCase, case_of
from freebody.report.measured import Measured, beside_measured, measured_torques
from freebody.report.replay import replayed
from freebody.report.results import Check, MotionVerdict, Replay, Singularity, StaticPose, Worst
from freebody.report.series import series
from freebody.report.studied_motion import Smooth, studied, with_peaks
from freebody.report.summary import drive_table, limit_notices, summary, worst, worst_poses
from freebody.report.verdict import judged_motion, verdict
from freebody.trees.public_calls import FrameWrenchTable, wrenches_by_frame

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.study_figures import StudyFigure


StudiedMotion = DutyCycle | Segment | Motion | MotionTable | str | os.PathLike[str] | None
"""Motions that a robot is studied along; None: a default one."""


@dataclass(frozen=True, eq=False, repr=False)
class Study(Tabled, ByValue):
    """The dynamic study of a robot: everything that a report shows, as data.

    Names of dimensions: `time` (T samples), `coordinate` (nv; model.velocity_names), `position`
    (nq; position_names), `joint` (model.joint_names; joint i carries body i; then the loops),
    `body` (names of the bodies), `axis` (x, y, z; x, y in the plane), `moment_axis` (x, y, z; z in
    the plane). Every variable has the attributes `units` and `long_name`, as the page on studies
    lists them; where units differ by coordinate they are "rad|m" and the like, and the coordinate
    arrays `unit` (rad or m) and `effort_unit` (N m or N) along `coordinate` say which.
    """

    model: Model
    tip: str | None
    """Frame whose position, velocity and Jacobian are studied; without a single tip None, and
    nothing is said of these."""
    """One sentence: which frame is the tip and why, or why none is, and which may be."""
    motion: Motion
    data: xr.Dataset
    """Time series: the motion, torques with their parts, reactions and what bearings carry, bodies,
    tip, energies, powers."""
    summary: xr.Dataset
    """Peaks, means and shares of limits: of each drive, of each joint (`joint`: magnitudes of
    reactions, loads of bearings, each with its time), and of all drives together; NaN where there
    is no limit."""
    worst: Worst
    static: tuple[StaticPose, ...]
    """For each coordinate that gravity loads."""
    singularity: Singularity | None
    """Singularities of the tip; None for a robot without a tip."""
    checks: tuple[Check, ...]
    """Checks of freebody on itself: quantities computed in two ways."""
    verdict: MotionVerdict
    """Whether the robot can make the motion: feasible, not feasible, or not judged, and why."""
    card: Card
    """Answers: what the robot carries on this path, how much faster it can go, and what gives out
    first."""
    replay: Replay | None
    replay_skipped: str
    """Reason why there is no replay; empty if there is one."""
    notices: tuple[str, ...]
    """Sentences that a reader must know: how the file was read, what is doubtful, and all
    `warnings`."""
    warnings: tuple[str, ...] = ()
    """About the motion: limits that it leaves, limits that the model does not give, a base that
    nothing drives."""
    seconds: dict[str, float] = field(default_factory=dict)
    """The time that each part took (s)."""
    wrenches: dict[str, Array] = field(default_factory=dict)
    """Constant ones on the robot by frame, (six,), world axes."""
    speed: float = 1.0
    """How many times as fast as given the motion is run."""
    command: str = ""
    """The command line that makes it again, where one made it."""
    parts: FittedParts = NO_PARTS
    """The brakes and bearings that are judged besides the drives."""
    _aside = ("seconds", "command")

    def _title(self) -> str:
        samples = counted(len(self.motion.t), "sample")
        return (
            f"Study of {self.model.name!r}: {samples} in {self.motion.duration:.4g} s; "
            f"{self.verdict.heading}"
        )

    def _table(self) -> TextTable:
        found = drive_table(self.model, self.summary)
        return replace(found, notes=[self.verdict.text, *self.warnings])

    @property
    def load_case(self) -> LoadCase:
        """The load case: what the robot carries, what pulls at it, how it is mounted, how fast it
        is run, and which brakes and bearings are judged."""
        return case_of(self.model, self.wrenches, self.speed, self.command, self.parts.words)

    @property
    def checked(self) -> bool:
        """Whether all of freebody's `checks` on itself passed."""
        return all(check.passed for check in self.checks)

    @property
    def passed(self) -> bool:
        """Whether the motion is feasible beyond doubt, and all `checks` passed."""
        return self.checked and self.verdict.good and self.verdict.outcome == "feasible"

    @property
    def finding(self) -> bool:
        """Whether something has to be mended (the command then exits with 1): a limit exceeded,
        wrong masses or limits in the file, a failed check. Missing and estimated values do not
        count."""
        return not (self.checked and self.verdict.good)

    def save(self, directory: str | os.PathLike[str], *, report: bool = False) -> list[Path]:
        """The paths of the files written into a folder: study.nc (time series and summary), CSV
        tables, card.json and manifest.json.

        report: report.html as well. Units stand in the headers. Each file is whole; the manifest,
        which comes last, lists their checksums. Raises FileError for a folder that cannot be
        written, OutputError naming the files that could not be, when the others are there; files of
        another origin are left alone.
        """
        from freebody.report.study_files import save

        return save(self, Path(directory), report)

    def to_html(self, path: str | os.PathLike[str]) -> Path:
        """The path of the report that is written as one HTML file, which opens offline."""
        from freebody.report.page import page

        return write(path, page(self))

    def to_pdf(self, path: str | os.PathLike[str]) -> Path:
        """The path of the report that is written as PDF, printed by a Chromium, Chrome or Edge that
        is at hand.

        Raises FreebodyError where there is none, or where it fails, FileError for a file that
        cannot be written.
        """
        from freebody.report.page import page

        return write(path, pdf(page(self)))

    def figure(self, name: str, only: str | Sequence[str] | None = None) -> StudyFigure:
        """A figure of the report by itself, for a paper, slides or a site.

        Parameters
        ----------
        name
            "robot" (at the worst instant), "animation" (the motion in its own time, without
            script), "free_bodies", "kinematics" (path of the tip, speed, nearness to singular
            poses), "gravity", "lifting", "motion", "followers" (joints that loops lead), "torques"
            (of each drive with its parts), "powers", "energies", "reactions", "drift" (of the
            replay) or "residual" (of the energy balance).
        only
            The panels that it has, one or several of the figure's `titles`, such as a joint's name;
            default all.

        Returns
        -------
        StudyFigure
            Shows itself in a notebook; `.save("torques.svg")` or `.save("torques.pdf")` writes it.

        Raises
        ------
        UnknownNameError
            For a name that no figure, or a title that no panel has; it lists those there are.
        FreebodyError
            Where there is nothing to draw, such as the tip's path of a robot without a tip.
        """
        from freebody.report.study_figures import study_figure

        return study_figure(self, name, only)


@overload
def study(
    model: Model,
    motion: DutyCycle | Segment,
    tip: str | None = None,
    *,
    wrenches: FrameWrenchTable = None,
    smooth: Smooth = False,
    speed: float = 1.0,
    brakes: ChosenDrives | None = None,
    bearings: Mapping[str, Bearing] | None = None,
    progress: Progress | None = None,
) -> CycleStudy: ...


@overload
def study(
    model: Model,
    motion: Motion | MotionTable | str | os.PathLike[str] | None = None,
    tip: str | None = None,
    *,
    wrenches: FrameWrenchTable = None,
    smooth: Smooth = False,
    speed: float = 1.0,
    measured: Measured | None = None,
    brakes: ChosenDrives | None = None,
    bearings: Mapping[str, Bearing] | None = None,
    progress: Progress | None = None,
) -> Study: ...


@overload
def study(
    model: Model,
    motion: Motion | MotionTable | str | os.PathLike[str] | DutyCycle | Segment | None = None,
    tip: str | None = None,
    *,
    wrenches: FrameWrenchTable = None,
    smooth: Smooth = False,
    speed: float = 1.0,
    measured: Measured | None = None,
    brakes: ChosenDrives | None = None,
    bearings: Mapping[str, Bearing] | None = None,
    progress: Progress | None = None,
) -> Study | CycleStudy: ...


def study(
    model: Model,
    motion: StudiedMotion = None,
    tip: str | None = None,
    *,
    wrenches: FrameWrenchTable = None,
    smooth: Smooth = False,
    speed: float = 1.0,
    measured: Measured | None = None,
    brakes: ChosenDrives | None = None,
    bearings: Mapping[str, Bearing] | None = None,
    progress: Progress | None = None,
) -> Study | CycleStudy:
    """The dynamic study of a robot along a motion, or over a duty cycle.

    Parameters
    ----------
    model
        With all values.
    motion
        A Motion, a CSV file (see `read_motion`) or a table by names (see `Motion.of`: a dict, a
        DataFrame, a Dataset); default: a smooth one within the joint limits, slowed as far as the
        limits of speed and torque require. Or a DutyCycle, whose result is a `CycleStudy`: the
        studies of its segments, and what is said of all together.
    tip
        Frame; default: the model's own, without which the study leaves out what is of a tip.
    wrenches
        Constant ones exerted on the robot by its surroundings, {frame: (six,)}, force then moment,
        world axes (N, N m); one alone: at the tip. Those of segments are added.
    smooth
        True, or a cutoff (Hz), for a measured motion (see `smoothed`). Noise that spoils the
        torques is reported in any case, with the torques with and without it.
    speed
        How many times as fast the motion is run along its path, after it was smoothed.
    measured
        Torques that were measured during the motion, (t, tau) with t (k,) in the motion's time and
        tau (k, nv), N m and N, or a CSV file (see `read_torques`): shown beside the computed ones,
        with the RMS difference.
    brakes : {joint: (Motor, Gear)}, optional
        Drives whose brakes have to hold the robot still wherever it is, as for `payload`; such as
        the `drives` of `drive_loads`. Their masses are the model's already.
    bearings : {joint: Bearing}, optional
        Of joints that turn, judged by their static load and tilting moment, as for `payload`.
        Verdict, card and pace then count brakes and bearings too.
    progress
        Called with a text and the fraction done.

    Raises
    ------
    FreebodyError
        A robot without movable joints; a duty cycle with wrenches that change over time, or that
        is to be smoothed; torques that were measured at another time or pace, or over a cycle; a
        bearing without a limit, or whose load rigid bodies do not determine.
    MissingValueError
        A robot with open parameters.
    """
    if model.nv == 0:
        raise FreebodyError(
            f"study: {model.name!r} has no movable joint; there is no motion to study."
        )
    model.require_values("the study")
    clock = _Clock(progress)
    if tip is not None:
        model = model.replace(tip=tip)
    loads = wrenches_by_frame("study", model, wrenches, single=True)
    for frame, load in loads.items():
        refuse_not_finite("study", f"wrenches[{frame!r}]", load, 1)
    parts = FittedParts.of("study", model, brakes, bearings)
    if isinstance(motion, DutyCycle | Segment):
        if measured is not None:
            raise FreebodyError(
                "study: measured is for one motion; study the segments by themselves."
            )
        cycle = motion if isinstance(motion, DutyCycle) else DutyCycle((motion,))
        return _over_cycle(model, cycle, loads, parts, smooth, speed, progress)
    torques = None if measured is None else measured_torques(model, measured, speed)
    found, _ = _along(model, motion, loads, parts, smooth, speed, clock)
    return found if torques is None else beside_measured(found, *torques)


def _over_cycle(
    model: Model,
    cycle: DutyCycle,
    loads: Mapping[str, Array],
    parts: FittedParts,
    smooth: Smooth,
    speed: float,
    progress: Progress | None,
) -> CycleStudy:
    if smooth is not None and smooth is not False:
        raise FreebodyError(
            "study: smooth is for one motion; the segments of a duty cycle would no longer meet. "
            "Smooth the whole (fb.smoothed), then divide it."
        )
    segments = loaded_segments("study", model, cycle, loads)
    found = []
    for k, segment in enumerate(segments):
        part = None if progress is None else _SegmentProgress(progress, k, len(segments))
        clock = _Clock(part)
        case = segment.model, segment.motion, segment.wrenches, parts
        found.append(_along(*case, None, speed, clock))
    studies, noisy = zip(*found, strict=True)
    whole = cycle_study(model, cycle, segments, studies, any(noisy), parts)
    return replace(whole, wrenches=dict(loads), speed=speed)


@dataclass(frozen=True)
class _SegmentProgress:
    """The progress of one of several segments."""

    progress: Progress
    number: int
    count: int

    def __call__(self, text: str, fraction: float) -> None:
        words = f"segment {self.number + 1}: {text}" if fraction < 1.0 else text
        self.progress(words, (self.number + fraction) / self.count)


def _along(
    model: Model,
    motion: Motion | MotionTable | str | os.PathLike[str] | None,
    loads: dict[str, Array],
    parts: FittedParts,
    smooth: Smooth,
    speed: float,
    clock: _Clock,
) -> tuple[Study, bool]:
    """The study of one motion, and whether the motion's noise is part of its torques."""
    with clock.part("motion", 0.0):
        sampled, measured = studied(model, motion, smooth, speed, loads)
        followed = with_peaks(model, sampled, loads)
    with clock.part("torques, reactions, energies", 0.05):
        data = series(model, followed, loads)
        found = summary(model, followed, data)
        noisy = bool(measured) and not smooth
        one = judged_motion(model, followed, data, found, loads, parts=parts)
        judged = verdict([one], noisy)
    with clock.part("payload", 0.35):
        carded = card(model, followed, judged, loads, parts)
    with clock.part("worst poses", 0.4):
        poses = () if model.loops else worst_poses(model)
    with clock.part("replay", 0.5):
        replay, skipped = _replay(model, sampled, loads)
    with clock.part("checks", 0.9):
        checked = checks(model, followed, data, replay, loads)
    beyond = limit_notices(model, found, judged.uses)
    warned = (*measured, *followed.notices, *without_motor(model, "this study"), *beyond)
    clock.say("done", 1.0)
    done = Study(
        model=model,
        tip=model.tip,
        motion=followed,
        data=data,
        summary=found,
        worst=worst(model, data),
        static=poses,
        singularity=None if model.tip is None else singularity(model, model.tip, data),
        checks=checked,
        verdict=judged,
        card=carded,
        replay=replay,
        replay_skipped=skipped,
        notices=(*map(str, readings(model)), *map(str, model.doubts), *warned),
        warnings=warned,
        seconds=clock.seconds,
        wrenches=loads,
        speed=speed,
        parts=parts,
    )
    return done, noisy


def _replay(
    model: Model, motion: Motion, wrenches: Mapping[str, Array]
) -> tuple[Replay | None, str]:
    """The replay and the reason why there is none: (the replay, empty), or (None, the reason)."""
    if model.loops:
        why = "There is no replay of a closed chain; one of the checks simulates a section of the"
        return None, f"{why} motion."
    try:
        return replayed(model, motion, wrenches), ""
    except SingularError as problem:
        return None, f"There is no replay. {problem}"


class _Clock:
    """A clock that reports progress and measures how long each part takes."""

    def __init__(self, progress: Progress | None):
        self.progress = progress
        self.seconds: dict[str, float] = {}

    def say(self, text: str, fraction: float) -> None:
        if self.progress is not None:
            self.progress(text, fraction)

    @contextmanager
    def part(self, text: str, fraction: float) -> Iterator[None]:
        self.say(text, fraction)
        start = time.perf_counter()
        yield
        self.seconds[text] = time.perf_counter() - start
