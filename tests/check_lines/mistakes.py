"""One edit of a formula, of the kinds that people make."""

import random
import re
from collections.abc import Iterator

from .robots import mechanism
from .trees import Tree, children, places, put


def edits(one: Tree, robot: str) -> Iterator[tuple[str, Tree]]:
    """All trees that differ from this one by an edit, each with its kind."""
    for at, part in places(one):
        for kind, new in _changed(part, robot):
            yield kind, put(one, at, new)


def _changed(part: Tree, robot: str) -> Iterator[tuple[str, Tree]]:
    match part[0]:
        case "add":
            yield from _terms(part[1])
        case "mul":
            yield from _factors(part[1])
        case "sym":
            yield from _symbols(part[1], robot)
        case "pow" if part[2] == 2:
            yield "exponent", part[1]
            yield "exponent", ("pow", part[1], 3)
        case "num" if part[1] not in (0, 1):
            yield "factor", ("num", part[1] * 2)
        case "div" if part[1][0] != "num" and part[2][0] != "num":
            yield "inverse", ("div", part[2], part[1])
        case "fun":
            yield from _functions(part)


def _negative(one: Tree) -> Tree:
    return one[1] if one[0] == "neg" else ("neg", one)


def _terms(terms: tuple[Tree, ...]) -> Iterator[tuple[str, Tree]]:
    for i, term in enumerate(terms):
        rest = terms[:i], terms[i + 1 :]
        yield "sign", ("add", (*rest[0], _negative(term), *rest[1]))
        left = (*rest[0], *rest[1])
        yield "missing", left[0] if len(left) == 1 else ("add", left)
        yield "twice", ("add", (*terms, term))


def _factors(factors: tuple[Tree, ...]) -> Iterator[tuple[str, Tree]]:
    for i in range(len(factors)):
        left = (*factors[:i], *factors[i + 1 :])
        yield "missing factor", left[0] if len(left) == 1 else ("mul", left)
    if factors[0][0] != "num":
        yield "factor", ("mul", (("num", 2), *factors))


def _symbols(key: str, robot: str) -> Iterator[tuple[str, Tree]]:
    m = mechanism(robot)
    known = set(m.values) | {x + y for x in m.coordinates for y in ("", "_d", "_dd")}
    found = re.fullmatch(r"([A-Za-z]+)(\d)((?:_dd?)?)", key)
    if found:
        letter, index, dots = found.groups()
        for i in "1234":
            if i != index and letter + i + dots in known:
                yield "index", ("sym", letter + i + dots)
        swaps = {"l": "lc", "lc": "l"}
        if letter in swaps and swaps[letter] + index in known:
            yield "length", ("sym", swaps[letter] + index)
    if key in known and re.match(r"th|d\d|x|y", key):
        if key.endswith("_dd"):
            yield "rate", ("sym", key[:-1])
        elif key.endswith("_d"):
            yield "rate", ("sym", key + "d")


def _functions(part: Tree) -> Iterator[tuple[str, Tree]]:
    name, arguments = part[1], part[2]
    if name in ("sin", "cos"):
        yield "function", ("fun", "cos" if name == "sin" else "sin", arguments)
        inside = arguments[0]
        if inside[0] == "add":
            yield "angle", ("fun", name, (inside[1][0],))
            yield "angle", ("fun", name, (inside[1][-1],))
    if name == "atan2":
        yield "arguments", ("fun", name, arguments[::-1])
    if name in ("asin", "acos"):
        yield "function", ("fun", "acos" if name == "asin" else "asin", arguments)


def mistaken(one: Tree, robot: str, rng: random.Random) -> tuple[str, Tree] | None:
    """One edit, drawn first by its kind and then by its place."""
    found = list(edits(one, robot))
    if one[0] in ("sym", "mul", "fun", "div", "neg", "pow", "add"):
        found.append(("sign", _negative(one)))
    if not found or (not children(one) and one[0] == "num"):
        return None
    kind = rng.choice(sorted({x for x, _ in found}))
    return kind, rng.choice([y for x, y in found if x == kind])
