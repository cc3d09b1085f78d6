"""The load case on the command line: what the robot carries, what pulls at it, how gravity acts,
and how fast a motion is run. One table for all commands: each uses an option, or refuses it with
its reason."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from freebody.cli.numbers import by_commas, values
from freebody.errors import FreebodyError, shown
from freebody.outputs.display import counted

if TYPE_CHECKING:
    from freebody.arrays import Array
    from freebody.model.model import Model


@dataclass(frozen=True)
class CaseOption:
    """An option of the load case: what it is on the command line, and the model that follows from
    its text, where it changes the model."""

    annotation: Any
    changed: Callable[[Model, Any], Model] | None = None


_PAYLOAD = re.compile(
    r"(?P<mass>[^@,=]+)(@(?P<com>[^@=]+?))?(,\s*(?P<shape>box|cylinder|inertia)\s*=(?P<sizes>[^@=]+))?"
)
_ENTRIES = (0, 3, 4, 1, 5, 2)
"""Indices among xx, yy, zz, xy, xz, yz of a tensor's entries in stored order."""
_TURNS = {"floor": ("X", 0.0), "wall": ("Y", 90.0), "ceiling": ("X", 180.0)}
"""The axis about which a base is turned, in the plane its normal, and by how many degrees."""


def payload_arguments(text: str) -> dict[str, Any]:
    """The meaning of --payload, as arguments of `Model.with_payload`."""
    match = _PAYLOAD.fullmatch(text.strip())
    given = {name: match[name] for name in ("mass", "com", "sizes")} if match else {}
    parts = {name: None if part is None else by_commas(part) for name, part in given.items()}
    if match is None or any(parts[name] is None and given[name] is not None for name in parts):
        raise FreebodyError(
            f"--payload {shown(text)}: write MASS (kg), then perhaps @x,y,z (m), then perhaps "
            f",box=a,b,c or ,cylinder=r,h (m) or ,inertia=xx,yy,zz,xy,xz,yz (kg m²), such as "
            f"3@0,0,0.1,box=0.1,0.1,0.2."
        )
    (mass,) = parts["mass"] or (0.0,)
    told: dict[str, Any] = {"mass": mass, "com": parts["com"]}
    sizes: Any = parts["sizes"]
    if sizes and match["shape"] == "inertia":
        if len(sizes) not in (1, 6):
            raise FreebodyError(
                f"--payload {shown(text)}: inertia has {counted(len(sizes), 'entry')}, expected "
                f"xx,yy,zz,xy,xz,yz, or in the plane one."
            )
        sizes = [sizes[k] for k in _ENTRIES] if len(sizes) == 6 else sizes[0]
    return {**told, match["shape"]: sizes} if sizes is not None else told


def _loaded(model: Model, texts: list[str]) -> Model:
    """The model with all loads that --payload tells."""
    for k, text in enumerate(texts, 1):
        name = "payload" if k == 1 else f"payload{k}"
        model = model.with_payload(**payload_arguments(text), name=name)
    return model


def _with_gravity(model: Model, text: str) -> Model:
    """The model in the field that --gravity tells."""
    vector, axes = by_commas(text), ("x", "y", "z")[: model.dim]
    if vector is None or len(vector) != model.dim:
        down = ",".join([*["0"] * (model.dim - 1), "-9.81"])
        raise FreebodyError(
            f"--gravity {shown(text)}: write the field {','.join(axes)} (m/s², world axes), such "
            f"as {down}."
        )
    return model.replace(gravity=vector)


def _mounted(model: Model, text: str) -> Model:
    """The model with its base turned: gravity in the base's axes, which are the world's."""
    import numpy as np

    from freebody.model.description import CHANGED, Notice
    from freebody.model.loops import held_by_base

    if model.bodies and not held_by_base(model):
        raise FreebodyError(
            f"--mounting: the base of {model.name!r} is free, and mounted nowhere; its orientation "
            f"is in the positions."
        )
    if not model.gravity.any():
        raise FreebodyError(f"--mounting: {model.name!r} is without gravity; no mounting is felt.")
    R = _orientation(text, model.dim)
    turned = R.T @ model.gravity
    turned[np.abs(turned) < 1e-12 * np.abs(turned).max()] = 0.0  # what rounding leaves of it
    said = f"mounted {text!r}: gravity is that of the base turned so (--mounting)."
    model = model.replace(gravity=turned)
    return replace(model, notices=(*model.notices, Notice(CHANGED, said)))


def _orientation(text: str, dim: int) -> Array:
    """The rotation of the base against the floor."""
    from freebody.trees.positions import rotation

    if text in _TURNS:
        axis, turn = _TURNS[text]
        return rotation("Z" if dim == 2 else axis, [math.radians(turn)])[:dim, :dim]
    given = values("--mounting", text)
    if len(given) != (3 if dim == 3 else 1):
        raise FreebodyError(
            f"--mounting {shown(text)}: write floor, wall, ceiling, or "
            f"{'roll,pitch,yaw' if dim == 3 else 'one angle'} of the base (rad, or 30 deg)."
        )
    return rotation("ZYX", given[::-1]) if dim == 3 else rotation("Z", given)[:2, :2]


LOAD_CASE: dict[str, CaseOption] = {
    "payload": CaseOption(
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="MASS[@x,y,z][,box=a,b,c|cylinder=r,h|inertia=xx,yy,zz,xy,xz,yz]",
                help="A load at the tip, in its axes, kg and m: where its centre of mass is "
                "(default: at the origin), and its shape: the sides of a box, radius and height "
                "along z of a cylinder, or its inertia about its centre of mass (kg m²). Without a "
                "shape it is a point. May be repeated: all are carried.",
            ),
        ],
        _loaded,
    ),
    "gravity": CaseOption(
        Annotated[
            str | None,
            typer.Option(
                metavar="x,y,z",
                help="The field of gravity, m/s², world axes. Default: the robot's own.",
            ),
        ],
        _with_gravity,
    ),
    "mounting": CaseOption(
        Annotated[
            str | None,
            typer.Option(
                metavar="floor|wall|ceiling|roll,pitch,yaw",
                help="How the base is turned against the floor: at a wall by 90° about its y, at a "
                "ceiling by 180° about its x, or by angles as in URDF (rad, or 30 deg; in the "
                "plane one). World axes are then those of the turned base.",
            ),
        ],
        _mounted,
    ),
    "wrench": CaseOption(
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="FRAME:fx,fy,fz,mx,my,mz",
                help="A constant wrench exerted on the robot by its surroundings, at the origin of "
                "FRAME, N and N m, world axes (in the plane fx,fy,m); may be repeated.",
            ),
        ]
    ),
    "speed": CaseOption(
        Annotated[
            str | None,
            typer.Option(
                metavar="FACTOR",
                help="The motion is run so many times as fast along its path.",
            ),
        ]
    ),
}
"""The options of the load case by name, in the order in which they change a model."""

MODEL_CASE = tuple(name for name, option in LOAD_CASE.items() if option.changed is not None)
"""Options of a load case that are numbers of the model."""


def changed(model: Model, how: dict[str, Any]) -> Model:
    """The model in the load case that the options `how` tell."""
    if how.get("gravity") is not None and how.get("mounting") is not None:
        raise FreebodyError(
            "--gravity and --mounting both say how gravity acts on the base; give one of them."
        )
    for name in MODEL_CASE:
        text, change = how.get(name), LOAD_CASE[name].changed
        if text is not None and change is not None:  # an empty text is refused there
            model = change(model, text)
    return model


def wrenches(model: Model, texts: list[str] | None) -> dict[str, list[float]] | None:
    """The meaning of --wrench: a wrench by the name of its frame; None without one."""
    names = ("fx", "fy", "fz", "mx", "my", "mz") if model.dim == 3 else ("fx", "fy", "m")
    found: dict[str, list[float]] = {}
    for text in texts or ():
        frame, colon, entries = text.rpartition(":")
        wrench = by_commas(entries)
        if not (colon and frame.strip()) or wrench is None or len(wrench) != len(names):
            raise FreebodyError(
                f"--wrench {shown(text)}: write FRAME:{','.join(names)} (N, N m; world axes), such "
                f"as {model.tip or 'tip'}:{','.join(['0', '-50', *['0'] * (len(names) - 2)])}."
            )
        name = model.frame(frame.strip()).name
        if name in found:
            raise FreebodyError(f"--wrench: frame {name!r} has two wrenches; add them up.")
        found[name] = wrench
    return found or None


def speed(text: str | None) -> float:
    """The meaning of --speed; 1 without it."""
    found = [1.0] if text is None else by_commas(text)
    if found is None or len(found) != 1 or not found[0] > 0.0:
        raise FreebodyError(f"--speed {shown(str(text))}: write a factor above 0, such as 0.5.")
    return found[0]
