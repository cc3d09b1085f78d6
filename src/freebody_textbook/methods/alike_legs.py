"""Legs of a robot that are alike: the lines of the first are told, and that the others have the
same with their own numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from freebody.errors import listed
from freebody.expressions.nodes import Expression, Symbol, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting

FEW = 3
"""Legs up to which each has lines of its own."""

Names = Mapping[str, str]


def told_once(s: Setting, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """The steps without the lines of further legs that are those of the first leg under other
    names; steps of which none is left are dropped."""
    first, *others = _legs(s)
    if len(others) < FEW:
        return steps
    renamings = [_renaming(s, first, leg) for leg in others]
    known = {x for names in renamings for x in names}
    model = [
        (k, line)
        for k, step in enumerate(steps)
        for line in step.equations
        if known & set(_names(line))
    ]
    told: set[int] = set()
    found = []
    for step in steps:
        kept = []
        for line in step.equations:
            like = _model_of(line, model, renamings)
            if like is None:
                kept.append(line)
            else:
                told.add(like)
        found.append(replace(step, equations=tuple(kept)))
    reasons = _reasons(s, first, others)
    return tuple(
        replace(new, reason=new.reason + next(reasons)) if k in told else new
        for k, (old, new) in enumerate(zip(steps, found, strict=True))
        if new.equations or not old.equations
    )


def _legs(s: Setting) -> list[list[int]]:
    """The most chains of bodies from the ground that have the same joints in a row."""
    groups: dict[tuple[tuple[bool, bool], ...], list[list[int]]] = {(): [[]]}
    for root in s.tree.children(-1):
        leg = [root]
        while len(below := s.tree.children(leg[-1])) == 1:
            leg.append(below[0])
        if not below and not set(leg) & s.links:
            joints = tuple((s.turns(i), s.slides(i)) for i in leg)
            groups.setdefault(joints, []).append(leg)
    return max(groups.values(), key=len)


def _renaming(s: Setting, first: list[int], leg: list[int]) -> Names:
    """Names of coordinates and their rates of one leg, from those of the first."""
    return {
        s.coordinate(a) + dots: s.coordinate(b) + dots
        for a, b in zip(first, leg, strict=True)
        for dots in ("", RATE, SECOND)
    }


def _names(line: Expression) -> Iterator[str]:
    return (x.name for x in nodes(line) if isinstance(x, Symbol))


def _model_of(
    line: Expression, model: Iterable[tuple[int, Expression]], renamings: Iterable[Names]
) -> int | None:
    """The step of the first leg's line that a line is under the names of its own leg."""
    own = set(_names(line))
    for names in renamings:
        if own & set(names.values()):
            for k, other in model:
                if _same(other, line, dict(names), {b: a for a, b in names.items()}):
                    return k
    return None


def _same(a: Any, b: Any, there: dict[str, str], back: dict[str, str]) -> bool:
    """Whether two trees are equal but for names, each of which stands for one other."""
    if isinstance(a, Symbol) and isinstance(b, Symbol):
        look = [(x.letter, x.dots, x.high, x.bold) for x in (a, b)]
        given = there.setdefault(a.name, b.name) == b.name
        return look[0] == look[1] and given and back.setdefault(b.name, a.name) == a.name
    if type(a) is not type(b):
        return False
    if isinstance(a, tuple):
        return len(a) == len(b) and all(_same(x, y, there, back) for x, y in zip(a, b, strict=True))
    if isinstance(a, Expression):
        one, other = (tuple([getattr(x, name) for name in x.__match_args__]) for x in (a, b))
        return _same(one, other, there, back)
    return a == b


def _reasons(s: Setting, first: list[int], others: list[list[int]]) -> Iterator[str]:
    def span(leg: list[int]) -> str:
        return f"{s.numbers[leg[0]]} to {s.numbers[leg[-1]]}"

    yield (
        f" The lines are those of the first leg, bodies {span(first)}; for bodies "
        f"{listed(list(map(span, others)))} they are the same, with other numbers."
    )
    while True:
        yield " The lines of the other legs are the same, with other numbers."
