"""Findings on masses and inertias by themselves: what no rigid body has, placeholders, units, the
point and the axes that they are about, and twins that differ."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.diagnosis.facts import LinkFacts, RobotFacts, norm
from freebody.diagnosis.finding import AttributeChange, FindingKind, FoundFault
from freebody.diagnosis.urdf_facts import TENSOR
from freebody.errors import listed
from freebody.model.doubt_rules.inertias import MEASURED, excess, unfelt_links
from freebody.model.inertia import Inertia

_SAME = 0.05
"""Relative difference of left and right that is none."""
_HEAVY = 2000.0
"""kg for each square of the reach in m: more than any robot moves."""
_TINY = 0.002
"""Share of the robot's mass that is passed over: sensors and frames have placeholders."""
_FAR = 100.0
"""m that no robot reaches."""
_THIN = 1e-6
"""Second moment that a mended inertia keeps, as a share of the largest."""
_TYPICAL = 0.3
"""Radius of gyration of a link, as a share of its size."""
_UNITS = {1e4: "kg cm²", 1e6: "kg mm²", 1e7: "g cm²", 1e9: "g mm²"}
"""Units that inertias are exported in, by how many of them are a kg m²."""


class _Weighed(NamedTuple):
    """A moving link with mass: mass, centre of mass and inertia tensor in the link's axes, second
    moments about the centre of mass, and the link's size (m)."""

    link: LinkFacts
    mass: float
    com: Array
    tensor: Array
    second: Array
    size: float

    @property
    def gyration(self) -> float:
        """The largest radius of gyration, m."""
        return float(np.sqrt(max(np.linalg.eigvalsh(self.tensor)[-1], 0.0) / self.mass))


def _weighed(facts: RobotFacts) -> list[_Weighed]:
    found = []
    for link in facts.moving:
        inertia = link.inertia
        if inertia is None or inertia.dim != 3 or not inertia.numbers()[0] > 0.0:
            continue
        mass, com, tensor = inertia.numbers()
        if tensor.any():
            second = 0.5 * np.trace(tensor) * np.eye(3) - tensor
            found.append(_Weighed(link, mass, com, tensor, second, _size(facts, link.name)))
    return found


def _size(facts: RobotFacts, name: str) -> float:
    """How far a link extends from its origin (m), judged by the joints that it carries and by its
    shapes."""
    ends = [norm(x.pose[1]) for x in facts.joints if x.parent == name and x.pose is not None]
    link = facts.link[name]
    shapes = [norm(shape.placement.arrays()[1]) + shape.radius for shape in link.shapes]
    return max([*ends, *shapes], default=0.0)


def _written(facts: RobotFacts) -> Iterator[tuple[LinkFacts, Inertia]]:
    for link in facts.links:
        if link.inertia is not None:
            yield link, link.inertia


def _faulty(facts: RobotFacts) -> Iterator[tuple[LinkFacts, str, bool]]:
    """Links with inertias that no rigid body has, the reason, and whether it matters: the triangle
    inequality is broken by more than measurements would, and some motion feels it."""
    unfelt = unfelt_links(facts.model) if facts.model and not facts.model.missing else set()
    for link, inertia in _written(facts):
        fault = inertia.fault()
        if fault:
            mass, _, tensor = inertia.numbers()
            off = mass < 0.0 or excess(tensor) > MEASURED
            yield link, fault, off and (mass < 0.0 or link.name not in unfelt)


def _impossible(facts: RobotFacts) -> Iterator[FoundFault]:
    for link, fault, matters in _faulty(facts):
        if matters:
            remedy = "correct its mass" if fault.startswith("mass") else ""
            reason = f"link {link.name!r}: {fault}"
            yield FoundFault(reason, link.inertia_line, _nearest(link), remedy)


def _nearest(link: LinkFacts) -> tuple[AttributeChange, ...]:
    """Changes that replace an inertia tensor by the nearest one of a rigid body, with positive
    second moments; empty where the mass or the whole tensor is wrong."""
    written = link.inertial
    element = (
        next(iter(written.element.all("inertia")), None) if written and written.element else None
    )
    if written is None or written.inertia is None or element is None:
        return ()
    mass, _, tensor = written.inertia.numbers()
    moments, axes = np.linalg.eigh(0.5 * np.trace(tensor) * np.eye(3) - tensor)
    if mass <= 0.0 or moments[-1] <= 0.0:
        return ()
    second = axes @ np.diag(np.maximum(moments, _THIN * moments[-1])) @ axes.T
    mended = np.trace(second) * np.eye(3) - second
    given = mended[np.triu_indices(3)].tolist()
    return tuple(
        AttributeChange(element, key, f"{x:.9g}")
        for key, x, was in zip(TENSOR, given, tensor[np.triu_indices(3)].tolist(), strict=True)
        if abs(x - was) > 1e-9 * moments[-1]
    )


def _inexact(facts: RobotFacts) -> Iterator[FoundFault]:
    for link, fault, matters in _faulty(facts):
        if not matters:
            yield FoundFault(f"link {link.name!r}: {fault}", link.inertia_line)


def _no_mass(facts: RobotFacts) -> Iterator[FoundFault]:
    for link, inertia in _written(facts):
        mass, _, tensor = inertia.numbers()
        if mass == 0.0 and tensor.any():
            reason = f"link {link.name!r} has moments of inertia, and a mass of 0"
            yield FoundFault(reason, facts.line_of(link.name))


def _no_inertia(facts: RobotFacts) -> Iterator[FoundFault]:
    """Findings of masses without moments of inertia, unless it is a person who wrote that: tools
    that export a robot write zeros for what they do not know."""
    whole = sum(max(x.numbers()[0], 0.0) for _, x in _written(facts))
    for link in facts.moving:
        if link.inertia is None or link.inertia.dim != 3 or link.stated:
            continue
        mass, com, tensor = link.inertia.numbers()
        lumped = facts.above[link.name].kind == "fixed" and not com.any()
        if mass > 0.01 * whole and not tensor.any() and not lumped and _turns(facts, link.name):
            reason = f"link {link.name!r} has a mass of {mass:g} kg and no moment of inertia"
            yield FoundFault(reason, facts.line_of(link.name))


def _turns(facts: RobotFacts, name: str) -> bool:
    """Whether a link can turn, and does not only slide: its moments of inertia count."""
    seen = set[str]()
    while (joint := facts.above.get(name)) and name not in seen:
        if joint.kind != "fixed" and (joint.turns or not joint.moves):
            return True
        seen.add(name)
        name = joint.parent
    return False


def _plain(facts: RobotFacts) -> Iterator[FoundFault]:
    for body in _weighed(facts):
        diagonal = np.diag(body.tensor)
        alike = (body.tensor == np.diag(diagonal)).all() and (diagonal == diagonal[0]).all()
        plain = _is_power(body.mass) and _is_power(float(diagonal[0]))
        if alike and plain and body.mass > _TINY * facts.mass:
            reason = f"link {body.link.name!r} has {body.mass:g} kg and {diagonal[0]:g} kg m²"
            yield FoundFault(f"{reason} about all axes, a placeholder", body.link.inertia_line)


def _is_power(x: float) -> bool:
    """Whether a number is a power of ten, as placeholders are."""
    text = f"{x:.0e}"
    return text[0] == "1" and float(text) == x


def _units(facts: RobotFacts) -> Iterator[FoundFault]:
    if facts.reach > _FAR:
        yield FoundFault(f"the joints reach {facts.reach:.3g} m, as though lengths were in mm")
        return
    mass = sum(body.mass for body in _weighed(facts))
    bodies = [body for body in _weighed(facts) if body.size > 0.0 and body.mass > 0.01 * mass]
    if mass > _HEAVY * max(facts.reach, 0.1) ** 2 and mass > 1000.0:
        reason = (
            f"{mass:.4g} kg move, at a reach of {facts.reach:.3g} m, as though masses were in g"
        )
        yield FoundFault(reason)
    if len(bodies) < 2:
        return
    share = float(np.median([body.gyration / body.size for body in bodies]))
    if 0.03 < share < 4.0 or share == 0.0:
        return
    many = (share / _TYPICAL) ** 2
    unit = min(_UNITS, key=lambda x: abs(np.log10(many / x)))
    about = f", as though in {_UNITS[unit]}" if many > 1e3 else ""
    small = "small" if share < 1.0 else "large"
    reason = f"the links' radii of gyration are {share:.2g} times their size"
    yield FoundFault(f"{reason}: their moments of inertia are too {small} for their masses{about}")


def _about_origin(facts: RobotFacts) -> Iterator[FoundFault]:
    bodies = [
        body
        for body in _weighed(facts)
        if norm(body.com) > 0.3 * body.gyration and body.size and not body.link.filled
    ]
    shares = []
    for body in bodies:
        rest = body.second - body.mass * np.outer(body.com, body.com)
        largest = float(np.linalg.eigvalsh(body.second)[-1])
        if np.linalg.eigvalsh(rest)[0] < -0.02 * largest:
            return
        along = body.com / norm(body.com)
        shares.append(body.mass * norm(body.com) ** 2 / float(along @ body.second @ along))
    if len(bodies) >= 3 and np.mean(np.array(shares) > 0.45) >= 0.6:
        yield FoundFault(
            f"the inertias of {listed([b.link.name for b in bodies], 4)} are such as about the "
            f"links' origins, not their centres of mass",
            bodies[0].link.inertia_line,
        )


def _turned(facts: RobotFacts) -> Iterator[FoundFault]:
    """Long links whose mass, by the file's own numbers, lies across the way to the next joint."""
    for body in _weighed(facts):
        if body.link.filled:
            continue
        ends = [
            joint.pose[1]
            for joint in facts.joints
            if joint.parent == body.link.name and joint.pose is not None and joint.kind != "fixed"
        ]
        if len(ends) != 1 or norm(ends[0]) < 0.1 * facts.reach:
            continue
        length = norm(ends[0])
        along = ends[0] / length
        across = np.linalg.eigvalsh((np.eye(3) - np.outer(along, along)) @ body.second)[-1]
        own, other = (
            np.sqrt(max(float(x), 0.0) / body.mass) / length
            for x in (along @ body.second @ along, across)
        )
        if own < 0.11 and other > 0.22 and other > 2.5 * own:
            yield FoundFault(
                f"link {body.link.name!r} is {length:.3g} m long to its next joint, and its "
                f"inertia is that of a body which lies across",
                body.link.inertia_line,
            )


# ------------------------------------------------------------ left and right
_SIDES = {"left": "right", "l": "r", "fl": "fr", "rl": "rr", "lf": "rf", "lh": "rh", "hl": "hr",
          "bl": "br", "lb": "rb", "lr": "rr"}  # fmt: skip
_OTHER_SIDE = _SIDES | {right: left for left, right in _SIDES.items()}


def twins(facts: RobotFacts, names: list[str]) -> Iterator[tuple[str, str]]:
    """Pairs of names that differ in left and right alone, the left one first: in all their words
    for sides, as mirror images do, else in one."""
    known = set(names)
    for name in names:
        parts = re.split(r"(_|(?<=[a-z])(?=[A-Z])|(?<=\d)|(?=\d))", name)
        parts = [x for x in parts if x]
        sides = [k for k, part in enumerate(parts) if part.lower() in _OTHER_SIDE]
        lefts = [k for k in sides if parts[k].lower() in _SIDES]
        mirrored = _changed(parts, sides)
        found = [_changed(parts, [k]) for k in lefts]
        if len(sides) > 1 and mirrored in known:
            found = [mirrored] if lefts[:1] == sides[:1] else []
        yield from [(name, twin) for twin in found if twin in known and twin != name][:1]


def _changed(parts: list[str], sides: list[int]) -> str:
    """The name with the words at these places for the other side."""
    return "".join(_other(part) if k in sides else part for k, part in enumerate(parts))


def _other(part: str) -> str:
    """The word for the other side, in the same case."""
    other = _OTHER_SIDE[part.lower()]
    if part.isupper():
        return other.upper()
    return other.capitalize() if part.istitle() and len(part) > 1 else other


def _twins(facts: RobotFacts) -> Iterator[FoundFault]:
    for left, right in twins(facts, [link.name for link in facts.links]):
        a, b = facts.link[left].inertia, facts.link[right].inertia
        if a is None or b is None or a.dim != 3 or not (a.numbers()[0] > 0 and b.numbers()[0] > 0):
            continue
        for what, x, y in _invariants(a, b):
            size = max(float(np.abs([x, y]).max()), 1e-300)
            if float(np.abs(np.subtract(x, y)).max()) > _SAME * size:
                yield FoundFault(
                    f"links {left!r} and {right!r} are left and right, and differ in their {what}",
                    facts.line_of(right),
                )
                break


def _invariants(a: Inertia, b: Inertia) -> Iterator[tuple[str, Array, Array]]:
    """The names and values, for both of two bodies, of numbers that mirrored bodies have in
    common."""
    (m, c, S), (n, d, T) = a.numbers(), b.numbers()
    yield "masses", np.array([m]), np.array([n])
    size = np.sqrt(max(float(np.trace(S)), 0.0) / m) + norm(c)
    yield "centres of mass", np.array([norm(c) + size]), np.array([norm(d) + size])
    yield "moments of inertia", np.linalg.eigvalsh(S), np.linalg.eigvalsh(T)
    far = norm(c) ** 2 * float(np.linalg.eigvalsh(S)[-1])
    along = [float(x @ A @ x) + far for x, A in ((c, S), (d, T))]
    yield "axes of inertia", np.array(along[:1]), np.array(along[1:])


IMPOSSIBLE = FindingKind("impossible inertia", "error", "correct its inertia", _impossible)
INEXACT = FindingKind("inexact inertia", "notice", "it is used as given", _inexact)
NO_MASS = FindingKind("mass of 0", "warning", "give its mass", _no_mass)
NO_INERTIA = FindingKind("point mass", "warning", "give its moments of inertia", _no_inertia)
PLAIN = FindingKind("placeholder inertia", "warning", "give its own numbers", _plain)
UNITS = FindingKind("wrong units", "warning", "give kg, m and kg m²", _units)
ABOUT_ORIGIN = FindingKind(
    "inertia about the origin", "warning", "give those about the centres of mass", _about_origin
)
TURNED = FindingKind(
    "inertia in wrong axes", "warning", "give it in the axes of its <origin>", _turned
)
TWINS = FindingKind("left and right differ", "warning", "correct the wrong one", _twins)
