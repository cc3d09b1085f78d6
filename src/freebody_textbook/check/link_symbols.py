"""The symbols of each link of a planar arm in the lecture notes, one record each: letter, other
spellings in answers, and unit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from freebody.expressions.quantities import units
from freebody.expressions.quantities.units import Unit


@dataclass(frozen=True)
class LinkSymbol:
    """A parameter or coordinate of link k, such as l_k."""

    letter: str
    unit: Unit
    also: tuple[str, ...] = ()
    """Other letters by which answers call it."""
    behind: tuple[str, ...] = ()
    """Spellings with something behind the number, l1c."""
    moves: bool = False
    """Whether it is a coordinate."""

    def spelt(self, k: int | str) -> Iterator[str]:
        """Spellings of the symbol with a link's number."""
        yield from (f"{letter}{k}" for letter in (self.letter, *self.also))
        yield from (form.format(k=k) for form in self.behind if k)


LINK_SYMBOLS = (
    LinkSymbol("l", units.LENGTH),
    LinkSymbol("lc", units.LENGTH, ("lC", "lG", "lg"), ("l{k}c",)),
    LinkSymbol("m", units.MASS),
    LinkSymbol("I", units.INERTIA, ("Ic", "IC", "IG", "Izz")),
    LinkSymbol("theta", units.NONE, ("q", "th"), moves=True),
    LinkSymbol("d", units.LENGTH, ("q",), moves=True),
)
PARAMETERS = tuple(x for x in LINK_SYMBOLS if not x.moves)
COORDINATES = {x.letter: x for x in LINK_SYMBOLS if x.moves}
BY_LETTER = {x.letter: x for x in LINK_SYMBOLS}
