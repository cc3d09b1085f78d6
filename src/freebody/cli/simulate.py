"""The command `freebody simulate`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import INTERRUPTED, numbers, options, terminal
from freebody.errors import FreebodyError, shown
from freebody.outputs.display import TextTable

if TYPE_CHECKING:
    import xarray as xr

    from freebody.arrays import Array
    from freebody.model.model import Model

EXAMPLE = 'Example: freebody simulate 2R --q "30 deg, -0.5" --torque pd --goal "1, 0.5" --time 3'
_ROWS = 400
_MOST = 1_000_000


@options.collected(
    wrench=options.USED,
    speed="the torques make the motion; there is none to run faster or slower.",
)
def simulate(
    context: typer.Context,
    robot: options.GivenRobot,
    q: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help='Positions at the start, rad and m, or "30 deg"; loops are closed near them. '
            "Default: 0, within the limits; of closed chains their home.",
        ),
    ] = None,
    qd: Annotated[
        str | None, typer.Option(metavar="VALUES", help="Rates at the start. Default: at rest.")
    ] = None,
    time: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", parser=numbers.number, help="Duration. Default: 2."),
    ] = None,
    torque: Annotated[
        str,
        typer.Option(
            metavar="zero|pd|computed_torque|FILE",
            help="zero: no torque. pd: gravity and springs are held, and each joint is "
            "driven to --goal. computed_torque: so that the error e of each joint obeys "
            "ë + kd ė + kp e = 0. A CSV file with t and the joints' names (N m, N): torques, "
            "linear between its rows, which also give the duration.",
        ),
    ] = "zero",
    goal: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES", help="Of a control law: positions. Default: those at the start."
        ),
    ] = None,
    kp: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="One value or one per joint; of pd: N m/rad or N/m, by default 100 times the "
            "inertia at the start; of computed_torque: 1/s², by default 100.",
        ),
    ] = None,
    kd: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="Of pd: N m s/rad or N s/m, by default 20 times that inertia; of "
            "computed_torque: 1/s, by default 20.",
        ),
    ] = None,
    friction: Annotated[
        Literal["smooth", "dry"],
        typer.Option(help="Dry friction about rest: smooth creeps, dry sticks."),
    ] = "smooth",
    restitution: Annotated[
        float | None,
        typer.Option(
            metavar="FRACTION",
            parser=numbers.number,
            help="Stops at the limits, from which a joint rebounds with this fraction of its "
            "speed, 0 to 1. Default: no stops.",
        ),
    ] = None,
    method: Annotated[
        str, typer.Option(metavar="NAME", help="As in fb.simulate: auto, rk4, Radau, …")
    ] = "auto",
    every: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", parser=numbers.number, help="Time between rows. Default: 400 rows."
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="File for the motion, for study --motion.")
    ] = Path("motion.csv"),
) -> None:
    """Simulate the motion that torques cause, and write it.

    Ctrl-C stops it and writes the motion so far, and so does a motion that cannot go on. Exit
    status 2: the motion cannot go on, or something cannot be read or written.
    """
    from freebody.motion.motion import FEWEST
    from freebody.motion.simulation.results import SimulationInterrupted, SimulationStopped
    from freebody.motion.simulation.simulate import simulate as run

    model = robot.load()
    wrenches = robot.wrenches(model)
    start, rates = _start(model, q, qd)
    times, law, given = _torque(model, torque, start, rates, (time, every), (goal, kp, kd))
    interrupted, given_up = False, None
    with terminal.warnings_as_lines(), terminal.progress("simulating") as tell:
        try:
            found = run(
                model,
                start,
                rates,
                times,
                law,
                wrenches,
                method=method,
                friction=friction,
                restitution=restitution,
                torque_inputs=given,
                progress=tell,
            )
        except SimulationInterrupted as stopped:
            found, interrupted = stopped.result, True
        except SimulationStopped as stopped:
            if stopped.result is None or len(stopped.result["time"]) < FEWEST:
                raise
            found, given_up = stopped.result, stopped
    _written(model, found, out, options.again(context), wrenches)
    if interrupted:
        raise typer.Exit(INTERRUPTED)
    if given_up is not None:
        raise given_up


def _start(model: Model, q: str | None, qd: str | None) -> tuple[Array, Array]:
    """Positions and rates at the start; loops are closed near the given positions."""
    import numpy as np

    from freebody.loops.assembly import assemble
    from freebody.motion.ranges import position_columns, ranges
    from freebody.trees.positions import neutral

    start = None if q is None else _vector("--q", q, model.nq, model)
    if model.loops:
        start = np.asarray(assemble(model, start))
    elif start is None:
        start, (iq, iv), usable = neutral(model), position_columns(model), ranges(model)
        start[iq] = np.clip(start[iq], usable.lower[iv], usable.upper[iv])
    rates = np.zeros(model.nv) if qd is None else _vector("--qd", qd, model.nv, model)
    return start, rates


def _vector(name: str, text: str, size: int, model: Model) -> Array:
    import numpy as np

    values = numbers.values(name, text)
    if len(values) != size:
        raise FreebodyError(f"{name} has {len(values)} values, {model.name!r} takes {size}.")
    return np.array(values)


def _torque(
    model: Model,
    torque: str,
    q: Array,
    qd: Array,
    course: tuple[float | None, float | None],
    law: tuple[str | None, str | None, str | None],
) -> tuple[Array, Any, dict[str, Array] | None]:
    """Times, the torques along them or a compiled control law, and the inputs that such a law takes
    besides the state."""
    import numpy as np

    if torque not in _LAWS:
        for name, text in zip(("--goal", "--kp", "--kd"), law, strict=True):
            if text is not None:
                raise FreebodyError(
                    f"{name} is of a control law, --torque {' or '.join(_LAWS)}; --torque is "
                    f"{shown(torque)}."
                )
    if torque not in ("zero", *_LAWS):
        from freebody.motion.files.csv_files import read_torques

        if not Path(torque).exists():
            raise FreebodyError(
                f"--torque {shown(torque)}: there is no such file; write {', '.join(_LAWS)}, zero, "
                f"or the name of a CSV file."
            )
        if course[0] is not None:
            raise FreebodyError(f"--time: the duration is that of {torque}; leave it out.")
        t, rows = read_torques(model, torque)
        # lines between the rows stay lines where there are more rows
        times = np.union1d(t, t[0] + _times(float(t[-1] - t[0]), course[1]))
        between = [np.interp(times, t, column) for column in rows.T]
        return times, np.stack(between, axis=-1), None
    times = _times(*course)
    if torque == "zero":
        return times, None, None
    from freebody.ways_out.kernel import kernel

    goal, kp, kd = law
    aim = q if goal is None else _vector("--goal", goal, model.nq, model)
    chosen = _LAWS[torque]
    defaults = chosen.gains(model, q)
    gains = [
        own if text is None else _gains(name, text, model)
        for name, text, own in zip(("--kp", "--kd"), (kp, kd), defaults, strict=True)
    ]
    given = {"q_ref": aim, **{name: np.zeros(model.nv) for name in chosen.at_rest}}
    given |= {"kp": gains[0], "kd": gains[1]}
    chosen.function()(model, q, qd, **given)  # which refuses what the law cannot be
    return times, kernel(model, chosen.quantity), given


@dataclass(frozen=True)
class _ControlLaw:
    """A control law that drives each joint to a goal.

    at_rest: its arguments that are 0 of a goal at rest. gains: (kp, kd) unless others are given.
    """

    quantity: str
    at_rest: tuple[str, ...]
    gains: Callable[[Model, Array], tuple[Array, Array]]

    def function(self) -> Callable[..., Any]:
        """The function that checks what the law is given."""
        from freebody.trees import controllers

        return getattr(controllers, self.quantity)


def _pd_gains(model: Model, q: Array) -> tuple[Array, Array]:
    from freebody.trees.controllers import default_pd_gains

    return default_pd_gains(model, q)


def _error_gains(model: Model, q: Array) -> tuple[Array, Array]:
    import numpy as np

    return np.full(model.nv, 100.0), np.full(model.nv, 20.0)


_LAWS = {
    "pd": _ControlLaw("pd_gravity", (), _pd_gains),
    "computed_torque": _ControlLaw("computed_torque", ("qd_ref", "qdd_ref"), _error_gains),
}
"""Control laws by their names after --torque."""


def _gains(name: str, text: str, model: Model) -> Array:
    """Gains of a controller, one for each coordinate."""
    import numpy as np

    values = numbers.values(name, text)
    return (
        np.full(model.nv, values[0]) if len(values) == 1 else _vector(name, text, model.nv, model)
    )


def _times(time: float | None, every: float | None) -> Array:
    import numpy as np

    from freebody.motion.motion import FEWEST

    duration = 2.0 if time is None else time
    gap = duration / _ROWS if every is None else every
    for name, value in (("--time", duration), ("--every", gap)):
        if not 0.0 < value < float("inf"):
            raise FreebodyError(f"{name} is {value:g}, expected seconds above 0.")
    if not FEWEST - 1.5 <= duration / gap <= _MOST:
        raise FreebodyError(
            f"--every {gap:g} makes {duration / gap + 1:.3g} rows of {duration:g} s; a motion has "
            f"from {FEWEST} to {_MOST}."
        )
    return np.linspace(0.0, duration, round(duration / gap) + 1)


def _written(
    model: Model,
    found: xr.Dataset,
    out: Path,
    again: str,
    wrenches: dict[str, list[float]] | None,
) -> None:
    """Write a simulated motion to a file, and print its largest values as a table."""
    import numpy as np

    from freebody.motion.files.csv_files import state_table
    from freebody.motion.ranges import angular
    from freebody.outputs.files import write
    from freebody.outputs.harmless_text import csv_text
    from freebody.report.load_case import in_a_line

    t, q, qd, qdd, tau = (found[n].values for n in ("time", "q", "qd", "qdd", "tau"))
    header, table = state_table(model, t, q, qd, qdd)
    path = write(out, csv_text([header, *table]))
    console = terminal.out()
    if "doubts" in found.attrs:
        terminal.warn(found.attrs["doubts"])
    console.print(f"{model.name}: {t[-1] - t[0]:.4g} s by {found.attrs['method']}.")
    console.print(in_a_line(model, wrenches))
    rows = []
    for k, name in enumerate(model.velocity_names):
        unit, effort = ("rad", "N m") if angular(model)[k] else ("m", "N")
        speed, most = np.abs(qd[:, k]).max(), np.abs(tau[:, k]).max()
        rows.append(
            (name, f"{speed:.4g} {unit}/s", f"{qd[-1, k]:.4g} {unit}/s", f"{most:.4g} {effort}")
        )
    terminal.table(TextTable(("joint", "largest speed", "at the end", "largest torque"), rows))
    console.print(f"written: {path}", soft_wrap=True)
    console.print(f"again:   {again}", soft_wrap=True)
