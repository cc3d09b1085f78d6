"""Arguments that commands share: the robot, and how its file is read."""

from __future__ import annotations

import math
import re
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from freebody.cli import terminal
from freebody.errors import FreebodyError, shown

if TYPE_CHECKING:
    from freebody.model.model import Model


class BaseChoice(StrEnum):
    """Whether the root link is held."""

    fixed = "fixed"
    free = "free"


class MimicChoice(StrEnum):
    """What mimic joints do."""

    follow = "follow"
    free = "free"


class PhysicalChoice(StrEnum):
    """What becomes of inertias that no body has."""

    warn = "warn"
    refuse = "refuse"
    ignore = "ignore"


class ConventionChoice(StrEnum):
    """Of a Denavit-Hartenberg table."""

    standard = "standard"
    modified = "modified"


class LabelChoice(StrEnum):
    """What stands beside arrows, angles and lengths."""

    names = "names"
    values = "values"
    both = "both"


Robot = Annotated[
    str,
    typer.Argument(
        help="A .urdf, .toml or .csv (DH table) file, a bundled model's name, "
        "or letters such as RRP."
    ),
]
Tip = Annotated[
    str | None,
    typer.Option(help="The frame that is the tip. Default: the end behind the most joints."),
]
Base = Annotated[
    BaseChoice | None,
    typer.Option(help="Fix the root link, or let it float. Default: as in the file."),
]
Mimic = Annotated[
    MimicChoice,
    typer.Option(help="Whether mimic joints follow the joint they mimic, or move freely."),
]
Physical = Annotated[
    PhysicalChoice, typer.Option(help="What to do about a physically impossible inertia.")
]


def number(text: str | float) -> float:
    """An option's number; the parser's own would also take 1_0 and digits of other scripts."""
    from freebody.formats import number_text

    value = number_text.number(text) if isinstance(text, str) else text
    if value is None or number_text.fault(value):
        raise typer.BadParameter(f"{shown(text)} is not a number that can be used.")
    return value


def values(what: str, text: str) -> list[float]:
    """Numbers apart by commas or blanks; a number with "deg" is an angle in degrees."""
    from freebody.formats import number_text

    found = []
    for piece in re.sub(r" ?(deg|°)", r"deg", " ".join(text.split())).replace(",", " ").split():
        value = number_text.number(piece.removesuffix("deg"))
        if value is None or number_text.fault(value):
            raise FreebodyError(
                f"{what} {shown(text)}: {shown(piece)} is not a number that can be used; "
                f'write for example {what} "0.5, 30 deg".'
            )
        found.append(math.radians(value) if piece.endswith("deg") else value)
    return found


Snap = Annotated[
    float,
    typer.Option(
        metavar="RAD",
        parser=number,
        help="Angles of a URDF this close (rad) to a multiple of a right angle are read as that "
        "multiple.",
    ),
]
Estimate = Annotated[
    float | None,
    typer.Option(
        "--estimate-inertia",
        metavar="KG",
        parser=number,
        help="The robot's whole mass: inertias of a URDF are estimated from its shapes instead of "
        "read.",
    ),
]
Convention = Annotated[
    ConventionChoice | None,
    typer.Option(help="The convention of a DH table that does not state it."),
]


def load(
    robot: str,
    tip: str | None = None,
    base: BaseChoice | None = None,
    mimic: MimicChoice = MimicChoice.follow,
    physical: PhysicalChoice = PhysicalChoice.warn,
    snap_angles: float = 3e-9,
    convention: ConventionChoice | None = None,
    estimate_inertia: float | None = None,
) -> Model:
    """The model; warnings become yellow lines."""
    from freebody.formats.loading import load as load_model

    with terminal.warnings_as_lines():
        return load_model(
            robot,
            tip=tip,
            base=base.value if base else None,
            mimic=mimic.value,
            physical=physical.value,
            snap_angles=snap_angles,
            convention=convention.value if convention else None,
            estimate_inertia=estimate_inertia,
        )
