"""Kane's equations: partial velocities, generalized active and inertia forces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.words import PRIME
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value, pair
from freebody_textbook.check.asked.bodies import QuantitiesOfBodies
from freebody_textbook.check.asked.group import NamedTarget
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable

_TOLD = LexemePattern(
    "!-%latin F _? {? < %digit | %low_digit >{1,2} }? %prime"
    " | < v | ω > }? _? {? < c | G > < ~%digit | ~%low_digit > _? ,? < %digit | %low_digit >"
    " | < ∂ | \\partial > < %font { >? < v | ω | \\omega >"
)
PartialRate = Callable[[], Trig]
_LETTERS = ("vc", "vG", "omega", "w")


class KaneQuantities(QuantitiesOfBodies):
    """v_c2,1 and ω_2,1, the factors of a rate in velocities, and F_1 and F_1*, of open chains."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer has v_c2,1, ∂v_c2/∂θ̇1 or F_1*. Elsewhere F_1 is a force and ω_21
        perhaps that of body 2 as seen from body 1."""
        return _TOLD.found_in(formulas)

    def single(self) -> Iterator[NamedTarget]:
        yield from self.entries_of(self._partials)
        if self.setting.system is None:
            for i in self.numbers:
                yield (f"F{i}",), self._active(i)
                yield (f"F{i}{PRIME}",), self._inertia(i)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._partials

    @cached_property
    def _partials(self) -> dict[str, QuantityTable]:
        found: dict[str, QuantityTable] = {}
        for letter in _LETTERS:
            for n in range(1, len(self.setting.symbols.model.bodies) + 1):
                whole = self.vectors.get(f"{letter}{n}", [])
                for r in self.numbers if whole else ():
                    found[f"{letter}{n}{r}"] = [[self._partial(x, r)] for (x,) in whole]
        return found

    def _partial(self, entry: AskedQuantity, r: int) -> AskedQuantity:
        """The factor of rate r in a component of a velocity."""

        def by(ending: str, k: int, value: Callable[[], Value] = entry.compute) -> PartialRate:
            name = self.setting.symbols.coordinates[k - 1] + ending
            return lambda: pair(value())[0].derivative(name)

        thoughts: list[Mistaken] = [
            (f"This is the factor of {self.joint(k)}'s rate.", by(RATE, k))
            for k in self.numbers
            if k != r
        ]
        thoughts.append(("A partial velocity is a derivative by the rate.", by("", r)))
        return replace(
            entry,
            index=(*entry.index, r),
            compute=by(RATE, r),
            in_world=entry.in_world and by(RATE, r, entry.in_world),
            words=f"the factor of {self.joint(r)}'s rate in {entry.words}",
            thoughts=tuple(thoughts),
        )

    # ------------------------------------------------------------ generalized forces
    def _active(self, i: int) -> AskedQuantity:
        """F_i: the torque of the drive, friction and springs, weights."""
        tau, applied = self._parts(i)
        plain = self.setting.zero if i in self.passive else None

        def motor() -> Trig:
            return tau() if plain is None else plain

        gravity = self.entry("g", i)
        thoughts: list[Mistaken] = [
            ("The weights have the wrong sign.", lambda: motor() + applied() + gravity() * 2)
        ]
        if plain is None:
            thoughts.append(("The torque or force of the drive is missing.", applied))
        return AskedQuantity(
            kinds.ACTIVE, (i,), lambda: motor() + applied(), joint=self.joint(i),
            thoughts=tuple(thoughts),
        )  # fmt: skip

    def _inertia(self, i: int) -> AskedQuantity:
        """F_i*: the opposite of mass times acceleration."""
        tau, applied = self._parts(i)
        law = "The inertia force is the opposite: F* = −(Σ m a · ∂v/∂q̇ + …)."
        opposite = (law, lambda: tau() + applied())
        return AskedQuantity(
            kinds.INERTIA_FORCE,
            (i,),
            lambda: -tau() - applied(),
            joint=self.joint(i),
            thoughts=(opposite,),
        )

    def _parts(self, i: int) -> tuple[Callable[[], Trig], Callable[[], Trig]]:
        """The torque that the motion needs, and the forces that no drive applies."""
        gravity, resisting = self.entry("g", i), self.entry("drives", i)
        return self.entry("tau", i), lambda: -gravity() - resisting()
