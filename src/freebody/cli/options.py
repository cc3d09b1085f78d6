"""What commands share: how their options are collected, and a few that several have."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
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
"""What a command's function takes of robots: the argument of the command line, and its record."""


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
        robots = {n: _ROBOTS[p.annotation] for n, p in own.parameters.items() if _is_robot(p)}
        records: dict[str, Any] = {
            name: p.annotation
            for name, p in own.parameters.items()
            if name not in robots and is_dataclass(p.annotation)
        }
        shared = _shared(command, robots, said, own)
        refused = {name: reason for name, reason in said.items() if reason is not None}

        @wraps(command)
        def run(**given: Any) -> Any:
            for name, reason in refused.items():
                if given.pop(name):
                    raise FreebodyError(f"--{name}: {reason}")
            how = {name: given.pop(name) for name in shared if name not in refused}
            for name, (_, kind) in robots.items():
                texts = given[name]
                given[name] = (
                    kind(texts, how) if isinstance(texts, str) else [kind(x, how) for x in texts]
                )
            for name, record in records.items():
                own_fields = [field.name for field in fields(record)]
                given[name] = record(**{field: given.pop(field) for field in own_fields})
            return command(**given)

        taken: list[Parameter] = []
        for name, p in own.parameters.items():
            if name in records:
                taken += _of_record(p.annotation)
            else:
                kind = robots[name][0] if name in robots else p.annotation
                taken.append(_parameter(name, kind, p.default))
        for name, option in shared.items():
            kind = _HIDDEN if name in refused else option.annotation
            taken.append(_parameter(name, kind, option.default))
        vars(run)["__signature__"] = own.replace(parameters=taken)
        return run

    return decorated


_HIDDEN = Annotated[list[str] | None, typer.Option(hidden=True)]


def _is_robot(parameter: Parameter) -> bool:
    return any(parameter.annotation == kind for kind in _ROBOTS)


def _shared(
    command: Callable[..., Any], robots: dict[str, Any], said: dict[str, Any], own: Signature
) -> dict[str, RobotOption]:
    """The options that a command's robots bring."""
    if not robots:
        return {}
    if not any(kind is GivenRobot for _, kind in robots.values()):
        return {name: option for name, option in ROBOT_OPTIONS.items() if option.of_text}
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
