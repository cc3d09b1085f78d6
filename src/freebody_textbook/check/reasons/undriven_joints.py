"""Equations of joints that nothing drives: 0 = …, right up to a factor without rates."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fractions import Fraction

from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value, difference, over, times
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.asked.terms_by_motion import parts

_AGREEING = 2
"""Parts that tell a factor."""


def equation(
    targets: Targets, x: Trig, taken: Collection[tuple[int, ...]]
) -> tuple[tuple[int, ...], Value]:
    """The passive joint whose equation x = 0 states, or else should, of those that no other line
    has given the one with which it has most in common; and what x should be."""
    own = [targets.single[f"tau{i}"] for i in targets.passive]
    right = next(
        (target for target in own if is_same(targets.setting, x, target.polynomial())), None
    )
    if right is not None:
        return right.index, x
    left = [target for target in own if target.index not in taken] or own
    target = max(left, key=lambda target: len(_votes(targets.setting, x, target.polynomial())))
    return target.index, alike(targets.setting, x, target.polynomial())


def is_same(setting: RightEquations, x: Trig, y: Trig) -> bool:
    """Whether x = 0 says the same as y = 0: one is the other times a factor without rates."""
    first, second = (parts(setting, side, setting.order.moving) for side in (x, y))
    if not first or first.keys() != second.keys():
        return False
    key = next(iter(first))
    return all((first[k] * second[key] - second[k] * first[key]).is_zero for k in first)


def alike(setting: RightEquations, x: Trig, y: Trig) -> Value:
    """y times the number, or else the factor without rates, with which it has most parts in common
    with x."""
    votes = _votes(setting, x, y)
    best = max(
        votes, key=lambda ratio: (votes.count(ratio), ratio > 0, -abs(ratio)), default=Fraction(1)
    )
    if votes.count(best) < _AGREEING:
        first, second = (parts(setting, side, setting.order.moving) for side in (x, y))
        ratios = [over(first[k], second[k]) for k in first.keys() & second.keys()]
        for ratio in ratios:
            if sum(difference(ratio, other).is_zero for other in ratios) >= _AGREEING:
                return times(y, ratio)
    return y * best


def _votes(setting: RightEquations, x: Trig, y: Trig) -> list[Fraction]:
    """The numbers that parts of x are times those of y."""
    first, second = parts(setting, x), parts(setting, y)
    return [ratio for k in first.keys() & second.keys() for ratio in _ratio(first[k], second[k])]


def _ratio(a: Trig, b: Trig) -> Iterator[Fraction]:
    """The number that a is times b, if it is one."""
    ratio = Fraction(a.leading_coefficient) / Fraction(b.leading_coefficient)
    if (a - b * ratio).is_zero:
        yield ratio
