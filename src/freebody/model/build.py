"""From links and joints to a `Model`: what is fixed together becomes one body."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Literal, NoReturn

from freebody.errors import ModelError, UnknownNameError
from freebody.model import changes
from freebody.model.bodies import Body, Frame
from freebody.model.description import MOST_LINKS, Joint, Loop, RobotDescription
from freebody.model.description_checks import DescriptionChecks, Policy
from freebody.model.joints import KINDS
from freebody.model.loops import checked_loop
from freebody.model.mimic_chains import leaders
from freebody.model.model import Model
from freebody.model.parameters import one_value_each
from freebody.model.placement import Placement
from freebody.model.tip import chosen
from freebody.model.tree import Attached
from freebody.spatial import of_dimension

_MOST_STEPS = 1000
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
    """One assembly: the description, its checks, and of each link and frame the body that carries
    it."""

    def __init__(
        self, description: RobotDescription, physical: Policy, mimic: MimicPolicy, base: BasePolicy
    ):
        self.description, self.mimic, self.base = description, mimic, base
        self.checks = DescriptionChecks(description, physical)
        self.carrier: dict[str, tuple[int, Placement]] = {}
        """Of a link or frame, by name: the index of its body, -1 for the base, and its placement
        there."""

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
        order = [joint.child for joint in joints if KINDS[joint.kind].nv]
        index = {name: i for i, name in enumerate(order)}
        for link in d.links:
            self.carry(link.name, above, index)
        return self.finished(joints, tip)

    def carry(self, link: str, above: dict[str, Joint], index: dict[str, int]) -> None:
        """Notes the body that a link is part of, and the link's frame in it: found by walking its
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
        """A frame's placement in its body, by way of the frame that it is fixed to."""
        placement = outer.then(inner).folded(of_dimension(self.description.dim))
        if len(placement.steps) > _MOST_STEPS:
            self.checks.refuse(
                f"{name!r} hangs on more than {_MOST_STEPS} fixed placements with symbolic "
                f"numbers; give these values."
            )
        return placement

    def finished(self, joints: list[Joint], tip: str | None) -> Model:
        """The model of joints and carriers; its frames complete the carriers, so they come
        first."""
        d = self.description
        frames = self.frames(joints)
        followers = leaders(joints, self.checks.refuse) if self.mimic == "follow" else {}
        movable = [joint for joint in joints if KINDS[joint.kind].nv]
        parts = self.parts(len(movable))
        bodies = []
        for joint, attached in zip(movable, parts, strict=False):
            parent, placement = self.carrier[joint.parent] if joint.parent else (-1, Placement())
            mounted = replace(
                joint, placement=placement.then(joint.placement), mimic=followers.get(joint.name)
            )
            bodies.append(Body(joint.child, mounted, parent, tuple(attached)))
        model = Model(
            d.name,
            d.dim,
            tuple(bodies),
            tuple(frames),
            *d.gravity,
            base_inertias=tuple(parts[-1]),
            loops=self.loops(movable),
            formulas=d.formulas,
            home=d.home,
            source=d.source,
            about=d.about,
            notices=tuple(self.checks.notices),
            loop_tolerance=d.loop_tolerance,
        )
        known = set(model.position_names)
        for name, _ in d.home:
            if name not in known:
                self._unknown("position", name, "home", model.position_names)
        if tip is not None:
            return model.replace(tip=tip)
        return changes.with_tip(model, chosen(model, d.tip, joints))

    def parts(self, bodies: int) -> list[list[Attached]]:
        """The inertias of links and payloads that each body carries; the last are the base's."""
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
        """The frames of links, then those mounted on them, which the carriers are completed
        with."""
        d, carrier = self.description, self.carrier
        fixed_to = {joint.child: joint.parent for joint in joints if not KINDS[joint.kind].nv}
        frames = [
            Frame(link.name, *carrier[link.name], fixed_to.get(link.name, "")) for link in d.links
        ]
        for mount in d.mounts:
            if mount.link not in carrier:
                self._unknown("link", mount.link, f"frame {mount.name!r}", carrier)
            if mount.name in carrier:
                self.checks.refuse(f"frame {mount.name!r}: the name is taken; rename it.")
            body, placement = carrier[mount.link]
            carrier[mount.name] = body, self.placed(mount.name, placement, mount.placement)
            frames.append(Frame(mount.name, *carrier[mount.name], mount.link, mounted=True))
        return frames

    def loops(self, joints: list[Joint]) -> tuple[Loop, ...]:
        """The loops, each checked."""
        body_of = {name: body for name, (body, _) in self.carrier.items()}
        taken = {joint.name for joint in joints}
        checked = []
        for loop in self.description.loops:
            try:
                checked.append(checked_loop(loop, self.description.dim, body_of, taken))
            except (ModelError, UnknownNameError) as error:
                self.checks.refuse(str(error), loop.line)
            taken.add(loop.name)
        return tuple(checked)

    def _unknown(self, what: str, name: str, where: str, known: Collection[str]) -> NoReturn:
        self.checks.refuse(str(UnknownNameError(what, name, where, known)))
