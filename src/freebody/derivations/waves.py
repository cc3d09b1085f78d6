"""A polynomial's terms with its sines and cosines as products, or gathered into sines and cosines of sums of angles."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from fractions import Fraction

from freebody.scalars.trig import Trig

Raw = list[tuple[dict[str, int], Fraction]]
"""Terms as `Trig.terms` gives them: {generator: exponent}, coefficient."""

Monomial = tuple[tuple[str, int], ...]
"""Powers of symbols, (name, exponent)."""

Wave = tuple[tuple[str, Monomial, int], ...]
"""A product of functions (sin or cos, multiples of angles, exponent); () is 1."""

Terms = dict[tuple[Monomial, Wave], Fraction]
"""Coefficient of each monomial times wave."""


def raw(x: Trig) -> Raw:
    """The terms of a polynomial."""
    return list(x.terms())


def shortest(terms: Raw, angles: tuple[str, ...]) -> Terms:
    """Gathered or as products, whichever has fewer terms; gathered where they tie."""
    products = as_products(terms, angles)
    sums = gathered(terms, angles)
    return sums if len(sums) <= len(products) else products


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


def gathered(terms: Raw, angles: tuple[str, ...]) -> Terms:
    """Sums over sines and cosines of sums of angles, each with its first multiple positive."""
    result: defaultdict[tuple[Monomial, Wave], Fraction] = defaultdict(Fraction)
    for powers, coefficient in terms:
        monomial = _rest(powers, angles)
        for wave, part in _fourier(powers, angles):
            result[monomial, wave] += coefficient * part
    return {key: value for key, value in result.items() if value}


def _rest(powers: dict[str, int], angles: tuple[str, ...]) -> Monomial:
    """The monomial without its sines and cosines."""
    waves = {f"{f}_{x}" for x in angles for f in ("sin", "cos")}
    return tuple((name, e) for name, e in powers.items() if name not in waves)


def _fourier(powers: dict[str, int], angles: tuple[str, ...]) -> Iterable[tuple[Wave, Fraction]]:
    """One product of sines and cosines as a sum, through z = e^{ix}: cos = (z + 1/z)/2, sin = (z - 1/z)/2i."""
    laurent: dict[tuple[int, ...], Fraction] = {(): Fraction(1)}
    sines = 0
    for x in angles:
        s, c = powers.get(f"sin_{x}", 0), powers.get(f"cos_{x}", 0)
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
    for k, value in laurent.items():
        first = next((j for j in k if j), 0)
        if first == 0 and sines % 2 == 0:
            yield (), turn * value
        elif first > 0:
            argument = tuple((x, j) for x, j in zip(angles, k, strict=True) if j)
            yield (("sin" if sines % 2 else "cos", argument, 1),), 2 * turn * value
