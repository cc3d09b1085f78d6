"""Energies: of the whole robot and of each body."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from freebody.expressions.grammar.atoms import atom, spellings
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.methods.energies import Energies
from freebody_textbook.methods.setting import Setting

_OF_BODIES = (
    (kinds.KINETIC, kinds.BODY_KINETIC, Energies.kinetic),
    (kinds.POTENTIAL, kinds.BODY_POTENTIAL, Energies.potential),
)
"""Energies of the robot, of a body, and the latter's value."""


class EnergyQuantities(QuantityGroup):
    """T, V, L, T_i, V_i, and the power of the drives."""

    def single(self) -> Iterator[NamedTarget]:
        eq = self.setting.equations
        bodies = len(eq.symbols.model.bodies)
        for kind, of_body, energy in _OF_BODIES:
            letters = self.letters[kind.name]
            yield letters, AskedQuantity(kind, (), self.entry(kind.name))
            for i in range(1, bodies + 1):
                names = tuple(f"{x}{i}" for x in (*letters, *of_body.letters))
                yield names, AskedQuantity(of_body, (i,), self._of_body(energy, i - 1))
        sum_of_both = ("L = T − V, not T + V.", lambda: self.setting.element(eq.T + eq.V))
        yield (
            self.letters["L"],
            AskedQuantity(
                kinds.LAGRANGIAN,
                (),
                lambda: self.setting.element(eq.T - eq.V),
                thoughts=(sum_of_both,),
            ),
        )

        yield ("E",), AskedQuantity(kinds.ENERGY, (), lambda: self.setting.element(eq.T + eq.V))
        for kind, value in (
            (kinds.KINETIC, eq.T), (kinds.POTENTIAL, eq.V),
            (kinds.LAGRANGIAN, eq.T - eq.V), (kinds.ENERGY, eq.T + eq.V),
        ):  # fmt: skip
            letters = (x for x in self.letters.get(kind.name, kind.letters) if x[0].isupper())
            names = tuple(name for x in letters for name in spellings(x, "", 1))
            words = f"the rate of {kind.words}"
            yield names, AskedQuantity(kinds.POWER, (), self._rate(value), words=words)
        for i, x in enumerate(self.setting.symbols.coordinates, 1):
            words = f"the momentum that belongs to {sym(x)}"
            yield (
                self._momentum_names(i, x),
                AskedQuantity(kinds.MOMENTUM, (i,), self._momentum(i), words=words, soft=True),
            )
        yield from ((("power" + number,), x) for number, x in self._powers.items())

    def namesakes(self) -> Iterator[NamedTarget]:
        yield from ((("P" + number,), x) for number, x in self._powers.items())

    @cached_property
    def _powers(self) -> dict[str, AskedQuantity]:
        """The power of all drives, and of each by its number."""
        words = "the power of the drives"
        found = {"": AskedQuantity(kinds.POWER, (), self._power(*self.numbers), words=words)}
        for i in self.numbers:
            words = f"the power of the drive of {self.joint(i)}"
            found[str(i)] = AskedQuantity(kinds.POWER, (i,), self._power(i), words=words)
        return found

    def _momentum_names(self, i: int, coordinate: str) -> tuple[str, ...]:
        """p_θ1, p_q1, p_x, p_1; none where p is a parameter."""
        if {"p", "P"} & self.setting.ring.index.keys():
            return ()
        number = atom(coordinate).figures
        own = (coordinate, *[f"q{number}"] * bool(number))
        return (*(f"{p}{x}" for p in "pP" for x in own), f"p{i}")

    def _momentum(self, i: int) -> Callable[[], Trig]:
        """Σ M_ij q̇_j."""
        rates = [self.setting.ring[x + RATE] for x in self.setting.symbols.coordinates]
        row = [self.entry("M", i, j) for j in self.numbers]
        return lambda: sum((m() * v for m, v in zip(row, rates, strict=True)), self.setting.zero)

    def _power(self, *joints: int) -> Callable[[], Trig]:
        """Σ τ_i q̇_i; joints that nothing drives have none."""
        driven = [i for i in joints if i not in self.passive]
        rates = [self.setting.ring[x + RATE] for x in self.setting.symbols.coordinates]
        torques = [self.entry("tau", i) for i in driven]
        return lambda: sum(
            (torque() * rates[i - 1] for i, torque in zip(driven, torques, strict=True)),
            self.setting.zero,
        )

    def _rate(self, energy: Trig) -> Callable[[], Trig]:
        """What an energy grows by."""
        return lambda: self.setting.element(energy.along(self.setting.equations.symbols.rates))

    def _of_body(self, energy: Callable[[Energies, int], Trig], body: int) -> Callable[[], Trig]:
        """An energy of a body with all that is fixed to it."""

        def value() -> Trig:
            s = self._setting
            return self.setting.element(energy(Energies(s, s.motion), s.tree.body_of[body]))

        return value

    @cached_property
    def _setting(self) -> Setting:
        return Setting(self.setting.equations.symbols)
