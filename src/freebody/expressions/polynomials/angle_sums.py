"""Sums and products of sines and cosines: a polynomial's products written with sums of angles, and
pairs of such terms as products again: cos a + cos b = 2 cos ½(a+b) cos ½(a-b), and so on.

With b = 0 these are 1 + cos 2x = 2 cos²x and 1 - cos 2x = 2 sin²x.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache

from freebody.scalars.trig import Trig

Raw = list[tuple[dict[str, int], Fraction]]
"""Terms as `Trig.terms` gives them: {generator: exponent}, coefficient."""

SymbolPowers = tuple[tuple[str, int], ...]
"""Powers of symbols, (name, exponent)."""

TrigProduct = tuple[tuple[str, SymbolPowers, int], ...]
"""A product of functions (sin or cos, multiples of angles, exponent); () is 1."""

Exponents = tuple[tuple[int, int], ...]
"""Exponents of sine and cosine for each angle."""

AngleBlocks = tuple[tuple[str, ...], ...]
"""Angles that are gathered with one another, each in one block."""

TrigTerms = dict[tuple[SymbolPowers, TrigProduct], Fraction]
"""Coefficient of each monomial times wave."""


_Multiples = dict[str, int]


_InPowers = dict[tuple[tuple[int, ...], Exponents], tuple[int, int]]
"""Real and imaginary part by the powers of e^{ix} of the first angles, and the exponents of sine
and cosine of the others."""


def raw(x: Trig) -> Raw:
    """The terms of a polynomial."""
    return list(x.terms())


def as_products(terms: Raw, angles: tuple[str, ...]) -> TrigTerms:
    """The terms as products of powers of sines and cosines; sin² is restored where the normal form
    wrote (1 - cos²)."""
    result: TrigTerms = {}
    for powers, coefficient in terms:
        wave = tuple(
            (f, ((x, 1),), powers[f"{f}_{x}"])
            for x in angles
            for f in ("sin", "cos")
            if f"{f}_{x}" in powers
        )
        result[_rest(powers, angles), wave] = coefficient
    return _with_squares(result)


def _with_squares(terms: TrigTerms) -> TrigTerms:
    """The terms with a X - a X cos²x written as a X sin²x."""
    result = dict(terms)
    for (monomial, wave), coefficient in terms.items():
        for k, (f, argument, exponent) in enumerate(wave):
            if f != "cos" or exponent < 2:
                continue
            lower = (("cos", argument, exponent - 2),) if exponent > 2 else ()
            short = (monomial, wave[:k] + lower + wave[k + 1 :])
            here = (monomial, wave)
            if here in result and result.get(short) == -coefficient:
                squared = (("sin", argument, 2), *lower)
                if any(f == "sin" and a == argument for f, a, _ in wave):
                    continue
                del result[here]
                value = result.pop(short)
                result[monomial, wave[:k] + squared + wave[k + 1 :]] = value
                break
    return result


def gathered(terms: Raw, angles: tuple[str, ...], blocks: AngleBlocks) -> TrigTerms:
    """The terms with sines and cosines of sums of the angles within each block, the first multiple
    in each sum positive."""
    state: dict[tuple[SymbolPowers, TrigProduct, Exponents], Fraction] = {}
    for powers, coefficient in terms:
        exponents = tuple((powers.get(f"sin_{x}", 0), powers.get(f"cos_{x}", 0)) for x in angles)
        state[_rest(powers, angles), (), exponents] = coefficient
    for block in blocks:
        places = [angles.index(x) for x in block]
        parts: defaultdict[
            tuple[SymbolPowers, TrigProduct, Exponents], dict[Exponents, Fraction]
        ] = defaultdict(dict)
        for (monomial, wave, exponents), coefficient in state.items():
            ours = tuple(exponents[k] for k in places)
            others = tuple((0, 0) if k in places else e for k, e in enumerate(exponents))
            parts[monomial, wave, others][ours] = coefficient
        state = {
            (monomial, wave + own, others): value
            for (monomial, wave, others), part in parts.items()
            for own, value in _in_sums_of_angles(part, block)
        }
    return {(monomial, wave): value for (monomial, wave, _), value in state.items()}


def _rest(powers: dict[str, int], angles: tuple[str, ...]) -> SymbolPowers:
    """The part of a monomial without sines and cosines."""
    waves = {f"{f}_{x}" for x in angles for f in ("sin", "cos")}
    return tuple((name, e) for name, e in powers.items() if name not in waves)


def _in_sums_of_angles(
    part: dict[Exponents, Fraction], names: tuple[str, ...]
) -> Iterator[tuple[TrigProduct, Fraction]]:
    """A polynomial in the sines and cosines of a block's angles as a sum over waves.

    Angle by angle it becomes one in z = e^{ix}, with 2 cos x = z + 1/z and 2 sin x = -i (z - 1/z),
    in whole numbers.
    """
    degree = max(sum(s + c for s, c in exponents) for exponents in part)
    scale = math.lcm(*(value.denominator for value in part.values())) << degree
    laurent: _InPowers = {}
    for exponents, value in part.items():
        laurent[(), exponents] = (int(value * scale) >> sum(s + c for s, c in exponents), 0)
    for _ in names:
        laurent = _next_angle(laurent)
    for (multiples, _), (re, im) in laurent.items():
        first = next((k for k in multiples if k), 0)
        argument = tuple((x, k) for x, k in zip(names, multiples, strict=True) if k)
        if first == 0:
            yield (), Fraction(re, scale)
        elif first > 0:
            # the term with -k is the conjugate: together 2 re cos - 2 im sin
            if re:
                yield (("cos", argument, 1),), Fraction(2 * re, scale)
            if im:
                yield (("sin", argument, 1),), Fraction(-2 * im, scale)


def _next_angle(laurent: _InPowers) -> _InPowers:
    """A polynomial with the sine and cosine of its next angle replaced by powers of z."""
    wider: _InPowers = defaultdict(lambda: (0, 0))
    for (multiples, ((s, c), *later)), (re, im) in laurent.items():
        if s % 2:  # times -i
            re, im = im, -re
        for k, factor in _laurent(s, c):
            key = ((*multiples, k), tuple(later))
            x, y = wider[key]
            wider[key] = (x + factor * re, y + factor * im)
    return {key: value for key, value in wider.items() if value != (0, 0)}


@lru_cache(maxsize=256)
def _laurent(sines: int, cosines: int) -> tuple[tuple[int, int], ...]:
    """The Laurent polynomial (z - 1/z)^sines (z + 1/z)^cosines, which is i^sines times the wanted
    product; sines is 0 or 1."""
    powers = {0: 1}
    for sign in (-1,) * sines + (1,) * cosines:
        wider: defaultdict[int, int] = defaultdict(int)
        for k, value in powers.items():
            wider[k + 1] += value
            wider[k - 1] += sign * value
        powers = wider
    return tuple((k, value) for k, value in powers.items() if value)


def paired(terms: TrigTerms, blocks: AngleBlocks) -> TrigTerms:
    """The terms with two of them replaced by one product wherever their coefficients and angles
    allow it."""
    block_of = {x: k for k, block in enumerate(blocks) for x in block}
    candidates: defaultdict[tuple, list[tuple[TrigProduct, _Multiples]]] = defaultdict(list)
    for (monomial, wave), value in terms.items():
        for k, (f, argument, _) in enumerate(wave):
            rest = wave[:k] + wave[k + 1 :]
            key = (monomial, rest, f, block_of[argument[0][0]], abs(value))
            candidates[key].append((wave, dict(argument)))
    result = dict(terms)
    for (monomial, rest, f, _, value), rows in candidates.items():
        if f == "cos" and abs(terms.get((monomial, rest), 0)) == value:
            rows = [*rows, (rest, {})]
        _join(result, monomial, rest, f, rows)
    return result


def _join(
    result: TrigTerms,
    monomial: SymbolPowers,
    rest: TrigProduct,
    f: str,
    rows: list[tuple[TrigProduct, _Multiples]],
) -> None:
    """Replace pairs of terms by their products in `result`, in the order in which they are
    found."""
    left = [row for row in rows if (monomial, row[0]) in result]
    while left:
        wave, a = left.pop(0)
        for k, (other, b) in enumerate(left):
            half = _halves(a, b)
            if half is None:
                continue
            p, q = result[monomial, wave], result[monomial, other]
            sign, functions = _product(f, *half, p == q)
            joined = _sorted(rest + functions)
            if (monomial, joined) not in result:
                del result[monomial, wave], result[monomial, other], left[k]
                result[monomial, joined] = 2 * p * sign
                break


def _halves(a: _Multiples, b: _Multiples) -> tuple[_Multiples, _Multiples] | None:
    """The half sum ½(a + b) and half difference ½(a - b) of two angle sums; None where they are not
    whole."""
    names = list(dict.fromkeys([*a, *b]))
    total = {x: a.get(x, 0) + b.get(x, 0) for x in names}
    if any(k % 2 for k in total.values()):
        return None
    difference = {x: a.get(x, 0) - b.get(x, 0) for x in names}
    plus, minus = ({x: k // 2 for x, k in d.items() if k} for d in (total, difference))
    return plus, minus


def _product(f: str, plus: _Multiples, minus: _Multiples, equal: bool) -> tuple[int, TrigProduct]:
    """The sign and the functions of ½(a+b) and ½(a-b) whose product, times 2, is f(a) + f(b), or
    f(a) - f(b) where not `equal`."""
    kinds = {
        ("cos", True): (1, "cos", "cos"),
        ("cos", False): (-1, "sin", "sin"),
        ("sin", True): (1, "sin", "cos"),
        ("sin", False): (1, "cos", "sin"),
    }
    sign, first, second = kinds[f, equal]
    functions = []
    for kind, angle in ((first, plus), (second, minus)):
        if next(iter(angle.values()), 1) < 0:
            angle = {x: -k for x, k in angle.items()}
            sign = -sign if kind == "sin" else sign
        functions.append((kind, tuple(angle.items()), 1))
    if functions[0] == functions[1]:
        return sign, ((*functions[0][:2], 2),)
    return sign, tuple(functions)


def _sorted(wave: TrigProduct) -> TrigProduct:
    """Factors of a product in order, those with short arguments first."""
    return tuple(sorted(wave, key=lambda f: (len(f[1]), sum(abs(k) for _, k in f[1]), f[1], f[0])))
