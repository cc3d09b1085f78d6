"""The command `freebody export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from freebody.cli import options, terminal

EXAMPLE = "Example: freebody export ur5e inverse_dynamics mass_matrix --language c --out controller"


QuantitiesArgument = Annotated[
    list[str],
    typer.Argument(
        metavar="QUANTITY…",
        help="What the function computes: inverse_dynamics, mass_matrix, jacobian, …",
    ),
]
LanguageOption = Annotated[
    str,
    typer.Option(
        help="c, cpp, javascript, javascript-script, rust, julia, matlab, numpy, jax, "
        "casadi or cuda (PTX)."
    ),
]
_Out = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder for the files. Default: export-ROBOT."),
]
WordOption = Annotated[
    str | None,
    typer.Option(metavar="WORD", help="Name of the function. Default: from the quantities."),
]
_NumberType = Annotated[
    Literal["float64", "float32"],
    typer.Option(help="Number type (float32 only for c, rust, julia and cuda)."),
]
_Reference = Annotated[
    str, typer.Option(help="Axes of Jacobians and wrenches: world, body or child.")
]
WrenchFramesOption = Annotated[
    list[str] | None,
    typer.Option(metavar="FRAME", help="A frame that carries a wrench; may be repeated."),
]
InputsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--input",
        metavar="NAME",
        help="A number of the robot that is given at each call, such as '*.mass'; may be repeated.",
    ),
]
_By = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ARGUMENT",
        help="Derivatives by this argument as well, such as q, "
        "or p for the numbers of --input; may be repeated.",
    ),
]
RowsOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ROW",
        help="Restrict operational-space quantities to vx, vy, vz, wx, wy or wz; may be repeated.",
    ),
]


@options.collected(
    speed="the exported function is given rates and accelerations; there is no motion.",
)
def export(
    robot: options.GivenRobot,
    quantities: QuantitiesArgument,
    language: LanguageOption = "c",
    out: _Out = None,
    name: WordOption = None,
    dtype: _NumberType = "float64",
    frame: options.FrameOption = None,
    reference: _Reference = "world",
    wrench: WrenchFramesOption = None,
    inputs: InputsOption = None,
    by: _By = None,
    row: RowsOption = None,
) -> None:
    """Write what freebody computes for a robot as source text that needs nothing else, with a
    self-test.

    The folder's README.txt has the command that compiles and runs the self-test.
    """
    with terminal.progress("reading") as progress:
        from freebody.ways_out.exports import export as write

        model = robot.load()
        progress(f"writing {language}", 0.3)
        paths = write(
            model,
            quantities,
            out or Path(f"export-{Path(robot.name).stem}"),
            language,
            name=name,
            dtype=dtype,
            frame=frame,
            reference=reference,
            wrench_frames=wrench or (),
            inputs=inputs or (),
            by=by or (),
            rows=row,
        )
    for path in paths:
        terminal.out().print(f"written: {path}", soft_wrap=True)
