"""What is refused, and what is doubted, in the description of a robot.

Refusals name the link or joint, the file's line where there is one, and the remedy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NoReturn, TypeVar

import numpy as np

from freebody.errors import FileError, ModelError, PhysicalWarning, UnknownNameError, warn
from freebody.model.description import Drive, Joint, Link, Notice, RobotDescription
from freebody.model.joints import KINDS
from freebody.model.parameters import Quantity, quantity
from freebody.spatial import unit

Policy = Literal["warn", "refuse", "ignore"]
Part = TypeVar("Part", Link, Joint)


class DescriptionChecks:
    """The links of a description by name, its checks, and the notices that they add."""

    def __init__(self, description: RobotDescription, physical: Policy):
        self.description, self.physical = description, physical
        self.notices = list(description.notices)
        self.links = self.unique("link", description.links)
        self.unique("joint", description.joints)

    def refuse(self, problem: str, line: int | None = None) -> NoReturn:
        """Raise with the file and line where there is one."""
        if self.description.file:
            raise FileError(self.description.file, line, problem)
        raise ModelError(f"{self.description.name!r}: {problem}")

    def unique(self, what: str, parts: Sequence[Part]) -> dict[str, Part]:
        """The parts by name; refuses one without and two of the same."""
        named: dict[str, Part] = {}
        for part in parts:
            if not part.name:
                self.refuse(f"a {what} has no name; give it one.", part.line)
            if part.name in named:
                self.refuse(f"two {what}s are called {part.name!r}; rename one.", part.line)
            named[part.name] = part
        return named

    def joint(self, joint: Joint) -> Joint:
        """The joint with a unit axis; refuses unknown kinds, links, axes, limits."""
        where = f"joint {joint.name!r}"
        if joint.kind not in KINDS:
            self.refuse(str(UnknownNameError("joint kind", joint.kind, where, KINDS)), joint.line)
        kind = KINDS[joint.kind]
        dim = self.description.dim
        if dim not in kind.dimensions:
            self.refuse(
                f"{where}: a {kind.name} joint needs a model in space, this one is planar.",
                joint.line,
            )
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in self.links:
                self.refuse(
                    f"{where}: {UnknownNameError(f'{role} link', name, 'the file', self.links)}",
                    joint.line,
                )
        if joint.parent == joint.child:
            self.refuse(
                f"{where}: link {joint.child!r} cannot be its own parent; name another parent.",
                joint.line,
            )
        if kind.nv != 1 and joint.drive != Drive():
            self.refuse(
                f"{where}: friction, rotors and springs belong to joints of one coordinate, not a "
                f"{kind.name} one; remove them.",
                joint.line,
            )
        if problem := joint.limits.fault():
            self.refuse(f"{where}: {problem}.", joint.line)
        axis = self._unit_axis(joint, where) if kind.needs_axis else ()
        return replace(joint, axis=axis, numbers=self._own_numbers(joint, where))

    def _unit_axis(self, joint: Joint, where: str) -> tuple[float, ...]:
        """The joint's axis, of unit length: for a planar revolute joint (±1,)."""
        expected = KINDS[joint.kind].axis_size(self.description.dim)
        axis = np.array(joint.axis, dtype=float)
        if axis.shape != (expected,) or not np.isfinite(axis).all() or not axis.any():
            self.refuse(
                f"{where}: axis {joint.axis} must be {expected} finite numbers, not all zero.",
                joint.line,
            )
        return unit(axis)

    def _own_numbers(self, joint: Joint, where: str) -> tuple[Quantity, ...]:
        """The numbers of the joint's kind, such as a pitch; refuses too few, too many, and what is
        none."""
        own = KINDS[joint.kind].numbers
        if len(joint.numbers) != len(own):
            named = ", ".join(f"{number.name} ({number.unit})" for number in own) or "none"
            self.refuse(
                f"{where}: numbers has {len(joint.numbers)} entries; those of a {joint.kind} joint "
                f"are: {named}.",
                joint.line,
            )
        try:
            return tuple(
                quantity(x, f"{where}: {number.name}")
                for x, number in zip(joint.numbers, own, strict=True)
            )
        except ModelError as error:
            self.refuse(str(error), joint.line)

    def check_inertia(self, link: Link) -> None:
        """The policy on inertias that no rigid body has: the numbers are used as given, or
        refused."""
        if link.inertia is None or self.physical == "ignore":
            return
        if link.inertia.dim != self.description.dim:
            self.refuse(
                f"link {link.name!r}: its inertia is {link.inertia.dim}D, the model "
                f"{self.description.dim}D.",
                link.line,
            )
        self._doubt("physical", f"link {link.name!r}", link.inertia.fault(), link.line)

    def check_drive(self, joint: Joint) -> None:
        """The same policy on friction that pushes and rotors that no motor has."""
        if self.physical != "ignore":
            self._doubt("drive", f"joint {joint.name!r}", joint.drive.fault(), joint.line)

    def _doubt(self, kind: str, what: str, fault: str | None, line: int | None) -> None:
        """Warn about what no robot has, or refuse it."""
        if fault is None:
            return
        problem = f"{what}: {fault}"
        if self.physical == "refuse":
            self.refuse(f"{problem}. Correct it, or accept it with physical='warn'.", line)
        notice = Notice(kind, f"warning: {problem}.", self.description.file, line)
        self.notices.append(notice)
        warn(str(notice), PhysicalWarning)

    def parent_joints(self, joints: list[Joint]) -> dict[str, Joint]:
        """For each link the joint above it; a link has at most one."""
        above: dict[str, Joint] = {}
        for joint in joints:
            other = above.setdefault(joint.child, joint)
            if other is not joint:
                self.refuse(
                    f"link {joint.child!r} hangs on two joints, {other.name!r} and {joint.name!r}; "
                    "a tree allows one: write the other as a loop between two frames, or remove "
                    "it.",
                    joint.line,
                )
        return above

    def root(self, above: dict[str, Joint]) -> str:
        """The one link without a joint above it; every other link must lead to it."""
        roots = [link.name for link in self.description.links if link.name not in above]
        rooted: set[str] = set()
        for link in self.description.links:
            path: dict[str, None] = {}  # in the order walked
            name = link.name
            while name in above and name not in rooted:
                if name in path:
                    walked = list(path)
                    cycle = " -> ".join(_shortened([*walked[walked.index(name) :], name]))
                    self.refuse(
                        f"the links form a cycle, {cycle} (child -> parent); a tree has none: "
                        "write one joint as a loop between two frames, or remove it.",
                        above[name].line,
                    )
                path[name] = None
                name = above[name].parent
            rooted.update(path)
        if len(roots) > 1:
            self.refuse(
                f"links {', '.join(map(repr, roots[:6]))} have no parent joint; only one link can "
                f"be the base: connect the others to it by joints.",
                self.links[roots[1]].line,
            )
        return roots[0]


def _shortened(names: list[str], most: int = 12) -> list[str]:
    """The names, those in the middle left out where there are many."""
    return names if len(names) <= most else [*names[: most - 2], "…", names[-1]]
