"""Changes of the correct answer by what was forgotten: parameters that are set to 0 in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import dataclass
from typing import NamedTuple

from freebody.errors import listed
from freebody.expressions.printed_names import sym
from freebody.model.parameters import each_parameter
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reasons.thoughts import Changed, Subject, each_and_all


class Forgotten(NamedTuple):
    """Parameters that may have been forgotten, with values for the places of the sentence."""

    said: Mapping[str, object]
    names: Set[str]
    remembered: Set[str] = frozenset()
    """Parameters of which, where the correct answer has some, the user's must have one."""

    def explains(self, right: Set[str], written: Set[str]) -> bool:
        """Whether an answer with the symbols `written` has one of those that are remembered,
        unless the correct one, with the symbols `right`, has none."""
        return right.isdisjoint(self.remembered) or not written.isdisjoint(self.remembered)


@dataclass(frozen=True)
class Without:
    """Change: parameters set to 0, as if their effects were forgotten. `groups` gives sets of
    them."""

    groups: Callable[[RightEquations], Iterator[Forgotten]]

    def __call__(self, x: Subject) -> Iterator[Changed]:
        for group in self.groups(x.setting):
            left = (powers for powers, _ in x.rows if group.names.isdisjoint(powers))
            if group.names & x.names and group.explains(x.names, set[str]().union(*left)):
                yield group.said, x.at(dict.fromkeys(group.names, 0))


def of_weights(setting: RightEquations) -> Iterator[Forgotten]:
    """The group of the gravity symbol, which stands for all weights."""
    if setting.order.gravity:
        yield Forgotten({}, {setting.order.gravity})


def of_bodies(setting: RightEquations) -> Iterator[Forgotten]:
    """Groups of mass and inertia of one body, or of a body and all bodies that it carries."""
    model, inertial = setting.symbols.model, setting.order.inertial
    heavy, every = {body for body, _ in inertial.values()}, range(len(model.bodies))
    carried = {i: {i} for i in every}
    for i in reversed(every):
        if model.bodies[i].parent in carried:
            carried[model.bodies[i].parent] |= carried[i]
    for group in [{i} for i in sorted(heavy)] + [carried[i] & heavy for i in every]:
        if group != heavy:
            links = listed(str(model.bodies[i].name) for i in sorted(group))
            names = {name for name, (i, _) in inertial.items() if i in group}
            yield Forgotten({"links": links}, names)


def of_moments(setting: RightEquations) -> Iterator[Forgotten]:
    """The group of all moments of inertia, as if bodies were point masses, and each body's."""
    inertial, every = setting.order.inertial, moments_of_inertia(setting)
    moments = "The moments of inertia about the centres of mass are"
    yield Forgotten({"moments": moments, "points": "point masses"}, every)
    for i, body in enumerate(setting.symbols.model.bodies):
        names = {name for name in every if inertial[name][0] == i}
        one = f"The moment of inertia of {body.name} about its centre of mass is"
        if names and names != every:
            yield Forgotten({"moments": one, "points": "a point mass"}, names)


def moments_of_inertia(setting: RightEquations) -> set[str]:
    """The names of all moments of inertia."""
    return {name for name, (_, kind) in setting.order.inertial.items() if kind == 1}


def of_centres(setting: RightEquations) -> Iterator[Forgotten]:
    """Groups of what places one body's centre of mass and no joint or frame, or all bodies'. Their
    masses are remembered: else these, not their places, were forgotten."""
    model, inertial = setting.symbols.model, setting.order.inertial
    placements = (*(x.joint.placement for x in model.bodies), *(x.placement for x in model.frames))
    elsewhere = {x.name for x in each_parameter(placements)}
    rows = list[tuple[int, set[str]]]()
    for i, body in enumerate(model.bodies):
        if setting.is_planar and body.kind.slides:
            continue  # the displacement may be to its centre of mass: `slides`
        centres = tuple(part.inertia.com for part in body.inertias)
        if names := {x.name for x in each_parameter(centres)} - elsewhere:
            rows.append((i, names))
    for group in each_and_all(rows):
        names = set[str]().union(*(own for _, own in group))
        masses = {name for name, (i, kind) in inertial.items() if not kind and i in dict(group)}
        several = len(group) > 1
        said = {
            "zero": listed(f"{sym(name)} = 0" for name in sorted(names)),
            "centres": "the centres of mass" if several else "the centre of mass",
            "links": listed(model.bodies[i].name for i, _ in group),
            "are": "are not at their joints" if several else "is not at its joint",
        }
        yield Forgotten(said, names, masses)
