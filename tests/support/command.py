"""The command `freebody`, run in this process as `python -m freebody` runs it."""

from __future__ import annotations

import contextlib
import io
import re
import runpy
import sys
from collections.abc import Sequence
from functools import cache

import pytest


def run(arguments: Sequence[str]) -> int:
    """The exit status with these arguments; what it prints goes to this process's streams."""
    before, sys.argv = sys.argv, ["freebody", *arguments]
    try:
        runpy.run_module("freebody", run_name="__main__")
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.argv = before
    raise AssertionError("freebody ended without an exit status")


def told(arguments: Sequence[str]) -> tuple[int, str]:
    """The exit status with these arguments, and all that is printed."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = run(arguments)
    return status, said.getvalue()


@cache
def help_of(command: str) -> str:
    """The help of a command; of freebody as a whole for ""."""
    return told([command, "--help"] if command else ["--help"])[1]


@cache
def command_names() -> tuple[str, ...]:
    """The names of all commands."""
    listed = help_of("").partition("Commands")[2]
    return tuple(re.findall(r"^\W*([a-z]+) {2,}\S", listed, re.MULTILINE))


@cache
def commands() -> dict[str, str]:
    """The help of every command, by its name."""
    return {name: help_of(name) for name in command_names()}


def example(help_text: str) -> str:
    """The example of a command's help: what follows the program's name."""
    return " ".join(help_text.partition("Example: freebody ")[2].split())


def error(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """What a refused command says: one line, nothing on stdout, exit code 2."""
    assert run([*arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("error: ")
    assert said.err.count("\n") == 1
    assert "Traceback" not in said.err
    return said.err.removeprefix("error: ").rstrip("\n")
