"""Names as structured values: letter, index, dots, and how they are written. All code that needs a
name's letter or number asks here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from string import ascii_letters, digits

from freebody.expressions.grammar.tables.characters import DOT, PRIME

_DOTS = {"_dd": 2, "_d": 1}
"""Endings of names of rates."""
_PLACES = frozenset((*digits, *"ihk"))
"""A link's number, or a letter that stands for such a number."""


@dataclass(frozen=True)
class Atom:
    """A name taken apart: θ̇₁ is the letter theta with the index 1 and a dot; R2_1 has the indices
    2 and 1."""

    letter: str
    index: tuple[str, ...] = ()
    dots: int = 0
    primes: int = 0

    @property
    def figures(self) -> str:
        """All digits of the index; "" where it has none."""
        return "".join(c for part in self.index for c in part if c.isdigit())

    @property
    def is_numbered(self) -> bool:
        """Whether the index is one number."""
        return len(self.index) == 1 and self.index[0].isdigit()

    @property
    def is_figures(self) -> bool:
        """Whether the index consists of digits, in one part or several."""
        return bool(self.index) and all(part.isdigit() for part in self.index)

    @property
    def ending(self) -> str:
        """The ending of the name that stands for its dots: _d, _dd or nothing."""
        return "_" + "d" * self.dots if self.dots else ""


@lru_cache(maxsize=8192)
def atom(name: str) -> Atom:
    """The atom of a name as code or the plain spelling has it: theta1_d, ˙theta1, R2_1, I2_xy."""
    bare = name.lstrip(DOT)
    dots = len(name) - len(bare)
    unprimed = bare.replace(PRIME, "")
    ending = next((x for x in _DOTS if unprimed.endswith(x) and len(unprimed) > len(x)), "")
    rest = unprimed.removesuffix(ending).lstrip(ascii_letters)
    letter = unprimed.removesuffix(ending)[: len(unprimed) - len(ending) - len(rest)]
    index = tuple(rest.removeprefix("_").split("_")) if rest else ()
    return Atom(letter, index, dots + _DOTS.get(ending, 0), len(bare) - len(unprimed))


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


def undotted(name: str) -> str:
    """The coordinate's name from that of its rate or acceleration, in the spelling of code: theta1
    of theta1_dd; any other name itself."""
    return name.removesuffix(atom(name).ending)


def unprimed(name: str) -> str:
    """The name without the ending of one with a prime: omega of omega_prime."""
    return name.removesuffix("_prime")


def between(name: str) -> tuple[str, ...]:
    """The letter, the upper and the lower place of a name that relates two bodies, such as R2_1 or
    Ri_h (with letters for link numbers); () for any other name."""
    own = atom(name)
    parts = (own.letter, *own.index)
    if len(parts) == len(own.letter) == 2:
        parts = (*own.letter, *own.index)
    return parts if len(parts) == 3 and not own.dots and _PLACES.issuperset(parts[1:]) else ()


def numbered(name: str) -> tuple[str, str]:
    """The name without the digits at its end, and those digits."""
    stem = name.rstrip(digits)
    return stem, name[len(stem) :]
