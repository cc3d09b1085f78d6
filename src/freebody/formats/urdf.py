"""URDF: links, inertias, joints, limits, friction and mimics. Whatever else the file holds is counted and reported.

Conventions: a joint's frame is the child link's at q = 0; rpy are fixed-axis roll, pitch, yaw; the axis is in the joint's frame
and (1, 0, 0) by default; damping is N m s/rad or N s/m, friction N m or N. See docs/formats.md for the policy.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from typing import NoReturn

from freebody.errors import FileError, UnknownNameError
from freebody.formats.xml import Element, parse
from freebody.model.inertia import Inertia
from freebody.model.model import gravity_of
from freebody.model.parameters import Parameter
from freebody.model.parts import INFINITE, Description, Drive, Joint, Limits, Link, Mimic, Notice
from freebody.model.placement import Placement, rotate, rpy, shift

KINDS = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "free",
    "planar": "planar",
}
_SHAPES = ("visual", "collision", "material")
_TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?inf(inity)?", re.IGNORECASE)


def describe(file: str, data: bytes, *, name: str, snap_angles: float) -> Description:
    """The description in a URDF file. `name` stands in where <robot> has none; snap_angles in rad."""
    return _Reader(file, snap_angles).description(parse(file, data), name)


class _Reader:
    """One reading: the file, and what is to be reported about it."""

    def __init__(self, file: str, snap: float):
        self.file, self.snap = file, snap
        self.notices: list[Notice] = []
        self.shapes: Counter[str] = Counter()
        self.ignored: dict[str, list[int]] = {}
        self.changes: list[float] = []
        self.links: list[Link] = []
        self.joints: list[Joint] = []

    def description(self, robot: Element, name: str) -> Description:
        if robot.tag != "robot":
            self.refuse(robot, f"the root element is <{robot.tag}>, expected <robot>{_other_format(robot.tag)}.")
        self.only(robot, "name", "version")
        if robot.name():
            name = robot.name()
        else:
            self.notice("name", robot, f"<robot> has no name; the file's is used, {name!r}.")
        self.sort_out(robot, "link", "joint")
        if not robot.all("link"):
            xacro = any(child.tag.startswith("xacro:") for child in robot.children)
            hint = "; it looks like xacro: expand it first with `xacro FILE > out.urdf`" if xacro else ""
            self.refuse(robot, f"there are no links; a robot needs at least one{hint}.")
        for element in robot.all("link"):
            self.link(element)
        for element in robot.all("joint"):
            self.joint(element)
        return Description(
            name,
            3,
            tuple(self.links),
            tuple(self.joints),
            gravity_of(Parameter("g", 9.81), 3),
            source=self.file,
            notices=(*self.notices, *self.summary(robot)),
            file=self.file,
        )

    # ------------------------------------------------------------ links and joints
    def link(self, element: Element) -> None:
        self.only(element, "name")
        self.sort_out(element, "inertial")
        where = f"link {element.name()!r}"
        inertial = self.one(element, "inertial", where)
        inertia, placement = self.inertial(inertial, where) if inertial else (None, Placement())
        self.links.append(Link(element.name(), inertia, placement, (inertial or element).line))

    def inertial(self, element: Element, where: str) -> tuple[Inertia, Placement]:
        """Mass properties and the frame they are given in; without a rotation that frame is the link's own."""
        self.only(element)
        self.sort_out(element, "origin", "mass", "inertia")
        mass, tensor = (self.one(element, tag, where) for tag in ("mass", "inertia"))
        if mass is None or tensor is None:
            tag = "mass" if mass is None else "inertia"
            self.refuse(element, f"{where}: <inertial> has no <{tag}>; add it, or remove <inertial> from a link without mass.")
        self.only(mass, "value")
        self.only(tensor, *_TENSOR)
        entries = tuple(self.number(tensor, key, where) for key in _TENSOR)
        kilograms = self.number(mass, "value", where)
        xyz, turned = self.origin(element, where)
        if turned.steps:
            return Inertia(kilograms, (0.0, 0.0, 0.0), entries), shift(*xyz).then(turned)
        return Inertia(kilograms, xyz, entries), Placement()

    def joint(self, element: Element) -> None:
        self.only(element, "name", "type")
        where = f"joint {element.name()!r}"
        given = self.text(element, "type", where)
        if given not in KINDS:
            self.refuse(element, str(UnknownNameError("type", given, where, KINDS)))
        kind = KINDS[given]
        parts = ["origin", "parent", "child"]
        if kind in ("revolute", "continuous", "prismatic"):
            parts += ["axis", "limit", "dynamics", "mimic"]
        elif kind == "planar":
            parts += ["axis"]
        self.sort_out(element, *parts, owner=f"<{given}> joint")
        ends = []
        for tag in ("parent", "child"):
            end = self.one(element, tag, where)
            if end is None:
                self.refuse(element, f"{where}: it has no <{tag}>; add <{tag} link=\"...\"/>.")
            self.only(end, "link")
            ends.append(self.text(end, "link", where))
        xyz, turned = self.origin(element, where)
        placement = shift(*xyz).then(turned)
        if kind == "planar":
            self.planar(element, where, ends[0], ends[1], placement)
            return
        axis, limits, drive, mimic = (), Limits(), Drive(), None
        if kind not in ("fixed", "free"):
            axis = self.axis(element, where)
            limits, drive, mimic = self.limits(element, kind, where), self.drive(element, where), self.mimic(element, where)
        self.joints.append(Joint(element.name(), kind, *ends, placement, axis, limits, drive, mimic, element.line))

    def planar(self, element: Element, where: str, parent: str, child: str, placement: Placement) -> None:
        """URDF's planar joint moves in the plane normal to its axis; ours in the xy-plane of its frame."""
        x, y, z = _unit(self.axis(element, where))
        name, line = element.name(), element.line
        if z == 1.0:
            self.joints.append(Joint(name, "planar", parent, child, placement, line=line))
            return
        # the shortest turn that takes z to the normal, undone behind the joint so that the child keeps its frame
        if z == -1.0:
            matrix = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
        else:
            k = 1.0 / (1.0 + z)
            matrix = ((1.0 - k * x * x, -k * x * y, x), (-k * x * y, 1.0 - k * y * y, y), (-x, -y, z))
        plane = f"{child}_plane"
        self.links.append(Link(plane, line=line))
        self.joints.append(Joint(name, "planar", parent, plane, placement.then(rotate(matrix)), line=line))
        back = tuple(zip(*matrix, strict=True))
        self.joints.append(Joint(f"{name}_back", "fixed", plane, child, rotate(back), line=line))
        self.notice("planar", element, f"{where}: x, y and the angle are those of frame {plane!r}, whose z is the joint's axis.")

    def axis(self, element: Element, where: str) -> tuple[float, float, float]:
        """The axis as written, (1, 0, 0) where there is none; refuses a zero one."""
        tag = self.one(element, "axis", where)
        if tag is None:
            return 1.0, 0.0, 0.0
        self.only(tag, "xyz")
        axis = self.vector(tag, "xyz", where)
        length = math.hypot(*axis)
        if length == 0.0:
            self.refuse(tag, f"{where}: the axis is zero; give a direction such as xyz=\"0 0 1\".")
        if abs(length - 1.0) > 1e-6:
            self.notice("axis", tag, f"{where}: the axis has length {length:g}; it is made a unit vector.")
        return axis

    def limits(self, element: Element, kind: str, where: str) -> Limits:
        tag = self.one(element, "limit", where)
        if tag is None:
            if kind != "continuous":
                self.notice("limits", element, f"{where}: a {kind} joint without <limit>; its range is taken as infinite.")
            return Limits()
        ranges = () if kind == "continuous" else ("lower", "upper")
        self.only(tag, *ranges, "velocity", "effort", owner=f"<limit> of a {kind} joint")
        absent = [key for key in ranges if key not in tag.attributes]
        if absent:
            self.notice("limits", tag, f"{where}: <limit> without {' and '.join(absent)}, taken as infinite.")
        lower, upper = (
            self.number(tag, key, where, default, infinite=True) if key in ranges else default
            for key, default in (("lower", -INFINITE), ("upper", INFINITE))
        )
        velocity, effort = (self.number(tag, key, where, INFINITE, infinite=True) for key in ("velocity", "effort"))
        return Limits(lower, upper, velocity, effort)

    def drive(self, element: Element, where: str) -> Drive:
        tag = self.one(element, "dynamics", where)
        if tag is None:
            return Drive()
        self.only(tag, "damping", "friction")
        return Drive(viscous=self.number(tag, "damping", where, 0.0), coulomb=self.number(tag, "friction", where, 0.0))

    def mimic(self, element: Element, where: str) -> Mimic | None:
        tag = self.one(element, "mimic", where)
        if tag is None:
            return None
        self.only(tag, "joint", "multiplier", "offset")
        return Mimic(
            self.text(tag, "joint", where),
            self.number(tag, "multiplier", where, 1.0),
            self.number(tag, "offset", where, 0.0),
        )

    def origin(self, element: Element, where: str) -> tuple[tuple[float, float, float], Placement]:
        """Shift (m) and rotation of the <origin> inside."""
        tag = self.one(element, "origin", where)
        if tag is None:
            return (0.0, 0.0, 0.0), Placement()
        self.only(tag, "xyz", "rpy")
        angles = self.vector(tag, "rpy", where)
        for angle in angles:
            off = abs(angle - round(angle / (math.pi / 2)) * (math.pi / 2))
            if 0.0 < off <= self.snap:
                self.changes.append(off)
        return self.vector(tag, "xyz", where), rpy(*angles, snap=self.snap)

    # ------------------------------------------------------------ attributes
    def text(self, element: Element, key: str, where: str) -> str:
        value = element.attributes.get(key, "").strip()
        if not value:
            self.refuse(element, f"{where}: <{element.tag}> has no {key}; add {key}=\"...\".")
        return value

    def number(
        self, element: Element, key: str, where: str, default: float | None = None, infinite: bool = False
    ) -> float:
        """A number; infinity only where asked for."""
        if key not in element.attributes and default is not None:
            return default
        return self.read(element, key, self.text(element, key, where), where, infinite)

    def vector(self, element: Element, key: str, where: str) -> tuple[float, float, float]:
        """Three numbers, zeros where the attribute is absent."""
        words = element.attributes.get(key, "0 0 0").split()
        if len(words) != 3:
            self.refuse(element, f"{where}: {key}=\"{' '.join(words)}\" has {len(words)} entries, expected 3 numbers.")
        x, y, z = (self.read(element, key, word, where) for word in words)
        return x, y, z

    def read(self, element: Element, key: str, word: str, where: str, infinite: bool = False) -> float:
        value = float(word) if _NUMBER.fullmatch(word) else math.nan
        if math.isnan(value) or (math.isinf(value) and not infinite):
            hint = "; it is a xacro expression: expand the file first with `xacro FILE > out.urdf`" if "${" in word else ""
            kind = "number" if infinite else "finite number"
            self.refuse(element, f"{where}: {key} of <{element.tag}> is {word!r}, expected a {kind}{hint}.")
        return value

    # ------------------------------------------------------------ what is not used
    def only(self, element: Element, *known: str, owner: str | None = None) -> None:
        """Count the attributes that are not read."""
        for key in element.attributes:
            if key not in known and not key.startswith("xmlns"):
                self.count(f"attribute {key} of {owner or f'<{element.tag}>'}", element.line)

    def sort_out(self, element: Element, *known: str, owner: str | None = None) -> None:
        """Count the elements inside that are not read."""
        for child in element.children:
            if child.tag in _SHAPES:
                self.shapes[child.tag] += 1
            elif child.tag not in known:
                self.count(f"<{child.tag}> in {owner or f'<{element.tag}>'}", child.line)

    def count(self, what: str, line: int) -> None:
        self.ignored.setdefault(what, [0, line])[0] += 1

    def one(self, element: Element, tag: str, where: str) -> Element | None:
        """The only element of that tag inside, or None."""
        found = element.all(tag)
        if len(found) > 1:
            self.refuse(found[1], f"{where}: there are {len(found)} <{tag}>; keep one.")
        return found[0] if found else None

    def summary(self, robot: Element) -> list[Notice]:
        """Notices on the whole file: snapped angles, shapes, ignored elements and attributes."""
        notices = []
        if self.changes:
            text = (
                f"{len(self.changes)} angles lie within {self.snap:g} rad of a multiple of a right angle and are read as "
                f"that multiple; largest change {max(self.changes):.2g} rad. snap_angles=0 reads them as written."
            )
            notices.append(Notice("snapped", text, self.file))
        if self.shapes:
            listed = ", ".join(f"{n} <{tag}>" for tag, n in sorted(self.shapes.items()))
            notices.append(Notice("skipped", f"shapes play no part in the dynamics: {listed} are not read.", self.file))
        for what, (n, line) in self.ignored.items():
            times = "once" if n == 1 else f"{n} times, first here"
            notices.append(Notice("ignored", f"{what} is ignored ({times}){self.remark(what, robot)}.", self.file, line))
        return notices

    def remark(self, what: str, robot: Element) -> str:
        """What an ignored element says about gears, which the dynamics would need."""
        if what != "<transmission> in <robot>":
            return ""
        ratios: dict[str, str] = {}
        for transmission in robot.all("transmission"):
            reductions = [e for part in (transmission, *transmission.children) for e in part.all("mechanicalReduction")]
            name = transmission.name()
            ratios.update({name: e.content for e in reductions if e.content not in ("1", "1.0", "")})
        if not ratios:
            return ""
        first, ratio = next(iter(ratios.items()))
        return (
            f"; {len(ratios)} of them give a mechanicalReduction other than 1 (first {first!r}: {ratio}), "
            "but URDF has no rotor inertia that it would multiply"
        )

    def notice(self, kind: str, element: Element, text: str) -> None:
        self.notices.append(Notice(kind, text, self.file, element.line))

    def refuse(self, element: Element, problem: str) -> NoReturn:
        raise FileError(self.file, element.line, problem)


def _unit(axis: tuple[float, float, float]) -> tuple[float, ...]:
    length = math.hypot(*axis)
    return tuple(x / length for x in axis)


def _other_format(tag: str) -> str:
    return {"sdf": " (this is SDF)", "mujoco": " (this is MJCF)", "COLLADA": " (this is a mesh)"}.get(tag, "")
