"""A polynomial's terms with its sines and cosines as products, or gathered into sines and cosines
of sums of angles."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache

from freebody.scalars.trig import Trig

Raw = list[tuple[dict[str, int], Fraction]]
"""Terms as `Trig.terms` gives them: {generator: exponent}, coefficient."""

Monomial = tuple[tuple[str, int], ...]
"""Powers of symbols, (name, exponent)."""

Wave = tuple[tuple[str, Monomial, int], ...]
"""A product of functions (sin or cos, multiples of angles, exponent); () is 1."""

Exponents = tuple[tuple[int, int], ...]
"""Exponents of sine and cosine for each angle."""

Blocks = tuple[tuple[str, ...], ...]
"""Angles that are gathered with one another, each in one block."""

Terms = dict[tuple[Monomial, Wave], Fraction]
"""Coefficient of each monomial times wave."""


def raw(x: Trig) -> Raw:
    """The terms of a polynomial."""
    return list(x.terms())


def as_products(terms: Raw, angles: tuple[str, ...]) -> Terms:
    """Products of powers of sines and cosines; a (1 - cos²) that the normal form spelt out is sin²
    again."""
    result: Terms = {}
    for powers, coefficient in terms:
        wave = tuple(
            (f, ((x, 1),), powers[f"{f}_{x}"])
            for x in angles
            for f in ("sin", "cos")
            if f"{f}_{x}" in powers
        )
        result[_rest(powers, angles), wave] = coefficient
    return _with_squares(result)


def _with_squares(terms: Terms) -> Terms:
    """a X - a X cos²x written a X sin²x."""
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


def gathered(terms: Raw, angles: tuple[str, ...], blocks: Blocks) -> Terms:
    """Sines and cosines of sums of the angles of a block, each with its first multiple positive."""
    state: dict[tuple[Monomial, Wave, Exponents], Fraction] = {}
    for powers, coefficient in terms:
        exponents = tuple((powers.get(f"sin_{x}", 0), powers.get(f"cos_{x}", 0)) for x in angles)
        state[_rest(powers, angles), (), exponents] = coefficient
    for block in blocks:
        places = [angles.index(x) for x in block]
        parts: defaultdict[tuple[Monomial, Wave, Exponents], dict[Exponents, Fraction]] = (
            defaultdict(dict)
        )
        for (monomial, wave, exponents), coefficient in state.items():
            ours = tuple(exponents[k] for k in places)
            others = tuple((0, 0) if k in places else e for k, e in enumerate(exponents))
            parts[monomial, wave, others][ours] = coefficient
        state = {
            (monomial, wave + own, others): value
            for (monomial, wave, others), part in parts.items()
            for own, value in _waves(part, block)
        }
    return {(monomial, wave): value for (monomial, wave, _), value in state.items()}


def _rest(powers: dict[str, int], angles: tuple[str, ...]) -> Monomial:
    """The monomial without its sines and cosines."""
    waves = {f"{f}_{x}" for x in angles for f in ("sin", "cos")}
    return tuple((name, e) for name, e in powers.items() if name not in waves)


def _waves(
    part: dict[Exponents, Fraction], names: tuple[str, ...]
) -> Iterator[tuple[Wave, Fraction]]:
    """A polynomial in the sines and cosines of a block's angles as a sum over waves.

    Angle by angle it becomes one in z = e^{ix}, with 2 cos x = z + 1/z and 2 sin x = -i (z - 1/z),
    in whole numbers.
    """
    degree = max(sum(s + c for s, c in exponents) for exponents in part)
    scale = math.lcm(*(value.denominator for value in part.values())) << degree
    laurent: dict[tuple[tuple[int, ...], Exponents], tuple[int, int]] = {}
    for exponents, value in part.items():
        laurent[(), exponents] = (int(value * scale) >> sum(s + c for s, c in exponents), 0)
    for _ in names:
        wider: defaultdict[tuple[tuple[int, ...], Exponents], tuple[int, int]] = defaultdict(
            lambda: (0, 0)
        )
        for (multiples, ((s, c), *later)), (re, im) in laurent.items():
            if s % 2:  # times -i
                re, im = im, -re
            for k, factor in _laurent(s, c):
                key = ((*multiples, k), tuple(later))
                x, y = wider[key]
                wider[key] = (x + factor * re, y + factor * im)
        laurent = {key: value for key, value in wider.items() if value != (0, 0)}
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


@lru_cache(maxsize=256)
def _laurent(sines: int, cosines: int) -> tuple[tuple[int, int], ...]:
    """(z - 1/z)^sines (z + 1/z)^cosines, up to i^sines; sines is 0 or 1."""
    powers = {0: 1}
    for sign in (-1,) * sines + (1,) * cosines:
        wider: defaultdict[int, int] = defaultdict(int)
        for k, value in powers.items():
            wider[k + 1] += value
            wider[k - 1] += sign * value
        powers = wider
    return tuple((k, value) for k, value in powers.items() if value)
