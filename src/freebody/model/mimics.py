"""Mimic joints, which follow other joints, and the independent joints that each follows in the end.

A joint follows another by a polynomial of its position, most often a linear one. A joint that
follows several is built as several joints on one axis, each of which follows one: their turns, or
shifts, add up, and what lies between has no mass.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NoReturn, Protocol

import numpy as np

from freebody.errors import IncludedLine, ModelError, UnknownNameError
from freebody.model.joints import KINDS
from freebody.model.parameters import finite
from freebody.model.placement import Placement

if TYPE_CHECKING:
    from numpy.polynomial import Polynomial

    from freebody.model.description import Joint


RatioCoefficients = tuple[float, ...]
"""Coefficients of a leader's position q, of q², q³, …; those of a linear follower are its ratio
alone."""


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = ratio · q(joint) + offset.

    powers: coefficients of q(joint)², q(joint)³, … besides. more: of several leaders, whose parts
    add up, (joint, coefficients) of the others.
    """

    joint: str
    ratio: float = 1.0
    offset: float = 0.0
    more: tuple[tuple[str, RatioCoefficients], ...] = ()
    powers: RatioCoefficients = ()

    def __post_init__(self) -> None:
        for name in ("ratio", "offset"):
            object.__setattr__(self, name, finite(getattr(self, name), f"Mimic: {name}"))
        more = tuple((joint, _coefficients(given)) for joint, given in self.more)
        object.__setattr__(self, "more", more)
        object.__setattr__(self, "powers", _coefficients((0.0, *self.powers))[1:])

    @staticmethod
    def of_terms(terms: Sequence[tuple[str, RatioCoefficients]], offset: float) -> Mimic:
        """The mimic of one leader or several, with the coefficients of each."""
        (first, (ratio, *powers)), *more = terms
        return Mimic(first, ratio, offset, tuple(more), tuple(powers))

    @property
    def terms(self) -> tuple[tuple[str, RatioCoefficients], ...]:
        """(joint, coefficients) of each leader."""
        return ((self.joint, self.coefficients), *self.more)

    @property
    def coefficients(self) -> RatioCoefficients:
        """Coefficients of the powers, from the first, of the position of the first leader in the
        joint's own position."""
        return (self.ratio, *self.powers)

    def seen_at(self, scale: float, shift: float) -> Mimic:
        """The mimic of one leader whose position here is scale · x + shift, by x."""
        offset, found = _put_in(self.coefficients, Mimic(self.joint, scale, shift))
        own = tuple(map(float, found[self.joint].coef[1:]))
        return Mimic.of_terms([(self.joint, own)], self.offset + offset)

    def said(self) -> str:
        """The position in terms of the leaders', as text."""
        return (
            " + ".join(
                f"{c:g} × {joint}{_POWERS.get(k, f'^{k}')}"
                for joint, own in self.terms
                for k, c in enumerate(own, start=1)
                if c or len(own) == 1
            )
            + f" + {self.offset:g}"
        )


_POWERS = {1: "", 2: "²", 3: "³"}


def _coefficients(given: Sequence[float]) -> RatioCoefficients:
    """Coefficients without those of the highest powers that are 0."""
    found = [finite(x, "Mimic: ratio") for x in given]
    while len(found) > 1 and found[-1] == 0.0:
        found.pop()
    return tuple(found)


class _Refuse(Protocol):
    """Raises with what is wrong and the line of the file."""

    def __call__(self, problem: str, line: int | IncludedLine | None = None) -> NoReturn: ...


def leaders(joints: Sequence[Joint], refuse: _Refuse) -> dict[str, Mimic]:
    """Mimics resolved to independent leaders: ratios multiply along a chain of mimics."""
    named = {joint.name: joint for joint in joints}
    resolved: dict[str, Mimic] = {}
    for joint in joints:
        # followers that wait for what they follow, in the order walked
        path = [joint]
        while path:
            follower = path[-1]
            if follower.mimic is None or follower.name in resolved:
                path.pop()
                continue
            waits = _first_open(follower, named, resolved, refuse)
            if waits is None:
                resolved[follower.name] = _follower(follower, named, resolved, refuse)
            elif any(waits is other for other in path):
                refuse(
                    f"joint {joint.name!r}: its mimic relations form a cycle; remove one.",
                    joint.line,
                )
            else:
                path.append(waits)
    return resolved


def _first_open(
    joint: Joint, named: Mapping[str, Joint], resolved: Collection[str], refuse: _Refuse
) -> Joint | None:
    """The first of a joint's leaders of which it is not known yet what it follows itself."""
    assert joint.mimic is not None
    for name, _ in joint.mimic.terms:
        if name not in named:
            problem = UnknownNameError("joint", name, f"the mimic of {joint.name!r}", named)
            refuse(f"{problem} Correct it, or load with mimic='free'.", joint.line)
        if named[name].mimic is not None and name not in resolved:
            return named[name]
    return None


def _follower(
    joint: Joint, named: Mapping[str, Joint], resolved: Mapping[str, Mimic], refuse: _Refuse
) -> Mimic:
    """The mimic of independent joints that a joint is, whose leaders may be followers."""
    given = joint.mimic
    assert given is not None
    above = [named[name] for name, _ in given.terms]
    if any(KINDS[other.kind].nv != 1 for other in (joint, *above)):
        refuse(
            f"joint {joint.name!r}: only joints of one coordinate can mimic or be mimicked.",
            joint.line,
        )
    found: dict[str, Polynomial] = {}
    offset = given.offset
    for name, coefficients in given.terms:
        of = resolved.get(name, Mimic(name))
        if of.more and len(coefficients) > 1:
            refuse(
                f"joint {joint.name!r} follows {name!r} by a polynomial, and that follows several "
                f"joints: products of their positions are not known; let it follow these joints.",
                joint.line,
            )
        constant, terms = _put_in(coefficients, of)
        offset += constant
        for leader, own in terms.items():
            found[leader] = found[leader] + own if leader in found else own
    every = {leader: tuple(map(float, x.coef[1:])) for leader, x in found.items()}
    try:
        return Mimic.of_terms(
            [x for x in every.items() if any(x[1])] or list(every.items())[:1], offset
        )
    except ModelError as error:
        refuse(f"joint {joint.name!r}: {error}", joint.line)


def _put_in(coefficients: RatioCoefficients, of: Mimic) -> tuple[float, dict[str, Polynomial]]:
    """(constant, terms without one by leader) of the polynomial of a follower's position."""
    polynomial = np.polynomial.Polynomial  # a module that NumPy imports when it is asked for
    if len(coefficients) == 1:
        ratio = coefficients[0]
        own = {leader: polynomial((0.0, *(ratio * x for x in c))) for leader, c in of.terms}
        return ratio * of.offset, own
    outer, inner = (0.0, *coefficients), (of.offset, *of.coefficients)
    whole = polynomial(outer)(polynomial(inner))
    return float(whole.coef[0]), {of.joint: whole - whole.coef[0]}


def one_by_one(joint: Joint, mimic: Mimic, taken: Collection[str]) -> tuple[Joint, ...]:
    """Joints on one axis that together move as a joint that follows several, the last of which has
    its name; taken: names of links and joints."""
    found, parent, placement = [], joint.parent, joint.placement
    for leader, own in mimic.terms[:-1]:
        name, between = (_free(f"{x}_{leader}", taken) for x in (joint.name, joint.child))
        found.append(
            replace(
                joint,
                name=name,
                parent=parent,
                child=between,
                placement=placement,
                limits=type(joint.limits)(),
                mimic=Mimic.of_terms([(leader, own)], 0.0),
            )
        )
        parent, placement = between, Placement()
    follows = Mimic.of_terms(mimic.terms[-1:], mimic.offset)
    end = replace(
        joint, parent=parent, placement=placement, limits=type(joint.limits)(), mimic=follows
    )
    return (*found, end)


def _free(name: str, taken: Collection[str]) -> str:
    while name in taken:
        name += "_"
    return name
