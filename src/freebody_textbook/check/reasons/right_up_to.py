"""Answers that are correct up to a choice: rows of a Coriolis matrix with C q̇ = c, equations of
joints without a drive up to a factor, rows of J_a and J_b up to a factor."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from freebody.expressions.polynomials.arithmetic import inner
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import (
    Value,
    difference,
    inverted,
    negative,
    over,
    times,
)
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reasons.differences import parts

_COMPARED_WITH = (
    "C is not unique: many matrices satisfy C q̇ = c. This entry was compared with that of "
    "the Christoffel matrix; give the whole row to have C q̇ = c checked."
)


def coriolis_notes(
    setting: RightEquations, claims: Sequence[Claim]
) -> Mapping[tuple[int, ...], str]:
    """Notes, by indices, on Coriolis matrix entries that differ from Christoffel's though C q̇ = c
    holds."""
    rows = _rows_of_C(setting, claims)
    right = {
        i
        for i, row in rows.items()
        if inner(row, setting.symbols.qd, setting.symbols)
        == setting.element(setting.all_of("c")[i])
    }
    if not right:
        return {}
    whole = len(right) == len(setting.symbols.coordinates)
    skew = f" Ṁ − 2C is {'' if _is_skew(setting, rows) else 'not '}skew-symmetric." if whole else ""
    return {
        (i + 1, j + 1): f"C q̇ = c holds in row {i + 1}; C is not the Christoffel matrix.{skew}"
        for i in right
        for j in range(len(rows[i]))
    }


def coriolis_advice(setting: RightEquations, claim: Claim, claims: Sequence[Claim]) -> str:
    """A sentence about a Coriolis matrix entry whose row is incomplete."""
    return (
        _COMPARED_WITH
        if claim.target.kind.by_rates
        and claim.target.index[0] - 1 not in _rows_of_C(setting, claims)
        else ""
    )


def _rows_of_C(setting: RightEquations, claims: Sequence[Claim]) -> dict[int, list[Trig]]:
    """The rows of C, counted from 0, for which an answer gives every entry once."""
    n = len(setting.symbols.coordinates)
    given: dict[tuple[int, ...], list[Trig]] = {}
    for claim in claims:
        if claim.target.kind.by_rates and isinstance(claim.value, Trig):
            given.setdefault(claim.target.index, []).append(claim.value)
    single = {index: values[0] for index, values in given.items() if len(values) == 1}
    return {
        i: [single[i + 1, j + 1] for j in range(n)]
        for i in range(n)
        if all((i + 1, j + 1) in single for j in range(n))
    }


def _is_skew(setting: RightEquations, rows: Mapping[int, Sequence[Trig]]) -> bool:
    """Whether Ṁ − 2C is skew-symmetric, which means C + Cᵀ = Ṁ."""
    M, n = setting.all_of("M"), len(setting.symbols.coordinates)
    rates = setting.symbols.rates
    return all(
        (rows[i][j] + rows[j][i] - setting.element(M[i][j]).along(rates)).is_zero
        for i in range(n)
        for j in range(i + 1)
    )


_AGREEING = 2
"""Number of parts that must agree to tell a factor."""


def undriven_equation(
    targets: Targets, x: Trig, taken: Collection[tuple[int, ...]]
) -> tuple[tuple[int, ...], Value]:
    """The passive joint whose equation x = 0 is, or should be (the most similar among those no
    other line states), and the value that x should have."""
    own = targets.undriven
    right = next(
        (target for target in own if is_undriven_equation(targets.setting, x, target.polynomial())),
        None,
    )
    if right is not None:
        return right.index, x
    left = [target for target in own if target.index not in taken] or own
    target = max(left, key=lambda target: len(_votes(targets.setting, x, target.polynomial())))
    return target.index, alike(targets.setting, x, target.polynomial())


def is_undriven_equation(setting: RightEquations, x: Trig, y: Trig) -> bool:
    """Whether x = 0 and y = 0 are equivalent: one is the other times a factor without rates."""
    first, second = (parts(setting, side, setting.order.moving) for side in (x, y))
    if not first or first.keys() != second.keys():
        return False
    key = next(iter(first))
    return all((first[k] * second[key] - second[k] * first[key]).is_zero for k in first)


def alike(setting: RightEquations, x: Trig, y: Trig) -> Value:
    """The polynomial y, multiplied by the number or rate-free factor that makes most of its parts
    equal to those of x."""
    votes = _votes(setting, x, y)
    best = max(
        votes, key=lambda ratio: (votes.count(ratio), ratio > 0, -abs(ratio)), default=Fraction(1)
    )
    if votes.count(best) < _AGREEING:
        first, second = (parts(setting, side, setting.order.moving) for side in (x, y))
        ratios = [over(first[k], second[k]) for k in first if k in second]
        for ratio in ratios:
            if sum(difference(ratio, other).is_zero for other in ratios) >= _AGREEING:
                return times(y, ratio)
    return y * best


def _votes(setting: RightEquations, x: Trig, y: Trig) -> list[Fraction]:
    """Ratios of the parts of x to the same parts of y, as numbers."""
    first, second = parts(setting, x), parts(setting, y)
    return [ratio for k in first if k in second for ratio in _ratio(first[k], second[k])]


def _ratio(a: Trig, b: Trig) -> Iterator[Fraction]:
    """The number k with a = k b, if it exists."""
    ratio = Fraction(a.leading_coefficient) / Fraction(b.leading_coefficient)
    if (a - b * ratio).is_zero:
        yield ratio


Same = Callable[[Value, Value], bool]
_Pair = tuple[Value, Value]
"""An entry of the answer with its right value."""
_NOTE = "Row {} is that of J_a ẋ + J_b θ̇ = 0 times a factor, in all of its entries."


def in_its_scale(claim: Claim, claims: Sequence[Claim], same: Same) -> Claim:
    """A claim about J_a or J_b with its correct value scaled by its row's factor, in the answer's
    sign convention. Raises AnswerError for a single wrong entry in a row, as another factor could
    make it correct."""
    if not claim.target.kind.up_to_rows:
        return claim
    own = [x for x in claims if x.target.kind.up_to_rows]
    numbers = sorted({x.target.index[0] for x in own})
    rows = {sign: {k: _row(own, k, sign) for k in numbers} for sign in (1, -1)}
    free = any(x.target.also for x in own)
    sign = max(
        (1, -1) if free else (1,), key=lambda s: sum(_most(x, same) for x in rows[s].values())
    )
    number = claim.target.index[0]
    pairs, right = rows[sign][number], _right(claim, sign)
    fitting = next((x for x in pairs if same(*x)), None) or _of_most(pairs, same)
    if fitting is None and len(pairs) == 1:
        claim.source.fail(
            "alone, this entry may be any: an equation of a parallel robot may be multiplied by a "
            "factor",
            claim.node.span,
            "Give both matrices, J_a and J_b.",
        )
    target = replace(claim.target, compute=lambda: right, also=())
    if fitting is not None and not same(*fitting):
        scaled = times(right, times(fitting[0], inverted(fitting[1])))
        target = replace(target, compute=lambda: scaled, note=_NOTE.format(number))
    return replace(claim, target=target)


def _row(claims: Sequence[Claim], number: int, sign: int) -> list[_Pair]:
    """(answer, correct value) of the entries in a row of J_a and J_b that are not 0."""
    row = [x for x in claims if x.target.index[0] == number]
    pairs = [(x.value, _right(x, sign)) for x in row]
    return [(yours, right) for yours, right in pairs if not right.is_zero]


def _right(claim: Claim, sign: int) -> Value:
    """The correct value of an entry; sign: the assumed sign convention of J_b if the answer does
    not show it."""
    value = claim.target.compute()
    return negative(value) if claim.target.also and sign < 0 else value


def _most(pairs: Sequence[_Pair], same: Same) -> int:
    """The largest number of a row's entries that agree up to a common factor."""
    return max((_agreeing(x, pairs, same) for x in pairs), default=0)


def _of_most(pairs: Sequence[_Pair], same: Same) -> _Pair | None:
    """The entry whose factor makes most others of its row correct; None if none does."""
    best = max(pairs, key=lambda x: _agreeing(x, pairs, same), default=None)
    return best if best is not None and _agreeing(best, pairs, same) > 1 else None


def _agreeing(one: _Pair, pairs: Sequence[_Pair], same: Same) -> int:
    """The number of entries that become correct with one entry's factor; factors that vanish on
    closed loops do not count."""
    yours, right = one
    if same(yours, negative(yours)):
        return 0
    return sum(same(times(yours, y), times(x, right)) for x, y in pairs)
