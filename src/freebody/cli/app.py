"""The program: its commands, and what becomes of errors.

Exit status 0: done. 1: a finding, such as a failed check. 2: bad input.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Annotated, Any

import typer

from freebody import __version__
from freebody.cli import (
    INTERRUPTED,
    export,
    fbd,
    models,
    plan,
    show,
    simulate,
    study,
    sweep,
    terminal,
)
from freebody.errors import FreebodyError, MissingPackageError
from freebody.locks import imported
from freebody_textbook.commands import check, derive

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


def _command(function: Callable[..., None], example: str, **more: Any) -> None:
    app.command(epilog=example, help=terminal.paragraphs(function.__doc__), **more)(function)


COMMANDS = (study, plan, simulate, sweep, show, derive, check, fbd, export, models)
"""Modules, each with a function of its name, an EXAMPLE, and where it writes its own help a
`Command`."""
for _module in COMMANDS:
    _own = vars(_module)
    _command(_own[_module.__name__.rpartition(".")[2]], _module.EXAMPLE, cls=_own.get("Command"))

BESIDE = {"notes": "freebody_notes.command"}
"""Commands of packages that build on freebody, each with the module that has the function of this
name, and an EXAMPLE."""


def _add(name: str, module: str) -> None:
    """A command from beside; where its package is not installed, one that says so."""
    package = module.partition(".")[0]
    try:
        found = imported(module)
    except ModuleNotFoundError as failure:
        if failure.name != package:
            raise
        anything = {"allow_extra_args": True, "ignore_unknown_options": True}
        short = f"Needs the package {package}, which is not installed."
        app.command(name, help=short, context_settings=anything, add_help_option=False)(
            _missing(name, package)
        )
    else:
        _command(getattr(found, name), found.EXAMPLE, name=name)


def _missing(name: str, package: str) -> Callable[[], None]:
    def refuse() -> None:
        raise MissingPackageError(f"freebody {name}", package)

    return refuse


for _name, _module in BESIDE.items():
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
    """Run the program on its arguments; the exit code. Every error is one line on stderr."""
    with terminal.streams():
        return _run(arguments)


def _run(arguments: list[str]) -> int:
    try:
        code = typer.main.get_command(app).main(
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


def _unforeseen(problem: Exception) -> int:
    """A wrong option, which the parser words; else a fault of freebody's own."""
    wording = getattr(problem, "format_message", None)
    if wording is not None:
        text = wording().replace("Value error, ", "").rstrip(".")
        command = getattr(getattr(problem, "ctx", None), "command_path", None) or "freebody"
        return terminal.error(f"{text}. See {command} --help.")
    if os.environ.get("FREEBODY_TRACEBACK"):
        raise problem
    if isinstance(problem, MemoryError):
        return terminal.error(f"this does not fit into memory: {problem or 'no more is left'}.")
    return terminal.error(
        f"{type(problem).__name__}: {problem} (an error in freebody, please report it; "
        f"FREEBODY_TRACEBACK=1 shows where)"
    )
