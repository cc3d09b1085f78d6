"""Two limits in which the equations of a planar arm are known: its last body without mass, and all
joints but one held still."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from freebody.algorithms.rnea import rnea
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, eq
from freebody.expressions.nodes import Conditioned, Words, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.model.parameters import each_parameter
from freebody.scalars.trig import Trig
from freebody.spatial import dot, sub
from freebody_textbook.derivation import Step
from freebody_textbook.methods.reactions import rotor_part
from freebody_textbook.methods.setting import Setting


def limits(s: Setting) -> list[Step]:
    """The limits of a planar row of bodies, each proved: what becomes of the equations is the same
    polynomial as the equations of the simpler robot."""
    if not s.planar or s.tree.loops or s.load or s.symbols.turned or not _is_row(s):
        return []
    found = [*_one_turning(s), *_without_last(s)]
    if not found:
        return []
    reason = " ".join(words for words, _ in found)
    lines = tuple(line for _, some in found for line in some)
    title = "Two limits" if len(found) > 1 else "A limit"
    return [Step(title, reason, lines)]


def _is_row(s: Setting) -> bool:
    """Whether there are several bodies, each on the one before, and each joint moves alone."""
    parents = [s.tree.bodies[i].parent for i in s.order]
    return len(s.order) > 1 and parents == [-1, *s.order[:-1]] and all(map(s.is_alone, s.order))


def _readable(lines: Iterable[Equation]) -> bool:
    return not any(isinstance(x, Words) for line in lines for x in nodes(line))


# ---------------------------------------------------------------- a mass to zero
def _without_last(s: Setting) -> Iterator[tuple[str, list[Equation]]]:
    """The last body's mass and inertia vanish: the equations of the arm without it."""
    *inner, last = s.order
    names = _inertia_names(s, last)
    shorter = rnea(replace(s.tree, bodies=s.tree.bodies[:-1]), s.symbols.q, *s._rates)
    lines = []
    for i in inner if names else ():
        tau, alone = s.equations.tau[s.index(i)], s.symbols.element(shorter.tau[s.index(i)])
        if _dropped(tau, names) != alone:
            return
        lines.append(eq(s.motor(i), ex.add(s.show(alone), s.show_moved(tau - alone))))
    if not lines or not _readable(lines):
        return
    remaining = listed([f"body {s.numbers[i]}" for i in inner])
    what, it = ("mass and inertia", "them") if len(names) > 1 else ("mass", "it")
    yield (
        f"What body {s.numbers[last]} adds stands last, by its {what}: without {it} the rest "
        f"remains, the equation of the arm of {remaining} alone.",
        lines,
    )


def _inertia_names(s: Setting, last: int) -> list[str]:
    """The mass and moments of inertia of the last body, as the torques have them; none where one is
    a number or belongs to other bodies too."""
    model = s.symbols.model
    own, others = model.bodies[s.numbers[last] - 1], model.bodies[: s.numbers[last] - 1]
    found = dict.fromkeys(
        x.name
        for part in own.inertias
        for quantity in (part.inertia.mass, part.inertia.tensor)
        for x in each_parameter(quantity)
    )
    shared = {x.name for x in each_parameter(others)}
    used = {x for tau in s.equations.tau for powers, _ in tau.terms() for x in powers}
    return [] if shared & found.keys() else [x for x in found if x in used]


# ---------------------------------------------------------------- one joint turning
def _one_turning(s: Setting) -> Iterator[tuple[str, list[Equation]]]:
    """All joints but the first that turns are held, angles after it at 0: a rigid body that swings
    about that joint."""
    pivot = next((i for i in s.order if s.turns(i) and not s.slides(i)), None)
    if pivot is None:
        return
    held = [i for i in s.order if i != pivot]
    straight = [i for i in held if s.turns(i) and s.numbers[i] > s.numbers[pivot]]
    at = _at_zero(s, held, straight)
    limit = at(s.equations.tau[s.index(pivot)])
    if limit != at(_swinging(s, pivot)):
        return
    zero = [s.coordinate(i) for i in straight]
    names = [*zero, *(s.coordinate(i) + dots for dots in (RATE, SECOND) for i in held)]
    line = eq(Conditioned((eq(*map(sym, names), ex.ZERO),), s.motor(pivot)), s.show(limit))
    if not _readable([line]):
        return
    n, others = s.numbers[pivot], [f"joint {s.numbers[i]}" for i in held]
    how = "held and the arm stretched" if straight and _is_straight(s, pivot, at) else "held"
    what = "a compound pendulum" if s.weighs else "one rigid body"
    yield (
        f"With {listed(others)} {how}, all that joint {n} carries is {what}: its moment of inertia "
        "about the joint is, body by body, that about the centre of mass and the mass times the "
        "square of the centre's distance.",
        [line],
    )


def _swinging(s: Setting, pivot: int) -> Trig:
    """What turns a rigid body about a joint: its moment of inertia there times the acceleration,
    less the moment of its weights, and what the joint's drive takes."""
    k, total = s.index(pivot), s.symbols.zero()
    _, origin = s.world[pivot]
    for i in s.order[s.order.index(pivot) :]:
        if i in s.weighted:
            arm, m = sub(s.centre_position(i), origin), s.mass(i)
            (weight,) = s.tree.space.moment(arm, s.gravity(i))
            total = total + (s.inertia(i) + m * dot(arm, arm)) * s.symbols.qdd[k] - m * weight
    return s.symbols.element(total) + s.equations.drives[k] + rotor_part(s, pivot)


def _at_zero(s: Setting, held: Iterable[int], straight: Iterable[int]) -> Callable[[Trig], Trig]:
    """A polynomial where these joints stand still, and these angles are 0."""
    still = {s.coordinate(i) + dots for i in held for dots in (RATE, SECOND)}
    angles = {s.coordinate(i) for i in straight}
    gone = still | {f"sin_{x}" for x in angles} | {f"sgn_{x}" for x in still}
    ones = {f"cos_{x}" for x in angles}

    def at(x: Trig) -> Trig:
        kept = (
            ({name: e for name, e in powers.items() if name not in ones}, c)
            for powers, c in _dropped(x, gone | angles).terms()
        )
        return s.symbols.ring.polynomial(kept)

    return at


def _is_straight(s: Setting, pivot: int, at: Callable[[Trig], Trig]) -> bool:
    """Whether joint and centres of mass lie on one line."""
    _, origin = s.world[pivot]
    arms = [
        sub(s.centre_position(i), origin) for i in s.weighted if s.numbers[i] >= s.numbers[pivot]
    ]
    first, *others = arms
    moments = (s.tree.space.moment(first, arm)[0] for arm in others)
    return all(at(s.symbols.element(x)).is_zero for x in moments)


def _dropped(x: Trig, names: Iterable[str]) -> Trig:
    """A polynomial without the terms that hold one of these names."""
    gone = set(names)
    return x.ring.polynomial((powers, c) for powers, c in x.terms() if not gone & powers.keys())
