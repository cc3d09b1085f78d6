"""The Denavit-Hartenberg table of a serial arm, fitted to its joint axes, which is possible for
every arm of turning and sliding joints (Siciliano et al. 2009, section 2.8.2), between a base and a
tool.

Frame i of the standard convention has its z on the axis of joint i + 1 and its x on the common
normal of the axes i and i + 1, so that the pose of a link is told by two turns and two shifts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from freebody.errors import FreebodyError, listed
from freebody.formats import dh_csv
from freebody.formats.writing.contents import (
    Contents,
    Holds,
    WrittenLink,
    contents_of,
    lost_names,
)
from freebody.formats.writing.xml import angles
from freebody.model.build import build_model
from freebody.model.description import INFINITE
from freebody.model.inertia import Inertia, combined
from freebody.model.model import Model
from freebody.model.placement import AxisRotation, Placement, Shift
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Pose
from freebody.spatial import space

HOLDS = Holds(
    "a DH table",
    kinds={"revolute": "R", "continuous": "R", "prismatic": "P"},
    drive=frozenset(("viscous", "coulomb", "rotor", "gear")),
    gravity=True,
    keeps_tip=True,
)
_PARALLEL = 1e-12
"""Sine of the angle below which two axes are parallel."""
_ROUNDED = 1e-14
"""Size of what rounding leaves of a length (m) or angle (rad) that is 0."""
_SAME = 1e-12
"""Difference of poses that are one, m or as a sine."""
_FITTED = 1e-9
"""Residual of the fit, m or as a sine, above which it is a loss."""
DhFrame = tuple[np.ndarray, np.ndarray]
"""(R, p) in the root link at q = 0."""


@dataclass(frozen=True)
class _Fit:
    """A fitted DH table: its frames with all joints at 0, frame 0 first, and its rows theta, d, a,
    alpha."""

    frames: tuple[DhFrame, ...]
    rows: tuple[tuple[float, float, float, float], ...]


def written(model: Model) -> tuple[str, list[str]]:
    """The DH table of a model as text, and sentences on what the table loses of the model."""
    contents = contents_of(model, HOLDS)
    chain = _chain(contents)
    drawn = _drawn(contents)
    inner = model.tip in drawn and not _moves_with(contents, model.tip, chain[-1])
    tip = drawn[model.tip if model.tip in drawn and not inner else chain[-1].name]
    axes = [_axis(link, drawn) for link in chain]
    fit = _fitted(axes, tip)
    tool = _between(fit.frames[-1], tip)
    off = _residual(fit, axes, tool, tip)
    remarks = {
        "convention": "standard",
        "name": contents.name,
        "source": model.source,
        "gravity": _number(math.hypot(*contents.gravity)),
    }
    for name, pose in (("base", fit.frames[0]), ("tool", tool)):
        if not _is_near(pose, (np.eye(3), np.zeros(3))):
            remarks[name] = " ".join(map(_number, (*pose[1], *angles(pose[0].tolist()))))
    head = [f"# {name}: {' '.join(x.split())}" for name, x in remarks.items() if x.strip()]
    head.append(f"# fitted to the axes of the joints, which are off by at most {off:.1g}")
    table = [_row(contents, link, k, drawn, fit) for k, link in enumerate(chain)]
    used = [c for c in dh_csv.COLUMNS if any(row.get(c) for row in table)]
    lines = [", ".join(used), *(", ".join(row.get(c, "") for c in used) for row in table)]
    text = "\n".join([*head, *lines]) + "\n"
    fixed = lost_names(link.fixed for link in contents.links if link.fixed)
    losses = [*contents.losses, *_lost(contents, drawn, text, None if inner else model.tip), *fixed]
    losses += _lost_of_arm(contents, chain, model.tip if inner else None)
    if off > _FITTED:
        losses.append(f"{off:.1g} m or rad: the table does not fit the axes better")
    return text, losses


def _lost_of_arm(contents: Contents, chain: list[WrittenLink], inner: str | None) -> list[str]:
    """Sentences on what a DH table loses of an arm: the order of its coordinates, a tip (`inner`)
    that is not on the last link, a base with mass."""
    losses = []
    if inner is not None:
        losses.append(
            f"the tip {inner!r}, which the last joint does not move: that of a table is on the "
            f"last link"
        )
    order = tuple(link.joint.name for link in chain if link.joint)
    if order != contents.joint_names:
        losses.append(
            f"the order of its coordinates, which is that from the base outwards: "
            f"{', '.join(order)}"
        )
    resting = _resting(contents)
    if resting:
        losses.append(f"the mass of {listed(resting, 6)}, which does not move")
    return losses


# ---------------------------------------------------------------- the arm
def _chain(contents: Contents) -> list[WrittenLink]:
    """The links that joints move, from the base outwards. Refuses what is no serial arm."""
    chain, above = [], {link.name: link for link in contents.links}
    for link in contents.links:
        if link.joint is None:
            continue
        if link.joint.mimic:
            _refuse(contents, f"joint {link.joint.name!r} follows another")
        carrier = above[link.parent]
        while carrier.parent and carrier.joint is None:
            carrier = above[carrier.parent]
        if carrier is not (chain[-1] if chain else contents.links[0]):
            _refuse(contents, f"link {link.name!r} branches off")
        chain.append(link)
    if not chain:
        _refuse(contents, "nothing moves")
    return chain


def _moves_with(contents: Contents, name: str, link: WrittenLink) -> bool:
    """Whether a link or frame is fixed to a link."""
    at = contents.parts[name]
    while at.parent and at.joint is None:
        at = contents.parts[at.parent]
    return at is link


def _refuse(contents: Contents, why: str) -> None:
    raise FreebodyError(
        f"save: a DH table is one serial arm, and {contents.name!r} is none: {why}. Write it as "
        f".toml."
    )


def _drawn(contents: Contents) -> dict[str, DhFrame]:
    """The poses of links and frames with every joint at 0, by name."""
    found: dict[str, DhFrame] = {"": (np.eye(3), np.zeros(3))}
    for link in contents.links:
        found[link.name] = _composed(found[link.parent], link.pose)
    return found


def _axis(link: WrittenLink, drawn: dict[str, DhFrame]) -> DhFrame:
    """A frame with its origin at a link's joint and its z axis along the joint's axis."""
    R, p = drawn[link.name]
    assert link.joint
    return R @ _towards(np.array(link.joint.axis)), p


def _towards(axis: np.ndarray) -> np.ndarray:
    """A rotation that takes z to a given axis; made of whole numbers where that is a coordinate
    axis."""
    if axis[2] == 1.0:
        return np.eye(3)
    k = int(np.argmin(abs(axis)))
    x = np.eye(3)[k] - axis[k] * axis
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


# ---------------------------------------------------------------- the fit
def _fitted(axes: list[DhFrame], tip: DhFrame) -> _Fit:
    """A DH table fitted to the joints' axes in their order; its last frame is the tip where a row
    can reach it."""
    first = axes[0]
    on_z = math.hypot(*first[1][:2]) <= _ROUNDED and first[0][2, 2] >= 1.0 - _ROUNDED
    frames = [(np.eye(3), np.zeros(3)) if on_z else first]
    rows = []
    for k in range(len(axes)):
        R, p = frames[-1]
        if k + 1 < len(axes):
            x, z, origin = _common_normal(frames[-1], axes[k + 1])
        else:
            x, z, origin = _end(frames[-1], tip)
        theta = _clean(math.atan2(x @ R[:, 1], x @ R[:, 0]))
        alpha = _clean(math.atan2(np.cross(R[:, 2], z) @ x, R[:, 2] @ z))
        d, a = (_clean(float((origin - p) @ along)) for along in (R[:, 2], x))
        rows.append((theta, d, a, alpha))
        frames.append(_composed(frames[-1], _stepped(*rows[-1])))
    return _Fit(tuple(frames), tuple(rows))


def _common_normal(frame: DhFrame, axis: DhFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The x axis, z axis and origin of the next DH frame, whose z lies along a given axis."""
    (R, p), z, on = frame, axis[0][:, 2], axis[1]
    across = np.cross(R[:, 2], z)
    sine = np.linalg.norm(across)
    if sine > _PARALLEL:
        # where the axis is nearest to the one before
        along = float(np.cross(on - p, R[:, 2]) @ across / sine**2)
        return across / sine, z, on + along * z
    apart = on - p
    apart = apart - (apart @ R[:, 2]) * R[:, 2]
    distance = np.linalg.norm(apart)
    return (apart / distance if distance > _SAME else R[:, 0]), z, on


def _end(frame: DhFrame, tip: DhFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The x axis, z axis and origin of the last DH frame: the tip's where a row can reach it, else
    those of the frame before."""
    R, p = _between(frame, tip)
    x, z = R[:, 0], R[:, 2]
    off = p - p[2] * np.array((0.0, 0.0, 1.0)) - (p @ x) * x
    if abs(x[2]) <= _SAME and np.linalg.norm(off) <= _SAME:
        return frame[0] @ x, frame[0] @ z, tip[1]
    return frame[0][:, 0], frame[0][:, 2], frame[1]


def _clean(value: float) -> float:
    right = round(value / (math.pi / 2)) * (math.pi / 2)
    return right if abs(value - right) <= _ROUNDED else 0.0 if abs(value) <= _ROUNDED else value


def _residual(fit: _Fit, axes: list[DhFrame], tool: DhFrame, tip: DhFrame) -> float:
    """How far the table's axes and tip are from the arm's: the largest deviation, in m or as the
    sine of an angle."""
    R, p = _composed(fit.frames[-1], tool)
    off = [abs(R - tip[0]).max(), abs(p - tip[1]).max()]
    for (own, at), (its, on) in zip(fit.frames[:-1], axes, strict=True):
        off += [abs(own[:, 2] - its[:, 2]).max(), np.linalg.norm(np.cross(on - at, its[:, 2]))]
    return float(max(off))


# ---------------------------------------------------------------- the table
def _row(
    contents: Contents, link: WrittenLink, k: int, drawn: dict[str, DhFrame], fit: _Fit
) -> dict[str, str]:
    joint = link.joint
    assert joint
    theta, d, a, alpha = fit.rows[k]
    row: dict[str, float] = {"theta": theta, "d": d, "a": a, "alpha": alpha}
    row |= {"viscous": joint.drive["viscous"], "coulomb": joint.drive["coulomb"]}
    row |= {"rotor": joint.drive["rotor"], "gear": joint.drive["gear"]}
    inertia = _mass(contents, link, drawn, fit.frames[k + 1])
    if inertia is not None:
        m, com, tensor = inertia.numbers()
        row |= {"m": m, "cx": com[0], "cy": com[1], "cz": com[2]}
        entries = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        names = ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
        row |= {name: tensor[i, j] for name, (i, j) in zip(names, entries, strict=True)}
    told = {name: _number(x) for name, x in row.items() if x or name == "m"}
    if joint.drive["gear"] == 1.0:
        del told["gear"]
    limits = {
        name: getattr(joint.limits, name) for name in ("lower", "upper", "velocity", "effort")
    }
    told |= {name: _number(x) for name, x in limits.items() if abs(x) < INFINITE}
    names = {"name": (link.name, f"link{k + 1}"), "joint_name": (joint.name, f"joint{k + 1}")}
    told |= {key: _cell(name) for key, (name, usual) in names.items() if name != usual}
    return {**told, "joint": HOLDS.kinds[joint.kind]}


def _mass(
    contents: Contents, link: WrittenLink, drawn: dict[str, DhFrame], frame: DhFrame
) -> Inertia | None:
    """The inertia of all parts that move with a link, in the DH frame of its row."""
    moved, parts = {link.name}, []
    for other in contents.links:
        if other.name == link.name or (other.parent in moved and other.joint is None):
            moved.add(other.name)
            if other.inertia is not None:
                R, p = _between(frame, drawn[other.name])
                parts.append(other.inertia.placed(R, tuple(p)))
    return combined(parts) if parts else None


def _resting(contents: Contents) -> list[str]:
    """The names of the links with mass that no joint moves."""
    still, found = {""}, []
    for link in contents.links:
        if link.parent in still and link.joint is None:
            still.add(link.name)
            if link.inertia is not None and link.inertia.numbers()[0]:
                found.append(link.name)
    return found


def _cell(name: str) -> str:
    if any(x in name for x in ',;"\n\r') or name != name.strip() or not name:
        raise FreebodyError(f"save: {name!r} is no name in a DH table; rename it without commas.")
    return name


def _number(x: float) -> str:
    return repr(float(x) + 0.0)


# ---------------------------------------------------------------- what is lost
def _lost(contents: Contents, drawn: dict[str, DhFrame], text: str, tip: str | None) -> list[str]:
    """Sentences on the direction of gravity and the frames that a table, read back, lacks or has
    elsewhere."""
    x, y, z = contents.gravity
    losses = []
    if x or y or z > 0.0:
        losses.append(f"the direction of gravity ({x:g}, {y:g}, {z:g}): a table has it along -z")
    described = dh_csv.describe("table", text, name=contents.name, convention=None)
    table = build_model(described, physical="ignore")
    read = _drawn(contents_of(table, HOLDS))
    if tip is not None and tip != table.tip:
        losses.append(f"the name of the tip {tip!r}, which is {table.tip!r} in a table")
    missing = [name for name in drawn if name not in read and name != tip]
    moved = [name for name in drawn if name in read and not _is_near(drawn[name], read[name])]
    if missing:
        losses.append(f"the frames {listed(missing, 6)}")
    if moved:
        losses.append(f"where the frames {listed(moved, 6)} are on their links")
    return losses


# ---------------------------------------------------------------- poses
def _composed(outer: DhFrame, inner: Pose | DhFrame) -> DhFrame:
    return outer[0] @ np.array(inner[0]), outer[1] + outer[0] @ np.array(inner[1])


def _between(outer: DhFrame, inner: DhFrame) -> DhFrame:
    return outer[0].T @ inner[0], outer[0].T @ (inner[1] - outer[1])


def _is_near(one: DhFrame, other: DhFrame) -> bool:
    return float(max(abs(one[0] - other[0]).max(), abs(one[1] - other[1]).max())) <= _SAME


def _stepped(theta: float, d: float, a: float, alpha: float) -> Pose:
    """The pose of a DH row's frame in the frame before, computed as readers do."""
    steps = (
        AxisRotation("z", theta),
        Shift((0.0, 0.0, d)),
        Shift((a, 0.0, 0.0)),
        AxisRotation("x", alpha),
    )
    return Placement(steps).lower(space, VALUES)
