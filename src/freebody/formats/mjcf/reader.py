"""A model of MuJoCo as links, joints, loops and frames.

Each MJCF body becomes a link; its joints, of which it may have several at points of their own, a
chain of joints with links without mass between them. q of a joint is MuJoCo's qpos. What has no
counterpart here is named in the model's notices; constraints that cannot be kept are refused.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NoReturn

import numpy as np

from freebody.errors import FileError, MissingPackageError, listed
from freebody.formats.mjcf import compiled
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
from freebody.model.placement import Placement, rotate, shift
from freebody.model.struts import Strut
from freebody.spatial import space

_SECONDS = 300  # that MuJoCo may take, of which distances of large meshes take most
_KINDS = {"free": "free", "ball": "spherical", "slide": "prismatic", "hinge": "revolute"}
_WORLD = "world"


def describe(file: str, on_disk: bool, data: bytes, name: str) -> RobotDescription:
    """The description in an MJCF file, or in its text where it is not on disk. Raises FileError
    for what MuJoCo refuses and for constraints that freebody does not know."""
    return _MjcfReader(file, _compiled(file, on_disk, data)).description(name)


def _compiled(file: str, on_disk: bool, data: bytes) -> dict[str, Any]:
    """The numbers of a file as MuJoCo compiles it, in a process of its own that may fail."""
    from importlib.util import find_spec

    if find_spec("mujoco") is None:
        raise MissingPackageError("load: MJCF", "mujoco", "mjcf")
    command = [
        sys.executable,
        compiled.__file__,
        *([str(Path(file).absolute())] if on_disk else []),
    ]
    try:
        with TemporaryDirectory() as folder:  # MuJoCo writes a log where it runs
            done = subprocess.run(
                command,
                input=b"" if on_disk else data,
                capture_output=True,
                timeout=_SECONDS,
                check=False,
                cwd=folder,
            )
    except subprocess.TimeoutExpired:
        raise FileError(file, None, f"MuJoCo took more than {_SECONDS} s to compile it.") from None
    try:
        found = json.loads(done.stdout)
    except ValueError:
        reason = done.stderr.decode(errors="replace").strip().rsplit("\n", 1)[-1]
        raise FileError(
            file, None, f"MuJoCo ended while it compiled it: {reason or done.returncode}."
        ) from None
    if "problem" in found:
        told = " ".join(found["problem"].split()).rstrip(".")
        raise FileError(file, None, f"MuJoCo does not compile it: {told}.")
    return found


@dataclass
class _MjcfReader:
    """A reader of one compiled model, with the parts of the description found so far."""

    file: str
    given: dict[str, Any]
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    mounts: list[Mount] = field(default_factory=list)
    loops: list[Loop] = field(default_factory=list)
    struts: list[Strut] = field(default_factory=list)
    notices: list[Notice] = field(default_factory=list)

    def description(self, name: str) -> RobotDescription:
        self.body_names = self.names(self.given["bodies"], "body")
        self.joint_names = self.names(self.given["joints"], "joint")
        self.effort = self.efforts()
        self.mimics = self.followers()
        self.at: list[np.ndarray] = [np.zeros(3)] * len(self.body_names)
        """Where the frame of each body's link is, in the body's own frame."""
        for index in range(len(self.body_names)):
            self.body(index)
        if len(self.links) < 2:
            self.refuse("it has no bodies; a robot needs at least one.")
        site_names = self.names(self.given["sites"], "site")
        pulled = {k for tendon in self.given["tendons"] for k in tendon["ends"]}
        self.sites: dict[int, str] = {}
        """The frame of each site that has one."""
        for k, (site, called) in enumerate(zip(self.given["sites"], site_names, strict=True)):
            if site["name"] or k in pulled:
                at = self.in_link(site["body"], site["pos"], site["quat"])
                self.sites[k] = self.mount(called, site["body"], at)
        for equality in self.given["equalities"]:
            self.equality(equality)
        for tendon in self.given["tendons"]:
            self.tendon(tendon)
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
            self.joints.append(self.joint(i, parent, child, where.then(_moved(at - offset))))
            if not last:
                self.links.append(Link(child))
            parent, where, offset = child, Placement(), at
        self.at[index] = offset
        self.links.append(Link(name, *self.inertia(given, offset)))

    def inertia(
        self, given: dict[str, Any], offset: np.ndarray
    ) -> tuple[Inertia | None, Placement]:
        if not given["mass"] and not any(given["inertia"]):
            return None, Placement()
        xx, yy, zz = given["inertia"]
        centre = _moved(np.array(given["com"]) - offset).then(_turned(given["axes"]))
        return Inertia(given["mass"], (0.0, 0.0, 0.0), (xx, 0.0, 0.0, yy, 0.0, zz)), centre

    def joint(self, index: int, parent: str, child: str, where: Placement) -> Joint:
        given, name = self.given["joints"][index], self.joint_names[index]
        kind = _KINDS[given["type"]]
        if given["type"] in ("free", "ball"):
            names = ("damping", "stiffness", "friction", "armature")
            if any(map(given.get, names)) or any(
                [*given["more_damping"], *given["more_stiffness"]]
            ):
                self.note(
                    f"joint {name!r}: damping, springs, friction loss and armature of a "
                    f"{given['type']} joint are left out."
                )
            return Joint(name, kind, parent, child, where)
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
        back = _about(axis, -zero) if kind == "revolute" else _moved(-zero * axis)
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
            passive=bool(self.closed and self.effort and index not in self.driven),
        )

    @property
    def closed(self) -> bool:
        """Whether the file's equalities close loops."""
        kinds = ("connect", "weld")
        return any(x["type"] in kinds and x["active"] for x in self.given["equalities"])

    @property
    def driven(self) -> set[int]:
        direct = (a for a in self.given["actuators"] if a["transmission"] == "joint")
        return {actuator["joint"] for actuator in direct}

    def efforts(self) -> dict[int, float]:
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
            joint = actuator["joint"]
            found[joint] = found.get(joint, 0.0) + abs(actuator["gear"]) * most
        for index, joint in enumerate(self.given["joints"]):
            if joint["effort_limited"]:
                most = max(map(abs, joint["effort"]))
                found[index] = min(found.get(index, INFINITE), most)
        return found

    # ------------------------------------------------------------ constraints
    def followers(self) -> dict[int, Mimic]:
        """The joints that equality constraints make follow another joint, by index."""
        found = {}
        for equality in self.given["equalities"]:
            if equality["type"] != "joint" or not equality["active"]:
                continue
            first, second = equality["first"], equality["second"]
            constant, slope, *higher = equality["data"][:5]
            if second < 0 or any(higher):
                what = "held in its place" if second < 0 else "a polynomial of another"
                self.refuse(
                    f"joint {self.joint_names[first]!r} is {what} by an equality, which freebody "
                    f"does not know; make it linear, or remove it."
                )
            zero, other = (self.given["joints"][i]["zero"] for i in (first, second))
            found[first] = Mimic(self.joint_names[second], slope, zero + constant - slope * other)
        return found

    def equality(self, given: dict[str, Any]) -> None:
        """Add the loop that a connect or weld constraint closes."""
        kind, index = given["type"], len(self.loops) + 1
        called = given["name"] or f"loop{index}"
        if kind == "joint":
            return
        if not given["active"]:
            self.note(f"the equality {called!r} is not active, and is left out.")
            return
        if kind not in ("connect", "weld"):
            self.note(f"the equality {called!r} of {kind}s is left out.")
            return
        ends = (given["first"], given["second"])
        if given["of_sites"]:
            sites = [self.given["sites"][i] for i in ends]
            bodies = [site["body"] for site in sites]
            places = [self.in_link(s["body"], s["pos"], s["quat"]) for s in sites]
        else:
            bodies, data = list(ends), given["data"]
            if kind == "connect":
                poses = [(data[:3], (1, 0, 0, 0)), (data[3:6], (1, 0, 0, 0))]
            else:
                poses = [(data[3:6], data[6:10]), (data[:3], (1, 0, 0, 0))]
            places = [self.in_link(b, *pose) for b, pose in zip(bodies, poses, strict=True)]
        frames = tuple(f"{called}_{end}" for end in "ab")
        for frame, body, place in zip(frames, bodies, places, strict=True):
            self.mount(frame, body, place)
        closing = "spherical" if kind == "connect" else "fixed"
        self.loops.append(Loop(called, closing, (frames[0], frames[1])))

    def tendon(self, given: dict[str, Any]) -> None:
        """Add the strut that a tendon between sites of two bodies stands for."""
        if not (given["stiffness"] or given["damping"] or given["more"]):
            return
        name = given["name"] or f"tendon{len(self.struts) + 1}"
        (lower, upper), ends = given["rest"], given["ends"]
        bodies = {self.given["sites"][k]["body"] for k in ends}
        if len(bodies) < 2 or given["more"] or lower != upper:
            self.note(
                f"warning: what the tendon {name!r} does is left out: read is one between sites of "
                f"two bodies, its stiffness, damping and springlength, one number, alone."
            )
            return
        parts = (*self.joints, *self.loops, *self.struts)
        while name in {part.name for part in parts}:
            name += "_tendon"
        frames = (self.sites[ends[0]], self.sites[ends[1]])
        self.struts.append(Strut(name, frames, given["stiffness"], lower, given["damping"]))

    # ------------------------------------------------------------ frames and notices
    def in_link(self, body: int, position: Any, quaternion: Any) -> Placement:
        """A pose given in a body's frame, expressed in the frame of its link."""
        return _moved(np.array(position) - self.at[body]).then(_turned(quaternion))

    def mount(self, name: str, body: int, placement: Placement) -> str:
        """Fix a frame to a body's link; returns the name that it gets."""
        taken = {*self.body_names, *(mount.name for mount in self.mounts)}
        while name in taken:
            name += "_site"
        self.mounts.append(Mount(name, self.body_names[body], placement))
        return name

    def name_left_out(self) -> None:
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


def _moved(by: np.ndarray) -> Placement:
    return shift(*by.tolist()) if by.any() else Placement()


def _turned(quaternion: Any) -> Placement:
    w, x, y, z = (float(c) for c in quaternion)
    if not (x or y or z):
        return Placement()
    return rotate(space.quaternion((w, x, y, z)), "quaternion")


def _about(axis: np.ndarray, angle: float) -> Placement:
    half = 0.5 * angle
    return _turned((np.cos(half), *(np.sin(half) * axis)))
