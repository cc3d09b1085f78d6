"""freebody's TOML of a model. Loading it again gives the same model, to the last bit."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace

from freebody.formats.writing.contents import fixed_name
from freebody.model.bodies import Frame
from freebody.model.description import Drive, Joint, Limits, Loop
from freebody.model.doubts import DOUBT_KINDS, read_doubts
from freebody.model.drives import LAWS
from freebody.model.inertia import Inertia
from freebody.model.joints import KINDS
from freebody.model.model import Model
from freebody.model.parameter_formulas import used
from freebody.model.parameters import Parameter, Quantity
from freebody.model.placement import Placement, Rotate, Shift
from freebody.model.struts import NUMBERS as STRUT_NUMBERS
from freebody.model.struts import Strut
from freebody.model.tree import Attached


def written(model: Model) -> tuple[str, list[str]]:
    """The TOML text of a model, and no losses."""
    writer = _TomlWriter(model)
    parts = (writer.head(), writer.parameters(), writer.home(), *writer.parts())
    return "\n\n".join(filter(None, parts)) + "\n", []


class _TomlWriter:
    def __init__(self, model: Model):
        self.model = model
        held = [body for body in model.bodies if body.joint.parent]
        self.free = len(held) < len(model.bodies)  # a root joint that base="free" made
        self.joints = [body.joint for body in held]
        self.links = [frame for frame in model.frames if not frame.mounted]
        attached = [a for body in model.bodies for a in body.inertias] + list(model.base_inertias)
        self.inertia_of = {part.link: part for part in attached if not part.load}
        self.loads = [part for part in attached if part.load]

    # ------------------------------------------------------------ the file, top to bottom
    def head(self) -> str:
        model = self.model
        entries = {"name": _text(model.name)}
        if model.source:
            entries["source"] = _text(model.source)
        if model.about:
            entries["about"] = _text(model.about)
        entries["dim"] = str(model.dim)
        entries["gravity"] = _inline(
            {"size": _quantity(model.gravity_size), "direction": _vector(model.gravity_direction)}
        )
        if model.tip:
            entries["tip"] = _text(model.tip)
        if self.free:
            entries["base"] = _text("free")
        doubts = read_doubts(model)
        for kind in DOUBT_KINDS.values():
            texts = [_text(doubt.text) for doubt in doubts if doubt.kind == kind.name]
            if texts:
                entries[kind.key] = f"[{', '.join(texts)}]"
        if model.loop_tolerance is not None:
            entries["loop_tolerance"] = _vector(model.loop_tolerance)
        return _entries(entries)

    def parameters(self) -> str:
        """The [parameters] table with the model's values and formulas; numbers that only unused
        formulas need are left out."""
        formulas = used(self.model)
        values = {
            _key(name): repr(value)
            for name, value in replace(self.model, formulas=formulas).parameters.items()
            if value is not None
        }
        values |= {_key(x.name): _text(x.text) for x in formulas}
        return f"[parameters]\n{_entries(values)}" if values else ""

    def home(self) -> str:
        entries = {_key(name): repr(value) for name, value in self.model.home}
        return f"[home]\n{_entries(entries)}" if entries else ""

    def parts(self) -> list[str]:
        frames = {frame.name: frame for frame in self.model.frames}
        fixed = [frame for frame in self.links if frame.parent]
        moving = {joint.name for joint in self.joints}
        taken = moving.union(self.model.fixed_joint_names)
        return [
            *(self.link(frame) for frame in self.links),
            *(_joint(joint, frames[joint.parent].placement) for joint in self.joints),
            *(
                _fixed(
                    frame,
                    frames[frame.parent],
                    frame.joint if frame.joint not in moving else "",
                    taken,
                )
                for frame in fixed
            ),
            *(
                _mounted(frame, frames[frame.parent])
                for frame in self.model.frames
                if frame.mounted
            ),
            *(self.payload(part) for part in self.loads),
            *map(_loop, self.model.loops),
            *map(_strut, self.model.struts),
        ]

    def link(self, frame: Frame) -> str:
        entries = {"name": _text(frame.name)}
        part = self.inertia_of.get(frame.name)
        if part:
            entries.update(_mass(part.inertia))
            own = _behind(frame.placement, part.placement)
            if own.steps:
                entries["inertia_frame"] = _inline(_place(own))
        return _section("link", entries)

    def payload(self, part: Attached) -> str:
        """The [[payload]] table of a load that is fixed to a frame."""
        return _section(
            "payload", {"name": _text(part.link), "frame": _text(part.frame), **_mass(part.inertia)}
        )


def _joint(joint: Joint, parent: Placement) -> str:
    entries = {
        "name": _text(joint.name),
        "kind": _text(joint.kind),
        "parent": _text(joint.parent),
        "child": _text(joint.child),
    }
    entries.update(_place(_behind(parent, joint.placement)))
    if KINDS[joint.kind].needs_axis:
        entries["axis"] = repr(joint.axis[0]) if len(joint.axis) == 1 else _vector(joint.axis)
    for number, value in zip(KINDS[joint.kind].numbers, joint.numbers, strict=True):
        entries[number.name] = _quantity(value)
    if joint.limits != Limits():
        limits = {
            key: getattr(joint.limits, key) for key in ("lower", "upper", "velocity", "effort")
        }
        entries["limits"] = _inline(
            {key: repr(x) for key, x in limits.items() if not math.isinf(x) or _told(key, x)}
        )
    entries.update(_drive(joint.drive))
    if joint.mimic:
        follow = joint.mimic
        entries["mimic"] = _inline(
            {
                "joint": _text(follow.joint),
                "ratio": repr(follow.ratio),
                "offset": repr(follow.offset),
            }
        )
    if joint.passive:
        entries["passive"] = "true"
    return _section("joint", entries)


def _loop(loop: Loop) -> str:
    entries = {
        "name": _text(loop.name),
        "kind": _text(loop.kind),
        "frames": f"[{', '.join(map(_text, loop.frames))}]",
    }
    if loop.axis:
        entries["axis"] = _vector(loop.axis)
    if loop.distance is not None:
        entries["distance"] = _quantity(loop.distance)
    return _section("loop", entries)


def _strut(strut: Strut) -> str:
    entries = {
        "name": _text(strut.name),
        "frames": f"[{', '.join(map(_text, strut.frames))}]",
    }
    for number, value in zip(STRUT_NUMBERS, strut.numbers, strict=True):
        entries[number.name] = _quantity(value)
    return _section("strut", entries)


def _told(key: str, value: float) -> bool:
    """Whether a limit differs from the default, so that it is written."""
    return value != getattr(Limits(), key)


def _drive(drive: Drive) -> dict[str, str]:
    groups: dict[str, dict[str, str]] = {}
    for law in LAWS.values():
        given = {number: getattr(drive, number.name) for number in law.numbers}
        if law.usual or any(x != number.default for number, x in given.items()):
            for number, x in given.items():
                table, key = number.place
                groups.setdefault(table, {})[key] = _quantity(x)
    given = {table: group for table, group in groups.items() if group != _NOTHING.get(table)}
    return {table: _inline(group) for table, group in given.items()}


_NOTHING: dict[str, dict[str, str]] = {}
for _number in (number for law in LAWS.values() if law.usual for number in law.numbers):
    _NOTHING.setdefault(_number.place[0], {})[_number.place[1]] = repr(_number.default)


def _fixed(frame: Frame, parent: Frame, name: str, taken: set[str]) -> str:
    name = name or fixed_name(frame.name, taken)
    entries = {"name": name, "kind": "fixed", "parent": parent.name, "child": frame.name}
    place = _place(_behind(parent.placement, frame.placement))
    return _section("joint", {key: _text(value) for key, value in entries.items()} | place)


def _mounted(frame: Frame, parent: Frame) -> str:
    place = _place(_behind(parent.placement, frame.placement))
    return _section("frame", {"name": _text(frame.name), "parent": _text(parent.name), **place})


def _mass(inertia: Inertia) -> dict[str, str]:
    tensor = _quantity(inertia.tensor[0]) if inertia.dim == 2 else _vector(inertia.tensor)
    return {"mass": _quantity(inertia.mass), "com": _vector(inertia.com), "inertia": tensor}


# ---------------------------------------------------------------- placements
def _behind(outer: Placement, whole: Placement) -> Placement:
    """The remaining steps of a placement that starts with the steps of `outer`."""
    return Placement(whole.steps[len(outer.steps) :])


def _place(placement: Placement) -> dict[str, str]:
    """A placement as TOML: a shift and a rotation where that is enough; else the list of steps."""
    match placement.steps:
        case ():
            return {}
        case (Shift(by),):
            return {"origin": _vector(by)}
        case (Rotate(matrix),):
            return {"matrix": _matrix(matrix)}
        case (Shift(by), Rotate(matrix)):
            return {"origin": _vector(by), "matrix": _matrix(matrix)}
    steps = [
        {"shift": _vector(step.by)}
        if isinstance(step, Shift)
        else {"matrix": _matrix(step.matrix)}
        if isinstance(step, Rotate)
        else {"turn": _text(step.axis), "angle": _quantity(step.angle)}
        for step in placement.steps
    ]
    return {"steps": f"[{', '.join(map(_inline, steps))}]"}


# ---------------------------------------------------------------- TOML text
def _quantity(value: Quantity) -> str:
    return _text(value.name) if isinstance(value, Parameter) else repr(value)


def _vector(values: Sequence[Quantity]) -> str:
    return f"[{', '.join(map(_quantity, values))}]"


def _matrix(rows: Sequence[Sequence[float]]) -> str:
    return f"[{', '.join(map(_vector, rows))}]"


def _text(value: str) -> str:
    # JSON's escapes are TOML's, except that TOML wants the delete character escaped too
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")


def _key(name: str) -> str:
    """A key as TOML, bare where that is allowed, else quoted."""
    return (
        name if name.replace("_", "").replace("-", "").isalnum() and name.isascii() else _text(name)
    )


def _inline(entries: dict[str, str]) -> str:
    return f"{{ {', '.join(f'{key} = {value}' for key, value in entries.items())} }}"


def _entries(entries: dict[str, str]) -> str:
    return "\n".join(f"{key} = {value}" for key, value in entries.items())


def _section(name: str, entries: dict[str, str]) -> str:
    return f"[[{name}]]\n{_entries(entries)}"
