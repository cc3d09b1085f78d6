"""From links and joints to a `Model`: the one place where a mechanism is checked.

Refusals name the link or joint, the file's line where there is one, and the remedy.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Literal, NoReturn, TypeVar

import numpy as np

from freebody.errors import FileError, ModelError, PhysicalWarning, UnknownNameError
from freebody.model import changes
from freebody.model.bodies import Body, Frame
from freebody.model.description import (
    MOST_LINKS,
    Drive,
    Joint,
    Link,
    Loop,
    Mimic,
    Notice,
    RobotDescription,
)
from freebody.model.joints import KINDS
from freebody.model.loops import checked_loop
from freebody.model.model import Model
from freebody.model.parameters import Quantity, one_value_each, quantity
from freebody.model.placement import Placement
from freebody.model.tree import Attached
from freebody.spatial import of_dimension, unit

Policy = Literal["warn", "refuse", "ignore"]
_MOST_STEPS = 1000
_Part = TypeVar("_Part", Link, Joint)
MimicPolicy = Literal["follow", "free"]
BasePolicy = Literal["fixed", "free"]


def build_model(
    description: RobotDescription,
    *,
    physical: Policy = "refuse",
    mimic: MimicPolicy = "follow",
    base: BasePolicy = "fixed",
    tip: str | None = None,
) -> Model:
    """Check a description and lump what is fixed together; see `load` for the options."""
    for option, value, allowed in (
        ("physical", physical, ("warn", "refuse", "ignore")),
        ("mimic", mimic, ("follow", "free")),
        ("base", base, ("fixed", "free")),
    ):
        if value not in allowed:
            raise UnknownNameError("option", value, f"{option}=", allowed)
    described = one_value_each(description, repr(description.name))
    return _Assembly(described, physical, mimic, base).model(tip)


class _Assembly:
    """One assembly: the description, what was found on the way, and its refusals."""

    def __init__(
        self, description: RobotDescription, physical: Policy, mimic: MimicPolicy, base: BasePolicy
    ):
        self.description = description
        self.physical, self.mimic, self.base = physical, mimic, base
        self.notices = list(description.notices)
        self.links = self._unique("link", description.links)
        self.joints = self._unique("joint", description.joints)

    def model(self, tip: str | None) -> Model:
        d = self.description
        if not d.links:
            self.refuse("there are no links; a robot needs at least one.")
        if len(d.links) > MOST_LINKS:
            self.refuse(f"there are {len(d.links)} links; at most {MOST_LINKS} are read.")
        joints = [self.checked(joint) for joint in d.joints]
        for link in d.links:
            self.check_inertia(link)
        for joint in joints:
            self.check_drive(joint)
        parent_joint = self.parent_joints(joints)
        root = self.root(parent_joint)
        if self.base == "free":
            if d.dim == 2:
                joints.insert(0, Joint("base", "planar", "", root, axis=()))
            else:
                joints.insert(0, Joint("base", "free", "", root))
            self._unique("joint", tuple(joints))
            parent_joint[root] = joints[0]
        order = [joint.child for joint in joints if KINDS[joint.kind].nv]
        index = {name: i for i, name in enumerate(order)}
        carrier: dict[str, tuple[int, Placement]] = {}
        for link in d.links:
            self.carry(link.name, parent_joint, index, carrier)
        return self.finished(joints, index, carrier, tip)

    # ------------------------------------------------------------ checks
    def refuse(self, problem: str, line: int | None = None) -> NoReturn:
        """Raise with the file and line where there is one."""
        if self.description.file:
            raise FileError(self.description.file, line, problem)
        raise ModelError(f"{self.description.name!r}: {problem}")

    def _unique(self, what: str, parts: tuple[_Part, ...]) -> dict[str, _Part]:
        named: dict[str, _Part] = {}
        for part in parts:
            if not part.name:
                self.refuse(f"a {what} has no name; give it one.", part.line)
            if part.name in named:
                self.refuse(f"two {what}s are called {part.name!r}; rename one.", part.line)
            named[part.name] = part
        return named

    def checked(self, joint: Joint) -> Joint:
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
        self.check_limits(joint, where)
        axis = self.unit_axis(joint, where) if kind.needs_axis else ()
        return replace(joint, axis=axis, numbers=self.own_numbers(joint, where))

    def unit_axis(self, joint: Joint, where: str) -> tuple[float, ...]:
        """The joint's axis, of unit length: for a planar revolute joint (±1,)."""
        expected = KINDS[joint.kind].axis_size(self.description.dim)
        axis = np.array(joint.axis, dtype=float)
        if axis.shape != (expected,) or not np.isfinite(axis).all() or not axis.any():
            self.refuse(
                f"{where}: axis {joint.axis} must be {expected} finite numbers, not all zero.",
                joint.line,
            )
        return unit(axis)

    def own_numbers(self, joint: Joint, where: str) -> tuple[Quantity, ...]:
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

    def check_limits(self, joint: Joint, where: str) -> None:
        problem = joint.limits.fault()
        if problem:
            self.refuse(f"{where}: {problem}.", joint.line)

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
        self.doubt("physical", f"link {link.name!r}", link.inertia.fault(), link.line)

    def check_drive(self, joint: Joint) -> None:
        """The same policy on friction that pushes and rotors that no motor has."""
        if self.physical != "ignore":
            self.doubt("drive", f"joint {joint.name!r}", joint.drive.fault(), joint.line)

    def doubt(self, kind: str, what: str, fault: str | None, line: int | None) -> None:
        """Warn about what no robot has, or refuse it."""
        if fault is None:
            return
        problem = f"{what}: {fault}"
        if self.physical == "refuse":
            self.refuse(f"{problem}. Correct it, or accept it with physical='warn'.", line)
        notice = Notice(kind, f"warning: {problem}.", self.description.file, line)
        self.notices.append(notice)
        warnings.warn(str(notice), PhysicalWarning, stacklevel=6)

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
                    cycle = " -> ".join(_cut([*walked[walked.index(name) :], name]))
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
                f"links {', '.join(map(repr, roots[:6]))} have no joint above them; only one link "
                f"can be the base: "
                "connect the others to it by joints.",
                self.links[roots[1]].line,
            )
        return roots[0]

    # ------------------------------------------------------------ lumping and mimics
    def carry(
        self,
        link: str,
        above: dict[str, Joint],
        index: dict[str, int],
        carrier: dict[str, tuple[int, Placement]],
    ) -> None:
        """Notes the body that a link is part of, and the link's frame in it: found by walking its
        parents."""
        walked = []
        while link not in carrier:
            if link not in above:
                carrier[link] = (-1, Placement())
            elif link in index:
                carrier[link] = (index[link], Placement())
            else:
                walked.append(link)
                link = above[link].parent
        body, placement = carrier[link]
        for link in reversed(walked):
            placement = self.placed(link, placement, above[link].placement)
            carrier[link] = (body, placement)

    def placed(self, name: str, outer: Placement, inner: Placement) -> Placement:
        """A frame's placement in its body, by way of the frame that it is fixed to."""
        placement = outer.then(inner).folded(of_dimension(self.description.dim))
        if len(placement.steps) > _MOST_STEPS:
            self.refuse(
                f"{name!r} hangs on more than {_MOST_STEPS} fixed steps with names for numbers; "
                f"give them values."
            )
        return placement

    def leaders(self, joints: list[Joint]) -> dict[str, Mimic]:
        """Mimics resolved to an independent leader: ratios multiply along a chain of mimics."""
        named = {joint.name: joint for joint in joints}
        resolved: dict[str, Mimic] = {}
        for joint in joints:
            path: dict[
                str, Joint
            ] = {}  # followers on the way to what is known, in the order walked
            leader = joint
            while leader.mimic is not None and leader.name not in resolved:
                path[leader.name] = leader
                name = leader.mimic.joint
                if name not in named:
                    problem = UnknownNameError(
                        "joint", name, f"the mimic of {leader.name!r}", named
                    )
                    self.refuse(f"{problem} Correct it, or load with mimic='free'.", leader.line)
                if name in path:
                    self.refuse(
                        f"joint {joint.name!r}: its mimic relations form a cycle; remove one.",
                        joint.line,
                    )
                leader = named[name]
            for follower in reversed(path.values()):
                resolved[follower.name] = self.follower(follower, leader, resolved.get(leader.name))
                leader = follower
        return resolved

    def follower(self, joint: Joint, above: Joint, of: Mimic | None) -> Mimic:
        """The mimic of an independent joint that a joint is: it follows `above`, which may be a
        follower itself."""
        given = joint.mimic
        assert given is not None
        if KINDS[above.kind].nv != 1 or KINDS[joint.kind].nv != 1:
            self.refuse(
                f"joint {joint.name!r}: only joints of one coordinate can mimic or be mimicked.",
                joint.line,
            )
        if of is None:
            return Mimic(above.name, given.ratio, given.offset)
        try:
            return Mimic(of.joint, given.ratio * of.ratio, given.offset + given.ratio * of.offset)
        except ModelError as error:
            self.refuse(f"joint {joint.name!r}: {error}", joint.line)

    def finished(
        self,
        joints: list[Joint],
        index: dict[str, int],
        carrier: dict[str, tuple[int, Placement]],
        tip: str | None,
    ) -> Model:
        d = self.description
        followers = self.leaders(joints) if self.mimic == "follow" else {}
        parts: list[list[Attached]] = [[] for _ in range(len(index) + 1)]  # the last is the base
        for link in d.links:
            body, placement = carrier[link.name]
            if link.inertia is not None:
                parts[body].append(
                    Attached(link.name, link.inertia, placement.then(link.placement))
                )
        frames = self.frames(joints, carrier)
        for load in d.payloads:
            if load.frame not in carrier:
                self.refuse(
                    str(UnknownNameError("frame", load.frame, f"payload {load.name!r}", carrier))
                )
            body, placement = carrier[load.frame]
            try:
                parts[body].append(
                    changes.attached(load.inertia, placement, load.name, load.frame, d.dim, d.name)
                )
            except ModelError as error:
                self.refuse(str(error))
        bodies = []
        for joint in joints:
            if not KINDS[joint.kind].nv:
                continue
            parent, placement = carrier[joint.parent] if joint.parent else (-1, Placement())
            mounted = replace(
                joint, placement=placement.then(joint.placement), mimic=followers.get(joint.name)
            )
            bodies.append(Body(joint.child, mounted, parent, tuple(parts[index[joint.child]])))
        model = Model(
            d.name,
            d.dim,
            tuple(bodies),
            tuple(frames),
            *d.gravity,
            base_inertias=tuple(parts[-1]),
            loops=self.loops(joints, carrier),
            home=d.home,
            source=d.source,
            notices=tuple(self.notices),
            loop_tolerance=d.loop_tolerance,
        )
        known = set(model.position_names)
        for name, _ in d.home:
            if name not in known:
                self.refuse(str(UnknownNameError("position", name, "home", model.position_names)))
        chosen = tip or d.tip or (model.leaves[0] if len(model.leaves) == 1 else None)
        return model if chosen is None else model.replace(tip=chosen)

    def frames(self, joints: list[Joint], carrier: dict[str, tuple[int, Placement]]) -> list[Frame]:
        """The frames of links, then those mounted on them, which the carriers are completed
        with."""
        d = self.description
        fixed_to = {joint.child: joint.parent for joint in joints if not KINDS[joint.kind].nv}
        frames = [
            Frame(link.name, *carrier[link.name], fixed_to.get(link.name, "")) for link in d.links
        ]
        for mount in d.mounts:
            if mount.link not in carrier:
                self.refuse(
                    str(UnknownNameError("link", mount.link, f"frame {mount.name!r}", carrier))
                )
            if mount.name in carrier:
                self.refuse(f"frame {mount.name!r}: the name is taken; rename it.")
            body, placement = carrier[mount.link]
            carrier[mount.name] = body, self.placed(mount.name, placement, mount.placement)
            frames.append(Frame(mount.name, *carrier[mount.name], mount.link, mounted=True))
        return frames

    def loops(
        self, joints: list[Joint], carrier: dict[str, tuple[int, Placement]]
    ) -> tuple[Loop, ...]:
        """The loops, each checked."""
        body_of = {name: body for name, (body, _) in carrier.items()}
        taken = {joint.name for joint in joints if KINDS[joint.kind].nv}
        checked = []
        for loop in self.description.loops:
            try:
                checked.append(checked_loop(loop, self.description.dim, body_of, taken))
            except (ModelError, UnknownNameError) as error:
                self.refuse(str(error), loop.line)
            taken.add(loop.name)
        return tuple(checked)


def _cut(names: list[str], most: int = 12) -> list[str]:
    """The names, those in the middle left out where there are many."""
    return names if len(names) <= most else [*names[: most - 2], "…", names[-1]]
