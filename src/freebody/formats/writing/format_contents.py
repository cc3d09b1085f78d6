"""A model's contents for formats that hold less than freebody's own: in plain numbers, with joints
that the format knows, and sentences on whatever is lost.

A writer of a format says what it holds (`Holds`), and prints what `contents_of` makes of a model.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from freebody.errors import FreebodyError, listed
from freebody.model.bodies import Body
from freebody.model.description import INFINITE, Drive, Joint, Limits
from freebody.model.doubts import read_doubts
from freebody.model.drives import LAWS
from freebody.model.inertia import Inertia, combined
from freebody.model.mimics import Mimic
from freebody.model.model import Model
from freebody.model.parameters import each_parameter
from freebody.model.placement import ArrayPose, Placement, seen_from
from freebody.model.quantity_reader import VALUES
from freebody.model.single_joints import is_taken_apart, with_single_joints
from freebody.model.tip import chosen
from freebody.model.tree import Attached, Pose

STANDARD_GRAVITY = 9.81
"""m/s² along -z, which readers of formats without gravity take."""
GROUND = "world"
"""The ground's name in SDF and MJCF."""
_LIMITS = {
    "lower": "lower limit",
    "upper": "upper limit",
    "velocity": "speed limit",
    "effort": "effort limit",
}
_SHOWN = 6
"""Names that a sentence holds."""
_OUTSIDE_XML = re.compile(r"[\x00-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


@dataclass(frozen=True)
class Holds:
    """A format's place for what a model can have besides links, joints and masses.

    kinds: of joints, by their names here. drive: numbers of drives. loops: kinds of loops.
    struts, gravity, velocity (its limits): whether there is a place for it. base: how a floating
    base is told, where it is not written. passive: whether joints without motor are told, of closed
    chains. keeps_tip: whether the tip is written; else readers choose it. degree: the highest of a
    polynomial by which a joint follows another. no_zero: limits of which readers take 0 for none.
    unlimited: the size from which they take any limit for none.
    """

    name: str
    kinds: Mapping[str, str]
    drive: frozenset[str]
    loops: frozenset[str] = frozenset()
    struts: bool = False
    gravity: bool = False
    velocity: bool = True
    base: str = ""
    passive: bool = False
    keeps_tip: bool = False
    degree: int = 1
    no_zero: frozenset[str] = frozenset()
    unlimited: float = INFINITE


@dataclass(frozen=True)
class WrittenLink:
    """A link, or a frame mounted on one, with its pose in its parent; without a joint it is fixed,
    by a joint whose name may be known. The root has no parent. Its inertia is in its own frame."""

    name: str
    parent: str
    pose: Pose
    inertia: Inertia | None = None
    joint: WrittenJoint | None = None
    mounted: bool = False
    fixed: str = ""


@dataclass(frozen=True)
class WrittenJoint:
    """A joint that moves a link, in plain numbers."""

    name: str
    kind: str
    axis: tuple[float, ...]
    numbers: tuple[float, ...]
    limits: Limits
    drive: Mapping[str, float]
    mimic: Mimic | None
    passive: bool


@dataclass(frozen=True)
class WrittenLoop:
    """A loop; each of its frames is given by a link and a pose on it."""

    name: str
    kind: str
    frames: tuple[str, str]
    axis: tuple[float, ...]


@dataclass(frozen=True)
class WrittenStrut:
    """A strut between two frames, in plain numbers."""

    name: str
    frames: tuple[str, str]
    stiffness: float
    rest: float
    damping: float
    preload: float


@dataclass(frozen=True)
class Contents:
    """A model in plain numbers, each link behind its parent, with sentences on what a format loses
    of it."""

    name: str
    links: tuple[WrittenLink, ...]
    loops: tuple[WrittenLoop, ...]
    struts: tuple[WrittenStrut, ...]
    gravity: tuple[float, float, float]
    losses: tuple[str, ...]
    joint_names: tuple[str, ...]
    """Names of the joints that move, in the order of the coordinates."""
    free: WrittenJoint | None = None
    """The joint that carries the root of a robot whose base floats."""

    def with_losses(self, more: Iterable[str]) -> Contents:
        """A copy of the contents with further losses."""
        return replace(self, losses=(*self.losses, *more))

    @property
    def joined(self) -> list[WrittenLink]:
        """The links and frames that have a parent: those that joints move in the joints' order,
        then the others."""
        place = {name: k for k, name in enumerate(self.joint_names)}
        last = len(place)
        held = (link for link in self.links if link.parent)
        return sorted(held, key=lambda link: place[link.joint.name] if link.joint else last)

    @property
    def taken(self) -> set[str]:
        """The names of all joints, fixed ones included."""
        fixed = {link.fixed for link in self.links if link.fixed}
        return fixed.union(self.joint_names)

    @property
    def parts(self) -> dict[str, WrittenLink]:
        """Links and mounted frames, by name."""
        return {link.name: link for link in self.links}


def contents_of(model: Model, holds: Holds) -> Contents:
    """The contents of a model in a format. Raises FreebodyError for a robot that the format does
    not hold at all."""
    return _Collection(model, holds).contents()


@dataclass
class _Collection:
    """The conversion of one model to what a format holds, with the losses found so far."""

    given: Model
    holds: Holds
    losses: list[str] = field(default_factory=list)
    of_joints: dict[str, list[str]] = field(default_factory=dict)
    """Names of joints by a property that all of them lose."""
    no_limits: dict[str, list[str]] = field(default_factory=dict)
    """Names of joints by a limit that the format's readers take for none."""

    def contents(self) -> Contents:
        self.given.require_values(f"save: {self.holds.name}")
        self.model = self.in_known_joints()
        self.lose_names()
        links = self.links()
        gravity = self.gravity()
        self.lose_the_rest()
        free = next((self.joint(body) for body in self.model.bodies if not body.joint.parent), None)
        if free is not None and self.holds.base:
            self.losses.append(f"the floating base: {self.holds.base}")
        loops, struts = tuple(self.loops()), self.struts()
        self.losses += [
            f"the {what} of {listed(names, _SHOWN)}" for what, names in self.of_joints.items()
        ]
        self.losses += [
            f"the {what} of {listed(names, _SHOWN)}, which {self.holds.name} takes for none"
            for what, names in self.no_limits.items()
        ]
        return Contents(
            self.model.name,
            links,
            loops,
            struts,
            gravity,
            tuple(self.losses),
            self.model.joint_names,
            free,
        )

    # ------------------------------------------------------------ what becomes another
    def in_known_joints(self) -> Model:
        """The model in space, with joints of kinds that the format lacks replaced by simpler
        ones."""
        model, known = self.given, self.holds.kinds
        if model.dim == 2:
            self.losses.append("the plane: its twin in space is written (model.to_space())")
            model = model.to_space()
        if [body for body in model.bodies if body.kind.composed and body.kind.name not in known]:
            for body in model.bodies:
                if is_taken_apart(body, euler=False):
                    self.losses.append(
                        f"the {body.kind.name} joint {body.joint.name!r}: it is written as "
                        f"{body.kind.nv} joints of one coordinate"
                    )
            model = with_single_joints(model)
        for body in model.bodies:
            if body.joint.kind not in known:
                raise FreebodyError(
                    f"save: {self.holds.name} has no {body.joint.kind} joint such as "
                    f"{body.joint.name!r} of {model.name!r}; write it as .toml, which has all."
                )
        return model

    # ------------------------------------------------------------ links
    def links(self) -> tuple[WrittenLink, ...]:
        """Links and mounted frames, each behind its parent."""
        model = self.model
        joints = {body.name: body for body in model.bodies if body.joint.parent}
        poses = {frame.name: frame.placement for frame in model.frames}
        masses = self.masses()
        others = {*model.joint_names, *(loop.name for loop in model.loops)}
        waiting: dict[str, list[WrittenLink]] = {}
        for frame in model.frames:
            body = joints.get(frame.name)
            parent = body.joint.parent if body else frame.parent
            whole = body.joint.placement if body else frame.placement
            pose = behind(poses[parent], whole) if parent else (np.eye(3), np.zeros(3))
            waiting.setdefault(parent, []).append(
                WrittenLink(
                    frame.name,
                    parent,
                    _as_tuples(*pose),
                    masses.get(frame.name),
                    self.joint(body) if body else None,
                    frame.mounted,
                    "" if frame.joint in others else frame.joint,
                )
            )
        self.losses += lost_names(others.intersection(model.fixed_joint_names))
        found = list(waiting.pop("", ()))
        for link in found:  # it grows meanwhile
            found += waiting.pop(link.name, ())
        return tuple(found)

    def masses(self) -> dict[str, Inertia]:
        """The inertia of each link in its own frame; a load's is added to the link or frame that
        carries it."""
        model = self.model
        frames = {frame.name: frame for frame in model.frames}
        parts: dict[str, list[Inertia]] = {}
        for part in (*model.base_inertias, *(a for body in model.bodies for a in body.inertias)):
            if part.load:
                if not part.inertia.numbers()[0]:
                    continue
                self.losses.append(
                    f"the load {part.link!r}: its mass counts to {self.carrier(part)!r}"
                )
            at = self.carrier(part) if part.load else part.link
            pose = behind(frames[at].placement, part.placement)
            parts.setdefault(at, []).append(part.inertia.placed(pose[0], tuple(pose[1])))
        return {
            name: found[0] if len(found) == 1 else combined(found) for name, found in parts.items()
        }

    def carrier(self, load: Attached) -> str:
        """The name of the link or frame to which a load's mass is added."""
        frames = {frame.name: frame for frame in self.model.frames}
        name = load.frame
        while frames[name].mounted:
            name = frames[name].parent
        return name

    # ------------------------------------------------------------ joints and loops
    def joint(self, body: Body) -> WrittenJoint:
        joint = body.joint
        limits = Limits(*(float(getattr(joint.limits, name)) for name in vars(Limits())))
        if not self.holds.velocity and limits.velocity != INFINITE:
            self.of_joints.setdefault("speed limit", []).append(joint.name)
            limits = replace(limits, velocity=INFINITE)
        for name, value in vars(limits).items():
            none = value == 0.0 and name in self.holds.no_zero
            if none or INFINITE > abs(value) >= self.holds.unlimited:
                self.no_limits.setdefault(f"{_LIMITS[name]} {value:g}", []).append(joint.name)
        return WrittenJoint(
            joint.name,
            joint.kind,
            tuple(map(float, joint.axis)),
            tuple(float(VALUES.quantity(x)) for x in joint.numbers),
            limits,
            self.drive(joint.name, joint.drive),
            self.mimic(joint),
            joint.passive,
        )

    def mimic(self, joint: Joint) -> Mimic | None:
        """How the joint follows another; None where the format has no place for that."""
        mimic = joint.mimic
        if mimic is not None and len(mimic.powers) >= self.holds.degree:
            self.losses.append(
                f"the polynomial by which joint {joint.name!r} follows {mimic.joint!r}: it moves "
                f"on its own"
            )
            return None
        return mimic

    def drive(self, joint: str, given: Drive) -> dict[str, float]:
        """The numbers of all drive laws of a joint, with defaults for those that the format cannot
        hold."""
        kept = {n.name: float(n.default) for law in LAWS.values() for n in law.numbers}
        for law in LAWS.values():
            numbers = {n.name: float(VALUES.quantity(getattr(given, n.name))) for n in law.numbers}
            if not numbers[law.strength] and law.name != "rotor":
                continue
            lost = [
                n.words
                for n in law.numbers
                if n.name not in self.holds.drive and numbers[n.name] != n.default
            ]
            if lost:
                self.of_joints.setdefault(listed(lost, _SHOWN), []).append(joint)
            kept |= {name: x for name, x in numbers.items() if name in self.holds.drive}
        return kept

    def loops(self) -> Iterable[WrittenLoop]:
        for loop in self.model.loops:
            if loop.kind in self.holds.loops:
                yield WrittenLoop(loop.name, loop.kind, loop.frames, tuple(map(float, loop.axis)))
            else:
                self.losses.append(f"the {loop.kind} loop {loop.name!r}, which is left open")

    def struts(self) -> tuple[WrittenStrut, ...]:
        struts = self.model.struts
        if struts and not self.holds.struts:
            s = "s" if len(struts) > 1 else ""
            self.losses.append(f"the strut{s} {listed([x.name for x in struts], _SHOWN)}")
            return ()
        return tuple(
            WrittenStrut(
                x.name,
                x.frames,
                *(float(VALUES.quantity(n)) for n in (x.stiffness, x.rest, x.damping, x.preload)),
            )
            for x in struts
        )

    # ------------------------------------------------------------ what is lost
    def gravity(self) -> tuple[float, float, float]:
        x, y, z = map(float, self.model.gravity)
        if not self.holds.gravity and (x, y, z) != (0.0, 0.0, -STANDARD_GRAVITY):
            self.losses.append(
                f"gravity ({x:g}, {y:g}, {z:g}): readers take {STANDARD_GRAVITY} m/s² along -z"
            )
        return x, y, z

    def lose_names(self) -> None:
        """Record the loss of the parameters' names and formulas; gravity's name is not counted,
        since readers restore it."""
        model = self.given
        gravity = {p.name for p in each_parameter(model.gravity_size)} & {"g"}
        names = [name for name in model.parameters if name not in gravity]
        if names:
            self.losses.append(
                f"the names {listed(names, _SHOWN)} of its numbers; their values are written"
            )
        if model.formulas:
            told = listed([formula.name for formula in model.formulas], _SHOWN)
            self.losses.append(f"the formulas of {told}")

    def lose_the_rest(self) -> None:
        model, holds = self.model, self.holds
        passive = [body.joint.name for body in model.bodies if body.joint.passive]
        if passive and not (holds.passive and self.motors_tell()):
            has = "has" if len(passive) == 1 else "have"
            self.losses.append(f"that {listed(passive, _SHOWN)} {has} no motor")
        joints = [body.joint for body in model.bodies]
        if model.tip and not holds.keeps_tip and chosen(model, None, joints).frame != model.tip:
            self.losses.append(
                f"that {model.tip!r} is the tip: give tip={model.tip!r} when loading"
            )
        if model.home:
            self.losses.append("the positions of [home], from which loops are closed")
        if model.loop_tolerance is not None:
            self.losses.append("the tolerance of its loops")
        self.losses += [f"the doubt that {_begun(doubt.clause)}" for doubt in read_doubts(model)]

    def motors_tell(self) -> bool:
        """Whether a written file shows by its motors which joints are passive: it has loops and at
        least one motor."""
        kept = [loop for loop in self.model.loops if loop.kind in self.holds.loops]
        return bool(kept and self.model.actuated)


def _begun(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:]


def behind(outer: Placement, whole: Placement) -> ArrayPose:
    """The rotation and position of a frame in another one, from both placements in the same
    body."""
    steps = outer.steps
    if whole.steps[: len(steps)] == steps:  # as they were written, without rounding
        return Placement(whole.steps[len(steps) :]).arrays()
    return seen_from(outer.arrays(), whole.arrays())


def _as_tuples(R: np.ndarray, p: np.ndarray) -> Pose:
    return tuple(tuple(map(float, row)) for row in R), tuple(map(float, p))


def lost_names(fixed: Iterable[str]) -> list[str]:
    """The sentence on lost names of fixed joints; none where there are none."""
    names = sorted(fixed)
    if not names:
        return []
    s = "s" if len(names) > 1 else ""
    return [f"the name{s} of the fixed joint{s} {listed(names, _SHOWN)}"]


def fixed_name(link: str, taken: set[str]) -> str:
    """A new name for the fixed joint of a link, for models that keep none."""
    name = f"{link}_joint"
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def checked_names(contents: Contents, format_name: str) -> None:
    """Refuse names that XML does not keep."""
    names = [link.name for link in contents.links]
    names += [link.joint.name if link.joint else link.fixed for link in contents.links]
    names += [part.name for part in (*contents.loops, *contents.struts)]
    for name in (contents.name, *names):
        kept_name(name, format_name)


def checked_ground(contents: Contents, format_name: str) -> None:
    """Refuse a link or frame with the name of the ground that is not the fixed root."""
    others = contents.links if contents.free else contents.links[1:]
    if any(link.name == GROUND for link in others):
        raise FreebodyError(
            f"save: in {format_name} {GROUND!r} is the ground, and no other link or frame; rename "
            f"that of {contents.name!r}."
        )


def kept_name(name: str, format_name: str) -> str:
    """The name itself where XML keeps it; else an error is raised."""
    if _OUTSIDE_XML.search(name) or name != name.strip():
        raise FreebodyError(
            f"save: {name!r} is no name in {format_name}, which is XML: remove control "
            f"characters and blanks around it."
        )
    return name
