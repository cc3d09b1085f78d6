"""How names with dots are written."""

from __future__ import annotations

from collections.abc import Iterable

from freebody.expressions.grammar.words import DOT, PRIME


def spellings(letter: str, k: str, dots: int) -> Iterable[str]:
    """Ways to write a letter with number k and dots: theta1_d, dtheta1, theta_dot_1, theta1',
    θ̇₁."""
    if dots == 0:
        return (f"{letter}{k}",)
    d, dot = "d" * dots, "d" * (dots - 1) + "dot"
    return dict.fromkeys((
        DOT * dots + f"{letter}{k}",
        f"{letter}{k}{PRIME * dots}", f"{letter}{PRIME * dots}{k}",
        f"{letter}{k}{d}", f"{d}{letter}{k}", f"{letter}{d}{k}",
        f"{letter}{k}{dot}", f"{letter}{dot}{k}", f"{letter}{k}{'dot' * dots}",
        f"{letter}{'dot' * dots}{k}",
    ))  # fmt: skip
