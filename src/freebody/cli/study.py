"""The command `freebody study`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import fitted_parts, motions, options, terminal
from freebody.errors import FreebodyError, OutputError, UnknownNameError
from freebody.outputs.display import counted
from freebody.outputs.folder import prepare
from freebody.outputs.number_text import compared
from freebody.outputs.pdf import browser

if TYPE_CHECKING:
    from collections.abc import Sequence

    from freebody.design.duty_cycle import DutyCycle
    from freebody.model.model import Model
    from freebody.motion.motion import Motion
    from freebody.motion.simulation.prepared_simulation import Progress
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.results import Check
    from freebody.report.study import Study

_STYLES = {
    ("feasible", True): "bold green",
    ("not feasible", False): "bold red",
    ("not judged", True): "bold yellow",
    ("not judged", False): "bold red",
}
"""Styles by outcome, and whether there is nothing to mend."""

GivenMeasured = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="A CSV file of the torques that were measured during the motion, shown beside the "
        "computed ones: t (s) and the joints (N m, N).",
    ),
]
EXAMPLE = "Example: freebody study ur5e --out study-ur5e"


@options.collected(wrench=options.USED, speed=options.USED)
def study(
    context: typer.Context,
    robot: options.GivenRobot,
    motion: motions.GivenMotion = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for report and data. Default: study-ROBOT."),
    ] = None,
    smooth: motions.GivenSmooth = None,
    measured: GivenMeasured = None,
    catalogue: fitted_parts.GivenCatalogue = None,
    brake: fitted_parts.GivenBrakes = None,
    bearing: fitted_parts.GivenBearings = None,
    pdf: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="The report as PDF too, printed by a Chromium, Chrome or Edge."
        ),
    ] = None,
    figure: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=FILE",
            help="A figure by itself, .svg or .pdf, such as torques=torques.svg or "
            "animation=moves.svg; repeatable. Names: robot, animation, free_bodies, kinematics, "
            "gravity, lifting, motion, followers, torques, powers, energies, reactions, drift, "
            "residual.",
        ),
    ] = None,
) -> None:
    """Study a robot along a motion or over a duty cycle: torques, powers, reactions, energies and
    checks, as a report and as data.

    Exit status 0: feasible, or not judged because limits are not given. 1: a limit is exceeded,
    masses are missing or doubtful, or a self-check failed. 2: something cannot be read or written.
    """
    directory = out or Path(f"study-{Path(robot.name).stem}")
    with terminal.progress("reading") as progress:
        from freebody.design.duty_cycle import DutyCycle
        from freebody.report.study import Study

        motions.cutoff(smooth)  # refused before anything is computed
        figures = [_figure(given) for given in figure or ()]
        if pdf is not None:
            browser()  # refused before anything is computed
        model = robot.load()
        prepare(directory)
        given = None if motion is None else motions.read(model, motion)
        if figures and isinstance(given, DutyCycle):
            raise FreebodyError(
                "--figure is for one motion, and this is a duty cycle; in Python "
                "study(...).segments[0].figure(...) is that of a segment."
            )
        found = computed(
            robot, model, given, smooth, measured, fitted_parts.read(catalogue, brake, bearing),
            lambda text, done: progress(text, 0.7 * done),
        )  # fmt: skip
        found = replace(found, command=options.again(context))
        progress("report and data files", 0.7)
        failure = _saved(found, directory)
        if pdf is not None and failure is None:
            progress("PDF", 0.9)
            found.to_pdf(pdf)
        if failure is None and isinstance(found, Study):
            for name, file in figures:
                progress(f"figure {name}", 0.95)
                found.figure(name).save(file)
    _print(found, directory, failure)
    if failure is None:
        for title, file in [*([("PDF", pdf)] if pdf else []), *(("figure", x) for _, x in figures)]:
            terminal.out().print(f"{title + ':':7} {file}", soft_wrap=True)
    if failure:
        raise failure
    if found.finding:
        raise typer.Exit(1)


def computed(
    robot: options.GivenRobot, model: Model, motion: DutyCycle | Motion | None,
    smooth: str | None, measured: Path | None, parts: dict[str, Any], progress: Progress,
) -> Study | CycleStudy:  # fmt: skip
    """The study of a robot as the options of the command say."""
    from freebody.report.study import study as study_of

    return study_of(
        model,
        motion,
        wrenches=robot.wrenches(model),
        smooth=motions.cutoff(smooth),
        speed=robot.speed,
        measured=measured,
        **parts,
        progress=progress,
    )


def _figure(given: str) -> tuple[str, Path]:
    """The name and the file of a figure that --figure asks for."""
    from freebody.figures.figure import picture_file
    from freebody.report.study_figures import NAMES

    name, separator, file = given.partition("=")
    if not separator or not file:
        raise FreebodyError(
            f"--figure is {given!r}, expected NAME=FILE, such as torques=torques.svg."
        )
    if name not in NAMES:
        raise UnknownNameError("figure", name, "a study", NAMES)
    return name, picture_file(file, "--figure")


def _saved(found: Study | CycleStudy, directory: Path) -> FreebodyError | None:
    """The error that kept a study's files from being written, or None; it is raised after the
    findings are printed."""
    try:
        found.save(directory, report=True)
    except FreebodyError as failure:
        return failure
    return None


def _print(found: Study | CycleStudy, directory: Path, failure: FreebodyError | None) -> None:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.summary import drive_table

    out = terminal.out()
    for sentence in found.warnings:
        terminal.warn(sentence)
    out.print(found.verdict.text, style=_STYLES[found.verdict.outcome, found.verdict.good])
    whole = isinstance(found, CycleStudy)
    of = f"Duty cycle: {found.cycle.source}" if whole else f"Motion: {found.motion.source}"
    out.print(f"{found.model.name}: {counted(found.model.nv, 'coordinate')}. {of}.")
    out.print(found.model.tip_reason)
    _print_case(found.segments if whole else (found,))
    terminal.table(found.card._table())
    shares = found.summary["effort_fraction"].sel(coordinate=list(found.model.driven_names)).values
    table = drive_table(found.model, found.summary)
    terminal.table(table, red=[k for k, share in enumerate(shares) if share > 1])
    if isinstance(found, CycleStudy):
        terminal.table(found.worst)
        out.print(found.energy)
        _print_checks([check for study in found.segments for check in study.checks])
    else:
        _print_words(found)
        _print_checks(found.checks)
    _print_files(found, directory, failure)
    out.print(f"again:  {found.command}", soft_wrap=True)


def _print_case(studies: Sequence[Study]) -> None:
    """The load case, of a duty cycle that of each segment."""
    from freebody.report.load_case import in_a_line

    for k, study in enumerate(studies, 1):
        about = f"Segment {k}. " if len(studies) > 1 else ""
        terminal.out().print(
            about + in_a_line(study.model, study.wrenches, study.speed, study.parts.words)
        )


def _print_words(found: Study) -> None:
    from freebody.report.measured import measured_text
    from freebody.report.summary import energy_text

    measured = measured_text(found)
    terminal.out().print(
        found.worst.text,
        *([measured] if measured else []),
        energy_text(found.summary, found.motion.duration),
        *([found.singularity.text] if found.singularity else []),
        found.replay.text if found.replay else found.replay_skipped,
        sep="\n",
    )


def _print_files(found: Study | CycleStudy, directory: Path, failure: FreebodyError | None) -> None:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study_files import CYCLE, DATA, REPORT

    told = (("report: {}", REPORT), ("data:   {} and CSV tables beside it", DATA))
    if isinstance(found, CycleStudy):
        first = f"segment-1/{REPORT}"
        told = (("report: {}, and of each segment its own", first), ("data:   {}", CYCLE))
    for title, name in told:
        if failure is None or (isinstance(failure, OutputError) and name in failure.written):
            terminal.out().print(title.format(directory / name), soft_wrap=True)


def _print_checks(checks: Sequence[Check]) -> None:
    failed = [check for check in checks if not check.passed]
    out = terminal.out()
    if not failed:
        out.print(f"Self-checks: freebody's results are consistent in all {len(checks)}.")
    for check in failed:
        value, bar = compared(check.value, check.bar, digits=3)
        text = f"self-check failed: {check.name}: {value}, allowed {bar}. {check.text}"
        out.print(text, style="bold red")
