"""MJCF of a model: bodies nested with their joints, frames as sites, loops and mimics as equalities
between sites and joints, struts as tendons between sites."""

from __future__ import annotations

import numpy as np

from freebody.errors import FreebodyError, listed
from freebody.formats.writing.format_contents import (
    GROUND,
    Contents,
    Holds,
    WrittenJoint,
    WrittenLink,
    WrittenStrut,
    checked_ground,
    checked_names,
    contents_of,
    lost_names,
)
from freebody.formats.writing.xml import Element, SubElement, numbers, text_of
from freebody.model.description import INFINITE
from freebody.model.inertia import Inertia, decimal_sum
from freebody.model.joints import KINDS
from freebody.model.model import Model
from freebody.model.tree import Pose

HOLDS = Holds(
    "MJCF",
    kinds={
        "revolute": "hinge",
        "continuous": "hinge",
        "prismatic": "slide",
        "spherical": "ball",
        "free": "free",
    },
    drive=frozenset(
        (
            *("viscous", "coulomb", "rotor", "gear", "stiffness", "rest"),
            *("quadratic", "hardening", "hardening_rest"),
        )
    ),
    loops=frozenset(("spherical", "fixed", "revolute")),
    struts=True,
    gravity=True,
    velocity=False,
    passive=True,
    degree=4,
    no_zero=frozenset(("effort",)),
)
_LEAST = 2e-15
"""kg and kg m²: what MuJoCo moves is heavier than 1e-15."""
_ALONG = 0.1
"""m from the frame of a revolute loop, along its axis, to each point that is held."""
_ROUNDED = 1e-12
"""Share of a moment by which rounding may break the triangle inequality."""


def written(model: Model) -> tuple[str, list[str]]:
    """The MJCF text of a model, and sentences on what it loses of the model."""
    contents = contents_of(model, HOLDS)
    checked_names(contents, "MJCF")
    checked_ground(contents, "MJCF")
    return _Writer(contents, flat=model.dim == 2).written()


class _Writer:
    """The writer of one MJCF file, with the elements of links by name and the losses found so
    far."""

    def __init__(self, contents: Contents, flat: bool):
        self.contents, self.flat = contents, flat
        self.losses = list(contents.losses)
        self.light: list[str] = []
        self.geared: list[str] = []
        self.root = Element("mujoco", {"model": contents.name})
        SubElement(self.root, "compiler", {"angle": "radian", "autolimits": "true"})
        SubElement(self.root, "option", {"gravity": numbers(contents.gravity)})
        self.world = SubElement(self.root, "worldbody")
        self.bodies: dict[str, Element] = {}
        self.sites = {link.name for link in contents.links}
        """Names that no further site may have."""

    def written(self) -> tuple[str, list[str]]:
        contents = self.contents
        for link in contents.links:
            self.link(link)
        found = tuple(
            element.get("name") for element in self.world.iter() if element.tag == "joint"
        )
        if found != contents.joint_names:
            self.losses.append(
                f"the order of its coordinates, which is that of the bodies in one another: "
                f"{', '.join(map(str, found))}"
            )
        self.equalities()
        self.tendons()
        self.losses += lost_names(
            link.fixed for link in contents.links if link.fixed not in ("", f"{link.name}_weld")
        )
        driven = [
            link.joint.name
            for link in contents.links
            if link.joint
            and KINDS[link.joint.kind].nv == 1
            and not (link.joint.passive or link.joint.mimic)
        ]
        if driven:
            actuator = SubElement(self.root, "actuator")
            for name in driven:
                SubElement(actuator, "motor", {"name": f"{name}_motor", "joint": name})
        if self.geared:
            self.losses.append(
                f"the gears of {listed(self.geared, 6)}: rotors are written as they are felt "
                f"behind them"
            )
        if self.light:
            has = "has" if len(self.light) == 1 else "have"
            self.losses.append(
                f"that {listed(self.light, 6)} {has} no mass, or no moment of inertia about some "
                f"axis: {_LEAST:g} kg (kg m²) are written, the least that MuJoCo moves"
            )
        return text_of(self.root), self.losses

    # ------------------------------------------------------------ links
    def link(self, link: WrittenLink) -> None:
        joint = link.joint
        if link.mounted:
            body, R, p = self.end(link.name)
            SubElement(body, "site", {"name": link.name, **_place((R, p))})
            return
        if not link.parent and link.name == GROUND and not self.contents.free:
            if link.inertia is not None:
                self.losses.append(f"the mass of {GROUND!r}, which is the ground")
            self.bodies[link.name] = self.world
            return
        outer = self.bodies[link.parent] if link.parent else self.world
        if not link.parent:
            joint = self.contents.free
        free = joint is not None and joint.kind == "free"
        if free and outer is not self.world:
            self.refuse_inner_free(link, joint)
            outer = self.world
        body = SubElement(outer, "body", {"name": link.name, **_place(link.pose)})
        self.bodies[link.name] = body
        self.inertial(body, link, joint is not None)
        if joint is not None:
            self.joint(body, joint)

    def refuse_inner_free(self, link: WrittenLink, joint: WrittenJoint | None) -> None:
        root = self.contents.links[0]
        held = link.parent == root.name and not self.contents.free
        if not held or _place(link.pose):
            raise FreebodyError(
                f"save: in MJCF only bodies of the world move freely, from its origin; joint "
                f"{joint and joint.name!r} of {self.contents.name!r} is another."
            )

    def inertial(self, body: Element, link: WrittenLink, jointed: bool) -> None:
        given = link.inertia or Inertia.nothing()
        mass, com, tensor = given.numbers()
        if not jointed and not mass and not tensor.any():
            return
        moments, axes = self.principal(link.name, tensor)
        if jointed and (mass < _LEAST or min(moments) < _LEAST):
            self.light.append(link.name)
            mass, moments = max(mass, _LEAST), np.maximum(moments, _LEAST)
        SubElement(
            body,
            "inertial",
            {
                "pos": numbers(com),
                "quat": numbers(_quaternion(axes)),
                "mass": repr(mass),
                "diaginertia": numbers(moments),
            },
        )

    def principal(self, name: str, tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The principal moments and axes of an inertia tensor in the form that MuJoCo takes."""
        if self.flat:
            # nothing turns out of the plane, so that a disc moves as what only turns in it
            zz = tensor[2, 2]
            return np.array((zz / 2, zz / 2, zz)), np.eye(3)
        if not (tensor - np.diag(np.diag(tensor))).any():
            moments, axes = np.diag(tensor).copy(), np.eye(3)
        else:
            moments, axes = np.linalg.eigh(tensor)
            axes = axes * np.linalg.det(axes)
        largest = int(np.argmax(moments))
        smaller = np.arange(3) != largest
        short = decimal_sum((moments[largest], *-moments[smaller]))
        if short > _ROUNDED * abs(moments[largest]):
            self.losses.append(
                f"the moments of inertia of {name!r}, which no rigid body has: the smaller ones "
                f"are raised"
            )
        if short > 0.0:
            moments[smaller] = [decimal_sum((x, 0.5 * short)) for x in moments[smaller]]
        # MuJoCo adds the two without regard to rounding
        moments[largest] = min(moments[largest], moments[smaller].sum())
        return moments, axes

    # ------------------------------------------------------------ joints
    def joint(self, body: Element, joint: WrittenJoint) -> None:
        kind = HOLDS.kinds[joint.kind]
        given = {"name": joint.name, "type": kind}
        if kind not in ("hinge", "slide"):
            SubElement(body, "joint", given)
            return
        limits, drive = joint.limits, joint.drive
        given["axis"] = numbers(joint.axis)
        if limits.lower >= limits.upper:
            self.losses.append(
                f"the range of {joint.name!r}, which is a point: MuJoCo takes it for none"
            )
        elif limits.lower > -INFINITE or limits.upper < INFINITE:
            given["range"] = f"{limits.lower!r} {limits.upper!r}"
        if 0.0 < limits.effort < INFINITE:
            given["actuatorfrcrange"] = f"{-limits.effort!r} {limits.effort!r}"
        armature = drive["rotor"] * drive["gear"] * drive["gear"]
        if drive["gear"] != 1.0:
            self.geared.append(joint.name)
        rest = drive["rest"] if drive["stiffness"] else drive["hardening_rest"]
        if drive["hardening"] and drive["hardening_rest"] != rest:
            self.losses.append(f"the rest position of the hardening spring of {joint.name!r}")
        polynomials = {
            "damping": (drive["viscous"], drive["quadratic"]),
            "stiffness": (drive["stiffness"], 0.0, drive["hardening"]),
        }
        for key, powers in polynomials.items():
            used = powers if powers[-1] else powers[:1]
            if any(used):
                given[key] = numbers(used)
        for key, value in (
            ("frictionloss", drive["coulomb"]),
            ("armature", armature),
            ("springref", rest),
        ):
            if value:
                given[key] = repr(value)
        SubElement(body, "joint", given)

    # ------------------------------------------------------------ constraints
    def equalities(self) -> None:
        followers = [link.joint for link in self.contents.links if link.joint and link.joint.mimic]
        if not (followers or self.contents.loops):
            return
        equality = SubElement(self.root, "equality")
        for joint in followers:
            assert joint.mimic
            mimic = joint.mimic
            given = {
                "joint1": joint.name,
                "joint2": mimic.joint,
                "polycoef": numbers((mimic.offset, mimic.ratio, *mimic.powers, 0, 0, 0)[:5]),
            }
            SubElement(equality, "joint", given)
        for loop in self.contents.loops:
            ends = [self.end(frame) for frame in loop.frames]
            if loop.kind == "revolute":
                for side in (-1.0, 1.0):
                    by = side * _ALONG * np.array(loop.axis)
                    self.equality(
                        equality, "connect", f"{loop.name}{'' if side < 0 else '_2'}", ends, by
                    )
            else:
                tag = {"spherical": "connect", "fixed": "weld"}[loop.kind]
                self.equality(equality, tag, loop.name, ends, np.zeros(3))

    def end(self, frame: str) -> tuple[Element, np.ndarray, np.ndarray]:
        """The body element that a loop's frame is fixed to, and the frame's rotation and position
        there."""
        link, R, p = self.contents.parts[frame], np.eye(3), np.zeros(3)
        while link.mounted:
            own = np.array(link.pose[0])
            R, p = own @ R, np.array(link.pose[1]) + own @ p
            link = self.contents.parts[link.parent]
        return self.bodies[link.name], R, p

    def equality(
        self,
        equality: Element,
        tag: str,
        name: str,
        ends: list[tuple[Element, np.ndarray, np.ndarray]],
        by: np.ndarray,
    ) -> None:
        """Add an equality that holds two sites together, at the offset `by` from the frames of a
        loop."""
        # readers call the ends so
        sites = [
            self.site(f"{name}_{side}", body, (R, p + R @ by))
            for side, (body, R, p) in zip("ab", ends, strict=True)
        ]
        SubElement(equality, tag, {"name": name, "site1": sites[0], "site2": sites[1]})

    def site(self, name: str, body: Element, pose: Pose | tuple[np.ndarray, np.ndarray]) -> str:
        """Add a site to a body; returns its name."""
        while name in self.sites:
            name += "_"
        self.sites.add(name)
        SubElement(body, "site", {"name": name, **_place(pose)})
        return name

    # ------------------------------------------------------------ struts
    def tendons(self) -> None:
        """Add struts as tendons, each a spring and a damper between two sites."""
        told = [(strut, self.spring(strut)) for strut in self.contents.struts]
        kept = [(strut, rest) for strut, rest in told if strut.stiffness or strut.damping]
        if not kept:
            return
        tendon = SubElement(self.root, "tendon")
        for strut, rest in kept:
            numbers_of = {
                "stiffness": strut.stiffness,
                "damping": strut.damping,
                "springlength": rest,
            }
            given = {key: repr(x) for key, x in numbers_of.items()}
            spatial = SubElement(tendon, "spatial", {"name": strut.name, **given})
            for side, frame in zip("ab", strut.frames, strict=True):
                site = frame
                if not self.contents.parts[frame].mounted:
                    body, R, p = self.end(frame)
                    site = self.site(f"{strut.name}_{side}", body, (R, p))
                SubElement(spatial, "site", {"site": site})

    def spring(self, strut: WrittenStrut) -> float:
        """The rest length (m) that gives a strut's spring the right force in MuJoCo, which knows no
        preload."""
        stiffness, rest, preload = strut.stiffness, strut.rest, strut.preload
        if not stiffness and not strut.damping:
            which = "which is a preload alone" if preload else "which has no force"
            self.losses.append(f"the strut {strut.name!r}, {which}")
        elif preload:
            free = rest - preload / stiffness if stiffness else -1.0
            if free >= 0.0:
                self.losses.append(
                    f"the preload of the strut {strut.name!r}: with the rest length {free:.6g} m, "
                    f"which is written, its spring has the same force"
                )
                return free
            self.losses.append(
                f"the preload of the strut {strut.name!r}, which no rest length stands for"
            )
        return rest


def _place(pose: Pose | tuple[np.ndarray, np.ndarray]) -> dict[str, str]:
    R, p = np.array(pose[0]), np.array(pose[1])
    given = {"pos": numbers(p)} if p.any() else {}
    if not np.array_equal(R, np.eye(3)):
        given["quat"] = numbers(_quaternion(R))
    return given


def _quaternion(R: np.ndarray) -> np.ndarray:
    """The unit quaternion w, x, y, z of a rotation, by its largest entry."""
    squares = np.array(
        (
            1.0 + R[0, 0] + R[1, 1] + R[2, 2],
            1.0 + R[0, 0] - R[1, 1] - R[2, 2],
            1.0 - R[0, 0] + R[1, 1] - R[2, 2],
            1.0 - R[0, 0] - R[1, 1] + R[2, 2],
        )
    )
    k = int(np.argmax(squares))
    (a, b, c) = R[2, 1], R[0, 2], R[1, 0]
    (d, e, f) = R[1, 2], R[2, 0], R[0, 1]
    rows = (
        (squares[0], a - d, b - e, c - f),
        (a - d, squares[1], f + c, e + b),
        (b - e, f + c, squares[2], a + d),
        (c - f, e + b, a + d, squares[3]),
    )
    q = np.array(rows[k])
    q /= np.linalg.norm(q)
    return q if q[0] >= 0.0 else -q
