"""Quantities of a free body: symbols and their spellings in answers, vectors in body axes, the
position p and gravity in world axes, energies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Angle
from freebody_textbook.check.asked.group import (
    NamedTarget,
    QuantityGroup,
    column,
    inverse,
    matrix,
    values,
)
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.methods.free_body_steps import PLACES, XYZ, FreeBody
from freebody_textbook.methods.setting import Setting

ENDINGS = ("", RATE, SECOND)
_VECTORS = (
    ("v", ("v",), "the velocity of the body's origin"),
    ("omega", ("omega", "w"), "the angular velocity of the body"),
    ("f", ("f", "F"), "the force on the body besides its weight"),
    ("n", ("n", "M", "tau", "N"), "the moment on the body"),
)
"""Letter of the symbols, letters in answers, whose components have x, y, z behind, and words."""
_ALONE = {"omega": "pqr", "v": "uvw"}
"""Letters of their components."""
_ANGLES = ("psi", "theta", "phi")
"""Names of yaw, pitch and roll."""


def symbols(setting: RightEquations) -> Iterator[tuple[str, Trig]]:
    """Spellings of a free body's coordinates in answers, with the polynomial of each."""
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
    """Spellings of vectors' components along one axis, with the polynomial of each."""
    ring = setting.ring
    for vector, letters, _ in _VECTORS:
        for dots, ending in enumerate(ENDINGS):
            name = f"{vector}_{axis}{ending}"
            if name not in ring.index:
                continue
            for letter in letters:
                yield from ((x, ring[name]) for x in spellings(letter, axis, dots))
            if vector in _ALONE:
                yield from ((x, ring[name]) for x in spellings(_ALONE[vector][k], "", dots))


def angles(setting: RightEquations) -> Iterator[tuple[str, str]]:
    """Names of yaw, pitch and roll, each with its letter."""
    return zip(setting.symbols.coordinates[3:PLACES], _ANGLES, strict=True)


def waves(setting: RightEquations) -> Iterator[tuple[str, tuple[str, Angle]]]:
    """Abbreviations such as cφ and sθ with the function and the angle that they mean."""
    for name, letter in angles(setting):
        for x, function in (("c", "cos"), ("s", "sin")):
            yield x + letter, (function, ((name, 1),))


class FreeBodyQuantities(QuantityGroup):
    """Quantities of a free body: v, ω, f, n, p, R, I, T, V, L."""

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
                    own = values(ring[x] for x in body.components(name, ending))
                    table = column(kinds.OF_BODY, own, words, is_angular=name == "omega")
                    for letter in letters:
                        found |= dict.fromkeys(spellings(letter, "", dots), table)
        for dots, ending in enumerate(ENDINGS):
            own = values(ring[x + ending] for x in body.coordinates[:3])
            table = column(kinds.OF_BODY, own, "the position of the body")
            for letter in ("p", "r"):
                found |= dict.fromkeys(spellings(letter, "", dots), table)
        s, element = body.s, body.s.symbols.element
        found["gravity"] = column(kinds.OF_BODY, values(map(element, s.tree.gravity)), "gravity")
        inertia, turned = (
            matrix(kinds.OF_BODY, [values(map(element, row)) for row in rows], words)
            for rows, words in (
                (s.inertia(body.i), "the inertia of the body"),
                (s.world[body.i][0], "the orientation of the body"),
            )
        )
        inverted = inverse(
            self.setting, [[x.polynomial for x in row] for row in inertia], "the inertia"
        )
        for letter in "IJ":
            found |= {letter: inertia, letter + INVERSE: inverted}
        return found | {"R": turned}
