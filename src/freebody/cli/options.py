"""The options of commands: how they are collected, and a few that several commands have."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from operator import itemgetter
from typing import Annotated, Any, Literal, get_type_hints

import typer

from freebody.cli.robots import ROBOT_OPTIONS, USE_OPTIONS, GivenFile, GivenRobot, RobotOption
from freebody.errors import FreebodyError

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
USED = None
"""Said of an option of what is done to a robot that a command uses."""

_ONE = Annotated[
    str,
    typer.Argument(
        help="A .urdf, .xacro, .xml (MJCF), .sdf, .toml or .csv (DH table) file, a bundled "
        "model's name, or letters such as RRP."
    ),
]
_SEVERAL = Annotated[
    list[str],
    typer.Argument(
        metavar="ROBOT…",
        help="Files, or names of bundled models, as `freebody show` takes one.",
    ),
]
_ROBOTS: dict[Any, tuple[Any, type[GivenFile]]] = {
    GivenRobot: (_ONE, GivenRobot),
    list[GivenFile]: (_SEVERAL, GivenFile),
}
"""Kinds of robots that a command's function takes: the argument of the command line, and the
record that is made of it."""


def again(context: typer.Context) -> str:
    """The command line, quoted for a shell, that runs a command again."""
    return shlex.join(["freebody", *context.find_root().obj])


def collected(**said: str | None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """A command whose function takes its options in records.

    A `GivenRobot` brings the options of all commands that take a robot, a `GivenFile` those of how
    a text is read; a dataclass brings one for each of its fields. said: of each option of what is
    done to a robot, that it is `USED`, or the reason for which it is refused; what the function
    itself has under that name is its own.
    """

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        own = signature(command, eval_str=True)
        shared = _shared(command, own, said)
        parts = {name: _part(parameter, shared) for name, parameter in own.parameters.items()}

        @wraps(command)
        def run(**given: Any) -> Any:
            for name, reason in said.items():
                if reason is not None and given[name]:
                    raise FreebodyError(f"--{name}: {reason}")
            return command(**{name: part.made(given) for name, part in parts.items()})

        taken = [parameter for part in parts.values() for parameter in part.options]
        for name, option in shared.items():
            kind = _HIDDEN if said.get(name) else option.annotation
            taken.append(_parameter(name, kind, option.default))
        vars(run)["__signature__"] = own.replace(parameters=taken)
        return run

    return decorated


_HIDDEN = Annotated[list[str] | None, typer.Option(hidden=True)]


@dataclass(frozen=True)
class _CommandParameter:
    """A parameter of a command's function: its own options, and how its value is made of what is
    given for all."""

    options: tuple[Parameter, ...]
    made: Callable[[dict[str, Any]], Any]


def _part(parameter: Parameter, shared: Iterable[str]) -> _CommandParameter:
    name, kind = parameter.name, parameter.annotation
    if robot := _robot(kind):
        argument, record = robot

        def robots(given: dict[str, Any]) -> Any:
            texts, how = given[name], {x: given[x] for x in shared}
            return record(texts, how) if isinstance(texts, str) else [record(x, how) for x in texts]

        return _CommandParameter((_parameter(name, argument, parameter.default),), robots)
    if is_dataclass(kind):
        options = tuple(_of_record(kind))
        make: Any = kind
        return _CommandParameter(
            options, lambda given: make(**{x.name: given[x.name] for x in options})
        )
    return _CommandParameter((_parameter(name, kind, parameter.default),), itemgetter(name))


def _robot(kind: Any) -> tuple[Any, type[GivenFile]] | None:
    """The argument and the record of a parameter that is a robot or several; else None."""
    return next((found for known, found in _ROBOTS.items() if known == kind), None)


def _shared(
    command: Callable[..., Any], own: Signature, said: dict[str, str | None]
) -> dict[str, RobotOption]:
    """The options that a command's robots bring."""
    records = {found[1] for x in own.parameters.values() if (found := _robot(x.annotation))}
    if GivenRobot not in records:
        return {name: x for name, x in ROBOT_OPTIONS.items() if x.of_text} if records else {}
    if set(said) != set(USE_OPTIONS) - set(own.parameters):
        raise TypeError(f"{command.__name__} uses or refuses each of {', '.join(USE_OPTIONS)}")
    return {**ROBOT_OPTIONS, **{name: USE_OPTIONS[name] for name in said}}


def _parameter(name: str, annotation: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=default)


def _of_record(record: Any) -> Iterator[Parameter]:
    """The options of a command that are the fields of a record."""
    kinds = get_type_hints(record, include_extras=True)
    for field in fields(record):
        default = Parameter.empty if field.default is MISSING else field.default
        yield _parameter(field.name, kinds[field.name], default)
