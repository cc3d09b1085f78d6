"""A body that nothing holds: what answers call its symbols, and its quantities: vectors by
components in its own axes, p and gravity in the world's, and its energies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, ClassVar

from freebody.expressions.grammar.dotted_names import spellings
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.answer_tree import Angle
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup, inverse
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.methods.free_body_steps import PLACES, XYZ, FreeBody
from freebody_textbook.methods.setting import Setting

ENDINGS = ("", RATE, SECOND)
_COMPONENTS = {"omega": ("omega", "w"), "v": ("v",), "f": ("f", "F"), "n": ("n", "M", "tau", "N")}
"""Letters of vectors, whose components have x, y, z behind."""
_ALONE = {"omega": "pqr", "v": "uvw"}
"""Letters of their components."""
_ANGLES = ("psi", "theta", "phi")
"""Yaw, pitch and roll."""


def symbols(setting: RightEquations) -> Iterator[tuple[str, Trig]]:
    """Spellings with their values."""
    ring = setting.ring
    for name, letter in angles(setting):
        for dots, ending in enumerate(ENDINGS):
            yield from ((x, ring[name + ending]) for x in spellings(letter, "", dots))
    for k, axis in enumerate(XYZ):
        yield from _along(setting, k, axis)
        yield from ((f"{x}{_ANGLES[2 - k]}", ring[f"n_{axis}"]) for x in ("tau", "M"))
        if f"I{axis}" in ring.index:
            for x in (f"I{axis}{axis}", f"J{axis}", f"J{axis}{axis}"):
                yield x, ring[f"I{axis}"]
    for name in ring.names:
        if name[0] == "T" and name[1:].isdigit():
            yield from ((f"{x}{name[1:]}", ring[name]) for x in ("F", "f"))
    if "l" in ring.index:
        yield "d", ring["l"]


def _along(setting: RightEquations, k: int, axis: str) -> Iterator[tuple[str, Trig]]:
    """Spellings of the components of vectors along an axis."""
    ring = setting.ring
    for vector, letters in _COMPONENTS.items():
        for dots, ending in enumerate(ENDINGS):
            name = f"{vector}_{axis}{ending}"
            if name not in ring.index:
                continue
            for letter in letters:
                yield from ((x, ring[name]) for x in spellings(letter, axis, dots))
            if vector in _ALONE:
                yield from ((x, ring[name]) for x in spellings(_ALONE[vector][k], "", dots))


def angles(setting: RightEquations) -> Iterator[tuple[str, str]]:
    """Yaw, pitch and roll with their letters."""
    return zip(setting.symbols.coordinates[3:PLACES], _ANGLES, strict=True)


def waves(setting: RightEquations) -> Iterator[tuple[str, tuple[str, Angle]]]:
    """cφ, sθ: the function and the angle."""
    for name, letter in angles(setting):
        for x, function in (("c", "cos"), ("s", "sin")):
            yield x + letter, (function, ((name, 1),))


_VECTORS = (
    ("v", ("v",), "the velocity of the body's origin"),
    ("omega", ("omega", "w"), "the angular velocity of the body"),
    ("f", ("f", "F"), "the force on the body besides its weight"),
    ("n", ("n", "M", "tau", "N"), "the moment on the body"),
)
"""Letter of the symbols, letters in answers, and what it is."""


class FreeBodyQuantities(QuantityGroup):
    """v, ω, f, n, p, R, I, T, V, L."""

    in_equations_of_bodies: ClassVar[Mapping[str, str]] = {"g": "gravity"}

    @cached_property
    def _body(self) -> FreeBody:
        symbols = self.setting.symbols
        return FreeBody(Setting(symbols), symbols.given or symbols.model, 0)

    def single(self) -> Iterator[NamedTarget]:
        eq = self.setting.equations
        yield self.letters["T"], AskedQuantity(kinds.KINETIC, (), self.entry("T"))
        yield self.letters["V"], AskedQuantity(kinds.POTENTIAL, (), self.entry("V"))
        yield (
            self.letters["L"],
            AskedQuantity(kinds.LAGRANGIAN, (), self.element(lambda: eq.T - eq.V)),
        )

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        ring, body = self.setting.ring, self._body
        found: dict[str, QuantityTable] = {}
        for name, letters, words in _VECTORS:
            for dots, ending in enumerate(("", RATE)):
                if f"{name}_x{ending}" in ring.index:
                    values = [ring[x] for x in body.components(name, ending)]
                    column = _column(values, words, is_angular=name == "omega")
                    for letter in letters:
                        found |= dict.fromkeys(spellings(letter, "", dots), column)
        places = body.coordinates[:3]
        for dots, ending in enumerate(("", RATE, SECOND)):
            column = _column([ring[x + ending] for x in places], "the position of the body")
            for letter in ("p", "r"):
                found |= dict.fromkeys(spellings(letter, "", dots), column)
        s = body.s
        found["gravity"] = _column(map(s.symbols.element, s.tree.gravity), "gravity")
        inertia = _matrix(s.inertia(body.i), s.symbols.element, "the inertia of the body")
        turned = _matrix(s.world[body.i][0], s.symbols.element, "the orientation of the body")
        inverted = inverse(
            self.setting, [[x.polynomial for x in row] for row in inertia], "the inertia"
        )
        names = (
            ("I", inertia),
            ("J", inertia),
            (f"I{INVERSE}", inverted),
            (f"J{INVERSE}", inverted),
        )
        return found | dict(names) | {"R": turned}


def _column(values: Iterable[Trig], words: str, is_angular: bool = False) -> QuantityTable:
    def entry(axis: str, x: Trig) -> AskedQuantity:
        value = _constant(x)
        return AskedQuantity(
            kinds.OF_BODY, (), value, axis=axis, words=words, is_angular=is_angular
        )

    return [[entry(axis, x)] for axis, x in zip(XYZ, values, strict=True)]


def _matrix(
    rows: Iterable[Iterable[Any]], element: Callable[[Any], Trig], words: str
) -> QuantityTable:
    return [
        [
            AskedQuantity(kinds.OF_BODY, (i, j), _constant(element(x)), words=words)
            for j, x in enumerate(row, 1)
        ]
        for i, row in enumerate(rows, 1)
    ]


def _constant(x: Trig) -> Callable[[], Trig]:
    return lambda: x
