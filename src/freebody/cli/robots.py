"""Which robot: one table of options for all commands that take a robot, and the model that they
tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import load_case, numbers, terminal
from freebody.errors import FreebodyError, listed

if TYPE_CHECKING:
    from freebody.model.model import Model


@dataclass(frozen=True)
class RobotOption:
    """An option of all commands that take a robot.

    of_text: whether it says how the file's text is read, which concerns those too who look at the
    file alone. changed: the model that follows from what is given, where the option changes the
    model that is read; without it, it is an argument of `fb.load`.
    """

    annotation: Any
    default: Any
    of_text: bool
    changed: Callable[[Model, Any], Model] | None


def _option(
    kind: Any,
    words: str,
    *names: str,
    default: Any = None,
    of_text: bool = False,
    changed: Callable[[Model, Any], Model] | None = None,
    **how: Any,
) -> RobotOption:
    said = typer.Option(*names, help=words, rich_help_panel="The robot", **how)
    return RobotOption(Annotated[kind, said], default, of_text, changed)


def _locked(model: Model, texts: list[str]) -> Model:
    """The model in which the joints of --lock stand still."""
    at = numbers.pairs("--lock", texts, "finger=0.02")
    locked = {joint: numbers.one("--lock", text) for joint, text in at.items()}
    told = listed(f"{joint} at {text}" for joint, text in at.items())
    return _noted(model.with_locked(locked), f"locked by --lock: {told}")


def parameters(texts: list[str] | None) -> dict[str, str]:
    """The meaning of --parameter: a number or a formula for each name."""
    return numbers.pairs("--parameter", texts, "l1=0.5")


def _bound(model: Model, texts: list[str]) -> Model:
    """The model with the numbers of --parameter."""
    from freebody.formats.toml_table import in_units

    given = parameters(texts)
    for name, text in given.items():
        value = in_units(text, "angle")
        given[name] = text if value is None else repr(value)
    told = ", ".join(f"{name} = {text}" for name, text in given.items())
    return _noted(model.bind(given), f"given by --parameter in the place of the file's: {told}")


def _noted(model: Model, text: str) -> Model:
    """The model with a notice of how it was changed."""
    from freebody.model.description import CHANGED, Notice

    return replace(model, notices=(*model.notices, Notice(CHANGED, f"{text}.")))


ROBOT_OPTIONS: dict[str, RobotOption] = {
    "tip": _option(
        str | None,
        "The frame that is the tip. Default: the file's, else one that is called tcp, tool0, "
        "flange, ee… or grasp…, else the end of the longest chain, grippers taken off.",
        metavar="FRAME",
    ),
    "base": _option(
        Literal["fixed", "free"] | None,
        "Fix the root link, or let it float. Default: as in the file.",
    ),
    "mimic": _option(
        Literal["follow", "free"],
        "Whether mimic joints follow the joint they mimic, or move freely.",
        default="follow",
    ),
    "physical": _option(
        Literal["warn", "refuse", "ignore"],
        "What to do about a physically impossible inertia.",
        default="warn",
    ),
    "snap_angles": _option(
        float,
        "Angles of a URDF this close (rad) to a multiple of a right angle are read as that "
        "multiple.",
        default=3e-9,
        metavar="RAD",
        parser=numbers.number,
    ),
    "convention": _option(
        Literal["standard", "modified"] | None,
        "The convention of a DH table that does not state it.",
        of_text=True,
    ),
    "package_path": _option(
        list[str] | None,
        "A folder of ROS packages that a xacro file includes, or of meshes. Packages around the "
        "file are found without.",
        of_text=True,
        metavar="FOLDER",
    ),
    "xacro": _option(
        list[str] | None,
        "A value for an argument of a xacro file.",
        of_text=True,
        metavar="NAME:=VALUE",
    ),
    "xacro_environment": _option(
        list[str] | None,
        "A variable of the environment that a xacro file may read.",
        of_text=True,
        metavar="NAME",
    ),
    "estimate_inertia": _option(
        float | None,
        "The robot's whole mass: inertias of a URDF are estimated from its shapes instead of read.",
        metavar="KG",
        parser=numbers.number,
    ),
    "lock": _option(
        list[str] | None,
        "A joint that stands still at a position, rad or m, or 30 deg, and is no coordinate then, "
        "such as a gripper's finger; or all that a pattern matches, 'right_*'; may be repeated.",
        metavar="JOINT=POSITION",
        changed=_locked,
    ),
    "payload": _option(
        list[str] | None,
        "A load at the tip, in its axes, kg and m: where its centre of mass is (default: at the "
        "origin), and its shape: the sides of a box, radius and height along z of a cylinder, or "
        "its inertia about its centre of mass (kg m²). Without a shape it is a point. May be "
        "repeated: all are carried.",
        metavar="MASS[@x,y,z][,box=a,b,c|cylinder=r,h|inertia=xx,yy,zz,xy,xz,yz]",
        changed=load_case.loaded,
    ),
    "gravity": _option(
        str | None,
        "The field of gravity, m/s², world axes. Default: the robot's own.",
        metavar="x,y,z",
        changed=load_case.with_gravity,
    ),
    "mounting": _option(
        str | None,
        "How the base is turned against the floor: at a wall by 90° about its y, at a ceiling by "
        "180° about its x, or by angles as in URDF (rad, or 30 deg; in the plane one). World axes "
        "are then those of the turned base.",
        metavar="floor|wall|ceiling|roll,pitch,yaw",
        changed=load_case.mounted,
    ),
    "parameters": _option(
        list[str] | None,
        "Another value for a number of the robot, such as l1=0.5, or a formula that gives it, such "
        "as lc=l/2 for all links; of a derivation and an answer also by letters of your own.",
        "--parameter",
        metavar="NAME=VALUE",
        changed=_bound,
    ),
}
"""The options of all commands that take a robot, in the order in which they change it."""

USE_OPTIONS: dict[str, RobotOption] = {
    "wrench": _option(
        list[str] | None,
        "A constant wrench exerted on the robot by its surroundings, at the origin of FRAME, N and "
        "N m, world axes (in the plane fx,fy,m); may be repeated.",
        metavar="FRAME:fx,fy,fz,mx,my,mz",
    ),
    "speed": _option(
        str | None,
        "The motion is run so many times as fast along its path.",
        metavar="FACTOR",
    ),
}
"""Options of what is done to a robot, each of which a command uses or refuses with its reason."""


@dataclass(frozen=True)
class GivenFile:
    """A robot's file as the command line names it, and how its text is read."""

    name: str
    how: Mapping[str, Any]

    @property
    def arguments(self) -> dict[str, Any]:
        """How the file is to be read, as arguments of `fb.load` and `fb.doctor`."""
        own = {name for name, option in ROBOT_OPTIONS.items() if option.changed is None}
        how = {name: x for name, x in self.how.items() if name in own}
        how["xacro"] = numbers.pairs("--xacro", how.get("xacro"), "length:=0.5", ":=")
        for name in ("package_path", "xacro_environment"):
            how[name] = how.get(name) or ()
        return how


@dataclass(frozen=True)
class GivenRobot(GivenFile):
    """A robot as the command line names it, how it is read, and in which case it is."""

    def load(self) -> Model:
        """The model of the robot named on the command line; warnings are printed as yellow
        lines."""
        from freebody.formats.loading import load

        if self.how.get("gravity") is not None and self.how.get("mounting") is not None:
            raise FreebodyError(
                "--gravity and --mounting both say how gravity acts on the base; give one of them."
            )
        with terminal.warnings_as_lines():
            model = load(self.name, **self.arguments)
        for name, option in ROBOT_OPTIONS.items():
            given = self.how.get(name)
            if option.changed is not None and given not in (None, []):  # a text may be empty
                model = option.changed(model, given)
        return model

    def in_symbols(self) -> tuple[Model, dict[str, str]]:
        """The robot without --parameter, and the numbers and formulas that it gives: a derivation
        puts them into its lines, where a model's values are not seen."""
        how = {**self.how, "parameters": None}
        return replace(self, how=how).load(), parameters(self.how.get("parameters"))

    def wrenches(self, model: Model) -> dict[str, list[float]] | None:
        """The wrenches on the robot by frame; None without one."""
        return load_case.wrenches(model, self.how.get("wrench"))

    @property
    def speed(self) -> float:
        """How many times as fast a motion is run."""
        return load_case.speed(self.how.get("speed"))
