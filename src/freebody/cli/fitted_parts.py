"""The options that tell of brakes and bearings by which a robot is judged."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from freebody.cli import numbers
from freebody.errors import FreebodyError

GivenCatalogue = Annotated[
    str | None,
    typer.Option(metavar="FILE", help="The catalogue of --brake and --bearing, TOML."),
]
GivenBrakes = Annotated[
    list[str] | None,
    typer.Option(
        metavar="JOINT=MOTOR,GEAR",
        help="The motor whose brake has to hold a joint through a gear, wherever the robot is.",
    ),
]
GivenBearings = Annotated[
    list[str] | None,
    typer.Option(
        metavar="JOINT=BEARING",
        help="The bearing of a joint, judged by its static load and its moment limit.",
    ),
]


def read(
    catalogue: str | None, brakes: list[str] | None, bearings: list[str] | None
) -> dict[str, Any]:
    """The brakes and bearings of joints, out of a catalogue."""
    from freebody.design.catalogue import catalogue as catalogue_of

    given = ("--brake", brakes), ("--bearing", bearings)
    asked = [option for option, texts in given if texts]
    if catalogue is None:
        if asked:
            raise FreebodyError(
                f"{asked[0]}: give the file in which the parts are, --catalogue FILE."
            )
        return {}
    if not asked:
        raise FreebodyError(
            "--catalogue: say which of its parts the joints have, --brake JOINT=MOTOR,GEAR or "
            "--bearing JOINT=BEARING."
        )
    parts, held = catalogue_of(catalogue), {}
    for joint, names in numbers.pairs("--brake", brakes, "joint1=M200,W25-100").items():
        motor, _, gear = (x.strip() for x in names.partition(","))
        held[joint] = parts.motor(motor), parts.gear(gear)
    fitted = numbers.pairs("--bearing", bearings, "joint1=B70").items()
    return {
        "brakes": held or None,
        "bearings": {joint: parts.bearing(name) for joint, name in fitted},
    }
