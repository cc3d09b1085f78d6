"""Rows of a Coriolis matrix: every C with C q̇ = c is right; Christoffel's is the one that is
computed here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from freebody.expressions.polynomials.arithmetic import inner
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reading.claim import Claim

_ALONE = (
    "C is not unique: many matrices satisfy C q̇ = c. This entry was compared with that of "
    "the Christoffel matrix; give the whole row to have C q̇ = c checked."
)


def notes(setting: RightEquations, claims: Sequence[Claim]) -> Mapping[tuple[int, ...], str]:
    """What is to be said of entries that differ from Christoffel's, by their indices, where C q̇ =
    c holds."""
    rows = _rows(setting, claims)
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


def advice(setting: RightEquations, claim: Claim, claims: Sequence[Claim]) -> str:
    """A sentence about an entry whose row is not given."""
    return (
        _ALONE
        if claim.target.kind.by_rates and claim.target.index[0] - 1 not in _rows(setting, claims)
        else ""
    )


def _rows(setting: RightEquations, claims: Sequence[Claim]) -> dict[int, list[Trig]]:
    """Rows of C, from 0, of which an answer gives every entry once."""
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
    """Whether Ṁ − 2C and its transpose add up to 0, that is C + Cᵀ = Ṁ."""
    M, n = setting.all_of("M"), len(setting.symbols.coordinates)
    rates = setting.symbols.rates
    return all(
        (rows[i][j] + rows[j][i] - setting.element(M[i][j]).along(rates)).is_zero
        for i in range(n)
        for j in range(i + 1)
    )
