"""A polynomial's terms with its sines and cosines as products, or gathered into sines and cosines of sums of angles."""

from __future__ import annotations

from collections import defaultdict
from fractions import Fraction
from functools import lru_cache

from freebody.scalars.trig import Trig

Raw = list[tuple[dict[str, int], Fraction]]
"""Terms as `Trig.terms` gives them: {generator: exponent}, coefficient."""

Monomial = tuple[tuple[str, int], ...]
"""Powers of symbols, (name, exponent)."""

Wave = tuple[tuple[str, Monomial, int], ...]
"""A product of functions (sin or cos, multiples of angles, exponent); () is 1."""

Blocks = tuple[tuple[str, ...], ...]
"""Angles that are gathered with one another, each in one block."""

Terms = dict[tuple[Monomial, Wave], Fraction]
"""Coefficient of each monomial times wave."""


def raw(x: Trig) -> Raw:
    """The terms of a polynomial."""
    return list(x.terms())


def as_products(terms: Raw, angles: tuple[str, ...]) -> Terms:
    """Products of powers of sines and cosines; a (1 - cos²) that the normal form spelt out is sin² again."""
    result: Terms = {}
    for powers, coefficient in terms:
        wave = tuple(
            (f, ((x, 1),), powers[f"{f}_{x}"]) for x in angles for f in ("sin", "cos") if f"{f}_{x}" in powers
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
    result: defaultdict[tuple[Monomial, Wave], Fraction] = defaultdict(Fraction)
    index = {f"{f}_{x}": 2 * k + (f == "cos") for k, x in enumerate(angles) for f in ("sin", "cos")}
    places = tuple(tuple(angles.index(x) for x in block) for block in blocks)
    for powers, coefficient in terms:
        exponents = [0] * (2 * len(angles))
        monomial = []
        for name, exponent in powers.items():
            if name in index:
                exponents[index[name]] = exponent
            else:
                monomial.append((name, exponent))
        rest = tuple(monomial)
        for wave, part in _fourier(tuple(exponents), angles, places):
            result[rest, wave] += coefficient * part
    return {key: value for key, value in result.items() if value}


def _rest(powers: dict[str, int], angles: tuple[str, ...]) -> Monomial:
    """The monomial without its sines and cosines."""
    waves = {f"{f}_{x}" for x in angles for f in ("sin", "cos")}
    return tuple((name, e) for name, e in powers.items() if name not in waves)


@lru_cache(maxsize=50_000)
def _fourier(
    exponents: tuple[int, ...], angles: tuple[str, ...], blocks: tuple[tuple[int, ...], ...]
) -> list[tuple[Wave, Fraction]]:
    """A product of sines and cosines as a sum of products of one function a block."""
    total: list[tuple[Wave, Fraction]] = [((), Fraction(1))]
    for block in blocks:
        if any(exponents[2 * k] or exponents[2 * k + 1] for k in block):
            ours = _of_block(tuple((exponents[2 * k], exponents[2 * k + 1]) for k in block))
            names = [angles[k] for k in block]
            total = [(wave + _wave(f, names, k), a * value) for wave, a in total for f, k, value in ours]
    return total


def _wave(f: str, names: list[str], multiples: tuple[int, ...]) -> Wave:
    argument = tuple((x, k) for x, k in zip(names, multiples, strict=True) if k)
    return ((f, argument, 1),) if argument else ()


def _of_block(exponents: tuple[tuple[int, int], ...]) -> list[tuple[str, tuple[int, ...], Fraction]]:
    """One product as a sum of (sin or cos, multiples, value): cos x = (z + 1/z)/2, sin x = (z - 1/z)/2i, z = e^{ix}."""
    laurent: dict[tuple[int, ...], Fraction] = {(): Fraction(1)}
    sines = 0
    for s, c in exponents:
        sines += s
        factor = {0: Fraction(1)}
        for sign in (-1,) * s + (1,) * c:
            wider: defaultdict[int, Fraction] = defaultdict(Fraction)
            for k, value in factor.items():
                wider[k + 1] += value / 2
                wider[k - 1] += sign * value / 2
            factor = wider
        laurent = {(*k, j): a * b for k, a in laurent.items() for j, b in factor.items() if b}
    turn = (-1) ** (sines // 2)  # i⁻ˢ = ±1, or ∓i, which the sine takes up
    rows = []
    for k, value in laurent.items():
        first = next((j for j in k if j), 0)
        if first == 0 and sines % 2 == 0:
            rows.append(("cos", k, turn * value))
        elif first > 0:
            rows.append(("sin" if sines % 2 else "cos", k, 2 * turn * value))
    return rows
