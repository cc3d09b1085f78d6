"""URDF: links, inertias, joints, limits, friction and mimics; motors and loops are read by
`urdf_motors`. Everything else in the file is counted and reported.

A joint's frame is the child link's at q = 0; rpy are fixed-axis roll, pitch, yaw; the axis is in
the joint's frame and (1, 0, 0) by default; damping is in N m s/rad or N s/m, friction in N m or N.
docs/formats.md states the policy."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.errors import UnknownNameError
from freebody.formats import read_file, urdf_motors
from freebody.formats.urdf_elements import UNEXPANDED, UNLIMITED, Elements, XmlElement
from freebody.model.description import (
    INFINITE,
    Drive,
    Joint,
    Limits,
    Link,
    Notice,
    RobotDescription,
)
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia
from freebody.model.joints import KINDS
from freebody.model.mimics import Mimic
from freebody.model.placement import Placement, rotate, rpy, shift
from freebody.model.shapes import SHAPE_KINDS, Shape, ShapeRole, SolidKind
from freebody.spatial import unit

TYPES = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "free",
    "spherical": "spherical",  # Bullet's, outside the format's own list
    "planar": "planar",
}
_TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_ROLES: tuple[ShapeRole, ...] = ("collision", "visual")
_ROUND = "radius", "length"
_SOLIDS: dict[str, tuple[SolidKind, tuple[str, ...]]] = {
    "box": ("box", ("size",)),
    "cylinder": ("cylinder", _ROUND),
    "sphere": ("sphere", ("radius",)),
    "capsule": ("capsule", _ROUND),  # since version 1.2 of the format
    "drake:capsule": ("capsule", _ROUND),
    "drake:ellipsoid": ("ellipsoid", ("a", "b", "c")),
}
"""The kind of solid that an element stands for, and the attributes with its sizes."""


def describe(robot: XmlElement, file: str, *, name: str, snap_angles: float) -> RobotDescription:
    """The description in a URDF's root element, of that file. `name` stands in where <robot> has
    none; snap_angles in rad."""
    return _UrdfReader(file, snap_angles).description(robot, name)


class _UrdfReader(Elements):
    """The reader of one URDF, with the links and joints found so far and the notices about the
    file."""

    def __init__(self, file: str, snap: float):
        super().__init__(file, snap)
        self.links: list[Link] = []
        self.joints: list[Joint] = []

    def description(self, robot: XmlElement, name: str) -> RobotDescription:
        if robot.tag != "robot":
            self.refuse(
                robot,
                f"the root element is <{robot.tag}>, expected <robot>{other_format(robot.tag)}.",
            )
        self.only(robot, "name", "version")
        self.notices += [Notice("passed over", text, self.file) for text in robot.passed_over]
        if robot.name():
            name = robot.name()
        else:
            self.notice("name", robot, f"<robot> has no name; the file's is used, {name!r}.")
        self.sort_out(robot, "link", "joint", "transmission", "loop", "coupling")
        if not robot.all("link"):
            unexpanded = any(child.tag.startswith("xacro:") for child in robot.children)
            hint = f"; it is xacro, {UNEXPANDED}" if unexpanded else ""
            self.refuse(robot, f"there are no links; a robot needs at least one{hint}.")
        for element in robot.all("link"):
            self.link(element)
        for element in robot.all("joint"):
            self.joint(element)
        loops, mounts = urdf_motors.loops(self, robot)
        joints = urdf_motors.with_motors(self, robot, self.joints, bool(loops))
        return RobotDescription(
            name,
            3,
            tuple(self.links),
            tuple(joints),
            gravity_of(9.81, 3, name="g"),
            mounts=tuple(mounts),
            loops=tuple(loops),
            source=self.file,
            notices=(*self.notices, *self.summary()),
            file=self.file,
            real=True,
        )

    # ------------------------------------------------------------ links and joints
    def link(self, element: XmlElement) -> None:
        self.only(element, "name")
        self.sort_out(element, "inertial")
        where = f"link {element.name()!r}"
        inertial = self.one(element, "inertial", where)
        inertia, placement = self.inertial(inertial, where) if inertial else (None, Placement())
        line = (inertial or element).line
        self.links.append(Link(element.name(), inertia, placement, line, shapes_of(element)))

    def inertial(self, element: XmlElement, where: str) -> tuple[Inertia, Placement]:
        """Mass properties and the frame they are given in; without a rotation that frame is the
        link's own."""
        self.only(element)
        self.sort_out(element, "origin", "mass", "inertia")
        mass, tensor = (self.one(element, tag, where) for tag in ("mass", "inertia"))
        if mass is None or tensor is None:
            tag = "mass" if mass is None else "inertia"
            self.refuse(
                element,
                f"{where}: <inertial> has no <{tag}>; add it, or remove <inertial> from a link "
                f"without mass.",
            )
        self.only(mass, "value")
        self.only(tensor, *_TENSOR)
        entries = tuple(self.number(tensor, key, where) for key in _TENSOR)
        kilograms = self.number(mass, "value", where)
        xyz, turned = self.origin(element, where)
        if turned.steps:
            return Inertia(kilograms, (0.0, 0.0, 0.0), entries), shift(*xyz).then(turned)
        return Inertia(kilograms, xyz, entries), Placement()

    def joint(self, element: XmlElement) -> None:
        self.only(element, "name", "type")
        where = f"joint {element.name()!r}"
        given = self.text(element, "type", where)
        if given not in TYPES:
            self.refuse(element, str(UnknownNameError("type", given, where, TYPES)))
        kind = TYPES[given]
        parts = ["origin", "parent", "child"]
        if KINDS[kind].nv == 1:
            parts += ["axis", "limit", "dynamics", "mimic"]
        elif kind == "planar":
            parts += ["axis"]
        self.sort_out(element, *parts, owner=f"a {given} joint")
        parent, child = (self.end(element, tag, where) for tag in ("parent", "child"))
        placement = self.placement(element, where)
        if kind == "planar":
            self.planar(element, where, parent, child, placement)
            return
        axis, limits, drive, mimic = (), Limits(), Drive(), None
        if KINDS[kind].needs_axis:
            axis = self.axis(element, where)
            limits = self.limits(element, kind, where)
            drive = self.drive(element, where)
            mimic = self.mimic(element, where)
        self.joints.append(
            Joint(
                element.name(),
                kind,
                parent,
                child,
                placement,
                axis,
                limits,
                drive,
                mimic,
                element.line,
            )
        )

    def end(self, element: XmlElement, tag: str, where: str) -> str:
        """The name of the link that <parent> or <child> refers to."""
        end = self.one(element, tag, where)
        if end is None:
            self.refuse(element, f'{where}: it has no <{tag}>; add <{tag} link="..."/>.')
        self.only(end, "link")
        return self.text(end, "link", where)

    def planar(
        self, element: XmlElement, where: str, parent: str, child: str, placement: Placement
    ) -> None:
        """Add URDF's planar joint, which moves in the plane normal to its axis, as one that moves
        in the xy-plane of its frame."""
        x, y, z = unit(self.axis(element, where))
        name, line = element.name(), element.line
        if z == 1.0:
            self.joints.append(Joint(name, "planar", parent, child, placement, line=line))
            return
        # the shortest turn that takes z to the normal, undone behind the joint so that the child
        # keeps its frame
        if z == -1.0:
            matrix = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
        else:
            k = 1.0 / (1.0 + z)
            matrix = (
                (1.0 - k * x * x, -k * x * y, x),
                (-k * x * y, 1.0 - k * y * y, y),
                (-x, -y, z),
            )
        plane = f"{child}_plane"
        self.links.append(Link(plane, line=line))
        self.joints.append(
            Joint(name, "planar", parent, plane, placement.then(rotate(matrix)), line=line)
        )
        back = tuple(zip(*matrix, strict=True))
        self.joints.append(Joint(f"{name}_back", "fixed", plane, child, rotate(back), line=line))
        self.notice(
            "planar",
            element,
            f"{where}: x, y and the angle are those of frame {plane!r}, whose z is the joint's "
            f"axis.",
        )

    def limits(self, element: XmlElement, kind: str, where: str) -> Limits:
        tag = self.one(element, "limit", where)
        if tag is None:
            if KINDS[kind].ranged:
                self.notice(
                    "limits",
                    element,
                    f"{where}: a {kind} joint without <limit>; its range is taken as infinite.",
                )
            return Limits()
        ranges = ("lower", "upper") if KINDS[kind].ranged else ()
        self.only(tag, *ranges, "velocity", "effort", owner=f"<limit> of a {kind} joint")
        absent = [key for key in ranges if key not in tag.attributes]
        if absent:
            self.notice(
                "limits",
                tag,
                f"{where}: <limit> without {' and '.join(absent)}, taken as infinite.",
            )
        lower, upper = (
            self.number(tag, key, where, default, infinite=True) if key in ranges else default
            for key, default in (("lower", -INFINITE), ("upper", INFINITE))
        )
        velocity, effort = (self.most(tag, key, where) for key in ("velocity", "effort"))
        return Limits(
            lower if lower > -UNLIMITED else -INFINITE,
            upper if upper < UNLIMITED else INFINITE,
            velocity,
            effort,
        )

    def most(self, tag: XmlElement, key: str, where: str) -> float:
        """A limit of speed or effort; infinite for 0, which exporters write for an unknown limit
        and which no joint has."""
        value = self.number(tag, key, where, INFINITE, infinite=True)
        if value != 0.0:
            return value if value < UNLIMITED else INFINITE
        n, first = self.unknown.get(key, (0, tag.line))
        self.unknown[key] = n + 1, first
        return INFINITE

    def drive(self, element: XmlElement, where: str) -> Drive:
        tag = self.one(element, "dynamics", where)
        if tag is None:
            return Drive()
        self.only(tag, "damping", "friction")
        return Drive(
            viscous=self.number(tag, "damping", where, 0.0),
            coulomb=self.number(tag, "friction", where, 0.0),
        )

    def mimic(self, element: XmlElement, where: str) -> Mimic | None:
        tag = self.one(element, "mimic", where)
        if tag is None:
            return None
        self.only(tag, "joint", "multiplier", "offset")
        return Mimic(
            self.text(tag, "joint", where),
            self.number(tag, "multiplier", where, 1.0),
            self.number(tag, "offset", where, 0.0),
        )


def other_format(tag: str) -> str:
    """Words in brackets for a file with a root element of that tag; empty where nobody knows."""
    return {
        "sdf": " (this is SDF)",
        "mujoco": " (this is MJCF)",
        "mujocoinclude": " (this is a part of an MJCF file, load one that includes it)",
        "package": " (this names a ROS package, its robots are in other files)",
        "COLLADA": " (this is a mesh)",
    }.get(tag, "")


def shapes_of(link: XmlElement) -> tuple[Shape, ...]:
    """The shapes of a <link> that can be read: sizes finite and above 0, a mesh with its file's
    name. Others are ignored, since the dynamics do not depend on shapes."""
    return tuple(
        shape
        for role in _ROLES
        for element in link.all(role)
        for shape in _shapes_in(element, role)
    )


def _shapes_in(element: XmlElement, role: ShapeRole) -> Iterator[Shape]:
    try:
        placement = _shape_origin(element)
        for geometry in element.all("geometry"):
            for part in geometry.children:
                yield from _shape(part, placement, role)
    except (ValueError, KeyError):  # no number, or none at all
        return


def _shape(part: XmlElement, placement: Placement, role: ShapeRole) -> Iterator[Shape]:
    given, line = part.attributes, part.line
    if part.tag in _SOLIDS:
        kind, keys = _SOLIDS[part.tag]
        size = _sizes(" ".join(given[key] for key in keys), len(SHAPE_KINDS[kind].sizes))
        yield Shape(kind, size, placement, role, line=line)
    elif part.tag == "mesh" and given.get("filename", "").strip():
        size = _numbers(given.get("scale", "1 1 1"), 3)
        yield Shape("mesh", size, placement, role, given["filename"].strip(), line)


def _shape_origin(element: XmlElement) -> Placement:
    for origin in element.all("origin"):
        position = _numbers(origin.attributes.get("xyz", "0 0 0"), 3)
        angles = _numbers(origin.attributes.get("rpy", "0 0 0"), 3)
        return shift(*position).then(rpy(*angles))
    return Placement()


def _sizes(text: str, count: int) -> tuple[float, ...]:
    values = _numbers(text, count)
    if min(values) <= 0.0:
        raise ValueError(text)
    return values


def _numbers(text: str, count: int) -> tuple[float, ...]:
    values = tuple(
        x for x in map(read_file.number, text.split()) if x is not None and not read_file.fault(x)
    )
    if len(values) != count:
        raise ValueError(text)
    return values
