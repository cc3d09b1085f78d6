"""The command `freebody sweep`."""

from __future__ import annotations

import csv
import io
import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import options, terminal
from freebody.errors import FreebodyError, shown
from freebody.outputs.display import TextTable

if TYPE_CHECKING:
    import xarray as xr

    from freebody.model.model import Model

EXAMPLE = "Example: freebody sweep 2R inverse_dynamics --over m2=0.5:3:6 --over l1=0.2:0.6:3"
_SHOWN = 40
"""Rows of a result that are printed."""


@options.collected(
    wrench="a sweep varies numbers of the robot; a wrench is none (fb.sweep takes functions).",
    speed="a sweep takes its motion as it is; write a faster one with study or fb.Motion.faster.",
)
def sweep(
    robot: options.GivenRobot,
    function: Annotated[
        str, typer.Argument(help="Name of a formula, such as inverse_dynamics or jacobian.")
    ],
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=LOW:HIGH[:COUNT]",
            help="A number of the robot and the values it takes: COUNT evenly spaced, or without "
            "it those that --samples spreads; may be repeated.",
        ),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="COUNT",
            help="So many robots, spread over all ranges without a COUNT together.",
        ),
    ] = None,
    method: Annotated[
        str, typer.Option(help="How they are spread: sobol, latin-hypercube or random.")
    ] = "sobol",
    motion: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="The states are those of this motion, a CSV file."),
    ] = None,
    states: Annotated[
        int | None,
        typer.Option(min=1, metavar="COUNT", help="The states are so many random ones."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of random states and samples.")] = 0,
    frame: options.FrameOption = None,
    reduce: Annotated[
        str, typer.Option(metavar="NAMES", help="Such as peak, rms, max, mean or p99, by commas.")
    ] = "peak",
    store: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="A Zarr store, from which a sweep that was stopped goes on."
        ),
    ] = None,
    client: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Of a Dask cluster's scheduler.")
    ] = None,
    cpu: Annotated[
        str | None,
        typer.Option(
            metavar="LEVEL",
            help="Processors that give the same last digits, such as x86-64-v3; else this one's.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="CSV file for the whole table.")
    ] = None,
) -> None:
    """Evaluate a formula for many robots along a motion, or at random states, and print what it
    reduces to.

    Without --motion and --states the motion is the one that a study takes. Exit status 1: some
    points have no value. 2: something cannot be read, computed or written.
    """  # fmt: skip
    from freebody.outputs.files import write
    from freebody.sweeps.sweep import sweep as sweep_of

    model = robot.load()
    axes = _axes(over or [], samples, method, seed)
    axes[_free("state", axes)] = _states(model, function, frame, motion, states, seed)
    names = [name.strip() for name in reduce.split(",")]
    with terminal.warnings_as_lines(), terminal.progress("compiling") as progress:
        found = sweep_of(
            model,
            function,
            over=axes,
            reduce=names,
            frame=frame,
            store=store,
            client=client,
            cpu=cpu,
            progress=progress,
        )
    head, rows = _table(found, list(axes)[:-1])
    if out is not None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([head, *rows])
        write(out, text.getvalue())
    _print(model, found, head, rows, out)
    if found.attrs["failed"]:
        raise typer.Exit(1)


def _axes(over: list[str], samples: int | None, method: str, seed: int) -> dict[str, Any]:
    """The sweep's axes from --over options: one for each range with a count, and one for all ranges
    that are sampled."""
    import numpy as np

    from freebody.sweeps.samples import samples as samples_of

    axes: dict[str, Any] = {}
    ranges: dict[str, tuple[float, float]] = {}
    for text in over:
        name, low, high, count = _range(text)
        if name in axes or name in ranges:
            raise FreebodyError(f"--over {shown(text)}: {name!r} is given twice; give it once.")
        if count is not None:
            axes[name] = np.linspace(low, high, count)
        elif samples is None:
            raise FreebodyError(
                f"--over {shown(text)} has no COUNT: write {name}=LOW:HIGH:COUNT, or say with "
                f"--samples how many robots are spread over the ranges."
            )
        else:
            ranges[name] = low, high
    if samples is not None:
        if not ranges:
            raise FreebodyError("--samples spreads robots over ranges; give --over NAME=LOW:HIGH.")
        axes[_free("design", axes)] = samples_of(samples, ranges, method=method, seed=seed)
    return axes


def _free(name: str, axes: dict[str, Any]) -> str:
    """The name, with underscores appended until no axis has the same one."""
    return _free(f"{name}_", axes) if name in axes else name


def _range(text: str) -> tuple[str, float, float, int | None]:
    """Name, ends and count of a range typed as name=low:high:count; the count is None where it is
    left out."""
    from freebody.formats import read_file

    name, equals, rest = text.rpartition("=")
    pieces = [x.strip() for x in rest.split(":")]
    low, high = (read_file.number(x) for x in (*pieces, "", "")[:2])
    count = pieces[2] if len(pieces) == 3 else "1"
    if (
        not (equals and name.strip() and low is not None and high is not None)
        or len(pieces) > 3
        or not (count.isascii() and count.isdigit() and 0 < int(count) <= 10**7)
    ):
        raise FreebodyError(
            f"--over {shown(text)} is not NAME=LOW:HIGH:COUNT; write for example m2=0.5:3:6, or "
            f"m2=0.5:3 with --samples."
        )
    return name.strip(), low, high, int(count) if len(pieces) == 3 else None


def _states(
    model: Model,
    function: str,
    frame: str | None,
    motion: str | None,
    states: int | None,
    seed: int,
) -> Any:
    """The sweep's last axis: random states, or the samples of a motion."""
    from freebody.any_chain.kernel_options import chosen_option
    from freebody.kernels.tracing import arguments
    from freebody.motion.default_motion import default_motion
    from freebody.motion.files.csv_files import read_motion
    from freebody.trees.positions import random_state

    if motion is not None and states is not None:
        raise FreebodyError("--motion and --states both say at which states; give one of them.")
    formulas, option = chosen_option(model, function, frame=frame)
    needed = [x.name for x in arguments(model, formulas, option)]
    if states is None:
        return default_motion(model) if motion is None else read_motion(model, motion)
    every = dict(zip(("q", "qd", "qdd"), random_state(model, seed, states), strict=True))
    return {name: x for name, x in every.items() if name in needed}


def _table(found: xr.Dataset, axes: list[str]) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a table of a sweep's results: a row for each robot, a column for each
    quantity that varies and for each number computed."""
    sizes = [found.sizes[name] for name in axes]
    along = [[x for x in found.coords if found[x].dims == (name,)] for name in axes]
    head, columns = [str(x) for names in along for x in names], []
    for label, values in found.data_vars.items():
        if label == "failed":
            continue
        inner = values.dims[len(axes) :]
        for place in itertools.product(*(range(found.sizes[x]) for x in inner)):
            told = [
                str(found[x].values[k]) if x in found.coords else str(k)
                for x, k in zip(inner, place, strict=True)
            ]
            head.append(" ".join([str(label), *told]))
            columns.append(values.values[(..., *place)].ravel())
    if found.attrs["failed"]:
        head.append("failed")
        columns.append(found.failed.values.ravel())
    rows = []
    for k, place in enumerate(itertools.product(*(range(n) for n in sizes))):
        at = [
            f"{found[x].values[i]:.6g}"
            for names, i in zip(along, place, strict=True)
            for x in names
        ]
        rows.append([*at, *(f"{column[k]:.6g}" for column in columns)])
    return head, rows


def _print(
    model: Model, found: xr.Dataset, head: list[str], rows: list[list[str]], out: Path | None
) -> None:
    to = terminal.out()
    if "doubts" in found.attrs:
        terminal.warn(found.attrs["doubts"])
    to.print(f"{model.name}: {found.attrs['points']} points.")
    left = len(rows) - _SHOWN
    terminal.table(TextTable(head, rows[:_SHOWN]))
    if left > 0:
        where = "the file has all" if out else "--out FILE writes all"
        to.print(f"… and {left} more; {where}.")
    for text in found.attrs["failures"]:
        to.print(f"failed {text}", style="bold red", soft_wrap=True)
    if out is not None:
        to.print(f"written: {out}", soft_wrap=True)
