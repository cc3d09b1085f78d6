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


@dataclass(frozen=True)
class Start:
    """The state at the start, as it was typed."""

    q: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help='Positions at the start, rad and m, or "30 deg"; loops are closed near them. '
            "Default: 0, within the limits; of closed chains their home.",
        ),
    ] = None
    qd: Annotated[
        str | None, typer.Option(metavar="VALUES", help="Rates at the start. Default: at rest.")
    ] = None

    def of(self, model: Model) -> tuple[Array, Array]:
        """Positions and rates at the start; loops are closed near the given positions."""
        import numpy as np

        from freebody.loops.assembly import assemble
        from freebody.motion.ranges import position_columns, ranges
        from freebody.trees.positions import neutral

        q = None if self.q is None else _vector("--q", self.q, model.nq, model)
        if model.loops:
            q = np.asarray(assemble(model, q))
        elif q is None:
            q, (iq, iv), usable = neutral(model), position_columns(model), ranges(model)
            q[iq] = np.clip(q[iq], usable.lower[iv], usable.upper[iv])
        qd = np.zeros(model.nv) if self.qd is None else _vector("--qd", self.qd, model.nv, model)
        return q, qd


@dataclass(frozen=True)
class Course:
    """How long the motion is, and how often it is told."""

    time: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", parser=numbers.number, help="Duration. Default: 2."),
    ] = None
    every: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", parser=numbers.number, help="Time between rows. Default: 400 rows."
        ),
    ] = None

    def times(self, duration: float | None = None) -> Array:
        """The instants, s, of a motion of --time or of a given duration."""
        import numpy as np

        from freebody.motion.motion import FEWEST

        if duration is None:
            duration = 2.0 if self.time is None else self.time
        gap = duration / _ROWS if self.every is None else self.every
        for name, value in (("--time", duration), ("--every", gap)):
            if not 0.0 < value < float("inf"):
                raise FreebodyError(f"{name} is {value:g}, expected seconds above 0.")
        if not FEWEST - 1.5 <= duration / gap <= _MOST:
            raise FreebodyError(
                f"--every {gap:g} makes {duration / gap + 1:.3g} rows of {duration:g} s; a motion "
                f"has from {FEWEST} to {_MOST}."
            )
        return np.linspace(0.0, duration, round(duration / gap) + 1)


Torques = tuple["Array", Any, "dict[str, Array] | None"]
"""Times, the torques along them or a compiled control law, and the inputs that such a law takes
besides the state."""


@dataclass(frozen=True)
class Control:
    """Options that tell what exerts the torques, and to which goal."""

    torque: Annotated[
        str,
        typer.Option(
            metavar="zero|pd|computed_torque|FILE",
            help="zero: no torque. pd: gravity and springs are held, and each joint is "
            "driven to --goal. computed_torque: so that the error e of each joint obeys "
            "ë + kd ė + kp e = 0. A CSV file with t and the joints' names (N m, N): torques, "
            "linear between its rows, which also give the duration.",
        ),
    ] = "zero"
    goal: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES", help="Of a control law: positions. Default: those at the start."
        ),
    ] = None
    kp: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="One value or one per joint; of pd: N m/rad or N/m, by default 100 times the "
            "inertia at the start; of computed_torque: 1/s², by default 100.",
        ),
    ] = None
    kd: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="Of pd: N m s/rad or N s/m, by default 20 times that inertia; of "
            "computed_torque: 1/s, by default 20.",
        ),
    ] = None

    def torques(self, model: Model, q: Array, qd: Array, course: Course) -> Torques:
        """The torques from a state on."""
        if self.torque in _LAWS:
            return self._of_law(model, q, qd, course)
        for name in ("goal", "kp", "kd"):
            if getattr(self, name) is not None:
                raise FreebodyError(
                    f"--{name} is of a control law, --torque {' or '.join(_LAWS)}; --torque is "
                    f"{shown(self.torque)}."
                )
        return (
            (course.times(), None, None) if self.torque == "zero" else self._of_file(model, course)
        )

    def _of_file(self, model: Model, course: Course) -> Torques:
        """The torques of a file, linear between its rows."""
        import numpy as np

        from freebody.motion.files.csv_files import read_torques

        if not Path(self.torque).exists():
            raise FreebodyError(
                f"--torque {shown(self.torque)}: there is no such file; write {', '.join(_LAWS)}, "
                f"zero, or the name of a CSV file."
            )
        if course.time is not None:
            raise FreebodyError(f"--time: the duration is that of {self.torque}; leave it out.")
        t, rows = read_torques(model, self.torque)
        # lines between the rows stay lines where there are more rows
        times = np.union1d(t, t[0] + course.times(float(t[-1] - t[0])))
        between = [np.interp(times, t, column) for column in rows.T]
        return times, np.stack(between, axis=-1), None

    def _of_law(self, model: Model, q: Array, qd: Array, course: Course) -> Torques:
        """A control law that drives each joint to its goal, compiled."""
        import numpy as np

        from freebody.ways_out.kernel import kernel

        chosen = _LAWS[self.torque]
        aim = q if self.goal is None else _vector("--goal", self.goal, model.nq, model)
        kp, kd = (
            own if text is None else _gains(name, text, model)
            for name, text, own in zip(
                ("--kp", "--kd"), (self.kp, self.kd), chosen.gains(model, q), strict=True
            )
        )
        given = {"q_ref": aim, **{name: np.zeros(model.nv) for name in chosen.at_rest}}
        given |= {"kp": kp, "kd": kd}
        chosen.function()(model, q, qd, **given)  # which refuses what the law cannot be
        return course.times(), kernel(model, chosen.quantity), given


@options.collected(
    wrench=options.USED,
    speed="the torques make the motion; there is none to run faster or slower.",
)
def simulate(
    context: typer.Context,
    robot: options.GivenRobot,
    start: Start,
    course: Course,
    control: Control,
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
    q, qd = start.of(model)
    times, law, given = control.torques(model, q, qd, course)
    interrupted, given_up = False, None
    with terminal.warnings_as_lines(), terminal.progress("simulating") as tell:
        try:
            found = run(
                model,
                q,
                qd,
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


def _vector(name: str, text: str, size: int, model: Model) -> Array:
    import numpy as np

    values = numbers.values(name, text)
    if len(values) != size:
        raise FreebodyError(f"{name} has {len(values)} values, {model.name!r} takes {size}.")
    return np.array(values)


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
