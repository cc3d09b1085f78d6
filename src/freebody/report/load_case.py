"""The load case of a study in words: the robot's loads, its tip, how it is mounted, and which
numbers differ from its file's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.model.description import CHANGED
from freebody.model.inertia import decimal_sum
from freebody.model.loops import held_by_base
from freebody.model.model import Model
from freebody.model.number_editors import TENSOR
from freebody.model.parameters import Quantity
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached
from freebody.outputs.display import Tabled, TextTable
from freebody.trees.public_calls import FrameWrenchTable, wrenches_by_frame


@dataclass(frozen=True, eq=False, repr=False)
class LoadCase(Tabled, ByValue):
    """The load case of a study: what the robot carries, what pulls at it, how it is mounted and how
    fast it is run."""

    payload: float
    """The mass of all that it carries (kg)."""
    gravity: Array
    """The field, (dim,), m/s², world axes."""
    free: bool
    """Whether the base is free."""
    wrenches: Mapping[str, Array]
    """Constant ones on the robot by frame, (six,), N and N m, world axes."""
    speed: float
    """How many times as fast as given the motion is run."""
    words: Mapping[str, str]
    """Each in words: `load_case`."""
    command: str
    """The command line that makes the study again; empty where none made it."""

    @property
    def rows(self) -> tuple[tuple[str, str, str, str], ...]:
        """The load case as rows of texts: label, value, unit, remark."""
        words = self.words
        found = [
            ("payload", f"{self.payload:.4g}", "kg", words["load"]),
            ("gravity", ", ".join(map(_number, self.gravity)), "m/s²", words["mounting"]),
            ("tip", "", "", words["tip"]),
        ]
        if self.wrenches:
            found.append(("wrench", "", "", words["wrenches"]))
        found.append(("speed", f"{self.speed:.4g}", "times as given", ""))
        if "parts" in words:
            found.append(("parts", "", "", words["parts"]))
        if "changed" in words:
            found.append(("changed", "", "", words["changed"]))
        if self.command:
            found.append(("again", self.command, "", ""))
        return tuple(found)

    def _title(self) -> str:
        return "Load case: " + " ".join(self.words.values())

    def _table(self) -> TextTable:
        return TextTable(("", "value", "unit", "remark"), self.rows)


def case_of(
    model: Model,
    wrenches: Mapping[str, Array],
    speed: float = 1.0,
    command: str = "",
    parts: Sequence[str] = (),
) -> LoadCase:
    """The load case of a study of a model; parts: brakes and bearings in words."""
    return LoadCase(
        payload=carried_mass(model),
        gravity=np.asarray(model.gravity, dtype=float),
        free=_free(model),
        wrenches=dict(wrenches),
        speed=speed,
        words=load_case(model, wrenches, speed, parts),
        command=command,
    )


def _parts(model: Model) -> list[Attached]:
    return [*model.base_inertias, *(part for body in model.bodies for part in body.inertias)]


def carried_mass(model: Model) -> float:
    """The mass (kg) of all loads of a model."""
    loads = (part.inertia.mass for part in _parts(model) if part.load)
    return decimal_sum(VALUES.quantity(mass) for mass in loads)


def _free(model: Model) -> bool:
    return bool(model.bodies) and not held_by_base(model)


def load_case(
    model: Model,
    wrenches: FrameWrenchTable = None,
    speed: float = 1.0,
    parts: Sequence[str] = (),
) -> dict[str, str]:
    """Words by what they are about: "load", "tip", "mounting", "wrenches", "speed" and "parts"
    where there are such, and "changed" where numbers are.

    wrenches: constant ones by frame. speed: how many times as fast the motion is run. parts: brakes
    and bearings that are judged, in words.

    They tell the model as it is, not how it was made, so that equal models have equal words but for
    what was changed by name.
    """
    base = "free" if _free(model) else "fixed"
    loads = "; ".join(_load(model, part) for part in _parts(model) if part.load)
    field = ", ".join(_number(x) for x in np.moveaxis(model.gravity, -1, 0))
    changed = [notice.text for notice in model.notices if notice.kind == CHANGED]
    found = {
        "load": f"{loads}." if loads else "none.",
        "tip": model.tip_reason,
        "mounting": f"base {base}, gravity ({field}) m/s² in world axes.",
    }
    if wrenches:
        found["wrenches"] = f"{_pulls(model, wrenches)}, exerted on the robot, world axes."
    if speed != 1.0:
        found["speed"] = f"the motion is run {speed:.4g} times as fast as given."
    if parts:
        found["parts"] = f"judged too: {'; '.join(parts)}."
    return {**found, "changed": " ".join(changed)} if changed else found


def _pulls(model: Model, wrenches: FrameWrenchTable) -> str:
    loads, d = wrenches_by_frame("study", model, wrenches, single=True), model.dim
    return "; ".join(
        f"force ({', '.join(map(_number, load[:d]))}) N and moment "
        f"({', '.join(map(_number, load[d:]))}) N m at {frame}"
        for frame, load in loads.items()
    )


def _load(model: Model, part: Attached) -> str:
    """A load in words: its mass, centre of mass and inertia, in the axes of its frame."""
    inertia = part.inertia
    centre = ", ".join(_quantity(x) for x in inertia.com)
    entries = [
        f"{name} {_quantity(x)}"
        for name, x in zip(TENSOR[model.dim], inertia.tensor, strict=True)
        if np.any(VALUES.quantity(x))
    ]
    about = f"inertia {', '.join(entries)} kg m²" if entries else "a point without inertia"
    return f"{part.link}, {_quantity(inertia.mass)} kg at ({centre}) m in {part.frame}, {about}"


def _quantity(x: Quantity) -> str:
    return _number(VALUES.quantity(x))


def _number(x: object) -> str:
    """A number as text, or the range of the numbers of a family."""
    values = np.asarray(x, dtype=float)
    low, high = (f"{float(end) + 0.0:.4g}" for end in (values.min(), values.max()))
    return low if low == high else f"{low} … {high}"


def in_a_line(
    model: Model,
    wrenches: FrameWrenchTable = None,
    speed: float = 1.0,
    parts: Sequence[str] = (),
) -> str:
    """The load case except the tip, in one line."""
    case = load_case(model, wrenches, speed, parts)
    return " ".join(f"{about.capitalize()}: {case[about]}" for about in case if about != "tip")
