"""Arguments that commands share: the robot, and how its file is read."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import numbers, terminal
from freebody.cli.load_case import LOAD_CASE, MODEL_CASE, changed, speed, wrenches
from freebody.errors import FreebodyError, listed

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
        help="A parameter given by others or a number, such as lc=l/2 for all links, or I1=0; also "
        "by letters of your own, such as I1=m1*r^2/2.",
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
                parser=numbers.number,
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
    "lock": (
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="JOINT=POSITION",
                help="A joint that stands still at a position, rad or m, or 30 deg, and is no "
                "coordinate then, such as a gripper's finger; may be repeated.",
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
                parser=numbers.number,
                help="The robot's whole mass: inertias of a URDF are estimated from its shapes "
                "instead of read.",
            ),
        ],
        None,
    ),
}
"""Options of how a robot is read, by the argument of `fb.load`, with their defaults; which of its
numbers are others, and which joints are locked."""
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
    "lock",
)
"""Options of most commands."""
CASE = (*FILE, *MODEL_CASE)
"""Options of commands that compute with the robot in its load case."""
WHOLE_CASE = (*CASE, "wrench", "speed", "estimate_inertia")
"""Options of commands that run the robot along a motion in its load case."""
_READING |= {name: (option.annotation, None) for name, option in LOAD_CASE.items()}


@dataclass(frozen=True)
class GivenRobot:
    """A robot as the command line names it, and how it is to be read."""

    name: str
    how: dict[str, Any]

    @property
    def arguments(self) -> dict[str, Any]:
        """How the file is to be read, as arguments of `fb.load`."""
        own = ("parameters", "lock", *LOAD_CASE)
        how = {k: x for k, x in self.how.items() if k not in own}
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

        how = self.arguments
        given = pairs("--parameter", self.how.get("parameters"), "l1=0.5")
        for name, text in given.items():
            value = in_units(text, "angle")
            given[name] = text if value is None else repr(value)
        with terminal.warnings_as_lines():
            model = load(self.name, **how)
        if locked := pairs("--lock", self.how.get("lock"), "finger=0.02"):
            model = model.with_locked(
                {joint: numbers.one("--lock", text) for joint, text in locked.items()}
            )
            told = listed(f"{joint} at {text}" for joint, text in locked.items())
            notice = Notice(CHANGED, f"locked by --lock: {told}.")
            model = replace(model, notices=(*model.notices, notice))
        model = changed(model, self.how)
        if given:
            told = ", ".join(f"{name} = {text}" for name, text in given.items())
            notice = Notice(CHANGED, f"given by --parameter in the place of the file's: {told}.")
            model = replace(model.bind(given), notices=(*model.notices, notice))
        return model

    def wrenches(self, model: Model) -> dict[str, list[float]] | None:
        """The wrenches on the robot by frame; None without one."""
        return wrenches(model, self.how.get("wrench"))

    @property
    def speed(self) -> float:
        """How many times as fast a motion is run."""
        return speed(self.how.get("speed"))


_ROBOTS: dict[Any, Any] = {
    GivenRobot: Robot,
    list[GivenRobot]: Annotated[
        list[str],
        typer.Argument(metavar="ROBOT…", help="Files, or names of bundled models, as `freebody "
                       "show` takes one."),
    ],
}  # fmt: skip
"""Arguments of the command line by what a command's function takes: one robot, or several."""


def again(context: typer.Context) -> str:
    """The command line, quoted for a shell, that runs a command again."""
    return shlex.join(["freebody", *context.find_root().obj])


def reading(*names: str, **refused: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """A command with these options behind its own; its function finds them, with the names of the
    robots, in its arguments that are a `GivenRobot` or a list of such. refused: options of the load
    case that the command cannot use, and why."""

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        own = signature(command, eval_str=True)
        options = [
            Parameter(name, Parameter.KEYWORD_ONLY, annotation=kind, default=default)
            for name, (kind, default) in _READING.items()
            if name in names
        ]
        options += [
            Parameter(
                name,
                Parameter.KEYWORD_ONLY,
                annotation=Annotated[list[str] | None, typer.Option(hidden=True)],
                default=None,
            )
            for name in refused
        ]
        robots = {
            name: parameter.replace(annotation=_ROBOTS[parameter.annotation])
            for name, parameter in own.parameters.items()
            if parameter.annotation in (GivenRobot, list[GivenRobot])
        }

        @wraps(command)
        def run(**given: Any) -> Any:
            for name, reason in refused.items():
                if given.pop(name):
                    raise FreebodyError(f"--{name}: {reason}")
            how = {name: given.pop(name) for name in names}
            for name in robots:
                text = given[name]
                given[name] = (
                    GivenRobot(text, how)
                    if isinstance(text, str)
                    else [GivenRobot(one, how) for one in text]
                )
            return command(**given)

        parameters = {**own.parameters, **robots}
        vars(run)["__signature__"] = own.replace(parameters=[*parameters.values(), *options])
        return run

    return decorated
