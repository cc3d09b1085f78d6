"""What answers call the symbols of a body that nothing holds."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.answer_tree import Angle
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.methods.free_body_steps import PLACES, XYZ

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
    """Components of vectors."""
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
