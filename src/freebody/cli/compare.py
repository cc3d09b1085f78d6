"""The command `freebody compare`."""

from __future__ import annotations

import shlex
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import fitted_parts, motions, options, terminal
from freebody.cli.commands import OnceCommand
from freebody.cli.study import GivenMeasured, computed
from freebody.errors import FreebodyError

if TYPE_CHECKING:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study import Study

EXAMPLE = 'Example: freebody compare ur5e "ur5e --payload 5" --out compared.html'


def compare(
    cases: Annotated[
        list[str],
        typer.Argument(
            metavar="CASE...",
            help="Two to eight studies, each with its own options, in quotes: a robot, then what "
            "freebody study takes, such as 'ur5e --payload 5 --speed 0.8'. A name before it, as in "
            "'loaded: ur5e --payload 5', is what it is called.",
        ),
    ],
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="The page; as .pdf it is printed by a Chromium.")
    ] = Path("comparison.html"),
) -> None:
    """Study robots, loads or designs beside each other: what differs, verdicts, what the drives
    have to give, and their curves over each other, on one page."""
    kind = out.suffix.lower()
    if kind not in (".html", ".pdf"):
        raise FreebodyError(f"--out is {out.name!r}, expected an .html or .pdf file.")
    with terminal.progress("reading") as progress:
        from freebody.report.comparison import compared

        named = list(map(_named, cases))
        studies: list[Any] = []
        for k, (_, text) in enumerate(named):
            progress(f"study {k + 1} of {len(named)}", k / len(named))
            studies.append(_studied(text))
        found = compared(_names(named), studies)
        progress("page", 0.95)
        written = found.to_html(out) if kind == ".html" else found.to_pdf(out)
    terminal.table(found._table())
    terminal.out().print(f"page:   {written}", soft_wrap=True)


def _named(case: str) -> tuple[str, str]:
    """The name and the study of a case; the name is empty where none is given."""
    name, separator, rest = case.partition(": ")
    return (name.strip(), rest) if separator else ("", case)


def _names(named: list[tuple[str, str]]) -> list[str] | None:
    """The names of the cases, of those without one their numbers; None where none has a name."""
    if not any(name for name, _ in named):
        return None
    return [name or f"study {k}" for k, (name, _) in enumerate(named, 1)]


def _studied(case: str) -> Study | CycleStudy:
    """The study that the text of a case describes."""
    try:
        return _reader().main(shlex.split(case), prog_name=case, standalone_mode=False)
    except FreebodyError as problem:
        raise FreebodyError(f"compare: {case!r}: {problem}") from problem
    except ValueError as problem:  # a quote that nothing closes
        raise FreebodyError(f"compare: {case!r} cannot be read: {problem}.") from problem
    except Exception as problem:
        wording = getattr(problem, "format_message", None)  # of the parser of options
        if wording is None:
            raise
        raise FreebodyError(f"compare: {case!r}: {wording()}") from problem


@cache
def _reader() -> Any:
    """The parser of a case: the options of a study that say what is computed."""
    reader = typer.Typer(add_completion=False, rich_markup_mode=None)
    reader.command(cls=OnceCommand, add_help_option=False)(_case)
    return typer.main.get_command(reader)


@options.collected(wrench=options.USED, speed=options.USED)
def _case(
    robot: options.GivenRobot,
    motion: motions.GivenMotion = None,
    smooth: motions.GivenSmooth = None,
    measured: GivenMeasured = None,
    catalogue: fitted_parts.GivenCatalogue = None,
    brake: fitted_parts.GivenBrakes = None,
    bearing: fitted_parts.GivenBearings = None,
) -> Any:
    from freebody.motion.motion import Motion

    model = robot.load()
    given = None if motion is None else motions.read(model, motion)
    if given is not None and not isinstance(given, Motion):
        raise FreebodyError(
            f"{motion} is a duty cycle, and one motion each is compared; give a CSV file. In "
            f"Python fb.compare(study.segments) has the segments of a cycle beside each other."
        )
    parts = fitted_parts.read(catalogue, brake, bearing)
    return computed(robot, model, given, smooth, measured, parts, lambda text, done: None)
