"""Changes of the correct answer by a wrong belief about the equations of its bodies."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import partial
from typing import Any

from freebody.errors import listed
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import sym
from freebody_textbook.check.reasons.bodies_at_point import Belief
from freebody_textbook.check.reasons.changed_answers import chains
from freebody_textbook.check.reasons.free_body_beliefs import FreeBelief
from freebody_textbook.check.reasons.thoughts import Change, Changed, Subject, each_and_all


def freely(belief: FreeBelief) -> Change:
    """Change: an equation that holds for a free body under a wrong belief."""

    def change(x: Subject) -> Iterator[Changed]:
        if x.free is not None:
            yield {}, x.point.of(x.free.yours) + x.free.gap(x.point, belief)

    return change


def believed(*beliefs: Belief, of_next: bool = False) -> Change:
    """Change: wrong beliefs about the body of the answer, a body that it carries, or all bodies;
    the first belief that has an effect is reported. of_next: only for bodies that carry others."""

    def change(x: Subject) -> Iterator[Changed]:
        every = range(len(x.bodies.bodies)) if x.about else ()
        for i in x.about:
            own = [j for j in _carried(x, i) if x.bodies.s.tree.children(j) or not of_next]
            for belief in beliefs if i in own else ():
                alone = {j: list(_under(x, i, (j,), belief)) for j in own}
                matter = [j for j in own if any(value != x.value for value in alone[j])]
                if len(every) > 1:
                    first = next(iter(matter), i)
                    alone[first] = [*alone[first], *_under(x, i, every, belief)]
                yield from ((_names(x, j), value) for j in own for value in alone[j])

    return change


def _carried(x: Subject, i: int) -> list[int]:
    """Indices of a body and of all bodies that it carries."""
    found = [i]
    for j in found:
        found += x.bodies.s.tree.children(j)
    return found


def arms(*often: int, of_next: bool = False) -> Change:
    """Change: wrong lever arms of the forces in Euler's equation."""
    return believed(Belief(arms=often), of_next=of_next)


def _under(x: Subject, i: int, of: Collection[int], belief: Belief) -> Iterator[Any]:
    """Values of the correct answer, about body i, under a belief about some bodies."""
    b, right = x.bodies, x.value
    if x.torque is not None:
        moves = belief.spins_alone or belief.turns_alone
        for way in (b.acting, b.projected)[: 1 + moves]:
            state = x.torque[1]
            yield right + way(state, of, belief)["tau", i][0] - way(state)["tau", i][0]
    for own in x.components:
        if own.key[1] in (i, -1):
            told = partial(b.acting, b.moving) if own.key[0] in "fn" else b.moved
            gap = own.of(b, told(of, belief)) - own.of(b, told())
            yield right + gap
            if x.is_equation:
                yield right - gap


def _names(x: Subject, i: int) -> dict[str, object]:
    """Values for the placeholders in sentences about body i."""
    s, n = x.bodies.s, x.bodies.s.numbers[i]
    h, behind = s.numbers[s.tree.bodies[i].parent], [s.numbers[k] for k in s.tree.children(i)]
    return {
        "n": n, "k": listed(map(str, behind)), "f": f"f{h}{n}",
        "next": listed(f"f{n}{k}" for k in behind), "opposite": listed(f"−f{n}{k}" for k in behind),
    }  # fmt: skip


def alone(*beliefs: Belief) -> Change:
    """Change: the angular velocity of one body, or of all, without those of the preceding
    bodies."""

    def change(x: Subject) -> Iterator[Changed]:
        sums = _sums(x) if x.about else {}
        for of in each_and_all(list(sums)):
            said = {
                "wrong": listed(f"{sums[i][0]} = {sums[i][-1]}" for i in of),
                "right": listed(f"{sums[i][0]} = {' + '.join(sums[i][1:])}" for i in of),
            }
            for belief in beliefs:
                for i in x.about:
                    yield from ((said, value) for value in _under(x, i, of, belief))

    return change


def _sums(x: Subject) -> dict[int, list[str]]:
    """For each body with several turning joints before it: the name of ω and the joint rates whose
    sum it is."""
    return {
        i: [str(sym(f"omega{x.bodies.s.numbers[i]}")), *(str(sym(name + RATE)) for name in row)]
        for i, row in chains(x).items()
        if len(row) > 1
    }


def other_axes(x: Subject) -> Iterator[Changed]:
    """Change: vector components in another body's axes, or in the world's."""
    b = x.bodies
    found = {**b.moved(), **b.acting(b.moving)} if x.components and not x.is_equation else {}
    for own in x.components if found else ():
        for k in range(-(x.target.in_world is None), len(b.bodies)):
            if k != own.axes and len(found[own.key]) == b.s.tree.space.dim:
                yield {"axes": _axes(x, k), "here": _axes(x, own.axes)}, own.of(b, found, k)


def _axes(x: Subject, i: int) -> str:
    return f"along those of body {x.bodies.s.numbers[i]}" if i >= 0 else "along the world's axes"
