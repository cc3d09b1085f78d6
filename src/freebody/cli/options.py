"""Arguments that commands share: the robot, and how its file is read."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import terminal
from freebody.errors import FreebodyError, shown

if TYPE_CHECKING:
    from freebody.model.model import Model


Robot = Annotated[
    str,
    typer.Argument(
        help="A .urdf, .xacro, .xml (MJCF), .sdf, .toml or .csv (DH table) file, a bundled "
        "model's name, or letters such as RRP."
    ),
]
Tip = Annotated[
    str | None,
    typer.Option(
        metavar="FRAME",
        help="The frame that is the tip. Default: the file's, else one that is called tcp, tool0, "
        "flange, ee… or grasp…, else the end of the longest chain, grippers taken off.",
    ),
]
FrameOption = Annotated[
    str | None,
    typer.Option(metavar="FRAME", help="Frame of kinematic quantities. Default: the tip."),
]
LabelsOption = Literal["names", "values", "both"]
"""Labels beside arrows, angles and lengths."""


def number(text: str | float) -> float:
    """The number that an option's text stands for; unlike the parser's own, without 1_0 and digits
    of other scripts."""
    from freebody.formats import read_file

    value = read_file.number(text) if isinstance(text, str) else text
    if value is None or read_file.fault(value):
        raise typer.BadParameter(f"{shown(text)} is not a number that can be used.")
    return value


def values(what: str, text: str) -> list[float]:
    """Numbers apart by commas or blanks; a number with "deg" is an angle in degrees."""
    from freebody.formats import read_file

    found = []
    for piece in re.sub(r" ?(deg|°)", r"deg", " ".join(text.split())).replace(",", " ").split():
        value = read_file.number(piece.removesuffix("deg"))
        if value is None or read_file.fault(value):
            raise FreebodyError(
                f"{what} {shown(text)}: {shown(piece)} is not a number that can be used; "
                f'write for example {what} "0.5, 30 deg".'
            )
        found.append(math.radians(value) if piece.endswith("deg") else value)
    return found


NotationOption = Annotated[
    str | None,
    typer.Option(
        metavar="NAME or FILE",
        help="Letters, angles and parameters as a book has them: notes, craig, spong, siciliano, "
        "murray-li-sastry, lynch-park, featherstone; or as a TOML file of your own says.",
    ),
]
ParametersOption = Annotated[
    list[str] | None,
    typer.Option(
        "--parameter",
        metavar="NAME=FORMULA",
        help="A parameter given by others or a number, such as lc=l/2 for all links, or I1=0.",
    ),
]


def pairs(option: str, texts: list[str] | None, example: str, equals: str = "=") -> dict[str, str]:
    """Names and values from options of the form name=value."""
    found = {}
    for text in texts or ():
        name, sign, meaning = text.partition(equals)
        if not (name.strip() and sign and meaning.strip()):
            raise FreebodyError(
                f"{option} {text}: write a name, {equals}, and what it stands for, such as "
                f"{example}."
            )
        found[name.strip()] = meaning.strip()
    return found


_READING: dict[str, tuple[Any, Any]] = {
    "tip": (Tip, None),
    "base": (
        Annotated[
            Literal["fixed", "free"] | None,
            typer.Option(help="Fix the root link, or let it float. Default: as in the file."),
        ],
        None,
    ),
    "mimic": (
        Annotated[
            Literal["follow", "free"],
            typer.Option(help="Whether mimic joints follow the joint they mimic, or move freely."),
        ],
        "follow",
    ),
    "physical": (
        Annotated[
            Literal["warn", "refuse", "ignore"],
            typer.Option(help="What to do about a physically impossible inertia."),
        ],
        "warn",
    ),
    "snap_angles": (
        Annotated[
            float,
            typer.Option(
                metavar="RAD",
                parser=number,
                help="Angles of a URDF this close (rad) to a multiple of a right angle are read as "
                "that multiple.",
            ),
        ],
        3e-9,
    ),
    "convention": (
        Annotated[
            Literal["standard", "modified"] | None,
            typer.Option(help="The convention of a DH table that does not state it."),
        ],
        None,
    ),
    "package_path": (
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="FOLDER",
                help="A folder of ROS packages that a xacro file includes, or of meshes. Packages "
                "around the file are found without.",
            ),
        ],
        None,
    ),
    "xacro": (
        Annotated[
            list[str] | None,
            typer.Option(metavar="NAME:=VALUE", help="A value for an argument of a xacro file."),
        ],
        None,
    ),
    "xacro_environment": (
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="NAME", help="A variable of the environment that a xacro file may read."
            ),
        ],
        None,
    ),
    "parameters": (
        Annotated[
            list[str] | None,
            typer.Option(
                "--parameter",
                metavar="NAME=VALUE",
                help="Another value for a number of the robot, such as l1=0.5, or a formula that "
                "gives it, such as lc=l/2 for all links.",
            ),
        ],
        None,
    ),
    "payload": (
        Annotated[
            str | None,
            typer.Option(
                metavar="MASS[@x,y,z][,box=a,b,c|cylinder=r,h|inertia=xx,yy,zz,xy,xz,yz]",
                help="A load at the tip, in its axes, kg and m: where its centre of mass is "
                "(default: at the origin), and its shape: the sides of a box, radius and height "
                "along z of a cylinder, or its inertia about its centre of mass (kg m²). Without a "
                "shape it is a point.",
            ),
        ],
        None,
    ),
    "estimate_inertia": (
        Annotated[
            float | None,
            typer.Option(
                "--estimate-inertia",
                metavar="KG",
                parser=number,
                help="The robot's whole mass: inertias of a URDF are estimated from its shapes "
                "instead of read.",
            ),
        ],
        None,
    ),
}
"""Options of how a robot is read, by the argument of `fb.load`, with their defaults; and which of
its numbers are others."""
FILE = (
    "tip",
    "base",
    "mimic",
    "physical",
    "snap_angles",
    "convention",
    "package_path",
    "xacro",
    "xacro_environment",
    "parameters",
)
"""Options of most commands."""
CASE = (*FILE, "payload")
"""Options of commands that move the robot."""


@dataclass(frozen=True)
class GivenRobot:
    """A robot as the command line names it, and how it is to be read."""

    name: str
    how: dict[str, Any]

    @property
    def arguments(self) -> dict[str, Any]:
        """How the file is to be read, as arguments of `fb.load`."""
        how = {k: x for k, x in self.how.items() if k not in ("parameters", "payload")}
        how["xacro"] = pairs("--xacro", how.get("xacro"), "length:=0.5", ":=")
        for name in ("package_path", "xacro_environment"):
            how[name] = how.get(name) or ()
        return how

    def load(self) -> Model:
        """The model of the robot named on the command line; warnings are printed as yellow
        lines."""
        from freebody.formats.loading import load
        from freebody.formats.toml_table import in_units
        from freebody.model.description import CHANGED, Notice

        how, payload = self.arguments, self.how.get("payload")
        given = pairs("--parameter", self.how.get("parameters"), "l1=0.5")
        for name, text in given.items():
            value = in_units(text, "angle")
            given[name] = text if value is None else repr(value)
        with terminal.warnings_as_lines():
            model = load(self.name, **how)
        if payload is not None:
            model = model.with_payload(**_payload(payload))
        if not given:
            return model
        told = ", ".join(f"{name} = {text}" for name, text in given.items())
        notice = Notice(CHANGED, f"given by --parameter in the place of the file's: {told}.")
        return replace(model.bind(given), notices=(*model.notices, notice))


_ROBOTS: dict[Any, Any] = {
    GivenRobot: Robot,
    list[GivenRobot]: Annotated[
        list[str],
        typer.Argument(metavar="ROBOT…", help="Files, or names of bundled models, as `freebody "
                       "show` takes one."),
    ],
}  # fmt: skip
"""Arguments of the command line by what a command's function takes: one robot, or several."""

_PAYLOAD = re.compile(
    r"(?P<mass>[^@,=]+)(@(?P<com>[^@=]+?))?(,\s*(?P<shape>box|cylinder|inertia)\s*=(?P<sizes>[^@=]+))?"
)
_ENTRIES = (0, 3, 4, 1, 5, 2)
"""Indices among xx, yy, zz, xy, xz, yz of a tensor's entries in stored order."""


def _payload(text: str) -> dict[str, Any]:
    """The meaning of --payload, as arguments of `Model.with_payload`."""
    from freebody.formats import read_file

    def numbers(part: str | None) -> list[float] | None:
        if part is None:
            return None
        found = [read_file.number(piece.strip()) for piece in part.split(",")]
        usable = [x for x in found if x is not None and not read_file.fault(x)]
        return usable if len(usable) == len(found) else []

    match = _PAYLOAD.fullmatch(text.strip())
    parts = {name: numbers(match[name]) for name in ("mass", "com", "sizes")} if match else {}
    if match is None or [] in parts.values():
        raise FreebodyError(
            f"--payload {shown(text)}: write MASS (kg), then perhaps @x,y,z (m), then perhaps "
            f",box=a,b,c or ,cylinder=r,h (m) or ,inertia=xx,yy,zz,xy,xz,yz (kg m²), such as "
            f"3@0,0,0.1,box=0.1,0.1,0.2."
        )
    (mass,) = parts["mass"] or (0.0,)
    given: dict[str, Any] = {"mass": mass, "com": parts["com"]}
    sizes = parts["sizes"]
    if sizes and match["shape"] == "inertia":
        if len(sizes) not in (1, 6):
            raise FreebodyError(
                f"--payload {shown(text)}: inertia has {len(sizes)} entries, expected "
                f"xx,yy,zz,xy,xz,yz, or in the plane one."
            )
        sizes = [sizes[k] for k in _ENTRIES] if len(sizes) == 6 else sizes[0]
    return {**given, match["shape"]: sizes} if sizes is not None else given


def again(context: typer.Context) -> str:
    """The command line, quoted for a shell, that runs a command again."""
    return shlex.join(["freebody", *context.find_root().obj])


def reading(*names: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """A decorator that adds the named reading options to a command; its function finds them, with
    the robots' names, in arguments that are a `GivenRobot` or a list of them."""

    def decorated(command: Callable[..., None]) -> Callable[..., None]:
        own = signature(command, eval_str=True)
        options = [
            Parameter(name, Parameter.KEYWORD_ONLY, annotation=kind, default=default)
            for name, (kind, default) in _READING.items()
            if name in names
        ]
        robots = {
            name: parameter.replace(annotation=_ROBOTS[parameter.annotation])
            for name, parameter in own.parameters.items()
            if parameter.annotation in (GivenRobot, list[GivenRobot])
        }

        @wraps(command)
        def run(**given: Any) -> None:
            how = {name: given.pop(name) for name in names}
            for name in robots:
                text = given[name]
                given[name] = (
                    GivenRobot(text, how)
                    if isinstance(text, str)
                    else [GivenRobot(one, how) for one in text]
                )
            command(**given)

        parameters = {**own.parameters, **robots}
        vars(run)["__signature__"] = own.replace(parameters=[*parameters.values(), *options])
        return run

    return decorated
