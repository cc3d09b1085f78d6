"""What an answer is compared with: the model's equations in a ring wide enough for what users write
by mistake."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, replace

from freebody.derivations.equations.equations import Equations
from freebody.derivations.polynomials.symbol_order import Order
from freebody.derivations.polynomials.symbols import RATE, SECOND, Symbols
from freebody.derivations.polynomials.textbook_form import Layout
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig, TrigRing

FAMILIES = ("l", "lc", "m", "I")
"""Parameters that every link of a planar arm has in the notes."""


@dataclass(frozen=True)
class RightEquations:
    """The equations, and their symbols over the wider ring."""

    equations: Equations
    symbols: Symbols
    foreign: frozenset[str]
    """Symbols of the notes that this model does not have, such as l2 of a link that slides."""
    zeros: frozenset[str] = frozenset()
    """Parameters of the model whose value is 0: an answer may name them."""

    @cached_property
    def layout(self) -> Layout:
        """How polynomials are printed."""
        return Layout(self.symbols)

    @property
    def order(self) -> Order:
        """What the symbols are."""
        return self.layout.order

    @property
    def ring(self) -> TrigRing:
        """The ring of answers."""
        return self.symbols.ring

    @property
    def is_planar(self) -> bool:
        """Whether the model moves in the plane."""
        return self.symbols.model.dim == 2

    @property
    def joints(self) -> int:
        """The highest number a joint's coordinate carries."""
        return max(
            (int(d) for x in self.symbols.coordinates for d in re.findall(r"\d+", x)), default=0
        )

    @property
    def zero(self) -> Trig:
        """0."""
        return self.symbols.zero()

    def element(self, x: Trig) -> Trig:
        """A polynomial of the equations in the wider ring."""
        return self.ring.polynomial(x.terms())

    def parameter(self, name: str) -> Trig | None:
        """What a parameter's name stands for: its symbol, or 0 where that is its value; None of no
        parameter."""
        if name in self.zeros:
            return self.zero
        return self.ring[name] if name in self.ring.index else None

    def form(self, x: Trig) -> str:
        """A polynomial as one prints it."""
        return str(self.layout.form(x))


def setting(equations: Equations, zeros: Collection[str] = ()) -> RightEquations:
    """The setting of a model's equations; `zeros`: names of parameters that are 0 in them."""
    symbols = equations.symbols
    ring = symbols.ring
    foreign: list[str] = []
    if symbols.model.dim == 2:
        numbers = [re.sub(r"\D", "", x) for x in symbols.coordinates]
        family = [f"{letter}{k}" for k in numbers for letter in FAMILIES]
        moving = [f"{x}{k}" for k in numbers for x in ("theta", "d")]
        still = set(ring.index) - set(symbols.coordinates)  # a length may be called d1
        family += [x + e for x in moving if x not in still for e in ("", RATE, SECOND)]
        foreign = [
            name for name in dict.fromkeys(family) if name not in ring.index and name not in zeros
        ]
    angles = [name for name in foreign if re.fullmatch(r"theta\d+", name)]
    others = [name for name in foreign if name not in angles]
    wide = TrigRing([*ring.angles, *angles], [*ring.names[len(ring.angles) :], *others])
    return RightEquations(
        equations, replace(symbols, ring=wide), frozenset(foreign), frozenset(zeros)
    )
