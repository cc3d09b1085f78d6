"""The command `freebody check`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from freebody.cli import numbers, options, terminal
from freebody.errors import FileError, FreebodyError
from freebody.outputs.files import write

EXAMPLE = "Example: freebody check 2R 'H22 = m2*lc2^2 + I2' 'G2 = m2*g*lc2*cos(theta1+theta2)'"

_LARGEST = 80_000
"""Bytes of standard input; far more than an answer may have characters."""


@options.collected(
    wrench="an answer names its own forces, such as fx and fy at the tip.",
    speed="equations hold for motions of any speed.",
)
def check(
    robot: options.GivenRobot,
    answer: Annotated[
        list[str],
        typer.Argument(
            help="A file (.txt, .md, .tex, .ipynb, .py) with equations as text, LaTeX or Python; "
            "or equations, each a line of one answer; - for stdin."
        ),
    ],
    names: Annotated[
        list[str] | None,
        typer.Option(
            "--name",
            metavar="YOURS=OURS",
            help="What one of your own names stands for, such as L1=l1.",
        ),
    ] = None,
    absolute: Annotated[
        bool,
        typer.Option(
            "--absolute",
            help="Your angles are those of the links themselves, all from one direction, and your "
            "torques those of these angles; without it each angle is from the previous link.",
        ),
    ] = False,
    notation: options.NotationOption = None,
    form: Annotated[
        str | None,
        typer.Option(
            "--form",
            metavar="FORM",
            help="How the answer is written where no file's suffix tells it: text, markdown, "
            "latex, notebook or python.",
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at",
            metavar="STATE",
            help="The state of results that are numbers, such as 'theta1 = 30 deg, theta2 = 0, "
            "theta1_d = 2 rad/s'; the answer may contain it instead.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.html",
            help="The verdict as a page: the answer with its marks, the reasons, and folded away "
            "what would be right.",
        ),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            metavar="SHARE",
            help="Tolerance of numbers, 0.01 for 1 %. Default: half a unit of the last digit.",
        ),
    ] = None,
) -> None:
    """Compare your own equations (tau1, H12, c1, G1, J11, T, V, …) with the robot's, and name the
    mistakes.

    From Markdown, LaTeX and notebooks the equations are taken, and the words between them passed
    over. Exit status 0: all are right. 1: a mistake was found. 2: something cannot be read.
    """
    from freebody_textbook.check.check import check as verdict_on
    from freebody_textbook.check.spelling.answer_text import AnswerError

    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise FreebodyError(f"--out is {out.name!r}, expected an .html file.")
    own = _answer(answer)
    meanings = numbers.pairs("--name", names, "L1=l1")
    model, parameters = robot.in_symbols()
    try:
        with terminal.progress("comparing"):
            verdict = verdict_on(
                model,
                own,
                meanings,
                absolute=absolute,
                form=form,
                notation=notation,
                at=", ".join(at) if at else None,
                tolerance=tolerance,
                parameters=parameters,
            )
    except FileError as error:
        if error.path != str(own):
            raise
        hint = "an answer is a file, an equation such as 'H12 = …', or - for what is piped in"
        raise FileError(str(own), None, f"{error.problem.rstrip('.')}; {hint}.") from None
    except AnswerError as problem:
        terminal.error(problem.problem)
        if problem.context:
            terminal.err().print(problem.context, highlight=False, soft_wrap=True)
        raise typer.Exit(2) from None
    terminal.out().print(verdict.text, soft_wrap=True)
    if out is not None:
        terminal.out().print(f"written: {write(out, verdict.html())}", soft_wrap=True)
    if not verdict:
        raise typer.Exit(2 if all(equation.equal for equation in verdict.equations) else 1)


def _answer(given: list[str]) -> str | Path:
    """The answer: the path of a file, the text from stdin, or the arguments as lines."""
    from freebody.formats import read_file

    answer = "\n".join(given)
    if len(given) > 1:
        if other := next((x for x in given if "=" not in x), None):
            raise FreebodyError(
                f"check: {other!r} is no equation; give one file, or equations such as 'H12 = …'."
            )
        return answer
    if answer == "-":
        data = sys.stdin.buffer.read(_LARGEST + 1) if sys.stdin else b""
        if len(data) > _LARGEST:
            raise FreebodyError(
                f"check: standard input gives more than {_LARGEST // 1000} kB, too much for an "
                f"answer."
            )
        return read_file.decoded("standard input", data)
    return answer if "=" in answer or "\n" in answer else Path(answer)
