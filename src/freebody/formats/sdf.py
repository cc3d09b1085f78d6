"""SDF, the format of Gazebo and Drake: the links, joints, loops and frames of one model.

Poses are relative to the model unless they say otherwise, a joint's to its child; an axis is in the
joint's frame (up to version 1.4, and with use_parent_model_frame, in the model's). A link that is
the child of several joints closes a loop with each after the first. What else the file holds is
counted and reported.
"""

from __future__ import annotations

import math

import numpy as np

from freebody.errors import UnknownNameError, listed, shown
from freebody.formats import read_file
from freebody.formats.packages import Packages
from freebody.formats.sdf_gears import GEARBOX, SCREW, SCREW_TAGS, couple, pitch
from freebody.formats.sdf_nested import AXES_IN_JOINTS, MODEL, WORLD, NestedModels, read_version
from freebody.formats.sdf_shapes import shapes_of
from freebody.formats.urdf_elements import UNLIMITED, Elements, XmlElement
from freebody.model.description import (
    INFINITE,
    Drive,
    Joint,
    Limits,
    Link,
    Loop,
    Mount,
    RobotDescription,
)
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia
from freebody.model.mimics import Mimic
from freebody.model.placement import ArrayPose, Placement, composed, rotate, rpy, seen_from, shift
from freebody.model.quantity_reader import VALUES
from freebody.spatial import space

_TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_OTHER_WORLD = "__world__"
"""The world's name where an old file has a link called world, which its joints then mean."""
_SAME = 1e-12
"""m or of a rotation's entries: two poses that are one."""
_TYPES: dict[str, tuple[str, str | None]] = {
    "revolute": ("revolute", "revolute"),
    "continuous": ("continuous", "revolute"),
    "prismatic": ("prismatic", "prismatic"),
    "ball": ("spherical", "spherical"),
    "fixed": ("fixed", "fixed"),
    "universal": ("revolute", None),
    "revolute2": ("revolute", None),
    SCREW: ("helical", None),
}
"""The kind of joint, and of loop, of each type; those with two axes are two joints."""
_ROTOR = {"rotor": "drake:rotor_inertia", "gear": "drake:gear_ratio"}
"""Drake's elements of joints with one axis, by the number of a drive that they are."""
_AXES = {
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    SCREW: 1,
    "universal": 2,
    "revolute2": 2,
    GEARBOX: 2,
}


def describe(
    root: XmlElement, file: str, packages: Packages, *, name: str, snap_angles: float
) -> RobotDescription:
    """The description in an SDF's root element, of that file, which may include others of those
    packages. `name` stands in where the model has none; snap_angles in rad."""
    return SdfReader(file, packages, snap_angles).description(root, name)


class SdfReader(Elements):
    """The reader of one SDF file, with the frames, links and joints found so far."""

    def __init__(self, file: str, packages: Packages, snap: float):
        super().__init__(file, snap)
        self.nested = NestedModels(self, packages)
        self.links: dict[str, Link] = {}
        self.joints: list[Joint] = []
        self.mounts: list[Mount] = []
        self.loops: list[Loop] = []
        self.written: dict[str, tuple[XmlElement, str]] = {}
        """Each frame's element, and the frame its pose is relative to where it does not say."""
        still = np.eye(3), np.zeros(3)
        self.poses: dict[str, ArrayPose] = {MODEL: still}
        self.inside: dict[tuple[str, str], ArrayPose] = {}
        """Poses of frames in those that they are given in, as they are written."""
        self.world = WORLD
        self.assumed: list[str] = []
        """Links of which the format assumes a mass or inertia."""

    def description(self, root: XmlElement, name: str) -> RobotDescription:
        if root.tag != "sdf":
            self.refuse(root, f"the root element is <{root.tag}>, expected <sdf>.")
        self.version = read_version(self, root)
        model, gravity = self.model(root)
        model = self.nested.flattened(model, self.version)
        self.sort_out(model, "link", "joint", "frame", "pose", "static")
        links, joints = model.all("link"), model.all("joint")
        if not links:
            self.refuse(model, "there are no links; a robot needs at least one.")
        if any(element.name() == WORLD for element in links):
            self.world = _OTHER_WORLD
        self.poses[self.world] = self.poses[MODEL]
        for element in (*links, *model.all("frame"), *joints):
            self.declare(element)
        pose = self.one(model, "pose", "the model")
        placed = self.local(pose, "the model") if pose is not None else self.poses[MODEL]
        base = model.attributes.get("placement_frame", "").strip()
        if base:
            placed = composed(placed, seen_from(self.pose_of(base, model), self.poses[MODEL]))
        if pose is not None or base:
            self.poses[self.world] = seen_from(placed, self.poses[MODEL])
        for element in links:
            self.link(element)
        self.tree(model, joints)
        for element in model.all("frame"):
            self.frame(element)
        if self.assumed:
            self.notice(
                "inertia",
                model,
                f"warning: {listed(self.assumed, 5)}: no mass or inertia, for which SDF assumes 1 "
                f"kg and 1 kg m².",
            )
        return RobotDescription(
            model.name() or name,
            3,
            tuple(self.links.values()),
            tuple(self.joints),
            gravity,
            mounts=tuple(self.mounts),
            loops=tuple(self.loops),
            source=self.file,
            notices=(*self.notices, *self.summary()),
            file=self.file,
            real=True,
        )

    def model(self, root: XmlElement) -> tuple[XmlElement, tuple]:
        """The file's only model that is not static scenery, and the gravity vector (m/s²)."""
        worlds, models = root.all("world"), root.all("model")
        gravity, versions = [0.0, 0.0, -9.81], dict[int, tuple[int, int]]()
        for world in worlds:
            models += world.all("model")
            for element in world.all("include"):
                found = self.nested.included_in_world(element)
                if found is not None:
                    models.append(found[0])
                    versions[id(found[0])] = found[1]
            for element in world.all("gravity"):
                gravity = self.numbers(element, 3, "gravity")
        moving = [m for m in models if not self.truth(m, "static")] or models
        if len(moving) != 1:
            names = listed([repr(m.name()) for m in moving], 6) or "none"
            lost = listed([x.text for x in self.notices if x.kind == "ignored"], 3)
            told = f" ({lost.rstrip('.')})" if lost else ""
            self.refuse(root, f"a robot is one <model>, and here are {names}{told}; leave one.")
        self.version = versions.get(id(moving[0]), self.version)
        _, along = gravity_of(gravity, 3)
        return moving[0], gravity_of(math.hypot(*gravity), 3, along, name="g")

    # ------------------------------------------------------------ frames
    def declare(self, element: XmlElement) -> None:
        where = f"{element.tag} {element.name()!r}"
        name = self.text(element, "name", element.tag)
        if name in self.written or name in (MODEL, self.world):
            self.refuse(element, f"{where}: there are two of that name; rename one.")
        around = MODEL
        if element.tag == "joint":
            around = self.named(element, "child", where).content
        elif element.tag == "frame":
            around = element.attributes.get("attached_to", "").strip() or MODEL
        self.written[name] = element, around

    def pose_of(self, name: str, asked_by: XmlElement, above: tuple[str, ...] = ()) -> ArrayPose:
        """A frame's pose in the model's frame."""
        if name not in self.poses:
            if name not in self.written:
                known = [MODEL, *self.written]
                self.refuse(asked_by, str(UnknownNameError("frame", name, "the model", known)))
            if name in above or len(above) > 200:
                chain = listed([*above, name], 6)
                self.refuse(asked_by, f"frames are placed in circles: {chain}.")
            element, around = self.written[name]
            self.poses[name] = self.placed(element, around, (*above, name))
        return self.poses[name]

    def placed(self, element: XmlElement, around: str, above: tuple[str, ...] = ()) -> ArrayPose:
        """The pose that an element's <pose> gives, in the model's frame."""
        where = f"{element.tag} {element.name()!r}"
        pose = self.one(element, "pose", where)
        if pose is None:
            return self.pose_of(around, element, above)
        self.only(pose, "relative_to", "frame", "degrees", "rotation_format")
        base = pose.attributes.get("relative_to", "").strip() or around
        outer, local = self.pose_of(base, pose, above), self.local(pose, where)
        held = element.attributes.get("placement_frame", "").strip()
        if element.tag == "frame" and held:
            within = self.within(element.name(), held, pose)
            local = composed(local, seen_from(within, self.poses[MODEL]))
        self.inside[base, element.name()] = local
        return composed(outer, local)

    def within(self, outer: str, name: str, asked_by: XmlElement, depth: int = 0) -> ArrayPose:
        """A frame's pose in another one that it is placed in, whose own pose may be unknown."""
        if name == outer:
            return self.poses[MODEL]
        if name not in self.written or depth > 200:
            known = [MODEL, *self.written]
            self.refuse(asked_by, str(UnknownNameError("frame", name, f"{outer!r}", known)))
        element, around = self.written[name]
        pose = self.one(element, "pose", f"{element.tag} {name!r}")
        base = pose.attributes.get("relative_to", "").strip() if pose is not None else ""
        local = self.local(pose, name) if pose is not None else self.poses[MODEL]
        return composed(self.within(outer, base or around, asked_by, depth + 1), local)

    def local(self, pose: XmlElement, where: str) -> ArrayPose:
        """The numbers of a <pose>: position, then roll, pitch, yaw or a quaternion x, y, z, w."""
        form = pose.attributes.get("rotation_format", "euler_rpy")
        if form == "quat_xyzw":
            *p, x, y, z, w = self.numbers(pose, 7, where)
            if not any((x, y, z, w)):
                self.refuse(pose, f"{where}: the quaternion is zero.")
            return np.array(space.quaternion((w, x, y, z)), dtype=float), np.array(p)
        if form != "euler_rpy":
            self.refuse(pose, f"{where}: rotation_format is {form!r}, not euler_rpy or quat_xyzw.")
        values = self.numbers(pose, 6, where) if pose.content else [0.0] * 6
        angles = values[3:]
        if pose.attributes.get("degrees", "").strip() in ("true", "1"):
            angles = [math.radians(angle) for angle in angles]
        R, _ = rpy(*angles, snap=self.snap).lower(space, VALUES)
        return np.array(R, dtype=float), np.array(values[:3])

    def relative(self, outer: str, name: str, asked_by: XmlElement) -> ArrayPose:
        """A frame's pose in another one: as written, where it is given there."""
        poses = self.pose_of(outer, asked_by), self.pose_of(name, asked_by)
        if poses[0] is poses[1]:
            return np.eye(3), np.zeros(3)
        return self.inside.get((outer, name)) or seen_from(*poses)

    def placed_in(self, link: XmlElement, element: XmlElement) -> Placement:
        """Where the <pose> of a part of a link puts it in the link's frame."""
        where = f"<{element.tag}> of link {link.name()!r}"
        pose = self.one(element, "pose", where)
        if pose is None:
            return Placement()
        base = pose.attributes.get("relative_to", "").strip() or link.name()
        return _placement(composed(self.relative(link.name(), base, pose), self.local(pose, where)))

    def frame(self, element: XmlElement) -> None:
        """A frame fixed to a link, directly or through others."""
        name, body, seen = element.name(), element.name(), set[str]()
        while body not in self.links:
            if body in seen or body == MODEL:
                body = self.root
                break
            seen.add(body)
            holder, around = self.written.get(body, (element, MODEL))
            body = self.end(holder, "child", "") if holder.tag == "joint" else around
        inside = self.relative(body, name, element)
        self.mounts.append(Mount(name, body, _placement(inside)))

    # ------------------------------------------------------------ links
    def link(self, element: XmlElement) -> None:
        self.only(element, "name")
        self.sort_out(element, "inertial", "pose")
        where = f"link {element.name()!r}"
        self.pose_of(element.name(), element)
        inertial = self.one(element, "inertial", where)
        inertia, placement = self.inertial(inertial, where)
        line = (inertial or element).line
        shapes = tuple(shapes_of(self, element))
        self.links[element.name()] = Link(element.name(), inertia, placement, line, shapes)

    def inertial(self, element: XmlElement | None, where: str) -> tuple[Inertia | None, Placement]:
        mass, tensor, pose = 1.0, {"ixx": 1.0, "iyy": 1.0, "izz": 1.0}, None
        if element is not None:
            self.sort_out(element, "mass", "inertia", "pose")
            given = self.one(element, "mass", where)
            mass = self.number_in(given, where) if given is not None else 1.0
            pose = self.one(element, "pose", where)
            entries = self.one(element, "inertia", where)
            for key in _TENSOR:
                found = self.one(entries, key, where) if entries is not None else None
                if found is not None:
                    tensor[key] = self.number_in(found, where)
        if element is None or not (element.all("mass") and element.all("inertia")):
            self.assumed.append(where)
        Rp = self.local(pose, where) if pose is not None else (np.eye(3), np.zeros(3))
        numbers = tuple(tensor.get(key, 0.0) for key in _TENSOR)
        if not mass and not any(numbers):
            return None, Placement()
        return Inertia(mass, (0.0, 0.0, 0.0), numbers), _placement(Rp)

    # ------------------------------------------------------------ joints
    def tree(self, model: XmlElement, joints: list[XmlElement]) -> None:
        """The tree of joints, and a loop for each joint to a link that has one."""
        placed: set[str] = set()
        held, own = False, tuple(self.links)
        gearboxes = [element for element in joints if _type(element) == GEARBOX]
        joints = [element for element in joints if _type(element) != GEARBOX]
        for element in joints:
            where = f"joint {element.name()!r}"
            parent, child = (self.end(element, tag, where) for tag in ("parent", "child"))
            if child == self.world:
                self.refuse(element, f"{where}: its child is the world; swap parent and child.")
            held |= parent == self.world
            if child in placed:
                self.loop(element, where, parent, child)
            else:
                placed.add(child)
                self.joint(element, where, parent, child)
        roots = [name for name in own if name not in placed]
        if len(roots) == 1 and not held:
            at = _placement(self.relative(self.world, roots[0], model))
            self.root = self.world if at.steps else roots[0]
            if at.steps:
                weld = f"{roots[0]}_in_world"
                self.joints.append(Joint(weld, "fixed", self.world, roots[0], at))
        else:
            self.root = self.world
            for name in roots:
                self.notice(
                    "floating", model, f"link {name!r} is joined to nothing and floats freely."
                )
                self.joints.append(Joint(f"{name}_floats", "free", self.world, name))
        for element in gearboxes:
            couple(self, element, joints)
        if self.root == self.world:
            self.links = {self.world: Link(self.world), **self.links}

    def named(self, element: XmlElement, tag: str, where: str) -> XmlElement:
        """The <parent> or <child> of a joint, with what it names."""
        found = self.one(element, tag, where)
        if found is None or not found.content:
            self.refuse(element, f"{where}: it has no <{tag}>; name a link in it.")
        return found

    def end(self, element: XmlElement, tag: str, where: str) -> str:
        """The name of the link that <parent> or <child> refers to, by its name or by a frame on
        it."""
        found = self.named(element, tag, where)
        name = found.content
        if name in (self.world, *self.links) or name not in self.written:
            known = [self.world, *self.links] if self.links else [self.world, *self.written]
            if name not in known and name not in self.written:
                self.refuse(found, str(UnknownNameError("link", name, "the model", known)))
            return name
        for _ in range(200):
            if name not in self.written:
                known = [MODEL, *self.written]
                self.refuse(found, str(UnknownNameError("frame", name, where, known)))
            holder, around = self.written[name]
            if holder.tag == "link":
                return name
            name = self.end(holder, "child", where) if holder.tag == "joint" else around
            if name in (MODEL, self.world):
                return self.world
        self.refuse(found, f"{where}: frames are attached in circles.")

    def joint(self, element: XmlElement, where: str, parent: str, child: str) -> None:
        """Add a joint of the tree; where its frame is not its child's, a massless link is put
        between."""
        name, kind, axes = element.name(), self.kind(element, where)[0], self.axes(element, where)
        inside = self.relative(name, child, element)
        # a joint that has its child's frame is where the child is said to be
        placed = name if _placement(inside).steps else child
        placement = _placement(self.relative(parent, placed, element))
        steps = [
            (name if k == 0 else f"{name}_{k + 1}", kind, axis, tag)
            for k, (axis, tag) in enumerate(axes)
        ] or [(name, kind, (), None)]
        direct = not _placement(inside).steps
        own = (pitch(self, element, where),) if kind == "helical" else ()
        rotor = {
            number: value
            for number, tag in _ROTOR.items()
            if len(axes) == 1 and (value := self.inside_of(element, tag, where)) is not None
        }
        for k, (called, kind, axis, tag) in enumerate(steps):
            last = k == len(steps) - 1
            to = child if last and direct else f"{called}_frame"
            if to != child:
                self.links[to] = Link(to, line=element.line)
            self.joints.append(
                Joint(
                    called,
                    kind,
                    parent,
                    to,
                    placement,
                    axis,
                    self.limits(tag, where),
                    self.drive(tag, where, rotor if k == 0 else {}),
                    self.mimic(tag, where),
                    element.line,
                    numbers=own,
                )
            )
            parent, placement = to, Placement()
        if not direct:
            at_child = _placement(inside)
            self.joints.append(Joint(f"{name}_to_link", "fixed", parent, child, at_child))

    def loop(self, element: XmlElement, where: str, parent: str, child: str) -> None:
        """Add the loop of a joint to a link that already has one, with frames at the joint's pose
        on both links."""
        kind, axes = self.kind(element, where)[1], self.axes(element, where)
        if kind is None:
            self.refuse(
                element,
                f"{where}: a {_type(element)} joint that closes a loop is not known; "
                f"write another joint of the loop behind it, so that that one closes it.",
            )
        ends = [self.loop_end(element, "a", parent), self.loop_end(element, "b", child)]
        axis, tag = axes[0] if axes else ((), None)
        lost = [
            part for part in ("limit", "dynamics", "mimic") if tag is not None and tag.all(part)
        ]
        if lost:
            told = listed([f"<{part}>" for part in lost])
            self.notice(
                "ignored", element, f"warning: {where} closes a loop, and its {told} is left out."
            )
        self.loops.append(Loop(element.name(), kind, (ends[0], ends[1]), axis, line=element.line))

    def loop_end(self, loop: XmlElement, side: str, link: str) -> str:
        """The name of the loop's frame on a link: the file's own frame of that name where it fits,
        else a new one."""
        joint = loop.name()
        name = f"{joint}_{side}"
        while name in self.written:
            frame = self.written[name][0]
            off = np.subtract(self.pose_of(name, frame)[1], self.pose_of(joint, loop)[1])
            turned = np.subtract(self.pose_of(name, frame)[0], self.pose_of(joint, loop)[0])
            close = max(abs(off).max(), abs(turned).max()) <= _SAME
            if close and frame.attributes.get("attached_to") == link:
                return name
            name += "_"
        self.mounts.append(Mount(name, link, _placement(self.relative(link, joint, loop))))
        return name

    def kind(self, element: XmlElement, where: str) -> tuple[str, str | None]:
        given = self.text(element, "type", where)
        if given not in _TYPES:
            known = (*_TYPES, GEARBOX)
            self.refuse(element, str(UnknownNameError("type", given, where, known)))
        self.only(element, "name", "type")
        rotor = _ROTOR.values() if _AXES.get(given) == 1 else ()
        own = SCREW_TAGS if given == SCREW else ()
        self.sort_out(element, "parent", "child", "pose", *self.axis_tags(given), *own, *rotor)
        return _TYPES[given]

    def axis_tags(self, given: str) -> tuple[str, ...]:
        return ("axis", "axis2")[: _AXES.get(given, 0)]

    def axes(
        self, element: XmlElement, where: str
    ) -> list[tuple[tuple[float, ...], XmlElement | None]]:
        """Each axis in the joint's frame, with its element."""
        found = []
        for tag in self.axis_tags(_type(element)):
            axis = self.one(element, tag, where)
            xyz = self.one(axis, "xyz", where) if axis is not None else None
            direction = np.array(self.numbers(xyz, 3, where) if xyz is not None else (0, 0, 1.0))
            if not direction.any():
                self.refuse(element, f"{where}: the axis is zero; give a direction such as 0 0 1.")
            frame = xyz.attributes.get("expressed_in", "").strip() if xyz is not None else ""
            if not frame and axis is not None and self.in_model(axis):
                frame = MODEL
            if frame:
                mine, theirs = self.pose_of(element.name(), element), self.pose_of(frame, element)
                direction = mine[0].T @ theirs[0] @ direction
            length = math.hypot(*direction)
            x, y, z = (direction / length).tolist()
            found.append(((x, y, z), axis))
        return found

    def in_model(self, axis: XmlElement) -> bool:
        """Whether an axis is given in the model's frame, as in old versions of SDF."""
        return self.version < AXES_IN_JOINTS or self.truth(axis, "use_parent_model_frame")

    def limits(self, axis: XmlElement | None, where: str) -> Limits:
        limit = self.one(axis, "limit", where) if axis is not None else None
        if limit is None:
            return Limits()
        lower, upper = (self.inside_of(limit, tag, where) for tag in ("lower", "upper"))
        effort, velocity = (self.inside_of(limit, tag, where) for tag in ("effort", "velocity"))

        def most(value: float | None) -> float:
            """A limit of speed or effort; infinite where it is absent, negative or beyond what
            counts as a limit."""
            return INFINITE if value is None or value < 0 or value >= UNLIMITED else value

        return Limits(
            -INFINITE if lower is None or lower <= -UNLIMITED else lower,
            INFINITE if upper is None or upper >= UNLIMITED else upper,
            most(velocity),
            most(effort),
        )

    def drive(self, axis: XmlElement | None, where: str, rotor: dict[str, float]) -> Drive:
        """The friction, spring and rotor of a joint, the rotor as Drake's elements give it."""
        dynamics = self.one(axis, "dynamics", where) if axis is not None else None
        if dynamics is None:
            return Drive(**rotor)
        tags = ("damping", "friction", "spring_stiffness", "spring_reference")
        d, f, k, rest = (self.inside_of(dynamics, tag, where) or 0.0 for tag in tags)
        return Drive(viscous=d, coulomb=f, stiffness=k, rest=rest if k else 0.0, **rotor)

    def mimic(self, axis: XmlElement | None, where: str) -> Mimic | None:
        tag = self.one(axis, "mimic", where) if axis is not None else None
        if tag is None:
            return None
        ratio, offset, reference = (
            self.inside_of(tag, key, where) for key in ("multiplier", "offset", "reference")
        )
        ratio = 1.0 if ratio is None else ratio
        leader = self.text(tag, "joint", where)
        return Mimic(leader, ratio, (offset or 0.0) - ratio * (reference or 0.0))

    # ------------------------------------------------------------ values
    def numbers(self, element: XmlElement, count: int, where: str) -> list[float]:
        """The numbers in an element's text."""
        words = element.content.split()
        if len(words) != count:
            self.refuse(
                element, f"{where}: <{element.tag}> has {len(words)} numbers, expected {count}."
            )
        return [self.checked(element, word, where) for word in words]

    def number_in(self, element: XmlElement, where: str) -> float:
        return self.numbers(element, 1, where)[0]

    def inside_of(self, element: XmlElement, tag: str, where: str) -> float | None:
        """The number in the element of that tag, perhaps infinite."""
        found = self.one(element, tag, where)
        if found is None:
            return None
        return self.checked(found, found.content.strip(), where, infinite=True)

    def checked(self, element: XmlElement, word: str, where: str, infinite: bool = False) -> float:
        value = read_file.number(word)
        problem = None if value is None else read_file.fault(value, infinite)
        if value is None or problem:
            self.refuse(element, f"{where}: {shown(word)} in <{element.tag}> is no usable number.")
        return value

    def truth(self, element: XmlElement, tag: str) -> bool:
        return any(found.content in ("1", "true") for found in element.all(tag))


def _type(joint: XmlElement) -> str:
    return joint.attributes.get("type", "").strip()


def _placement(pose: ArrayPose) -> Placement:
    R, p = pose
    near = np.allclose(R, np.eye(3), rtol=0, atol=1e-15)
    turned = Placement() if near else rotate(R, "pose")
    return (shift(*p.tolist()) if p.any() else Placement()).then(turned)
