"""Meanings of the texts of the load case: what the robot carries, what pulls at it, how gravity
acts, and how fast a motion is run."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from freebody.cli.numbers import by_commas, values
from freebody.errors import FreebodyError, shown
from freebody.outputs.display import counted

if TYPE_CHECKING:
    from freebody.arrays import Array
    from freebody.model.model import Model


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


def loaded(model: Model, texts: list[str]) -> Model:
    """The model with all loads that --payload tells."""
    for k, text in enumerate(texts, 1):
        name = "payload" if k == 1 else f"payload{k}"
        model = model.with_payload(**payload_arguments(text), name=name)
    return model


def with_gravity(model: Model, text: str) -> Model:
    """The model in the field that --gravity tells."""
    vector, axes = by_commas(text), ("x", "y", "z")[: model.dim]
    if vector is None or len(vector) != model.dim:
        down = ",".join([*["0"] * (model.dim - 1), "-9.81"])
        raise FreebodyError(
            f"--gravity {shown(text)}: write the field {','.join(axes)} (m/s², world axes), such "
            f"as {down}."
        )
    return model.replace(gravity=vector)


def mounted(model: Model, text: str) -> Model:
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
