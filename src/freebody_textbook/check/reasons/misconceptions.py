"""Misconceptions, each of which alone may explain a wrong answer. To add one, add a table row: a
sentence and the function that changes the correct answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import Any

from freebody.expressions.grammar.tables.characters import DOT
from freebody.expressions.printed_names import with_letter
from freebody.spatial import Vector
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reasons import changed_answers as c
from freebody_textbook.check.reasons.bodies_at_point import Belief
from freebody_textbook.check.reasons.changed_bodies import (
    alone,
    arms,
    believed,
    freely,
    other_axes,
)
from freebody_textbook.check.reasons.forgotten_parameters import (
    Forgotten,
    Without,
    of_bodies,
    of_centres,
    of_moments,
    of_weights,
)
from freebody_textbook.check.reasons.free_body_beliefs import FreeBelief
from freebody_textbook.check.reasons.thoughts import Change, Changed, Subject

_REST = "; everything else is right."


def _told(x: Subject) -> Iterator[Changed]:
    """Change: values that the quantity is often confused with."""
    yield from (({"text": text}, x.point.of(value())) for text, value in x.target.thoughts)


def _others(x: Subject) -> Iterator[Changed]:
    """Change: the value of another quantity of the same kind."""
    for name, other in related(x.targets, x.target).items():
        yield {"name": with_letter(name)}, x.point.of(other)


def _sum(a: Vector, b: Vector) -> Vector:
    """Mistaken planar cross product a × b with a plus sign in place of the minus."""
    return (a[0] * b[1] + a[1] * b[0],)


def _along(a: Vector, b: Vector) -> Vector:
    """Mistaken cross product: the dot product a · b."""
    return (a[0] * b[0] + a[1] * b[1],)


def _across(a: Vector, b: Vector) -> Vector:
    """Mistaken planar cross product a × b with the components of a swapped."""
    return (a[1] * b[1] - a[0] * b[0],)


_GYROSCOPIC_SIGN = "The gyroscopic moment has the wrong sign: I ω̇ + ω × I ω = n."
_NOT_GYROSCOPIC = "The gyroscopic moment is missing: I ω̇ + ω × I ω = n."
_TRANSPORT = "in axes that turn the acceleration is v̇ + ω × v."
_ARM = "The thrust's arm has the wrong sign: a thrust T at s has the moment s × T, about"

OF_FREE_BODIES: Mapping[str, Change] = {
    _GYROSCOPIC_SIGN: freely(FreeBelief(gyroscopic=-1)),
    _NOT_GYROSCOPIC: freely(FreeBelief(gyroscopic=0)),
    "The weight has the wrong direction: z points up here, and gravity acts along −z.": freely(
        FreeBelief(weight=-1)
    ),
    "The weight is missing.": freely(FreeBelief(weight=0)),
    f"ω × v has the wrong sign: {_TRANSPORT}": freely(FreeBelief(transport=-1)),
    f"ω × v is missing: {_TRANSPORT}": freely(FreeBelief(transport=0)),
    f"f is all that acts besides the weight, and {_TRANSPORT}": freely(
        FreeBelief(transport=0, weight=0)
    ),
    f"{_ARM} x that is y T.": freely(FreeBelief(arms=(-1, 1))),
    f"{_ARM} y that is −x T.": freely(FreeBelief(arms=(1, -1))),
    "Forces are not rotated: the thrust acts along the body's axes, the weight along the "
    "world's.": freely(FreeBelief(axes="")),
    "R is transposed: it takes components from the body's axes to the world's.": freely(
        FreeBelief(axes="back")
    ),
    "This takes the rates of the angles for ω, which is right near hover only: ω̇ is that of the "
    "body, and φ̇ = p + (q sin φ + r cos φ) tan θ.": freely(FreeBelief(angular=False)),
    "This is right near hover only, where φ̇ = p and products of rates vanish.": freely(
        FreeBelief(angular=False, gyroscopic=0)
    ),
}
"""Other equations of a body that nothing holds."""

THOUGHTS: Mapping[str, Change] = {
    "{text}": _told,
    "What you wrote is right for {name}, not for this one.": _others,
    "Only the sign of gravity is wrong: {energy}, and the drives must support them: "
    "g_i = + ∂V/∂q_i.": c.other_gravity,
    f"Gravity is missing{_REST}": Without(of_weights),
    "Only a factor of 2 is missing: a product of two different rates, θ̇ᵢ θ̇ⱼ, occurs twice (as ij "
    "and as ji), so Coriolis terms have a factor of 2.": c.parts(Fraction(1, 2), "coriolis"),
    "The Coriolis terms, with products of two different rates, are missing.": c.parts(
        0, "coriolis"
    ),
    "The centrifugal terms, with squares of rates, are missing.": c.parts(0, "centrifugal"),
    f"The Coriolis and centrifugal terms are missing{_REST}": c.parts(0, *c.VELOCITY),
    f"All Coriolis and centrifugal terms have the wrong sign{_REST}": c.parts(-1, *c.VELOCITY),
    f"Friction is missing{_REST}": c.parts(0, "friction"),
    f"All friction terms have the wrong sign: the drive must overcome friction{_REST}": c.parts(
        -1, "friction"
    ),
    f"The terms with {{name}} are missing{_REST}": c.without_acceleration,
    "Every term with the mass or the moment of inertia of {links} is missing; the rest is "
    "right.": Without(of_bodies),
    "{moments} missing: this is right for {points} only.": Without(of_moments),
    "This is right only if {zero}: {centres} of {links} {are}.": Without(of_centres),
    "A factor ½ is missing: the kinetic energy of a body is ½ m v² + ½ I ω².": c.twice_the_energy,
    "The mixed terms are missing: a sum of rates is squared as (θ̇ᵢ + θ̇ⱼ)² = θ̇ᵢ² + 2 θ̇ᵢ θ̇ⱼ + "
    "θ̇ⱼ².": c.unmixed_rates,
    "The mixed terms are missing: velocities add as vectors, so the square of their sum is "
    "|a + b|² = a² + b² + 2 a · b.": c.unmixed_velocities,
    "This is right for {wrong}. The rate of a joint is relative to the previous link: angular "
    "velocities are sums, {right}.": alone(
        Belief(spins_alone=True),
        Belief(turns_alone=True),
        Belief(spins_alone=True, turns_alone=True),
    ),
    "Angles and rates are in radians: a factor π/180 too many, or one too few.": c.degrees,
    "This would be right with {zeros}, where {d} is measured {how}. If yours is, say so: "
    "{options}, in Python parameters={{{given}}}.": c.slides,
    "You wrote {wrong}: masses and weights act at the centre of mass, {centres} from the joint, "
    "not at the end of the link.": c.lengths(centre="l"),
    "This is right only if the centre of mass is at the midpoint of the link, {half}.": c.lengths(
        centre="half"
    ),
    "l and lc are swapped: {l} is the length of the link, {lc} the distance from its joint to the "
    "centre of mass.": c.lengths("lc", "l"),
    "You wrote {back}: the next body hangs at the end of the link, not at its centre of "
    "mass.": c.lengths("lc"),
    "The parallel-axis theorem is missing: this would be right for moments of inertia about the "
    "joints; here {names} {are} about the centre of mass, and {lacking} must be added.": c.axes(-1),
    "The parallel-axis term {lacking} is counted twice.": c.axes(1),
    "This would be right if {names} were measured from {zero}; here {it} measured from "
    "{own}.": c.turned,
    "This would be right if {names} were measured from the x axis; here each angle is measured "
    "from the previous link, so the direction of a link is a sum of angles.": c.absolute,
    "This would be right with components {axes}; here they are {here}.": other_axes,
}
"""Thoughts about one quantity, in the order in which they are tried."""

OF_INERTIAS: Mapping[str, Change] = {
    "Only the moments of inertia about the centres of mass are here: what the masses add, m lc² "
    "where a body turns about its joint, is missing.": arms(0, 0, 0, 0),
}
"""Entries of the mass matrix without what the masses add, where no symbol tells it apart."""

OF_BODIES: Mapping[str, Change] = {
    "The sign of the reaction is wrong: {next} is the force of body {n} on body {k}, so by "
    "Newton's third law {opposite} acts on body {n}.": believed(
        Belief(force=-1),
        *(Belief(couple=k, arms=x) for k in (1, -1) for x in ((1, 0, 0, -1), (1, 0, 2, -1))),
        *(Belief(force=-1, couple=k, arms=(1, 0, 0, -1)) for k in (1, -1)),
        of_next=True,
    ),
    "The sign of the moment at joint {k} is wrong: what acts on body {k} there acts on body {n} in "
    "the opposite direction.": believed(Belief(couple=-1), of_next=True),
    "The reaction of body {k} on body {n} is missing.": believed(
        Belief(force=0), Belief(force=0, couple=0, arms=(1, 0, 0, 0)), of_next=True
    ),
    "The moments r × f of the forces on body {n} are missing: I ω̇ alone is right only where no "
    "force has an arm about the centre of mass.": arms(0, 0, 0, 0),
    "This would be right if joint {n} did not accelerate: about a joint that does, s_c × m a of "
    "the joint must be added to I ω̇.": believed(Belief(joint_is_fixed=True)),
    "The moment of {opposite} on body {n} is missing.": arms(1, 0, 0, 0, of_next=True),
    "The moment of joint {k} on body {n} is missing.": believed(Belief(couple=0), of_next=True),
    "The moment s_c × m (v̇_c − g) of body {n} itself is missing.": arms(0, 0, 0, 1),
    "The moment of {f} about the centre of mass of body {n} is missing.": arms(0, 0, -1, 1),
    "m (v̇_c − g) of body {n} has the arm s_c to its centre of mass, not s to its end.": arms(
        0, 1, 0, 1
    ),
    "{next} has a wrong arm or none: about joint {n} the arm is s, about the centre of mass of "
    "body {n} that of {opposite} is s − s_c.": arms(1, 0, 1, 0, of_next=True),
    "The arms are swapped: of body {n}, m (v̇_c − g) has the arm s_c to its centre of mass, {next} "
    "the arm s to joint {k}.": arms(0, 1, 1, 0, of_next=True),
    "The arms about the centre of mass of body {n} are swapped: that of {f} is −s_c, that of "
    "{opposite} is s − s_c.": arms(-1, 1, 0, 1, of_next=True),
    "The arm of {opposite} about the centre of mass of body {n} is s − s_c, not s.": arms(
        1, 0, 1, 1, of_next=True
    ),
    "A cross product has the wrong sign: the arm comes first, r × f = −f × r, and from the centre "
    "of mass of body {n} to its joint it is −s_c.": believed(
        *(Belief(arms=x) for x in ((-1, 0, -2, 1), (-1, 0, 0, -1), (-1, 0, 0, 1)))
    ),
    "The cross product has a minus: r × f = r_x f_y − r_y f_x.": believed(Belief(product=_sum)),
    "The arms of the components are mixed up: r × f = r_x f_y − r_y f_x, so f_x has the arm r_y "
    "and f_y the arm r_x.": believed(Belief(product=_along), Belief(product=_across)),
    "The Coriolis acceleration of what slides along a turning body is 2 ω × ḋ.": believed(
        Belief(coriolis=Fraction(1, 2)), Belief(coriolis=Fraction(0))
    ),
    _GYROSCOPIC_SIGN: believed(Belief(gyroscopic=-1)),
    _NOT_GYROSCOPIC: believed(Belief(gyroscopic=0)),
    "The forces of the loops are missing.": believed(Belief(loops_act=False)),
}
"""Other equations of the bodies."""


@dataclass(frozen=True)
class ThoughtTable:
    """A table of misconceptions, the most specific first."""

    rows: Mapping[str, Change]
    most: int
    """The greatest number of them that is told of one answer."""
    about: Callable[[Subject], bool] = lambda x: True
    """Whether they are about a quantity."""


TABLES = (
    ThoughtTable(OF_FREE_BODIES, 1),
    ThoughtTable(THOUGHTS, 2, lambda x: not x.is_equation),
    ThoughtTable(OF_INERTIAS, 1, lambda x: x.part == "M"),
    ThoughtTable(OF_BODIES, 1, lambda x: x.part in ("", "tau")),  # of M or g, nobody knows the way
)
"""The tables in the order in which they are tried: one whose thoughts explain is the last."""


def explaining(x: Subject, value: Any) -> list[str]:
    """Sentences on the misconceptions that turn the correct answer into the user's: at most two, or
    one about the bodies' equations."""
    if value == 0:  # of many parts it would be right that they are missing
        return []
    for table, rows in zip(TABLES, values(x), strict=True):
        agreeing = (next((said for said, y in row if x.point.agree(y, value)), "") for row in rows)
        if told := list(islice(filter(None, agreeing), table.most)):
            return told
    return []


def values(x: Subject) -> Iterator[Iterator[Iterator[tuple[str, Any]]]]:
    """All misconceptions about a quantity by table and row: a sentence, and the value that the
    answer would have."""
    yield from (_of(table, x) for table in TABLES)


def left_out(setting: RightEquations) -> Iterator[tuple[str, Forgotten]]:
    """Sentences on parameters that may have been forgotten, with these."""
    for text, change in THOUGHTS.items():
        if isinstance(change, Without):
            yield from ((text.format(**x.said), x) for x in change.groups(setting))


def _of(table: ThoughtTable, x: Subject) -> Iterator[Iterator[tuple[str, Any]]]:
    for text, change in table.rows.items() if table.about(x) else ():
        yield _filled(text, change(x))


def _filled(text: str, changed: Iterator[Changed]) -> Iterator[tuple[str, Any]]:
    """A sentence with its placeholders filled, and the value of the changed answer."""
    yield from ((text.format(**said), value) for said, value in changed)


def related(targets: Targets, target: AskedQuantity) -> dict[str, Value]:
    """Other quantities of the same kind, by name."""
    letter = target.kind.usual
    others = [
        (name, other)
        for name, other in targets.single.items()
        if letter and other.kind is target.kind and other.index != target.index
    ]
    usual = [row for row in others if row[0].startswith(letter)]
    found: dict[str, Value] = {}
    seen = set()
    for name, other in usual or others:
        if other.index not in seen:
            seen.add(other.index)
            found[name] = other.compute()
    return found or _of_the_same_table(targets, target)


def _of_the_same_table(targets: Targets, target: AskedQuantity) -> dict[str, Value]:
    """Other entries of the same matrix, such as a rotation matrix."""
    if len(target.index) != 2 or not target.words:
        return {}
    for name, table in targets.tables.items():
        entries = {entry.index: entry for row in table for entry in row}
        own = entries.get(target.index)
        if own is not None and own.words == target.words:
            bare = name.lstrip(DOT)
            dots = "\u0307" * (len(name) - len(bare))
            shown = bare[:1] + dots + bare[1:]
            others = (entry for index, entry in entries.items() if index != target.index)
            return {f"{shown} {x.index[0]}, {x.index[1]}": x.compute() for x in others}
    return {}
