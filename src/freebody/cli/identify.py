"""The command `freebody identify`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli import numbers, options, terminal, verdicts
from freebody.errors import FreebodyError
from freebody.model.drives import assumed_by

if TYPE_CHECKING:
    from freebody.identification.collisions import DetectedCollisions
    from freebody.identification.identification import Identification
    from freebody.identification.identified_payload import IdentifiedPayload
    from freebody.identification.logs.log import Log
    from freebody.model.model import Model

EXAMPLE = "Example: freebody identify scara simulated --validate simulated --out identified"


@dataclass(frozen=True)
class LogUses:
    """Logs by what they are for, besides those that the model is made from."""

    validate: Annotated[
        list[str] | None,
        typer.Option(metavar="LOG", help="A log to predict, which is used for nothing else."),
    ] = None
    loaded: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LOG",
            help="A log of currents with a load of known mass at the tip, which tells the scale of "
            "unknown gains.",
        ),
    ] = None
    payload_of: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LOG",
            help="A log of the same robot with a load at its tip, whose mass, centre and inertia "
            "are then told.",
        ),
    ] = None
    collisions_in: Annotated[
        str | None,
        typer.Option(metavar="LOG", help="A log that is searched for collisions."),
    ] = None
    layout: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The TOML file that tells the logs' columns."),
    ] = None

    def names(self, logs: list[str]) -> dict[str, list[str]]:
        """The names of all logs by their use, in the order of the seeds of simulated ones."""
        return {
            "logs": logs,
            "validate": self.validate or [],
            "payload of": self.payload_of or [],
            "collisions in": [] if self.collisions_in is None else [self.collisions_in],
            "loaded": self.loaded or [],
        }

    def read(self, logs: list[str], model: Model) -> dict[str, list[Log]]:
        """All logs by their use."""
        return {
            use: [self._log(text, model, seed) for text in texts]
            for seed, (use, texts) in enumerate(self.names(logs).items())
        }

    def _log(self, text: str, model: Model, seed: int) -> Log:
        from freebody.identification.logs.read_log import read_log
        from freebody.identification.simulated import simulated_log

        return verdicts.measured(
            text,
            lambda file: read_log(file, model, layout=self.layout),
            lambda: simulated_log(model, seed),
        )


@dataclass(frozen=True)
class Assumed:
    """Options that tell what is known or assumed of the robot before its logs are looked at."""

    friction: Annotated[
        str | None,
        typer.Option(
            metavar="LAWS",
            help=f"Laws of friction, apart by commas. Default: {','.join(assumed_by('identify'))}; "
            "losses by load where no joint follows another.",
        ),
    ] = None
    masses: Annotated[
        str | None,
        typer.Option(
            metavar="VALUES",
            help="Masses of the links in order, kg, as a data sheet has them. Default: the robot's "
            "own, if it has some.",
        ),
    ] = None
    load: Annotated[
        float | None, typer.Option(metavar="KG", help="The mass of the load of --loaded, kg.")
    ] = None
    rotors: Annotated[
        bool, typer.Option(help="Whether the drives' rotors have unknown inertias.")
    ] = True
    lmi: Annotated[
        bool,
        typer.Option(
            "--lmi",
            help="Take the physical robot nearest to the logs, by linear matrix inequalities "
            "(extra lmi), instead of one near what is held beforehand.",
        ),
    ] = False

    @property
    def laws(self) -> dict[str, Any]:
        """The laws of friction, as an argument of `fb.identify`."""
        given = self.friction
        return {} if given is None else {"friction": [x.strip() for x in given.split(",")]}

    @property
    def arguments(self) -> dict[str, Any]:
        """All of it, as arguments of `fb.identify`."""
        held = {"load": self.load, "rotors": self.rotors, "lmi": self.lmi, **self.laws}
        if self.masses is not None:
            held["prior"] = numbers.values("--masses", self.masses)
        return held


@options.collected(
    wrench="logs are of the robot by itself; a load of known mass is --loaded with --load.",
    speed="the logs tell how fast the robot moved.",
)
def identify(
    context: typer.Context,
    robot: options.GivenRobot,
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG…",
            help="Logs of the robot (.csv, .parquet), with a TOML file of their columns beside "
            "them where the names of these do not tell; or simulated, a log made from the model.",
        ),
    ],
    uses: LogUses,
    assumed: Assumed,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for the page (index.html), the robot (model.toml), the report, and it as "
            "JSON.",
        ),
    ] = None,
) -> None:
    """A robot's masses, rotors and friction from its logs, with intervals, and a model that
    predicts its torques.

    Exit status 0: the model predicts the logs of --validate about as well as those that it was
    made from. 1: it does not, there are none, the scale of its masses is not told to a tenth, or
    the logs speak against the geometry or against one another. 2: bad input.
    """
    from freebody.identification.identify import identify as identified
    from freebody.identification.result_files import write_results
    from freebody.report.identification_page import identification_page

    with terminal.progress("reading"):
        model = robot.load()
        read = uses.read(logs, model)
    held = assumed.arguments
    with terminal.progress("identify"):
        of_logs = {use: read[use] for use in ("validate", "loaded")}
        found = identified(model, read["logs"], **of_logs, **held)
        carried = _carried(found, read["payload of"], read["logs"], assumed.laws)
        pushes = _pushes(found, read["collisions in"])
    beside = [x for x in (carried, pushes) if x is not None]
    write = None
    if out is not None:
        names = [text for texts in uses.names(logs).values() for text in texts]
        page = partial(identification_page, found, carried, pushes)
        write = partial(write_results, found, out, names, page, carried, pushes)
    verdicts.conclude(context, found, beside, write)


def _carried(
    found: Identification, loaded: list[Log], empty: list[Log], laws: dict[str, Any]
) -> IdentifiedPayload | None:
    """The load of logs with it, or None where there are none."""
    from freebody.identification.identify_payload import identify_payload

    if not loaded:
        return None
    if not found.scale_known:
        raise FreebodyError(
            "--payload-of: the load's mass is not told, since the logs have currents whose gains "
            "have an unknown factor. Give torque constants in the TOML file beside the logs, or "
            "logs with a weighed load, --loaded and --load."
        )
    return identify_payload(found.model, loaded, empty, gains=found.gains, **laws)


def _pushes(found: Identification, searched: list[Log]) -> DetectedCollisions | None:
    """The collisions in a log, or None where there is none."""
    from freebody.identification.collisions import detect_collisions

    if not searched:
        return None
    return detect_collisions(found.model, searched[0], gains=found.gains)
