"""The command `freebody doctor`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from freebody.cli import options, terminal
from freebody.errors import FreebodyError
from freebody.outputs.files import write

if TYPE_CHECKING:
    from freebody.diagnosis.doctor import Diagnosis

EXAMPLE = "Example: freebody doctor ur5e panda"

_STYLES = {"error": "bold red", "warning": "yellow", "notice": "dim"}


@options.collected()
def doctor(
    robots: list[options.GivenFile],
    fix: Annotated[
        bool,
        typer.Option(
            "--fix",
            help="Write NAME.mended.urdf beside each URDF in which something has one sensible "
            "remedy, all other text as it was, and say what is changed.",
        ),
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the findings as JSON, a list of files.")
    ] = False,
) -> None:
    """Find what is wrong in files of robots: inertias, limits, axes, frictions, names, meshes, each
    with its line, the reason and what to do.

    Exit status 0: neither an error nor a warning, notices perhaps. 1: there are some; with --fix,
    some are left. 2: a file cannot be read or written.
    """
    from freebody.diagnosis.doctor import doctor as looked_at

    told = []
    status = 0
    for robot in robots:
        try:
            found = looked_at(robot.name, **robot.arguments)
            mended = _mended(found) if fix else None
            left = looked_at(mended, **robot.arguments) if mended else found
        except FreebodyError as problem:  # the other files are looked at nevertheless
            status = terminal.error(str(problem))
            continue
        status = max(status, 0 if left.sound else 1)
        told.append(found.data | ({"mended": str(mended)} if mended else {}))
        if not as_json:
            _print(found, left if mended else None)
            if fix and not mended:
                terminal.out().print(_UNCHANGED)
    if as_json:
        terminal.out().print(json.dumps(told, indent=2, ensure_ascii=False), soft_wrap=True)
    raise typer.Exit(status)


_UNCHANGED = (
    "nothing is changed: of URDF files what has one sensible remedy is mended, of others nothing"
)


def _mended(found: Diagnosis) -> Path | None:
    """The path of the mended copy of a robot's file, which is written; None where nothing could be
    mended."""
    if found.mended is None:
        return None
    path = Path(found.file)
    return write(path.with_name(f"{path.stem}.mended{path.suffix}"), found.mended)


def _print(found: Diagnosis, left: Diagnosis | None) -> None:
    out = terminal.out()
    for finding in found.findings:
        out.print(str(finding), style=_STYLES[finding.severity], soft_wrap=True)
    out.print(found.title)
    if left is not None:
        for change in found.changes:
            out.print(f"changed: {change}", soft_wrap=True)
        out.print(f"written: {left.title}", soft_wrap=True)
