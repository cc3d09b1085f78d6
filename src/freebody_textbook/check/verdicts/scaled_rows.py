"""J_a and J_b of a parallel robot: each equation J_a ẋ + J_b θ̇ = 0 may be multiplied by a factor,
and so a row of both matrices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from freebody_textbook.check.algebra.quotients import Value, inverted, negative, times
from freebody_textbook.check.reading.claim import Claim

Same = Callable[[Value, Value], bool]
_Pair = tuple[Value, Value]
"""What an answer has, and the right entry."""
_NOTE = "Row {} is that of J_a ẋ + J_b θ̇ = 0 times a factor, in all of its entries."


def in_its_scale(claim: Claim, claims: Sequence[Claim], same: Same) -> Claim:
    """The claim with the right value times the factor of its row, and in the sense of the answer's
    J_b. Raises AnswerError for an entry that is wrong as it stands and alone in its row, for with
    another factor it may be right."""
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
    """The entries of a row of both matrices that are not to be 0."""
    row = [x for x in claims if x.target.index[0] == number]
    pairs = [(x.value, _right(x, sign)) for x in row]
    return [(yours, right) for yours, right in pairs if not right.is_zero]


def _right(claim: Claim, sign: int) -> Value:
    """The right entry; of a J_b whose sense the answer does not say in one of its two."""
    value = claim.target.compute()
    return negative(value) if claim.target.also and sign < 0 else value


def _most(pairs: Sequence[_Pair], same: Same) -> int:
    """How many entries agree, up to one factor."""
    return max((_agreeing(x, pairs, same) for x in pairs), default=0)


def _of_most(pairs: Sequence[_Pair], same: Same) -> _Pair | None:
    """The entry with whose factor several agree, if there is one."""
    best = max(pairs, key=lambda x: _agreeing(x, pairs, same), default=None)
    return best if best is not None and _agreeing(best, pairs, same) > 1 else None


def _agreeing(one: _Pair, pairs: Sequence[_Pair], same: Same) -> int:
    """How many entries are right times the factor of one, which loops must not make 0."""
    yours, right = one
    if same(yours, negative(yours)):
        return 0
    return sum(same(times(yours, y), times(x, right)) for x, y in pairs)
