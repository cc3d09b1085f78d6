"""Sums of two sines or cosines with one factor written as products: cos a + cos b = 2 cos ½(a+b)
cos ½(a-b), and so on.

With b = 0 these are 1 + cos 2x = 2 cos²x and 1 - cos 2x = 2 sin²x.
"""

from __future__ import annotations

from collections import defaultdict

from freebody.expressions.polynomials.angle_sums import Blocks, Monomial, Terms, Wave

Angle = dict[str, int]


def paired(terms: Terms, blocks: Blocks) -> Terms:
    """Gathered terms, two of them made one product wherever their coefficients and angles allow
    it."""
    block_of = {x: k for k, block in enumerate(blocks) for x in block}
    candidates: defaultdict[tuple, list[tuple[Wave, Angle]]] = defaultdict(list)
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
    result: Terms, monomial: Monomial, rest: Wave, f: str, rows: list[tuple[Wave, Angle]]
) -> None:
    """Replaces pairs of rows, first come first served."""
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


def _halves(a: Angle, b: Angle) -> tuple[Angle, Angle] | None:
    """½(a + b) and ½(a - b), if they are whole."""
    names = list(dict.fromkeys([*a, *b]))
    total = {x: a.get(x, 0) + b.get(x, 0) for x in names}
    if any(k % 2 for k in total.values()):
        return None
    difference = {x: a.get(x, 0) - b.get(x, 0) for x in names}
    plus, minus = ({x: k // 2 for x, k in d.items() if k} for d in (total, difference))
    return plus, minus


def _product(f: str, plus: Angle, minus: Angle, equal: bool) -> tuple[int, Wave]:
    """f(a) + f(b) (or f(a) - f(b) where not `equal`) as sign · 2 · product of functions of ½(a+b)
    and ½(a-b)."""
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


def _sorted(wave: Wave) -> Wave:
    """Short arguments first."""
    return tuple(sorted(wave, key=lambda f: (len(f[1]), sum(abs(k) for _, k in f[1]), f[1], f[0])))
