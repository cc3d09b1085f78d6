"""Names as structured values: letter, index, dots. What needs a name's letter or number asks here,
and takes no name apart itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from string import ascii_letters, digits

from freebody.expressions.grammar.tables.characters import DOT, PRIME

_DOTS = {"_dd": 2, "_d": 1}
"""Endings of rates."""


@dataclass(frozen=True)
class Atom:
    """θ̇₁ is the letter theta with the index 1 and a dot; R2_1 has the indices 2 and 1."""

    letter: str
    index: tuple[str, ...] = ()
    dots: int = 0
    primes: int = 0

    @property
    def figures(self) -> str:
        """All figures of the index, "" where there are none."""
        return "".join(c for part in self.index for c in part if c.isdigit())

    @property
    def is_numbered(self) -> bool:
        """Whether the index is one number."""
        return len(self.index) == 1 and self.index[0].isdigit()

    @property
    def is_figures(self) -> bool:
        """Whether the index consists of figures, in one part or several."""
        return bool(self.index) and all(part.isdigit() for part in self.index)

    @property
    def ending(self) -> str:
        """What its rates end with, _d or _dd."""
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


def numbered(name: str) -> tuple[str, str]:
    """A name without the figures that it ends with, and these."""
    stem = name.rstrip(digits)
    return stem, name[len(stem) :]
