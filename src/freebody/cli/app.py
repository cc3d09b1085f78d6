"""The program `freebody`: its commands, and how errors are reported.

Exit status 0: done. 1: a finding, such as a failed check. 2: bad input.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from typing import Annotated, Any

import typer

from freebody import __version__, beside
from freebody.cli import (
    INTERRUPTED,
    calibrate,
    commands,
    compare,
    convert,
    diff,
    doctor,
    export,
    fbd,
    identify,
    models,
    payload,
    plan,
    show,
    simulate,
    size,
    studio,
    study,
    sweep,
    terminal,
)
from freebody.errors import FreebodyError, MissingPackageError

_UNREAD = 141
"""128 and the number of SIGPIPE, as shells count: `| head` has read enough."""

app = typer.Typer(
    name="freebody",
    help="Dynamics of robotic manipulators: from a robot description to numbers, reports and "
    "drawings.",
    epilog="Example: freebody study ur5e",
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _command(
    function: Callable[..., None],
    example: str,
    name: str | None = None,
    cls: type[commands.OnceCommand] = commands.OnceCommand,
) -> None:
    words = terminal.paragraphs(function.__doc__)
    app.command(name, epilog=example, help=words, cls=cls)(function)


for _function, _example in (
    (study.study, study.EXAMPLE),
    (compare.compare, compare.EXAMPLE),
    (studio.studio, studio.EXAMPLE),
    (plan.plan, plan.EXAMPLE),
    (size.size, size.EXAMPLE),
    (payload.payload, payload.EXAMPLE),
    (identify.identify, identify.EXAMPLE),
    (calibrate.calibrate, calibrate.EXAMPLE),
    (simulate.simulate, simulate.EXAMPLE),
    (sweep.sweep, sweep.EXAMPLE),
    (show.show, show.EXAMPLE),
    (fbd.fbd, fbd.EXAMPLE),
    (export.export, export.EXAMPLE),
    (convert.convert, convert.EXAMPLE),
    (doctor.doctor, doctor.EXAMPLE),
    (diff.diff, diff.EXAMPLE),
    (models.models, models.EXAMPLE),
):
    _command(_function, _example)


def _add(name: str, module: str) -> None:
    """Add a command of an optional package to the program; where that is not installed, a command
    that says so."""
    try:
        found = beside.found(module, f"freebody {name}")
    except MissingPackageError as problem:
        _refuse(name, problem)
    else:
        kind = vars(found).get("Command", commands.OnceCommand)
        _command(getattr(found, name), found.EXAMPLE, name, kind)


def _refuse(name: str, problem: MissingPackageError) -> None:
    def refuse() -> None:
        raise problem

    anything = {"allow_extra_args": True, "ignore_unknown_options": True}
    app.command(name, help=str(problem), context_settings=anything, add_help_option=False)(refuse)


for _name, _module in beside.COMMANDS.items():
    _add(_name, _module)


@app.callback(invoke_without_command=True)
def freebody(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", is_eager=True)
    ] = False,
) -> None:
    """The dynamics of robotic manipulators, from a robot description to the numbers and the
    pictures."""
    if version:
        terminal.out().print(f"freebody {__version__}", highlight=False)
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())
    else:
        return
    raise typer.Exit(0)


def run(arguments: list[str]) -> int:
    """The exit code after running the program on its arguments; every error is one line on
    stderr."""
    with terminal.streams():
        return _run(arguments)


def _run(arguments: list[str]) -> int:
    try:
        code = _program().main(
            arguments, prog_name="freebody", standalone_mode=False, obj=tuple(arguments)
        )
    except FreebodyError as problem:
        return terminal.error(str(problem))
    except terminal.Gone:
        return _UNREAD
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except Exception as problem:
        return _unforeseen(problem)
    if code == INTERRUPTED:
        terminal.error("interrupted.")
    return code if isinstance(code, int) else 0


@cache
def _program() -> Any:
    """The program of all commands, which is made once a process."""
    return typer.main.get_command(app)


def _unforeseen(problem: Exception) -> int:
    """The exit code after reporting an error that no command expects: a wrong option in the
    parser's words, or else a fault of freebody's own."""
    wording = getattr(problem, "format_message", None)
    if wording is not None:
        text = wording().replace("Value error, ", "").rstrip(".")
        command = getattr(getattr(problem, "ctx", None), "command_path", None) or "freebody"
        stop = "" if text.endswith("?") else "."
        return terminal.error(f"{text}{stop} See {command} --help.")
    if os.environ.get("FREEBODY_TRACEBACK"):
        raise problem
    if isinstance(problem, MemoryError):
        return terminal.error(f"this does not fit into memory: {problem or 'no more is left'}.")
    return terminal.error(
        f"{type(problem).__name__}: {problem} (an error in freebody, please report it; "
        f"FREEBODY_TRACEBACK=1 shows where)"
    )
