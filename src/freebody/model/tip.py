"""The tip of a robot: the frame that `frame=None` stands for everywhere.

The first of four rules that says one: (1) the frame that was asked for, or that the robot's
description names; (2) the only frame that is called as `CONVENTIONS` has it, in their order; (3)
grippers taken off, the end of the chain of most movable joints, where only one is so long; (4)
none. What a gripper is, `_TreeBranches.fingers` says.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from math import isclose
from typing import TYPE_CHECKING

from freebody.errors import listed
from freebody.model.bodies import Body, Frame
from freebody.model.description import TIP, Joint, Notice
from freebody.model.named_parts import NamedParts
from freebody.model.parameters import Quantity
from freebody.model.tree import parents_first
from freebody.outputs.display import counted

if TYPE_CHECKING:
    from freebody.model.model import Model

CONVENTIONS = {
    "tcp": "tcp|tool_cent(er|re)_point",
    "tool0": "tool_?0",
    "flange": "flange",
    "ee…": "(ee|eef|end_?effector)(_.*)?",
    "grasp… or gripper_frame": "grasp.*|gripper_frame",
}
"""Names of the frame that a tool or a load is mounted on or held in: whole words, with any words in
front, and link or frame behind."""
_ALIKE = 0.01
"""Share by which numbers of two equal fingers may differ: those of files are rounded."""
_SHOWN = 8
"""Number of candidates that are named."""


@dataclass(frozen=True)
class ChosenTip:
    """The tip's frame, None where there is none, and a sentence on the rule that chose it."""

    frame: str | None
    reason: str

    @property
    def notice(self) -> Notice:
        """The sentence on the choice, as a notice of the model."""
        return Notice(TIP, self.reason)


def with_tip(model: Model, tip: ChosenTip) -> Model:
    """The model with another tip, which its notices report."""
    frame = None if tip.frame is None else model.frame(tip.frame).name
    notices = (notice for notice in model.notices if notice.kind != TIP)
    return replace(model, tip=frame, notices=(*notices, tip.notice))


def requested_tip(frame: str) -> ChosenTip:
    """The tip that a caller names, with the sentence that says so."""
    return ChosenTip(frame, f"The tip is {frame!r}, as asked.")


def chosen(parts: NamedParts, described: str | None, joints: Iterable[Joint]) -> ChosenTip:
    """The tip where no caller names one. described: the tip of the robot's description; joints: as
    described, with mimics that the model may have set free."""
    if described is not None:
        return ChosenTip(described, f"The tip is {described!r}, as the robot's description says.")
    return _by_name(parts) or _by_chain(parts, joints)


def left_by(locked: Collection[str], whole: NamedParts, rest: NamedParts) -> ChosenTip:
    """The tip of what is left of a robot that had no single one when some joints are locked.

    rest: the robot with these joints locked. Its frames are those of the whole robot, which alone
    tells what is a gripper.
    """
    joints = [body.joint for body in whole.bodies]
    return _by_name(rest) or _by_chain(whole, joints, locked)


# ---------------------------------------------------------------- by names
def _by_name(parts: NamedParts) -> ChosenTip | None:
    moving = [(frame.name, _words(frame.name)) for frame in parts.frames if frame.body >= 0]
    for called, words in CONVENTIONS.items():
        pattern = re.compile(f"(.*_)?({words})(_(link|frame))?")
        found = [name for name, spelled in moving if pattern.fullmatch(spelled)]
        if len(found) == 1:
            return ChosenTip(found[0], f"The tip is {found[0]!r}, the only frame called {called}.")
    return None


def _words(name: str) -> str:
    """The words of a name in lower case, joined by underscores: rightEndEffector becomes
    right_end_effector."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    return re.sub(r"[^a-z0-9]+", "_", apart.lower()).strip("_")


# ---------------------------------------------------------------- by the tree
def _by_chain(
    parts: NamedParts, joints: Iterable[Joint], locked: Collection[str] = ()
) -> ChosenTip:
    """The end of the longest chain, in which joints that are locked do not count."""
    tree = _TreeBranches(parts, joints)
    fingers = {k for at in (-1, *range(len(parts.bodies))) for k in tree.fingers(at)}
    lengths = {-1: 0}
    for k in tree.order:
        above = parts.bodies[k].parent
        if above in lengths and k not in fingers:
            lengths[k] = lengths[above] + (parts.bodies[k].joint.name not in locked)
    most = max(lengths.values())
    farthest = [k for k, length in lengths.items() if length == most]
    ends = sorted({_outermost(tree, k, farthest) for k in farthest})
    length = counted(most, "movable joint")
    if all(body.joint.name in locked for body in parts.bodies):
        return _none("nothing moves", ())
    if most == 0:
        return _none("nothing moves but equal branches of one joint", parts.leaves)
    frames = [_end(parts, k, fingers) for k in ends]
    if len(frames) > 1:
        return _none(f"{len(frames)} chains have {length} each, the most", frames)
    off = [parts.bodies[k].joint.name for k in sorted(fingers) if parts.bodies[k].parent == ends[0]]
    gripper = f"; the gripper behind it ({listed(off, _SHOWN)}) does not count" if off else ""
    (frame,) = frames
    return ChosenTip(
        frame, f"The tip is {frame!r}, the end of the longest chain of joints ({most}){gripper}."
    )


def _outermost(tree: _TreeBranches, k: int, among: Collection[int]) -> int:
    """The last body of those that hang on a body one by one, by locked joints, of some bodies."""
    while len(behind := [j for j in tree.carried.get(k, ()) if j in among]) == 1:
        k = behind[0]
    return k


def _none(why: str, candidates: Sequence[str]) -> ChosenTip:
    names = f" Candidates: {listed(candidates, _SHOWN)}." if candidates else ""
    return ChosenTip(None, f"No tip is chosen: {why}.{names}")


class _TreeBranches:
    """The branches of a robot's tree: the bodies that each body carries, and for each branch its
    length and whether all its joints are coupled."""

    def __init__(self, parts: NamedParts, joints: Iterable[Joint]):
        self.bodies = parts.bodies
        self.carried: dict[int, list[int]] = {}
        for k, body in enumerate(self.bodies):
            self.carried.setdefault(body.parent, []).append(k)
        self.order = parents_first(self.bodies)
        followers = [joint for joint in joints if joint.mimic is not None]
        in_step = {joint.name for joint in followers}
        in_step |= {name for x in followers if x.mimic for name, _ in x.mimic.terms}
        self.length = dict.fromkeys(self.order, 1)
        self.coupled = {k: self.bodies[k].joint.name in in_step for k in self.order}
        for k in reversed(self.order):
            if (above := self.bodies[k].parent) >= 0:
                self.length[above] = max(self.length[above], 1 + self.length[k])
                self.coupled[above] = self.coupled[above] and self.coupled[k]

    def fingers(self, palm: int) -> list[int]:
        """The first bodies of the fingers of a gripper on a body; empty where there are none.

        Fingers are branches whose joints all follow one another (mimics and their leaders), of
        which two are the longest, with what else there is no longer than they, such as a gear; or
        two or more equal branches of one joint. So a parallelogram along an arm is none, whose bars
        are shorter than what the arm carries, nor is a telescope.
        """
        branches = self.carried.get(palm, [])
        lengths = sorted(self.length[k] for k in branches if self.coupled[k])
        if len(lengths) > 1 and lengths[-1] == lengths[-2]:
            return [k for k in branches if self.length[k] <= lengths[-1]]
        single = [k for k in branches if self.length[k] == 1]
        return [
            k
            for k in single
            if any(k != j and _alike(self.bodies[k], self.bodies[j]) for j in single)
        ]


def _alike(one: Body, other: Body) -> bool:
    """Whether two bodies are equal fingers: the same kind of joint with the same range, perhaps
    mirrored, and the same masses."""
    own, its = one.joint.limits, other.joint.limits
    ranges = (its.lower, its.upper), (-its.upper, -its.lower)
    return (
        one.joint.kind == other.joint.kind
        and any(_close(own.lower, low) and _close(own.upper, high) for low, high in ranges)
        and len(one.inertias) == len(other.inertias)
        and all(
            _close(a.inertia.mass, b.inertia.mass)
            for a, b in zip(one.inertias, other.inertias, strict=True)
        )
    )


def _close(a: Quantity, b: Quantity) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return isclose(a, b, rel_tol=_ALIKE)
    return a == b


def _end(parts: NamedParts, at: int, fingers: set[int]) -> str:
    """The name of the frame at the end of a body: outward from the link that carries its gripper,
    else from its own frame, as long as fixed frames do not fork. A frame that only a strut uses is
    no end."""
    pulled = {name for strut in parts.struts for name in strut.frames}
    pulled -= {frame.parent for frame in parts.frames}
    fixed: dict[str, list[Frame]] = {}
    for frame in parts.frames:
        if frame.body == at and not (frame.mounted and frame.name in pulled):
            fixed.setdefault(frame.parent, []).append(frame)
    palms = {parts.bodies[k].joint.parent for k in fingers if parts.bodies[k].parent == at}
    name = palms.pop() if len(palms) == 1 else fixed[""][0].name
    while len(fixed.get(name, ())) == 1:
        name = fixed[name][0].name
    return name
