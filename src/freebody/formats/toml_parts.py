"""The parts of a robot in TOML: links with their masses, joints with limits and drives, placements,
frames, payloads, loops, gravity and home positions.

Each function reads one table, as docs/formats.md describes it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np

from freebody.errors import ModelError
from freebody.formats.toml_table import TomlTable, in_units
from freebody.model.description import (
    INFINITE,
    Drive,
    Joint,
    Limits,
    Link,
    Loop,
    Mount,
    Payload,
)
from freebody.model.drives import LAWS, NUMBERS
from freebody.model.flexible_joints import split
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia
from freebody.model.joints import KINDS
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.loops import checked_tolerance
from freebody.model.mimics import Mimic
from freebody.model.parameters import Parameter, Quantity
from freebody.model.placement import (
    AxisRotation,
    Placement,
    Rotate,
    Shift,
    rotate,
    rpy,
    shift,
    turn,
)
from freebody.model.struts import NUMBERS as STRUT_NUMBERS
from freebody.model.struts import Strut
from freebody.outputs.number_text import compared
from freebody.spatial import space

DRIVE = tuple(dict.fromkeys(number.place[0] for number in NUMBERS.values()))
_OWN = tuple(number.name for kind in KINDS.values() for number in kind.numbers)
_MASS = ("mass", "com", "inertia", "shape")
_SHAPE_SIZES: dict[str, tuple[str, ...]] = {
    "point": (),
    "disc": ("radius",),
    "ring": ("radius",),
    "bar": ("length",),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}
_TURNS = ("rpy", "axis_angle", "quat_wxyz", "matrix", "angle")
_PLACE = ("origin", *_TURNS, "steps")
_UNIT_VECTORS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def link(table: TomlTable, dim: int) -> Link:
    """The link that a table [[link]] describes."""
    table = table.called(f"link {table.text('name')!r}").only("name", *_MASS, "inertia_frame")
    inner = table.table("inertia_frame")
    frame = (
        _placement(inner.called(f"{table.where}, inertia_frame").only(*_PLACE), dim)
        if inner
        else Placement()
    )
    body = _inertia(table, dim) if any(key in table for key in _MASS) else None
    stated = "inertia" in table or "shape" in table
    return Link(table.text("name"), body, frame, table.line, stated=stated)


def mount(table: TomlTable, dim: int, parents: Collection[str]) -> Mount:
    """The frame that a table [[frame]] mounts on a link or frame."""
    table = table.called(f"frame {table.text('name')!r}").only("name", "parent", *_PLACE)
    return Mount(table.text("name"), table.choice("parent", parents), _placement(table, dim))


def payload(table: TomlTable, dim: int, frames: Collection[str]) -> Payload:
    """The load that a table [[payload]] fixes to a frame."""
    table = table.called(f"payload {table.text('name')!r}").only("name", "frame", *_MASS)
    return Payload(table.text("name"), table.choice("frame", frames), _inertia(table, dim))


def loop(table: TomlTable, dim: int) -> Loop:
    """The loop that a table [[loop]] closes."""
    table = table.called(f"loop {table.text('name')!r}").only(
        "name", "kind", "frames", "axis", "distance"
    )
    frames = _two_frames(table)
    kind = LOOP_KINDS[table.choice("kind", LOOP_KINDS)]
    return Loop(
        table.text("name"),
        kind.name,
        frames,
        _direction(table, dim) if "axis" in table else (),
        table.quantity("distance") if "distance" in table else None,
        table.line,
    )


def strut(table: TomlTable) -> Strut:
    """The strut that a table [[strut]] puts between two frames."""
    numbers = [number.name for number in STRUT_NUMBERS]
    table = table.called(f"strut {table.text('name')!r}").only("name", "frames", *numbers)
    if "rest" in table and "stiffness" not in table:
        table.refuse("stiffness is missing, without which rest has no effect; give both.", "rest")
    given = {key: table.quantity(key, default=0.0) for key in numbers}
    return Strut(table.text("name"), _two_frames(table), **given, line=table.line)


def _two_frames(table: TomlTable) -> tuple[str, str]:
    if "frames" not in table:
        table.refuse('frames is missing; name the two: frames = ["one", "other"].')
    first, second = table.listed(table.get("frames", None), "frames", 2)
    if not isinstance(first, str) or not isinstance(second, str):
        table.refuse("frames must be the names of two frames.", "frames")
    return first, second


def loop_tolerance(top: TomlTable) -> tuple[float, float] | None:
    """The tolerance given as loop_tolerance = [metres, radians]; None where the key is absent."""
    key = "loop_tolerance"
    if key not in top:
        return None
    metres, radians = top.listed(top.data[key], key, 2)
    given = (
        top.read_number(metres, "number", (key, 0)),
        top.read_number(radians, "angle", (key, 1)),
    )
    try:
        return checked_tolerance(given, top.where)
    except ModelError as error:
        top.refuse(str(error), key)


def home(top: TomlTable, joints: Sequence[Joint]) -> tuple[tuple[str, float], ...]:
    """Positions by name, from [home]."""
    inner = top.table("home")
    if inner is None:
        return ()
    inner = inner.called("[home]")
    lengths = {joint.name for joint in joints if KINDS[joint.kind].slides}
    return tuple(
        (name, inner.number(name, "number" if name in lengths else "angle")) for name in inner.data
    )


def gravity(top: TomlTable, dim: int) -> tuple[Quantity, tuple[float, ...]]:
    """Gravity from a size, a name, a vector, or { size, direction }; 9.81 m/s² downwards,
    called g, where the file says nothing."""
    down = (0.0,) * (dim - 1) + (-1.0,)
    given: Any = top.data.get("gravity")
    if isinstance(given, list):
        return gravity_of(top.vector("gravity", dim), dim)
    if isinstance(given, dict) and "direction" in given:
        inner = top.inner(given, "gravity").called("gravity").only("size", "direction")
        along = inner.vector("direction", dim)
        if abs(math.hypot(*along) - 1.0) > 1e-9:
            inner.refuse("direction must have length 1.", "direction")
        return inner.quantity("size"), along
    if "gravity" not in top:
        values, texts = parameter_table(top)
        return Parameter("g", None if "g" in texts else values.get("g", 9.81)), down
    size = top.quantity("gravity")
    return (size if isinstance(size, Parameter) else Parameter("g", size)), down


def joint(table: TomlTable, dim: int) -> Joint:
    """The joint that a table [[joint]] describes."""
    table = table.called(f"joint {table.text('name')!r}")
    table.only(
        *("name", "kind", "parent", "child", *_PLACE, "axis", *_OWN),
        *("limits", *DRIVE, "flexible", "mimic", "passive"),
    )
    kind = table.choice("kind", KINDS)
    one, angles = KINDS[kind].nv == 1, not KINDS[kind].slides
    own = [number.name for number in KINDS[kind].numbers]
    taken = {
        "axis": KINDS[kind].needs_axis,
        "limits": one,
        **dict.fromkeys((*DRIVE, "flexible"), one),
        **{name: name in own for name in _OWN},
        "mimic": one,
    }
    if unused := [key for key, has_it in taken.items() if key in table and not has_it]:
        table.refuse(f"a {kind} joint has no {unused[0]}; remove it.", unused[0])
    if table.flag("passive") and (KINDS[kind].nv == 0 or "mimic" in table):
        reason = (
            "has nothing to drive"
            if KINDS[kind].nv == 0
            else "follows another, which may be passive"
        )
        table.refuse(f"passive: the joint {reason}; remove it.", "passive")
    return Joint(
        table.text("name"),
        kind,
        table.text("parent"),
        table.text("child"),
        _placement(table, dim),
        _axis(table, kind, dim) if KINDS[kind].needs_axis else (),
        limits(table, angles),
        drive(table, angles),
        _mimic(table, angles),
        table.line,
        table.flag("passive"),
        tuple(map(table.quantity, own)),
    )


def flexible(table: TomlTable, joint: Joint) -> tuple[tuple[Joint, ...], tuple[Link, ...]]:
    """(joints, links) for a [[joint]] table: the joint itself, or for a flexible one its two halves
    and the link between."""
    inner = table.table("flexible")
    if inner is None:
        return (joint,), ()
    inner = inner.called(f"joint {joint.name!r}, flexible").only("stiffness", "damping")
    try:
        rotor, link, twist = split(
            joint, inner.quantity("stiffness"), inner.quantity("damping", default=0.0)
        )
    except ModelError as error:
        inner.refuse(str(error))
    return (rotor, twist), (link,)


def _axis(table: TomlTable, kind: str, dim: int) -> tuple[float, ...]:
    """A joint's axis: a vector, or "x", "-z"; in the plane 1 (counterclockwise) or -1."""
    if KINDS[kind].axis_size(dim) == 1:
        return (table.number("axis", default=1.0),)
    return _direction(table, dim)


def limits(table: TomlTable, angles: bool) -> Limits:
    """Limits from { lower, upper, velocity, effort }; angles: whether they are of an angle rather
    than a length."""
    inner = table.table("limits")
    return limits_of(inner.called(f"{table.where}, limits"), angles) if inner else Limits()


def limits_of(table: TomlTable, angles: bool) -> Limits:
    """Limits from a table of their own; angles: whether they are of an angle rather than a
    length."""
    table.only("lower", "upper", "velocity", "effort")
    angle, rate = ("angle", "rate") if angles else ("number", "number")
    return Limits(
        table.number("lower", angle, -INFINITE, infinite=True),
        table.number("upper", angle, INFINITE, infinite=True),
        table.number("velocity", rate, INFINITE, infinite=True),
        table.number("effort", "number", INFINITE, infinite=True),
    )


def drive(table: TomlTable, angles: bool) -> Drive:
    """The drive that a table's friction, rotor, spring and transmission describe; angles: whether
    its joint's position is an angle rather than a length."""
    found: dict[str, Quantity] = {}
    for key in DRIVE:
        inner = table.table(key)
        if inner is not None:
            found |= drive_numbers(inner.called(f"{table.where}, {key}"), key, angles)
    return Drive(**found)


def drive_numbers(table: TomlTable, name: str, angles: bool) -> dict[str, Quantity]:
    """The numbers of drive laws from the table of that name; a law that is mentioned needs all its
    numbers, and an empty table those of the usual laws. angles: whether the joint's position is an
    angle rather than a length."""
    groups = [
        (law, {n.place[1]: n for n in law.numbers if n.place[0] == name}) for law in LAWS.values()
    ]
    table.only(*(key for _, numbers in groups for key in numbers))
    found: dict[str, Quantity] = {}
    for law, numbers in groups:
        asked = any(key in table for key in numbers) or (law.usual and not table.data)
        for key, number in numbers.items():
            default = {} if asked and number.needed else {"default": number.default}
            found[number.name] = table.quantity(key, number.kind_of(angles), **default)
    return found


def _mimic(table: TomlTable, angles: bool) -> Mimic | None:
    inner = table.table("mimic")
    if inner is None:
        return None
    inner = inner.called(f"{table.where}, mimic")
    several = inner.table("joints")
    if several is None:
        inner.only("joint", "ratio", "offset")
        terms = [
            (inner.text("joint"), _coefficients(inner, "ratio") if "ratio" in inner else (1.0,))
        ]
    else:
        inner.only("joints", "offset")
        terms = [(name, _coefficients(several, name)) for name in several.data]
        if not terms:
            inner.refuse("joints is empty; give each leader its ratio.", "joints")
    return Mimic.of_terms(terms, inner.number("offset", "angle" if angles else "number", 0.0))


def _coefficients(table: TomlTable, key: str) -> tuple[float, ...]:
    """A ratio, or a list of the coefficients of a leader's position q, of q², q³, …"""
    if not isinstance(table.data[key], list):
        return (table.number(key),)
    given = table.listed(table.data[key], key, None)
    if not given:
        table.refuse(f"{key} is empty; give a number, or the coefficients of q, q², q³, …", key)
    return tuple(table.read_number(x, "number", (key, i)) for i, x in enumerate(given))


def _inertia(table: TomlTable, dim: int) -> Inertia:
    """An inertia from mass, com, and inertia or shape."""
    mass = table.quantity("mass")
    com = table.quantities("com", dim, default=(0.0,) * dim)
    if "shape" in table and "inertia" in table:
        table.refuse("shape and inertia exclude each other; keep one.", "shape")
    try:
        if "shape" in table:
            return _shaped(table, dim, mass, com)
        return Inertia(mass, com, _tensor(table, dim))
    except ModelError as error:
        table.refuse(str(error), "inertia" if "inertia" in table else "mass")


def _tensor(table: TomlTable, dim: int) -> tuple[Quantity, ...]:
    """The entries of an inertia tensor: one number in the plane; six in space, or a symmetric 3×3
    matrix."""
    if dim == 2:
        return (table.quantity("inertia", default=0.0),)
    rows = table.data.get("inertia")
    if isinstance(rows, list) and rows and all(isinstance(row, list) for row in rows):
        full = np.array(table.matrix("inertia", 3))
        return Inertia.of(0.0, (0.0,) * 3, full).tensor
    return table.quantities("inertia", 6, default=(0.0,) * 6)


def _shaped(table: TomlTable, dim: int, mass: Quantity, com: tuple[Quantity, ...]) -> Inertia:
    """An inertia from shape = { bar = { length = 0.4 } } or another shape."""
    outer = table.inner(table.data["shape"], "shape").only(*_SHAPE_SIZES)
    if len(outer.data) != 1:
        outer.refuse(
            f"shape names {len(outer.data)} shapes, expected one of {', '.join(_SHAPE_SIZES)}."
        )
    (kind,) = outer.data
    sizes = (
        outer.inner(outer.data[kind], kind)
        .called(f"{table.where}, {kind}")
        .only(*_SHAPE_SIZES[kind])
    )
    if not isinstance(mass, float):
        table.refuse(
            "a shape needs a mass in numbers; give inertia = ... as a name instead.", "mass"
        )
    match kind:
        case "point":
            body = Inertia.point(mass, (0.0,) * dim)
        case "disc":
            body = Inertia.disc(mass, sizes.number("radius"), dim)
        case "ring":
            body = Inertia.ring(mass, sizes.number("radius"), dim)
        case "bar":
            body = Inertia.bar(mass, sizes.number("length"), dim)
        case "box":
            body = Inertia.box(mass, sizes.vector("size", dim))
        case _ if dim == 2:
            outer.refuse(f"a {kind} is not a planar shape; use disc, ring, bar or box.")
        case "cylinder":
            body = Inertia.cylinder(mass, sizes.number("radius"), sizes.number("length"))
        case _:
            body = Inertia.sphere(mass, sizes.number("radius"))
    return Inertia(mass, com, body.tensor)


def _placement(table: TomlTable, dim: int) -> Placement:
    """A placement from origin, then one rotation; or from a list of steps."""
    if "steps" in table:
        if any(key in table for key in ("origin", *_TURNS)):
            table.refuse("steps give the complete placement; remove origin and rotations.", "steps")
        return Placement(
            tuple(_step(t.called(f"{table.where}, steps"), dim) for t in table.tables("steps"))
        )
    turns = [key for key in _TURNS if key in table]
    if len(turns) > 1:
        table.refuse(f"{turns[0]} and {turns[1]} exclude each other; keep one rotation.", turns[1])
    if turns and (turns[0] == "angle") != (dim == 2) and turns[0] != "matrix":
        use = "angle" if dim == 2 else ", ".join(_TURNS[:-1])
        table.refuse(f"{turns[0]} does not fit a model with dim = {dim}; use {use}.", turns[0])
    origin = shift(*table.quantities("origin", dim, default=(0.0,) * dim))
    return origin.then(_rotation(table, turns[0], dim)) if turns else origin


def _rotation(table: TomlTable, key: str, dim: int) -> Placement:
    if key == "angle":
        return turn("z", table.quantity(key, "angle"))
    if key == "rpy":
        return rpy(*table.vector(key, 3, "angle"))
    if key == "matrix":
        return _matrix(table, dim)
    if key == "quat_wxyz":
        w, x, y, z = table.vector(key, 4)
        if abs(math.sqrt(w * w + x * x + y * y + z * z) - 1.0) > 1e-6:
            length, unit = compared(math.hypot(w, x, y, z), 1.0, digits=6)
            table.refuse(f"the quaternion has length {length}, expected {unit}.", key)
        return rotate(
            _about((x, y, z), math.hypot(x, y, z), 2.0 * math.atan2(math.hypot(x, y, z), w))
        )
    inner = table.inner(table.data[key], key).called(f"{table.where}, {key}").only("axis", "angle")
    axis = inner.data.get("axis")
    if isinstance(axis, str):
        return turn(inner.choice("axis", _UNIT_VECTORS), inner.quantity("angle", "angle"))
    direction = inner.vector("axis", 3)
    length = math.hypot(*direction)
    if length == 0.0:
        inner.refuse("the axis is zero; give a direction.", "axis")
    return rotate(_about(direction, length, inner.number("angle", "angle")))


def _about(axis: Iterable[float], length: float, angle: float) -> np.ndarray:
    """Rotation matrix by an angle (rad) about an axis of that length (Rodrigues)."""
    if length == 0.0:
        return np.eye(3)
    return np.array(space.rotation(tuple(a / length for a in axis), angle))


def _matrix(table: TomlTable, dim: int) -> Placement:
    try:
        return rotate(table.matrix("matrix", dim))
    except ModelError as error:
        table.refuse(str(error), "matrix")


def _step(table: TomlTable, dim: int) -> Shift | AxisRotation | Rotate:
    """A step from { shift = [...] }, { turn = "z", angle = ... } or { matrix = [...] }."""
    table.only("shift", "turn", "angle", "matrix")
    if "shift" in table:
        return Shift(table.quantities("shift", dim))
    if "turn" in table:
        return AxisRotation(
            table.choice("turn", "z" if dim == 2 else "xyz"), table.quantity("angle", "angle")
        )
    _matrix(table, dim)
    return Rotate(table.matrix("matrix", dim))


def _direction(table: TomlTable, dim: int) -> tuple[float, ...]:
    """A direction from axis = [0, 0, 1], or a letter: "x", "-z"."""
    given = table.data.get("axis")
    if isinstance(given, str):
        sign, letter = (-1.0, given[1:]) if given.startswith("-") else (1.0, given)
        if letter not in _UNIT_VECTORS or (dim == 2 and letter == "z"):
            table.refuse(
                f"axis is {given!r}, expected x, y{'' if dim == 2 else ', z'}, one of them with a "
                f"minus, or numbers.",
                "axis",
            )
        return tuple(sign * x for x in _UNIT_VECTORS[letter][:dim])
    return table.vector("axis", dim)


def parameter_table(top: TomlTable) -> tuple[dict[str, float], dict[str, str]]:
    """The [parameters] table: numbers by name, and formulas by name from which further parameters
    follow."""
    table = top.table("parameters")
    if table is None:
        return {}, {}
    named = table.called("[parameters]")
    texts = {
        key: text
        for key, text in table.data.items()
        if isinstance(text, str) and text.strip() and in_units(text, "angle") is None
    }
    return {key: named.number(key, "angle") for key in table.data if key not in texts}, texts
