"""Names of a model's parts, and the places of its coordinates in q and q̇."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from freebody.errors import FreebodyError, UnknownNameError
from freebody.lazy import cached_property
from freebody.model.bodies import Body, Frame
from freebody.model.description import TIP, Loop, Notice
from freebody.model.joints import JointKind
from freebody.model.struts import Strut
from freebody.model.tree import Coordinates


class NamedParts:
    """The parts of a model that are independent of its numbers: sizes, names, and which coordinates
    are driven."""

    name: str
    bodies: tuple[Body, ...]
    frames: tuple[Frame, ...]
    loops: tuple[Loop, ...]
    struts: tuple[Strut, ...]
    tip: str | None
    notices: tuple[Notice, ...]

    @cached_property
    def coordinates(self) -> tuple[Coordinates, ...]:
        """For each body the entries of q and q̇ that belong to its joint; a mimic joint shares its
        leader's."""
        own: dict[str, Coordinates] = {}
        iq = iv = 0
        for body in self.bodies:
            if body.joint.mimic is None:
                kind = body.kind
                own[body.joint.name] = Coordinates(
                    tuple(range(iq, iq + kind.nq)), tuple(range(iv, iv + kind.nv)), 1.0, 0.0
                )
                iq, iv = iq + kind.nq, iv + kind.nv
        result = []
        for body in self.bodies:
            mimic = body.joint.mimic
            # assembly has already resolved mimics of mimics to an independent leader
            result.append(
                own[body.joint.name]
                if mimic is None
                else replace(own[mimic.joint], ratio=mimic.ratio, offset=mimic.offset)
            )
        return tuple(result)

    @cached_property
    def nq(self) -> int:
        """Number of position coordinates."""
        return sum(body.kind.nq for body in self.bodies if body.joint.mimic is None)

    @cached_property
    def nv(self) -> int:
        """Number of velocity coordinates: the degrees of freedom."""
        return sum(body.kind.nv for body in self.bodies if body.joint.mimic is None)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the movable joints, followers of other joints included, in the file's order."""
        return tuple(body.joint.name for body in self.bodies)

    @cached_property
    def position_names(self) -> tuple[str, ...]:
        """A name for each entry of q: the joint's, with the component where it has several."""
        return self._names(lambda kind: kind.position_names)

    @cached_property
    def velocity_names(self) -> tuple[str, ...]:
        """A name for each entry of q̇ and tau."""
        return self._names(lambda kind: kind.velocity_names)

    def _names(self, components: Callable[[JointKind], tuple[str, ...]]) -> tuple[str, ...]:
        return tuple(
            f"{body.joint.name}.{component}" if component else body.joint.name
            for body in self.bodies
            if body.joint.mimic is None
            for component in components(body.kind)
        )

    @cached_property
    def passive(self) -> tuple[int, ...]:
        """Coordinates, as entries of q and q̇, that nothing drives: those of passive joints."""
        if not [body for body in self.bodies if body.joint.passive]:  # most have none
            return ()
        return tuple(
            k
            for body, at in zip(self.bodies, self.coordinates, strict=True)
            if body.joint.passive and body.joint.mimic is None
            for k in at.v
        )

    @cached_property
    def driven(self) -> tuple[int, ...]:
        """Coordinates that are not `passive`, as entries of q̇ and tau."""
        return tuple([k for k in range(self.nv) if k not in self.passive])

    @property
    def passive_names(self) -> tuple[str, ...]:
        """Names of the coordinates whose joints are passive, of `velocity_names`."""
        return tuple(self.velocity_names[k] for k in self.passive)

    @property
    def driven_names(self) -> tuple[str, ...]:
        """Names of the coordinates whose joints are not passive, of `velocity_names`."""
        return tuple(self.velocity_names[k] for k in self.driven)

    @property
    def reaction_names(self) -> tuple[str, ...]:
        """Names of everything that transmits a reaction wrench: joints, then loops."""
        return (*self.joint_names, *(loop.name for loop in self.loops))

    @property
    def fixed_joint_names(self) -> tuple[str, ...]:
        """Names of the fixed joints, by which links are fixed to one another."""
        return tuple(frame.joint for frame in self.frames if frame.joint)

    @property
    def actuated(self) -> tuple[str, ...]:
        """Names of the independent joints that are driven: all that are not passive."""
        return tuple(
            body.joint.name
            for body in self.bodies
            if body.joint.mimic is None and not body.joint.passive
        )

    @property
    def strut_names(self) -> tuple[str, ...]:
        """Names of the struts."""
        return tuple(strut.name for strut in self.struts)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names of all frames: links and mounted ones."""
        return tuple(frame.name for frame in self.frames)

    @cached_property
    def _frame_by_name(self) -> dict[str, Frame]:
        return {frame.name: frame for frame in self.frames}

    @cached_property
    def leaves(self) -> tuple[str, ...]:
        """The movable frames at the ends of the tree: links that carry nothing, or frames mounted
        on them."""
        carry = {body.joint.parent for body in self.bodies} | {
            f.parent for f in self.frames if not f.mounted
        }

        mounted: dict[str, list[str]] = {}
        for frame in self.frames:
            if frame.mounted:
                mounted.setdefault(frame.parent, []).append(frame.name)
        links = [
            f.name for f in self.frames if not f.mounted and f.body >= 0 and f.name not in carry
        ]
        ends, waiting = [], links[::-1]
        while waiting:  # depth first, in the order of the file
            name = waiting.pop()
            if name in mounted:
                waiting += reversed(mounted[name])
            else:
                ends.append(name)
        return tuple(ends)

    @property
    def tip_reason(self) -> str:
        """The rule that chose the tip, or the reason why there is none with the candidates: a
        sentence of `notices`."""
        return next((notice.text for notice in self.notices if notice.kind == TIP), "")

    def frame(self, name: str | None = None) -> Frame:
        """The frame of that name; of None the tip."""
        if name is None:
            if self.tip is None:
                raise FreebodyError(
                    f"{self.name!r} has no single tip. {self.tip_reason} Name a frame, or choose "
                    f"the tip with tip= (--tip)."
                )
            name = self.tip
        try:
            return self._frame_by_name[name]
        except (KeyError, TypeError):  # a TypeError: what cannot be a name
            raise UnknownNameError("frame", name, f"{self.name!r}", self.frame_names) from None

    def body_index(self, name: str) -> int:
        """Index of the body that carries a link or body of that name."""
        for i, body in enumerate(self.bodies):
            if body.name == name:
                return i
        return self.frame(name).body
