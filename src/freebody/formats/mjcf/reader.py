"""A model of MuJoCo as links, joints, loops and frames.

Each MJCF body becomes a link; its joints, of which it may have several at points of their own, a
chain of joints with links without mass between them. q of a joint is MuJoCo's qpos. What has no
counterpart here is named in the model's notices; constraints that cannot be kept are refused.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NoReturn

import numpy as np

from freebody.errors import FileError, listed
from freebody.formats.mjcf.compilation import BOUNDS, PARTS, compilation
from freebody.formats.mjcf.couplings import followers, is_coupling
from freebody.formats.mjcf.equalities import HeldBodies, joined, moved, turned
from freebody.formats.mjcf.geoms import shapes_of
from freebody.lazy import cached_property
from freebody.model.description import (
    INFINITE,
    Drive,
    Joint,
    Limits,
    Link,
    Loop,
    Mount,
    Notice,
    RobotDescription,
)
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia
from freebody.model.mimics import Mimic
from freebody.model.placement import Placement
from freebody.model.struts import Strut
from freebody.outputs.number_text import compared

_KINDS = {"free": "free", "ball": "spherical", "slide": "prismatic", "hinge": "revolute"}
_LAWS = {
    "damping": ("damping", "more_damping"),
    "stiffness": ("stiffness", "more_stiffness"),
    "friction loss": ("friction",),
    "armature": ("armature",),
}
"""Laws that act along joints, and their numbers in a compiled model."""
_TENDON = (
    "warning: what tendons do, but for those straight between sites of two bodies with stiffness, "
    "damping and one springlength alone, is"
)


def describe(file: str, on_disk: bool, data: bytes, name: str) -> RobotDescription:
    """The description in an MJCF file, or in its text where it is not on disk. Raises FileError
    for what MuJoCo refuses and for constraints that freebody does not know."""
    return _MjcfReader(file, compilation(file, on_disk, data)).description(name)


@dataclass
class _MjcfReader:
    """A reader of one compiled model, with the parts of the description found so far."""

    file: str
    given: dict[str, Any]
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    mounts: list[Mount] = field(default_factory=list)
    loops: list[Loop] = field(default_factory=list)
    held: list[HeldBodies] = field(default_factory=list)
    replaced: set[str] = field(default_factory=set)
    """Names of sites in whose place frames of loops are."""
    struts: list[Strut] = field(default_factory=list)
    notices: list[Notice] = field(default_factory=list)
    sites: dict[int, str] = field(default_factory=dict)
    """The frame of each site that has one."""
    left_out: list[tuple[str, str]] = field(default_factory=list)
    """Pairs of words for something that is not read, and the name of the part that has it."""

    def description(self, name: str) -> RobotDescription:
        for equality in self.given["equalities"]:
            self.equality(equality)
        self.join_connects()
        for index in range(len(self.body_names)):
            self.body(index)
        if len(self.links) < 2:
            self.refuse(
                "it has no bodies; a robot needs at least one. A scene or a part that others "
                "include is loaded by one of those."
            )
        site_names = self.names(self.given["sites"], "site")
        pulled = {k for tendon in self.given["tendons"] for k in tendon["ends"]}
        for k, (site, called) in enumerate(zip(self.given["sites"], site_names, strict=True)):
            if k in pulled or (site["name"] and site["name"] not in self.replaced):
                at = self.in_link(site["body"], site["pos"], site["quat"])
                self.sites[k] = self.mount(called, site["body"], at)
        for held in self.held:
            self.loop(held)
        for index, tendon in enumerate(self.given["tendons"]):
            self.tendon(index, tendon)
        self.name_swapped()
        self.name_left_out()
        g = np.array(self.given["gravity"])
        size = float(np.linalg.norm(g))
        along = tuple((g / size).tolist()) if size else (0.0, 0.0, -1.0)
        return RobotDescription(
            self.given["name"] or name,
            3,
            tuple(self.links),
            tuple(self.joints),
            gravity_of(size, 3, along, name="g"),
            mounts=tuple(self.mounts),
            loops=tuple(self.loops),
            home=self.home(),
            source=self.file,
            notices=tuple(self.notices),
            file=self.file,
            real=True,
            struts=tuple(self.struts),
        )

    def home(self) -> tuple[tuple[str, float], ...]:
        """Joint positions (rad, m) in which the file draws the robot and closes its loops, by
        joint, where they are not 0."""
        single = zip(self.joint_names, self.given["joints"], strict=True)
        return tuple(
            (name, joint["zero"])
            for index, (name, joint) in enumerate(single)
            if joint["zero"] and joint["type"] in ("slide", "hinge") and index not in self.mimics
        )

    @cached_property
    def at(self) -> list[np.ndarray]:
        """Where the frame of each body's link is, in the body's own frame: at its last joint."""
        found = [np.zeros(3)] * len(self.body_names)
        for joint in self.given["joints"]:
            if joint["type"] != "free":
                found[joint["body"]] = np.array(joint["pos"])
        return found

    @cached_property
    def body_names(self) -> list[str]:
        """The name of each body's link."""
        return self.names(self.given["bodies"], "body")

    @cached_property
    def joint_names(self) -> list[str]:
        """The name of each joint."""
        return self.names(self.given["joints"], "joint")

    def names(self, parts: list[dict[str, Any]], what: str) -> list[str]:
        """The names of parts, made up and unique where the file gives none."""
        taken = {part["name"] for part in parts}
        found = []
        for i, part in enumerate(parts):
            called = part["name"]
            while not called or (called in taken and called != part["name"]):
                called = f"{called or what}{'' if called else i}{'_' if called else ''}"
            taken.add(called)
            found.append(called)
        return found

    # ------------------------------------------------------------ bodies and joints
    def body(self, index: int) -> None:
        given, name = self.given["bodies"][index], self.body_names[index]
        joints = [i for i, joint in enumerate(self.given["joints"]) if joint["body"] == index]
        where = self.in_link(given["parent"], given["pos"], given["quat"]) if index else Placement()
        parent, offset = self.body_names[given["parent"]], np.zeros(3)
        if index and not joints:
            self.joints.append(Joint(f"{name}_weld", "fixed", parent, name, where))
        for k, i in enumerate(joints):
            joint = self.given["joints"][i]
            last = k == len(joints) - 1
            child = name if last else f"{name}_{self.joint_names[i]}"
            at = np.array(joint["pos"])
            if joint["type"] == "free":
                where = Placement()  # its q is the body's pose in the world
                at = offset
            self.joints.append(self.joint(i, parent, child, where.then(moved(at - offset))))
            if not last:
                self.links.append(Link(child))
            parent, where, offset = child, Placement(), at
        # what is fixed to the world itself is scenery
        shapes = tuple(shapes_of(self.geoms[index], partial(self.in_link, index))) if index else ()
        inertia, centre = self.inertia(given, offset)
        self.links.append(Link(name, inertia, centre, shapes=shapes, filled=given["filled"]))

    @cached_property
    def geoms(self) -> dict[int, list[dict[str, Any]]]:
        """The geoms of each body that has some."""
        found: dict[int, list[dict[str, Any]]] = defaultdict(list)
        for geom in self.given["geoms"]:
            found[geom["body"]].append(geom)
        return found

    def inertia(
        self, given: dict[str, Any], offset: np.ndarray
    ) -> tuple[Inertia | None, Placement]:
        if not given["mass"] and not any(given["inertia"]):
            return None, Placement()
        xx, yy, zz = given["inertia"]
        centre = moved(np.array(given["com"]) - offset).then(turned(given["axes"]))
        return Inertia(given["mass"], (0.0, 0.0, 0.0), (xx, 0.0, 0.0, yy, 0.0, zz)), centre

    def joint(self, index: int, parent: str, child: str, where: Placement) -> Joint:
        given, name = self.given["joints"][index], self.joint_names[index]
        kind = _KINDS[given["type"]]
        if given["type"] in ("free", "ball"):
            self.left_out += [
                (f"warning: {what} of free and ball joints is", name)
                for what, keys in _LAWS.items()
                if any(np.any(given[key]) for key in keys)
            ]
            passive = self.passive(index) and (kind != "free" or self.is_held(given["body"]))
            return Joint(name, kind, parent, child, where, passive=passive)
        axis, zero = np.array(given["axis"]), given["zero"]
        (square, hardening), (quadratic, cube) = given["more_stiffness"], given["more_damping"]
        # the first is no law here, since it pushes the same way on both sides of its rest
        for what, number in (
            ("the second power of its spring", square),
            ("the third power of its damper", cube),
            ("the second power of its damper, below 0,", min(quadratic, 0.0)),
        ):
            if number:
                self.note(f"joint {name!r}: {what} is left out.")
        lower, upper = given["range"] if given["limited"] else (-INFINITE, INFINITE)
        # at qpos = ref the body is where the file draws it
        back = _about(axis, -zero) if kind == "revolute" else moved(-zero * axis)
        return Joint(
            name,
            kind,
            parent,
            child,
            where.then(back),
            tuple(axis.tolist()),
            Limits(lower, upper, effort=self.effort.get(index, INFINITE)),
            Drive(
                viscous=given["damping"],
                coulomb=given["friction"],
                rotor=given["armature"],
                stiffness=given["stiffness"],
                rest=given["rest"] if given["stiffness"] else 0.0,
                quadratic=max(quadratic, 0.0),
                hardening=hardening,
                hardening_rest=given["rest"] if hardening else 0.0,
            ),
            self.mimics.get(index),
            passive=self.passive(index),
        )

    def passive(self, index: int) -> bool:
        """Whether a joint of a closed chain lacks the actuator that others have."""
        direct = (a for a in self.given["actuators"] if a["transmission"] == "joint")
        driven = {actuator["joint"] for actuator in direct}
        return bool(self.held and self.effort and index not in driven)

    def is_held(self, body: int) -> bool:
        """Whether a loop holds what a free body carries to anything else, as a platform is held:
        else it is the robot's base."""
        carried = {body}
        for index, other in enumerate(self.given["bodies"]):
            if other["parent"] in carried and index:
                carried.add(index)
        return any(len(carried.intersection(held.bodies)) == 1 for held in self.held)

    @cached_property
    def effort(self) -> dict[int, float]:
        """The largest effort of each joint with an actuator, through its gear."""
        found: dict[int, float] = {}
        for actuator in self.given["actuators"]:
            if actuator["transmission"] != "joint":
                continue
            most = INFINITE
            if actuator["force_limited"]:
                most = max(map(abs, actuator["force"]))
            elif actuator["input_limited"] and actuator["direct"]:
                most = abs(actuator["gain"]) * max(map(abs, actuator["input"]))
            joint, gear = actuator["joint"], abs(actuator["gear"])
            # without a gear not even an unlimited force reaches the joint
            found[joint] = found.get(joint, 0.0) + (gear * most if gear else 0.0)
        for index, joint in enumerate(self.given["joints"]):
            if joint["effort_limited"]:
                most = max(map(abs, joint["effort"]))
                found[index] = min(found.get(index, INFINITE), most)
        return found

    # ------------------------------------------------------------ constraints
    @cached_property
    def mimics(self) -> dict[int, Mimic]:
        """The joints that equalities make follow others."""
        return followers(self.given, self.joint_names, self.refuse)

    def equality(self, given: dict[str, Any]) -> None:
        """Add the loop that a connect or weld constraint closes."""
        kind, called = given["type"], given["name"] or f"loop{len(self.held) + 1}"
        if not given["active"]:
            self.note(f"the equality {called!r} is not active, and is left out.")
            return
        if is_coupling(given, self.given):
            return
        if kind not in ("connect", "weld"):
            self.note(f"warning: the equality {called!r} of {kind}s is left out.")
            return
        ends = (given["first"], given["second"])
        if given["of_sites"]:
            sites = [self.given["sites"][i] for i in ends]
            bodies = [site["body"] for site in sites]
            poses = [(site["pos"], site["quat"]) for site in sites]
        else:
            bodies, data = list(ends), given["data"]
            if kind == "connect":
                poses = [(data[:3], (1, 0, 0, 0)), (data[3:6], (1, 0, 0, 0))]
            else:
                poses = [(data[3:6], data[6:10]), (data[:3], (1, 0, 0, 0))]
        if len({*map(self.rigid, bodies)}) < 2:
            self.note(f"the equality {called!r} joins parts of one body, and is left out.")
            return
        places = [self.in_link(b, *pose) for b, pose in zip(bodies, poses, strict=True)]
        points = [np.array(at) - self.at[b] for b, (at, _) in zip(bodies, poses, strict=True)]
        closing = "spherical" if kind == "connect" else "fixed"
        self.held.append(HeldBodies(called, closing, bodies, points, places))

    def join_connects(self) -> None:
        self.held, pairs = joined(self.held)
        for first, second in pairs:
            self.replaced |= {f"{name}_{end}" for name in (first, second) for end in "ab"}
            self.note(f"the connects {first!r} and {second!r} hold an axis: one revolute loop.")

    def loop(self, held: HeldBodies) -> None:
        ends = zip("ab", held.bodies, held.places, strict=True)
        frames = [self.mount(f"{held.name}_{end}", body, place) for end, body, place in ends]
        self.loops.append(Loop(held.name, held.kind, (frames[0], frames[1]), held.axis))

    def tendon(self, index: int, given: dict[str, Any]) -> None:
        """Add the strut that a tendon between sites of two bodies stands for."""
        name = given["name"] or f"tendon{index + 1}"
        if given["limited"]:
            self.left_out.append(("limits of the length of tendons are", name))
        if not (given["stiffness"] or given["damping"] or given["more"]):
            return
        (lower, upper), ends = given["rest"], given["ends"]
        bodies = {self.rigid(self.given["sites"][k]["body"]) for k in ends}
        if len(bodies) == 1 and not given["more"]:
            self.note(f"the tendon {name!r} is between parts of one body, and is left out.")
            return
        if given["is_point"] and not given["more"]:
            self.note(
                f"warning: the tendon {name!r} is between two sites that are always at one point, "
                f"and is left out."
            )
            return
        if not bodies or given["more"] or lower != upper:
            self.left_out.append((_TENDON, name))
            return
        parts = (*self.joints, *self.loops, *self.struts)
        while name in {part.name for part in parts}:
            name += "_tendon"
        frames = (self.sites[ends[0]], self.sites[ends[1]])
        self.struts.append(Strut(name, frames, given["stiffness"], lower, given["damping"]))

    def rigid(self, body: int) -> int:
        """The outermost body that a body is welded to: itself where it has joints."""
        moved = {joint["body"] for joint in self.given["joints"]}
        while body and body not in moved:
            body = self.given["bodies"][body]["parent"]
        return body

    # ------------------------------------------------------------ frames and notices
    def in_link(self, body: int, position: Any, quaternion: Any) -> Placement:
        """A pose given in a body's frame, expressed in the frame of its link."""
        return moved(np.array(position) - self.at[body]).then(turned(quaternion))

    def mount(self, name: str, body: int, placement: Placement) -> str:
        """Fix a frame to a body's link, if it is not there; the name that it has."""
        new = Mount(name, self.body_names[body], placement)
        if new in self.mounts:
            return name
        taken = {*self.body_names, *(mount.name for mount in self.mounts)}
        while name in taken:
            name += "_site"
        self.mounts.append(replace(new, name=name))
        return name

    def name_swapped(self) -> None:
        """Ranges whose ends are swapped, which MuJoCo takes for no bounds without a word."""
        for kind in ("joints", "actuators"):
            for k, part in enumerate(self.given[kind]):
                for key, attribute in BOUNDS.items():
                    lower, upper = part.get(key, (0.0, 0.0))
                    if lower > upper:
                        called = f"{PARTS[kind]} {part['name'] or k + 1!r}"
                        low, high = compared(lower, upper)
                        self.note(
                            f"warning: {called}: the lower end of its {attribute}, {low}, is "
                            f"above the upper one, {high}, so that MuJoCo takes it to have none."
                        )

    def name_left_out(self) -> None:
        for what in dict.fromkeys(what for what, _ in self.left_out):
            names = [name for of, name in self.left_out if of == what]
            self.note(f"{what} left out: {listed(names, 5)}.")
        for what, count in self.given["left_out"].items():
            if count:
                self.note(f"warning: {what} acts on the bodies in MuJoCo, and is left out.")
        compensated = [
            name
            for name, body in zip(self.body_names, self.given["bodies"], strict=True)
            if body["compensated"]
        ]
        if compensated:
            self.note(
                f"warning: gravity compensation of {listed(compensated, 5)} is left out: here "
                f"gravity pulls at them in full."
            )
        others = [a["name"] for a in self.given["actuators"] if a["transmission"] != "joint"]
        if others:
            self.note(f"{len(others)} actuators that are not at joints are left out.")
        moved = sum(body["mocap"] >= 0 for body in self.given["bodies"])
        if moved:
            self.note(f"{moved} bodies that motion capture would move stay where they are.")
        self.note("contacts, servo laws of actuators and sensors are not read.")

    def note(self, text: str) -> None:
        self.notices.append(Notice("ignored", text, self.file))

    def refuse(self, problem: str) -> NoReturn:
        raise FileError(self.file, None, problem)


def _about(axis: np.ndarray, angle: float) -> Placement:
    half = 0.5 * angle
    return turned((np.cos(half), *(np.sin(half) * axis)))
