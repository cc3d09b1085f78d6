"""Facts of a robot's file, each with its line: links with inertias and shapes, joints with axes and
limits, as they are written.

Nothing is refused here. What no reader would take, such as a word in the place of a number, is
`None` among the facts, and a finding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.diagnosis.finding import FileLine
from freebody.errors import FreebodyError
from freebody.formats.packages import Packages
from freebody.formats.urdf_elements import XmlElement
from freebody.lazy import Keeps, cached_property
from freebody.model.inertia import Inertia
from freebody.model.model import Model
from freebody.model.placement import ArrayPose, Placement, composed
from freebody.model.shapes import Shape

"""(R, p) of a frame in another."""


class Written(NamedTuple):
    """A number of a file, with the element and the attribute where it is written; None where that
    is no number."""

    value: float | None
    element: XmlElement | None = None
    attribute: str = ""
    text: str = ""


@dataclass(frozen=True)
class InertiaFacts:
    """Mass properties of a link: `inertia` in a frame placed in the link's; None where a number is
    missing or none."""

    inertia: Inertia | None
    placement: Placement
    line: FileLine
    element: XmlElement | None = None

    @property
    def in_link(self) -> Inertia | None:
        """The inertia in the link's axes."""
        if self.inertia is None or not self.placement.steps:
            return self.inertia
        return self.inertia.placed(*self.placement.arrays())


@dataclass(frozen=True)
class LinkFacts(Keeps):
    """A link as it is written."""

    name: str
    line: FileLine
    inertial: InertiaFacts | None = None
    shapes: tuple[Shape, ...] = ()
    element: XmlElement | None = None
    filled: bool = False
    """Whether its inertia is the reader's, of its shapes filled evenly, and not the file's."""
    stated: bool = False
    """Whether a file in freebody's own form gives its moments, if only zeros."""

    @cached_property
    def inertia(self) -> Inertia | None:
        """The inertia in the link's axes; None where there is none, or none that can be read."""
        return self.inertial.in_link if self.inertial else None

    @property
    def inertia_line(self) -> FileLine:
        """The line of the inertia, or of the link that has none."""
        return self.inertial.line if self.inertial else self.line


FRICTIONS = {"damping": "viscous", "friction": "coulomb"}
"""Names of friction as URDF writes it, and as a `Drive` has it."""


@dataclass(frozen=True)
class JointFacts(Keeps):
    """A joint as it is written in a file; kind: a name of `model.joints`, or the unknown type."""

    name: str
    kind: str
    parent: str
    child: str
    line: FileLine
    pose: ArrayPose | None
    """The joint's frame in the parent link's; None where that is not to be read."""
    axis: tuple[float, ...] | None
    """The axis as written; None where there is none."""
    limits: dict[str, Written]
    """The limits that are given, by name: lower, upper, velocity, effort."""
    drive: dict[str, Written]
    """The numbers of friction that are given: damping, friction."""
    mimics: str = ""
    """The joint that it follows."""
    element: XmlElement | None = None
    limit_line: FileLine = None

    @property
    def moves(self) -> bool:
        """Whether the joint is revolute, continuous or prismatic, and so has one coordinate."""
        return self.kind in ("revolute", "continuous", "prismatic")

    @property
    def turns(self) -> bool:
        """Whether the joint turns about its axis."""
        return self.kind in ("revolute", "continuous")

    def limit(self, name: str) -> float | None:
        """The value of a joint's limit by name; None where it is not given."""
        return self.limits[name].value if name in self.limits else None


@dataclass(frozen=True)
class RobotFacts(Keeps):
    """All that is known about a file: what is written in it, the model that is read from it, or why
    none is."""

    file: str
    links: tuple[LinkFacts, ...]
    joints: tuple[JointFacts, ...]
    packages: Packages
    model: Model | None
    refusal: FreebodyError | None = None
    root: XmlElement | None = None
    """The root of a URDF."""
    dim: int = 3
    filled: dict[tuple[Shape, ...], Inertia | None] = field(default_factory=dict, compare=False)
    """Links' shapes at density 1 that have been computed: of meshes that takes seconds."""

    @cached_property
    def link(self) -> dict[str, LinkFacts]:
        """The links of the robot by their names."""
        return {link.name: link for link in self.links}

    @cached_property
    def joint(self) -> dict[str, JointFacts]:
        """The joints of the robot by their names."""
        return {joint.name: joint for joint in self.joints}

    @cached_property
    def above(self) -> dict[str, JointFacts]:
        """The joint above each link that has one."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def roots(self) -> tuple[LinkFacts, ...]:
        """The links that hang on no joint."""
        return tuple(link for link in self.links if link.name not in self.above)

    @cached_property
    def carrier(self) -> dict[str, str]:
        """For each link the one to which it is rigidly attached through fixed joints: a link moved
        by a joint, or the base."""
        found: dict[str, str] = {}
        for link in self.links:
            name, seen = link.name, {link.name}
            while (joint := self.above.get(name)) and joint.kind == "fixed":
                name = joint.parent
                if name in seen:
                    break
                seen.add(name)
            found[link.name] = name
        return found

    @cached_property
    def groups(self) -> dict[str, list[tuple[LinkFacts, ArrayPose]]]:
        """Links that are fixed together, with their poses, by the link that carries them; links
        whose pose cannot be read are left out."""
        found: dict[str, list[tuple[LinkFacts, ArrayPose]]] = {}
        for link in self.links:
            pose: ArrayPose | None = np.eye(self.dim), np.zeros(self.dim)
            name = link.name
            while pose is not None and name != self.carrier[link.name]:
                joint = self.above[name]
                pose = None if joint.pose is None else composed(joint.pose, pose)
                name = joint.parent
            if pose is not None:
                found.setdefault(name, []).append((link, pose))
        return found

    @cached_property
    def mass(self) -> float:
        """The mass of all links that have a positive one, kg."""
        masses = (link.inertia.numbers()[0] for link in self.links if link.inertia)
        return sum(mass for mass in masses if mass > 0.0)

    @cached_property
    def moving(self) -> tuple[LinkFacts, ...]:
        """The links that move, in a robot with a fixed base."""
        base = {link.name for link in self.roots}
        return tuple(link for link in self.links if self.carrier[link.name] not in base)

    @cached_property
    def reach(self) -> float:
        """The longest way from the base along joints (m), at least 1 mm."""
        far: dict[str, float] = {}
        for link in self.links:
            way: dict[str, float] = {}
            """Steps towards the base, or around a circle, which has none."""
            name = link.name
            while name not in far and name not in way:
                joint = self.above.get(name)
                way[name] = norm(joint.pose[1]) if joint and joint.pose is not None else 0.0
                name = joint.parent if joint else ""
            distance = far.get(name, 0.0)
            for passed, step in reversed(way.items()):
                far[passed] = distance = distance + step
        return max(far.values(), default=0.0) or 1e-3

    def line_of(self, name: str) -> FileLine:
        """The line of a link's inertia, or of a joint's limits; None of any other name."""
        if name in self.link:
            return self.link[name].inertia_line
        return self.joint[name].limit_line if name in self.joint else None


def norm(x: Sequence[float] | Array) -> float:
    """The length of a vector."""
    return float(np.linalg.norm(x))


def elements_in(root: XmlElement) -> Iterator[XmlElement]:
    """An element and all below it, as their tags begin."""
    waiting = [root]
    while waiting:
        element = waiting.pop()
        yield element
        waiting += reversed(element.children)
