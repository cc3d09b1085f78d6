"""Factors of polynomials in sines and cosines: l1 l2 sin θ2 from a sum of four terms (2.21, 2.22).

The ring of sines and cosines has no unique factors: 1 - cos²θ is (1 - cos θ)(1 + cos θ) and sin θ ·
sin θ. Polynomials in S = sin θ/2 and C = cos θ/2, of one even degree in each pair, have: sin θ = 2
S C, cos θ = C² - S². So x is written with t = S/C, factored, and factors that are odd in some half
angle are multiplied in pairs, so that whole angles come back: sin θ = 2 S · C, cos θ = (C - S)(C +
S), sin(θ2 + θ3) from the sine and cosine of (θ2 + θ3)/2.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import combinations
from typing import Any

from freebody.scalars.trig import Trig, TrigRing

Parity = tuple[int, ...]
_MANY = 8  # odd factors of one kind from which on they are paired in the order they come


@dataclass(frozen=True)
class _Half:
    """A factor as a polynomial in t, the tangent of half of each angle; degree: its degree in sine
    and cosine of each half angle."""

    poly: Any
    degree: tuple[int, ...]

    def __hash__(self) -> int:
        return hash((len(self.poly), self.degree))  # FLINT's polynomials have no hash

    @property
    def parity(self) -> Parity:
        """The half angles in which the factor is odd, as 1 or 0 for each."""
        return tuple(d % 2 for d in self.degree)


def factored(x: Trig) -> tuple[Fraction, list[tuple[Trig, int]]]:
    """(number, [(factor, exponent)]) with number · Π factor^exponent = x, each factor with whole
    coefficients."""
    ring = x.ring
    halves: Counter[_Half] = Counter()
    for factor, exponent in x.factors():
        for half, inner in _halves(ring, factor):
            halves[half] += exponent * inner
    found: Counter[Trig] = Counter()
    for group, exponent in _whole(ring, halves):
        found[_primitive(_back(ring, group))] += exponent
    factors = [(f, e) for f, e in found.items() if not f.is_constant]
    product = reduce(
        lambda a, b: a * b, (f**e for f, e in factors), Trig(ring, ring.constant(1), 0)
    )
    number = x.leading_coefficient / product.leading_coefficient
    if product * number != x:  # never seen; a factorisation is only given with its proof
        return x.leading_coefficient, [(x / x.leading_coefficient, 1)]
    return number, sorted(factors, key=lambda row: (len(row[0]), str(row[0])))


def _halves(ring: TrigRing, x: Trig) -> list[tuple[_Half, int]]:
    """The irreducible factors of x in half angles, with exponents. The generator cos(x) serves as
    t, since no sines and cosines are left."""
    n = len(ring.angles)
    poly, degrees = _in_tangents(ring, x)
    _, rows = poly.factor()
    factors = [_Half(f, tuple(int(f.degrees()[2 * k + 1]) for k in range(n))) for f, _ in rows]
    result = [
        (half, int(e))
        for half, (f, e) in zip(factors, rows, strict=True)
        if not any(f == ring.generators[2 * k + 1] ** 2 + 1 for k in range(n))  # S² + C² = 1
    ]
    unit = ring.context.constant(1)
    for k in range(n):  # what is missing of the degree are factors C
        left = degrees[k] - sum(
            half.degree[k] * int(e) for half, (_, e) in zip(factors, rows, strict=True)
        )
        if left:
            result.append((_Half(unit, tuple(int(j == k) for j in range(n))), left))
    return result


def _in_tangents(ring: TrigRing, x: Trig) -> tuple[Any, tuple[int, ...]]:
    """(polynomial, degrees): x · Π (1 + t²)^d as a polynomial in t = tan of half of each angle, and
    its degrees 2 d in half-angle sines and cosines."""
    n = len(ring.angles)
    rows = [(powers, c) for powers, c in x.poly.to_dict().items()]
    d = [max((m[2 * k] + m[2 * k + 1] for m, _ in rows), default=0) for k in range(n)]
    total = ring.context.constant(0)
    cache: dict[tuple[int, int, int], Any] = {}

    def part(k: int, s: int, c: int) -> Any:
        if (k, s, c) not in cache:
            t = ring.generators[2 * k + 1]
            cache[k, s, c] = (2 * t) ** s * (1 - t**2) ** c * (1 + t**2) ** (d[k] - s - c)
        return cache[k, s, c]

    groups: dict[tuple[int, ...], dict[tuple[int, ...], Any]] = {}
    for m, coefficient in rows:
        waves, rest = m[: 2 * n], (0,) * (2 * n) + m[2 * n :]
        groups.setdefault(waves, {})[rest] = coefficient
    for waves, rest in groups.items():
        term = ring.context.from_dict(rest)
        for k in range(n):
            if d[k]:
                term = term * part(k, waves[2 * k], waves[2 * k + 1])
        total = total + term
    return total, tuple(2 * x for x in d)


# ---------------------------------------------------------------- back to whole angles
def _whole(ring: TrigRing, halves: Counter[_Half]) -> list[tuple[tuple[_Half, ...], int]]:
    """Groups of half-angle factors whose products are polynomials in whole angles, with
    exponents."""
    groups = [((half,), e) for half, e in halves.items() if not any(half.parity)]
    by_parity: dict[Parity, Counter[_Half]] = {}
    for half, e in halves.items():
        if any(half.parity):
            by_parity.setdefault(half.parity, Counter())[half] = e
    left: list[_Half] = []
    for odd in by_parity.values():
        pairs, alone = _paired(ring, odd)
        groups += pairs
        left += alone
    return groups + _leftover(left)


def _paired(
    ring: TrigRing, odd: Counter[_Half]
) -> tuple[list[tuple[tuple[_Half, ...], int]], list[_Half]]:
    """Pairs of odd factors with exponents (different factors first, those with the shortest
    products, then squares), and the factors left over, at most one."""
    groups: list[tuple[tuple[_Half, ...], int]] = []
    odd = Counter(odd)
    choices = list(combinations(odd, 2))
    if len(odd) <= _MANY:
        choices.sort(key=lambda pair: _cost(_back(ring, pair)))
    for a, b in choices:
        exponent = min(odd[a], odd[b])
        if exponent:
            groups.append(((a, b), exponent))
            odd -= Counter({a: exponent, b: exponent})
    alone = []
    for half, exponent in odd.items():
        if exponent // 2:
            groups.append(((half, half), exponent // 2))
        alone += [half] * (exponent % 2)
    return groups, alone


def _cost(x: Trig) -> tuple[int, int]:
    return len(x), sum(sum(m) for m in x.poly.to_dict())


def _leftover(left: list[_Half]) -> list[tuple[tuple[_Half, ...], int]]:
    """Groups of left-over factors, as small as possible, whose products are polynomials in whole
    angles."""
    groups: list[tuple[tuple[_Half, ...], int]] = []
    size = 2
    while left and size <= len(left):
        found = next((c for c in combinations(left, size) if _is_whole(c)), None)
        if found is None:
            size += 1
            continue
        groups.append((found, 1))
        for half in found:
            left.remove(half)
    return groups + ([(tuple(left), 1)] if left else [])


def _is_whole(halves: tuple[_Half, ...]) -> bool:
    return not any(sum(column) % 2 for column in zip(*(h.parity for h in halves), strict=True))


def _back(ring: TrigRing, halves: tuple[_Half, ...]) -> Trig:
    """The product of half-angle factors as polynomial in sines and cosines of whole angles."""
    n = len(ring.angles)
    poly = reduce(lambda a, b: a * b, (h.poly for h in halves))
    degree = [sum(h.degree[k] for h in halves) for k in range(n)]
    total = Trig(ring, ring.constant(0), 0)
    for m, coefficient in poly.to_dict().items():
        term = Trig(ring, ring.context.from_dict({(0,) * (2 * n) + m[2 * n :]: coefficient}), 0)
        for k, angle in enumerate(ring.angles):
            if degree[k]:
                term = term * _monomial(ring, angle, m[2 * k + 1], degree[k] - m[2 * k + 1])
        total = total + term
    return total


def _monomial(ring: TrigRing, angle: str, S: int, C: int) -> Any:
    """S^s C^c of half an angle, s + c even: S² = (1 - cos)/2, C² = (1 + cos)/2, S C = sin/2."""
    value: Any = Trig(ring, ring.constant(1), 0)
    if S % 2:
        value = ring.sin(angle) * Fraction(1, 2)
        S, C = S - 1, C - 1
    cosine = ring.cos(angle)
    for _ in range(S // 2):
        value = value * (1 - cosine) * Fraction(1, 2)
    for _ in range(C // 2):
        value = value * (1 + cosine) * Fraction(1, 2)
    return value


def _primitive(x: Trig) -> Trig:
    """x over the number that makes its coefficients whole and without common divisor, the first
    positive."""
    import math

    coefficients = [c for _, c in x.terms()]
    top = math.gcd(*(c.numerator for c in coefficients))
    below = math.lcm(*(c.denominator for c in coefficients))
    content = Fraction(top, below)
    return x / (content if coefficients[0] > 0 else -content)
