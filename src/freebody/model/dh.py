"""Serial arms from Denavit-Hartenberg tables, standard or modified: the caller says which.

standard:  T_{i-1,i} = Rz(θ_i) Tz(d_i) Tx(a_i) Rx(α_i); joint i acts along z_{i-1}, frame i sits at
the far end of link i.
modified:  T_{i-1,i} = Rx(α_i) Tx(a_i) Rz(θ_i) Tz(d_i), α_i and a_i being those of the row; joint i
acts along z_i (6.16-6.29).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from freebody.errors import FileError, ModelError, UnknownNameError, shown
from freebody.model.build import Policy, build_model
from freebody.model.description import Drive, Joint, Limits, Link, Mount, RobotDescription
from freebody.model.drives import LAWS
from freebody.model.families import NamedNumber
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia
from freebody.model.joints import BY_LETTER
from freebody.model.model import Model
from freebody.model.parameters import Quantity, quantity
from freebody.model.placement import AxisRotation, Placement, Shift

Convention = Literal["standard", "modified"]
KEYS = (
    *("joint", "name", "theta", "d", "a", "alpha", "m", "com", "I"),
    *("rotor", "gear", "friction", "limits", "passive"),
)
_FRICTION = tuple(law.strength for law in LAWS.values() if law.usual and law.feature == "friction")
"""Numbers of the usual laws of friction: the viscous one, then the dry one."""


def dh(
    rows: Sequence[Mapping[str, Any]],
    *,
    convention: Convention,
    gravity: float | str | Sequence[float] = 9.81,
    name: str = "dh",
    physical: Policy = "refuse",
) -> Model:
    """A serial arm from rows of a DH table.

    Parameters
    ----------
    rows
        A mapping for each joint, with the keys joint ("R" by default, or "P"), theta, d (constants;
        the joint variable's one is its offset), a, alpha (m, rad), m (kg), com (3) and I (6: ixx,
        ixy, ixz, iyy, iyz, izz, or 3×3; about the com), both in DH frame i of the convention, rotor
        (kg m²) and gear, friction (viscous, viscous and dry as a pair, or numbers by their names
        in `Drive`), limits (lower, upper) or Limits, passive (True: the joint has no drive), name.
        A name instead of a number is a parameter.
    convention
        "standard" or "modified".
    gravity
        Its size along -z (m/s²), a name, or a vector in world axes.
    name
        The model's name.
    physical
        "warn" about, "refuse" or "ignore" numbers that no rigid body or motor has.

    Raises
    ------
    ModelError
        What is wrong with a row, which is named.
    """
    return build_model(
        describe(rows, convention=convention, gravity=gravity, name=name), physical=physical
    )


def describe(
    rows: Sequence[Mapping[str, Any]],
    *,
    convention: Convention,
    gravity: float | str | Sequence[float] = 9.81,
    name: str = "dh",
    source: str = "",
    file: str | None = None,
    lines: Sequence[int] | None = None,
    joint_names: Sequence[str | None] = (),
    base: Placement | None = None,
    tool: Placement | None = None,
) -> RobotDescription:
    """The links and joints of a DH table; of a file also its name, the line of each row, and names
    of joints. base: placement of frame 0 in the root link; tool: a frame behind the last one, which
    is then the tip."""
    if convention not in ("standard", "modified"):
        raise UnknownNameError("convention", convention, "dh", ("standard", "modified"))
    if not isinstance(rows, Sequence) or not all(isinstance(row, Mapping) for row in rows):
        raise ModelError(
            f"dh: the rows are {shown(rows)}, expected a list of dicts, one per joint, such as "
            '[{"a": 0.4, "m": 2.0}]; of a DataFrame, table.to_dict("records").'
        )
    if not len(rows):
        raise ModelError("dh: the table has no rows; give one per joint.")
    links, joints, mounts = [Link("base")], [], []
    behind = base or Placement()  # from the link frame to where the next joint's placement starts
    for i, row in enumerate(rows):
        line = lines[i] if lines else None
        try:
            called = (joint_names[i] if joint_names else None) or f"joint{i + 1}"
            link, joint, frame = _row(row, i, convention, behind, links[-1].name, line, called)
        except ModelError as error:
            if file:
                raise FileError(file, line, str(error)) from None
            raise
        links.append(link)
        joints.append(joint)
        mounts.append(Mount(f"frame{i + 1}", link.name, frame))
        behind = frame
    if tool is not None:
        mounts.append(Mount("tool", mounts[-1].name, tool))
    return RobotDescription(
        name,
        3,
        tuple(links),
        tuple(joints),
        gravity_of(gravity, 3, name="g"),
        tuple(mounts),
        tip=mounts[-1].name,
        source=source,
        file=file,
    )


def _row(
    row: Mapping[str, Any],
    i: int,
    convention: Convention,
    behind: Placement,
    parent: str,
    line: int | None,
    name: str,
) -> tuple[Link, Joint, Placement]:
    """The link and joint of a row of a DH table, and the placement of DH frame i in the link's
    frame."""
    where = f"dh row {i + 1}"
    for key in row:
        if key not in KEYS:
            raise ModelError(str(UnknownNameError("key", key, where, KEYS)))
    letter = row.get("joint", "R")
    if letter not in ("R", "P"):
        raise ModelError(f"{where}: joint is {letter!r}, expected 'R' or 'P'.")
    theta, d, a, alpha = (_entry(row, key, where, name) for key in ("theta", "d", "a", "alpha"))
    # steps of their own, also where they are zero: each entry keeps its place
    about_z, along_z = Placement((AxisRotation("z", theta),)), Placement((Shift((0.0, 0.0, d)),))
    along_x, about_x = Placement((Shift((a, 0.0, 0.0)),)), Placement((AxisRotation("x", alpha),))
    link_shape = along_x.then(about_x)
    if convention == "modified":
        placement = behind.then(about_x).then(along_x).then(about_z).then(along_z)
        frame = Placement()
    elif letter == "R":
        placement, frame = behind.then(about_z), along_z.then(link_shape)
    else:
        placement, frame = behind.then(about_z).then(along_z), link_shape
    called = str(row.get("name", f"link{i + 1}"))
    link = Link(called, _inertia(row, where), frame, line, stated="I" in row)
    joint = Joint(
        name,
        BY_LETTER[letter],
        parent,
        link.name,
        placement,
        (0.0, 0.0, 1.0),
        Limits.of(row.get("limits"), where),
        _drive(row, where),
        line=line,
        passive=_flag(row.get("passive", False), where),
    )
    return link, joint, frame


def _entry(row: Mapping[str, Any], key: str, where: str, joint: str) -> Quantity:
    """An entry of a DH table: a number that keeps its joint and column as a name, or a symbol."""
    given = quantity(row.get(key, 0.0), f"{where}: {key}")
    return NamedNumber(given, (joint, key)) if isinstance(given, float) else given


def _flag(value: object, where: str) -> bool:
    if not isinstance(value, bool):
        raise ModelError(f"{where}: passive is {value!r}, expected True or False.")
    return value


def _inertia(row: Mapping[str, Any], where: str) -> Inertia | None:
    if not any(key in row for key in ("m", "com", "I")):
        return None
    if "m" not in row:
        raise ModelError(f"{where}: com or I without a mass; add m.")
    com, tensor = row.get("com", (0.0, 0.0, 0.0)), row.get("I", (0.0,) * 6)
    if np.shape(com) != (3,):
        raise ModelError(f"{where}: com is {com!r}, expected 3 entries.")
    try:
        return Inertia.of(row["m"], com, tensor)
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from None


def _drive(row: Mapping[str, Any], where: str) -> Drive:
    friction = row.get("friction", 0.0)
    if not isinstance(friction, tuple | list | Mapping):
        friction = (friction, 0.0)
    if not isinstance(friction, Mapping):
        if len(friction) != 2:
            raise ModelError(
                f"{where}: friction must be {_FRICTION[0]}, or ({', '.join(_FRICTION)}); got "
                f"{friction!r}."
            )
        friction = dict(zip(_FRICTION, friction, strict=True))
    given = {**friction, "rotor": row.get("rotor", 0.0), "gear": row.get("gear", 1.0)}
    numbers = {
        name: quantity(x, f"{where}: {'friction' if name in friction else name}")
        for name, x in given.items()
    }
    try:
        return Drive(**numbers)
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from None
