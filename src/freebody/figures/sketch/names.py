"""What things are called in a drawing: joints O, A, B, …, the tip P, forces with the bodies between which they act."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass


def lettered(n: int) -> str:
    """The joint of body n from 1: O, A, B, …"""
    return "O" if n == 1 else chr(ord("A") + (n - 2) % 14)


def numbered(n: int) -> str:
    """The number of a body."""
    return str(n)


def between(before: str, n: str) -> str:
    """Subscript of a force of body `before` on body n."""
    return f"{before},{n}"


@dataclass(frozen=True)
class Names:
    """How a drawing calls its parts; `index` turns a body's number (0: the ground) into a subscript."""

    index: Callable[[int], str] = numbered
    point: Callable[[int], str] = lettered
    tip: str = "P"
    force: Callable[[str, str], str] = between
    letter: str = "f"
    """Of forces."""
    moment: str = ""
    """Of the moment at any joint, with the body's number; default: τ at turns in the plane, else n with two."""
    slide: str = "z"
    """Of the direction of a prismatic joint."""
    load: str = "f"
    """Of a force on the tip."""

    def on(self, symbol: str, n: int, prefix: str = "") -> str:
        """A symbol with the subscript of body n, if it has one."""
        low = prefix + self.index(n)
        return f"{symbol}_{{{low}}}" if len(low) > 1 else f"{symbol}_{low}" if low else symbol

    def reaction(self, before: int, n: int) -> str:
        """The force of body `before` on body n."""
        return f"{self.letter}_{{{self.force(self.index(before), self.index(n))}}}"


def bold(name: str) -> str:
    """A vector's label: its letters bold; a sign in front, a subscript and what is in brackets stay as they are."""
    sign, rest = (name[0], name[1:]) if name[0] in "−-" else ("", name)
    letters = re.split(r"[_^(]", rest, maxsplit=1)[0]
    return f"{sign}*{letters}*{rest[len(letters) :]}"
