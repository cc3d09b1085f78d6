"""Units as powers of kg, m and s, and their texts; several kinds of quantities share a unit."""

from __future__ import annotations

Unit = tuple[int, int, int]
"""Exponents of kg, m and s in a unit."""

NONE: Unit = (0, 0, 0)
LENGTH: Unit = (0, 1, 0)
SPEED: Unit = (0, 1, -1)
ACCELERATION: Unit = (0, 1, -2)
RATE: Unit = (0, 0, -1)
SECOND: Unit = (0, 0, -2)
MASS: Unit = (1, 0, 0)
INERTIA: Unit = (1, 2, 0)
FORCE: Unit = (1, 1, -2)
ENERGY: Unit = (1, 2, -2)
"""Unit of energies, and of moments."""
POWER: Unit = (1, 2, -3)
MOMENTUM: Unit = (1, 1, -1)
SPIN: Unit = (1, 2, -1)
"""Unit of an angular momentum."""

_TEXTS = {
    ENERGY: "N m", FORCE: "N", POWER: "W", RATE: "rad/s", SECOND: "rad/s²", NONE: "rad",
}  # fmt: skip
"""Units that are not written by kg, m and s."""


def si_text(unit: Unit, angular: bool = False) -> str:
    """The SI unit as text, such as N m, rad/s or kg m²; angular: whether a turn is named by
    radians."""
    text = _TEXTS.get(unit, "")
    return unit_text(unit) if not text or ("rad" in text and not angular) else text


def unit_text(unit: Unit) -> str:
    """A unit as text: kg m²/s²."""
    high = {1: "", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶"}
    letters = list(zip(("kg", "m", "s"), unit, strict=True))
    above = " ".join(f"{x}{high.get(e, f'^{e}')}" for x, e in letters if e > 0)
    below = " ".join(f"{x}{high.get(-e, f'^{-e}')}" for x, e in letters if e < 0)
    return f"{above or '1'}/{below}" if below else above or "no unit"
