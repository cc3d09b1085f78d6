"""Assembly of links and joints to a `Model`: the description is checked, and links that are fixed
together become one body.

Refusals name the link or joint, the file's line where there is one, and the remedy.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal, NoReturn, TypeVar

import numpy as np

from freebody.errors import (
    FileError,
    IncludedLine,
    ModelError,
    PhysicalWarning,
    UnknownNameError,
    listed,
    warn,
)
from freebody.model import changes, refusal_rules
from freebody.model.bodies import Body, Frame
from freebody.model.description import (
    MOST_LINKS,
    Drive,
    Joint,
    Limits,
    Link,
    Loop,
    Notice,
    RobotDescription,
)
from freebody.model.joints import KINDS
from freebody.model.loops import checked_loop
from freebody.model.losses import loss_fault
from freebody.model.mimics import Mimic, leaders, one_by_one
from freebody.model.model import Model
from freebody.model.parameters import Quantity, one_value_each, quantity
from freebody.model.placement import Placement
from freebody.model.strut_ends import strut_fault
from freebody.model.struts import Strut, checked_strut
from freebody.model.tip import chosen, with_tip
from freebody.model.tree import Attached
from freebody.outputs.display import counted
from freebody.spatial import of_dimension, unit

_MOST_STEPS = 1000
MimicPolicy = Literal["follow", "free"]
BasePolicy = Literal["fixed", "free"]
Policy = Literal["warn", "refuse", "ignore"]
_LinkOrJoint = TypeVar("_LinkOrJoint", Link, Joint)
_Joining = TypeVar("_Joining", Loop, Strut)


def build_model(
    description: RobotDescription,
    *,
    physical: Policy = "refuse",
    mimic: MimicPolicy = "follow",
    base: BasePolicy = "fixed",
    tip: str | None = None,
) -> Model:
    """The model of a checked description, with links that are fixed together joined to one body;
    see `load` for the options."""
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
    """The assembly of one description: its checks, and for each link and frame the body that
    carries it."""

    def __init__(
        self, description: RobotDescription, physical: Policy, mimic: MimicPolicy, base: BasePolicy
    ):
        self.description, self.mimic, self.base = description, mimic, base
        self.links = list(description.links)
        """Links of the description, and those between joints that together follow several."""
        self.taken = {part.name for part in (*description.links, *description.joints)}
        """Names of links and joints."""
        self.checks = _DescriptionChecks(description, physical)
        self.carrier: dict[str, tuple[int, Placement]] = {}
        """Index of the body that carries a link or frame, -1 for the base, and the placement there,
        by name."""

    def model(self, tip: str | None) -> Model:
        d, checks = self.description, self.checks
        if not d.links:
            checks.refuse("there are no links; a robot needs at least one.")
        if len(d.links) > MOST_LINKS:
            checks.refuse(f"there are {len(d.links)} links; at most {MOST_LINKS} are read.")
        joints = [checks.joint(joint) for joint in d.joints]
        for link in d.links:
            checks.check_inertia(link)
        for joint in joints:
            checks.check_drive(joint)
        above = checks.parent_joints(joints)
        root = checks.root(above)
        if self.base == "free":
            if d.dim == 2:
                joints.insert(0, Joint("base", "planar", "", root, axis=()))
            else:
                joints.insert(0, Joint("base", "free", "", root))
            checks.unique("joint", joints)
            above[root] = joints[0]
        if self.mimic == "follow":
            followers = leaders(joints, checks.refuse)
            joints = [part for joint in joints for part in self.following(joint, followers)]
            above = {joint.child: joint for joint in joints}
        order = [joint.child for joint in joints if KINDS[joint.kind].nv]
        index = {name: i for i, name in enumerate(order)}
        for link in self.links:
            self.carry(link.name, above, index)
        return self.finished(joints, tip)

    def following(self, joint: Joint, followers: dict[str, Mimic]) -> tuple[Joint, ...]:
        """The joint with the independent joint that it follows; where it follows several, one joint
        for each, with links between them."""
        mimic = followers.get(joint.name)
        if mimic is None or not mimic.more:
            return (replace(joint, mimic=mimic),)
        several = f"joint {joint.name!r} follows {listed([name for name, _ in mimic.terms])}"
        if joint.drive != Drive():
            own = [n.words for n in joint.drive.listed if getattr(joint.drive, n.name) != n.default]
            self.checks.refuse(
                f"{several}, and has {listed(own)} of its own: these act on the sum of the "
                f"motions that it follows, and a model holds them for the motion of one joint. "
                f"Remove them from the joint, or load with mimic='free' (--mimic free): each joint "
                f"then moves by itself.",
                joint.line,
            )
        if joint.limits != Limits():
            text = f"{several}: its own limits are left out, since no range of one of them keeps it"
            notice = Notice("limits", f"{text} within.", self.description.file, joint.line)
            self.checks.notices.append(notice)
        parts = one_by_one(joint, mimic, self.taken)
        self.links += [Link(part.child) for part in parts[:-1]]
        self.taken.update(name for part in parts for name in (part.name, part.child))
        return parts

    def carry(self, link: str, above: dict[str, Joint], index: dict[str, int]) -> None:
        """Record the body that a link belongs to, and the link's frame in it, by walking up its
        parents."""
        carrier, walked = self.carrier, []
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
        """A frame's placement in its body, composed from those of the frame it is fixed to and on
        that frame."""
        placement = outer.then(inner).folded(of_dimension(self.description.dim))
        if len(placement.steps) > _MOST_STEPS:
            self.checks.refuse(
                f"{name!r} hangs on more than {_MOST_STEPS} fixed placements with symbolic "
                f"numbers; give these values."
            )
        return placement

    def finished(self, joints: list[Joint], tip: str | None) -> Model:
        """The model made of joints, frames and the bodies that carry them."""
        d = self.description
        frames = self.frames(joints)
        movable = [joint for joint in joints if KINDS[joint.kind].nv]
        parts = self.parts(len(movable))
        bodies = []
        for joint, attached in zip(movable, parts, strict=False):
            parent, placement = self.carrier[joint.parent] if joint.parent else (-1, Placement())
            mimic = joint.mimic if self.mimic == "follow" else None
            mounted = replace(joint, placement=placement.then(joint.placement), mimic=mimic)
            bodies.append(Body(joint.child, mounted, parent, tuple(attached)))
        model = Model(
            d.name,
            d.dim,
            tuple(bodies),
            tuple(frames),
            *d.gravity,
            base_inertias=tuple(parts[-1]),
            loops=self.joining(d.loops, partial(checked_loop, d.dim), movable),
            formulas=d.formulas,
            home=d.home,
            source=d.source,
            about=d.about,
            notices=tuple(self.checks.notices),
            loop_tolerance=d.loop_tolerance,
            struts=self.joining(d.struts, checked_strut, (*movable, *d.loops)),
            shapes=tuple((link.name, shape) for link in d.links for shape in link.shapes),
        )
        if problem := loss_fault(model.bodies, model.loops):
            self.checks.refuse(f"{problem}.")
        if problem := strut_fault(model):
            self.checks.refuse(f"{problem}.")
        known = set(model.position_names)
        for name, _ in d.home:
            if name not in known:
                self._unknown("position", name, "home", model.position_names)
        if tip is not None:
            return model.replace(tip=tip)
        return with_tip(model, chosen(model, d.tip, joints))

    def parts(self, bodies: int) -> list[list[Attached]]:
        """The inertias of links and payloads that each body carries; the last entry is the
        base's."""
        d = self.description
        parts: list[list[Attached]] = [[] for _ in range(bodies + 1)]
        for link in d.links:
            body, placement = self.carrier[link.name]
            if link.inertia is not None:
                parts[body].append(
                    Attached(link.name, link.inertia, placement.then(link.placement))
                )
        for load in d.payloads:
            if load.frame not in self.carrier:
                self._unknown("frame", load.frame, f"payload {load.name!r}", self.carrier)
            body, placement = self.carrier[load.frame]
            try:
                parts[body].append(
                    changes.attached(load.inertia, placement, load.name, load.frame, d.dim, d.name)
                )
            except ModelError as error:
                self.checks.refuse(str(error))
        return parts

    def frames(self, joints: list[Joint]) -> list[Frame]:
        """The frames of links, then those mounted on them, whose carriers are recorded on the
        way."""
        d, carrier = self.description, self.carrier
        fixed = {joint.child: joint for joint in joints if not KINDS[joint.kind].nv}
        frames = []
        for link in self.links:
            frame = Frame(link.name, *carrier[link.name])
            if above := fixed.get(link.name):
                frame = replace(frame, parent=above.parent, joint=above.name)
            frames.append(frame)
        for mount in d.mounts:
            if mount.link not in carrier:
                self._unknown("link", mount.link, f"frame {mount.name!r}", carrier)
            if mount.name in carrier:
                self.checks.refuse(f"frame {mount.name!r}: the name is taken; rename it.")
            body, placement = carrier[mount.link]
            carrier[mount.name] = body, self.placed(mount.name, placement, mount.placement)
            frames.append(Frame(mount.name, *carrier[mount.name], mount.link, mounted=True))
        return frames

    def joining(
        self,
        parts: Sequence[_Joining],
        check: Callable[[_Joining, Mapping[str, int], Container[str]], _Joining],
        others: Iterable[Joint | Loop],
    ) -> tuple[_Joining, ...]:
        """Loops or struts of the description, each checked; others: parts whose names they may not
        have."""
        body_of = {name: body for name, (body, _) in self.carrier.items()}
        taken = {part.name for part in others}
        checked = []
        for part in parts:
            try:
                checked.append(check(part, body_of, taken))
            except (ModelError, UnknownNameError) as error:
                self.checks.refuse(str(error), part.line)
            taken.add(part.name)
        return tuple(checked)

    def _unknown(self, what: str, name: str, where: str, known: Collection[str]) -> NoReturn:
        self.checks.refuse(str(UnknownNameError(what, name, where, known)))


class _DescriptionChecks:
    """Checks of a description, its links by name, and the notices that the checks add."""

    def __init__(self, description: RobotDescription, physical: Policy):
        self.description, self.physical = description, physical
        self.notices = list(description.notices)
        self.links = self.unique("link", description.links)
        self.unique("joint", description.joints)

    def refuse(self, problem: str, line: int | IncludedLine | None = None) -> NoReturn:
        """Raise an error about the description, with the file and line where it has these."""
        if self.description.file:
            raise FileError(self.description.file, line, problem)
        raise ModelError(f"{self.description.name!r}: {problem}")

    def unique(self, what: str, parts: Sequence[_LinkOrJoint]) -> dict[str, _LinkOrJoint]:
        """The links or joints by name; refuses parts without a name and two of one name."""
        names = [part.name for part in parts]
        for rule in refusal_rules.EVERY_NAME:
            for i in rule.broken(names):
                self.refuse(f"{rule.said(what, names[i])}; {rule.remedy}.", parts[i].line)
        return dict(zip(names, parts, strict=True))

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
        for end, name in refusal_rules.unknown_ends(joint, self.links):
            unknown = UnknownNameError(f"{end} link", name, "the file", self.links)
            self.refuse(f"{where}: {unknown}", joint.line)
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
        """The joint's axis as a unit vector; for a planar revolute joint (±1,)."""
        expected = KINDS[joint.kind].axis_size(self.description.dim)
        axis = np.array(joint.axis, dtype=float)
        if axis.shape != (expected,) or not np.isfinite(axis).all() or not axis.any():
            self.refuse(
                f"{where}: axis {joint.axis} must be {expected} finite numbers, not all zero.",
                joint.line,
            )
        return unit(axis)

    def _own_numbers(self, joint: Joint, where: str) -> tuple[Quantity, ...]:
        """The numbers of the joint's kind, such as a pitch; refuses too few, too many, and invalid
        ones."""
        own = KINDS[joint.kind].numbers
        if len(joint.numbers) != len(own):
            named = ", ".join(f"{number.name} ({number.unit})" for number in own) or "none"
            self.refuse(
                f"{where}: numbers has {counted(len(joint.numbers), 'entry')}; those of a "
                f"{joint.kind} joint are: {named}.",
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
        """Apply the policy on inertias that no rigid body has: warn and use them as given, or
        refuse them."""
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
        """Warn about negative friction and impossible rotors, or refuse them, by the policy on
        inertias."""
        if problem := joint.drive.fault(strict=True):
            self.refuse(f"joint {joint.name!r}: {problem}.", joint.line)
        if self.physical != "ignore":
            self._doubt("drive", f"joint {joint.name!r}", joint.drive.fault(), joint.line)

    def _doubt(
        self, kind: str, what: str, fault: str | None, line: int | IncludedLine | None
    ) -> None:
        """Warn about an impossible number of a link or joint, or refuse it, by the policy."""
        if fault is None:
            return
        problem = f"{what}: {fault}"
        if self.physical == "refuse":
            self.refuse(f"{problem}. Correct it, or accept it with physical='warn'.", line)
        notice = Notice(kind, f"warning: {problem}.", self.description.file, line)
        self.notices.append(notice)
        warn(str(notice), PhysicalWarning)

    def parent_joints(self, joints: list[Joint]) -> dict[str, Joint]:
        """For each link the joint that carries it; refuses links with several."""
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
        """The only link that no joint carries, from which every other link is reached; refuses
        other descriptions."""
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


def _shortened(names: list[str]) -> list[str]:
    """The names, with a gap in the middle where there are more than twelve."""
    return names if len(names) <= 12 else [*names[:10], "…", names[-1]]
