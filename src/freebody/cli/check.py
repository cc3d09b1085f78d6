"""`freebody check`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from freebody.cli import options, terminal
from freebody.errors import FileError, FreebodyError

EXAMPLE = "Example: freebody check 2R 'H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2'"

_LARGEST = 80_000
"""Bytes of a file; far more than an answer may have characters."""


def check(
    robot: options.Robot,
    answer: Annotated[
        str,
        typer.Argument(
            help="A file with equations, one a line, as text or LaTeX; or an equation; - for stdin."
        ),
    ],
    names: Annotated[
        list[str] | None,
        typer.Option(
            "--name", metavar="YOURS=OURS", help="What a name of your own stands for, such as L1=l1."
        ),
    ] = None,
    convention: options.Convention = None,
) -> None:
    """Compare your own equations (tau1, H12, c1, G1, J11, T, V, …) with the robot's, and name the mistakes.

    Exit code 0: all are right. 1: a mistake was found. 2: something cannot be read.
    """
    from freebody.derivations.check.check import check as verdict_on
    from freebody.derivations.check.source import AnswerError

    text = _text(answer)
    meanings = dict(map(_renaming, names or []))
    model = options.load(robot, convention=convention)
    try:
        with terminal.progress("comparing"):
            verdict = verdict_on(model, text, meanings)
    except AnswerError as problem:
        terminal.error(problem.problem)
        if problem.context:
            terminal.err().print(problem.context, markup=False, highlight=False, soft_wrap=True)
        raise typer.Exit(2) from None
    terminal.out().print(verdict.text, markup=False, soft_wrap=True)
    if not verdict:
        raise typer.Exit(1)


def _text(answer: str) -> str:
    """What a file, stdin or the argument itself says."""
    if answer == "-":
        return sys.stdin.read(_LARGEST)
    if "=" in answer or "\n" in answer:
        return answer
    path = Path(answer)
    try:
        with path.open("rb") as file:
            return file.read(_LARGEST).decode("utf-8")
    except OSError as problem:
        reason = (problem.strerror or str(problem)).lower()
        raise FileError(
            answer, None, f"{reason}; an answer is a file or an equation such as 'H12 = …'"
        ) from None
    except UnicodeDecodeError:
        raise FileError(answer, None, "this is no text file in UTF-8") from None


def _renaming(text: str) -> tuple[str, str]:
    """L1=l1."""
    name, equals, meaning = text.partition("=")
    if not (name.strip() and equals and meaning.strip()):
        raise FreebodyError(f"--name {text}: write your name, =, and what it stands for, such as L1=l1.")
    return name.strip(), meaning.strip()
