"""Findings on names, and on which link hangs on which."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from freebody.diagnosis.facts import JointFacts, LinkFacts, RobotFacts, elements_in
from freebody.diagnosis.finding import AttributeChange, FindingKind, FoundFault
from freebody.errors import did_you_mean, likely, listed
from freebody.model.refusal_rules import DUPLICATE, UNNAMED, NameRule, unknown_ends

_ODD = re.compile(r"[^\w.:/+-]+")
"""Characters that names of ROS, of simulators and of generated code do not take."""


def _parts(facts: RobotFacts) -> tuple[tuple[str, Sequence[LinkFacts | JointFacts]], ...]:
    return ("link", facts.links), ("joint", facts.joints)


def _breaking(rule: NameRule) -> Callable[[RobotFacts], Iterator[FoundFault]]:
    """A finder of the links and joints whose names break a rule."""

    def find(facts: RobotFacts) -> Iterator[FoundFault]:
        for what, parts in _parts(facts):
            names = [part.name for part in parts]
            for i in rule.broken(names):
                yield FoundFault(rule.said(what, names[i]), parts[i].line)

    return find


def _odd(facts: RobotFacts) -> Iterator[FoundFault]:
    taken = {part.name for _, parts in _parts(facts) for part in parts}
    for what, parts in _parts(facts):
        for part in parts:
            raw = part.element.attributes.get("name", "") if part.element else part.name
            if not _ODD.search(raw) or not part.name:
                continue
            new = _ODD.sub("_", part.name)
            changes = () if new in taken else tuple(_renamed(facts, what, part.name, new))
            yield FoundFault(f"the name of {what} {raw!r} has characters that few programs take",
                        part.line, changes, f"call it {new!r}")  # fmt: skip


def _renamed(facts: RobotFacts, what: str, name: str, new: str) -> Iterator[AttributeChange]:
    """The changes that rename a link or joint at every place where it is named."""
    if facts.root is None:
        return
    for element in elements_in(facts.root):
        given = {key: value.strip() for key, value in element.attributes.items()}
        if element.tag == what and given.get("name") == name:
            yield AttributeChange(element, "name", new)
        key = "reference" if element.tag == "gazebo" else what
        if element.tag in ("parent", "child", "mimic", "gazebo") and given.get(key) == name:
            yield AttributeChange(element, key, new)


def _unknown_link(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        for end, name in unknown_ends(joint, facts.link):
            if not name:
                yield FoundFault(f"joint {joint.name!r} has no {end}", joint.line)
                continue
            yield FoundFault(
                f"the {end} of joint {joint.name!r} is {name!r}, and no link is called so",
                joint.line,
                remedy=did_you_mean(likely(name, facts.link)),
            )
        if joint.mimics and (joint.mimics not in facts.joint or joint.mimics == joint.name):
            yield FoundFault(
                f"joint {joint.name!r} follows {joint.mimics!r}, which is no other joint",
                joint.line,
                remedy=did_you_mean(likely(joint.mimics, facts.joint)) or "name another joint",
            )


def _two_joints(facts: RobotFacts) -> Iterator[FoundFault]:
    first: dict[str, JointFacts] = {}
    for joint in facts.joints:
        other = first.setdefault(joint.child, joint)
        if other is not joint and joint.child in facts.link:
            reason = f"link {joint.child!r} hangs on two joints, {other.name!r} and {joint.name!r}"
            yield FoundFault(reason, joint.line)


def _apart(facts: RobotFacts) -> Iterator[FoundFault]:
    """Findings of links that no joint connects to the base, and of links that hang on each other in
    a circle, without a base."""
    children: dict[str, list[str]] = {}
    for joint in facts.joints:
        children.setdefault(joint.parent, []).append(joint.child)

    def below(name: str) -> set[str]:
        found, waiting = {name}, [name]
        while waiting:
            fresh = set(children.get(waiting.pop(), ())) - found
            found |= fresh
            waiting += fresh
        return found

    known = {joint.child for joint in facts.joints if joint.parent in facts.link}
    roots = [link for link in facts.links if link.name not in known]
    if facts.links and not roots:
        yield FoundFault("the links form a circle, and none is the base", facts.joints[0].line)
        return
    trees = sorted(((below(x.name), x) for x in roots), key=lambda pair: -len(pair[0]))
    reached = {name for tree, _ in trees for name in tree}
    for tree, root in trees[1:]:
        if root.name in facts.above:  # its joint names no link, which is a finding of its own
            continue
        with_it = f", with {listed(sorted(tree - {root.name}), 4)}" if len(tree) > 1 else ""
        yield FoundFault(f"link {root.name!r} hangs on no joint{with_it}", root.line)
    for link in facts.links:
        if link.name not in reached:
            yield FoundFault(f"link {link.name!r} is in a circle of links", link.line)


def _no_tip(facts: RobotFacts) -> Iterator[FoundFault]:
    model = facts.model
    if model is not None and model.tip is None and model.bodies:
        yield FoundFault(f"no frame is the only tip: {listed(model.leaves, 6)} are ends")


NO_NAME = FindingKind("no name", "error", UNNAMED.remedy, _breaking(UNNAMED))
SAME_NAME = FindingKind("duplicate name", "error", DUPLICATE.remedy, _breaking(DUPLICATE))
ODD = FindingKind("odd name", "warning", "rename it", _odd)
UNKNOWN_LINK = FindingKind("unknown name", "error", "name one that exists", _unknown_link)
TWO_JOINTS = FindingKind("two joints", "error", "remove one, or make it a loop", _two_joints)
APART = FindingKind("not connected", "error", "connect it by a joint, or remove it", _apart)
NO_TIP = FindingKind("no tip", "notice", "call the tip tool0 or tcp, or give tip=", _no_tip)
