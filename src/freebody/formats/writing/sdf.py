"""SDF of a model: each link's pose is given in its parent's, so that joints, whose frame is their
child's, need no pose; rotors as Drake reads them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from freebody.errors import FreebodyError
from freebody.formats.urdf_elements import UNLIMITED
from freebody.formats.writing.format_contents import (
    GROUND,
    STANDARD_GRAVITY,
    Contents,
    Holds,
    WrittenJoint,
    WrittenLink,
    WrittenLoop,
    checked_ground,
    contents_of,
    fixed_name,
)
from freebody.formats.writing.xml import (
    TENSOR,
    Element,
    SubElement,
    angles,
    checked,
    limit,
    numbers,
    text_of,
)
from freebody.model.joints import KINDS
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.model import Model
from freebody.model.tree import Pose
from freebody.spatial import space

HOLDS = Holds(
    "SDF",
    kinds={
        "revolute": "revolute",
        "continuous": "continuous",
        "prismatic": "prismatic",
        "helical": "screw",
        "spherical": "ball",
        "free": "",
    },
    drive=frozenset(("viscous", "coulomb", "rotor", "gear", "stiffness", "rest")),
    loops=frozenset(("revolute", "prismatic", "spherical", "fixed")),
    gravity=True,
    base="load it with base='free'",
    unlimited=UNLIMITED,
)
_CLOSED = 1e-12
"""Gap, m or as a sine, up to which a loop is closed where the file draws it."""


def written(model: Model) -> tuple[str, list[str]]:
    """The SDF text of a model, and sentences on what it loses of the model."""
    contents = checked(_with_names_apart(contents_of(model, HOLDS)), "SDF")
    checked_ground(contents, "SDF")
    root = Element("sdf", {"version": "1.11"})
    outer = root
    if contents.gravity != (0.0, 0.0, -STANDARD_GRAVITY):
        outer = SubElement(root, "world", {"name": "default"})
        SubElement(outer, "gravity").text = numbers(contents.gravity)
    robot = SubElement(outer, "model", {"name": contents.name})
    links = _links(contents)
    for link in links:
        _link(robot, link)
    taken = contents.taken
    for link in contents.joined:
        if not link.mounted:
            _joint(robot, link, taken)
    for link in links:
        if link.mounted:
            frame = SubElement(robot, "frame", {"name": link.name, "attached_to": link.parent})
            _pose(frame, link.pose)
    lost = _loops(robot, contents)
    _held(robot, contents, links, taken)
    return text_of(root), [*contents.losses, *_floating(contents), *lost]


def _with_names_apart(contents: Contents) -> Contents:
    """The contents with new names for joints and loops that share the name of a link or frame,
    which SDF does not allow."""
    parts = {link.name for link in contents.links}
    given = [*sorted(contents.taken), *(loop.name for loop in contents.loops)]
    taken, renamed = parts.union(given), dict[str, str]()
    for name in given:
        if name in parts:
            renamed[name] = fixed_name(name, taken)
    if not renamed:
        return contents

    def other(joint: WrittenJoint | None) -> WrittenJoint | None:
        if joint is None:
            return None
        mimic = joint.mimic
        if mimic is not None:
            mimic = replace(mimic, joint=renamed.get(mimic.joint, mimic.joint))
        return replace(joint, name=renamed.get(joint.name, joint.name), mimic=mimic)

    return replace(
        contents,
        links=tuple(
            replace(x, joint=other(x.joint), fixed=renamed.get(x.fixed, x.fixed))
            for x in contents.links
        ),
        loops=tuple(replace(x, name=renamed.get(x.name, x.name)) for x in contents.loops),
        joint_names=tuple(renamed.get(name, name) for name in contents.joint_names),
        losses=(
            *contents.losses,
            *(
                f"the name of joint {name!r}, which a link has: {new!r} is written"
                for name, new in renamed.items()
            ),
        ),
    )


def _links(contents: Contents) -> list[WrittenLink]:
    """The links to be written; a massless root named "world" is left out, since it is SDF's world
    itself."""
    root = contents.links[0]
    if root.name != GROUND:
        return list(contents.links)
    if root.inertia is not None or contents.free:
        raise FreebodyError(
            f"save: in SDF {GROUND!r} is the ground, and not a link with mass; rename the root "
            f"link of {contents.name!r}."
        )
    return list(contents.links[1:])


def _floating(contents: Contents) -> list[str]:
    """Sentences on losses of free joints, which SDF expresses by the absence of a joint."""
    found = []
    root = contents.links[0].name
    alone = root == GROUND and sum(link.parent == root for link in contents.links) == 1
    for link in contents.links:
        if link.joint is None or link.joint.kind != "free":
            continue
        if link.parent != root or any(link.pose[1]) or not _is_unit(link.pose):
            raise FreebodyError(
                f"save: in SDF only links that are joined to nothing float, at the origin; joint "
                f"{link.joint.name!r} of {contents.name!r} is another."
            )
        found.append(
            f"the free joint {link.joint.name!r}: {link.name!r} is joined to nothing, and floats, "
            f"its coordinates the last" + (" where you load it with base='free'" if alone else "")
        )
    return found


def _is_unit(pose: Pose) -> bool:
    return bool(np.array_equal(np.array(pose[0]), np.eye(3)))


def _held(robot: Element, contents: Contents, links: list[WrittenLink], taken: set[str]) -> None:
    """Add a fixed joint from the world to a root link beside which other links float."""
    root = contents.links[0]
    if root in links and any(link.joint and link.joint.kind == "free" for link in links):
        name = fixed_name(root.name, taken)
        joint = SubElement(robot, "joint", {"name": name, "type": "fixed"})
        SubElement(joint, "parent").text = GROUND
        SubElement(joint, "child").text = root.name


def _pose(element: Element, pose: Pose, within: str = "") -> None:
    R, p = pose
    values = (*p, *angles(R))
    if any(values) or within:
        given = {"relative_to": within} if within else {}
        SubElement(element, "pose", given).text = numbers(values)


def _link(robot: Element, link: WrittenLink) -> None:
    if link.mounted:
        return
    element = SubElement(robot, "link", {"name": link.name})
    if link.parent and link.parent != GROUND and not (link.joint and link.joint.kind == "free"):
        _pose(element, link.pose, link.parent)
    else:
        _pose(element, link.pose)
    inertial = SubElement(element, "inertial")
    mass, com, tensor = (
        link.inertia.numbers() if link.inertia else (0.0, np.zeros(3), np.zeros((3, 3)))
    )
    if com.any():
        SubElement(inertial, "pose").text = numbers((*com, 0.0, 0.0, 0.0))
    SubElement(inertial, "mass").text = repr(mass)
    entries = SubElement(inertial, "inertia")
    for key, i, j in TENSOR:
        SubElement(entries, key).text = numbers((tensor[i, j],))


def _joint(robot: Element, link: WrittenLink, taken: set[str]) -> None:
    joint = link.joint
    if joint and joint.kind == "free":
        return
    name = joint.name if joint else link.fixed or fixed_name(link.name, taken)
    kind = HOLDS.kinds[joint.kind] if joint else "fixed"
    element = SubElement(robot, "joint", {"name": name, "type": kind})
    SubElement(element, "parent").text = link.parent
    SubElement(element, "child").text = link.name
    if joint and KINDS[joint.kind].needs_axis:
        _axis(element, joint)
    if joint and joint.kind == "helical":
        (pitch,) = joint.numbers
        SubElement(element, "screw_thread_pitch").text = repr(2.0 * math.pi * pitch)


def _axis(element: Element, joint: WrittenJoint) -> None:
    axis, limits, drive = SubElement(element, "axis"), joint.limits, joint.drive
    SubElement(axis, "xyz").text = numbers(joint.axis)
    bounds = SubElement(axis, "limit")
    ranges = {"lower": limits.lower, "upper": limits.upper} if KINDS[joint.kind].ranged else {}
    for key, value in {**ranges, "velocity": limits.velocity, "effort": limits.effort}.items():
        SubElement(bounds, key).text = limit(value)
    numbers_of = {
        "damping": drive["viscous"],
        "friction": drive["coulomb"],
        "spring_stiffness": drive["stiffness"],
        "spring_reference": drive["rest"],
    }
    if any(numbers_of.values()):
        dynamics = SubElement(axis, "dynamics")
        for key, value in numbers_of.items():
            SubElement(dynamics, key).text = repr(value)
    if joint.mimic:
        follow = SubElement(axis, "mimic", {"joint": joint.mimic.joint})
        numbers_of = {"multiplier": joint.mimic.ratio, "offset": joint.mimic.offset}
        for key, value in (*numbers_of.items(), ("reference", 0.0)):
            SubElement(follow, key).text = repr(value)
    for tag, value, default in (
        ("drake:rotor_inertia", drive["rotor"], 0.0),
        ("drake:gear_ratio", drive["gear"], 1.0),
    ):
        if value != default:
            SubElement(element, tag).text = repr(value)


# ---------------------------------------------------------------- loops
def _loops(robot: Element, contents: Contents) -> list[str]:
    """Add loops as joints to links that already have one; returns sentences on the loops lost
    because they are open with all joints at zero, where SDF draws them closed."""
    drawn = _drawn(contents)
    lost = []
    for loop in contents.loops:
        if not _is_closed(loop, *(drawn[frame] for frame in loop.frames)):
            lost.append(
                f"the {loop.kind} loop {loop.name!r}, which is left open: SDF draws loops closed, "
                f"and with all joints at zero it is not"
            )
            continue
        element = SubElement(
            robot, "joint", {"name": loop.name, "type": HOLDS.kinds.get(loop.kind, loop.kind)}
        )
        within = contents.parts[loop.frames[0]]
        while within.mounted:
            within = contents.parts[within.parent]
        other = contents.parts[loop.frames[1]]
        while other.mounted:
            other = contents.parts[other.parent]
        SubElement(element, "parent").text = within.name
        SubElement(element, "child").text = other.name
        SubElement(element, "pose", {"relative_to": loop.frames[0]}).text = numbers([0.0] * 6)
        if loop.axis:
            SubElement(SubElement(element, "axis"), "xyz").text = numbers(loop.axis)
    return lost


def _drawn(contents: Contents) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The poses of links and frames with every joint at zero, by name."""
    found: dict[str, tuple[np.ndarray, np.ndarray]] = {"": (np.eye(3), np.zeros(3))}
    for link in contents.links:
        R, p = found[link.parent]
        own, at = np.array(link.pose[0]), np.array(link.pose[1])
        found[link.name] = R @ own, p + R @ at
    return found


def _is_closed(loop: WrittenLoop, one: tuple, other: tuple) -> bool:
    closure = LOOP_KINDS[loop.kind].closure(space, loop.axis)
    (R, p), (other_R, other_p) = one, other
    apart = R.T @ (other_p - p)
    gaps = [*apart] if closure.point else [np.dot(n, apart) for n in closure.slides]
    gaps += [np.array(n) @ R.T @ other_R @ np.array(u) for n, u in closure.turns]
    facing = all(
        np.dot(R @ np.cross(u, n), other_R @ np.cross(u, n)) > 0.0 for n, u in closure.facing
    )
    return facing and max(map(abs, gaps), default=0.0) <= _CLOSED
